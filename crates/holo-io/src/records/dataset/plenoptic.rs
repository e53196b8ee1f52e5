//! The reader of the folder of a plenoptic camera.

use std::path::{Path, PathBuf};

use super::{CAMERA_TOML, MANIFEST_JSON, Representation};
use crate::files::folder::Folder;
use crate::files::names::is_regular;
use crate::{CameraFile, Error, Manifest};

/// A folder with the raw image of a plenoptic camera, opened for reading: the camera in `camera.toml`, and beside it
/// `raw.exr` or `raw_linear.png`.
///
/// [`open`](Self::open) reads the camera and, if there is one, `manifest.json`; no pixels. A folder with a manifest may
/// have a camera without a raw image, such as one of calibration targets.
#[derive(Debug, Clone, PartialEq)]
pub struct PlenopticFolder {
    path: PathBuf,
    camera: CameraFile,
    manifest: Option<Manifest>,
}

impl PlenopticFolder {
    /// Opens a folder: reads its camera and its manifest.
    ///
    /// # Errors
    ///
    /// Those of [`CameraFile::read`], such as [`Error::Io`] if there is no camera; those of [`Manifest::read`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let manifest_path = path.join(MANIFEST_JSON);
        let manifest = is_regular(&manifest_path).then(|| Manifest::read(&manifest_path)).transpose()?;
        Self::with_manifest(path, manifest)
    }

    /// Opens a folder whose manifest has been read.
    pub(crate) fn with_manifest(path: &Path, manifest: Option<Manifest>) -> Result<Self, Error> {
        let camera = CameraFile::read_in(&Folder::open(path)?, CAMERA_TOML)?;
        Ok(Self { path: path.to_owned(), camera, manifest })
    }

    /// Whether a manifest is that of such a folder: it lists a camera, and there are no views that have a rig.
    pub(crate) fn is_described_by(manifest: &Manifest) -> bool {
        manifest.rig.is_none() && manifest.files.contains_key(CAMERA_TOML)
    }

    /// Whether a folder without a manifest has a camera and a raw image.
    pub(crate) fn has_files(path: &Path) -> bool {
        let has = |name: &str| is_regular(&path.join(name));
        has(CAMERA_TOML) && Representation::OF_PLENOPTIC.iter().filter_map(|raw| raw.file_name()).any(has)
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the camera.
    #[must_use]
    pub const fn camera(&self) -> &CameraFile {
        &self.camera
    }

    /// Returns the manifest, if the folder has one.
    #[must_use]
    pub const fn manifest(&self) -> Option<&Manifest> {
        self.manifest.as_ref()
    }

    /// Returns the files of the raw image that the folder has, in the order of preference. Files that a manifest does not
    /// list are ignored.
    #[must_use]
    pub fn representations(&self) -> Vec<Representation> {
        let is_listed = |name: &str| self.manifest.as_ref().is_none_or(|manifest| manifest.files.contains_key(name));
        let has = |raw: &Representation| {
            raw.file_name().is_some_and(|name| is_listed(name) && is_regular(&self.path.join(name)))
        };
        Representation::OF_PLENOPTIC.into_iter().filter(has).collect()
    }
}
