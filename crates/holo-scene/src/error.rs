//! Everything that can go wrong in this crate, grouped by cause.

/// An error of `holo-scene`. Every message says what is wrong and where, and what to do where that is not plain.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// The operating system's word.
        source: std::io::Error,
    },
    /// A scene file breaks its format's rules.
    #[error("{at}: {what}")]
    BadFile {
        /// Where in the file, such as `accessors[3].count`.
        at: String,
        /// What is wrong there.
        what: String,
    },
    /// A scene file asks for something that this version does not model.
    #[error("{at}: {what} is not supported")]
    Unsupported {
        /// Where in the file.
        at: String,
        /// What it asks for.
        what: String,
    },
    /// A scene is inconsistent: an index out of range, a NaN.
    #[error("scene: {at}: {what}")]
    BadScene {
        /// Which part, such as `meshes[2].triangles[7]`.
        at: String,
        /// What is wrong with it.
        what: String,
    },
}
