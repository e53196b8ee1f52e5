//! The reader of a dataset folder.

use std::path::{Path, PathBuf};

use holo_core::{DynLightField, GridSize, Layout, LightFieldShape, Rig};
use ndarray::{Array2, Array4, Axis};

use super::{
    DEPTH_PFM, DISPARITY_PFM, ELEMENTAL_PNG, HCI_FOLDER, MANIFEST_JSON, PARAMETERS_CFG, Representation, VIEWPOINT_PNG,
    layer_of_view,
};
use crate::error::in_words;
use crate::files::folder::Folder;
use crate::{
    Error, Limits, Manifest, ParametersCfg, files::names::hci_view_number, read_pfm_gray, read_png, read_png_info,
};

/// The name of the format in messages.
const FORMAT: &str = "dataset folder";

/// A folder that `holo render` wrote, opened for reading.
///
/// [`open`](Self::open) reads `manifest.json` and `parameters.cfg`; the other methods read images. The manifest is
/// written last, so a folder without one is not finished. Files that the manifest does not list are ignored. Contents
/// are not compared with their digests; [`Manifest::verify`] does that.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetFolder {
    path: PathBuf,
    manifest: Manifest,
    parameters: Option<ParametersCfg>,
    rig: Rig,
}

impl DatasetFolder {
    /// Opens a folder: reads the manifest and, if the manifest lists it, `parameters.cfg`.
    ///
    /// The rig is that of the manifest, or of `parameters.cfg` if the manifest contains none.
    ///
    /// # Errors
    ///
    /// Those of [`Manifest::read`], such as [`Error::Io`] if there is no manifest. Those of [`ParametersCfg::read`] if
    /// the manifest lists one. [`Error::Broken`] if neither contains a rig, or if the two differ in the numbers of
    /// views or pixels.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::with_manifest(path, Manifest::read_in(&open(path)?)?)
    }

    /// Opens a folder whose manifest has been read.
    pub(crate) fn with_manifest(path: &Path, manifest: Manifest) -> Result<Self, Error> {
        let parameters_path = path.join(PARAMETERS_CFG);
        let listed = manifest.files.contains_key(PARAMETERS_CFG);
        let read = || ParametersCfg::read_in(&Folder::open(path)?, PARAMETERS_CFG);
        let parameters = listed.then(read).transpose()?;
        let rig = match (&manifest.rig, &parameters) {
            (Some(rig), _) => *rig,
            (None, Some(parameters)) => parameters.rig().map_err(|error| error.about(&parameters_path))?,
            (None, None) => {
                let what = format!("neither {MANIFEST_JSON} nor a {PARAMETERS_CFG} that it lists contains a rig");
                return Err(Error::broken(path, FORMAT, what));
            }
        };
        let sizes = (rig.shape().views(), rig.shape().lenses());
        if let Some(other) = parameters.as_ref().map(|p| (p.num_cams, p.image_resolution_px)).filter(|p| *p != sizes) {
            let what = format!("it specifies {}, but {MANIFEST_JSON} specifies {}", in_words(other), in_words(sizes));
            return Err(Error::broken(&parameters_path, FORMAT, what));
        }
        Ok(Self { path: path.to_owned(), manifest, parameters, rig })
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the manifest.
    #[must_use]
    pub const fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Returns the contents of `parameters.cfg`, if the manifest lists one.
    #[must_use]
    pub const fn parameters(&self) -> Option<&ParametersCfg> {
        self.parameters.as_ref()
    }

    /// Returns the numbers of views and microlenses.
    #[must_use]
    pub const fn shape(&self) -> LightFieldShape {
        *self.rig.shape()
    }

    /// Returns the rig.
    #[must_use]
    pub const fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Returns the raw image that [`DatasetFolder::read`] reads, and its layout: `scene_el.png`, else `scene_vpi.png`,
    /// else `None`.
    #[must_use]
    pub fn raw_image(&self) -> Option<(PathBuf, Layout)> {
        let grids = [(ELEMENTAL_PNG, Layout::ElementalGrid), (VIEWPOINT_PNG, Layout::ViewpointGrid)];
        let listed = grids.into_iter().find(|(name, _)| self.manifest.files.contains_key(*name));
        listed.map(|(name, layout)| (self.path.join(name), layout))
    }

    /// Returns what the folder holds the light field in, by its manifest, in the order of preference. The subfolder `hci`
    /// counts if it has all views. [`LightFieldReader`](crate::LightFieldReader) reads any of them.
    #[must_use]
    pub fn representations(&self) -> Vec<Representation> {
        let is_listed = |representation: &Representation| match (representation, representation.file_name()) {
            (Representation::Hci, _) => self.lists_all_views(),
            (_, name) => name.is_some_and(|name| self.manifest.files.contains_key(name)),
        };
        Representation::OF_DATASET.into_iter().filter(is_listed).collect()
    }

    fn lists_all_views(&self) -> bool {
        let inside = self.manifest.files.keys().filter_map(|name| name.strip_prefix(HCI_FOLDER)?.strip_prefix('/'));
        inside.filter(|name| hci_view_number(name).is_some()).count() >= self.shape().views().count()
    }

    /// Reads the light field from the raw image that [`raw_image`](Self::raw_image) names; both contain the same
    /// samples.
    ///
    /// # Shape
    ///
    /// `(v, u, t, s, c)`, with the strides of the raw image in memory; nothing is copied.
    ///
    /// # Errors
    ///
    /// [`Error::Unsupported`] if the dataset has no raw image as PNG, which
    /// [`LightFieldReader`](crate::LightFieldReader) does not need; those of [`read_png`];
    /// [`Error::Broken`] if the size of the image is not that of the rig, before memory is allocated for it.
    pub fn read(&self, limits: &Limits) -> Result<DynLightField, Error> {
        let Some((_, layout)) = self.raw_image() else {
            let what =
                format!("the dataset has no raw image: {MANIFEST_JSON} lists no {ELEMENTAL_PNG} or {VIEWPOINT_PNG}");
            return Err(Error::unsupported(&self.path, what));
        };
        let name = if layout == Layout::ElementalGrid { ELEMENTAL_PNG } else { VIEWPOINT_PNG };
        let file = open(&self.path)?.regular_path(name)?;
        self.check_size(&file, read_png_info(&file)?.size, self.shape().raw_size())?;
        DynLightField::from_grid(read_png(&file, limits)?, layout, self.shape())
            .map_err(|error| Error::core(&file, error))
    }

    /// Reads the planar depth of the central view in meters, or returns `None` if the dataset has none.
    ///
    /// # Shape
    ///
    /// `(v, u)`; `+infinity` where nothing was hit.
    ///
    /// # Errors
    ///
    /// Those of [`read_pfm_gray`]; [`Error::Broken`] if the map does not have the size of a view.
    pub fn depth_m(&self, limits: &Limits) -> Result<Option<Array2<f32>>, Error> {
        self.map(DEPTH_PFM, limits)
    }

    /// Reads the disparity of the central view in pixels between horizontally adjacent views, or returns `None` if the
    /// dataset has none.
    ///
    /// # Shape
    ///
    /// `(v, u)`.
    ///
    /// # Errors
    ///
    /// As [`DatasetFolder::depth_m`].
    pub fn disparity_px(&self, limits: &Limits) -> Result<Option<Array2<f32>>, Error> {
        self.map(DISPARITY_PFM, limits)
    }

    /// Reads the disparities of all views in pixels between horizontally adjacent views, or returns `None` if the dataset has not
    /// those of every view.
    ///
    /// # Shape
    ///
    /// `(v, u, t, s)`.
    ///
    /// # Errors
    ///
    /// As [`DatasetFolder::depth_m`]; [`Error::TooLarge`] if all maps together exceed the limits, before memory is allocated for
    /// them.
    pub fn disparity_px_of_views(&self, limits: &Limits) -> Result<Option<Array4<f32>>, Error> {
        let (views, lenses) = (self.shape().views(), self.shape().lenses());
        let names: Vec<String> =
            (0..views.count()).map(|k| layer_of_view("disparity", k, views.count(), "pfm")).collect();
        if names.iter().any(|name| !self.manifest.files.contains_key(name)) {
            return Ok(None);
        }
        let shape = [lenses.rows, lenses.columns, views.rows, views.columns];
        limits.elements(&self.path, "ground truth", &shape, size_of::<f32>())?;
        let mut maps = Array4::zeros(shape);
        for (k, name) in names.iter().enumerate() {
            let Some(map) = self.map(name, limits)? else { return Ok(None) };
            let mut columns = maps.index_axis_mut(Axis(2), k / views.columns);
            columns.index_axis_mut(Axis(2), k % views.columns).assign(&map);
        }
        Ok(Some(maps))
    }

    /// Reads the planar depth of view `(t, s)` in meters, or returns `None` if the dataset has none of it: neither its depth nor its
    /// disparity.
    ///
    /// # Shape
    ///
    /// `(v, u)`; `+infinity` where nothing was hit.
    ///
    /// # Errors
    ///
    /// As [`DatasetFolder::depth_m`].
    pub fn depth_m_of_view(&self, (t, s): (usize, usize), limits: &Limits) -> Result<Option<Array2<f32>>, Error> {
        let views = self.shape().views();
        if (t, s) == self.shape().central_view()
            && let Some(depth_m) = self.depth_m(limits)?
        {
            return Ok(Some(depth_m));
        }
        let of_view = |layer| self.map(&layer_of_view(layer, t * views.columns + s, views.count(), "pfm"), limits);
        if let Some(depth_m) = of_view("depth")? {
            return Ok(Some(depth_m));
        }
        let disparity = self.rig().disparity_x();
        let depth_m = |px: f32| disparity.to_depth_m(f64::from(px)) as f32;
        Ok(of_view("disparity")?.map(|map| map.mapv_into(depth_m)))
    }

    fn map(&self, name: &str, limits: &Limits) -> Result<Option<Array2<f32>>, Error> {
        if !self.manifest.files.contains_key(name) {
            return Ok(None);
        }
        let file = open(&self.path)?.regular_path(name)?;
        let map = read_pfm_gray(&file, limits)?;
        self.check_size(&file, GridSize::new(map.nrows(), map.ncols()), self.shape().lenses())?;
        Ok(Some(map))
    }

    /// Checks the size of an image or map of the folder.
    ///
    /// # Errors
    ///
    /// [`Error::Broken`] if it is not that of the rig.
    pub(crate) fn check_size(&self, file: &Path, found: GridSize, expected: GridSize) -> Result<(), Error> {
        if found == expected {
            return Ok(());
        }
        let sizes = (self.shape().views(), self.shape().lenses());
        let what = format!(
            "it has {} x {} pixels, but the rig of {} needs {} x {}",
            found.columns,
            found.rows,
            in_words(sizes),
            expected.columns,
            expected.rows
        );
        Err(Error::broken(file, FORMAT, what))
    }
}

/// Opens the folder; the error is that of its manifest, if it is missing.
fn open(path: &Path) -> Result<Folder, Error> {
    Folder::open(path).map_err(|error| match error {
        Error::Io { error, .. } => Error::io("read", &path.join(MANIFEST_JSON), error),
        other => other,
    })
}
