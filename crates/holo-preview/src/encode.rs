//! Images for the page: JPEG where an image changes many times a second, PNG where pixels count.

use holo_core::LightFieldOwned;
use holo_render::exposure;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use ndarray::{Array3, ArrayView3};

/// The quality of JPEG.
const QUALITY: u8 = 88;

/// A light field of one view, or of one row of microlenses, as 8-bit RGB, axes (row, column, channel).
pub(crate) fn codes(color: &LightFieldOwned<f32>, exposure_ev: f64) -> Result<Array3<u8>, String> {
    let coded = exposure::encode_8bit(color, exposure_ev).map_err(|why| why.to_string())?;
    coded.to_elemental_grid().map_err(|why| why.to_string())
}

pub(crate) fn jpeg(image: ArrayView3<u8>) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let (pixels, [width, height]) = flat(image);
    let mut encoder = JpegEncoder::new_with_quality(&mut out, QUALITY);
    encoder.encode(&pixels, width, height, ExtendedColorType::Rgb8).map_err(|why| why.to_string())?;
    Ok(out)
}

pub(crate) fn png(image: ArrayView3<u8>) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let color = if image.dim().2 == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    let (pixels, [width, height]) = flat(image);
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Up);
    encoder.write_image(&pixels, width, height, color).map_err(|why| why.to_string())?;
    Ok(out)
}

/// The samples row by row, width and height. Images of a page are small.
fn flat(image: ArrayView3<u8>) -> (Vec<u8>, [u32; 2]) {
    let (rows, columns, _) = image.dim();
    (image.iter().copied().collect(), [columns as u32, rows as u32])
}
