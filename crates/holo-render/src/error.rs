//! The error type of this crate, grouped by cause.

/// An error of `holo-render`. The message says what is wrong, where, and what to do about it if that is not obvious.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene is inconsistent.
    #[error(transparent)]
    Scene(#[from] holo_scene::Error),
    /// A setting does not fit the scene or the other settings.
    #[error("{0}")]
    BadSetting(String),
    /// The requested ray tracing backend is not available.
    #[error("Embree: {0}")]
    Embree(String),
    /// The ray tracing backend has no memory left for the scene.
    #[error("out of memory: {0}")]
    OutOfMemory(String),
    /// The caller canceled the render.
    #[error("stopped")]
    Cancelled,
    /// The light field or the rig is impossible.
    #[error(transparent)]
    Core(#[from] holo_core::Error),
}
