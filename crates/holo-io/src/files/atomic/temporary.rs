//! Temporary files: creation, registration, renaming, and removal after a crash.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::target_of;
use crate::Error;
use crate::files::folder::{Destination, EntryKind, Folder};

const SUFFIX: &str = ".part";

/// Maximum length of the part of a name that is kept. Most file systems allow 255 bytes; process number and suffix need
/// the rest.
const MAX_NAME_BYTES: usize = 200;

/// The temporary files of this process by their numbers. A list of the process, because a signal such as Ctrl-C is one of
/// the process.
static LIVE: Mutex<BTreeMap<u64, Place>> = Mutex::new(BTreeMap::new());
static NEXT: AtomicU64 = AtomicU64::new(0);

/// A poisoned lock is used: the map is consistent after every statement.
fn live() -> MutexGuard<'static, BTreeMap<u64, Place>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where a file is.
#[derive(Debug, Clone)]
enum Place {
    /// By an absolute path.
    Path(PathBuf),
    /// By its name in an open folder.
    Inside(Folder, String),
}

impl Place {
    fn create_new(&self) -> io::Result<File> {
        match self {
            // For reading too: a digest at `commit` reads the file.
            Self::Path(path) => OpenOptions::new().read(true).write(true).create_new(true).open(path),
            Self::Inside(folder, name) => folder.create_new(name),
        }
    }

    fn remove(&self) -> bool {
        match self {
            Self::Path(path) => fs::remove_file(path).is_ok(),
            Self::Inside(folder, name) => folder.remove_file(name).is_ok(),
        }
    }

    /// The place of another name in the same folder.
    fn beside(&self, name: &str) -> Self {
        match self {
            Self::Path(path) => Self::Path(path.with_file_name(name)),
            Self::Inside(folder, own) => {
                let name = own.rsplit_once('/').map_or_else(|| name.to_owned(), |(inner, _)| format!("{inner}/{name}"));
                Self::Inside(folder.clone(), name)
            }
        }
    }

    /// The last part of the name; `None` for a path without one.
    fn name(&self) -> Option<String> {
        match self {
            Self::Path(path) => Some(path.file_name()?.to_string_lossy().into_owned()),
            Self::Inside(_, name) => name.rsplit('/').next().map(str::to_owned),
        }
    }
}

/// A temporary file that is removed when dropped, unless it was renamed.
#[derive(Debug)]
pub(super) struct Temporary {
    number: u64,
    place: Place,
    target: Place,
    renamed: bool,
}

impl Temporary {
    /// Creates a temporary file in the folder of a destination; `None` where that is a device or a pipe, which only a path
    /// can be.
    pub(super) fn of(destination: &impl Destination) -> Result<Option<(File, Self)>, Error> {
        let target = match destination.place() {
            Some((folder, name)) => {
                folder.check_replaceable(name)?;
                Place::Inside(folder.clone(), name.to_owned())
            }
            None => match target_of(destination.path())? {
                Some(target) => Place::Path(target),
                None => return Ok(None),
            },
        };
        match (Self::create(target), destination.place()) {
            (Ok(created), _) => Ok(Some(created)),
            (Err(error), Some((folder, name))) => Err(folder.failed("write", name, error)),
            (Err(error), None) => Err(Error::io("write", destination.path(), error)),
        }
    }

    /// Creates a temporary file in the folder of `target`. If `target` is a path, it must be absolute.
    fn create(target: Place) -> io::Result<(File, Self)> {
        let name = target.name().ok_or(io::ErrorKind::InvalidInput)?;
        let end = (0..=name.len().min(MAX_NAME_BYTES)).rev().find(|&at| name.is_char_boundary(at)).unwrap_or(0);
        let name = &name[..end];
        loop {
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let place = target.beside(&format!(".{name}.{}-{number}{SUFFIX}", std::process::id()));
            // Held while the file is created, so that `remove_temporary_files` never runs between creation and
            // registration.
            let mut live = live();
            match place.create_new() {
                Ok(file) => {
                    // By the lock other processes see that the writer of this file runs. The system releases it when
                    // the process ends. Where the file system has no locks, `is_alive` is the only check.
                    let _ = file.try_lock();
                    live.insert(number, place.clone());
                    return Ok((file, Self { number, place, target, renamed: false }));
                }
                // Left by an earlier process of the same number.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// The temporary path.
    pub(super) fn path(&self) -> PathBuf {
        match &self.place {
            Place::Path(path) => path.clone(),
            Place::Inside(folder, name) => folder.path_of(name),
        }
    }

    /// Renames the file to its target, atomically, and syncs the folder.
    pub(super) fn rename(mut self) -> io::Result<()> {
        match (&self.place, &self.target) {
            (Place::Inside(folder, own), Place::Inside(_, name)) => {
                folder.replace(own, name)?;
                self.renamed = true;
                folder.sync_of(name)
            }
            (Place::Path(own), Place::Path(target)) => {
                fs::rename(own, target)?;
                self.renamed = true;
                sync_folder(target.parent())
            }
            _ => Err(io::ErrorKind::InvalidInput.into()),
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        live().remove(&self.number);
        if !self.renamed {
            // There is no caller to report an error to.
            self.place.remove();
        }
    }
}

/// Syncs the folder, so that the rename survives a power failure.
fn sync_folder(folder: Option<&Path>) -> io::Result<()> {
    // Folders can be opened on Unix only.
    let Some(folder) = folder.filter(|_| cfg!(unix)) else { return Ok(()) };
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // The folder may be written but not read, or the file system cannot sync folders. The file is renamed already.
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::PermissionDenied | io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported
            ) =>
        {
            Ok(())
        }
        outcome => outcome,
    }
}

/// The temporary files of this process were removed, and no others are created while this value lives.
///
/// Do not create or drop an [`AtomicFile`](crate::AtomicFile) on the thread that holds it: that waits for itself.
#[derive(Debug)]
pub struct TemporaryFilesRemoved {
    count: usize,
    _live: MutexGuard<'static, BTreeMap<u64, Place>>,
}

impl TemporaryFilesRemoved {
    /// Returns how many files were removed.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }
}

/// Removes the temporary files of this process. Until the result is dropped, other threads that create or close an
/// [`AtomicFile`](crate::AtomicFile) wait.
///
/// For a process that is about to end, such as after Ctrl-C, which holds the result until it exits. An `AtomicFile` that is
/// still open can no longer be committed: `commit` is an error.
#[must_use = "dropped, it lets other threads create temporary files again"]
pub fn remove_temporary_files() -> TemporaryFilesRemoved {
    let mut live = live();
    let places = std::mem::take(&mut *live);
    let count = places.values().filter(|place| place.remove()).count();
    TemporaryFilesRemoved { count, _live: live }
}

/// Removes the temporary files that ended processes left in `folder`, and returns their paths, sorted.
///
/// A file is removed only if its name is one that [`AtomicFile`](crate::AtomicFile) creates, if no process holds its
/// lock, and if no process of its number runs on this machine (checked where there is a `/proc`). The lock also
/// protects the files of other machines and containers that share the folder. Subfolders are not searched.
///
/// # Errors
///
/// [`Error::Io`] if the folder cannot be listed or a stale file cannot be removed.
pub fn remove_stale_temporary_files(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let folder = folder.as_ref();
    let opened = Folder::open(folder).map_err(|error| match error {
        Error::Io { error, .. } => Error::io("list", folder, error),
        other => other,
    })?;
    opened.remove_stale_temporary_files()
}

impl Folder {
    /// Removes the temporary files that ended processes left in this folder, as [`remove_stale_temporary_files`].
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the folder cannot be listed or a stale file cannot be removed.
    pub fn remove_stale_temporary_files(&self) -> Result<Vec<PathBuf>, Error> {
        let mut removed = Vec::new();
        for (name, kind) in self.list()? {
            let Some(process) = process_of(&name) else { continue };
            if kind != EntryKind::File || is_alive(process) || self.is_locked(&name) {
                continue;
            }
            match self.remove_file(&name) {
                Ok(()) => removed.push(self.path_of(&name)),
                // Another process removed it.
                Err(Error::Io { error, .. }) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Ok(removed)
    }

    /// Whether a process, here or on another machine, holds the lock of a file; `true` if the file cannot be opened.
    fn is_locked(&self, name: &str) -> bool {
        // Opened for writing, because network file systems require that for an exclusive lock.
        match self.open_own(name, false) {
            Ok(file) => matches!(file.try_lock(), Err(TryLockError::WouldBlock)),
            Err(_) => true,
        }
    }
}

/// Returns the process number in a name of the form `.NAME.<process>-<number>.part`.
fn process_of(name: &str) -> Option<u32> {
    let (name, numbers) = name.strip_prefix('.')?.strip_suffix(SUFFIX)?.rsplit_once('.')?;
    let (process, number) = numbers.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if name.is_empty() || !is_number(process) || !is_number(number) {
        return None;
    }
    process.parse().ok()
}

/// Whether a process of this number runs; for other processes `false` where the system has no `/proc`.
fn is_alive(process: u32) -> bool {
    process == std::process::id() || Path::new("/proc").join(process.to_string()).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_this_crate_are_parsed() {
        assert_eq!(process_of(".scene_el.png.4711-3.part"), Some(4711));
        assert_eq!(process_of(".a.b-c.d.1-0.part"), Some(1));
        for other in [
            "scene_el.png.4711-3.part",
            ".x.4711.part",
            ".x.-3.part",
            ".x.4711-.part",
            ".x.a-3.part",
            ".part",
            "..1-1.part",
            ".x.+1-1.part",
        ] {
            assert_eq!(process_of(other), None, "{other}");
        }
    }

    #[test]
    fn a_name_of_maximum_length_gets_a_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        // Two-byte characters, so that a cut at a fixed byte would split one.
        let target = folder.path().join(format!("a{}", "ä".repeat(127)));
        let (_file, temporary) = Temporary::create(Place::Path(target.clone())).unwrap();
        temporary.rename().unwrap();
        assert!(target.exists());
    }

    #[test]
    fn an_existing_temporary_name_is_skipped() {
        let folder = tempfile::tempdir().unwrap();
        let next = NEXT.load(Ordering::Relaxed);
        for number in next..next + 50 {
            fs::write(folder.path().join(format!(".x.{}-{number}.part", std::process::id())), b"old").unwrap();
        }
        let (_file, temporary) = Temporary::create(Place::Path(folder.path().join("x"))).unwrap();
        temporary.rename().unwrap();
        assert_eq!(fs::read(folder.path().join("x")).unwrap(), b"");
    }
}
