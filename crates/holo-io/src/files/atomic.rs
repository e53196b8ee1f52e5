//! Atomic files: they appear whole or not at all.

mod path;
mod temporary;

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256 as Hasher};

use crate::Error;
use crate::files::digest::{FileDigest, Sha256, hash};
use crate::files::folder::Destination;
pub(crate) use path::AtomicPath;
use temporary::Temporary;
pub use temporary::{TemporaryFilesRemoved, remove_stale_temporary_files, remove_temporary_files};

/// Bytes that are collected before they are hashed and written.
const BUFFER_BYTES: usize = 256 * 1024;

/// A file that is written under a temporary name and renamed when it is complete.
///
/// The temporary name is in the same folder: `.NAME.<process>-<number>.part`. [`commit`](Self::commit) syncs the file,
/// renames it and syncs the folder, so a reader sees the old file, the new file or no file, but never a partial file,
/// even after a power failure. A file that is dropped without `commit` is removed. A killed process leaves at most the
/// `.part`, which [`remove_stale_temporary_files`] removes.
///
/// Where a path is a symbolic link to a file, that file is replaced and the link stays. Where it is a device or a
/// pipe (`/dev/null`, `/dev/stdout`), the bytes are written into it directly. Neither is so for a name in a
/// [`Folder`](crate::Folder): there only a regular file is replaced, and everything else is an error.
///
/// The size and the SHA-256 of the contents are computed during writing, so the file need not be read again for its
/// manifest.
///
/// # Examples
///
/// ```
/// use std::io::Write;
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("note.txt");
/// let mut file = holo_io::AtomicFile::create(&path)?;
/// file.write_all(b"holo")?;
/// assert!(!path.exists());
/// let written = file.commit()?;
/// assert_eq!((written.bytes, std::fs::read(&path)?), (4, b"holo".to_vec()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct AtomicFile {
    /// The name as the caller gave it, for messages.
    path: PathBuf,
    file: File,
    /// `None` where the bytes are written directly into a device or pipe.
    temporary: Option<Temporary>,
    buffer: Vec<u8>,
    hasher: Hasher,
    bytes: u64,
    /// Whether bytes may change after they are written, so that the digest is computed at `commit`.
    hash_at_commit: bool,
    /// The first error of a write. Encoders ignore errors in their destructors; `commit` returns this one.
    failure: Option<io::Error>,
}

impl AtomicFile {
    /// Creates the temporary file of a file that `commit` will give its name.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the folder does not exist or cannot be written, or if the destination is a folder, or in a
    /// [`Folder`](crate::Folder) anything but a regular file; [`Error::BadInput`] if it has no file name.
    pub fn create(destination: impl Destination) -> Result<Self, Error> {
        let path = destination.path();
        let (file, temporary) = match Temporary::of(&destination)? {
            Some((file, temporary)) => (file, Some(temporary)),
            None => {
                let failed = |source| Error::io("write", path, source);
                (OpenOptions::new().write(true).open(path).map_err(failed)?, None)
            }
        };
        Ok(Self {
            path: path.to_owned(),
            file,
            temporary,
            buffer: Vec::with_capacity(BUFFER_BYTES),
            hasher: Hasher::new(),
            bytes: 0,
            hash_at_commit: false,
            failure: None,
        })
    }

    /// Returns the path that the file will have.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Completes the file: writes the buffer, syncs, renames, and returns the size and the digest.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if any write since `create` failed, even where an encoder ignored its error, or if the file cannot
    /// be synced or renamed. The temporary file is removed then, and an older file of that name stays as it was.
    pub fn commit(mut self) -> Result<FileDigest, Error> {
        let finished = self.finish();
        finished.map_err(|source| Error::io("write", &self.path, source))
    }

    fn finish(&mut self) -> io::Result<FileDigest> {
        self.write_buffer()?;
        let mut written = FileDigest { bytes: self.bytes, sha256: Sha256(self.hasher.finalize_reset().into()) };
        if self.hash_at_commit {
            self.file.seek(SeekFrom::Start(0))?;
            written = hash(&mut self.file)?;
            if written.bytes != self.bytes {
                return Err(io::Error::other("the file changed its length while it was written"));
            }
        }
        if let Some(temporary) = self.temporary.take() {
            self.file.sync_all()?;
            temporary.rename()?;
        }
        Ok(written)
    }

    /// Whether there is a temporary file, in which bytes can be overwritten until `commit`; false for a device or a
    /// pipe.
    pub(crate) fn is_temporary(&self) -> bool {
        self.temporary.is_some()
    }

    /// Allows [`overwrite`](Self::overwrite): `commit` reads the file once more for its digest.
    pub(crate) fn hash_at_commit(&mut self) {
        self.hash_at_commit = true;
    }

    /// Overwrites bytes that were written before. Requires [`hash_at_commit`](Self::hash_at_commit).
    pub(crate) fn overwrite(&mut self, position: u64, data: &[u8]) -> io::Result<()> {
        self.write_buffer()?;
        if !self.hash_at_commit || !self.is_temporary() || position + data.len() as u64 > self.bytes {
            return Err(io::ErrorKind::Unsupported.into());
        }
        let outcome = self.file.seek(SeekFrom::Start(position)).and_then(|_| self.file.write_all(data));
        let outcome = outcome.and_then(|()| self.file.seek(SeekFrom::End(0)).map(drop));
        outcome.inspect_err(|failure| self.failure = Some(copy_of(failure)))
    }

    /// Converts an error of an encoder. If a write failed before, the result is the error of that write.
    pub(crate) fn error(&mut self, other: impl fmt::Display) -> Error {
        let source = self.failure.take().unwrap_or_else(|| io::Error::other(other.to_string()));
        Error::io("write", &self.path, source)
    }

    fn write_buffer(&mut self) -> io::Result<()> {
        let buffer = std::mem::take(&mut self.buffer);
        let outcome = self.write_through(&buffer);
        self.buffer = buffer;
        self.buffer.clear();
        outcome
    }

    /// Hashes and writes. After one failure nothing more is written.
    fn write_through(&mut self, data: &[u8]) -> io::Result<()> {
        if let Some(failure) = &self.failure {
            return Err(copy_of(failure));
        }
        if let Err(failure) = self.file.write_all(data) {
            let copy = copy_of(&failure);
            self.failure = Some(failure);
            return Err(copy);
        }
        if !self.hash_at_commit {
            self.hasher.update(data);
        }
        self.bytes += data.len() as u64;
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        if self.buffer.len() + data.len() > BUFFER_BYTES {
            self.write_buffer()?;
        }
        if data.len() >= BUFFER_BYTES {
            self.write_through(data)?;
        } else {
            self.buffer.extend_from_slice(data);
        }
        Ok(data.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.write_buffer()
    }
}

/// Returns the absolute path of the file that `path` refers to, or `None` where it is a device or a pipe.
fn target_of(path: &Path) -> Result<Option<PathBuf>, Error> {
    let failed = |source| Error::io("write", path, source);
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(failed(io::ErrorKind::IsADirectory.into())),
        // Renaming over a device would replace the device by a file.
        Ok(found) if !found.is_file() => Ok(None),
        Ok(_) => fs::canonicalize(path).map(Some).map_err(failed),
        Err(_) if path.file_name().is_none() => Err(Error::bad_input(path, "the path has no file name")),
        // The working folder may change before `commit`.
        Err(_) => std::path::absolute(path).map(Some).map_err(failed),
    }
}

/// Copies an error: `io::Error` is not `Clone`.
fn copy_of(error: &io::Error) -> io::Error {
    match error.raw_os_error() {
        Some(code) => io::Error::from_raw_os_error(code),
        None => io::Error::new(error.kind(), error.to_string()),
    }
}

/// Writes a file from bytes in memory as an [`AtomicFile`].
///
/// # Errors
///
/// Those of [`AtomicFile::create`] and [`AtomicFile::commit`].
pub fn write_file(destination: impl Destination, contents: &[u8]) -> Result<FileDigest, Error> {
    let mut file = AtomicFile::create(destination)?;
    match file.write_all(contents) {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}
