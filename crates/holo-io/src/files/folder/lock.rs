//! The lock of an output folder: one process writes in it.
//!
//! The lock is the kernel's, on the file `.holo.lock`, which names host and process for the message of whoever comes
//! second. When a process ends, however it does, its lock is gone, and the file that a killed one left means nothing. Only
//! where a file system has no locks does the file itself count.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, Write};

use super::Folder;
use crate::Error;

/// The name of the file.
const NAME: &str = ".holo.lock";

/// The first line of the file.
const MAGIC: &str = "holo lock";

/// No such file is longer.
const MAX_BYTES: u64 = 1024;

/// The lock of a folder, which is released when it is dropped.
#[derive(Debug)]
pub struct FolderLock {
    folder: Folder,
    file: File,
}

impl FolderLock {
    /// The name of its file, which is removed with the lock.
    pub const FILE: &str = NAME;
}

impl Folder {
    /// Takes the lock of the folder, without waiting. Where the file system has no locks, the file of another process
    /// counts as one, unless `ignores_files` says that it may be left from a process that has ended.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if another process has the lock, with its host and number; if the file cannot be written, or is
    /// something else.
    pub fn lock(&self, ignores_files: bool) -> Result<FolderLock, Error> {
        loop {
            let mut file = self.open_own(NAME, true)?;
            let holder = self.holder(&mut file)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(self.in_use(holder.as_deref(), "wait for it to end")),
                Err(TryLockError::Error(_)) if holder.is_none() || ignores_files => {}
                Err(TryLockError::Error(_)) => {
                    let advice = "this file system has no locks, so if that process has ended, remove its .holo.lock or give `overwrite`";
                    return Err(self.in_use(holder.as_deref(), advice));
                }
            }
            // Its holder may have removed the file after it was opened here: then the lock is of no name.
            let failed = |error| Error::io("write", &self.path_of(NAME), error);
            if self.is_same(NAME, &file).map_err(failed)? {
                write_holder(&mut file).map_err(failed)?;
                return Ok(FolderLock { folder: self.clone(), file });
            }
        }
    }

    /// Who has written the file, if somebody has.
    fn holder(&self, file: &mut File) -> Result<Option<String>, Error> {
        let mut text = Vec::new();
        if file.take(MAX_BYTES).read_to_end(&mut text).is_err() {
            // Where locks forbid reading too.
            return Ok(Some("another process".to_owned()));
        }
        let text = String::from_utf8_lossy(&text);
        let mut lines = text.lines();
        match lines.next() {
            None => Ok(None),
            Some(MAGIC) => {
                let mut value = |key: &str| {
                    let value = lines.next().and_then(|line| line.strip_prefix(key)).unwrap_or("?");
                    crate::shown(value).into_owned()
                };
                let (host, process) = (value("host "), value("process "));
                Ok(Some(format!("process {process} on {host}")))
            }
            Some(_) => {
                let what = "it is no lock of this program; remove it or choose another folder";
                Err(Error::io("lock", &self.path_of(NAME), io::Error::other(what)))
            }
        }
    }

    fn in_use(&self, holder: Option<&str>, advice: &str) -> Error {
        let holder = holder.unwrap_or("another process");
        let what = format!("{holder} is writing in it; {advice}, or choose another folder");
        Error::io("lock", self.path(), io::Error::other(what))
    }
}

fn write_holder(file: &mut File) -> io::Result<()> {
    let text = format!("{MAGIC}\nhost {}\nprocess {}\n", host(), std::process::id());
    file.set_len(0)?;
    file.rewind()?;
    file.write_all(text.as_bytes())
}

/// The name of this machine.
fn host() -> String {
    #[cfg(unix)]
    let name = rustix::system::uname().nodename().to_string_lossy().into_owned();
    #[cfg(not(unix))]
    let name = std::env::var("COMPUTERNAME").unwrap_or_else(|_| "?".to_owned());
    name
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Not the file of a process that has taken the lock since this one's file was removed.
        if self.folder.is_same(NAME, &self.file).unwrap_or(false) {
            // A file that stays does no harm.
            let _ = self.folder.remove_file(NAME);
        }
    }
}
