//! Whether a folder is up to date.

use std::path::Path;

use holo_io::{Manifest, dataset};

use super::identity::difference;
use crate::output::{checkpoints, clear_older};

/// Returns the manifest of a job that is done: with the same scene, options and versions, and with every file as its
/// digest. The error is why an older result is not up to date, if there is one.
pub(crate) fn done(folder: &Path, identity: &Manifest) -> Result<Manifest, Option<String>> {
    let path = folder.join(dataset::MANIFEST_JSON);
    let manifest = match Manifest::read(&path) {
        Ok(manifest) => manifest,
        Err(_) if !path.is_file() => return Err(None),
        Err(why) => return Err(Some(why.to_string())),
    };
    if let Some(why) = difference(&manifest, identity) {
        return Err(Some(why));
    }
    if let Some(mismatch) = manifest.verify(folder).first() {
        return Err(Some(mismatch.to_string()));
    }
    // A run may have been killed before these last steps.
    clear_older(folder, &manifest);
    checkpoints(folder).iter().for_each(|path| drop(std::fs::remove_file(path)));
    Ok(manifest)
}
