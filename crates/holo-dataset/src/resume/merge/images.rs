//! Shards of the images of pinhole cameras: every N-th image, as it is.

use super::Parts;
use crate::Error;
use crate::output::OutputFolder;

/// The key in the settings of a manifest that counts the cameras.
const CAMERAS: &str = "cameras";

/// Whether the shards are of pinhole cameras.
pub(super) fn is_images(parts: &Parts) -> bool {
    parts.manifest.settings.contains_key(CAMERAS)
}

/// Copies the files of all shards into one folder.
pub(super) fn merge(parts: &Parts, mut folder: OutputFolder) -> Result<Vec<String>, Error> {
    folder.unseal()?;
    for part in &parts.parts {
        for (name, digest) in &part.manifest.files {
            if let Some((inner, _)) = name.rsplit_once('/') {
                folder.subfolder(inner)?;
            }
            let from = part.folder.path_of(name);
            let bytes = part.folder.read(name, digest.bytes)?;
            let written = holo_io::write_file(folder.file(name), &bytes)?;
            if written != *digest {
                return Err(Error::Failed(format!("{}: it changed while it was read", from.display())));
            }
            folder.add(name.clone(), written);
        }
    }
    folder.seal(parts.manifest.clone())
}
