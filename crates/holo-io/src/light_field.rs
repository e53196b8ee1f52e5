//! Readers of a light field from any folder or file that contains one; see [`read_light_field`].

mod archives;
mod natural_order;
mod source;

use std::path::{Path, PathBuf};

use holo_core::{ColorEncoding, DynLightField, GridSize, Layout, LightFieldShape, Rig, ViewOrder};
use ndarray::Array2;

use crate::names::PARAMETERS_CFG;
use crate::{Error, Limits, ParametersCfg};
use source::Source;

pub use natural_order::list_images;

/// Options of reading a light field: limits, and what the files may not specify. By default everything is taken from
/// the files.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Layout};
/// use holo_io::ReadOptions;
///
/// let options = ReadOptions::default().views(GridSize::new(9, 9)).layout(Layout::ElementalGrid);
/// assert_eq!(options.views, Some(GridSize::new(9, 9)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Maximum memory that reading may take.
    pub limits: Limits,
    /// The number of views, T rows and S columns. `None`: the files must specify it. The files must not contradict it.
    pub views: Option<GridSize>,
    /// The layout of a raw PNG. `None`: the file name must specify it, as in
    /// [`layout_of_file_name`](crate::layout_of_file_name).
    pub layout: Option<Layout>,
    /// Which view each image of a folder of images is. Not used for other formats.
    pub order: ViewOrder,
}

impl ReadOptions {
    /// Sets [`limits`](Self::limits).
    #[must_use]
    pub const fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Sets [`views`](Self::views).
    #[must_use]
    pub fn views(mut self, views: impl Into<Option<GridSize>>) -> Self {
        self.views = views.into();
        self
    }

    /// Sets [`layout`](Self::layout).
    #[must_use]
    pub fn layout(mut self, layout: impl Into<Option<Layout>>) -> Self {
        self.layout = layout.into();
        self
    }

    /// Sets [`order`](Self::order).
    #[must_use]
    pub const fn order(mut self, order: ViewOrder) -> Self {
        self.order = order;
        self
    }
}

/// The format of a folder or file that contains a light field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LightFieldFormat {
    /// A folder that `holo render` wrote.
    DatasetFolder,
    /// A folder with the layout of the HCI benchmark.
    HciFolder,
    /// A folder of the Stanford Lego gantry.
    GantryFolder,
    /// A folder of PNGs, one a view.
    ImageFolder,
    /// A folder of perspective views of the MIT Synthetic Light Field Archive.
    MitFolder,
    /// An image of 14 x 14 views as Lytro Desktop exports it.
    Eslf,
    /// `lf.h5` of the old HCI benchmark.
    OldHci,
    /// A PNG of an elemental image array or a sub-aperture image array.
    RawImage,
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

/// Reads a light field from a folder or a file.
///
/// | format | recognized by | source of the rig |
/// |---|---|---|
/// | dataset folder | its `manifest.json` | the manifest |
/// | HCI folder | `parameters.cfg` and `input_Cam*.png` | `parameters.cfg` |
/// | Stanford gantry folder | `out_ROW_COLUMN_Y_X.png` | none: the unit of its positions is unknown |
/// | MIT Synthetic Light Field Archive | `NAME_5x5_apA` with `NAME-01.png` to `-25` | aperture A, the archive's README |
/// | ESLF of Lytro | `NAME_eslf.png`, `NAME.eslf.png`: 14 x 14 views, linear, with alpha | none ¹ |
/// | `lf.h5` of the old HCI benchmark | its dataset `/LF` | its attributes |
/// | folder of images | PNGs of any name in natural order, and [`ReadOptions::views`] | `parameters.cfg` in it ¹ |
/// | raw PNG | its signature | sidecar `parameters.cfg` ¹ |
/// | MAT file, version 5 or 7.3 | its header | its variables, else the sidecar `parameters.cfg` ¹ |
/// | HDF5 file | its signature | its attributes, else the sidecar `parameters.cfg` ¹ |
///
/// Views have the order of this crate: rows of gantry and MIT folders are counted from below, columns of a gantry whose X
/// falls and of the old HCI benchmark from the right. A decoded file of LFToolbox has weights as a fourth
/// channel.
///
/// A sidecar is a file of the same folder. ¹ If it specifies the same numbers of views and pixels. Of a raw PNG without
/// [`ReadOptions::views`] it specifies the number of views and must agree with the size of the image.
///
/// # Shape
///
/// `(v, u, t, s, c)`; see [`LightFieldFile::light_field`].
///
/// # Errors
///
/// [`Error::MissingOption`] if neither the files nor the options specify the number of views or the layout, or if files
/// and options contradict each other; [`Error::NoLightField`] if the path leads to something else;
/// [`Error::Unsupported`] if the format needs a feature that is off; otherwise those of the readers of the formats,
/// such as [`Error::Io`], [`Error::Broken`] and [`Error::TooLarge`].
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Layout, LightField, LightFieldShape};
/// use holo_io::{ColorEncoding, Compression, ReadOptions, read_light_field, write_png};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene_el.png");
/// let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 5))?;
/// let light_field = LightField::filled(shape, 3, Layout::ElementalGrid, 7_u8)?;
/// write_png(&path, light_field.to_elemental_grid()?.view(), ColorEncoding::Srgb, Compression::Fast)?;
///
/// let file = read_light_field(&path, &ReadOptions::default().views(GridSize::new(3, 3)))?;
/// assert_eq!(file.light_field, light_field.into());
/// assert_eq!((file.layout, file.rig), (Some(Layout::ElementalGrid), None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_light_field(path: impl AsRef<Path>, options: &ReadOptions) -> Result<LightFieldFile, Error> {
    LightFieldReader::open(path, options)?.read()
}

/// Reads the rig of a file or folder without its samples: that of a light field, a `manifest.json` or a
/// `parameters.cfg`; for any other file that of the `parameters.cfg` in the same folder. `None` if there is none.
///
/// # Errors
///
/// Those of the readers of the formats; [`Error::Core`] if the numbers of a `parameters.cfg` make no rig.
pub fn read_rig(path: impl AsRef<Path>, limits: &Limits) -> Result<Option<Rig>, Error> {
    source::rig_of(path.as_ref(), limits)
}

/// A light field whose headers have been read, but not its samples.
#[derive(Debug)]
pub struct LightFieldReader {
    path: PathBuf,
    source: Source,
    format: LightFieldFormat,
    shape: LightFieldShape,
    layout: Option<Layout>,
    rig: Option<Rig>,
    color_encoding: ColorEncoding,
    disparity_range_px: Option<(f64, f64)>,
    warnings: Vec<String>,
    limits: Limits,
}

impl LightFieldReader {
    /// Detects the format of a folder or file and reads everything but the samples.
    ///
    /// # Errors
    ///
    /// Those of [`read_light_field`], except for errors in the samples.
    pub fn open(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, Error> {
        let path = path.as_ref();
        let reader = source::open(path, options)?;
        let found = reader.shape.views();
        match options.views.filter(|views| *views != found) {
            Some(views) => Err(Error::MissingOption {
                path: path.to_owned(),
                option: "views",
                what: format!("it has {found} views, not {views}"),
            }),
            None => Ok(reader),
        }
    }

    /// Returns the format of the folder or file.
    #[must_use]
    pub const fn format(&self) -> LightFieldFormat {
        self.format
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
        self.source.central_map(source::Map::Depth, &self.limits)
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
        self.source.central_map(source::Map::Disparity, &self.limits)
    }

    /// Reads the samples.
    ///
    /// # Errors
    ///
    /// As [`read_light_field`].
    pub fn read(self) -> Result<LightFieldFile, Error> {
        let light_field = self.source.read(&self.path, self.shape, &self.limits)?;
        Ok(LightFieldFile {
            light_field,
            rig: self.rig,
            color_encoding: self.color_encoding,
            format: self.format,
            layout: self.layout,
            disparity_range_px: self.disparity_range_px,
            warnings: self.warnings,
        })
    }

    /// Completes rig and disparity range from a `parameters.cfg`, if it specifies the same numbers of views and pixels.
    fn complete_from(mut self, parameters_path: &Path) -> Self {
        if !parameters_path.is_file() {
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
    fn complete(mut self, parameters: &ParametersCfg, parameters_path: &Path) -> Self {
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

fn sizes(shape: LightFieldShape) -> (GridSize, GridSize) {
    (shape.views(), shape.lenses())
}

/// The `parameters.cfg` of a path: in the folder, or the sidecar of a file.
fn parameters_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(PARAMETERS_CFG) } else { path.with_file_name(PARAMETERS_CFG) }
}
