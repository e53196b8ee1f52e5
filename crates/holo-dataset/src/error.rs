//! The error type, grouped by cause.

/// An error of `holo-dataset`. Every message states what is wrong and where, and what to do where that is not obvious.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The request contradicts itself or is impossible; nothing was written.
    #[error("{0}")]
    BadRequest(String),
    /// The work failed, for example because files are damaged or missing.
    #[error("{0}")]
    Failed(String),
    /// The request needs more memory than there is; nothing was written.
    #[error("{0}")]
    OutOfMemory(String),
    /// An error of the renderer, or cancellation.
    #[error(transparent)]
    Render(#[from] holo_render::Error),
    /// A scene is invalid or its file cannot be read.
    #[error(transparent)]
    Scene(#[from] holo_scene::Error),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] holo_io::Error),
    /// The light field or the rig is invalid.
    #[error(transparent)]
    Core(#[from] holo_core::Error),
}

impl Error {
    /// Whether the request itself is invalid, in contrast to work that failed.
    #[must_use]
    pub fn is_bad_request(&self) -> bool {
        match self {
            // The only invalid rig that options alone cause.
            Self::Render(holo_render::Error::Core(why)) => {
                matches!(why, holo_core::Error::OrthographicFocus { .. })
            }
            Self::BadRequest(_)
            | Self::OutOfMemory(_)
            | Self::Render(holo_render::Error::BadSetting(_))
            | Self::Core(_) => true,
            Self::Failed(_) | Self::Render(_) | Self::Scene(_) | Self::Io(_) => false,
        }
    }

    /// Whether memory was missing.
    #[must_use]
    pub fn is_out_of_memory(&self) -> bool {
        match self {
            Self::Core(why) | Self::Render(holo_render::Error::Core(why)) => {
                matches!(why, holo_core::Error::OutOfMemory { .. })
            }
            Self::OutOfMemory(_)
            | Self::Render(holo_render::Error::OutOfMemory(_))
            | Self::Io(holo_io::Error::OutOfMemory { .. }) => true,
            Self::BadRequest(_) | Self::Failed(_) | Self::Render(_) | Self::Scene(_) | Self::Io(_) => false,
        }
    }
}
