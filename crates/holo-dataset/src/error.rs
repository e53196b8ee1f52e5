//! Everything that can go wrong in this crate, grouped by cause.

/// An error of `holo-dataset`. Every message says what is wrong and where, and what to do where that is not plain.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// What was requested contradicts itself or cannot be made; nothing was written.
    #[error("{0}")]
    BadRequest(String),
    /// The work failed.
    #[error("{0}")]
    Failed(String),
    /// The renderer refused, or was cancelled.
    #[error(transparent)]
    Render(#[from] holo_render::Error),
    /// A scene is broken.
    #[error(transparent)]
    Scene(#[from] holo_scene::Error),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] holo_io::Error),
    /// The light field or the rig is impossible.
    #[error(transparent)]
    Core(#[from] holo_core::Error),
}

impl Error {
    /// Whether the caller asked for something that cannot be, as opposed to work that failed.
    #[must_use]
    pub fn is_bad_request(&self) -> bool {
        match self {
            Self::BadRequest(_) | Self::Render(holo_render::Error::BadSetting(_)) | Self::Core(_) => true,
            // The only impossible rig that no scene file can cause.
            Self::Render(holo_render::Error::Core(why)) => {
                matches!(why, holo_core::Error::OrthographicFocus { .. })
            }
            Self::Failed(_) | Self::Render(_) | Self::Scene(_) | Self::Io(_) => false,
        }
    }
}
