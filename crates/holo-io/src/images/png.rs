//! PNG of 8 and 16 bits a channel, sRGB or linear.

mod animation;
mod bands;
mod decode;
mod encode;
mod filter;
mod stream;

use std::io::Write;
use std::path::Path;

use holo_core::{ColorEncoding, DynImageRef, GridSize, SampleKind};
use ndarray::ArrayView2;

use crate::error::STREAM;
use crate::files::folder::Destination;
use crate::files::stream::write_bytes;
use crate::{Error, FileDigest};
use encode::Encoder;

pub use animation::write_png_animation;
pub use decode::{decode_png, read_png, read_png_info};
pub use stream::PngWriter;

/// Compression of a PNG: speed or size. The pixels are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Compression {
    /// Fast, for files that are read once or twice.
    #[default]
    Fast,
    /// Small files, several times slower; for files that are kept or published.
    Best,
}

/// The header of a PNG.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PngInfo {
    /// Rows and columns.
    pub size: GridSize,
    /// Channels as [`read_png`] returns them, 1 to 4.
    pub channels: usize,
    /// Bits per channel as [`read_png`] returns them, 8 or 16.
    pub bits: u8,
    /// The sRGB curve if the file says so, else unknown: [`Linear`](ColorEncoding::Linear).
    pub encoding: ColorEncoding,
}

/// Writes an image of 8 or 16 bits a channel as PNG.
///
/// Rows are streamed: the image is not copied as a whole, whatever its strides.
///
/// # Shape
///
/// `image` is `(rows, columns, channels)` with 1 (gray), 2 (gray, alpha), 3 (RGB) or 4 (RGB, alpha) channels; any
/// strides.
///
/// # Errors
///
/// [`Error::BadInput`] if the image holds floats, is empty, has another number of channels or more than 2^31 - 1 rows
/// or columns; [`Error::Io`] if the file cannot be written. No file of that name appears then.
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
    path: impl Destination,
    image: impl Into<DynImageRef<'a>>,
    encoding: ColorEncoding,
    compression: Compression,
) -> Result<FileDigest, Error> {
    let image = image.into();
    let mut writer = PngWriter::create(path, image.size(), image.channels(), image.kind(), encoding, compression)?;
    writer.write_rows(image)?;
    writer.finish()
}

/// Encodes an image of 8 or 16 bits a channel as a PNG into a stream: the bytes that [`write_png`] writes.
///
/// They are encoded in memory first.
///
/// # Shape
///
/// As in [`write_png`].
///
/// # Errors
///
/// [`Error::BadInput`] as in [`write_png`]; [`Error::Io`] if `out` cannot be written.
pub fn encode_png<'a>(
    out: impl Write,
    image: impl Into<DynImageRef<'a>>,
    encoding: ColorEncoding,
    compression: Compression,
) -> Result<(), Error> {
    let image = image.into();
    let layout = encode::Layout::new(image.size(), image.channels(), image.kind(), Path::new(STREAM))?;
    let mut encoder = Encoder::new(Vec::new(), layout, encoding, None, compression)?;
    encoder.write_rows(image)?;
    write_bytes(out, &encoder.finish()?)
}

/// Writes a disparity map as a gray 8-bit PNG: brighter is nearer.
///
/// # Shape
///
/// `disparity_px` is `(rows, columns)`; any strides.
///
/// # Units
///
/// Pixels between adjacent views. `min_px` becomes 0 and `max_px` becomes 255, linear between and clamped outside; NaN
/// becomes 0. If the two are equal, pixels above them become 255 and all others 0. The text `Description` of the PNG says
/// the two numbers, and so does the manifest of a dataset folder.
///
/// # Errors
///
/// [`Error::BadInput`] if `min_px` or `max_px` is not finite, if `min_px` is greater, or if the map is empty;
/// [`Error::Io`] if the file cannot be written.
pub fn write_disparity_png(
    path: impl Destination,
    disparity_px: ArrayView2<'_, f32>,
    min_px: f64,
    max_px: f64,
    compression: Compression,
) -> Result<FileDigest, Error> {
    if !(min_px.is_finite() && max_px.is_finite() && min_px <= max_px) {
        return Err(Error::bad_input(
            path.path(),
            format!("a disparity range of {min_px} to {max_px} px cannot be shown"),
        ));
    }
    let gray = disparity_px.mapv(|disparity_px| gray_level(f64::from(disparity_px), min_px, max_px));
    let gray = gray.insert_axis(ndarray::Axis(2));
    let text = format!("disparity, px between adjacent views: {min_px} is 0, {max_px} is 255, linear");
    let size = GridSize::new(gray.dim().0, gray.dim().1);
    let layout = encode::Layout::new(size, 1, SampleKind::U8, path.path())?;
    let mut writer = PngWriter::described(path, layout, ColorEncoding::Linear, Some(&text), compression)?;
    writer.write_rows(gray.view())?;
    writer.finish()
}

/// Maps `min_px..=max_px` to `0..=255`.
fn gray_level(disparity_px: f64, min_px: f64, max_px: f64) -> u8 {
    // Halved, because the difference of two finite numbers may overflow.
    let share = (disparity_px / 2.0 - min_px / 2.0) / (max_px / 2.0 - min_px / 2.0);
    // `as` converts NaN (0/0 included) to 0 and clamps the infinities.
    (share * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gray_levels_are_linear_and_clamped() {
        let level = |value| gray_level(value, -2.0, 3.1);
        assert_eq!([level(-2.0), level(3.1), level(0.55)], [0, 255, 128]);
        assert_eq!([level(-9.0), level(f64::NEG_INFINITY), level(f64::NAN)], [0, 0, 0]);
        assert_eq!([level(9.0), level(f64::INFINITY)], [255, 255]);
        assert_eq!(gray_level(1.0, 1.0, 1.0), 0);
        assert_eq!(gray_level(f64::MAX, f64::MIN, f64::MAX), 255);
        assert_eq!(gray_level(0.0, f64::MIN, f64::MAX), 128);
    }
}
