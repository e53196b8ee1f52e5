//! Folders that are opened once and used through their handle: everything in them is found from there, and stays there.
//!
//! A folder from somebody else may contain anything: links that lead out of it, pipes that block who opens them, devices
//! that never end. A check of the text of a name sees none of that, and a path that is looked up again may lead elsewhere
//! the second time. So:
//!
//! - a name is relative, with `/` between folders, and has neither `..` nor control characters;
//! - every part of it is looked up from the open folder before it, and a symbolic link is an error wherever it is;
//! - the type is known before a file is opened, so that nothing blocks, and is compared again afterwards;
//! - reading has a limit of bytes.
//!
//! On Unix (Linux, macOS, BSD) the calls are those that take an open folder (`openat` and its kin), and nobody can exchange
//! a part of the path between a check and its use. On other systems every part is checked by its path first: that finds
//! links and other types too, but a process that exchanges a folder at the same moment is not noticed.

mod lock;
#[cfg(not(unix))]
#[path = "folder/by_path.rs"]
mod system;
#[cfg(unix)]
#[path = "folder/by_handle.rs"]
mod system;

use std::fmt;
use std::fs::{File, FileType};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::files::digest::hash;
use crate::files::limits::read_small_file;
use crate::files::names::stays_inside;
use crate::{Error, FileDigest, Limits};

pub use lock::FolderLock;
pub(crate) use system::path_of_open_file;

/// An open folder. Clones share the handle.
///
/// The path by which it was opened is the user's own and may contain links. Below it none is followed.
///
/// # Examples
///
/// ```
/// use holo_io::{Folder, write_file};
///
/// # let place = tempfile::tempdir()?;
/// let folder = Folder::open(place.path())?;
/// folder.create_folder("inner")?;
/// write_file(folder.file("inner/note.txt"), b"holo")?;
/// assert_eq!(folder.read("inner/note.txt", 100)?, b"holo");
/// assert!(folder.read("../note.txt", 100).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Folder(Arc<Opened>);

struct Opened {
    handle: system::Handle,
    /// For messages, and for libraries that open files by name.
    path: PathBuf,
}

/// What a name in a folder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EntryKind {
    /// A regular file.
    File,
    /// A folder.
    Folder,
    /// A symbolic link, wherever it leads.
    Link,
    /// A pipe, a socket or a device.
    Other,
}

/// A file that was opened, or what is there instead.
enum Found {
    File(File),
    Other(EntryKind),
}

/// A name in an open folder, for a file that is about to be written.
#[derive(Clone, Debug)]
pub struct FolderFile {
    folder: Folder,
    name: String,
    path: PathBuf,
}

/// Where a file is written: a path, or a [name in an open folder](FolderFile).
///
/// Where a path is a symbolic link, its target is written. In a folder no link is followed.
pub trait Destination {
    /// The path, for messages.
    fn path(&self) -> &Path;

    /// The folder and the name in it; `None` for a path.
    fn place(&self) -> Option<(&Folder, &str)> {
        None
    }
}

impl<P: AsRef<Path>> Destination for P {
    fn path(&self) -> &Path {
        self.as_ref()
    }
}

impl Destination for FolderFile {
    fn path(&self) -> &Path {
        &self.path
    }

    fn place(&self) -> Option<(&Folder, &str)> {
        Some((&self.folder, &self.name))
    }
}

impl Destination for &FolderFile {
    fn path(&self) -> &Path {
        &self.path
    }

    fn place(&self) -> Option<(&Folder, &str)> {
        Some((&self.folder, &self.name))
    }
}

impl Destination for &dyn Destination {
    fn path(&self) -> &Path {
        (**self).path()
    }

    fn place(&self) -> Option<(&Folder, &str)> {
        (**self).place()
    }
}

impl fmt::Debug for Folder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Folder({:?})", self.0.path)
    }
}

impl Folder {
    /// Opens a folder by its path, in which links are followed.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it does not exist, is no folder, or cannot be opened.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let handle = system::Handle::open(path).map_err(|error| Error::io("open", path, error))?;
        Ok(Self::new(handle, path.to_owned()))
    }

    /// Opens the folder of a file, for what lies beside it.
    ///
    /// # Errors
    ///
    /// Those of [`Folder::open`].
    pub fn beside(file: impl AsRef<Path>) -> Result<Self, Error> {
        let path = file.as_ref().parent().unwrap_or(Path::new(""));
        let place = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        let handle = system::Handle::open(place).map_err(|error| Error::io("open", place, error))?;
        Ok(Self::new(handle, path.to_owned()))
    }

    /// Opens the folder of a file, and the one above it: those of them that can be opened.
    #[must_use]
    pub fn around(file: impl AsRef<Path>) -> Vec<Self> {
        let beside = Self::beside(file).ok();
        let above = beside.as_ref().and_then(|folder| Self::open(folder.path().join("..")).ok());
        beside.into_iter().chain(above).collect()
    }

    /// Opens a folder in this one; `name` may have several parts.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it does not exist, or a part of its name is a link or no folder; [`Error::BadInput`] if the name
    /// leads out of the folder.
    pub fn sub(&self, name: &str) -> Result<Self, Error> {
        self.check("open", name)?;
        let handle = self.0.handle.sub(name).map_err(|error| self.failed("open", name, error))?;
        Ok(Self::new(handle, self.path_of(name)))
    }

    fn new(handle: system::Handle, path: PathBuf) -> Self {
        Self(Arc::new(Opened { handle, path }))
    }

    /// Returns the path by which it was opened: for messages, not for opening files.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// Returns the path of a name: for messages, not for opening files.
    #[must_use]
    pub fn path_of(&self, name: &str) -> PathBuf {
        self.0.path.join(name)
    }

    /// Returns the place of a file that is about to be written.
    #[must_use]
    pub fn file(&self, name: impl Into<String>) -> FolderFile {
        let name = name.into();
        FolderFile { path: self.path_of(&name), folder: self.clone(), name }
    }

    /// Creates one folder, unless it exists; returns whether it did not. All parts but the last must exist.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be created, or a part of its name is a link or no folder; [`Error::BadInput`] if the
    /// name leads out of the folder.
    pub fn create_folder(&self, name: &str) -> Result<bool, Error> {
        self.check("create", name)?;
        match self.0.handle.create_folder(name) {
            Ok(()) => Ok(true),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => match self.kind(name)? {
                Some(EntryKind::Folder) => Ok(false),
                Some(kind) => Err(self.refused("create", name, kind)),
                None => Err(self.failed("create", name, error)),
            },
            Err(error) => Err(self.failed("create", name, error)),
        }
    }

    /// Returns what a name is; `None` if there is nothing.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if that cannot be found out, or a part of its path is a link; [`Error::BadInput`] if the name leads out
    /// of the folder.
    pub fn kind(&self, name: &str) -> Result<Option<EntryKind>, Error> {
        self.check("read", name)?;
        self.0.handle.kind(name).map_err(|error| self.failed("read", name, error))
    }

    /// Returns whether a name is a regular file; errors mean that it is none that could be read.
    #[must_use]
    pub fn has_file(&self, name: &str) -> bool {
        matches!(self.kind(name), Ok(Some(EntryKind::File)))
    }

    /// Checks that a name is a regular file and returns its path, for readers and libraries that open files by path. The
    /// path is looked up again when it is opened: this finds what lies in a folder, and not what another process does in it
    /// at the same moment.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if there is none, or the name or a part of it is something else; [`Error::BadInput`] if the name leads
    /// out of the folder.
    pub fn regular_path(&self, name: &str) -> Result<PathBuf, Error> {
        match self.kind(name)? {
            Some(EntryKind::File) => Ok(self.path_of(name)),
            Some(kind) => Err(self.refused("read", name, kind)),
            None => Err(Error::io("read", &self.path_of(name), io::ErrorKind::NotFound.into())),
        }
    }

    /// Opens a regular file of at most `max_bytes` for reading.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if there is none, it cannot be read, or the name is a link, a folder, a pipe or a device;
    /// [`Error::TooLarge`] if it is larger; [`Error::BadInput`] if the name leads out of the folder.
    pub fn open_regular(&self, name: &str, max_bytes: u64) -> Result<File, Error> {
        self.check("read", name)?;
        let file = match self.0.handle.read(name).map_err(|error| self.failed("read", name, error))? {
            Found::File(file) => file,
            Found::Other(kind) => return Err(self.refused("read", name, kind)),
        };
        let needed = file.metadata().map_err(|error| Error::io("read", &self.path_of(name), error))?.len();
        if needed > max_bytes {
            return Err(Error::TooLarge { path: self.path_of(name), what: "file", needed, allowed: max_bytes });
        }
        Ok(file)
    }

    /// Reads a regular file of at most `max_bytes`.
    ///
    /// # Errors
    ///
    /// Those of [`open_regular`](Self::open_regular), also if the file grows meanwhile; [`Error::OutOfMemory`].
    pub fn read(&self, name: &str, max_bytes: u64) -> Result<Vec<u8>, Error> {
        let file = self.open_regular(name, max_bytes)?;
        let path = self.path_of(name);
        let failed = |error| Error::io("read", &path, error);
        let length = file.metadata().map_err(failed)?.len();
        let mut bytes: Vec<u8> = Limits::room(&path, "file", usize::try_from(length).unwrap_or(usize::MAX))?;
        file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(failed)?;
        if bytes.len() as u64 > max_bytes {
            let needed = bytes.len() as u64;
            return Err(Error::TooLarge { path, what: "file", needed, allowed: max_bytes });
        }
        Ok(bytes)
    }

    /// Computes the size and the digest of a regular file. Reads at most one byte more than `max_bytes`.
    ///
    /// # Errors
    ///
    /// Those of [`open_regular`](Self::open_regular).
    pub fn digest(&self, name: &str, max_bytes: u64) -> Result<FileDigest, Error> {
        let file = self.open_regular(name, max_bytes)?;
        hash(&mut file.take(max_bytes.saturating_add(1))).map_err(|error| self.failed("read", name, error))
    }

    /// Opens a regular file for reading and writing, which `create` creates if it is missing. It is not truncated.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be opened, the name is something else, or the file has other names (hard links), which
    /// would change with it; [`Error::BadInput`] if the name leads out of the folder.
    pub fn open_own(&self, name: &str, create: bool) -> Result<File, Error> {
        self.check("write", name)?;
        let file = match self.0.handle.read_write(name, create).map_err(|error| self.failed("write", name, error))? {
            Found::File(file) => file,
            Found::Other(kind) => return Err(self.refused("write", name, kind)),
        };
        match system::names_of(&file).map_err(|error| self.failed("write", name, error))? {
            // None if it was removed after it was opened.
            0 | 1 => Ok(file),
            count => {
                let what = format!("the file has {count} names, and all would change; remove this one");
                Err(Error::io("write", &self.path_of(name), io::Error::other(what)))
            }
        }
    }

    /// Whether a name is still the file that was opened by it.
    pub(crate) fn is_same(&self, name: &str, file: &File) -> io::Result<bool> {
        match self.0.handle.is_same(name, file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
            found => found,
        }
    }

    /// Removes a regular file.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if there is none, or it cannot be removed, or the name is something else; [`Error::BadInput`] if the
    /// name leads out of the folder.
    pub fn remove_file(&self, name: &str) -> Result<(), Error> {
        match self.kind(name)? {
            Some(EntryKind::File) | None => {
                self.0.handle.remove_file(name).map_err(|error| self.failed("remove", name, error))
            }
            Some(kind) => Err(self.refused("remove", name, kind)),
        }
    }

    /// Removes an empty folder.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it is not empty, is no folder, or cannot be removed; [`Error::BadInput`] if the name leads out of
    /// the folder.
    pub fn remove_folder(&self, name: &str) -> Result<(), Error> {
        self.check("remove", name)?;
        self.0.handle.remove_folder(name).map_err(|error| self.failed("remove", name, error))
    }

    /// Renames a regular file, in place of a regular file or of nothing.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if there is no such file, one of the names is something else, or it cannot be renamed;
    /// [`Error::BadInput`] if a name leads out of the folder.
    pub fn rename(&self, from: &str, to: &str) -> Result<(), Error> {
        match self.kind(from)? {
            Some(EntryKind::File) | None => {}
            Some(kind) => return Err(self.refused("rename", from, kind)),
        }
        self.check_replaceable(to)?;
        self.0.handle.rename(from, to).map_err(|error| self.failed("rename", from, error))
    }

    /// Lists the names in the folder, sorted, with what they are. Names that are not UTF-8 or have control characters are
    /// left out: none is this project's.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the folder cannot be read.
    pub fn list(&self) -> Result<Vec<(String, EntryKind)>, Error> {
        let mut found = self.0.handle.list().map_err(|error| Error::io("list", &self.0.path, error))?;
        found.retain(|(name, _)| stays_inside(name));
        found.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(found)
    }

    /// Checks that a file can be written at a name: nothing is there, or a regular file, which is replaced.
    pub(crate) fn check_replaceable(&self, name: &str) -> Result<(), Error> {
        match self.kind(name)? {
            Some(EntryKind::File) | None => Ok(()),
            Some(kind) => Err(self.refused("write", name, kind)),
        }
    }

    /// Creates a file that does not exist yet, for reading and writing.
    pub(crate) fn create_new(&self, name: &str) -> io::Result<File> {
        self.0.handle.create_new(name)
    }

    /// Renames a temporary file of this process to its name.
    pub(crate) fn replace(&self, temporary: &str, name: &str) -> io::Result<()> {
        match self.0.handle.kind(name)? {
            Some(EntryKind::File) | None => self.0.handle.rename(temporary, name),
            Some(kind) => Err(io::Error::other(kind.instead())),
        }
    }

    /// Syncs the folder of a name, as far as the system can.
    pub(crate) fn sync_of(&self, name: &str) -> io::Result<()> {
        self.0.handle.sync(name)
    }

    /// Syncs the folder of a name, as far as the system can.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] with the error of the system.
    pub fn sync(&self, name: &str) -> Result<(), Error> {
        self.check("write", name)?;
        self.0.handle.sync(name).map_err(|error| self.failed("write", name, error))
    }

    fn check(&self, action: &str, name: &str) -> Result<(), Error> {
        if stays_inside(name) {
            return Ok(());
        }
        let what = format!("cannot {action} {name:?} in it: that is no name of a file inside the folder");
        Err(Error::bad_input(&self.0.path, what))
    }

    /// The error of an operation. If a part of the name is a link, it says that instead of what the system says.
    pub(crate) fn failed(&self, action: &'static str, name: &str, error: io::Error) -> Error {
        let ends = name.match_indices('/').map(|(at, _)| at).chain([name.len()]);
        for part in ends.map(|end| &name[..end]) {
            match self.0.handle.kind(part) {
                Ok(Some(EntryKind::Link)) => return self.refused(action, part, EntryKind::Link),
                Ok(Some(_)) => {}
                _ => break,
            }
        }
        Error::io(action, &self.path_of(name), error)
    }

    fn refused(&self, action: &'static str, name: &str, kind: EntryKind) -> Error {
        kind.refused(action, &self.path_of(name))
    }
}

impl From<FileType> for EntryKind {
    fn from(kind: FileType) -> Self {
        match kind {
            kind if kind.is_symlink() => Self::Link,
            kind if kind.is_dir() => Self::Folder,
            kind if kind.is_file() => Self::File,
            _ => Self::Other,
        }
    }
}

impl EntryKind {
    /// What is wrong with a name that should be a file, and what to do.
    const fn instead(self) -> &'static str {
        match self {
            Self::File => "it is a file; remove it or choose another folder",
            Self::Folder => "it is a folder; remove it or choose another folder",
            Self::Link => {
                "it is a symbolic link, and in a folder none is followed; put the file itself there, or remove the link"
            }
            Self::Other => "it is a pipe, a socket or a device; remove it",
        }
    }

    /// The error that says so.
    pub(crate) fn refused(self, action: &'static str, path: &Path) -> Error {
        Error::io(action, path, io::Error::other(self.instead()))
    }
}

/// Reads a text file that belongs to others beside it: a regular file of at most `max_bytes`, and neither link nor pipe.
pub(crate) fn read_beside(path: &Path, max_bytes: u64) -> Result<Vec<u8>, Error> {
    let name = path.file_name().and_then(|name| name.to_str());
    // A name that a folder does not take, as the only part of its path, is the user's own.
    let Some(name) = name.filter(|name| stays_inside(name)) else { return read_small_file(path, max_bytes) };
    let inside = Folder::beside(path).and_then(|folder| folder.read(name, max_bytes));
    // With the path as the caller gave it.
    inside.map_err(|error| match error {
        Error::Io { error, .. } => Error::io("read", path, error),
        Error::TooLarge { what, needed, allowed, .. } => {
            Error::TooLarge { path: path.to_owned(), what, needed, allowed }
        }
        other => other,
    })
}

#[cfg(test)]
mod tests;
