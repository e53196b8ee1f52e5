//! The raw image of a plenoptic camera, opened as the views that it will be decoded to.

use std::path::Path;

use holo_core::ColorEncoding;

use super::options::ReadOptions;
use super::reader::{LightFieldFormat, LightFieldReader};
use super::source::Source;
use crate::files::names::{CAMERA_TOML, is_regular};
use crate::images::image_file::read_image_info;
use crate::{CameraFile, Error};

/// The camera beside an image, if the image may be its raw image: of the size of its sensor, and with colors. The codes of
/// a sensor behind a color filter and white images in integers have one channel.
pub(super) fn camera_beside(image: &Path) -> Result<Option<CameraFile>, Error> {
    let path = image.with_file_name(CAMERA_TOML);
    if !is_regular(&path) {
        return Ok(None);
    }
    let (info, file) = (read_image_info(image)?, CameraFile::read(&path)?);
    let may_be_raw = info.size == file.camera.sensor().size && (info.channels >= 3 || info.kind.is_float());
    Ok(may_be_raw.then_some(file))
}

/// Opens the raw image of a camera, without its pixels.
pub(super) fn open(image: &Path, file: CameraFile, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let nothing = |what: String| Error::NoLightField { path: image.to_owned(), what };
    let (size, sensor) = (read_image_info(image)?.size, file.camera.sensor().size);
    if size != sensor {
        return Err(nothing(format!(
            "it has {size} pixels, but the sensor of the camera '{}' in {CAMERA_TOML} has {sensor}",
            crate::shown(&file.name)
        )));
    }
    let impossible = |error: holo_core::Error| nothing(error.to_string());
    let views = match options.views {
        None => file.camera.decodable_views().map_err(impossible)?,
        Some(views) if views.rows == views.columns => views.rows,
        Some(views) => {
            let what = format!("a plenoptic camera is decoded to as many views along both axes, not to {views}");
            return Err(Error::MissingOption { path: image.to_owned(), option: "views", what });
        }
    };
    let rig = file.camera.decoded_rig(views).map_err(impossible)?;
    let source = Source::Plenoptic { file: image.to_owned(), camera: Box::new(file) };
    let mut reader = LightFieldReader::new(image, options, LightFieldFormat::Plenoptic, *rig.shape(), source);
    (reader.rig, reader.color_encoding) = (Some(rig), ColorEncoding::Linear);
    Ok(reader)
}
