//! A light field in one file.

use std::path::Path;

use holo_core::{ColorEncoding, GridSize, Layout, LightFieldShape};

use super::options::ReadOptions;
use super::reader::{LightFieldFormat, LightFieldReader, encoding, parameters_path, sizes};
use super::source::Source;
use super::{archives, light_pack, plenoptic};
use crate::files::detect_format;
use crate::images::image_file::read_image_info;
use crate::{Error, FileFormat, ParametersCfg, layout_of_file_name};
#[cfg(feature = "hdf5")]
use crate::{
    Hdf5LightField,
    arrays::hdf5::{OldHciFile, is_old_hci},
};

/// Opens a file that contains a light field.
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let no_light_field = |what: &str| Error::NoLightField { path: path.to_owned(), what: what.to_owned() };
    match detect_format(path)? {
        FileFormat::Png | FileFormat::Tiff | FileFormat::Exr => open_image(path, options),
        FileFormat::Mat5 | FileFormat::Mat73 => Ok(of_mat(path, options)?.complete_from(&parameters_path(path))),
        FileFormat::Hdf5 => open_hdf5(path, options),
        FileFormat::LightPack => light_pack::open(path, options),
        FileFormat::Dng => Err(no_light_field("it holds the codes of a sensor behind a color filter, not colors")),
        FileFormat::Lytro => Err(no_light_field("it holds the raw image of a Lytro camera; decode it first")),
        _ => Err(no_light_field("it is neither a PNG, TIFF, OpenEXR, MAT or HDF5 file nor a folder of a known kind")),
    }
}

fn open_image(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let missing = |option, what| Error::MissingOption { path: path.to_owned(), option, what };
    if options.layout.is_none() && archives::is_eslf(path) {
        return open_eslf(path, options);
    }
    let layout = options.layout.or_else(|| layout_of_file_name(path));
    if layout.is_none()
        && let Some(camera) = plenoptic::camera_beside(path)?
    {
        return plenoptic::open(path, camera, options);
    }
    let layout = layout.ok_or_else(|| {
        let what = "its name (_el, _vpi) does not specify whether it is an array of elemental images or of views";
        missing("layout", what.to_owned())
    })?;
    let parameters_path = parameters_path(path);
    // Without the option the sidecar must be right; with it, it may belong to another image.
    let (views, parameters) = match options.views {
        Some(views) => (views, None),
        None => match ParametersCfg::read(&parameters_path) {
            Ok(parameters) => (parameters.num_cams, Some(parameters)),
            Err(error) => {
                let what = format!("{} does not specify the number of views: {error}", parameters_path.display());
                return Err(missing("views", what));
            }
        },
    };
    let info = read_image_info(path)?;
    let size = info.size;
    if views.count() == 0 || size.rows % views.rows != 0 || size.columns % views.columns != 0 {
        return Err(missing("views", format!("{size} pixels do not divide into {views} views")));
    }
    let lenses = GridSize::new(size.rows / views.rows, size.columns / views.columns);
    let shape = LightFieldShape::new(views, lenses).map_err(|error| Error::core(path, error))?;
    let source = Source::RawImage { file: path.to_owned(), layout };
    let mut reader = LightFieldReader::new(path, options, LightFieldFormat::RawImage, shape, source);
    reader.layout = Some(layout);
    reader.color_encoding = encoding(info.kind.is_float());
    let Some(parameters) = parameters else { return Ok(reader.complete_from(&parameters_path)) };
    if (parameters.num_cams, parameters.image_resolution_px) != sizes(shape) {
        let what = format!(
            "its {size} pixels are not the {views} views of {} px that {} contains, which may belong to another image",
            parameters.image_resolution_px,
            parameters_path.display()
        );
        return Err(missing("views", what));
    }
    Ok(reader.complete(&parameters, &parameters_path))
}

fn open_eslf(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let views = options.views.unwrap_or(GridSize::new(archives::ESLF_VIEWS, archives::ESLF_VIEWS));
    if views.count() == 0 {
        let what = format!("there cannot be {views} views");
        return Err(Error::MissingOption { path: path.to_owned(), option: "views", what });
    }
    let shape = archives::eslf_shape(read_image_info(path)?.size, views).map_err(|error| Error::core(path, error))?;
    let mut reader = LightFieldReader::new(path, options, LightFieldFormat::Eslf, shape, Source::Eslf(path.to_owned()));
    (reader.layout, reader.color_encoding) = (Some(Layout::ElementalGrid), ColorEncoding::Linear);
    Ok(reader.complete_from(&parameters_path(path)))
}

/// Opens a MAT file without the files beside it.
pub(super) fn of_mat(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let header = crate::arrays::mat::read_light_field_header(path, &options.limits)?;
    let mut reader = LightFieldReader::new(path, options, LightFieldFormat::Mat, header.shape, Source::Mat);
    reader.color_encoding = encoding(header.is_float);
    reader.rig = header.rig;
    reader.warnings.extend(header.rig_error.map(|error| Error::core(path, error).to_string()));
    Ok(reader)
}

#[cfg(feature = "hdf5")]
fn open_hdf5(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    if !is_old_hci(path)? {
        return Ok(of_hdf5(path, options)?.complete_from(&parameters_path(path)));
    }
    let file = OldHciFile::open(path, &options.limits)?;
    let (shape, rig) = (file.shape(), file.rig());
    let source = Source::OldHci(Box::new(file));
    let mut reader = LightFieldReader::new(path, options, LightFieldFormat::OldHci, shape, source);
    reader.rig = rig;
    Ok(reader)
}

/// Opens an HDF5 file without the files beside it.
#[cfg(feature = "hdf5")]
pub(super) fn of_hdf5(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let file = Hdf5LightField::open(path, &options.limits)?;
    let (rig, error) = (file.rig().copied(), file.rig_error().map(|error| format!("{}: {error}", path.display())));
    let (shape, is_float) = (file.shape(), file.sample_kind().is_float());
    let source = Source::Hdf5(Box::new(file));
    let mut reader = LightFieldReader::new(path, options, LightFieldFormat::Hdf5, shape, source);
    reader.color_encoding = encoding(is_float);
    reader.rig = rig;
    reader.warnings.extend(error);
    Ok(reader)
}

#[cfg(not(feature = "hdf5"))]
fn open_hdf5(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    of_hdf5(path, options)
}

#[cfg(not(feature = "hdf5"))]
pub(super) fn of_hdf5(path: &Path, _: &ReadOptions) -> Result<LightFieldReader, Error> {
    Err(needs_feature(path, "hdf5", "an HDF5 file"))
}

/// The error for what another build could read.
pub(super) fn needs_feature(path: &Path, feature: &str, what: &str) -> Error {
    Error::unsupported(path, format!("this build cannot read {what}: build it with the feature `{feature}`"))
}
