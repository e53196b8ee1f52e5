//! A light field whose headers have been read.

use std::path::{Path, PathBuf};

use holo_core::{
    ColorEncoding, DynImage, DynLightField, GridSize, Layout, LightFieldOwned, LightFieldShape, PlaneSweepOptions, Rig,
    ViewOrder, for_each_sample,
};
use ndarray::{Array2, Array4};

use super::options::ReadOptions;
use super::source::{Map, Source};
use crate::files::names::{PARAMETERS_CFG, is_regular};
use crate::records::dataset::DatasetFolder;
use crate::records::dataset::Representation;
use crate::{Error, Limits, ParametersCfg};

/// The format of a folder or file that contains a light field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LightFieldFormat {
    /// A folder that `holo render` wrote, or one with such files without their manifest.
    DatasetFolder,
    /// A folder with the layout of the HCI benchmark.
    HciFolder,
    /// A folder of the Stanford Lego gantry.
    GantryFolder,
    /// A folder of PNGs, one a view.
    ImageFolder,
    /// A folder of perspective views of the MIT Synthetic Light Field Archive.
    MitFolder,
    /// A file of LightPack, which names images.
    LightPack,
    /// An image of 14 x 14 views as Lytro Desktop exports it.
    Eslf,
    /// `lf.h5` of the old HCI benchmark.
    OldHci,
    /// A PNG, TIFF or OpenEXR of an elemental image array or a sub-aperture image array.
    RawImage,
    /// The raw image of a plenoptic camera, or its folder: views are decoded when they are read.
    Plenoptic,
    /// A MAT file of version 5 or 7.3.
    Mat,
    /// An HDF5 file.
    Hdf5,
}

/// A light field that was read, and what its files contain about it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LightFieldFile {
    /// The samples `(v, u, t, s, c)` in the sample type of the files and with the strides of the files.
    pub light_field: DynLightField,
    /// The rig, if the files contain one with these numbers of views and pixels.
    pub rig: Option<Rig>,
    /// The encoding of the samples: sRGB for integers, linear for floats. No file of these formats specifies another.
    pub color_encoding: ColorEncoding,
    /// The format of the folder or file.
    pub format: LightFieldFormat,
    /// The layout of the raw image, if the samples come from one.
    pub layout: Option<Layout>,
    /// Smallest and largest disparity of the scene in pixels between horizontally adjacent views, if the files contain
    /// them.
    pub disparity_range_px: Option<(f64, f64)>,
    /// Problems of the files that do not affect the samples, such as numbers that make no rig: one message each, with
    /// its path.
    pub warnings: Vec<String>,
}

impl LightFieldFile {
    /// Returns the light field in linear light and without its alpha channel, for refocusing and other sums of samples.
    ///
    /// # Errors
    ///
    /// [`OutOfMemory`](holo_core::Error::OutOfMemory) if the allocation of a copy fails.
    pub fn into_linear(self) -> Result<LightFieldOwned<f32>, holo_core::Error> {
        self.light_field.without_alpha()?.into_linear(self.color_encoding)
    }

    /// Returns options for [`plane_sweep`](holo_core::plane_sweep) with the disparity range and the ratio of the baselines
    /// that the files contain, and the defaults for what they do not contain.
    #[must_use]
    pub fn plane_sweep_options(&self) -> PlaneSweepOptions {
        let mut options = PlaneSweepOptions::default();
        if let Some((min, max)) = self.disparity_range_px {
            options = options.range_px(min as f32, max as f32);
        }
        if let Some(rig) = &self.rig {
            options = options.baseline_ratio(rig.baseline_ratio());
        }
        options
    }
}

/// A light field whose headers have been read, but not its samples.
#[derive(Debug)]
pub struct LightFieldReader {
    /// The file or folder with the samples.
    path: PathBuf,
    source: Source,
    limits: Limits,
    pub(super) format: LightFieldFormat,
    pub(super) shape: LightFieldShape,
    pub(super) layout: Option<Layout>,
    pub(super) rig: Option<Rig>,
    pub(super) color_encoding: ColorEncoding,
    pub(super) disparity_range_px: Option<(f64, f64)>,
    pub(super) warnings: Vec<String>,
    pub(super) representation: Option<Representation>,
    pub(super) representations: Vec<Representation>,
    /// The dataset folder that the file is in.
    pub(super) dataset: Option<Box<DatasetFolder>>,
}

impl LightFieldReader {
    /// A reader of integers in `source` without rig, layout and disparity range.
    pub(super) fn new(
        path: &Path,
        options: &ReadOptions,
        format: LightFieldFormat,
        shape: LightFieldShape,
        source: Source,
    ) -> Self {
        Self {
            path: path.to_owned(),
            source,
            limits: options.limits,
            format,
            shape,
            layout: None,
            rig: None,
            color_encoding: ColorEncoding::Srgb,
            disparity_range_px: None,
            warnings: Vec::new(),
            representation: None,
            representations: Vec::new(),
            dataset: None,
        }
    }

    /// Returns the format of the folder or file.
    #[must_use]
    pub const fn format(&self) -> LightFieldFormat {
        self.format
    }

    /// Returns what the samples are read from, if the path is a folder.
    #[must_use]
    pub const fn representation(&self) -> Option<Representation> {
        self.representation
    }

    /// Returns all that the folder holds the light field in, in the order of preference; none of a file. See
    /// [`LightFieldFolder`](crate::LightFieldFolder).
    #[must_use]
    pub fn representations(&self) -> &[Representation] {
        &self.representations
    }

    /// Returns the numbers of views and microlenses.
    #[must_use]
    pub const fn shape(&self) -> LightFieldShape {
        self.shape
    }

    /// Returns the layout of the raw image, if the samples come from one.
    #[must_use]
    pub const fn layout(&self) -> Option<Layout> {
        self.layout
    }

    /// Returns the path of the raw image that contains all samples, if they come from one.
    #[must_use]
    pub fn raw_image(&self) -> Option<PathBuf> {
        self.source.raw_image()
    }

    /// Returns the rig; see [`LightFieldFile::rig`].
    #[must_use]
    pub const fn rig(&self) -> Option<&Rig> {
        self.rig.as_ref()
    }

    /// Returns the smallest and largest disparity of the scene; see [`LightFieldFile::disparity_range_px`].
    #[must_use]
    pub const fn disparity_range_px(&self) -> Option<(f64, f64)> {
        self.disparity_range_px
    }

    /// Returns the problems of the files that do not affect the samples; see [`LightFieldFile::warnings`].
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Reads the planar depth of the central view in meters, or returns `None` if the files have none.
    ///
    /// # Shape
    ///
    /// `(v, u)`; `+infinity` where nothing was hit.
    ///
    /// # Errors
    ///
    /// Those of the reader of the format.
    pub fn central_depth_m(&self) -> Result<Option<Array2<f32>>, Error> {
        self.central_map(Map::Depth)
    }

    /// Reads the planar depth of view `(t, s)` in meters, or returns `None` if the files have none of it.
    ///
    /// # Shape
    ///
    /// `(v, u)`; `+infinity` where nothing was hit.
    ///
    /// # Errors
    ///
    /// Those of the reader of the format.
    pub fn depth_m_of_view(&self, (t, s): (usize, usize)) -> Result<Option<Array2<f32>>, Error> {
        if let Some(folder) = &self.dataset {
            let beside = folder.depth_m_of_view((t, s), &self.limits)?;
            if beside.is_some() {
                return Ok(beside);
            }
        }
        if (t, s) == self.shape.central_view() { self.central_depth_m() } else { Ok(None) }
    }

    /// Reads the disparity of the central view in pixels between horizontally adjacent views, or returns `None` if the
    /// files have none.
    ///
    /// # Shape
    ///
    /// `(v, u)`; positive nearer than the focus plane.
    ///
    /// # Errors
    ///
    /// Those of the reader of the format.
    pub fn central_disparity_px(&self) -> Result<Option<Array2<f32>>, Error> {
        self.central_map(Map::Disparity)
    }

    /// Reads the disparities of all views in pixels between horizontally adjacent views, or returns `None` if the files have not
    /// those of every view.
    ///
    /// # Shape
    ///
    /// `(v, u, t, s)`; positive nearer than the focus plane.
    ///
    /// # Errors
    ///
    /// Those of the reader of the format; [`Error::TooLarge`] if all maps together exceed the limits.
    pub fn disparity_px_of_views(&self) -> Result<Option<Array4<f32>>, Error> {
        if let Some(folder) = &self.dataset {
            let beside = folder.disparity_px_of_views(&self.limits)?;
            if beside.is_some() {
                return Ok(beside);
            }
        }
        self.source.disparity_px_of_views(&self.limits)
    }

    /// Reads one view without the others, or returns `None` if the format stores them together: then [`read`](Self::read)
    /// has it.
    ///
    /// # Shape
    ///
    /// `(v, u, c)`.
    ///
    /// # Errors
    ///
    /// Those of the reader of the format; [`Error::BadInput`] if there is no such view.
    pub fn read_view(&self, row: usize, column: usize) -> Result<Option<DynImage>, Error> {
        self.source.read_view((row, column))
    }

    /// Reads the samples.
    ///
    /// # Errors
    ///
    /// As [`read_light_field`](crate::read_light_field).
    pub fn read(self) -> Result<LightFieldFile, Error> {
        let order = self.source.order();
        let light_field = self.source.read(&self.path, self.shape, &self.limits)?;
        let mut warnings = self.warnings;
        warnings.extend(order.and_then(|order| warning_of_order(&self.path, &light_field, order)));
        Ok(LightFieldFile {
            light_field,
            rig: self.rig,
            color_encoding: self.color_encoding,
            format: self.format,
            layout: self.layout,
            disparity_range_px: self.disparity_range_px,
            warnings,
        })
    }

    /// The map of a dataset folder, else the one of the file with the samples.
    fn central_map(&self, map: Map) -> Result<Option<Array2<f32>>, Error> {
        if let Some(folder) = &self.dataset {
            let beside = match map {
                Map::Depth => folder.depth_m(&self.limits)?,
                Map::Disparity => folder.disparity_px(&self.limits)?,
            };
            if beside.is_some() {
                return Ok(beside);
            }
        }
        self.source.central_map(map, &self.limits)
    }

    /// Completes rig and disparity range from a `parameters.cfg`, if it specifies the same numbers of views and pixels.
    pub(super) fn complete_from(mut self, parameters_path: &Path) -> Self {
        if !is_regular(parameters_path) {
            return self;
        }
        match ParametersCfg::read(parameters_path) {
            Ok(parameters) if (parameters.num_cams, parameters.image_resolution_px) == sizes(self.shape) => {
                self.complete(&parameters, parameters_path)
            }
            Ok(_) => self,
            Err(error) => {
                self.warnings.push(error.to_string());
                self
            }
        }
    }

    /// Takes rig and disparity range from the parameters where they are not known yet.
    pub(super) fn complete(mut self, parameters: &ParametersCfg, parameters_path: &Path) -> Self {
        if self.rig.is_none() {
            match parameters.rig().map_err(|error| error.about(parameters_path)) {
                Ok(rig) => self.rig = Some(rig),
                Err(error) => self.warnings.push(error.to_string()),
            }
        }
        self.disparity_range_px = self.disparity_range_px.or(parameters.disp_min.zip(parameters.disp_max));
        self
    }
}

pub(super) fn sizes(shape: LightFieldShape) -> (GridSize, GridSize) {
    (shape.views(), shape.lenses())
}

/// The `parameters.cfg` of a path: in the folder, or the sidecar of a file.
pub(super) fn parameters_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(PARAMETERS_CFG) } else { path.with_file_name(PARAMETERS_CFG) }
}

/// The encoding of samples of a file that states none.
pub(super) fn encoding(is_float: bool) -> ColorEncoding {
    if is_float { ColorEncoding::Linear } else { ColorEncoding::Srgb }
}

/// What is wrong with the order of the views, if the motion between them shows it.
fn warning_of_order(path: &Path, light_field: &DynLightField, order: ViewOrder) -> Option<String> {
    let found = for_each_sample!(DynLightField, light_field, field => field.view_order_of_images())?;
    let (path, name) = (path.display(), order.name());
    if order != ViewOrder::RowMajor {
        return Some(format!("{path}: the motion between the images is not that of the order {name}; try others"));
    }
    let views = light_field.shape().views();
    let views = if found.is_by_columns() { GridSize::new(views.columns, views.rows) } else { views };
    Some(format!(
        "{path}: the motion between the images is not that of the order {name}, but of {} ({views} views)",
        found.name()
    ))
}
