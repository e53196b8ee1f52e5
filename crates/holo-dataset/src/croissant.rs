//! `croissant.json`: a dataset in the vocabulary of MLCommons Croissant 1.0 (JSON-LD on schema.org), for catalogs and
//! loaders.
//!
//! It lists the files of all finished folders with size and SHA-256, a record for each light field, and a split into
//! scenes for training and for tests. All of it follows from `dataset.json` and the manifests, so that it can be written
//! again at any time.

use std::path::Path;

use holo_core::meters_to_millimeters;
use holo_io::dataset::{self, DatasetIndex};
use holo_io::{FileDigest, Manifest, ManifestValue};
use serde_json::{Map, Value, json};

use crate::checkpoint::finished_manifest;
use crate::{Error, text};

/// The name of the file.
pub const CROISSANT_JSON: &str = "croissant.json";

/// The name of every dataset: that of its folder would make equal datasets differ.
const NAME: &str = "holo-light-fields";

/// Every scene of this number is for tests, so that no scene is in both parts.
const TEST_EVERY: usize = 5;

/// What a record says of a light field: name, type, description.
const FIELDS: [(&str, &str, &str); 17] = [
    ("folder", "sc:Text", "Folder of the light field, relative to the dataset"),
    ("scene", "sc:Text", "Name of the scene"),
    ("split", "sc:Text", "train or test; a scene is in one of them with all its view counts"),
    ("view_columns", "sc:Integer", "Views in a row (S)"),
    ("view_rows", "sc:Integer", "Views in a column (T)"),
    ("lens_columns", "sc:Integer", "Microlenses in a row, which are the pixels of a view (U)"),
    ("lens_rows", "sc:Integer", "Microlenses in a column (V)"),
    ("disparity_min_px", "sc:Float", "Smallest disparity of the central view, pixels between adjacent views"),
    ("disparity_max_px", "sc:Float", "Largest disparity of the central view"),
    ("baseline_mm", "sc:Float", "Distance between horizontally adjacent views"),
    ("focus_distance_m", "sc:Float", "Distance of the plane of disparity 0; null for infinity"),
    ("focal_length_mm", "sc:Float", "Focal length"),
    ("sensor_size_mm", "sc:Float", "Larger image side on the sensor"),
    ("exposure_ev", "sc:Float", "Exposure compensation of the integers"),
    ("samples", "sc:Integer", "Samples a pixel"),
    ("reconstructed", "sc:Boolean", "Whether noise was reduced across views: a small bias"),
    ("bytes", "sc:Integer", "Size of all files"),
];

/// Writes `croissant.json` into the root of a dataset from its finished folders; returns their number.
///
/// # Errors
/// [`Error::Io`] if `dataset.json` cannot be read or the file cannot be written.
pub fn describe_croissant(root: &Path) -> Result<usize, Error> {
    let index = DatasetIndex::read(root)?;
    let (mut files, mut records) = (Vec::new(), Vec::new());
    for (number, scene) in index.scenes.iter().enumerate() {
        let is_test = (number + 1).is_multiple_of(TEST_EVERY);
        for shape in &index.shapes {
            let folder = dataset::folder(&scene.name, shape.views())?;
            let Ok(manifest) = finished_manifest(&root.join(&folder)) else { continue };
            // With `/` on every system.
            let folder = format!("{}/{}x{}", scene.name, shape.views().columns, shape.views().rows);
            files.extend(manifest.files.iter().map(|(name, written)| file(&folder, name, written)));
            records.push(record(&folder, &scene.name, is_test, &manifest));
        }
    }
    let count = records.len();
    let document = document(&index, files, records);
    let text = serde_json::to_string_pretty(&document).map_err(|why| Error::Failed(why.to_string()))?;
    holo_io::write_file(root.join(CROISSANT_JSON), format!("{text}\n").as_bytes())?;
    Ok(count)
}

fn document(index: &DatasetIndex, files: Vec<Value>, records: Vec<Value>) -> Value {
    let version = index.versions.get("holo").map_or("", String::as_str);
    json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": NAME,
        "description": format!(
            "Synthetic light fields of {} scenes as raw images of a holoscopic (integral, plenoptic 1.0) camera and as views, with \
             exact depth and disparity. Made by holo {version}; DATASET.md has files and conventions.",
            index.scenes.len()
        ),
        "license": format!("https://spdx.org/licenses/{}.html", index.license),
        "version": version,
        "citeAs": format!("@software{{holo, title = {{holo: raw holoscopic images with exact ground truth}}, version = {{{version}}}}}"),
        "distribution": files,
        "recordSet": [splits(), {
            "@type": "cr:RecordSet",
            "@id": "light_fields",
            "name": "light_fields",
            "description": "One record for each light field, which is a folder of files",
            "key": {"@id": "light_fields/folder"},
            "field": FIELDS.map(field),
            "data": records,
        }],
    })
}

fn field((name, kind, description): (&str, &str, &str)) -> Value {
    let mut field = json!({
        "@type": "cr:Field", "@id": format!("light_fields/{name}"), "name": name, "description": description, "dataType": kind,
    });
    if name == "split" {
        field["references"] = json!({"field": {"@id": "splits/name"}});
    }
    field
}

fn splits() -> Value {
    let field = |name: &str, kind: &str| json!({"@type": "cr:Field", "@id": format!("splits/{name}"), "name": name, "dataType": kind});
    let split = |name: &str, url: &str| json!({"splits/name": name, "splits/url": url});
    json!({
        "@type": "cr:RecordSet",
        "@id": "splits",
        "name": "splits",
        "description": format!("Every scene of number {TEST_EVERY}, {}, ... is for tests", 2 * TEST_EVERY),
        "dataType": "cr:Split",
        "key": {"@id": "splits/name"},
        "field": [field("name", "sc:Text"), field("url", "sc:URL")],
        "data": [split("train", "cr:TrainingSplit"), split("test", "cr:TestSplit")],
    })
}

fn file(folder: &str, name: &str, written: &FileDigest) -> Value {
    let path = format!("{folder}/{name}");
    let format = match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "png" => "image/png",
        "exr" => "image/x-exr",
        "h5" => "application/x-hdf5",
        "mat" => "application/x-matlab-data",
        "json" => "application/json",
        "cfg" | "txt" => "text/plain",
        "csv" => "text/csv",
        "pfm" => "image/x-portable-floatmap",
        _ => "application/octet-stream",
    };
    json!({
        "@type": "cr:FileObject",
        "@id": path,
        "name": path,
        "contentUrl": path,
        "contentSize": format!("{} B", written.bytes),
        "encodingFormat": format,
        "sha256": written.sha256.to_string(),
    })
}

fn record(folder: &str, scene: &str, is_test: bool, manifest: &Manifest) -> Value {
    let setting = |name: &str| manifest.settings.get(name);
    let number = |value: Option<f64>| value.map_or(Value::Null, text::json_number);
    let rig = manifest.rig.as_ref();
    let size = |of: &dyn Fn(&holo_core::Rig) -> usize| rig.map_or(Value::Null, |rig| of(rig).into());
    let samples = setting("spp").and_then(ManifestValue::as_f64).map_or(Value::Null, |samples| (samples as u64).into());
    let is_reconstructed = setting("denoise").and_then(ManifestValue::as_text).is_some_and(|how| how != "off");
    let bytes: u64 = manifest.files.values().map(|written| written.bytes).sum();
    let values = [
        folder.into(),
        scene.into(),
        if is_test { "test" } else { "train" }.into(),
        size(&|rig| rig.shape().views().columns),
        size(&|rig| rig.shape().views().rows),
        size(&|rig| rig.shape().lenses().columns),
        size(&|rig| rig.shape().lenses().rows),
        number(manifest.disparity_px.map(|(min, _)| min)),
        number(manifest.disparity_px.map(|(_, max)| max)),
        number(rig.map(|rig| meters_to_millimeters(rig.baseline_x_m()))),
        number(rig.map(|rig| rig.focus_distance_m()).filter(|distance| distance.is_finite())),
        number(rig.map(|rig| meters_to_millimeters(rig.focal_length_m()))),
        number(rig.map(|rig| meters_to_millimeters(rig.sensor_size_m()))),
        number(manifest.exposure_ev),
        samples,
        is_reconstructed.into(),
        bytes.into(),
    ];
    let named = FIELDS.iter().zip(values).map(|((name, ..), value)| (format!("light_fields/{name}"), value));
    Value::Object(named.collect::<Map<_, _>>())
}

/// The context that the specification prescribes.
fn context() -> Value {
    let mut context = Map::new();
    let mut set = |name: &str, value: Value| drop(context.insert(name.to_owned(), value));
    set("@language", "en".into());
    set("@vocab", "https://schema.org/".into());
    for (prefix, url) in [
        ("cr", "http://mlcommons.org/croissant/"),
        ("dct", "http://purl.org/dc/terms/"),
        ("rai", "http://mlcommons.org/croissant/RAI/"),
        ("sc", "https://schema.org/"),
    ] {
        set(prefix, url.into());
    }
    for name in [
        "citeAs",
        "column",
        "equivalentProperty",
        "extract",
        "field",
        "fileProperty",
        "fileObject",
        "fileSet",
        "format",
        "includes",
        "isLiveDataset",
        "jsonPath",
        "key",
        "md5",
        "parentField",
        "path",
        "recordSet",
        "references",
        "regex",
        "repeated",
        "replace",
        "samplingRate",
        "separator",
        "source",
        "subField",
        "transform",
    ] {
        set(name, format!("cr:{name}").into());
    }
    set("conformsTo", "dct:conformsTo".into());
    for name in ["data", "examples"] {
        set(name, json!({"@id": format!("cr:{name}"), "@type": "@json"}));
    }
    set("dataType", json!({"@id": "cr:dataType", "@type": "@vocab"}));
    Value::Object(context)
}

#[cfg(test)]
mod tests {
    use holo_core::GridSize;

    use super::*;
    use crate::options::Options;
    use crate::{DatasetPlan, EngineSpec, RenderSpec, Rollback, sources};

    /// Every file of the finished folders with its digest, a record for each of them, and five scenes of which the last is
    /// for tests. A folder that is missing is left out.
    #[test]
    fn finished_folders_are_described() {
        let root = tempfile::tempdir().unwrap();
        let names: Vec<String> = holo_scene::gallery::NAMES.iter().take(5).map(|name| (*name).to_owned()).collect();
        let mut spec = RenderSpec::default();
        (spec.samples, spec.outputs) = (Some(1), vec![crate::Output::Disparity]);
        spec.rig.sensor = holo_core::Sensor::Other(GridSize::new(12, 18));
        let (sources, options) = (sources(Some(&names), &[]).unwrap(), Options::new());
        let plan = DatasetPlan::new(&sources, &[GridSize::new(3, 3)], spec, options, EngineSpec::default()).unwrap();
        plan.describe(root.path(), "bvh", &Rollback::default()).unwrap();
        for job in plan.jobs.iter().skip(1) {
            plan.run_job(job, root.path(), "bvh", &(), &(), &Rollback::default()).unwrap();
        }
        assert_eq!(describe_croissant(root.path()).unwrap(), 4);
        let text = std::fs::read_to_string(root.path().join(CROISSANT_JSON)).unwrap();
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
        describe_croissant(root.path()).unwrap();
        assert_eq!(std::fs::read_to_string(root.path().join(CROISSANT_JSON)).unwrap(), text);
    }
}
