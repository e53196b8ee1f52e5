//! Verification of a dataset, a sequence, or one of their folders, against the digests in its files.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use holo_io::dataset::{self, DatasetCamera, DatasetIndex, SequenceFolder};
use holo_io::{CameraArray, Folder, Manifest, ManifestValue, WorldUp};

use crate::Error;
use crate::output::{TRANSFORMS, inner_name};
use crate::resume::finished_manifest;
use crate::settings::{Frames, SettingType, value_text};

/// The most frames of one range that are looked for: eleven hours of video. A damaged manifest may name billions.
const MAX_FRAMES: usize = 1_000_000;

/// The result of [`verify`].
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Verification {
    /// Number of folders that were checked.
    pub folders: usize,
    /// Number of folders that are missing or have a mismatch.
    pub bad_folders: usize,
    /// Number of files in all manifests.
    pub files: usize,
    /// Total size of these files by the manifests, bytes.
    pub bytes: u64,
    /// Mismatches, a line each; of a dataset with the folder relative to its root in front.
    pub mismatches: Vec<String>,
    /// Observations that are no errors, a line each.
    pub notes: Vec<String>,
}

/// Returns whether a folder is a dataset: whether it has a `dataset.json`.
#[must_use]
pub fn is_dataset(folder: &Path) -> bool {
    Folder::open(folder).is_ok_and(|folder| folder.has_file(dataset::DATASET_JSON))
}

/// Compares every file of a folder of `holo render`, or of all folders of a dataset, a sequence or several poses, with its
/// digest.
///
/// # Errors
/// [`Error::Io`] if `manifest.json` or `dataset.json` cannot be read; [`Error::Failed`] for an unfinished render. In a dataset or a
/// sequence, a manifest that cannot be read is a mismatch.
pub fn verify(folder: &Path) -> Result<Verification, Error> {
    if is_dataset(folder) {
        return verify_all(folder);
    }
    let root = Folder::open(folder)?;
    if root.kind(dataset::MANIFEST_JSON)?.is_none() {
        let shots = shots_of(folder)?;
        if !shots.is_empty() {
            return Ok(verify_folders(&root, &shots, |_, _| Vec::new()));
        }
    }
    let manifest = finished_manifest(&root)?;
    let mismatches: Vec<String> = manifest.verify_in(&root).iter().map(ToString::to_string).collect();
    Ok(Verification {
        folders: 1,
        bad_folders: usize::from(!mismatches.is_empty()),
        files: manifest.files.len(),
        bytes: bytes(&manifest),
        mismatches,
        notes: Vec::new(),
    })
}

/// Checks every folder that `dataset.json` contains.
fn verify_all(root: &Path) -> Result<Verification, Error> {
    let index = DatasetIndex::read(root)?;
    let folders = index.folders()?;
    let opened = Folder::open(root)?;
    let mut found = verify_folders(&opened, &folders, |manifest, name| differences(&index, manifest, name));
    for entry in dataset::list(root)? {
        let name: PathBuf = [entry.scene, entry.camera].iter().collect();
        if !folders.contains(&name) {
            let line = format!("{}: note: not part of this dataset by its {}", name.display(), dataset::DATASET_JSON);
            found.notes.push(line);
        }
    }
    Ok(found)
}

/// The folders of the poses and frames that a folder without a manifest should have, relative to it; none if it has
/// neither.
pub(crate) fn shots_of(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let opened = Folder::open(folder)?;
    if opened.kind(TRANSFORMS)?.is_none() {
        return frames_in(folder);
    }
    // Which axis is up does not matter for names.
    let array = CameraArray::read_in(&opened, TRANSFORMS, WorldUp::default(), None)?;
    let mut shots = Vec::new();
    for pose in array.cameras.iter().map(|camera| Path::new(&camera.name)) {
        let frames = frames_in(&folder.join(pose))?;
        match frames.is_empty() {
            true => shots.push(pose.to_owned()),
            false => shots.extend(frames.into_iter().map(|frame| pose.join(frame))),
        }
    }
    Ok(shots)
}

/// The folders of the frames that a folder should have, relative to it.
fn frames_in(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    if folder.join(dataset::MANIFEST_JSON).exists() || !folder.is_dir() {
        return Ok(Vec::new());
    }
    let sequence = SequenceFolder::open(folder)?;
    if sequence.frames().is_empty() {
        return Ok(Vec::new());
    }
    Ok(frames_of(&sequence).into_iter().map(|frame| SequenceFolder::frame_name(frame).into()).collect())
}

/// The frames that a sequence should have: those that are there, and all of the ranges that they were rendered with.
fn frames_of(sequence: &SequenceFolder) -> BTreeSet<u32> {
    let mut frames: BTreeSet<u32> = sequence.frames().iter().copied().collect();
    for &frame in sequence.frames() {
        let Ok(manifest) = Manifest::read(sequence.frame_path(frame).join(dataset::MANIFEST_JSON)) else { continue };
        let Some(ManifestValue::Table(options)) = manifest.settings.get("options") else { continue };
        let range = options.get("frame").and_then(value_text);
        if let Some(range) = range.and_then(|text| Frames::parse(&text).ok()) {
            frames.extend((range.first..=range.last).take(MAX_FRAMES));
        }
    }
    frames
}

/// Checks folders below `root`, with what else is wrong with a manifest.
fn verify_folders(
    root: &Folder,
    folders: &[PathBuf],
    differences: impl Fn(&Manifest, &Path) -> Vec<String>,
) -> Verification {
    let mut found = Verification { folders: folders.len(), ..Verification::default() };
    for name in folders {
        let folder = inner_name(name).and_then(|inner| Ok(root.sub(&inner)?));
        let found_there = folder.and_then(|folder| Ok((finished_manifest(&folder)?, folder)));
        let mismatches = match found_there {
            Ok((manifest, folder)) => {
                found.files += manifest.files.len();
                found.bytes += bytes(&manifest);
                let mut mismatches: Vec<String> = manifest.verify_in(&folder).iter().map(ToString::to_string).collect();
                mismatches.extend(differences(&manifest, name));
                mismatches
            }
            Err(error) => vec![error.to_string()],
        };
        found.bad_folders += usize::from(!mismatches.is_empty());
        found.mismatches.extend(mismatches.into_iter().map(|mismatch| format!("{}: {mismatch}", name.display())));
    }
    found
}

fn bytes(manifest: &Manifest) -> u64 {
    manifest.files.values().map(|written| written.bytes).sum()
}

/// The differences between a manifest and `dataset.json`.
pub(crate) fn differences(index: &DatasetIndex, manifest: &Manifest, folder: &Path) -> Vec<String> {
    let mut differences = Vec::new();
    if manifest.versions != index.versions {
        differences.push(format!("made by {:?}, the dataset by {:?}", manifest.versions, index.versions));
    }
    let digest = |key: &str| manifest.settings.get(key).and_then(ManifestValue::as_text);
    let scene = index.scenes.iter().find(|scene| folder.starts_with(&scene.name));
    if scene.is_some_and(|scene| digest("scene_sha256") != Some(&scene.sha256)) {
        differences.push("made from another scene of this name".into());
    }
    let camera = index.cameras.iter().find(|camera| folder.ends_with(camera.name()));
    if let Some(DatasetCamera::Plenoptic { name, sha256, .. }) = camera {
        let own = scene.and_then(|scene| scene.cameras.get(name));
        if digest("camera_sha256") != Some(own.unwrap_or(sha256).as_str()) {
            differences.push("made with another camera of this name".into());
        }
    }
    if digest("cameras_sha256") != index.poses.as_ref().map(|poses| poses.sha256.as_str()) {
        differences.push("made at other poses".into());
    }
    if let Some(ManifestValue::Table(options)) = manifest.settings.get("options") {
        for (name, value) in &index.options {
            let own = options.get(name).and_then(value_text);
            if own.as_ref() != Some(value) {
                let own = own.as_deref().unwrap_or("?");
                let (own, value) = (holo_io::shown(own), holo_io::shown(value));
                differences.push(format!("made with `{name}={own}`, the dataset with {value}"));
            }
        }
    }
    differences
}
