//! Images in linear light, from the files that hold them.

use std::path::Path;

use holo_core::color::srgb_to_linear;
use holo_core::{ColorEncoding, DynImage};
use ndarray::{Array3, Axis, Slice};

use crate::{Error, FileFormat, Limits, files::detect_format, read_pfm, read_png, read_png_info};
use crate::{ExrInfo, read_exr, read_exr_info, read_exr_rgb};

/// Reads an image in linear light: OpenEXR, PFM, PNG or TIFF.
///
/// Codes of a PNG become values from 0 to 1: along the sRGB curve if the file says that it has that, else in proportion.
/// Codes of a TIFF are taken along the sRGB curve, floats as they are. Of an OpenEXR the channels R, G and B without a
/// layer are read, else Y. Alpha is dropped.
///
/// # Shape
///
/// `(rows, columns, channels)` with 1 or 3 channels, top row first.
///
/// # Errors
///
/// Those of the readers of the formats; [`Error::Unsupported`] if an OpenEXR has other channels; [`Error::TooLarge`] if
/// the values exceed the limits, before memory is allocated for them.
///
/// # Examples
///
/// ```
/// use holo_io::{ColorEncoding, Compression, Limits, read_linear, write_png};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("raw_linear.png");
/// let codes = ndarray::Array3::<u16>::from_elem((2, 3, 3), 65_535);
/// write_png(&path, codes.view(), ColorEncoding::Linear, Compression::Fast)?;
/// assert_eq!(read_linear(&path, &Limits::default())?, ndarray::Array3::<f32>::ones((2, 3, 3)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_linear(path: impl AsRef<Path>, limits: &Limits) -> Result<Array3<f32>, Error> {
    let path = path.as_ref();
    match detect_format(path)? {
        FileFormat::Exr => read_plain_exr(path, limits),
        FileFormat::Pfm => Ok(read_pfm(path, limits)?.values),
        FileFormat::Tiff | FileFormat::Dng => {
            let info = crate::read_tiff_info(path)?;
            check_memory(path, [info.size.rows, info.size.columns, info.channels], limits)?;
            Ok(linear(crate::read_tiff(path, limits)?, ColorEncoding::Srgb))
        }
        _ => {
            let info = read_png_info(path)?;
            check_memory(path, [info.size.rows, info.size.columns, info.channels], limits)?;
            Ok(linear(read_png(path, limits)?, info.encoding))
        }
    }
}

fn check_memory(path: &Path, counts: [usize; 3], limits: &Limits) -> Result<(), Error> {
    limits.elements(path, "image", &counts, size_of::<f32>()).map(|_| ())
}

/// Values in linear light, without alpha; codes follow `encoding`.
fn linear(image: DynImage, encoding: ColorEncoding) -> Array3<f32> {
    let decoded = |code: f64| if encoding == ColorEncoding::Srgb { srgb_to_linear(code) } else { code };
    let image = match image {
        DynImage::U8(image) => image.mapv(|code| decoded(f64::from(code) / 255.0) as f32),
        DynImage::U16(image) => image.mapv(|code| decoded(f64::from(code) / 65_535.0) as f32),
        DynImage::F32(image) => image,
        DynImage::F64(image) => image.mapv(|value| value as f32),
    };
    let channels = image.dim().2;
    let kept = if channels >= 3 { 3 } else { 1 };
    if kept == channels {
        return image;
    }
    image.slice_axis(Axis(2), Slice::from(..kept)).as_standard_layout().into_owned()
}

/// Reads the channels of an OpenEXR that are in no layer: R, G and B, or Y.
pub(crate) fn read_plain_exr(path: &Path, limits: &Limits) -> Result<Array3<f32>, Error> {
    if plain_channels(&read_exr_info(path)?, path)? == 3 {
        return read_exr_rgb(path, limits);
    }
    let gray = read_exr(path, limits)?.channels.into_iter().find_map(|(name, plane)| (name == GRAY).then_some(plane));
    gray.map(|plane| plane.insert_axis(Axis(2))).ok_or_else(|| without_color(path))
}

const GRAY: &str = "Y";

/// The number of channels that [`read_plain_exr`] reads.
pub(crate) fn plain_channels(info: &ExrInfo, path: &Path) -> Result<usize, Error> {
    let has = |name: &str| info.channels.iter().any(|own| own == name);
    match (["R", "G", "B"].into_iter().all(has), has(GRAY)) {
        (true, _) => Ok(3),
        (false, true) => Ok(1),
        (false, false) => Err(without_color(path)),
    }
}

fn without_color(path: &Path) -> Error {
    Error::unsupported(path, "it has neither channels R, G, B nor Y")
}
