//! A folder of results: made when it is missing, taken back if nothing comes of it, sealed by its manifest.

use std::path::{Path, PathBuf};

use holo_io::{Manifest, Written, dataset};

use crate::failure::Failure;

/// The folder while it is being filled.
pub struct OutputFolder {
    path: PathBuf,
    /// Folders that did not exist before, deepest first.
    made: Vec<PathBuf>,
    files: Vec<(String, Written)>,
    finished: bool,
}

impl OutputFolder {
    /// Makes the folder and shows that files can be made in it, before any time is spent on what goes there.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let failed = |at: &Path, why: std::io::Error| {
            Failure::Failed(format!("cannot make the folder {}: {why}; choose another with --out", at.display()))
        };
        let mut folder = Self { path: path.to_path_buf(), made: Vec::new(), files: Vec::new(), finished: false };
        let missing: Vec<&Path> = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).collect();
        for ancestor in missing.into_iter().rev() {
            match std::fs::create_dir(ancestor) {
                Ok(()) => folder.made.insert(0, ancestor.to_path_buf()),
                Err(why) if why.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(why) => return Err(failed(ancestor, why)),
            }
        }
        if !path.is_dir() {
            return Err(failed(path, std::io::ErrorKind::NotADirectory.into()));
        }
        holo_io::remove_stale_temporary_files(path)?;
        // Dropped without a commit it leaves nothing.
        holo_io::AtomicFile::create(path.join(dataset::MANIFEST_JSON))?;
        Ok(folder)
    }

    /// The path of a file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// A folder inside, made now.
    pub fn subfolder(&mut self, name: &str) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        match std::fs::create_dir(&path) {
            Ok(()) => self.made.insert(0, path.clone()),
            Err(why) if why.kind() == std::io::ErrorKind::AlreadyExists && path.is_dir() => {}
            Err(why) => return Err(Failure::Failed(format!("cannot make the folder {}: {why}", path.display()))),
        }
        Ok(path)
    }

    /// An older manifest speaks of files that are about to change.
    pub fn unseal(&self) -> Result<(), Failure> {
        let path = self.file(dataset::MANIFEST_JSON);
        match std::fs::remove_file(&path) {
            Err(why) if why.kind() != std::io::ErrorKind::NotFound => {
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
        let names = manifest.files.keys().cloned();
        Ok(names.chain([dataset::MANIFEST_JSON.to_string()]).collect())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if !self.finished {
            // Only folders that are still empty go: whole files that were written stay.
            for folder in &self.made {
                let _ = std::fs::remove_dir(folder);
            }
        }
    }
}
