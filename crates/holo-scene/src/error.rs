//! The error type of this crate, grouped by cause.

/// An error of `holo-scene`. The message says what is wrong, where, and what to do about it if that is not obvious.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {path}: {error}")]
    Read {
        /// The path of the file.
        path: String,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// A scene file violates the rules of its format.
    #[error("{at}: {what}")]
    BadFile {
        /// The JSON path in the file, such as `accessors[3].count`.
        at: String,
        /// What is wrong there.
        what: String,
    },
    /// A scene file uses a feature that this version does not support.
    #[error("{at}: {what} is not supported")]
    Unsupported {
        /// The JSON path in the file.
        at: String,
        /// The unsupported feature.
        what: String,
    },
    /// A scene is inconsistent, such as an index out of range or a NaN.
    #[error("scene: {at}: {what}")]
    BadScene {
        /// The path in the scene, such as `meshes[2].triangles[7]`.
        at: String,
        /// What is wrong there.
        what: String,
    },
}
