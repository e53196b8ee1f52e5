//! `dataset.json`: the index of a dataset of many folders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape};
use serde::{Deserialize, Serialize};

use super::{DATASET_JSON, DatasetCamera, is_camera_name};
use crate::error::STREAM;
use crate::files::folder::{Folder, read_beside};
use crate::files::names::stays_inside;
use crate::{Error, FileDigest, write_file};

/// The values of the key `format`: 1 is that of rigs where the cameras of the scenes stand, which versions 0.1 and 0.2 read
/// too; 2 is that of all others.
const FORMATS: [&str; 2] = ["holo dataset 1", "holo dataset 2"];

/// Maximum size of a `dataset.json`, in bytes.
const MAX_BYTES: u64 = 16 << 20;

/// The index of a dataset: every scene with every camera, each in `<scene>/<S>x<T>/` or `<scene>/<camera>/`.
///
/// It depends on the settings only, not on which of the folders exist already, and contains no time and no path.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape};
/// use holo_io::dataset::{DatasetCamera, DatasetIndex, SceneEntry};
///
/// let (name, purpose, sha256) = ("garden".to_owned(), "foliage".to_owned(), "00".repeat(32));
/// let shape = LightFieldShape::new(GridSize::new(20, 20), GridSize::new(265, 397))?;
/// let index = DatasetIndex {
///     scenes: vec![SceneEntry { name, purpose, sha256, ..SceneEntry::default() }],
///     cameras: vec![DatasetCamera::Rig(shape)],
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
    /// The scenes; of a scene at several poses or frames one each.
    pub scenes: Vec<SceneEntry>,
    /// The cameras, one folder of every scene each: rigs, then plenoptic cameras.
    pub cameras: Vec<DatasetCamera>,
    /// The poses of every scene; `None` where the cameras stand where those of the scenes do.
    pub poses: Option<DatasetPoses>,
    /// What the scenes were drawn from; `None` if they are files or built in.
    pub recipe: Option<DatasetRecipe>,
    /// How to read the files, one sentence a topic.
    pub conventions: BTreeMap<String, String>,
    /// SPDX identifier of the license of the images.
    pub license: String,
}

/// A scene of a dataset.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneEntry {
    /// Name of the scene and of its folder.
    pub name: String,
    /// What the scene tests or shows.
    pub purpose: String,
    /// SHA-256 of its `.glb`, 64 hexadecimal digits.
    pub sha256: String,
    /// Name of the scene that this is a pose or a frame of; `None` if it is a scene of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// SHA-256 of cameras of its own, which a recipe perturbs, by the names in [`DatasetIndex::cameras`].
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub cameras: BTreeMap<String, String>,
}

impl SceneEntry {
    /// Returns the name of the scene itself, without pose and frame.
    #[must_use]
    pub fn source(&self) -> &str {
        self.source.as_deref().unwrap_or(&self.name)
    }
}

/// The poses of a dataset, a scene each.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DatasetPoses {
    /// Their number.
    pub count: usize,
    /// SHA-256 of the poses as manifests have it (`cameras_sha256`), 64 hexadecimal digits.
    pub sha256: String,
    /// The axis that points up in the world of `transforms.json`: `y` or `z`.
    pub up: String,
}

/// The recipe of a dataset whose scenes were drawn; its text is `recipe.toml` beside the index.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DatasetRecipe {
    /// Its name.
    pub name: String,
    /// The seed of the scenes.
    pub seed: u64,
    /// The number of scenes.
    pub count: usize,
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
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    cameras: Vec<CameraEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    poses: Option<DatasetPoses>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    recipe: Option<DatasetRecipe>,
    #[serde(default)]
    conventions: BTreeMap<String, String>,
}

#[derive(Serialize, Deserialize)]
struct ShapeEntry {
    views: Size,
    lenses: Size,
}

#[derive(Serialize, Deserialize)]
struct CameraEntry {
    name: String,
    size: Size,
    sha256: String,
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
    /// [`Error::BadInput`] if the name of a scene or of a camera is not the name of one folder.
    pub fn folders(&self) -> Result<Vec<PathBuf>, Error> {
        let folders = |scene: &str| self.cameras.iter().map(|camera| camera.folder(scene)).collect::<Vec<_>>();
        self.scenes.iter().flat_map(|scene| folders(&scene.name)).collect()
    }

    /// Returns the index as JSON, ending in a line feed.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if the name of a scene or of a camera is not the name of one folder.
    pub fn to_json(&self) -> Result<String, Error> {
        self.folders()?;
        let (mut shapes, mut cameras) = (Vec::new(), Vec::new());
        for camera in &self.cameras {
            match camera {
                DatasetCamera::Rig(shape) => {
                    shapes.push(ShapeEntry { views: shape.views().into(), lenses: shape.lenses().into() });
                }
                DatasetCamera::Plenoptic { name, size, sha256 } => {
                    cameras.push(CameraEntry { name: name.clone(), size: (*size).into(), sha256: sha256.clone() });
                }
            }
        }
        let is_old = cameras.is_empty() && self.poses.is_none();
        let document = Document {
            format: FORMATS[usize::from(!is_old)].to_owned(),
            license: self.license.clone(),
            versions: self.versions.clone(),
            options: self.options.clone(),
            scenes: self.scenes.clone(),
            shapes,
            cameras,
            poses: self.poses.clone(),
            recipe: self.recipe.clone(),
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
    if !FORMATS.contains(&document.format.as_str()) {
        let (found, known) = (crate::shown(&document.format), FORMATS.join("' and '"));
        return Err(Error::unsupported(path, format!("its format is '{found}'; '{known}' can be read")));
    }
    if let Some(scene) = document.scenes.iter().find(|scene| !stays_inside(&scene.name) || scene.name.contains('/')) {
        return Err(broken(format!("a scene called '{}' has no folder", crate::shown(&scene.name))));
    }
    if let Some(camera) = document.cameras.iter().find(|camera| !is_camera_name(&camera.name)) {
        return Err(broken(format!("a camera called '{}' has no folder", crate::shown(&camera.name))));
    }
    let shape = |entry: &ShapeEntry| LightFieldShape::new((&entry.views).into(), (&entry.lenses).into());
    let rigs = document.shapes.iter().map(|entry| shape(entry).map(DatasetCamera::Rig));
    let mut cameras = rigs.collect::<Result<Vec<_>, _>>().map_err(|error| broken(error.to_string()))?;
    cameras.extend(document.cameras.into_iter().map(|CameraEntry { name, size, sha256 }| DatasetCamera::Plenoptic {
        name,
        size: (&size).into(),
        sha256,
    }));
    Ok(DatasetIndex {
        versions: document.versions,
        options: document.options,
        scenes: document.scenes,
        cameras,
        poses: document.poses,
        recipe: document.recipe,
        conventions: document.conventions,
        license: document.license,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig() -> DatasetCamera {
        DatasetCamera::Rig(LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap())
    }

    #[test]
    fn damaged_indices_are_errors() {
        let good = DatasetIndex {
            scenes: vec![SceneEntry { name: "a".into(), ..SceneEntry::default() }],
            cameras: vec![rig()],
            ..DatasetIndex::default()
        };
        let text = good.to_json().unwrap();
        assert_eq!(DatasetIndex::from_json(&text).unwrap(), good);
        let recipe = Some(DatasetRecipe { name: "mixed".into(), seed: u64::MAX, count: 1 });
        let drawn = DatasetIndex { recipe, ..good.clone() };
        assert_eq!(DatasetIndex::from_json(&drawn.to_json().unwrap()).unwrap(), drawn);
        for (from, to) in [("\"a\"", "\"../a\""), ("\"a\"", "\"a/b\""), ("\"rows\": 2", "\"rows\": 0"), ("{", "[")] {
            let damaged = text.replacen(from, to, 1);
            assert_ne!(damaged, text);
            assert!(matches!(DatasetIndex::from_json(&damaged), Err(Error::Broken { .. })), "{to}");
        }
        let other = text.replacen("dataset 1", "dataset 3", 1);
        assert!(matches!(DatasetIndex::from_json(&other), Err(Error::Unsupported { .. })));
        let bad = DatasetIndex { scenes: vec![SceneEntry { name: "..".into(), ..good.scenes[0].clone() }], ..good };
        assert!(matches!(bad.to_json(), Err(Error::BadInput { .. })));
    }

    /// What versions 0.1 and 0.2 cannot read has a format of its own.
    #[test]
    fn cameras_and_poses_are_kept() {
        let plenoptic = |name: &str| DatasetCamera::Plenoptic {
            name: name.into(),
            size: GridSize::new(45, 60),
            sha256: "11".repeat(32),
        };
        let of = |cameras: Vec<DatasetCamera>, poses: Option<DatasetPoses>| {
            let (name, source) = ("a_left".to_owned(), Some("a".to_owned()));
            let scenes = vec![SceneEntry {
                name,
                source,
                cameras: BTreeMap::from([("another".into(), "33".repeat(32))]),
                ..SceneEntry::default()
            }];
            DatasetIndex { scenes, cameras, poses, ..DatasetIndex::default() }
        };
        let poses = || Some(DatasetPoses { count: 2, sha256: "22".repeat(32), up: "z".into() });
        for (index, format) in [
            (of(vec![rig()], None), "holo dataset 1"),
            (of(vec![rig()], poses()), "holo dataset 2"),
            (of(vec![rig(), plenoptic("small")], None), "holo dataset 2"),
            (of(vec![plenoptic("small"), plenoptic("with space")], poses()), "holo dataset 2"),
        ] {
            let text = index.to_json().unwrap();
            assert!(text.contains(format), "{text}");
            assert_eq!(DatasetIndex::from_json(&text).unwrap(), index);
            assert_eq!(index.scenes[0].source(), "a");
        }
        let text = of(vec![plenoptic("small")], None).to_json().unwrap();
        for name in ["../x", "a/b", "", "3x3", "frame_0001", "a.", " a", "a\\n"] {
            let damaged = text.replacen("\"small\"", &format!("\"{name}\""), 1);
            assert!(matches!(DatasetIndex::from_json(&damaged), Err(Error::Broken { .. })), "{name}");
        }
        assert!(matches!(of(vec![plenoptic("3x3")], None).to_json(), Err(Error::BadInput { .. })));
    }
}
