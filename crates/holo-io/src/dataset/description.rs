//! `dataset.json`: what a dataset of many folders consists of.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape};
use serde::{Deserialize, Serialize};

use super::{DATASET_JSON, folder};
use crate::error::MEMORY;
use crate::limits::read_small_file;
use crate::names::stays_inside;
use crate::{Error, FileDigest, write_file};

/// The value of the key `format`.
const FORMAT: &str = "holo dataset 1";

/// A description is at most this long.
const MAX_BYTES: u64 = 16 << 20;

/// What a dataset consists of: every scene with every light field shape, each in `<scene>/<S>x<T>/`.
///
/// It depends on the settings only, not on which of the folders are there already, and holds no time and no path.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape};
/// use holo_io::dataset::{Description, SceneEntry};
///
/// let description = Description {
///     scenes: vec![SceneEntry { name: "garden".into(), purpose: "foliage".into(), sha256: "00".repeat(32) }],
///     splits: vec![LightFieldShape::new(GridSize::new(20, 20), GridSize::new(265, 397))?],
///     ..Description::default()
/// };
/// assert_eq!(description.folders()?, [std::path::Path::new("garden/20x20")]);
/// assert_eq!(Description::from_json(&description.to_json()?)?, description);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Description {
    /// What makes the files: `holo` and its engine, each with its version.
    pub versions: BTreeMap<String, String>,
    /// The options that decide the files, by their names on the command line.
    pub options: BTreeMap<String, String>,
    /// The scenes.
    pub scenes: Vec<SceneEntry>,
    /// The splits.
    pub splits: Vec<LightFieldShape>,
    /// How the files are to be read, a sentence a topic.
    pub conventions: BTreeMap<String, String>,
    /// The licence of the images.
    pub licence: String,
}

/// A scene of a dataset.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneEntry {
    /// Its name, which is that of its folder.
    pub name: String,
    /// What it is there for.
    pub purpose: String,
    /// The digest of its `.glb`, 64 hexadecimal digits.
    pub sha256: String,
}

#[derive(Serialize, Deserialize)]
struct Document {
    format: String,
    #[serde(default)]
    licence: String,
    #[serde(default)]
    versions: BTreeMap<String, String>,
    #[serde(default)]
    options: BTreeMap<String, String>,
    scenes: Vec<SceneEntry>,
    splits: Vec<SplitEntry>,
    #[serde(default)]
    conventions: BTreeMap<String, String>,
}

#[derive(Serialize, Deserialize)]
struct SplitEntry {
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

impl Description {
    /// Returns the folders of the dataset relative to its root, scene by scene.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a scene's name is not the name of one folder.
    pub fn folders(&self) -> Result<Vec<PathBuf>, Error> {
        let splits = |scene: &str| self.splits.iter().map(|shape| folder(scene, shape.views())).collect::<Vec<_>>();
        self.scenes.iter().flat_map(|scene| splits(&scene.name)).collect()
    }

    /// Returns the description as JSON, ending in a line feed.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a scene's name is not the name of one folder.
    pub fn to_json(&self) -> Result<String, Error> {
        self.folders()?;
        let splits = self.splits.iter();
        let document = Document {
            format: FORMAT.to_owned(),
            licence: self.licence.clone(),
            versions: self.versions.clone(),
            options: self.options.clone(),
            scenes: self.scenes.clone(),
            splits: splits.map(|s| SplitEntry { views: s.views().into(), lenses: s.lenses().into() }).collect(),
            conventions: self.conventions.clone(),
        };
        let text = serde_json::to_string_pretty(&document);
        text.map(|text| text + "\n").map_err(|error| Error::bad_input(Path::new(MEMORY), error.to_string()))
    }

    /// Reads a description from JSON. Keys that this version does not know are passed over.
    ///
    /// # Errors
    ///
    /// [`Error::Broken`] if it is not JSON, a value has the wrong type, a shape is invalid or a name leads outside the folder;
    /// [`Error::Unsupported`] if it is of another version.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        parse(text.as_bytes(), Path::new(MEMORY))
    }

    /// Writes the description into the root of a dataset.
    ///
    /// # Errors
    ///
    /// Those of [`to_json`](Self::to_json), and [`Error::Io`] if the file cannot be written.
    pub fn write(&self, root: impl AsRef<Path>) -> Result<FileDigest, Error> {
        write_file(root.as_ref().join(DATASET_JSON), self.to_json()?.as_bytes())
    }

    /// Reads the description in the root of a dataset.
    ///
    /// # Errors
    ///
    /// Those of [`from_json`](Self::from_json); [`Error::Io`] if the file cannot be read; [`Error::TooLarge`] if it has more
    /// than 16 MiB.
    pub fn read(root: impl AsRef<Path>) -> Result<Self, Error> {
        let path = root.as_ref().join(DATASET_JSON);
        parse(&read_small_file(&path, MAX_BYTES)?, &path)
    }
}

fn parse(bytes: &[u8], path: &Path) -> Result<Description, Error> {
    let broken = |what: String| Error::broken(path, "dataset description", what);
    let document: Document = serde_json::from_slice(bytes).map_err(|error| broken(error.to_string()))?;
    if document.format != FORMAT {
        return Err(Error::unsupported(path, format!("its format is '{}'; '{FORMAT}' can be read", document.format)));
    }
    if let Some(scene) = document.scenes.iter().find(|scene| !stays_inside(&scene.name) || scene.name.contains('/')) {
        return Err(broken(format!("a scene called '{}' has no folder", scene.name)));
    }
    let shape = |entry: &SplitEntry| LightFieldShape::new((&entry.views).into(), (&entry.lenses).into());
    let splits: Result<Vec<LightFieldShape>, _> = document.splits.iter().map(shape).collect();
    Ok(Description {
        versions: document.versions,
        options: document.options,
        scenes: document.scenes,
        splits: splits.map_err(|error| broken(error.to_string()))?,
        conventions: document.conventions,
        licence: document.licence,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_descriptions_are_errors() {
        let good = Description {
            scenes: vec![SceneEntry { name: "a".into(), purpose: String::new(), sha256: String::new() }],
            splits: vec![LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap()],
            ..Description::default()
        };
        let text = good.to_json().unwrap();
        assert_eq!(Description::from_json(&text).unwrap(), good);
        for (from, to) in [("\"a\"", "\"../a\""), ("\"a\"", "\"a/b\""), ("\"rows\": 2", "\"rows\": 0"), ("{", "[")] {
            let damaged = text.replacen(from, to, 1);
            assert_ne!(damaged, text);
            assert!(matches!(Description::from_json(&damaged), Err(Error::Broken { .. })), "{to}");
        }
        let other = text.replacen("dataset 1", "dataset 2", 1);
        assert!(matches!(Description::from_json(&other), Err(Error::Unsupported { .. })));
        let bad = Description { scenes: vec![SceneEntry { name: "..".into(), ..good.scenes[0].clone() }], ..good };
        assert!(matches!(bad.to_json(), Err(Error::BadInput { .. })));
    }
}
