//! The error type, grouped by cause.

use std::io;
use std::path::{Path, PathBuf};

use holo_core::GridSize;

/// An error of `holo-io`. Every message states what went wrong and where, and what to do where that is not obvious.
///
/// The variants are grouped by cause: the file, the operating system, the memory limits, the caller.
///
/// The message is complete: it contains that of the operating system or of `holo-core`, so there is no
/// [`source`](std::error::Error::source), and a program that prints the chain of causes prints nothing twice.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file violates its format: it is truncated, damaged, or made by a faulty program.
    #[error("{}: broken {format}{}: {what}", .path.display(), if format.ends_with("folder") { "" } else { " file" })]
    Broken {
        /// The file, or `(stream)`.
        path: PathBuf,
        /// The format as which it was read, such as `"PFM"` or `"HCI folder"`.
        format: &'static str,
        /// What is wrong, and where in the file.
        what: String,
    },
    /// The file may be valid, but it contains something that this version cannot read.
    #[error("{}: {what}", .path.display())]
    Unsupported {
        /// The file, or `(stream)`.
        path: PathBuf,
        /// What it contains, and what can be read instead.
        what: String,
    },
    /// The operating system reported an error of reading or writing.
    #[error("cannot {action} {}: {error}{}", .path.display(), advice(.error, .action))]
    Io {
        /// The operation, such as `"write"`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        error: io::Error,
    },
    /// Reading would take more memory than the caller's [`Limits`](crate::Limits) allow.
    #[error(
        "{}: the {what} needs {needed} bytes, but only {allowed} are allowed; raise the limit if the file can be \
         trusted",
        .path.display()
    )]
    TooLarge {
        /// The file, or `(stream)`.
        path: PathBuf,
        /// What needs the memory, such as `"image"`.
        what: &'static str,
        /// Number of bytes that it needs; `u64::MAX` if the number overflows.
        needed: u64,
        /// Number of bytes that are allowed.
        allowed: u64,
    },
    /// The operating system has not enough memory, although the [`Limits`](crate::Limits) would allow it.
    #[error("{}: out of memory: allocating {bytes} bytes for the {what} failed", .path.display())]
    OutOfMemory {
        /// The file, or `(stream)`.
        path: PathBuf,
        /// What needs the memory, such as `"image"`.
        what: &'static str,
        /// Number of bytes of the allocation that failed.
        bytes: u64,
    },
    /// The arguments contradict each other or describe something that cannot be read or written.
    #[error("{}: {what}", .path.display())]
    BadInput {
        /// The file that was to be written or read.
        path: PathBuf,
        /// What is wrong with the arguments.
        what: String,
    },
    /// The files do not specify the arrangement of the samples of a light field, or they contradict the options.
    #[error("{}: {what}; set `{option}`", .path.display())]
    MissingOption {
        /// The file or folder.
        path: PathBuf,
        /// The field of [`ReadOptions`](crate::ReadOptions) that specifies it.
        option: &'static str,
        /// What is unknown or contradicts the files.
        what: String,
    },
    /// The file or folder contains no light field that can be read.
    #[error("{}: no light field: {what}", .path.display())]
    NoLightField {
        /// The file or folder.
        path: PathBuf,
        /// What it is instead.
        what: String,
    },
    /// Numbers in a file describe an impossible light field or rig.
    #[error("{}: {error}", .path.display())]
    Core {
        /// The file, or `(stream)`.
        path: PathBuf,
        /// The error of `holo-core` about the numbers.
        error: holo_core::Error,
    },
    /// A plenoptic camera is impossible, or another program has no file for one like it. The message names the key of the
    /// camera file.
    #[error("{0}")]
    Camera(String),
}

/// Stands for the path of data that did not come from a file.
pub(crate) const STREAM: &str = "(stream)";

impl Error {
    /// Returns the file or folder that the error is about; `(stream)` for data that are not of a file.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Broken { path, .. }
            | Self::Unsupported { path, .. }
            | Self::Io { path, .. }
            | Self::TooLarge { path, .. }
            | Self::OutOfMemory { path, .. }
            | Self::BadInput { path, .. }
            | Self::MissingOption { path, .. }
            | Self::NoLightField { path, .. }
            | Self::Core { path, .. } => path,
            Self::Camera(_) => Path::new(STREAM),
        }
    }

    pub(crate) fn broken(path: &Path, format: &'static str, what: impl Into<String>) -> Self {
        Self::Broken { path: path.to_owned(), format, what: what.into() }
    }

    pub(crate) fn unsupported(path: &Path, what: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), what: what.into() }
    }

    pub(crate) fn bad_input(path: &Path, what: impl Into<String>) -> Self {
        Self::BadInput { path: path.to_owned(), what: what.into() }
    }

    pub(crate) fn io(action: &'static str, path: &Path, error: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), error }
    }

    /// The same error with another path, if it is one of `holo-core`.
    pub(crate) fn about(self, path: &Path) -> Self {
        match self {
            Self::Core { error, .. } => Self::core(path, error),
            other => other,
        }
    }

    pub(crate) fn core(path: &Path, error: holo_core::Error) -> Self {
        Self::Core { path: path.to_owned(), error }
    }
}

/// Numbers of views and of the pixels of each, as messages name them.
pub(crate) fn in_words((views, pixels): (GridSize, GridSize)) -> String {
    format!("{} x {} views of {} x {} pixels", views.columns, views.rows, pixels.columns, pixels.rows)
}

/// What to do about an error of the operating system, where its own message does not state it.
fn advice(error: &io::Error, action: &str) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound if action == "write" => "; create the folder first",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "; free some space or choose another folder",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem if action == "write" => {
            "; choose another folder or change its permissions"
        }
        io::ErrorKind::IsADirectory if action == "write" => "; name a file inside it",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_state_what_where_and_what_to_do() {
        let path = Path::new("out/scene_el.png");
        let full = Error::io("write", path, io::ErrorKind::StorageFull.into());
        assert_eq!(
            full.to_string(),
            "cannot write out/scene_el.png: no storage space; free some space or choose another folder"
        );
        assert_eq!(full.path(), path);
        let missing = Error::io("read", path, io::ErrorKind::NotFound.into());
        assert_eq!(missing.to_string(), "cannot read out/scene_el.png: entity not found");
        let broken = Error::broken(Path::new(STREAM), "PFM", "the header ends early");
        assert_eq!(broken.to_string(), "(stream): broken PFM file: the header ends early");
    }
}
