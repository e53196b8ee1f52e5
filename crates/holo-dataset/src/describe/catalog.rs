//! What the root of a dataset says of its finished folders, for catalogs, loaders and readers.
//!
//! | file | contents |
//! |---|---|
//! | `croissant.json` | MLCommons Croissant 1.0: every file with size and SHA-256, a record for each light field, splits |
//! | `light_fields.csv` | the same records as a table |
//! | `train.txt`, `test.txt` | the folders of both splits, a line each |
//! | `contact_sheet_<S>x<T>.png` | the central view of every scene, and below it a part of its raw image |
//! | `contact_sheet_<camera>.png` | the same of a plenoptic camera, with the raw image in place of the view |
//!
//! All of it follows from `dataset.json` and the finished folders that were made as it says, so that it can be written again at
//! any time. There is a contact sheet of a camera when all scenes are finished.

pub(super) mod contact_sheet;
pub(super) mod croissant;
pub(super) mod record;

use std::fmt::Write;
use std::path::Path;

use holo_io::dataset::{DatasetCamera, DatasetIndex};
use holo_io::{Folder, Manifest};
use serde_json::Value;

pub(crate) use self::record::Record;
use self::record::fields;
use super::own::{self, CROISSANT_JSON, LIGHT_FIELDS_CSV, Own, SPLITS};
use super::verify::differences;
use crate::Error;
use crate::output::inner_name;
use crate::resume::finished_manifest;
use crate::watch::Diagnostics;

/// Every scene of this number is for tests, so that no scene is in both splits.
const TEST_EVERY: usize = 5;

/// How many light fields of a dataset a catalog describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Described {
    /// Light fields that are finished and as `dataset.json` says.
    pub finished: usize,
    /// Light fields that the dataset is to have.
    pub of: usize,
}

/// Returns how many light fields of a dataset are finished, by their manifests; files are not compared with these.
///
/// # Errors
/// [`Error::Io`] if `dataset.json` cannot be read.
pub fn finished(root: &Path) -> Result<Described, Error> {
    let index = DatasetIndex::read(root)?;
    Ok(Described {
        finished: records(&Folder::open(root)?, &index)?.len(),
        of: index.scenes.len() * index.cameras.len(),
    })
}

/// Writes what the root of a dataset says of its finished folders: `croissant.json`, `light_fields.csv`, `train.txt`,
/// `test.txt`, and `contact_sheet_<camera>.png` of every camera for which all scenes are finished. Contact sheets that are
/// newer than all of their folders stay. An image that cannot be read is an empty tile and a warning.
///
/// # Errors
/// [`Error::Failed`], before anything is written, if a file of these names is not the dataset's own; [`Error::Io`] if
/// `dataset.json` cannot be read, or if a file cannot be written.
pub fn write_catalog(root: &Path, diagnostics: &dyn Diagnostics) -> Result<Described, Error> {
    let index = DatasetIndex::read(root)?;
    let root = &Folder::open(root)?;
    let own_files = Own::new(root);
    own_files.check(&index)?;
    let records = records(root, &index)?;
    let document = croissant::document(&index, &records);
    let json = serde_json::to_string_pretty(&document).map_err(|why| Error::Failed(why.to_string()))?;
    let write = |name: &str, text: String| holo_io::write_file(root.file(name), text.as_bytes());
    write(CROISSANT_JSON, format!("{json}\n"))?;
    write(LIGHT_FIELDS_CSV, table(&index, &records))?;
    for (name, is_test) in SPLITS.into_iter().zip([false, true]) {
        let folders = records.iter().filter(|record| record.is_test == is_test);
        write(name, folders.map(|record| format!("{}\n", record.folder)).collect())?;
    }
    for camera in &index.cameras {
        let of_camera: Vec<&Record> = records.iter().filter(|record| record.camera == *camera).collect();
        let is_whole = of_camera.len() == index.scenes.len();
        if !(is_whole && contact_sheet::write(root, camera, &of_camera, diagnostics)?) {
            own_files.remove(&contact_sheet::file_name(camera))?;
        }
    }
    Ok(Described { finished: records.len(), of: index.scenes.len() * index.cameras.len() })
}

/// The records of all finished folders that are as `dataset.json` says, in the order of the scenes.
pub(crate) fn records(root: &Folder, index: &DatasetIndex) -> Result<Vec<Record>, Error> {
    let mut records = Vec::new();
    let mut files: Vec<&str> = Vec::new();
    let mut all: Vec<&str> = index.scenes.iter().map(|scene| scene.sha256.as_str()).collect();
    all.dedup();
    let count = all.len();
    for scene in &index.scenes {
        // Poses and frames are of one file, and belong together.
        if files.last() != Some(&scene.sha256.as_str()) {
            files.push(&scene.sha256);
        }
        // Of few files the last is for tests, so that there are some.
        let is_last_of_few = (2..TEST_EVERY).contains(&count) && files.len() == count;
        let is_test = files.len().is_multiple_of(TEST_EVERY) || is_last_of_few;
        for camera in &index.cameras {
            let path = camera.folder(&scene.name)?;
            let Ok(inside) = root.sub(&inner_name(&path)?) else { continue };
            let Ok(manifest) = finished_manifest(&inside) else { continue };
            if !is_of(&manifest, camera) || !differences(index, &manifest, &path).is_empty() {
                continue;
            }
            records.push(Record::new(
                own::folder(&scene.name, camera),
                scene.name.clone(),
                is_test,
                camera.clone(),
                manifest,
            ));
        }
    }
    Ok(records)
}

/// Whether a manifest is that of a camera.
fn is_of(manifest: &Manifest, camera: &DatasetCamera) -> bool {
    match camera {
        DatasetCamera::Rig(shape) => manifest.rig.is_some_and(|rig| rig.shape() == shape),
        // Which camera it is, is a difference.
        DatasetCamera::Plenoptic { .. } => manifest.rig.is_none(),
    }
}

/// The records as a table of comma-separated values (RFC 4180).
fn table(index: &DatasetIndex, records: &[Record]) -> String {
    let names: Vec<&str> = fields(&index.cameras).map(|field| field.name).collect();
    let mut text = names.join(",");
    text.push('\n');
    for record in records {
        for (k, field) in fields(&index.cameras).enumerate() {
            let separator = if k > 0 { "," } else { "" };
            let value = match (field.value)(record) {
                Value::Null => String::new(),
                Value::String(text) => quoted(text),
                other => other.to_string(),
            };
            // Writing into a `String` cannot fail.
            let _ = write!(text, "{separator}{value}");
        }
        text.push('\n');
    }
    text
}

fn quoted(text: String) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

#[cfg(test)]
mod tests {
    use holo_core::GridSize;

    use super::*;
    use crate::{DatasetPlan, EngineSettings, Pixels, RenderSettings, RigSettings, Rollback, RunOptions, sources};

    /// Every file of the finished folders with its digest, a record for each of them, and five scenes of which the last is
    /// for tests. A folder that is missing is left out.
    #[test]
    fn finished_folders_are_described() {
        let root = tempfile::tempdir().unwrap();
        let names: Vec<String> = holo_scene::gallery::NAMES.iter().take(5).map(|name| (*name).to_owned()).collect();
        let pixels = Pixels::Sensor(holo_core::Sensor::Other(GridSize::new(12, 18)));
        let rig = RigSettings { pixels, ..RigSettings::default() };
        let mut settings = RenderSettings { camera: rig.into(), ..RenderSettings::default() };
        (settings.light.samples, settings.output.write) = (Some(1.into()), vec![crate::Output::Disparity]);
        let (sources, views) = (sources(Some(&names), &[]).unwrap(), [GridSize::new(3, 3)]);
        let plan = DatasetPlan::new(&sources, &views, settings, EngineSettings::default()).unwrap();
        plan.describe(root.path(), &(), &Rollback::default()).unwrap();
        let mut run = plan.run();
        for job in plan.jobs().iter().skip(1) {
            run.job(job, root.path(), &RunOptions::new()).unwrap();
        }
        assert_eq!(write_catalog(root.path(), &()).unwrap(), Described { finished: 4, of: 5 });
        let text = std::fs::read_to_string(root.path().join("croissant.json")).unwrap();
        let document: Value = serde_json::from_str(&text).unwrap();
        let records = document["recordSet"][1]["data"].as_array().unwrap();
        let splits: Vec<_> = records.iter().map(|record| record["light_fields/split"].as_str().unwrap()).collect();
        assert_eq!(splits, ["train", "train", "train", "test"]);
        assert_eq!(records[0]["light_fields/lens_columns"], 6);
        for file in document["distribution"].as_array().unwrap() {
            let digest = holo_io::hash_file(root.path().join(file["contentUrl"].as_str().unwrap())).unwrap();
            assert_eq!(file["sha256"], digest.sha256.to_string());
            assert_eq!(file["contentSize"], format!("{} B", digest.bytes));
        }
        // The same again.
        write_catalog(root.path(), &()).unwrap();
        assert_eq!(std::fs::read_to_string(root.path().join("croissant.json")).unwrap(), text);
    }

    /// All poses of a scene are in the same split, here those of the fifth.
    #[test]
    fn poses_of_a_scene_stay_together() {
        let root = tempfile::tempdir().unwrap();
        let names: Vec<String> = holo_scene::gallery::NAMES.iter().take(5).map(|name| (*name).to_owned()).collect();
        let camera = |name: &str, x: f64| holo_io::ArrayCamera {
            name: name.into(),
            axes_and_position: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.3, 1.2]],
            focal_px: 14.0,
            size: Some(GridSize::new(8, 12)),
            ..holo_io::ArrayCamera::default()
        };
        let cameras = holo_io::CameraArray { cameras: vec![camera("left", -0.1), camera("right", 0.1)] };
        let (pixels, focus) = (Pixels::OfPoses, crate::Focus::Meters(1.0));
        let rig = RigSettings { pixels, focus, ..RigSettings::default() };
        let mut settings = RenderSettings { camera: rig.into(), ..RenderSettings::default() };
        settings.poses = crate::Poses::Array { cameras, up: holo_io::WorldUp::Y };
        settings.output.write = vec![crate::Output::Disparity];
        let (sources, views) = (sources(Some(&names), &[]).unwrap(), [GridSize::new(3, 3)]);
        let plan = DatasetPlan::new(&sources, &views, settings, EngineSettings::default()).unwrap();
        plan.describe(root.path(), &(), &Rollback::default()).unwrap();
        let mut run = plan.run();
        for job in plan.jobs() {
            run.job(job, root.path(), &RunOptions::new()).unwrap();
        }
        assert_eq!(write_catalog(root.path(), &()).unwrap(), Described { finished: 10, of: 10 });
        let lines = |name: &str| std::fs::read_to_string(root.path().join(name)).unwrap();
        assert_eq!(lines("test.txt"), format!("{0}_left/3x3\n{0}_right/3x3\n", names[4]));
        assert_eq!(lines("train.txt").lines().count(), 8);
    }

    /// Names as they are typed may contain what separates values.
    #[test]
    fn values_are_quoted() {
        assert_eq!(quoted("plain/3x3".into()), "plain/3x3");
        assert_eq!(quoted("a,\"b\"".into()), "\"a,\"\"b\"\"\"");
    }
}
