//! `dataset.json`: the index of a dataset of many folders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape};
use serde::{Deserialize, Serialize};

use super::{DATASET_JSON, folder};
use crate::error::STREAM;
use crate::folder::{Folder, read_beside};
use crate::names::stays_inside;
use crate::{Error, FileDigest, write_file};

/// The value of the key `format`.
const FORMAT: &str = "holo dataset 1";

/// Maximum size of a `dataset.json`, in bytes.
const MAX_BYTES: u64 = 16 << 20;

/// The index of a dataset: every scene with every light field shape, each in `<scene>/<S>x<T>/`.
///
/// It depends on the settings only, not on which of the folders exist already, and contains no time and no path.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape};
/// use holo_io::dataset::{DatasetIndex, SceneEntry};
///
/// let index = DatasetIndex {
///     scenes: vec![SceneEntry { name: "garden".into(), purpose: "foliage".into(), sha256: "00".repeat(32) }],
///     shapes: vec![LightFieldShape::new(GridSize::new(20, 20), GridSize::new(265, 397))?],
///     ..DatasetIndex::default()
/// };
/// assert_eq!(index.folders()?, [std::path::Path::new("garden/20x20")]);
/// assert_eq!(DatasetIndex::from_json(&index.to_json()?)?, index);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DatasetIndex {
    /// Versions of `holo` and of the ray tracing backend that make the files.
    pub versions: BTreeMap<String, String>,
    /// Options that determine the files, by their names on the command line.
    pub options: BTreeMap<String, String>,
    /// The scenes.
    pub scenes: Vec<SceneEntry>,
    /// Numbers of views and microlenses, one folder of every scene each.
    pub shapes: Vec<LightFieldShape>,
    /// How to read the files, one sentence a topic.
    pub conventions: BTreeMap<String, String>,
    /// SPDX identifier of the license of the images.
    pub license: String,
}

/// A scene of a dataset.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneEntry {
    /// Name of the scene and of its folder.
    pub name: String,
    /// What the scene tests or shows.
    pub purpose: String,
    /// SHA-256 of its `.glb`, 64 hexadecimal digits.
    pub sha256: String,
}

/// The keys in the order in which they are written.
#[derive(Serialize, Deserialize)]
struct Document {
    format: String,
    #[serde(default, rename = "licence")]
    license: String,
    #[serde(default)]
    versions: BTreeMap<String, String>,
    #[serde(default)]
    options: BTreeMap<String, String>,
    scenes: Vec<SceneEntry>,
    #[serde(rename = "splits")]
    shapes: Vec<ShapeEntry>,
    #[serde(default)]
    conventions: BTreeMap<String, String>,
}

#[derive(Serialize, Deserialize)]
struct ShapeEntry {
    views: Size,
    lenses: Size,
}

#[derive(Serialize, Deserialize)]
struct Size {
    columns: usize,
    rows: usize,
}

impl From<GridSize> for Size {
    fn from(size: GridSize) -> Self {
        Self { columns: size.columns, rows: size.rows }
    }
}

impl From<&Size> for GridSize {
    fn from(size: &Size) -> Self {
        Self::new(size.rows, size.columns)
    }
}

impl DatasetIndex {
    /// Returns the folders of the dataset relative to its root, scene by scene.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a scene's name is not the name of one folder.
    pub fn folders(&self) -> Result<Vec<PathBuf>, Error> {
        let folders = |scene: &str| self.shapes.iter().map(|shape| folder(scene, shape.views())).collect::<Vec<_>>();
        self.scenes.iter().flat_map(|scene| folders(&scene.name)).collect()
    }

    /// Returns the index as JSON, ending in a line feed.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a scene's name is not the name of one folder.
    pub fn to_json(&self) -> Result<String, Error> {
        self.folders()?;
        let shapes = self.shapes.iter();
        let document = Document {
            format: FORMAT.to_owned(),
            license: self.license.clone(),
            versions: self.versions.clone(),
            options: self.options.clone(),
            scenes: self.scenes.clone(),
            shapes: shapes.map(|s| ShapeEntry { views: s.views().into(), lenses: s.lenses().into() }).collect(),
            conventions: self.conventions.clone(),
        };
        let text = serde_json::to_string_pretty(&document);
        text.map(|text| text + "\n").map_err(|error| Error::bad_input(Path::new(STREAM), error.to_string()))
    }

    /// Reads an index from JSON. Unknown keys are ignored.
    ///
    /// # Errors
    ///
    /// [`Error::Broken`] if it is not JSON, a value has the wrong type, a number of views or microlenses is 0, or a
    /// name leads outside the folder; [`Error::Unsupported`] if it is of another version.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        parse(text.as_bytes(), Path::new(STREAM))
    }

    /// Writes `dataset.json` into the root folder of a dataset.
    ///
    /// # Errors
    ///
    /// Those of [`to_json`](Self::to_json), and [`Error::Io`] if the file cannot be written.
    pub fn write(&self, root: impl AsRef<Path>) -> Result<FileDigest, Error> {
        self.write_in(&Folder::open(root)?)
    }

    /// Writes `dataset.json` into an open folder.
    ///
    /// # Errors
    ///
    /// Those of [`write`](Self::write).
    pub fn write_in(&self, root: &Folder) -> Result<FileDigest, Error> {
        let text = self.to_json()?;
        write_file(root.file(DATASET_JSON), text.as_bytes())
    }

    /// Reads `dataset.json` in the root folder of a dataset.
    ///
    /// # Errors
    ///
    /// Those of [`from_json`](Self::from_json); [`Error::Io`] if the file cannot be read; [`Error::TooLarge`] if it has
    /// more than 16 MiB.
    pub fn read(root: impl AsRef<Path>) -> Result<Self, Error> {
        let path = root.as_ref().join(DATASET_JSON);
        parse(&read_beside(&path, MAX_BYTES)?, &path)
    }

    /// Reads `dataset.json` of an open folder.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read).
    pub fn read_in(root: &Folder) -> Result<Self, Error> {
        parse(&root.read(DATASET_JSON, MAX_BYTES)?, &root.path_of(DATASET_JSON))
    }
}

fn parse(bytes: &[u8], path: &Path) -> Result<DatasetIndex, Error> {
    let broken = |what: String| Error::broken(path, "dataset index", what);
    let document: Document = serde_json::from_slice(bytes).map_err(|error| broken(error.to_string()))?;
    if document.format != FORMAT {
        let found = crate::shown(&document.format);
        return Err(Error::unsupported(path, format!("its format is '{found}'; '{FORMAT}' can be read")));
    }
    if let Some(scene) = document.scenes.iter().find(|scene| !stays_inside(&scene.name) || scene.name.contains('/')) {
        return Err(broken(format!("a scene called '{}' has no folder", crate::shown(&scene.name))));
    }
    let shape = |entry: &ShapeEntry| LightFieldShape::new((&entry.views).into(), (&entry.lenses).into());
    let shapes: Result<Vec<LightFieldShape>, _> = document.shapes.iter().map(shape).collect();
    Ok(DatasetIndex {
        versions: document.versions,
        options: document.options,
        scenes: document.scenes,
        shapes: shapes.map_err(|error| broken(error.to_string()))?,
        conventions: document.conventions,
        license: document.license,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_indices_are_errors() {
        let good = DatasetIndex {
            scenes: vec![SceneEntry { name: "a".into(), purpose: String::new(), sha256: String::new() }],
            shapes: vec![LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap()],
            ..DatasetIndex::default()
        };
        let text = good.to_json().unwrap();
        assert_eq!(DatasetIndex::from_json(&text).unwrap(), good);
        for (from, to) in [("\"a\"", "\"../a\""), ("\"a\"", "\"a/b\""), ("\"rows\": 2", "\"rows\": 0"), ("{", "[")] {
            let damaged = text.replacen(from, to, 1);
            assert_ne!(damaged, text);
            assert!(matches!(DatasetIndex::from_json(&damaged), Err(Error::Broken { .. })), "{to}");
        }
        let other = text.replacen("dataset 1", "dataset 2", 1);
        assert!(matches!(DatasetIndex::from_json(&other), Err(Error::Unsupported { .. })));
        let bad = DatasetIndex { scenes: vec![SceneEntry { name: "..".into(), ..good.scenes[0].clone() }], ..good };
        assert!(matches!(bad.to_json(), Err(Error::BadInput { .. })));
    }
}
