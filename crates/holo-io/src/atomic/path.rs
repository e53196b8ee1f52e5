//! An atomic file that is not written front to back: a library opens it by name, or a writer seeks in it.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::temporary::Temporary;
use super::{FileDigest, hash_file, target_of};
use crate::Error;

/// An atomic file like [`AtomicFile`](super::AtomicFile), for writers that seek or open it by name. `commit` reads it
/// once for its digest.
#[derive(Debug)]
pub(crate) struct AtomicPath {
    path: PathBuf,
    /// Holds the lock by which other processes see that the writer runs.
    file: File,
    temporary: Temporary,
}

impl AtomicPath {
    /// Creates the temporary file of a file that `commit` will name `path`.
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        let Some(target) = target_of(path)? else {
            return Err(Error::bad_input(
                path,
                "a device or pipe cannot take a file that is not written front to back; name a file",
            ));
        };
        let (file, temporary) = Temporary::create(&target).map_err(|source| Error::io("write", path, source))?;
        Ok(Self { path: path.to_owned(), file, temporary })
    }

    /// The path that the file will have.
    #[cfg(any(feature = "mat", feature = "hdf5"))]
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The path that it has until `commit`.
    pub(crate) fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// The open file, at its beginning. Buffers on top of it must be flushed before `commit`.
    #[cfg(feature = "mat")]
    pub(crate) fn file(&self) -> &File {
        &self.file
    }

    /// Completes the file: syncs, hashes, renames.
    pub(crate) fn commit(self) -> Result<FileDigest, Error> {
        let failed = |source| Error::io("write", &self.path, source);
        self.file.sync_all().map_err(failed)?;
        let written = hash_file(self.temporary.path())?;
        self.temporary.rename().map_err(failed)?;
        Ok(written)
    }
}
