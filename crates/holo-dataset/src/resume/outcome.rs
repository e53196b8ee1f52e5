//! Whether a folder is up to date.

use std::path::Path;

use holo_io::{EntryKind, FolderLock, Manifest, dataset};

use super::identity::difference;
use crate::output::{existing, remove_checkpoints};

/// Returns the manifest of a job that is done in the folder `inner` below `root`: with the same scene, options and versions,
/// and with every file as its digest. The error is why an older result is not up to date, if there is one.
pub(crate) fn done(root: &Path, inner: &str, identity: &Manifest) -> Result<Manifest, Option<String>> {
    let folder = match existing(root, inner) {
        Ok(Some(folder)) => folder,
        Ok(None) => return Err(None),
        Err(why) => return Err(Some(why.to_string())),
    };
    let manifest = match Manifest::read_in(&folder) {
        Ok(manifest) => manifest,
        Err(_) if !matches!(folder.kind(dataset::MANIFEST_JSON), Ok(Some(EntryKind::File))) => return Err(None),
        Err(why) => return Err(Some(why.to_string())),
    };
    if let Some(why) = difference(&manifest, identity) {
        return Err(Some(why));
    }
    if let Some(mismatch) = manifest.verify_in(&folder).first() {
        return Err(Some(mismatch.to_string()));
    }
    // A run may have been killed before these last steps.
    remove_checkpoints(&folder);
    if folder.has_file(FolderLock::FILE) {
        // Taken and given back, which removes its file.
        drop(folder.lock(false));
    }
    Ok(manifest)
}
