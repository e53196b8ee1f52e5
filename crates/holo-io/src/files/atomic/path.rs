//! An atomic file that is not written front to back: a library opens it by name, or a writer seeks in it.

use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::temporary::Temporary;
use crate::Error;
use crate::files::digest::{FileDigest, hash};
use crate::files::folder::{Destination, path_of_open_file};

/// An atomic file like [`AtomicFile`](super::AtomicFile), for writers that seek or open it by name. `commit` reads it
/// once for its digest.
#[derive(Debug)]
pub(crate) struct AtomicPath {
    path: PathBuf,
    /// Holds the lock by which other processes see that the writer runs.
    file: File,
    temporary: Temporary,
    temporary_path: PathBuf,
}

impl AtomicPath {
    /// Creates the temporary file of a file that `commit` will give its name.
    pub(crate) fn create(destination: impl Destination) -> Result<Self, Error> {
        let path = destination.path();
        let Some((file, temporary)) = Temporary::of(&destination)? else {
            return Err(Error::bad_input(
                path,
                "a device or pipe cannot take a file that is not written front to back; name a file",
            ));
        };
        // A library looks the path up again. In an open folder it gets one that leads to this file alone, where the system
        // has such paths.
        let own = destination.place().and_then(|_| path_of_open_file(&file));
        let temporary_path = own.unwrap_or_else(|| temporary.path());
        Ok(Self { path: path.to_owned(), file, temporary, temporary_path })
    }

    /// The path that the file will have.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The path that it has until `commit`.
    pub(crate) fn temporary_path(&self) -> &Path {
        &self.temporary_path
    }

    /// The open file, at its beginning. Buffers on top of it must be flushed before `commit`.
    pub(crate) fn file(&self) -> &File {
        &self.file
    }

    /// Completes the file: syncs, hashes, renames.
    pub(crate) fn commit(self) -> Result<FileDigest, Error> {
        let Self { path, mut file, temporary, .. } = self;
        let failed = |source| Error::io("write", &path, source);
        file.sync_all().map_err(failed)?;
        file.seek(SeekFrom::Start(0)).map_err(failed)?;
        let written = hash(&mut file).map_err(failed)?;
        temporary.rename().map_err(failed)?;
        Ok(written)
    }
}
