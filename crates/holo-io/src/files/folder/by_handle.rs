//! The calls of Unix: names are looked up from an open folder, part by part, and no link is followed.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::fs::{AtFlags, Dir, FileType, Mode, OFlags, fsync, mkdirat, open, openat, renameat, statat, unlinkat};
use rustix::io::Errno;

use super::{EntryKind, Found};

/// How folders below an open one are opened.
const FOLDER: OFlags = OFlags::RDONLY.union(OFlags::DIRECTORY).union(OFlags::NOFOLLOW).union(OFlags::CLOEXEC);

/// How files are opened. Should another process put a pipe or a terminal in place of the file at this moment, the call
/// returns at once, and the process gets no controlling terminal.
const FILE: OFlags = OFlags::NOFOLLOW.union(OFlags::NONBLOCK).union(OFlags::NOCTTY).union(OFlags::CLOEXEC);

/// An open folder.
pub(super) struct Handle(OwnedFd);

impl Handle {
    /// Opens a folder by its path, in which links are followed.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let flags = OFlags::RDONLY.union(OFlags::DIRECTORY).union(OFlags::CLOEXEC);
        Ok(Self(open(path, flags, Mode::empty())?))
    }

    pub(super) fn sub(&self, name: &str) -> io::Result<Self> {
        self.descend(name).map(Self)
    }

    /// Opens the folders of a name one after another.
    fn descend(&self, name: &str) -> io::Result<OwnedFd> {
        let mut inner: Option<OwnedFd> = None;
        for part in name.split('/') {
            let outer = match &inner {
                Some(folder) => folder.as_fd(),
                None => self.0.as_fd(),
            };
            let next = openat(outer, part, FOLDER, Mode::empty())?;
            inner = Some(next);
        }
        inner.ok_or_else(|| io::ErrorKind::InvalidInput.into())
    }

    /// Calls `act` with the folder that a name is in, and its last part.
    fn at<T>(&self, name: &str, act: impl FnOnce(BorrowedFd<'_>, &str) -> io::Result<T>) -> io::Result<T> {
        match name.rsplit_once('/') {
            None => act(self.0.as_fd(), name),
            Some((folders, last)) => {
                let folder = self.descend(folders)?;
                act(folder.as_fd(), last)
            }
        }
    }

    pub(super) fn kind(&self, name: &str) -> io::Result<Option<EntryKind>> {
        let found = self.at(name, kind_at);
        match found {
            Ok(kind) => Ok(Some(kind)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    pub(super) fn read(&self, name: &str) -> io::Result<Found> {
        self.file(name, OFlags::RDONLY)
    }

    pub(super) fn read_write(&self, name: &str, create: bool) -> io::Result<Found> {
        let flags = if create { OFlags::RDWR.union(OFlags::CREATE) } else { OFlags::RDWR };
        self.file(name, flags)
    }

    fn file(&self, name: &str, flags: OFlags) -> io::Result<Found> {
        self.at(name, |folder, last| {
            // Before it is opened, because opening a device may start something.
            match kind_at(folder, last) {
                Ok(EntryKind::File) => {}
                Ok(other) => return Ok(Found::Other(other)),
                Err(error) if error.kind() == io::ErrorKind::NotFound && flags.contains(OFlags::CREATE) => {}
                Err(error) => return Err(error),
            }
            let file = File::from(openat(folder, last, FILE.union(flags), permissions())?);
            // Another process may have exchanged it in between.
            Ok(if file.metadata()?.is_file() { Found::File(file) } else { Found::Other(EntryKind::Other) })
        })
    }

    pub(super) fn create_new(&self, name: &str) -> io::Result<File> {
        let flags = OFlags::RDWR.union(OFlags::CREATE).union(OFlags::EXCL);
        self.at(name, |folder, last| Ok(File::from(openat(folder, last, FILE.union(flags), permissions())?)))
    }

    pub(super) fn create_folder(&self, name: &str) -> io::Result<()> {
        self.at(name, |folder, last| Ok(mkdirat(folder, last, Mode::from_raw_mode(0o777))?))
    }

    pub(super) fn remove_file(&self, name: &str) -> io::Result<()> {
        self.at(name, |folder, last| Ok(unlinkat(folder, last, AtFlags::empty())?))
    }

    pub(super) fn remove_folder(&self, name: &str) -> io::Result<()> {
        self.at(name, |folder, last| Ok(unlinkat(folder, last, AtFlags::REMOVEDIR)?))
    }

    pub(super) fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        self.at(from, |from_folder, from| self.at(to, |to_folder, to| Ok(renameat(from_folder, from, to_folder, to)?)))
    }

    /// Syncs the folder that a name is in.
    pub(super) fn sync(&self, name: &str) -> io::Result<()> {
        self.at(name, |folder, _| match fsync(folder) {
            // A file system that cannot sync folders.
            Err(Errno::INVAL | Errno::NOTSUP | Errno::BADF) => Ok(()),
            outcome => Ok(outcome?),
        })
    }

    pub(super) fn list(&self) -> io::Result<Vec<(String, EntryKind)>> {
        let mut found = Vec::new();
        for entry in Dir::read_from(&self.0)? {
            let entry = entry?;
            let Ok(name) = entry.file_name().to_str() else { continue };
            if matches!(name, "." | "..") {
                continue;
            }
            let kind = match entry.file_type() {
                // Some file systems do not say.
                FileType::Unknown => self.kind(name)?,
                known => Some(kind_of(known)),
            };
            // None if it was removed meanwhile.
            found.extend(kind.map(|kind| (name.to_owned(), kind)));
        }
        Ok(found)
    }

    pub(super) fn is_same(&self, name: &str, file: &File) -> io::Result<bool> {
        let Found::File(found) = self.read(name)? else { return Ok(false) };
        let (found, file) = (found.metadata()?, file.metadata()?);
        Ok((found.dev(), found.ino()) == (file.dev(), file.ino()))
    }
}

/// What the last part of a name is.
fn kind_at(folder: BorrowedFd<'_>, last: &str) -> io::Result<EntryKind> {
    let found = statat(folder, last, AtFlags::SYMLINK_NOFOLLOW)?;
    Ok(kind_of(FileType::from_raw_mode(found.st_mode)))
}

fn kind_of(kind: FileType) -> EntryKind {
    match kind {
        FileType::RegularFile => EntryKind::File,
        FileType::Directory => EntryKind::Folder,
        FileType::Symlink => EntryKind::Link,
        _ => EntryKind::Other,
    }
}

/// The permissions of new files, of which the process takes away those of its `umask`.
fn permissions() -> Mode {
    Mode::from_raw_mode(0o666)
}

/// The number of names (hard links) of an open file.
pub(super) fn names_of(file: &File) -> io::Result<u64> {
    Ok(file.metadata()?.nlink())
}

/// A path that leads to an open file whatever its name is, for libraries that open files by path; `None` where the system
/// has none.
pub(crate) fn path_of_open_file(file: &File) -> Option<PathBuf> {
    use std::os::fd::AsRawFd;

    let path = PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()));
    Some(path).filter(|path| cfg!(target_os = "linux") && path.symlink_metadata().is_ok())
}
