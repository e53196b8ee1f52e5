//! The calls of the standard library, for systems other than Unix: every part of a path is checked before it is used.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::{EntryKind, Found};

/// The absolute path of a folder.
pub(super) struct Handle(PathBuf);

impl Handle {
    /// Opens a folder by its path, in which links are followed.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let path = fs::canonicalize(path)?;
        if !path.is_dir() {
            return Err(io::ErrorKind::NotADirectory.into());
        }
        Ok(Self(path))
    }

    pub(super) fn sub(&self, name: &str) -> io::Result<Self> {
        self.descend(name).map(Self)
    }

    fn descend(&self, name: &str) -> io::Result<PathBuf> {
        let mut path = self.0.clone();
        for part in name.split('/') {
            path.push(part);
            // False for a link, of the type of which this is.
            if !fs::symlink_metadata(&path)?.is_dir() {
                return Err(io::ErrorKind::NotADirectory.into());
            }
        }
        Ok(path)
    }

    /// The path of a name all of whose folders are folders.
    fn at(&self, name: &str) -> io::Result<PathBuf> {
        match name.rsplit_once('/') {
            None => Ok(self.0.join(name)),
            Some((folders, last)) => Ok(self.descend(folders)?.join(last)),
        }
    }

    pub(super) fn kind(&self, name: &str) -> io::Result<Option<EntryKind>> {
        match self.at(name).and_then(fs::symlink_metadata) {
            Ok(found) => Ok(Some(found.file_type().into())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    pub(super) fn read(&self, name: &str) -> io::Result<Found> {
        self.file(name, OpenOptions::new().read(true), false)
    }

    pub(super) fn read_write(&self, name: &str, create: bool) -> io::Result<Found> {
        self.file(name, OpenOptions::new().read(true).write(true).create(create).truncate(false), create)
    }

    fn file(&self, name: &str, options: &OpenOptions, create: bool) -> io::Result<Found> {
        match self.kind(name)? {
            Some(EntryKind::File) => {}
            Some(other) => return Ok(Found::Other(other)),
            None if create => {}
            None => return Err(io::ErrorKind::NotFound.into()),
        }
        let file = options.open(self.at(name)?)?;
        Ok(if file.metadata()?.is_file() { Found::File(file) } else { Found::Other(EntryKind::Other) })
    }

    pub(super) fn create_new(&self, name: &str) -> io::Result<File> {
        OpenOptions::new().read(true).write(true).create_new(true).open(self.at(name)?)
    }

    pub(super) fn create_folder(&self, name: &str) -> io::Result<()> {
        fs::create_dir(self.at(name)?)
    }

    pub(super) fn remove_file(&self, name: &str) -> io::Result<()> {
        fs::remove_file(self.at(name)?)
    }

    pub(super) fn remove_folder(&self, name: &str) -> io::Result<()> {
        fs::remove_dir(self.at(name)?)
    }

    pub(super) fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.at(from)?, self.at(to)?)
    }

    /// Folders cannot be synced here.
    pub(super) fn sync(&self, _: &str) -> io::Result<()> {
        Ok(())
    }

    pub(super) fn list(&self) -> io::Result<Vec<(String, EntryKind)>> {
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.0)? {
            let entry = entry?;
            if let Ok(name) = entry.file_name().into_string() {
                found.push((name, entry.file_type()?.into()));
            }
        }
        Ok(found)
    }

    /// Open files keep their names here until they are closed.
    pub(super) fn is_same(&self, name: &str, _: &File) -> io::Result<bool> {
        Ok(self.kind(name)? == Some(EntryKind::File))
    }
}

/// The standard library does not say how many names a file has.
pub(super) fn names_of(_: &File) -> io::Result<u64> {
    Ok(1)
}

/// There is no such path here.
pub(crate) fn path_of_open_file(_: &File) -> Option<PathBuf> {
    None
}
