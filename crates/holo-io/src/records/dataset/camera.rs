//! The cameras of a dataset: each has a folder of its own in that of every scene.

use std::path::PathBuf;

use holo_core::{GridSize, LightFieldShape};

use super::{camera_folder, folder, views_name};
use crate::Error;

/// A camera of a dataset, which sees every scene.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape};
/// use holo_io::dataset::DatasetCamera;
///
/// let rig = DatasetCamera::Rig(LightFieldShape::new(GridSize::new(20, 40), GridSize::new(265, 198))?);
/// assert_eq!(rig.folder("garden")?, std::path::Path::new("garden/40x20"));
/// let (name, sha256) = ("bench".to_owned(), "00".repeat(32));
/// let camera = DatasetCamera::Plenoptic { name, size: GridSize::new(420, 560), sha256 };
/// assert_eq!(camera.folder("garden")?, std::path::Path::new("garden/bench"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DatasetCamera {
    /// A rig with these numbers of views and microlenses.
    Rig(LightFieldShape),
    /// A plenoptic camera.
    Plenoptic {
        /// Its name, and that of its folders.
        name: String,
        /// The size of its raw image in pixels.
        size: GridSize,
        /// SHA-256 of its `camera.toml`, 64 hexadecimal digits.
        sha256: String,
    },
}

impl DatasetCamera {
    /// Returns the name of its folders: `<S>x<T>`, views as columns x rows, or the name of the plenoptic camera.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Rig(shape) => views_name(shape.views()),
            Self::Plenoptic { name, .. } => name.clone(),
        }
    }

    /// Returns the relative path of its folder of a scene.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if one of both names cannot be a folder name.
    pub fn folder(&self, scene: &str) -> Result<PathBuf, Error> {
        match self {
            Self::Rig(shape) => folder(scene, shape.views()),
            Self::Plenoptic { name, .. } => camera_folder(scene, name),
        }
    }

    /// Returns the numbers of views and microlenses of a rig; `None` for a plenoptic camera.
    #[must_use]
    pub fn shape(&self) -> Option<LightFieldShape> {
        match self {
            Self::Rig(shape) => Some(*shape),
            Self::Plenoptic { .. } => None,
        }
    }
}
