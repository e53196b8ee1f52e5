//! A light field out of whatever holds one: one call for every folder and file of this crate.
//!
//! | what | how it is recognized | what tells the rig |
//! |---|---|---|
//! | dataset folder | its `manifest.json` | the manifest |
//! | HCI folder | `parameters.cfg` and `input_Cam*.png` | `parameters.cfg` |
//! | Stanford gantry folder | `out_ROW_COLUMN_Y_X.png` | nothing: its unit is unknown |
//! | folder of images | PNGs of any name, and [`ReadOptions::views`] | `parameters.cfg` in it, if it fits |
//! | raw PNG | its signature | `parameters.cfg` beside it |
//! | MAT file, versions 5 and 7.3 | its header | its variables, else `parameters.cfg` beside it, if it fits |
//! | HDF5 file | its signature | its attributes, else `parameters.cfg` beside it, if it fits |

mod natural_order;
mod source;

use std::path::{Path, PathBuf};

use holo_core::{ColorEncoding, DynLightField, GridSize, Layout, LightFieldShape, Rig, ViewOrder};
use ndarray::Array2;

use crate::names::PARAMETERS_CFG;
use crate::{Error, Limits, ParametersCfg};
use source::Source;

pub use natural_order::list_images;

/// How to read a light field: what the caller knows and the files may not tell. The default knows nothing.
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
    /// The memory that reading may take.
    pub limits: Limits,
    /// The number of views. Without it, the files must tell; with it, they must not contradict.
    pub views: Option<GridSize>,
    /// How a raw PNG is laid out. Without it, the file's name must tell; see [`layout_of_file_name`](crate::layout_of_file_name).
    pub layout: Option<Layout>,
    /// The order of the images of a folder of images.
    pub order: ViewOrder,
}

impl ReadOptions {
    /// Sets the memory that reading may take.
    #[must_use]
    pub const fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Sets the number of views.
    #[must_use]
    pub fn views(mut self, views: impl Into<Option<GridSize>>) -> Self {
        self.views = views.into();
        self
    }

    /// Sets the layout of a raw PNG.
    #[must_use]
    pub fn layout(mut self, layout: impl Into<Option<Layout>>) -> Self {
        self.layout = layout.into();
        self
    }

    /// Sets the order of the images of a folder of images.
    #[must_use]
    pub const fn order(mut self, order: ViewOrder) -> Self {
        self.order = order;
        self
    }
}

/// What holds a light field.
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
    /// A PNG of an elemental image array or of a grid of views.
    RawImage,
    /// A MAT file.
    Mat,
    /// An HDF5 file.
    Hdf5,
}

/// A light field and what its files tell about it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LightFieldFile {
    /// The samples `(v, u, t, s, c)` in the type of the files, with the strides of the files: nothing is converted.
    pub light_field: DynLightField,
    /// The rig, if the files contain one that is for these views and pixels.
    pub rig: Option<Rig>,
    /// What the samples mean: integers are on the sRGB curve, floats are linear. No file of these formats says otherwise.
    pub color_encoding: ColorEncoding,
    /// What the files are.
    pub format: LightFieldFormat,
    /// The layout of the raw image, if the samples come from one.
    pub layout: Option<Layout>,
    /// Smallest and largest disparity of the scene in pixels between adjacent views, if the files contain them.
    pub disparity_range_px: Option<(f64, f64)>,
    /// What is wrong with the files beside the samples, such as numbers that make no rig; in words, each with its path.
    pub warnings: Vec<String>,
}

/// Reads a light field from a folder or a file of any kind that this crate knows; see the table below.
///
/// | what | how it is recognized | what tells the rig |
/// |---|---|---|
/// | dataset folder | its `manifest.json` | the manifest |
/// | HCI folder | `parameters.cfg` and `input_Cam*.png` | `parameters.cfg` |
/// | Stanford gantry folder | `out_ROW_COLUMN_Y_X.png` | nothing: its unit is unknown |
/// | folder of images | PNGs of any name in natural order, and [`ReadOptions::views`] | `parameters.cfg` in it, if it fits |
/// | raw PNG | its signature | `parameters.cfg` beside it |
/// | MAT file | its header | its variables, else `parameters.cfg` beside it, if it fits |
/// | HDF5 file | its signature | its attributes, else `parameters.cfg` beside it, if it fits |
///
/// # Errors
///
/// [`Error::MissingOption`] if the files do not tell the number of views or the layout and the options do not either, or
/// if they contradict each other; [`Error::NoLightField`] if the path leads to something else; otherwise those of the
/// readers of the formats, such as [`Error::Broken`] and [`Error::TooLarge`].
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Layout, LightField, LightFieldShape};
/// use holo_io::{ColorEncoding, Compression, ReadOptions, read_light_field, write_png};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene_el.png");
/// let light_field = LightField::filled(LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 5))?, 3, Layout::ElementalGrid, 7_u8)?;
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

/// Reads the rig that belongs to a file or folder, and no samples: that of a light field, of a `manifest.json`, of a
/// `parameters.cfg`, and of any other file that of the `parameters.cfg` in its folder. `None` if there is none.
///
/// # Errors
///
/// Those of the readers; [`Error::Core`] if the numbers make no rig.
pub fn read_rig(path: impl AsRef<Path>, limits: &Limits) -> Result<Option<Rig>, Error> {
    source::rig_of(path.as_ref(), limits)
}

/// A light field whose headers have been read and whose samples have not.
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
    /// Finds out what a path leads to and reads everything but the samples.
    ///
    /// # Errors
    ///
    /// As [`read_light_field`], but for errors in the samples.
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

    /// Returns what the files are.
    #[must_use]
    pub const fn format(&self) -> LightFieldFormat {
        self.format
    }

    /// Returns the number of views and microlenses.
    #[must_use]
    pub const fn shape(&self) -> LightFieldShape {
        self.shape
    }

    /// Returns the layout of the raw image, if the samples come from one.
    #[must_use]
    pub const fn layout(&self) -> Option<Layout> {
        self.layout
    }

    /// Returns the raw image that holds all samples, if there is one.
    #[must_use]
    pub fn raw_image(&self) -> Option<PathBuf> {
        self.source.raw_image()
    }

    /// Returns the rig; see [`LightFieldFile::rig`].
    #[must_use]
    pub const fn rig(&self) -> Option<&Rig> {
        self.rig.as_ref()
    }

    /// Returns the smallest and the largest disparity of the scene; see [`LightFieldFile::disparity_range_px`].
    #[must_use]
    pub const fn disparity_range_px(&self) -> Option<(f64, f64)> {
        self.disparity_range_px
    }

    /// Returns what is wrong beside the samples; see [`LightFieldFile::warnings`].
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Reads the planar depth of the central view in meters, `(v, u)`, or returns `None` if the files have none.
    ///
    /// # Errors
    ///
    /// Those of the reader of the format.
    pub fn central_depth_m(&self) -> Result<Option<Array2<f32>>, Error> {
        self.source.central_map(source::Map::Depth, &self.limits)
    }

    /// Reads the disparity of the central view in pixels between horizontally adjacent views, `(v, u)`, or returns `None`
    /// if the files have none.
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

    /// Takes what a `parameters.cfg` tells, if it is for these views and pixels, and if nothing has told it before.
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

/// The `parameters.cfg` that belongs to a path: in the folder, or beside the file.
fn parameters_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(PARAMETERS_CFG) } else { path.with_file_name(PARAMETERS_CFG) }
}
