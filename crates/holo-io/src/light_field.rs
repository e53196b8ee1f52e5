//! Readers of a light field from any folder or file that contains one; see [`read_light_field`].
//!
//! `folder` finds what a folder holds a light field in, `file` opens one file, and either makes a `reader`, whose samples
//! are in a `source`.

mod archives;
pub(crate) mod array_folder;
mod decode;
mod file;
mod folder;
pub mod gantry;
mod grid_of_names;
pub mod hci;
mod light_pack;
mod natural_order;
mod options;
mod plenoptic;
pub(crate) mod probe;
pub(crate) mod raw_image;
mod reader;
mod source;
pub(crate) mod views;

use std::path::Path;

use holo_core::Rig;

use crate::files::names::is_regular;
use crate::{Error, FileFormat, Limits, ParametersCfg, files::detect_format};
use reader::parameters_path;

pub use folder::LightFieldFolder;
pub use natural_order::list_images;
pub use options::ReadOptions;
pub use reader::{LightFieldFile, LightFieldFormat, LightFieldReader};

/// Reads a light field from a folder or a file.
///
/// | format | recognized by | source of the rig |
/// |---|---|---|
/// | dataset folder ² | its `manifest.json` | the manifest |
/// | files of a dataset folder without a manifest ² | their names | as of each file |
/// | folder of a plenoptic camera | `camera.toml`, `raw.exr` or `raw_linear.png` | the camera |
/// | HCI folder | `parameters.cfg` and `input_Cam*.png` | `parameters.cfg` |
/// | Stanford gantry folder | `out_ROW_COLUMN_Y_X.png` | none: the unit of its positions is unknown |
/// | LightPack of Stanford | `NAME.lid`: its words; images `NAME.U.V.rgb` of one slab, or `.tif`, `.png` | none |
/// | MIT Synthetic Light Field Archive | `NAME_5x5_apA` with `NAME-01.png` to `-25` | aperture A, the archive's README |
/// | ESLF of Lytro | `NAME_eslf.png`, `NAME.eslf.png`: 14 x 14 views, linear, with alpha | none ¹ |
/// | `lf.h5` of the old HCI benchmark | its dataset `/LF` | its attributes |
/// | folder of images | PNGs of any other name in natural order, and [`ReadOptions::views`] or names with row and column ³ | `parameters.cfg` in it ¹ |
/// | raw PNG, TIFF or EXR | its signature | sidecar `parameters.cfg` ¹ |
/// | raw image of a plenoptic camera | colors, no layout in its name, sidecar `camera.toml` of its size | the camera |
/// | MAT file, version 5 or 7.3 | its header | its variables, else the sidecar `parameters.cfg` ¹ |
/// | HDF5 file | its signature | its attributes, else the sidecar `parameters.cfg` ¹ |
///
/// Views have the order of this crate: rows of gantry and MIT folders are counted from below, columns of a gantry whose X
/// falls and of the old HCI benchmark from the right. A decoded file of LFToolbox has weights as a fourth
/// channel.
///
/// A sidecar is a file of the same folder. ¹ If it specifies the same numbers of views and pixels. Of a raw image without
/// [`ReadOptions::views`] it specifies the number of views and must agree with the size of the image. ² The first that it
/// has, and that this build can read, of `scene_el.png`, `scene_vpi.png`, `scene_5d.h5`, `scene_5d.mat`, `scene_el.exr`,
/// `scene_vpi.exr` and `hci/`; [`LightFieldReader::representation`] tells which.
///
/// ³ `NAME_ROW_COLUMN.png` from 0 or 1, or a square of `input_Cam000.png` on. What is taken from names is a warning, and so is
/// motion between the images that is not that of [`ReadOptions::order`]
/// ([`view_order_of_images`](holo_core::LightField::view_order_of_images)).
///
/// Of a plenoptic camera as many views are decoded as are fully lit, unless [`ReadOptions::views`] says otherwise: linear
/// floats, relative to the white image of the camera; see
/// [`PlenopticCamera::decode`](holo_core::plenoptic::PlenopticCamera::decode).
///
/// # Shape
///
/// `(v, u, t, s, c)`; see [`LightFieldFile::light_field`].
///
/// # Errors
///
/// [`Error::MissingOption`] if neither the files nor the options specify the number of views or the layout, or if files
/// and options contradict each other; [`Error::NoLightField`] if the path leads to something else, such as the raw image
/// of a plenoptic camera that no light reaches;
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

impl LightFieldReader {
    /// Detects the format of a folder or file and reads everything but the samples.
    ///
    /// # Errors
    ///
    /// Those of [`read_light_field`], except for errors in the samples.
    pub fn open(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, Error> {
        let path = path.as_ref();
        let reader = if path.is_dir() { open_folder(path, options)? } else { file::open(path, options)? };
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
}

fn open_folder(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    LightFieldFolder::open(path)?.into_reader(options)
}

/// Reads the rig of a file or folder without its samples: that of a light field, a `manifest.json` or a
/// `parameters.cfg`; for any other file that of the `parameters.cfg` in the same folder. `None` if there is none.
///
/// # Errors
///
/// Those of the readers of the formats; [`Error::Core`] if the numbers of a `parameters.cfg` make no rig.
pub fn read_rig(path: impl AsRef<Path>, limits: &Limits) -> Result<Option<Rig>, Error> {
    let (path, options) = (path.as_ref(), ReadOptions::default().limits(*limits));
    let own = if path.is_dir() {
        rig_of_folder(path, &options)?
    } else {
        match detect_format(path)? {
            FileFormat::Manifest => return Ok(crate::Manifest::read(path)?.rig),
            FileFormat::Mat5 | FileFormat::Mat73 | FileFormat::Hdf5 => file::open(path, &options)?.rig,
            _ => None,
        }
    };
    let parameters_path = match is_parameters_cfg(path)? {
        true => path.to_owned(),
        false => parameters_path(path),
    };
    if own.is_some() || !is_regular(&parameters_path) {
        return Ok(own);
    }
    let parameters = ParametersCfg::read(&parameters_path)?;
    parameters.rig().map(Some).map_err(|error| error.about(&parameters_path))
}

/// The rig of what a folder holds; `None` if it holds no light field, or not all that a light field needs.
fn rig_of_folder(path: &Path, options: &ReadOptions) -> Result<Option<Rig>, Error> {
    // That of a dataset folder needs no image.
    let rig = LightFieldFolder::open(path).and_then(|folder| match folder.dataset().map(|dataset| *dataset.rig()) {
        Some(rig) => Ok(Some(rig)),
        None => folder.into_reader(options).map(|reader| reader.rig),
    });
    match rig {
        Err(Error::NoLightField { .. } | Error::MissingOption { .. }) => Ok(None),
        other => other,
    }
}

fn is_parameters_cfg(path: &Path) -> Result<bool, Error> {
    Ok(!path.is_dir() && detect_format(path)? == FileFormat::ParametersCfg)
}
