//! An image in the format of its file extension or of its contents.

use std::path::Path;

use holo_core::{ColorEncoding, DynImage, DynImageRef, GridSize, SampleKind};
use ndarray::{ArrayView3, Axis};

use crate::images::linear_image::{plain_channels, read_plain_exr};
use crate::images::sgi::{SgiInfo, read_sgi, read_sgi_info};
use crate::{Compression, Error, FileDigest, Limits, read_png, read_png_info, write_pfm, write_pfm_rgb, write_png};
use crate::{FileFormat, files::detect_format};

/// The size and samples of an image of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ImageInfo {
    pub(crate) size: GridSize,
    pub(crate) channels: usize,
    pub(crate) kind: SampleKind,
}

/// The extension of a name in lower case; empty if there is none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// Reads the header of a PNG, TIFF, OpenEXR or SGI image.
pub(crate) fn read_image_info(path: &Path) -> Result<ImageInfo, Error> {
    match detect_format(path)? {
        FileFormat::Tiff | FileFormat::Dng => {
            let crate::TiffInfo { size, channels, kind } = crate::read_tiff_info(path)?;
            return Ok(ImageInfo { size, channels, kind });
        }
        FileFormat::Exr => {
            let info = crate::read_exr_info(path)?;
            let channels = plain_channels(&info, path)?;
            return Ok(ImageInfo { size: info.size, channels, kind: SampleKind::F32 });
        }
        FileFormat::Sgi => {
            let SgiInfo { size, channels, kind } = read_sgi_info(path)?;
            return Ok(ImageInfo { size, channels, kind });
        }
        _ => {}
    }
    let info = read_png_info(path)?;
    let kind = if info.bits == 16 { SampleKind::U16 } else { SampleKind::U8 };
    Ok(ImageInfo { size: info.size, channels: info.channels, kind })
}

/// Reads a PNG, TIFF, OpenEXR or SGI image.
pub(crate) fn read_image(path: &Path, limits: &Limits) -> Result<DynImage, Error> {
    match detect_format(path)? {
        FileFormat::Tiff | FileFormat::Dng => return crate::read_tiff(path, limits),
        FileFormat::Exr => return Ok(read_plain_exr(path, limits)?.into()),
        FileFormat::Sgi => return read_sgi(path, limits),
        _ => {}
    }
    read_png(path, limits)
}

/// Writes an image as `.png`, `.pfm` or `.tif`: integers, which follow the sRGB curve, as PNG or TIFF; floats, which are
/// linear, as PFM or TIFF.
///
/// # Accuracy
///
/// `f64` is rounded to `f32` in a PFM; all other values are written as they are.
///
/// # Shape
///
/// `(rows, columns, channels)`, any strides: 1 to 4 channels in a PNG, 1 or 3 in a PFM, 1, 3 or 4 in a TIFF.
///
/// # Errors
///
/// [`Error::BadInput`] if the extension is another one, or not the one for these samples; those of [`write_png`],
/// [`write_pfm`] and `write_tiff`.
///
/// # Examples
///
/// ```
/// use holo_io::write_image;
/// use ndarray::Array3;
///
/// # let folder = tempfile::tempdir()?;
/// write_image(folder.path().join("view.png"), Array3::<u16>::zeros((4, 5, 3)).view())?;
/// write_image(folder.path().join("view.pfm"), Array3::<f32>::zeros((4, 5, 3)).view())?;
/// assert!(write_image(folder.path().join("view.png"), Array3::<f32>::zeros((4, 5, 3)).view()).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_image<'a>(path: impl AsRef<Path>, image: impl Into<DynImageRef<'a>>) -> Result<FileDigest, Error> {
    let (path, image) = (path.as_ref(), image.into());
    let is = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
    if is("tif") || is("tiff") {
        return crate::write_tiff(path, image);
    }
    match (image, image.kind()) {
        (image, SampleKind::U8 | SampleKind::U16) if is("png") => {
            write_png(path, image, ColorEncoding::Srgb, Compression::Best)
        }
        (DynImageRef::F32(image), _) if is("pfm") => write_floats(path, image),
        (DynImageRef::F64(image), _) if is("pfm") => write_floats(path, image.mapv(|value| value as f32).view()),
        (_, kind) if kind.is_float() => {
            Err(Error::bad_input(path, "linear floats cannot be written into a PNG; end the name in .pfm or .tif"))
        }
        _ => Err(Error::bad_input(
            path,
            "integers on the sRGB curve are written into a PNG; end the name in .png or .tif",
        )),
    }
}

fn write_floats(path: &Path, image: ArrayView3<'_, f32>) -> Result<FileDigest, Error> {
    match image.dim().2 {
        1 => write_pfm(path, image.index_axis_move(Axis(2), 0)),
        _ => write_pfm_rgb(path, image),
    }
}
