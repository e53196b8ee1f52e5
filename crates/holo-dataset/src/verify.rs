//! A dataset, or one folder of it, against what its files say of one another.

use std::path::{Path, PathBuf};

use holo_io::dataset::{self, Description};
use holo_io::{Manifest, Setting};

use crate::Error;

/// What [`verify`] found.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Verification {
    /// Folders that were looked at, and those of them with a mismatch.
    pub folders: usize,
    /// Folders that are missing or not as they should be.
    pub bad_folders: usize,
    /// Files in all manifests.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// What is wrong, a line each; of a dataset with the folder relative to its root in front.
    pub mismatches: Vec<String>,
    /// What is worth knowing and no error, a line each.
    pub notes: Vec<String>,
}

/// Whether a folder is a dataset: whether it has a `dataset.json`.
#[must_use]
pub fn is_dataset(folder: &Path) -> bool {
    folder.join(dataset::DATASET_JSON).is_file()
}

/// Checks every file of a folder that `holo render` wrote, or of all folders of a dataset, by its digest.
///
/// # Errors
/// A manifest or description that cannot be read; of a dataset, a folder's manifest that cannot be read is a mismatch.
pub fn verify(folder: &Path) -> Result<Verification, Error> {
    if is_dataset(folder) {
        return verify_all(folder);
    }
    let manifest = Manifest::read(folder.join(dataset::MANIFEST_JSON))?;
    let mismatches: Vec<String> = manifest.verify(folder).iter().map(ToString::to_string).collect();
    Ok(Verification {
        folders: 1,
        bad_folders: usize::from(!mismatches.is_empty()),
        files: manifest.files.len(),
        bytes: bytes(&manifest),
        mismatches,
        notes: Vec::new(),
    })
}

/// Every folder that the description names, and nothing else.
fn verify_all(root: &Path) -> Result<Verification, Error> {
    let description = Description::read(root)?;
    let folders = description.folders()?;
    let mut found = Verification { folders: folders.len(), ..Verification::default() };
    for name in &folders {
        let mismatches = match Manifest::read(root.join(name).join(dataset::MANIFEST_JSON)) {
            Ok(manifest) => {
                found.files += manifest.files.len();
                found.bytes += bytes(&manifest);
                let mut mismatches: Vec<String> =
                    manifest.verify(root.join(name)).iter().map(ToString::to_string).collect();
                mismatches.extend(other_than(&description, &manifest, name));
                mismatches
            }
            Err(error) => vec![error.to_string()],
        };
        found.bad_folders += usize::from(!mismatches.is_empty());
        found.mismatches.extend(mismatches.into_iter().map(|mismatch| format!("{}: {mismatch}", name.display())));
    }
    for entry in dataset::list(root)? {
        let name: PathBuf = dataset::folder(&entry.scene, entry.views)?;
        if !folders.contains(&name) {
            let line = format!("{}: note: not part of this dataset by its {}", name.display(), dataset::DATASET_JSON);
            found.notes.push(line);
        }
    }
    Ok(found)
}

fn bytes(manifest: &Manifest) -> u64 {
    manifest.files.values().map(|written| written.bytes).sum()
}

/// What a manifest says otherwise than the description of the whole.
fn other_than(description: &Description, manifest: &Manifest, folder: &Path) -> Vec<String> {
    let mut problems = Vec::new();
    if manifest.versions != description.versions {
        problems.push(format!("made by {:?}, the dataset by {:?}", manifest.versions, description.versions));
    }
    let scene = description.scenes.iter().find(|scene| folder.starts_with(&scene.name));
    let digest = manifest.settings.get("scene_sha256").and_then(Setting::as_text);
    if scene.is_some_and(|scene| digest != Some(&scene.sha256)) {
        problems.push("made from another scene of this name".into());
    }
    if let Some(Setting::Table(options)) = manifest.settings.get("options") {
        for (name, value) in &description.options {
            let own = options.get(name).and_then(Setting::as_text);
            if own != Some(value) {
                problems.push(format!("made with --{name}={}, the dataset with {value}", own.unwrap_or("?")));
            }
        }
    }
    problems
}
