//! Writes an image in the format of its file extension.

use std::path::Path;

use holo_core::{ColorEncoding, DynImageRef, SampleKind};
use ndarray::{ArrayView3, Axis};

use crate::{Compression, Error, FileDigest, write_pfm, write_pfm_rgb, write_png};

/// Writes an image as `.png` or `.pfm`: integers, which follow the sRGB curve, as PNG; floats, which are linear, as
/// PFM.
///
/// # Accuracy
///
/// `f64` is rounded to `f32`; all other values are written as they are.
///
/// # Shape
///
/// `(rows, columns, channels)`, any strides: 1 to 4 channels in a PNG, 1 or 3 in a PFM.
///
/// # Errors
///
/// [`Error::BadInput`] if the extension is another one, or not the one for these samples; those of [`write_png`] and
/// [`write_pfm`].
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
    match (image, image.kind()) {
        (image, SampleKind::U8 | SampleKind::U16) if is("png") => {
            write_png(path, image, ColorEncoding::Srgb, Compression::Best)
        }
        (DynImageRef::F32(image), _) if is("pfm") => write_floats(path, image),
        (DynImageRef::F64(image), _) if is("pfm") => write_floats(path, image.mapv(|value| value as f32).view()),
        (_, kind) if kind.is_float() => {
            Err(Error::bad_input(path, "linear floats cannot be written into a PNG; end the name in .pfm"))
        }
        _ => Err(Error::bad_input(path, "integers on the sRGB curve are written into a PNG; end the name in .png")),
    }
}

fn write_floats(path: &Path, image: ArrayView3<'_, f32>) -> Result<FileDigest, Error> {
    match image.dim().2 {
        1 => write_pfm(path, image.index_axis_move(Axis(2), 0)),
        _ => write_pfm_rgb(path, image),
    }
}
