//! The reader of HCI folders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use holo_core::{DynImage, DynLightField, GridSize, Layout, LightFieldOwned, LightFieldShape, Rig};
use ndarray::{Array2, Axis};
use rayon::prelude::*;

use super::names::Name;
use super::{FORMAT, HciQuantity, HciResolution};
use crate::files::names::PARAMETERS_CFG;
use crate::light_field::views::{Views, check_regular, files_by_key, has_file};
use crate::{Error, Folder, Limits, ParametersCfg, read_pfm_gray, read_pfm_info};

/// An [HCI folder](super), opened for reading.
///
/// [`open`](Self::open) reads `parameters.cfg` and the names of the files; the other methods read pixels.
///
/// # Examples
///
/// ```
/// use holo_core::{DynLightField, GridSize, Layout, LightField, Rig, LightFieldShape};
/// use holo_io::{Compression, HciFolder, HciImage, HciTruth, Limits, ParametersCfg};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path();
/// let split = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 5))?;
/// let rig = Rig::builder(split)
///     .focal_length_m(0.1)
///     .sensor_size_m(0.035)
///     .baseline_m(0.025)
///     .focus_distance_m(4.25)
///     .build()?;
/// let light_field = LightField::filled(split, 3, Layout::ElementalGrid, 7_u8)?;
/// let image = HciImage {
///     views: Some(light_field.as_light_field_ref().into()),
///     parameters: &ParametersCfg::from_rig(&rig),
///     disparity_px: HciTruth::None,
///     depth_m: HciTruth::None,
///     high_resolution: None,
/// };
/// image.write(path, Compression::Fast)?;
///
/// let read = HciFolder::open(path)?;
/// assert_eq!(read.rig()?, rig);
/// assert_eq!(read.read(&Limits::default())?, DynLightField::U8(light_field));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HciFolder {
    path: PathBuf,
    parameters: ParametersCfg,
    shape: LightFieldShape,
    /// One file a view, view row by view row.
    views: Vec<PathBuf>,
    truth: BTreeMap<Name, PathBuf>,
}

impl HciFolder {
    /// Opens a folder: reads its `parameters.cfg` and checks that there is a file for every view.
    ///
    /// Keys that do not belong to the rig may be missing, and so may ground truth. Other files are ignored.
    ///
    /// # Errors
    ///
    /// Those of [`ParametersCfg::read`]; [`Error::Io`] if the folder cannot be listed; [`Error::Core`] if the numbers
    /// of views or pixels are invalid, [`Error::Io`] if a view or a map is a link or no file; [`Error::Broken`] if a view is missing or has two files, such as
    /// `input_Cam007.png` and `input_Cam0007.png`.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let (parameters, shape, mut files) = contents(path)?;
        let count = shape.views().count();
        let mut views = Vec::with_capacity(count.min(files.len()));
        for index in 0..count {
            let Some(file) = files.remove(&Name::View(index)) else {
                let columns = shape.views().columns;
                return Err(Error::broken(
                    path,
                    FORMAT,
                    format!(
                        "there is no {}, the view in row {}, column {} of the {columns} x {} that {} specifies",
                        Name::View(index),
                        index / columns,
                        index % columns,
                        shape.views().rows,
                        PARAMETERS_CFG
                    ),
                ));
            };
            views.push(file);
        }
        files.retain(|name, _| matches!(name, Name::Truth { .. }));
        views.iter().chain(files.values()).try_for_each(|file| check_regular(file))?;
        Ok(Self { path: path.to_owned(), parameters, shape, views, truth: files })
    }

    /// Whether the folder has at least one file with the name of a view.
    pub(crate) fn has_views(path: &Path) -> Result<bool, Error> {
        has_file(path, |name| crate::files::names::hci_view_number(name).is_some())
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the contents of `parameters.cfg`.
    #[must_use]
    pub const fn parameters(&self) -> &ParametersCfg {
        &self.parameters
    }

    /// Returns the numbers of views and microlenses.
    #[must_use]
    pub const fn shape(&self) -> LightFieldShape {
        self.shape
    }

    /// Returns the rig of `parameters.cfg`; see the extensions of [the format](super).
    ///
    /// # Errors
    ///
    /// [`Error::Core`] if its numbers make no rig, such as a focal length of 0. The images can be read nevertheless.
    pub fn rig(&self) -> Result<Rig, Error> {
        self.parameters.rig().map_err(|error| error.about(&self.path.join(PARAMETERS_CFG)))
    }

    /// Reads all views.
    ///
    /// Views may be gray or RGB, of 8 or 16 bits, but all the same. An alpha channel is dropped; the color values stay
    /// as they are stored, also where alpha is 0.
    ///
    /// # Shape
    ///
    /// `(v, u, t, s, c)` with 1 or 3 channels; in memory a sub-aperture image array.
    ///
    /// # Errors
    ///
    /// Those of [`read_png`](crate::read_png); [`Error::Broken`] if the size of a view is not that of the parameters,
    /// or if its channels or bits differ from the first view; [`Error::TooLarge`] if the samples of all views exceed
    /// the limits, before memory is allocated for them.
    pub fn read(&self, limits: &Limits) -> Result<DynLightField, Error> {
        self.files().read(limits)
    }

    /// Reads the view `(t, s)`.
    ///
    /// # Shape
    ///
    /// `(v, u, c)` with 1 or 3 channels; alpha is dropped as in [`HciFolder::read`].
    ///
    /// # Errors
    ///
    /// [`Error::Core`] if there is no such view; those of [`read_png`](crate::read_png); [`Error::Broken`] if the size
    /// of the view is not that of the parameters.
    pub fn read_view(&self, t: usize, s: usize, limits: &Limits) -> Result<DynImage, Error> {
        self.files().read_one(self.index(t, s)?, limits)
    }

    /// Reads a ground truth map of the central view, or returns `None` if it has no file.
    ///
    /// Without a file for the central view alone, the numbered file of the central view is read.
    ///
    /// # Shape
    ///
    /// `(rows, columns)`: those of a view, or of any finer grid for [`HciResolution::High`].
    ///
    /// # Errors
    ///
    /// Those of [`read_pfm_gray`]; [`Error::Broken`] if a map of low resolution does not have the size of a view.
    pub fn central_truth(
        &self,
        quantity: HciQuantity,
        resolution: HciResolution,
        limits: &Limits,
    ) -> Result<Option<Array2<f32>>, Error> {
        let (t, s) = self.shape.central_view();
        match self.truth.get(&Name::truth(quantity, resolution, None)) {
            Some(file) => self.read_truth(file, resolution, limits).map(Some),
            None => self.truth_of_view(quantity, resolution, t, s, limits),
        }
    }

    /// Reads the ground truth map of the view `(t, s)`, or returns `None` if it has no file.
    ///
    /// # Shape
    ///
    /// As in [`HciFolder::central_truth`].
    ///
    /// # Errors
    ///
    /// As [`HciFolder::central_truth`], and [`Error::Core`] if there is no such view.
    pub fn truth_of_view(
        &self,
        quantity: HciQuantity,
        resolution: HciResolution,
        t: usize,
        s: usize,
        limits: &Limits,
    ) -> Result<Option<Array2<f32>>, Error> {
        let index = self.index(t, s)?;
        let file = self.truth.get(&Name::truth(quantity, resolution, Some(index)));
        file.map(|file| self.read_truth(file, resolution, limits)).transpose()
    }

    /// Reads the ground truth maps of low resolution of all views, or returns `None` unless every view has one.
    ///
    /// # Shape
    ///
    /// `(v, u, t, s, 1)`.
    ///
    /// # Errors
    ///
    /// As [`HciFolder::central_truth`]; [`Error::TooLarge`] if all maps together exceed the limits, before memory is
    /// allocated for them.
    pub fn truth_of_all_views(
        &self,
        quantity: HciQuantity,
        limits: &Limits,
    ) -> Result<Option<LightFieldOwned<f32>>, Error> {
        let file = |index| self.truth.get(&Name::truth(quantity, HciResolution::Low, Some(index)));
        let Some(files) = (0..self.views.len()).map(file).collect::<Option<Vec<&PathBuf>>>() else { return Ok(None) };
        limits.elements(&self.path, "ground truth", &self.shape.array_shape(1), size_of::<f32>())?;
        let mut maps = LightFieldOwned::filled(self.shape, 1, Layout::ViewpointGrid, 0.0)
            .map_err(|error| Error::core(&self.path, error))?;
        let failure = maps
            .par_views_mut()
            .zip(&files)
            .map(|((_, mut view), file)| {
                let map = self.read_truth(file, HciResolution::Low, limits)?;
                view.assign(&map.insert_axis(Axis(2)));
                Ok(())
            })
            .find_map_first(Result::err);
        failure.map_or(Ok(Some(maps)), Err)
    }

    fn read_truth(&self, file: &Path, resolution: HciResolution, limits: &Limits) -> Result<Array2<f32>, Error> {
        let (found, view) = (read_pfm_info(file)?.size, self.shape.lenses());
        if resolution == HciResolution::Low && found != view {
            return Err(Error::broken(
                file,
                FORMAT,
                format!(
                    "it has {} x {} pixels, but {} specifies {} x {}",
                    found.columns, found.rows, PARAMETERS_CFG, view.columns, view.rows
                ),
            ));
        }
        let map = read_pfm_gray(file, limits)?;
        match GridSize::new(map.nrows(), map.ncols()) == found {
            true => Ok(map),
            false => Err(Error::broken(file, FORMAT, "it changed while it was read")),
        }
    }

    fn index(&self, t: usize, s: usize) -> Result<usize, Error> {
        self.files().index(&self.path, t, s)
    }

    fn files(&self) -> Views<'_> {
        Views {
            format: FORMAT,
            views: self.shape.views(),
            files: &self.views,
            expected: Some((self.shape.lenses(), PARAMETERS_CFG)),
        }
    }
}

/// The parameters of a folder, its shape and its files.
pub(super) fn contents(path: &Path) -> Result<(ParametersCfg, LightFieldShape, BTreeMap<Name, PathBuf>), Error> {
    // First, because a folder without it is unfinished.
    let parameters = ParametersCfg::read_in(&Folder::open(path)?, PARAMETERS_CFG)?;
    let shape = LightFieldShape::new(parameters.num_cams, parameters.image_resolution_px)
        .map_err(|error| Error::core(&path.join(PARAMETERS_CFG), error))?;
    Ok((parameters, shape, files(path)?))
}

/// The files of a folder that belong to the format.
pub(super) fn files(folder: &Path) -> Result<BTreeMap<Name, PathBuf>, Error> {
    let files = files_by_key(folder, FORMAT, "has the same number", |name| Some((Name::parse(name)?, ())))?;
    Ok(files.into_iter().map(|(name, (path, ()))| (name, path)).collect())
}
