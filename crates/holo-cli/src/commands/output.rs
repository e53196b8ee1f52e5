//! A folder of results: made when it is missing, taken back if nothing comes of it, sealed by its manifest.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use holo_io::{Manifest, Written, dataset};

use crate::failure::Failure;

/// What the run has put where nothing was before: folders, and the files that are or will be in them, inner after
/// outer. It is for the whole process, because a signal handler must reach it.
struct Made {
    paths: Vec<PathBuf>,
    /// Set when the process is about to end: nothing new is made.
    stopped: bool,
}

/// Where an older manifest waits while its folder is written anew.
const OLD_MANIFEST: &str = ".manifest.old.json";

static MADE: Mutex<Made> = Mutex::new(Made { paths: Vec::new(), stopped: false });

/// The list is sound after every statement, so a panic elsewhere does not spoil it.
fn made() -> MutexGuard<'static, Made> {
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what an unfinished run has made, and makes nothing more: the process is about to end.
pub fn take_back() {
    let mut made = made();
    made.stopped = true;
    remove(&mut made);
}

/// Removes what was made. Files that were there before, replaced or not, stay, and so do folders with such files in them.
fn remove(made: &mut Made) {
    for path in made.paths.drain(..).rev() {
        // What was never written, or shares its folder with files of others, is no error here.
        let _ = if path.is_dir() { std::fs::remove_dir(&path) } else { std::fs::remove_file(&path) };
    }
}

/// The folder while it is being filled.
pub struct OutputFolder {
    path: PathBuf,
    files: Vec<(String, Written)>,
    finished: bool,
}

impl OutputFolder {
    /// Makes the folder of one render and shows that files can be made in it, before any time is spent on what goes there.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let folder = Self::create_plain(path)?;
        // Dropped without a commit it leaves nothing.
        holo_io::AtomicFile::create(path.join(dataset::MANIFEST_JSON))?;
        Ok(folder)
    }

    /// Makes the folder and clears away what a run that was killed has left in it.
    pub fn create_plain(path: &Path) -> Result<Self, Failure> {
        let folder = Self { path: path.to_path_buf(), files: Vec::new(), finished: false };
        let missing: Vec<&Path> = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).collect();
        for ancestor in missing.into_iter().rev() {
            make_folder(ancestor)?;
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
        made().paths.clear();
    }

    /// The path of a file that is about to be written; `name` may lead into a subfolder.
    pub fn file(&self, name: &str) -> PathBuf {
        let path = self.path.join(name);
        if std::fs::symlink_metadata(&path).is_err() {
            made().paths.push(path.clone());
        }
        path
    }

    /// Makes a folder inside.
    pub fn subfolder(&self, name: &str) -> Result<(), Failure> {
        make_folder(&self.path.join(name))
    }

    /// An older manifest speaks of files that are about to change: it is put aside until they are written.
    pub fn unseal(&self) -> Result<(), Failure> {
        let path = self.path.join(dataset::MANIFEST_JSON);
        match std::fs::rename(&path, self.path.join(OLD_MANIFEST)) {
            Err(why) if why.kind() != ErrorKind::NotFound => {
                Err(Failure::Failed(format!("cannot replace {}: {why}", path.display())))
            }
            _ => Ok(()),
        }
    }

    /// Notes a file that was written.
    pub fn add(&mut self, name: impl Into<String>, written: Written) {
        self.files.push((name.into(), written));
    }

    /// Writes the manifest over all noted files; returns their names and its own.
    pub fn seal(mut self, mut manifest: Manifest) -> Result<Vec<String>, Failure> {
        manifest.files.extend(self.files.drain(..));
        manifest.write(self.file(dataset::MANIFEST_JSON))?;
        self.finished = true;
        made().paths.clear();
        clear_older(&self.path, &manifest);
        let names = manifest.files.keys().cloned();
        Ok(names.chain([dataset::MANIFEST_JSON.to_string()]).collect())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if !self.finished {
            remove(&mut made());
        }
    }
}

/// Removes what an older render wrote into a folder and this one did not: a folder holds what its manifest says. Files that no
/// manifest speaks of are somebody else's and stay.
pub fn clear_older(folder: &Path, manifest: &Manifest) {
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

/// Makes one folder unless it is there.
fn make_folder(path: &Path) -> Result<(), Failure> {
    // Held meanwhile, so that no folder is made behind the back of a handler that takes them back.
    let mut made = made();
    if made.stopped {
        return Err(cannot_make(path, ErrorKind::Interrupted.into()));
    }
    match std::fs::create_dir(path) {
        Ok(()) => made.paths.push(path.to_path_buf()),
        Err(why) if why.kind() == ErrorKind::AlreadyExists && path.is_dir() => {}
        Err(why) => return Err(cannot_make(path, why)),
    }
    Ok(())
}

fn cannot_make(path: &Path, why: std::io::Error) -> Failure {
    Failure::Failed(format!("cannot make the folder {}: {why}; choose another with --out", path.display()))
}
