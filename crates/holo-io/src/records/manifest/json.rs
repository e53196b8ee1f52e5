//! The JSON of the manifest: fixed order of keys, sizes as columns and rows, infinities as text.

use std::collections::BTreeMap;
use std::path::Path;

use holo_core::Rig;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{FORMAT, FORMATS, Manifest, ManifestValue};
use crate::files::names::stays_inside;
use crate::{Error, FileDigest, Sha256};

/// The keys in the order in which they are written.
#[derive(Serialize, Deserialize)]
struct Document {
    format: String,
    #[serde(default)]
    versions: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    libraries: BTreeMap<String, FileEntry>,
    #[serde(default)]
    seed: u64,
    #[serde(default)]
    settings: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rig: Option<Rig>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    disparity_px: Option<Range>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    exposure_ev: Option<Number>,
    #[serde(default)]
    files: BTreeMap<String, FileEntry>,
}

#[derive(Serialize, Deserialize)]
struct Range {
    min: Number,
    max: Number,
}

#[derive(Serialize, Deserialize)]
struct FileEntry {
    bytes: u64,
    sha256: String,
}

/// A number that may be infinite.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Number {
    Finite(f64),
    Text(NotFinite),
}

#[derive(Serialize, Deserialize)]
enum NotFinite {
    #[serde(rename = "inf")]
    Infinity,
    #[serde(rename = "-inf")]
    NegativeInfinity,
    #[serde(rename = "nan")]
    NotANumber,
}

impl NotFinite {
    fn of(value: f64) -> Option<Self> {
        match value {
            f64::INFINITY => Some(Self::Infinity),
            f64::NEG_INFINITY => Some(Self::NegativeInfinity),
            value if value.is_nan() => Some(Self::NotANumber),
            _ => None,
        }
    }

    fn text(&self) -> &'static str {
        match self {
            Self::Infinity => "inf",
            Self::NegativeInfinity => "-inf",
            Self::NotANumber => "nan",
        }
    }

    fn value(&self) -> f64 {
        match self {
            Self::Infinity => f64::INFINITY,
            Self::NegativeInfinity => f64::NEG_INFINITY,
            Self::NotANumber => f64::NAN,
        }
    }
}

impl From<f64> for Number {
    fn from(value: f64) -> Self {
        NotFinite::of(value).map_or(Self::Finite(value), Self::Text)
    }
}

impl From<Number> for f64 {
    fn from(number: Number) -> Self {
        match number {
            Number::Finite(value) => value,
            Number::Text(text) => text.value(),
        }
    }
}

fn value_to_json(value: &ManifestValue) -> Value {
    match value {
        ManifestValue::None => Value::Null,
        ManifestValue::Bool(value) => Value::from(*value),
        ManifestValue::Integer(value) => Value::from(*value),
        ManifestValue::Float(value) => {
            NotFinite::of(*value).map_or(Value::from(*value), |text| Value::from(text.text()))
        }
        ManifestValue::Text(text) => Value::from(text.as_str()),
        ManifestValue::List(values) => values.iter().map(value_to_json).collect(),
        // In the order of a `BTreeMap`, whatever order the JSON crate keeps.
        ManifestValue::Table(values) => values.iter().map(|(key, value)| (key.clone(), value_to_json(value))).collect(),
    }
}

/// The recursion is bounded: the parser stops at 128 levels of nesting.
fn value_from_json(value: Value) -> ManifestValue {
    match value {
        Value::Null => ManifestValue::None,
        Value::Bool(value) => ManifestValue::Bool(value),
        Value::Number(number) => match (number.as_i64(), number.as_f64()) {
            (Some(value), _) => ManifestValue::Integer(value),
            (None, Some(value)) => ManifestValue::Float(value),
            (None, None) => ManifestValue::Text(number.to_string()),
        },
        Value::String(text) => match text.as_str() {
            "inf" => ManifestValue::Float(f64::INFINITY),
            "-inf" => ManifestValue::Float(f64::NEG_INFINITY),
            "nan" => ManifestValue::Float(f64::NAN),
            _ => ManifestValue::Text(text),
        },
        Value::Array(values) => ManifestValue::List(values.into_iter().map(value_from_json).collect()),
        Value::Object(values) => {
            ManifestValue::Table(values.into_iter().map(|(key, value)| (key, value_from_json(value))).collect())
        }
    }
}

pub(super) fn write(manifest: &Manifest, path: &Path) -> Result<String, Error> {
    if let Some(name) = manifest.files.keys().find(|name| !stays_inside(name)) {
        return Err(Error::bad_input(path, format!("the manifest lists {name:?}, which is no name inside its folder")));
    }
    let entries = |files: &BTreeMap<String, FileDigest>| {
        let entry = |file: &FileDigest| FileEntry { bytes: file.bytes, sha256: file.sha256.to_string() };
        files.iter().map(|(name, file)| (name.clone(), entry(file))).collect()
    };
    let document = Document {
        format: FORMAT.to_owned(),
        versions: manifest.versions.clone(),
        libraries: entries(&manifest.libraries),
        seed: manifest.seed,
        settings: manifest.settings.iter().map(|(key, value)| (key.clone(), value_to_json(value))).collect(),
        rig: manifest.rig,
        disparity_px: manifest.disparity_px.map(|(min, max)| Range { min: min.into(), max: max.into() }),
        exposure_ev: manifest.exposure_ev.map(Number::from),
        files: entries(&manifest.files),
    };
    let text = serde_json::to_string_pretty(&document);
    text.map(|text| text + "\n").map_err(|error| Error::bad_input(path, error.to_string()))
}

pub(super) fn read(text: &[u8], path: &Path) -> Result<Manifest, Error> {
    let broken = |what: String| Error::broken(path, "manifest", what);
    /// The key that distinguishes a manifest of another version from a damaged one.
    #[derive(Deserialize)]
    struct Version {
        format: String,
    }
    let version: Version = serde_json::from_slice(text).map_err(|error| broken(error.to_string()))?;
    if !FORMATS.contains(&version.format.as_str()) {
        return Err(Error::unsupported(
            path,
            format!("the format is {:?}; this version of holo reads {FORMATS:?}", crate::shown(&version.format)),
        ));
    }
    let document: Document = serde_json::from_slice(text).map_err(|error| broken(error.to_string()))?;
    let digests = |key: &str, entries: BTreeMap<String, FileEntry>| {
        let mut files = BTreeMap::new();
        for (name, entry) in entries {
            if !stays_inside(&name) {
                return Err(broken(format!("{key}: {:?} is no name inside the folder", crate::shown(&name))));
            }
            let sha256 = Sha256::from_hex(&entry.sha256).ok_or_else(|| {
                broken(format!("{key}: the SHA-256 of {:?} is not 64 hexadecimal digits", crate::shown(&name)))
            })?;
            files.insert(name, FileDigest { bytes: entry.bytes, sha256 });
        }
        Ok(files)
    };
    Ok(Manifest {
        versions: document.versions,
        libraries: digests("libraries", document.libraries)?,
        seed: document.seed,
        settings: document.settings.into_iter().map(|(key, value)| (key, value_from_json(value))).collect(),
        rig: document.rig,
        disparity_px: document.disparity_px.map(|range| (range.min.into(), range.max.into())),
        exposure_ev: document.exposure_ev.map(f64::from),
        files: digests("files", document.files)?,
    })
}
