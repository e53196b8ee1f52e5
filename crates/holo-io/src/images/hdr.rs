//! Radiance HDR (`.hdr`, `.pic`): linear RGB with an 8-bit mantissa a channel and a shared exponent.
//!
//! Own code, because the one maintained crate (`image` 0.25) reads one of the eight orientations and one of the two
//! signatures, leaves exposure to its caller and multiplies run lengths without a check. This module reads the
//! signatures `#?RADIANCE` and `#?RGBE`, all orientations, flat scanlines and both run-length codings.
//!
//! # Model
//!
//! A pixel (r, g, b, e) is `(r, g, b) * 2^(e - 136)`, black where e = 0, divided by the product of the header's
//! `EXPOSURE` and `COLORCORR` lines, so that the result is the original radiance. The power of two is exact; the
//! division, where there is one, is rounded once. The tools of Radiance add half a step to the mantissas; this module
//! does not, as most other programs, so that black stays black. Primaries are assumed to be those of sRGB; `PRIMARIES`
//! is ignored.
//!
//! # Source
//!
//! Ward, *Real Pixels*, Graphics Gems II (1991), and the file format chapter of the Radiance reference manual.

mod header;
mod scanline;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use holo_core::GridSize;
use ndarray::{Array3, Axis};

use crate::error::STREAM;
use crate::files::stream::open;
use crate::{Error, Limits};
use header::{Header, Major};

/// The format's name in messages.
const FORMAT: &str = "HDR";

/// The header of a Radiance HDR file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HdrInfo {
    /// Rows and columns of the upright image.
    pub size: GridSize,
    /// Product of all `EXPOSURE` lines, 1 without any. The reader divides by it.
    pub exposure: f64,
    /// Product of all `COLORCORR` lines for red, green and blue, 1 without any. The reader divides by it.
    pub color_correction: [f64; 3],
}

/// Reads a Radiance HDR image as linear RGB.
///
/// Values are divided by exposure and color correction of the header. Bytes after the last scanline are ignored.
///
/// # Shape
///
/// `(rows, columns, 3)`, top row first, whatever the orientation in the file.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not a Radiance HDR file, is truncated or
/// damaged; [`Error::Unsupported`] if its pixels are XYZE; [`Error::TooLarge`] if the image exceeds the limits, before
/// memory is allocated for it.
pub fn read_hdr(path: impl AsRef<Path>, limits: &Limits) -> Result<Array3<f32>, Error> {
    let path = path.as_ref();
    decode(&mut open(path)?, path, *limits)
}

/// Decodes a Radiance HDR image from a stream, like [`read_hdr`]. It may read past the end of the image.
///
/// # Errors
///
/// Those of [`read_hdr`].
///
/// # Examples
///
/// ```
/// let file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x81";
/// let image = holo_io::decode_hdr(&file[..], &holo_io::Limits::default())?;
/// assert_eq!(image, ndarray::array![[[1.0, 0.5, 0.25]]]);
/// # Ok::<(), holo_io::Error>(())
/// ```
pub fn decode_hdr(source: impl Read, limits: &Limits) -> Result<Array3<f32>, Error> {
    decode(&mut BufReader::new(source), Path::new(STREAM), *limits)
}

/// Reads the header of a Radiance HDR image without its pixels.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] or [`Error::Unsupported`] if its header cannot be
/// read.
pub fn read_hdr_info(path: impl AsRef<Path>) -> Result<HdrInfo, Error> {
    let path = path.as_ref();
    Ok(Header::read(&mut open(path)?, path)?.info())
}

fn decode(source: &mut impl BufRead, path: &Path, limits: Limits) -> Result<Array3<f32>, Error> {
    let header = Header::read(source, path)?;
    let (scanlines, length) = (header.scanlines, header.length);
    let upright = header.major == Major::Rows && !header.flip_scanlines && !header.flip_pixels;
    // An image of another orientation is copied once.
    let copies = if upright { 1 } else { 2 };
    limits.elements(path, "image", &[copies, scanlines, length, 3], size_of::<f32>())?;
    // The memory is only reserved: pages are touched as data arrive, so a short file that announces a large image uses
    // little memory.
    let mut values = Limits::room(path, "image", scanlines * length * 3)?;
    let mut codes = Limits::room(path, "image", length)?;
    let scale = scales();
    let divisor = header.color_correction.map(|correction| (correction * header.exposure) as f32);
    let plain = divisor == [1.0; 3];
    for index in 0..scanlines {
        scanline::read(source, &mut codes, length).map_err(|error| {
            let at = format!("scanline {} of {scanlines}", index + 1);
            error.into_error(path, &at)
        })?;
        for &[red, green, blue, exponent] in &codes {
            let scale = scale[usize::from(exponent)];
            let color = [f32::from(red) * scale, f32::from(green) * scale, f32::from(blue) * scale];
            if plain {
                values.extend(color);
            } else {
                values.extend([color[0] / divisor[0], color[1] / divisor[1], color[2] / divisor[2]]);
            }
        }
    }
    let mut image = Array3::from_shape_vec((scanlines, length, 3), values)
        .map_err(|error| Error::broken(path, FORMAT, error.to_string()))?;
    if header.flip_scanlines {
        image.invert_axis(Axis(0));
    }
    if header.flip_pixels {
        image.invert_axis(Axis(1));
    }
    if header.major == Major::Columns {
        image.swap_axes(0, 1);
    }
    Ok(if upright { image } else { image.as_standard_layout().into_owned() })
}

/// 2^(e - 136) for every exponent e, and 0 for e = 0. The smallest, 2^-135, is a subnormal number and exact.
fn scales() -> [f32; 256] {
    let mut scales = [0.0; 256];
    for (exponent, scale) in scales.iter_mut().enumerate().skip(1) {
        // Of an f32, the exponent field is e - 136 + 127; where that is below 1, a subnormal has units of 2^-149.
        *scale = f32::from_bits(if exponent > 9 { (exponent as u32 - 9) << 23 } else { 1 << (exponent + 13) });
    }
    scales
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_exact_powers_of_two() {
        let scales = scales();
        assert_eq!(scales[0], 0.0);
        for (exponent, &scale) in scales.iter().enumerate().skip(1) {
            // f64 holds all of them as normal numbers.
            assert_eq!(f64::from(scale), 2.0_f64.powi(exponent as i32 - 136), "{exponent}");
        }
    }
}
