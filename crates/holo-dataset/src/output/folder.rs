//! The output folder of a render: created if it is missing, locked, rolled back after an error, completed by its manifest.
//!
//! It is opened once and used through its handle ([`Folder`]). Nothing that is found in it gives a right: of an older
//! result only those files are removed that are as its manifest records them and have names that jobs write, and a
//! manifest that another run has put aside counts for nothing.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use holo_io::{AtomicFile, FileDigest, Folder, FolderFile, FolderLock, Manifest, dataset};

use super::names::is_of_a_job;
use crate::Error;
use crate::watch::{About, Diagnostics};

/// The name of an older manifest while its folder is written again.
const OLD_MANIFEST: &str = ".manifest.old.json";

/// What the name of a checkpoint begins and ends with.
pub(crate) const CHECKPOINT: [&str; 2] = [".holo-", ".checkpoint"];

/// The first bytes of a checkpoint. A file of that name without them is somebody else's.
pub(crate) const CHECKPOINT_MAGIC: &[u8; 16] = b"holo checkpoint\x01";

/// The files and folders that unfinished runs created: removed by an [`OutputFolder`] that is dropped unfinished, or by
/// a program that is about to end ([`Rollback::stop`]). Clones share the list.
#[derive(Clone, Debug, Default)]
pub struct Rollback(Arc<Mutex<Created>>);

/// Created folders, and files that were or will be created in them, outer before inner, each with the number of its
/// run.
#[derive(Debug, Default)]
struct Created {
    places: Vec<(u64, Place)>,
    runs: u64,
    /// Set when the process is about to end: nothing more is created.
    stopped: bool,
}

/// Something that a run created.
#[derive(Debug)]
enum Place {
    /// A folder on the way to the output folder, by the path that the user gave.
    Root(PathBuf),
    Folder(Folder, String),
    File(Folder, String),
}

impl Place {
    /// Removes it. A file that was never written, or a folder with other files in it, is no error.
    fn remove(&self) {
        let _ = match self {
            // Empty folders alone.
            Self::Root(path) => std::fs::remove_dir(path).is_ok(),
            Self::Folder(folder, name) => folder.remove_folder(name).is_ok(),
            Self::File(folder, name) => folder.remove_file(name).is_ok(),
        };
    }
}

impl Rollback {
    /// Removes what unfinished runs created, and lets runs create nothing more: for a process that is about to end.
    pub fn stop(&self) {
        let mut created = self.created();
        created.stopped = true;
        created.remove(|_| true);
    }

    /// A poisoned lock is used: the list is consistent after every statement.
    fn created(&self) -> MutexGuard<'_, Created> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Created {
    /// Removes what the runs of these numbers created. Files that existed before, replaced or not, stay, and so do
    /// folders with such files.
    fn remove(&mut self, of: impl Fn(u64) -> bool) {
        let places: Vec<_> = self.places.extract_if(.., |(run, _)| of(*run)).collect();
        places.iter().rev().for_each(|(_, place)| place.remove());
    }
}

/// What one run created. Dropped unfinished, it is removed.
struct Run {
    rollback: Rollback,
    number: u64,
    finished: bool,
}

impl Run {
    fn new(rollback: &Rollback) -> Self {
        let number = {
            let mut created = rollback.created();
            created.runs += 1;
            created.runs
        };
        Self { rollback: rollback.clone(), number, finished: false }
    }

    /// Creates something and registers it, unless it existed. The list is locked meanwhile, so that `stop` does not miss it.
    fn create<T>(&self, path: &Path, create: impl FnOnce() -> Result<(T, Option<Place>), Error>) -> Result<T, Error> {
        let mut created = self.rollback.created();
        if created.stopped {
            return Err(cannot_create(path, &ErrorKind::Interrupted.into()));
        }
        let (value, place) = create()?;
        created.places.extend(place.map(|place| (self.number, place)));
        Ok(value)
    }

    /// What it created stays.
    fn keep(&mut self) {
        self.finished = true;
        self.rollback.created().places.retain(|(of, _)| *of != self.number);
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        if !self.finished {
            self.rollback.created().remove(|run| run == self.number);
        }
    }
}

/// An output folder that is being written. Dropped unfinished, it removes what its run created.
pub struct OutputFolder {
    folder: Folder,
    files: Vec<(String, FileDigest)>,
    /// Those in it that were opened: of thousands of files, each needs its folder.
    subfolders: Mutex<BTreeMap<String, Folder>>,
    /// Whether this run has put an older manifest aside.
    is_unsealed: bool,
    /// That manifest, if it could be read.
    older: Option<Manifest>,
    // Dropped in this order: the file of the lock is among what a run created, and is not another's until the lock is gone.
    run: Run,
    /// `None` for a folder in which several processes may work, such as the root of a dataset.
    _lock: Option<FolderLock>,
}

impl OutputFolder {
    /// Creates the folder of one render, checks that files can be created in it, and takes its lock.
    ///
    /// # Errors
    /// [`Error::Failed`] or [`Error::Io`] if the folder cannot be created or written, or another process writes in it.
    pub fn create(path: &Path, rollback: &Rollback, diagnostics: &dyn Diagnostics) -> Result<Self, Error> {
        Self::create_in((path, ""), false, rollback, diagnostics)
    }

    /// The same for a folder `inner` below `root`, where no link is followed. Where the file system has no locks,
    /// `overwrite` passes the file of a process that may have ended. A manifest that another run has put aside is reported.
    pub(crate) fn create_in(
        (root, inner): (&Path, &str),
        overwrite: bool,
        rollback: &Rollback,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Self, Error> {
        let mut folder = Self::open(root, inner, rollback)?;
        // Dropped without `commit`, it leaves no file.
        AtomicFile::create(folder.folder.file(dataset::MANIFEST_JSON))?;
        let inside = &folder.folder;
        let lock = folder.run.create(inside.path(), || {
            let lock = inside.lock(overwrite)?;
            Ok((lock, Some(Place::File(inside.clone(), FolderLock::FILE.to_owned()))))
        })?;
        folder._lock = Some(lock);
        folder.folder.remove_stale_temporary_files()?;
        if let Some(note) = leftover(&folder.folder) {
            diagnostics.report(About::Scene, &note);
        }
        Ok(folder)
    }

    /// Creates the folder without a lock, and removes temporary files that a killed run left in it.
    ///
    /// # Errors
    /// [`Error::Failed`] if the folder cannot be created; [`Error::Io`] if stale files cannot be removed.
    pub fn create_plain(path: &Path, rollback: &Rollback) -> Result<Self, Error> {
        let folder = Self::open(path, "", rollback)?;
        folder.folder.remove_stale_temporary_files()?;
        Ok(folder)
    }

    fn open(root: &Path, inner: &str, rollback: &Rollback) -> Result<Self, Error> {
        let run = Run::new(rollback);
        let missing: Vec<&Path> = root.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).collect();
        for path in missing.into_iter().rev() {
            run.create(path, || match std::fs::create_dir(path) {
                Ok(()) => Ok(((), Some(Place::Root(path.to_path_buf())))),
                Err(why) if why.kind() == ErrorKind::AlreadyExists && path.is_dir() => Ok(((), None)),
                Err(why) => Err(cannot_create(path, &why)),
            })?;
        }
        let mut folder = Folder::open(root).map_err(|why| match why {
            holo_io::Error::Io { error, .. } => cannot_create(root, &error),
            other => other.into(),
        })?;
        if !inner.is_empty() {
            create_folders(&run, &folder, inner)?;
            folder = folder.sub(inner)?;
        }
        let (files, subfolders) = (Vec::new(), Mutex::default());
        Ok(Self { folder, files, subfolders, is_unsealed: false, older: None, run, _lock: None })
    }

    /// Finishes without a manifest: all files stay.
    pub fn keep(mut self) {
        self.run.keep();
    }

    /// Returns the place of a file that is about to be written, and registers it for a rollback. `name` may lead into a
    /// subfolder.
    #[must_use]
    pub fn file(&self, name: &str) -> FolderFile {
        let opened = self.opened();
        let inner = name.rsplit_once('/').and_then(|(folder, last)| Some((opened.get(folder)?, last)));
        let (folder, name) = inner.unwrap_or((&self.folder, name));
        // What is there already is not this run's.
        if matches!(folder.kind(name), Ok(None)) {
            let place = Place::File(folder.clone(), name.to_owned());
            self.run.rollback.created().places.push((self.run.number, place));
        }
        folder.file(name)
    }

    fn opened(&self) -> MutexGuard<'_, BTreeMap<String, Folder>> {
        self.subfolders.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the open folder.
    #[must_use]
    pub fn folder(&self) -> &Folder {
        &self.folder
    }

    /// Creates a subfolder and those that it is in, unless they exist, and removes temporary files that a killed run left
    /// in it. Returns it.
    ///
    /// # Errors
    /// [`Error::Failed`] with the error of the file system; [`Error::Io`] if stale files cannot be removed, or a part of
    /// the name is a link.
    pub fn subfolder(&self, name: &str) -> Result<Folder, Error> {
        let mut opened = self.opened();
        if let Some(inner) = opened.get(name) {
            return Ok(inner.clone());
        }
        create_folders(&self.run, &self.folder, name)?;
        let inner = self.folder.sub(name)?;
        inner.remove_stale_temporary_files()?;
        opened.insert(name.to_owned(), inner.clone());
        Ok(inner)
    }

    /// Puts an older manifest aside, because the files that it lists are about to change.
    ///
    /// # Errors
    /// [`Error::Failed`] with the error of the file system.
    pub fn unseal(&mut self) -> Result<(), Error> {
        if self.folder.kind(dataset::MANIFEST_JSON)?.is_none() {
            return Ok(());
        }
        // What cannot be read lists nothing.
        self.older = Manifest::read_in(&self.folder).ok();
        self.folder
            .rename(dataset::MANIFEST_JSON, OLD_MANIFEST)
            .map_err(|why| Error::Failed(format!("cannot replace the manifest: {why}")))?;
        self.is_unsealed = true;
        Ok(())
    }

    /// Adds a file that was written to the manifest.
    pub fn add(&mut self, name: impl Into<String>, written: FileDigest) {
        self.files.push((name.into(), written));
    }

    /// Returns the names of the files that were added.
    pub fn names(&self) -> Vec<String> {
        self.files.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Writes the manifest with all files that were added, and removes files of an older manifest that it does not
    /// list, if they are as that recorded them, and checkpoints. Returns the names of the files and of the manifest.
    ///
    /// # Errors
    /// [`Error::Io`] if the manifest cannot be written.
    pub fn seal(mut self, mut manifest: Manifest) -> Result<Vec<String>, Error> {
        manifest.files.extend(self.files.drain(..));
        manifest.write(self.file(dataset::MANIFEST_JSON))?;
        self.run.keep();
        self.clear_older(&manifest);
        remove_checkpoints(&self.folder);
        let names = manifest.files.keys().cloned();
        Ok(names.chain([dataset::MANIFEST_JSON.to_string()]).collect())
    }

    /// Removes the files of the older manifest that the new one does not list, and the older manifest. All other files
    /// stay. Errors are ignored: such a file does no harm.
    fn clear_older(&self, manifest: &Manifest) {
        let older = self.older.iter().flat_map(|older| &older.files);
        for (name, recorded) in older.filter(|(name, _)| !manifest.files.contains_key(*name) && is_of_a_job(name)) {
            let is_as_recorded = self.folder.digest(name, recorded.bytes).is_ok_and(|found| found == *recorded);
            if is_as_recorded && self.folder.remove_file(name).is_ok() {
                let inner = name.rmatch_indices('/').map(|(at, _)| &name[..at]);
                inner.for_each(|folder| drop(self.folder.remove_folder(folder)));
            }
        }
        if self.is_unsealed {
            let _ = self.folder.remove_file(OLD_MANIFEST);
        }
    }
}

/// Creates a folder in another and those that it is in, unless they exist.
fn create_folders(run: &Run, folder: &Folder, name: &str) -> Result<(), Error> {
    for end in name.match_indices('/').map(|(at, _)| at).chain([name.len()]) {
        let part = &name[..end];
        run.create(&folder.path_of(part), || {
            let is_new = folder.create_folder(part)?;
            Ok(((), is_new.then(|| Place::Folder(folder.clone(), part.to_owned()))))
        })?;
    }
    Ok(())
}

/// Opens the folder `inner` below `root`, if there is one. Links below `root` are not followed.
///
/// # Errors
/// [`Error::Io`] if it cannot be opened, or is a link or no folder.
pub(crate) fn existing(root: &Path, inner: &str) -> Result<Option<Folder>, Error> {
    let root = match Folder::open(root) {
        Ok(root) => root,
        Err(holo_io::Error::Io { error, .. })
            if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
        {
            return Ok(None);
        }
        Err(why) => return Err(why.into()),
    };
    if inner.is_empty() {
        return Ok(Some(root));
    }
    Ok(match root.kind(inner)? {
        Some(_) => Some(root.sub(inner)?),
        None => None,
    })
}

/// The line that reports a manifest that another run has put aside, if there is one.
fn leftover(folder: &Folder) -> Option<String> {
    let path = folder.path_of(OLD_MANIFEST);
    let is_there = !matches!(folder.kind(OLD_MANIFEST), Ok(None));
    is_there.then(|| {
        format!(
            "note: {} is of a run that did not end; it is not used, and files that it alone lists stay",
            path.display()
        )
    })
}

/// The name of a folder below another, with `/` on every system.
pub(crate) fn inner_name(folder: &Path) -> Result<String, Error> {
    let parts: Option<Vec<&str>> = folder.iter().map(|part| part.to_str()).collect();
    let parts = parts.ok_or_else(|| Error::Failed(format!("{}: the name is not UTF-8", folder.display())))?;
    Ok(parts.join("/"))
}

fn cannot_create(path: &Path, why: &std::io::Error) -> Error {
    Error::Failed(format!("cannot create the folder {}: {why}; choose another with `out`", path.display()))
}

/// Returns the names of the checkpoints in a folder, sorted: `.holo-<16 hexadecimal digits>.checkpoint`, whatever they are.
pub(crate) fn checkpoints(folder: &Folder) -> Vec<String> {
    let is_checkpoint = |name: &str| {
        let digits = name.strip_prefix(CHECKPOINT[0]).and_then(|name| name.strip_suffix(CHECKPOINT[1]));
        digits.is_some_and(|digits| digits.len() == 16 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()))
    };
    let entries = folder.list().unwrap_or_default().into_iter().map(|(name, _)| name);
    entries.filter(|name| is_checkpoint(name)).collect()
}

/// Removes the checkpoints in a folder: files that begin as checkpoints do, and empty ones.
pub(crate) fn remove_checkpoints(folder: &Folder) {
    for name in checkpoints(folder) {
        if has_checkpoint_magic(folder, &name) {
            // Such a file does no harm.
            let _ = folder.remove_file(&name);
        }
    }
}

fn has_checkpoint_magic(folder: &Folder, name: &str) -> bool {
    use std::io::Read;

    let Ok(file) = folder.open_regular(name, u64::MAX) else { return false };
    let mut begin = Vec::new();
    let read = file.take(CHECKPOINT_MAGIC.len() as u64).read_to_end(&mut begin);
    read.is_ok() && (begin.is_empty() || begin == CHECKPOINT_MAGIC)
}
