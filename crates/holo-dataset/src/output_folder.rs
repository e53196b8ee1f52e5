//! A folder of results: made when it is missing, rolled back if nothing comes of it, sealed by its manifest.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use holo_io::{FileDigest, Manifest, dataset};

use crate::Error;

/// Where an older manifest waits while its folder is written anew.
const OLD_MANIFEST: &str = ".manifest.old.json";

/// What runs have put where nothing was before, so that it can be removed again: by an [`OutputFolder`] that is dropped
/// unfinished, or by a program that is about to end ([`Rollback::stop`]). Clones share the list.
#[derive(Clone, Debug, Default)]
pub struct Rollback(Arc<Mutex<Made>>);

/// Folders, and the files that are or will be in them, inner after outer, each with the number of its run.
#[derive(Debug, Default)]
struct Made {
    paths: Vec<(u64, PathBuf)>,
    runs: u64,
    /// Set when the process is about to end: nothing new is made.
    stopped: bool,
}

impl Rollback {
    /// Removes what unfinished runs have made, and makes nothing more: the process is about to end.
    pub fn stop(&self) {
        let mut made = self.made();
        made.stopped = true;
        made.remove(|_| true);
    }

    fn begin(&self) -> u64 {
        let mut made = self.made();
        made.runs += 1;
        made.runs
    }

    /// The list is sound after every statement, so a panic elsewhere does not spoil it.
    fn made(&self) -> MutexGuard<'_, Made> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Made {
    /// Removes what the runs of these numbers made. Files that were there before, replaced or not, stay, and so do folders
    /// with such files in them.
    fn remove(&mut self, of: impl Fn(u64) -> bool) {
        for (_, path) in self.paths.extract_if(.., |(run, _)| of(*run)).collect::<Vec<_>>().into_iter().rev() {
            // What was never written, or shares its folder with files of others, is no error here.
            let _ = if path.is_dir() { std::fs::remove_dir(&path) } else { std::fs::remove_file(&path) };
        }
    }

    /// Lets what this run made stay, whatever comes.
    fn keep(&mut self, run: u64) {
        self.paths.retain(|(of, _)| *of != run);
    }
}

/// The folder while it is being filled.
pub struct OutputFolder {
    path: PathBuf,
    files: Vec<(String, FileDigest)>,
    finished: bool,
    rollback: Rollback,
    run: u64,
}

impl OutputFolder {
    /// Makes the folder of one render and shows that files can be made in it, before any time is spent on what goes there.
    ///
    /// # Errors
    /// A folder that cannot be made or written to.
    pub fn create(path: &Path, rollback: &Rollback) -> Result<Self, Error> {
        let folder = Self::create_plain(path, rollback)?;
        // Dropped without a commit it leaves nothing.
        holo_io::AtomicFile::create(path.join(dataset::MANIFEST_JSON))?;
        Ok(folder)
    }

    /// Makes the folder and clears away what a run that was killed has left in it.
    ///
    /// # Errors
    /// A folder that cannot be made.
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
            folder.make_folder(ancestor)?;
        }
        if !path.is_dir() {
            return Err(cannot_make(path, ErrorKind::NotADirectory.into()));
        }
        holo_io::remove_stale_temporary_files(path)?;
        Ok(folder)
    }

    /// Lets everything that is in it stay, whatever comes.
    pub fn keep(mut self) {
        self.finished = true;
        self.rollback.made().keep(self.run);
    }

    /// The path of a file that is about to be written; `name` may lead into a subfolder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        let path = self.path.join(name);
        if std::fs::symlink_metadata(&path).is_err() {
            self.rollback.made().paths.push((self.run, path.clone()));
        }
        path
    }

    /// Makes a folder inside.
    ///
    /// # Errors
    /// What the file system says.
    pub fn subfolder(&self, name: &str) -> Result<(), Error> {
        self.make_folder(&self.path.join(name))
    }

    /// An older manifest speaks of files that are about to change: it is put aside until they are written.
    ///
    /// # Errors
    /// What the file system says.
    pub fn unseal(&self) -> Result<(), Error> {
        let path = self.path.join(dataset::MANIFEST_JSON);
        match std::fs::rename(&path, self.path.join(OLD_MANIFEST)) {
            Err(why) if why.kind() != ErrorKind::NotFound => {
                Err(Error::Failed(format!("cannot replace {}: {why}", path.display())))
            }
            _ => Ok(()),
        }
    }

    /// Notes a file that was written.
    pub fn add(&mut self, name: impl Into<String>, written: FileDigest) {
        self.files.push((name.into(), written));
    }

    /// Writes the manifest over all noted files; returns their names and its own.
    ///
    /// # Errors
    /// What the file system says.
    pub fn seal(mut self, mut manifest: Manifest) -> Result<Vec<String>, Error> {
        manifest.files.extend(self.files.drain(..));
        manifest.write(self.file(dataset::MANIFEST_JSON))?;
        self.finished = true;
        self.rollback.made().keep(self.run);
        clear_older(&self.path, &manifest);
        let names = manifest.files.keys().cloned();
        Ok(names.chain([dataset::MANIFEST_JSON.to_string()]).collect())
    }

    /// Makes one folder unless it is there.
    fn make_folder(&self, path: &Path) -> Result<(), Error> {
        // Held meanwhile, so that no folder is made behind the back of a handler that takes them back.
        let mut made = self.rollback.made();
        if made.stopped {
            return Err(cannot_make(path, ErrorKind::Interrupted.into()));
        }
        match std::fs::create_dir(path) {
            Ok(()) => made.paths.push((self.run, path.to_path_buf())),
            Err(why) if why.kind() == ErrorKind::AlreadyExists && path.is_dir() => {}
            Err(why) => return Err(cannot_make(path, why)),
        }
        Ok(())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if !self.finished {
            self.rollback.made().remove(|run| run == self.run);
        }
    }
}

/// Removes what an older render wrote into a folder and this one did not: a folder holds what its manifest says. Files that no
/// manifest speaks of are somebody else's and stay.
pub(crate) fn clear_older(folder: &Path, manifest: &Manifest) {
    let aside = folder.join(OLD_MANIFEST);
    if let Ok(older) = Manifest::read(&aside) {
        // What cannot be removed is in nobody's way.
        for name in older.files.keys().filter(|name| !manifest.files.contains_key(*name)) {
            let path = folder.join(name);
            let _ = std::fs::remove_file(&path);
            let folders = path.ancestors().skip(1).take_while(|ancestor| *ancestor != folder);
            folders.for_each(|inner| drop(std::fs::remove_dir(inner)));
        }
    }
    let _ = std::fs::remove_file(aside);
}

fn cannot_make(path: &Path, why: std::io::Error) -> Error {
    Error::Failed(format!("cannot make the folder {}: {why}; choose another with --out", path.display()))
}
