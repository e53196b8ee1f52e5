//! Environment maps: from PNG and JPEG panoramas, and the default sky for scenes without light.

use std::io::Cursor;

use holo_core::color::srgb_to_linear;
use image::{ImageFormat, ImageReader};
use ndarray::Array3;
use rayon::prelude::*;

use crate::gltf::{Limits, panic_guard};
use crate::{Environment, Error};

/// The formats of panoramas.
const FORMATS: [ImageFormat; 3] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP];
/// The sizes of [`Environment::overcast`], rows and columns.
const OVERCAST: [usize; 2] = [64, 64];
/// The reflectance of the ground below the overcast sky.
const GROUND: f64 = 0.2;
/// How much brighter the bright side of the overcast sky is than its mean at the same elevation, and how much darker
/// the other side.
const SIDE: f64 = 0.6;

impl Environment {
    /// Decodes an equirectangular panorama of 8 or 16 bits a channel: a PNG, JPEG or WebP file in memory. Its codes are
    /// sRGB and become linear radiance from 0 to 1; alpha and color profiles are ignored.
    ///
    /// Such images are clipped: the sun in a photograph is not brighter than white, so its shadows are missing. HDR and
    /// OpenEXR files have the radiance of the sun.
    ///
    /// # Errors
    /// [`Error::BadFile`] for data that is none of these formats or damaged, and for images of more pixels than
    /// [`Limits::max_texture_pixels`].
    pub fn from_image(bytes: &[u8], limits: &Limits) -> Result<Self, Error> {
        panic_guard::catch("environment", || decode(bytes, limits.max_texture_pixels)).map(|radiance| Self { radiance })
    }

    /// A sky for scenes that have no light: the standard overcast sky of the CIE with radiance 1 at the zenith and 1/3
    /// at the horizon, above a ground of reflectance 0.2. To one side, (-1, 0, 1), it is brighter by 60 %, to the other
    /// darker by as much, so that walls at right angles differ.
    ///
    /// # Source
    /// P. Moon and D. E. Spencer, *Illumination from a non-uniform sky*, 1942: L = Lz (1 + 2 sin g) / 3 at the elevation
    /// g. The illuminance on the ground is 7/9 pi Lz. The bright side is an addition.
    #[must_use]
    pub fn overcast() -> Self {
        let [rows, columns] = OVERCAST;
        let radiance = Array3::from_shape_fn((rows, columns, 3), |(row, column, _)| {
            let polar = (row as f64 + 0.5) / rows as f64 * std::f64::consts::PI;
            let up = polar.cos();
            if up < 0.0 {
                return (GROUND * 7.0 / 9.0) as f32;
            }
            // The direction (x, y, z) of a column: see `Environment`.
            let azimuth = ((column as f64 + 0.5) / columns as f64 - 0.5) * std::f64::consts::TAU;
            let toward = polar.sin() * (azimuth.sin() - azimuth.cos()) * std::f64::consts::FRAC_1_SQRT_2;
            ((1.0 + 2.0 * up) / 3.0 * (1.0 + SIDE * toward)) as f32
        });
        Self { radiance }
    }
}

/// Linear RGB of an image, shape (rows, columns, 3).
fn decode(bytes: &[u8], max_pixels: u64) -> Result<Array3<f32>, Error> {
    let bad = |what: String| Error::BadFile { at: "environment".into(), what };
    let failed = |why: image::ImageError| bad(format!("the image cannot be decoded: {why}"));
    let format = image::guess_format(bytes).ok().filter(|format| FORMATS.contains(format));
    let format = format.ok_or_else(|| bad("the image is neither PNG nor JPEG nor WebP".into()))?;
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(failed)?;
    let pixels = u64::from(width).saturating_mul(u64::from(height));
    if pixels == 0 || pixels > max_pixels {
        return Err(bad(format!("an image of {width} x {height} pixels; 1 to {max_pixels} pixels are read")));
    }
    let mut reader = reader();
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(width);
    limits.max_image_height = Some(height);
    // 16-bit RGBA, once for the decoder and once for the image, and some memory for tables.
    limits.max_alloc = Some(pixels.saturating_mul(16).saturating_add(64 << 20));
    reader.limits(limits);
    // A code c of 8 bits becomes 257 c, which is the same share of the largest code.
    let image = reader.decode().map_err(failed)?.into_rgb16();
    let linear: Vec<f32> = (0..=u16::MAX).map(|c| srgb_to_linear(f64::from(c) / f64::from(u16::MAX)) as f32).collect();
    let values = image.as_raw().par_iter().map(|&code| linear[usize::from(code)]).collect();
    Array3::from_shape_vec((height as usize, width as usize, 3), values).map_err(|why| bad(why.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageBuffer, Luma, Rgb};

    fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn read(bytes: &[u8]) -> Array3<f32> {
        Environment::from_image(bytes, &Limits::default()).unwrap().radiance
    }

    #[test]
    fn panoramas_are_decoded_to_linear_light() {
        // Row 1, column 0 has the codes 0, 188, 255; sRGB 188 of 255 is 0.5029 linear.
        let image =
            ImageBuffer::from_fn(2, 2, |x, y| if (x, y) == (0, 1) { Rgb([0u8, 188, 255]) } else { Rgb([9; 3]) });
        let radiance = read(&encode(image, ImageFormat::Png));
        assert_eq!(radiance.dim(), (2, 2, 3));
        assert_eq!((radiance[[1, 0, 0]], radiance[[1, 0, 2]]), (0.0, 1.0));
        assert_eq!(radiance[[1, 0, 1]], srgb_to_linear(188.0 / 255.0) as f32);
        assert!((radiance[[1, 0, 1]] - 0.5029).abs() < 1e-4);
        // 16 bits keep what 8 bits would round.
        let fine = ImageBuffer::from_pixel(3, 1, Rgb([0u16, 48_000, 48_001]));
        let radiance = read(&encode(fine, ImageFormat::Png));
        assert_eq!(radiance[[0, 2, 1]], srgb_to_linear(48_000.0 / 65_535.0) as f32);
        assert!(radiance[[0, 2, 2]] > radiance[[0, 2, 1]]);
        // Gray is the same in three channels; a uniform JPEG is exact up to its rounding.
        assert_eq!(
            read(&encode(ImageBuffer::from_pixel(1, 1, Luma([255u8])), ImageFormat::Png)),
            Array3::<f32>::ones((1, 1, 3))
        );
        let jpeg = read(&encode(ImageBuffer::from_pixel(16, 8, Rgb([188u8; 3])), ImageFormat::Jpeg));
        assert_eq!(jpeg.dim(), (8, 16, 3));
        assert!(jpeg.iter().all(|x| (x - 0.5029).abs() < 0.01));
    }

    #[test]
    fn other_and_damaged_images_are_errors() {
        let png = encode(ImageBuffer::from_pixel(8, 8, Rgb([1u8; 3])), ImageFormat::Png);
        let small = Limits { max_texture_pixels: 63, ..Limits::default() };
        assert!(Environment::from_image(&png, &small).unwrap_err().to_string().contains("8 x 8"));
        for damaged in [&b""[..], b"hello", &png[..png.len() / 2], b"GIF89a"] {
            assert!(Environment::from_image(damaged, &Limits::default()).is_err());
        }
    }

    #[test]
    fn the_overcast_sky_is_bright_above_and_to_one_side() {
        let radiance = Environment::overcast().radiance;
        let at = |row: usize, column: usize| radiance[[row, column, 0]];
        let mean = |row: usize| (0..OVERCAST[1]).map(|column| at(row, column)).sum::<f32>() / OVERCAST[1] as f32;
        assert!((mean(0) - 1.0).abs() < 1e-3 && (mean(OVERCAST[0] / 2 - 1) - 1.0 / 3.0).abs() < 0.02);
        // The illuminance on the ground, 7/9 pi, by the midpoint rule: its error is of the order of a squared row.
        let step = std::f64::consts::PI / OVERCAST[0] as f64;
        let polar = |row: usize| (row as f64 + 0.5) * step;
        let sum: f64 = (0..OVERCAST[0] / 2)
            .map(|row| f64::from(mean(row)) * polar(row).cos() * polar(row).sin() * step * std::f64::consts::TAU)
            .sum();
        assert!((sum - 7.0 / 9.0 * std::f64::consts::PI).abs() < step * step, "{sum}");
        assert!((at(63, 3) - 0.2 * 7.0 / 9.0).abs() < 1e-6);
        // Direction (-1, 0, 1): atan2(1, -1) = 3/4 pi, at 7/8 of the width; the dark side is at 3/8.
        let horizon = OVERCAST[0] / 2 - 1;
        assert!(at(horizon, 56) > 3.0 * at(horizon, 24));
        assert!(radiance.iter().all(|x| (0.0..=1.2).contains(x)));
    }
}
