//! PNG of 8 and 16 bits a channel, in sRGB or as plain data.

mod animation;
mod bands;
mod decode;
mod encode;
mod filter;
mod stream;

use std::path::Path;

use holo_core::{ColorEncoding, DynImageRef, GridSize};
use ndarray::ArrayView2;

use crate::error::MEMORY;
use crate::{Error, FileDigest};
use encode::Encoder;

pub use animation::write_png_animation;
pub use decode::{decode_png, read_png, read_png_info};
pub use stream::PngWriter;

/// How hard to compress a PNG. The pixels are the same either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Compression {
    /// Quick: a third of a second for an 8K image of 8-bit RGB. For files that are read once or twice.
    #[default]
    Fast,
    /// Small: a few times slower. For files that are kept and passed on.
    Best,
}

/// What a PNG's header says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PngInfo {
    /// Rows and columns.
    pub size: GridSize,
    /// Channels as [`read_png`] returns them, 1 to 4.
    pub channels: usize,
    /// Bits per channel as [`read_png`] returns them, 8 or 16.
    pub bits: u8,
}

/// Writes an image of 8 or 16 bits a channel.
///
/// Rows are streamed: no second copy of the image is made, whatever its strides.
///
/// # Shape
///
/// `image` is `(rows, columns, channels)` with 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGB, alpha) channels; any
/// strides.
///
/// # Errors
///
/// [`Error::BadInput`] if the image holds floats, is empty, has another number of channels or more than 2^31 - 1 rows or
/// columns; [`Error::Io`] if the file cannot be written. No file of that name appears then.
///
/// # Examples
///
/// ```
/// use holo_core::{ColorEncoding, DynImage};
/// use holo_io::{Compression, Limits, read_png, write_png};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("image.png");
/// let image = ndarray::Array3::from_shape_fn((5, 7, 3), |(row, column, _)| (row * 30 + column * 4) as u8);
/// let written = write_png(&path, image.view(), ColorEncoding::Srgb, Compression::Fast)?;
/// assert_eq!(read_png(&path, &Limits::default())?, DynImage::U8(image));
/// assert_eq!(written.bytes, std::fs::metadata(&path)?.len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_png<'a>(
    path: impl AsRef<Path>,
    image: impl Into<DynImageRef<'a>>,
    encoding: ColorEncoding,
    compression: Compression,
) -> Result<FileDigest, Error> {
    let image = image.into();
    let mut writer = PngWriter::create(path, image.size(), image.channels(), image.kind(), encoding, compression)?;
    writer.write_rows(image)?;
    writer.finish()
}

/// Returns an image of 8 or 16 bits a channel as the bytes of a PNG file, such as for a page that embeds it.
///
/// # Shape
///
/// As in [`write_png`].
///
/// # Errors
///
/// [`Error::BadInput`] as in [`write_png`].
pub fn encode_png<'a>(
    image: impl Into<DynImageRef<'a>>,
    encoding: ColorEncoding,
    compression: Compression,
) -> Result<Vec<u8>, Error> {
    let image = image.into();
    let layout = encode::Layout::new(image.size(), image.channels(), image.kind(), Path::new(MEMORY))?;
    let mut encoder = Encoder::new(Vec::new(), layout, encoding, compression)?;
    encoder.write_rows(image)?;
    encoder.finish()
}

/// Writes a disparity map as a grey 8-bit picture: brighter is nearer.
///
/// # Shape
///
/// `disparity_px` is `(rows, columns)`; any strides.
///
/// # Units
///
/// `min_px` becomes 0 and `max_px` becomes 255, linear between and clamped outside; NaN becomes 0. Where the two are
/// equal, every pixel that is not above them becomes 0. The numbers belong in the manifest, because the picture alone
/// does not tell them.
///
/// # Errors
///
/// [`Error::BadInput`] if `min_px` or `max_px` is not finite, if `min_px` is the larger, or if the map is empty;
/// [`Error::Io`] if the file cannot be written.
pub fn write_disparity_png(
    path: impl AsRef<Path>,
    disparity_px: ArrayView2<'_, f32>,
    min_px: f64,
    max_px: f64,
    compression: Compression,
) -> Result<FileDigest, Error> {
    let path = path.as_ref();
    if !(min_px.is_finite() && max_px.is_finite() && min_px <= max_px) {
        return Err(Error::bad_input(path, format!("a disparity range of {min_px} to {max_px} px cannot be drawn")));
    }
    let grey = disparity_px.mapv(|disparity_px| grey_level(f64::from(disparity_px), min_px, max_px));
    let grey = grey.insert_axis(ndarray::Axis(2));
    write_png(path, grey.view(), ColorEncoding::Linear, compression)
}

/// Maps `min_px..=max_px` to `0..=255`.
fn grey_level(disparity_px: f64, min_px: f64, max_px: f64) -> u8 {
    // Halved, because the difference of two finite numbers need not be finite.
    let share = (disparity_px / 2.0 - min_px / 2.0) / (max_px / 2.0 - min_px / 2.0);
    // `as` turns NaN (0/0 included) into 0 and clamps the infinities.
    (share * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_levels_are_linear_and_clamped() {
        let level = |value| grey_level(value, -2.0, 3.1);
        assert_eq!([level(-2.0), level(3.1), level(0.55)], [0, 255, 128]);
        assert_eq!([level(-9.0), level(f64::NEG_INFINITY), level(f64::NAN)], [0, 0, 0]);
        assert_eq!([level(9.0), level(f64::INFINITY)], [255, 255]);
        assert_eq!(grey_level(1.0, 1.0, 1.0), 0);
        assert_eq!(grey_level(f64::MAX, f64::MIN, f64::MAX), 255);
        assert_eq!(grey_level(0.0, f64::MIN, f64::MAX), 128);
    }
}
