//! The output folder of a render: created if it is missing, rolled back after an error, completed by its manifest.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use holo_io::{FileDigest, Manifest, dataset};

use crate::Error;

/// The name of an older manifest while its folder is written again.
const OLD_MANIFEST: &str = ".manifest.old.json";

/// What the name of a checkpoint begins and ends with.
pub(crate) const CHECKPOINT: [&str; 2] = [".holo-", ".checkpoint"];

/// The files and folders that unfinished runs created: removed by an [`OutputFolder`] that is dropped unfinished, or by
/// a program that is about to end ([`Rollback::stop`]). Clones share the list.
#[derive(Clone, Debug, Default)]
pub struct Rollback(Arc<Mutex<Created>>);

/// Created folders, and files that were or will be created in them, outer before inner, each with the number of its
/// run.
#[derive(Debug, Default)]
struct Created {
    paths: Vec<(u64, PathBuf)>,
    runs: u64,
    /// Set when the process is about to end: nothing more is created.
    stopped: bool,
}

impl Rollback {
    /// Removes what unfinished runs created, and lets runs create nothing more: for a process that is about to end.
    pub fn stop(&self) {
        let mut created = self.created();
        created.stopped = true;
        created.remove(|_| true);
    }

    fn begin(&self) -> u64 {
        let mut created = self.created();
        created.runs += 1;
        created.runs
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
        for (_, path) in self.paths.extract_if(.., |(run, _)| of(*run)).collect::<Vec<_>>().into_iter().rev() {
            // A file that was never written, or a folder with other files in it, is no error.
            let _ = if path.is_dir() { std::fs::remove_dir(&path) } else { std::fs::remove_file(&path) };
        }
    }

    /// Removes a run from the list: its files stay.
    fn keep(&mut self, run: u64) {
        self.paths.retain(|(of, _)| *of != run);
    }
}

/// An output folder that is being written. Dropped unfinished, it removes what its run created.
pub struct OutputFolder {
    path: PathBuf,
    files: Vec<(String, FileDigest)>,
    finished: bool,
    rollback: Rollback,
    run: u64,
}

impl OutputFolder {
    /// Creates the folder of one render, and checks that files can be created in it.
    ///
    /// # Errors
    /// [`Error::Failed`] or [`Error::Io`] if the folder cannot be created or written.
    pub fn create(path: &Path, rollback: &Rollback) -> Result<Self, Error> {
        let folder = Self::create_plain(path, rollback)?;
        // Dropped without `commit`, it leaves no file.
        holo_io::AtomicFile::create(path.join(dataset::MANIFEST_JSON))?;
        Ok(folder)
    }

    /// Creates the folder, and removes temporary files that a killed run left in it.
    ///
    /// # Errors
    /// [`Error::Failed`] if the folder cannot be created; [`Error::Io`] if stale files cannot be removed.
    pub fn create_plain(path: &Path, rollback: &Rollback) -> Result<Self, Error> {
        let folder = Self {
            path: path.to_path_buf(),
            files: Vec::new(),
            finished: false,
            rollback: rollback.clone(),
            run: rollback.begin(),
        };
        let missing: Vec<&Path> = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).collect();
        for ancestor in missing.into_iter().rev() {
            folder.create_folder(ancestor)?;
        }
        if !path.is_dir() {
            return Err(cannot_create(path, ErrorKind::NotADirectory.into()));
        }
        holo_io::remove_stale_temporary_files(path)?;
        Ok(folder)
    }

    /// Finishes without a manifest: all files stay.
    pub fn keep(mut self) {
        self.finished = true;
        self.rollback.created().keep(self.run);
    }

    /// Returns the path of a file that is about to be written, and registers it for a rollback. `name` may lead into a
    /// subfolder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        let path = self.path.join(name);
        if std::fs::symlink_metadata(&path).is_err() {
            self.rollback.created().paths.push((self.run, path.clone()));
        }
        path
    }

    /// Creates a subfolder and those that it is in, unless they exist, and removes temporary files that a killed run left in it.
    ///
    /// # Errors
    /// [`Error::Failed`] with the error of the file system; [`Error::Io`] if stale files cannot be removed.
    pub fn subfolder(&self, name: &str) -> Result<(), Error> {
        let mut path = self.path.clone();
        for part in name.split('/') {
            path.push(part);
            self.create_folder(&path)?;
        }
        holo_io::remove_stale_temporary_files(path)?;
        Ok(())
    }

    /// Renames an older manifest, because the files that it lists are about to change.
    ///
    /// # Errors
    /// [`Error::Failed`] with the error of the file system.
    pub fn unseal(&self) -> Result<(), Error> {
        let path = self.path.join(dataset::MANIFEST_JSON);
        match std::fs::rename(&path, self.path.join(OLD_MANIFEST)) {
            Err(why) if why.kind() != ErrorKind::NotFound => {
                Err(Error::Failed(format!("cannot replace {}: {why}", path.display())))
            }
            _ => Ok(()),
        }
    }

    /// Adds a file that was written to the manifest.
    pub fn add(&mut self, name: impl Into<String>, written: FileDigest) {
        self.files.push((name.into(), written));
    }

    /// Writes the manifest with all files that were added, and removes files of an older manifest that it does not
    /// list, and checkpoints. Returns the names of the files and of the manifest.
    ///
    /// # Errors
    /// [`Error::Io`] if the manifest cannot be written.
    pub fn seal(mut self, mut manifest: Manifest) -> Result<Vec<String>, Error> {
        manifest.files.extend(self.files.drain(..));
        manifest.write(self.file(dataset::MANIFEST_JSON))?;
        self.finished = true;
        self.rollback.created().keep(self.run);
        clear_older(&self.path, &manifest);
        checkpoints(&self.path).iter().for_each(|path| drop(std::fs::remove_file(path)));
        let names = manifest.files.keys().cloned();
        Ok(names.chain([dataset::MANIFEST_JSON.to_string()]).collect())
    }

    /// Creates one folder, unless it exists.
    fn create_folder(&self, path: &Path) -> Result<(), Error> {
        // Locked until the folder is registered, so that `stop` does not miss it.
        let mut created = self.rollback.created();
        if created.stopped {
            return Err(cannot_create(path, ErrorKind::Interrupted.into()));
        }
        match std::fs::create_dir(path) {
            Ok(()) => created.paths.push((self.run, path.to_path_buf())),
            Err(why) if why.kind() == ErrorKind::AlreadyExists && path.is_dir() => {}
            Err(why) => return Err(cannot_create(path, why)),
        }
        Ok(())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if !self.finished {
            self.rollback.created().remove(|run| run == self.run);
        }
    }
}

/// Removes the files of an older manifest that the new one does not list, and the older manifest. Files that no
/// manifest lists stay.
pub(crate) fn clear_older(folder: &Path, manifest: &Manifest) {
    let aside = folder.join(OLD_MANIFEST);
    if let Ok(older) = Manifest::read(&aside) {
        // Errors are ignored: such a file does no harm.
        for name in older.files.keys().filter(|name| !manifest.files.contains_key(*name)) {
            let path = folder.join(name);
            let _ = std::fs::remove_file(&path);
            let folders = path.ancestors().skip(1).take_while(|ancestor| *ancestor != folder);
            folders.for_each(|inner| drop(std::fs::remove_dir(inner)));
        }
    }
    let _ = std::fs::remove_file(aside);
}

fn cannot_create(path: &Path, why: std::io::Error) -> Error {
    Error::Failed(format!("cannot create the folder {}: {why}; choose another with `out`", path.display()))
}

/// Returns the checkpoints in a folder, sorted: files that are called `.holo-<16 hexadecimal digits>.checkpoint`.
pub(crate) fn checkpoints(folder: &Path) -> Vec<PathBuf> {
    let is_checkpoint = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        let digits = name.and_then(|name| name.strip_prefix(CHECKPOINT[0])?.strip_suffix(CHECKPOINT[1]));
        digits.is_some_and(|digits| digits.len() == 16 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_checkpoint).collect();
    found.sort();
    found
}
