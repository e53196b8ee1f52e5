//! Everything that can go wrong in this crate, sorted by who can mend it.

use std::io;
use std::path::{Path, PathBuf};

/// An error of `holo-io`. Every message says what went wrong and where, and what to do where that is not plain.
///
/// The variants are sorted by who can mend them: the file, the machine, the limits, the caller.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file breaks its format's rules: truncated, damaged, or made by a faulty program.
    #[error("{}: broken {format}{}: {what}", .path.display(), if format.ends_with("folder") { "" } else { " file" })]
    Broken {
        /// The file, or `(memory)`.
        path: PathBuf,
        /// The format that it was read as, such as `"PFM"` or `"HCI folder"`.
        format: &'static str,
        /// What is wrong, and where in the file.
        what: String,
    },
    /// The file may be sound, but it holds something that this version cannot read.
    #[error("{}: {what}", .path.display())]
    Unsupported {
        /// The file, or `(memory)`.
        path: PathBuf,
        /// What it holds, and what can be read instead.
        what: String,
    },
    /// The operating system refused to read or write.
    #[error("cannot {action} {}: {source}{}", .path.display(), advice(.source, .action))]
    Io {
        /// What was being done, such as `"write"`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The operating system's word.
        source: io::Error,
    },
    /// Reading would take more memory than the caller's [`Limits`](crate::Limits) or the machine allow.
    #[error(
        "{}: the {what} needs {needed} bytes, but only {allowed} are allowed; raise the limit if the file can be trusted",
        .path.display()
    )]
    TooLarge {
        /// The file, or `(memory)`.
        path: PathBuf,
        /// What needs the memory, such as `"image"`.
        what: &'static str,
        /// How many bytes it needs; `u64::MAX` stands for a number too large to count.
        needed: u64,
        /// How many bytes are allowed.
        allowed: u64,
    },
    /// The caller asked for something that cannot be written.
    #[error("{}: {what}", .path.display())]
    BadInput {
        /// The file that was to be written or made use of.
        path: PathBuf,
        /// What is wrong with the arguments.
        what: String,
    },
    /// The files do not tell how the samples of a light field are arranged, or they contradict what the caller said.
    #[error("{}: {what}; set `{option}`", .path.display())]
    MissingOption {
        /// The file or folder.
        path: PathBuf,
        /// The field of [`ReadOptions`](crate::ReadOptions) that decides.
        option: &'static str,
        /// What is not known or does not fit.
        what: String,
    },
    /// The file or folder is not one that a light field can be read from.
    #[error("{}: no light field: {what}", .path.display())]
    NoLightField {
        /// The file or folder.
        path: PathBuf,
        /// What it is instead.
        what: String,
    },
    /// Numbers read from a file describe an impossible light field or rig.
    #[error("{}: {source}", .path.display())]
    Core {
        /// The file, or `(memory)`.
        path: PathBuf,
        /// What `holo-core` says about the numbers.
        source: holo_core::Error,
    },
}

/// What stands for the path of data that did not come from a file.
pub(crate) const MEMORY: &str = "(memory)";

impl Error {
    /// Returns the file that the error is about; `(memory)` stands for data that did not come from a file.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Broken { path, .. }
            | Self::Unsupported { path, .. }
            | Self::Io { path, .. }
            | Self::TooLarge { path, .. }
            | Self::BadInput { path, .. }
            | Self::MissingOption { path, .. }
            | Self::NoLightField { path, .. }
            | Self::Core { path, .. } => path,
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

    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }

    /// The same error of the library `holo-core`, about another file.
    #[cfg(any(feature = "png", feature = "mat", feature = "hdf5"))]
    pub(crate) fn about(self, path: &Path) -> Self {
        match self {
            Self::Core { source, .. } => Self::core(path, source),
            other => other,
        }
    }

    pub(crate) fn core(path: &Path, source: holo_core::Error) -> Self {
        Self::Core { path: path.to_owned(), source }
    }
}

/// What to do about an error of the operating system, where that is not plain from its own words.
fn advice(source: &io::Error, action: &str) -> &'static str {
    match source.kind() {
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
    fn messages_say_what_where_and_what_to_do() {
        let path = Path::new("out/scene_el.png");
        let full = Error::io("write", path, io::ErrorKind::StorageFull.into());
        assert_eq!(
            full.to_string(),
            "cannot write out/scene_el.png: no storage space; free some space or choose another folder"
        );
        assert_eq!(full.path(), path);
        let missing = Error::io("read", path, io::ErrorKind::NotFound.into());
        assert_eq!(missing.to_string(), "cannot read out/scene_el.png: entity not found");
        let broken = Error::broken(Path::new(MEMORY), "PFM", "the header ends early");
        assert_eq!(broken.to_string(), "(memory): broken PFM file: the header ends early");
    }
}
