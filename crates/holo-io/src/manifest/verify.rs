//! Compares a folder with its manifest.

use std::fmt;
use std::path::Path;

use rayon::prelude::*;

use super::Manifest;
use crate::names::stays_inside;
use crate::{Error, FileDigest, Sha256, hash_file};

/// A file that differs from its entry in the manifest.
#[derive(Debug)]
pub struct Mismatch {
    /// Name of the file in the manifest.
    pub file: String,
    /// The difference.
    pub kind: MismatchKind,
}

/// How a file differs from its entry in the manifest.
#[derive(Debug)]
#[non_exhaustive]
pub enum MismatchKind {
    /// It does not exist.
    Missing,
    /// It cannot be read.
    Unreadable(Error),
    /// It has another size.
    Size {
        /// Size in the manifest, bytes.
        expected: u64,
        /// Size of the file, bytes.
        found: u64,
    },
    /// It has the same size and other contents.
    Contents {
        /// Digest in the manifest.
        expected: Sha256,
        /// Digest of the file.
        found: Sha256,
    },
    /// Its name leads outside the folder; the file is not read.
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
    // Collecting keeps the order of the names, whatever the timing of the threads.
    let files: Vec<(&String, &FileDigest)> = manifest.files.iter().collect();
    files
        .into_par_iter()
        .filter_map(|(name, expected)| {
            difference(name, expected, folder).map(|kind| Mismatch { file: name.clone(), kind })
        })
        .collect()
}

fn difference(name: &str, expected: &FileDigest, folder: &Path) -> Option<MismatchKind> {
    if !stays_inside(name) {
        return Some(MismatchKind::Outside);
    }
    let path = folder.join(name);
    match std::fs::metadata(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Some(MismatchKind::Missing),
        Err(error) => return Some(MismatchKind::Unreadable(Error::io("read", &path, error))),
        // Reading a device may not end, and a folder cannot be read.
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
