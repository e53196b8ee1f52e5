//! Compares a folder with its manifest.

use std::fmt;
use std::path::Path;

use rayon::prelude::*;

use super::Manifest;
use crate::names::stays_inside;
use crate::{Error, Sha256, Written, hash_file};

/// One file that is not as the manifest says.
#[derive(Debug)]
pub struct Problem {
    /// The file's name in the manifest.
    pub file: String,
    /// What is wrong with it.
    pub kind: ProblemKind,
}

/// What can be wrong with a file.
#[derive(Debug)]
#[non_exhaustive]
pub enum ProblemKind {
    /// It is not there.
    Missing,
    /// It cannot be read.
    Unreadable(Error),
    /// It has another size.
    Size {
        /// Bytes by the manifest.
        expected: u64,
        /// Bytes in the folder.
        found: u64,
    },
    /// It has the right size and other contents.
    Contents {
        /// Digest by the manifest.
        expected: Sha256,
        /// Digest in the folder.
        found: Sha256,
    },
    /// The manifest names a file outside its folder, which is not looked at.
    Outside,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file)?;
        match &self.kind {
            ProblemKind::Missing => write!(f, "missing"),
            ProblemKind::Unreadable(error) => write!(f, "{error}"),
            ProblemKind::Size { expected, found } => write!(f, "{found} bytes, but the manifest says {expected}"),
            ProblemKind::Contents { expected, found } => {
                write!(f, "changed: its SHA-256 is {found}, but the manifest says {expected}")
            }
            ProblemKind::Outside => write!(f, "not a name inside the folder"),
        }
    }
}

pub(super) fn verify(manifest: &Manifest, folder: &Path) -> Vec<Problem> {
    // Collecting keeps the order of the names, whichever file is done first.
    let files: Vec<(&String, &Written)> = manifest.files.iter().collect();
    files
        .into_par_iter()
        .filter_map(|(name, expected)| problem(name, expected, folder).map(|kind| Problem { file: name.clone(), kind }))
        .collect()
}

fn problem(name: &str, expected: &Written, folder: &Path) -> Option<ProblemKind> {
    if !stays_inside(name) {
        return Some(ProblemKind::Outside);
    }
    let path = folder.join(name);
    match std::fs::metadata(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Some(ProblemKind::Missing),
        Err(error) => return Some(ProblemKind::Unreadable(Error::io("read", &path, error))),
        // A folder or a device of that name would be read without end, or not at all.
        Ok(found) if !found.is_file() => return Some(ProblemKind::Missing),
        Ok(found) if found.len() != expected.bytes => {
            return Some(ProblemKind::Size { expected: expected.bytes, found: found.len() });
        }
        Ok(_) => {}
    }
    match hash_file(&path) {
        Err(error) => Some(ProblemKind::Unreadable(error)),
        Ok(found) if found.bytes != expected.bytes => {
            Some(ProblemKind::Size { expected: expected.bytes, found: found.bytes })
        }
        Ok(found) if found.sha256 != expected.sha256 => {
            Some(ProblemKind::Contents { expected: expected.sha256, found: found.sha256 })
        }
        Ok(_) => None,
    }
}
