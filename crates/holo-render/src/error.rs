//! Everything that can go wrong in this crate, grouped by cause.

/// An error of `holo-render`. Every message says what is wrong and where, and what to do where that is not plain.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene is inconsistent.
    #[error(transparent)]
    Scene(#[from] holo_scene::Error),
    /// A setting does not fit the scene or the other settings.
    #[error("{0}")]
    BadSetting(String),
    /// The engine that was asked for cannot be had.
    #[error("Embree: {0}")]
    Embree(String),
    /// The caller asked the renderer to stop.
    #[error("stopped")]
    Cancelled,
    /// The light field or the rig is impossible.
    #[error(transparent)]
    Core(#[from] holo_core::Error),
}
