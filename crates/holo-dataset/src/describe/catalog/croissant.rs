//! `croissant.json`: a dataset in the vocabulary of MLCommons Croissant 1.0 (JSON-LD on schema.org).

use holo_io::FileDigest;
use holo_io::dataset::DatasetIndex;
use serde_json::{Map, Value, json};

use super::TEST_EVERY;
use super::record::{Field, Record, fields};

/// The name of every dataset: that of its folder would make equal datasets differ.
pub(in super::super) const NAME: &str = "holo-light-fields";

/// The specification that every description follows.
pub(in super::super) const CONFORMS_TO: &str = "http://mlcommons.org/croissant/1.0";

/// The document of a dataset with these light fields.
pub(super) fn document(index: &DatasetIndex, records: &[Record]) -> Value {
    let of = |record: &Record| {
        let files = record.manifest.files.iter();
        files.map(|(name, written)| file(&record.folder, name, written)).collect::<Vec<_>>()
    };
    let version = index.versions.get("holo").map_or("", String::as_str);
    json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS_TO,
        "name": NAME,
        "description": description(index, version),
        "license": format!("https://spdx.org/licenses/{}.html", index.license),
        "version": version,
        "citeAs": format!("@software{{holo, title = {{holo: raw holoscopic images with exact ground truth}}, version = {{{version}}}}}"),
        "distribution": records.iter().flat_map(of).collect::<Vec<_>>(),
        "recordSet": [splits(), {
            "@type": "cr:RecordSet",
            "@id": "light_fields",
            "name": "light_fields",
            "description": "One record for each light field, which is a folder of files",
            "key": {"@id": "light_fields/folder"},
            "field": fields(&index.cameras).map(field).collect::<Vec<_>>(),
            "data": records.iter().map(|record| values(index, record)).collect::<Vec<_>>(),
        }],
    })
}

fn description(index: &DatasetIndex, version: &str) -> String {
    let count = index.scenes.len();
    let what = match index.cameras.iter().any(|camera| camera.shape().is_some()) {
        true => format!(
            "Synthetic light fields of {count} scenes as raw images of a holoscopic (integral, plenoptic 1.0) camera and as views, \
             with exact depth and disparity."
        ),
        false => format!("Synthetic raw images of {count} scenes, as the sensors of plenoptic cameras record them."),
    };
    format!("{what} Made by holo {version}; DATASET.md has files and conventions.")
}

fn field(field: &Field) -> Value {
    let Field { name, kind, description, .. } = field;
    let mut json = json!({
        "@type": "cr:Field", "@id": format!("light_fields/{name}"), "name": name, "description": description, "dataType": kind,
    });
    if *name == "split" {
        json["references"] = json!({"field": {"@id": "splits/name"}});
    }
    json
}

fn splits() -> Value {
    let field = |name: &str, kind: &str| json!({"@type": "cr:Field", "@id": format!("splits/{name}"), "name": name, "dataType": kind});
    let split = |name: &str, url: &str| json!({"splits/name": name, "splits/url": url});
    json!({
        "@type": "cr:RecordSet",
        "@id": "splits",
        "name": "splits",
        "description": format!("Every scene file of number {TEST_EVERY}, {}, ... is for tests, with all its frames; of fewer files the last", 2 * TEST_EVERY),
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
        "toml" => "application/toml",
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

fn values(index: &DatasetIndex, record: &Record) -> Value {
    let named = fields(&index.cameras).map(|field| (format!("light_fields/{}", field.name), (field.value)(record)));
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
