//! `holo verify`: a dataset, or one folder of it, against what its files say of one another.

use std::path::Path;

use holo_io::dataset::{self, Description};
use holo_io::{Manifest, Setting};

use crate::arguments::VerifyOptions;
use crate::console::out;
use crate::failure::Failure;

pub fn run(options: &VerifyOptions) -> Result<(), Failure> {
    let folder = &options.folder;
    if folder.join(dataset::DATASET_JSON).is_file() {
        return verify_all(folder);
    }
    let manifest = Manifest::read(folder.join(dataset::MANIFEST_JSON))?;
    let problems = manifest.verify(folder);
    if problems.is_empty() {
        out!("{} files are as their manifest says", manifest.files.len())?;
        return Ok(());
    }
    for problem in &problems {
        out!("{problem}")?;
    }
    let (wrong, all) = (problems.len(), manifest.files.len());
    Err(Failure::Failed(format!("{wrong} of {all} files are not as their manifest says; render them again")))
}

/// Every folder that the description speaks of, and nothing else.
fn verify_all(root: &Path) -> Result<(), Failure> {
    let description = Description::read(root)?;
    let folders = description.folders()?;
    let (mut bad, mut files, mut bytes) = (0, 0, 0);
    for name in &folders {
        let problems = match Manifest::read(root.join(name).join(dataset::MANIFEST_JSON)) {
            Ok(manifest) => {
                files += manifest.files.len();
                bytes += manifest.files.values().map(|written| written.bytes).sum::<u64>();
                let mut problems: Vec<String> =
                    manifest.verify(root.join(name)).iter().map(ToString::to_string).collect();
                problems.extend(other_than(&description, &manifest, name));
                problems
            }
            Err(error) => vec![error.to_string()],
        };
        bad += usize::from(!problems.is_empty());
        for problem in problems {
            out!("{}: {problem}", name.display())?;
        }
    }
    for entry in dataset::list(root)? {
        let name = dataset::folder(&entry.scene, entry.views)?;
        if !folders.contains(&name) {
            out!("{}: note: not part of this dataset by its {}", name.display(), dataset::DATASET_JSON)?;
        }
    }
    if bad > 0 {
        return Err(Failure::Failed(format!(
            "{bad} of {} folders are missing or not as they should be; `holo dataset` with the same options makes them",
            folders.len()
        )));
    }
    out!("{} folders with {files} files, {:.1} GB, are as they should be", folders.len(), bytes as f64 / 1e9)?;
    Ok(())
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
