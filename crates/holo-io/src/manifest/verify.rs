//! Compares a folder with its manifest.

use std::fmt;
use std::path::Path;

use rayon::prelude::*;

use super::Manifest;
use crate::names::stays_inside;
use crate::{Error, FileDigest, Sha256, hash_file};

/// One file that is not as the manifest says.
#[derive(Debug)]
pub struct Mismatch {
    /// The file's name in the manifest.
    pub file: String,
    /// What is wrong with it.
    pub kind: MismatchKind,
}

/// What can be wrong with a file.
#[derive(Debug)]
#[non_exhaustive]
pub enum MismatchKind {
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

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file)?;
        match &self.kind {
            MismatchKind::Missing => write!(f, "missing"),
            MismatchKind::Unreadable(error) => write!(f, "{error}"),
            MismatchKind::Size { expected, found } => write!(f, "{found} bytes, but the manifest says {expected}"),
            MismatchKind::Contents { expected, found } => {
                write!(f, "changed: its SHA-256 is {found}, but the manifest says {expected}")
            }
            MismatchKind::Outside => write!(f, "not a name inside the folder"),
        }
    }
}

pub(super) fn verify(manifest: &Manifest, folder: &Path) -> Vec<Mismatch> {
    // Collecting keeps the order of the names, whichever file is done first.
    let files: Vec<(&String, &FileDigest)> = manifest.files.iter().collect();
    files
        .into_par_iter()
        .filter_map(|(name, expected)| {
            problem(name, expected, folder).map(|kind| Mismatch { file: name.clone(), kind })
        })
        .collect()
}

fn problem(name: &str, expected: &FileDigest, folder: &Path) -> Option<MismatchKind> {
    if !stays_inside(name) {
        return Some(MismatchKind::Outside);
    }
    let path = folder.join(name);
    match std::fs::metadata(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Some(MismatchKind::Missing),
        Err(error) => return Some(MismatchKind::Unreadable(Error::io("read", &path, error))),
        // A folder or a device of that name would be read without end, or not at all.
        Ok(found) if !found.is_file() => return Some(MismatchKind::Missing),
        Ok(found) if found.len() != expected.bytes => {
            return Some(MismatchKind::Size { expected: expected.bytes, found: found.len() });
        }
        Ok(_) => {}
    }
    match hash_file(&path) {
        Err(error) => Some(MismatchKind::Unreadable(error)),
        Ok(found) if found.bytes != expected.bytes => {
            Some(MismatchKind::Size { expected: expected.bytes, found: found.bytes })
        }
        Ok(found) if found.sha256 != expected.sha256 => {
            Some(MismatchKind::Contents { expected: expected.sha256, found: found.sha256 })
        }
        Ok(_) => None,
    }
}
