//! TIFF of 8- and 16-bit integers and of 32- and 64-bit floats: what ImageJ, MATLAB, OpenCV and tifffile exchange.
//!
//! Through the crate `tiff`. One image a file, without color profile: integers follow the sRGB curve and floats are linear
//! by this crate's convention, as in PNG and PFM.

mod decode;
mod encode;

use std::io::Write;
use std::path::Path;

use holo_core::{DynImageRef, GridSize, SampleKind};

use crate::error::STREAM;
use crate::files::folder::Destination;
use crate::files::stream::write_bytes;
use crate::{Error, FileDigest, write_file};

pub use decode::{decode_tiff, read_tiff, read_tiff_info};

/// The name of the format in messages.
const FORMAT: &str = "TIFF";

/// The header of a TIFF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TiffInfo {
    /// Rows and columns.
    pub size: GridSize,
    /// Channels, 1 to 4.
    pub channels: usize,
    /// The type of the samples.
    pub kind: SampleKind,
}

/// Writes an image as TIFF, deflated: the samples as they are, integers with a horizontal predictor.
///
/// The file is encoded in memory first.
///
/// # Shape
///
/// `(rows, columns, channels)` with 1 (gray), 3 (RGB) or 4 (RGB, alpha) channels; any strides.
///
/// # Errors
///
/// [`Error::BadInput`] if the image is empty, has another number of channels, or more than 4 GiB of samples;
/// [`Error::Io`] if the file cannot be written. No file of that name appears then.
///
/// # Examples
///
/// ```
/// use holo_core::DynImage;
/// use holo_io::{Limits, read_tiff, write_tiff};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("disparity.tif");
/// let image = ndarray::Array3::from_shape_fn((5, 7, 1), |(row, column, _)| row as f32 - 0.25 * column as f32);
/// write_tiff(&path, image.view())?;
/// assert_eq!(read_tiff(&path, &Limits::default())?, DynImage::F32(image));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_tiff<'a>(path: impl Destination, image: impl Into<DynImageRef<'a>>) -> Result<FileDigest, Error> {
    let encoded = encode::encode(path.path(), image.into())?;
    write_file(path, &encoded)
}

/// Encodes an image as TIFF into a stream: the bytes that [`write_tiff`] writes.
///
/// # Shape
///
/// As in [`write_tiff`].
///
/// # Errors
///
/// [`Error::BadInput`] as in [`write_tiff`]; [`Error::Io`] if `out` cannot be written.
pub fn encode_tiff<'a>(out: impl Write, image: impl Into<DynImageRef<'a>>) -> Result<(), Error> {
    write_bytes(out, &encode::encode(Path::new(STREAM), image.into())?)
}
