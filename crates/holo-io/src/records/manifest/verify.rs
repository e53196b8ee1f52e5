//! Compares a folder with its manifest.

use std::fmt;
use std::io;

use rayon::prelude::*;

use super::Manifest;
use crate::files::folder::{EntryKind, Folder};
use crate::files::names::stays_inside;
use crate::{Error, FileDigest, Sha256};

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
        write!(f, "{}: ", crate::shown(&self.file))?;
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

pub(super) fn verify(manifest: &Manifest, folder: &Folder) -> Vec<Mismatch> {
    // Collecting keeps the order of the names, whatever the timing of the threads.
    let files: Vec<(&String, &FileDigest)> = manifest.files.iter().collect();
    files
        .into_par_iter()
        .filter_map(|(name, expected)| {
            difference(name, expected, folder).map(|kind| Mismatch { file: name.clone(), kind })
        })
        .collect()
}

/// The files of a folder that cannot be opened.
pub(super) fn missing(manifest: &Manifest, error: &Error) -> Vec<Mismatch> {
    let kind = || match error {
        Error::Io { error, .. } if error.kind() == io::ErrorKind::NotFound => MismatchKind::Missing,
        other => MismatchKind::Unreadable(Error::io("open", other.path(), io::Error::other(other.to_string()))),
    };
    manifest.files.keys().map(|name| Mismatch { file: name.clone(), kind: kind() }).collect()
}

fn difference(name: &str, expected: &FileDigest, folder: &Folder) -> Option<MismatchKind> {
    if !stays_inside(name) {
        return Some(MismatchKind::Outside);
    }
    match folder.kind(name) {
        Ok(Some(EntryKind::File | EntryKind::Link)) => {}
        Ok(_) => return Some(MismatchKind::Missing),
        Err(error) => return Some(MismatchKind::Unreadable(error)),
    }
    match folder.digest(name, expected.bytes) {
        Ok(found) if found.bytes != expected.bytes => {
            Some(MismatchKind::Size { expected: expected.bytes, found: found.bytes })
        }
        Ok(found) if found.sha256 != expected.sha256 => {
            Some(MismatchKind::Contents { expected: expected.sha256, found: found.sha256 })
        }
        Ok(_) => None,
        Err(Error::TooLarge { needed, .. }) => Some(MismatchKind::Size { expected: expected.bytes, found: needed }),
        Err(Error::Io { error, .. }) if error.kind() == io::ErrorKind::NotFound => Some(MismatchKind::Missing),
        Err(error) => Some(MismatchKind::Unreadable(error)),
    }
}
