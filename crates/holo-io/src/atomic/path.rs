//! A temporary file that is not written front to back: by somebody who wants its name, or who goes back in it.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::temporary::Temporary;
use super::{FileDigest, hash_file, target_of};
use crate::Error;

/// What [`AtomicFile`](super::AtomicFile) is, for writers that do not go front to back. The digest costs one more pass.
#[derive(Debug)]
pub(crate) struct AtomicPath {
    path: PathBuf,
    /// Holds the lock that tells other processes of a living writer.
    file: File,
    temporary: Temporary,
}

impl AtomicPath {
    /// Starts a file that will be called `path`.
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

    /// The name that the file will have.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The name that it has until then.
    #[cfg(feature = "hdf5")]
    pub(crate) fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// The file itself, at its beginning; whoever writes must flush before `commit`.
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
