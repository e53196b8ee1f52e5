//! What became of a job in a folder, and whether it is done already.

use std::path::Path;

use holo_io::{Manifest, dataset};

use crate::checkpoint;
use crate::identity::difference;
use crate::output_folder::clear_older;
use crate::report::RenderReport;

/// The outcome of a job that reports `R`.
#[derive(Clone, Debug)]
pub enum JobOutcome<R = RenderReport> {
    /// It was rendered; the reason if its folder contained an older result.
    Made(Box<R>, Option<String>),
    /// Its folder is up to date.
    Kept(Box<Manifest>),
}

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
    checkpoint::remove_all(folder);
    Ok(manifest)
}
