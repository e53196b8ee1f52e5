//! Animations of any of the formats, by the extension of the name.

use std::path::Path;

use holo_core::Sample;
use ndarray::ArrayView3;

use crate::{ColorEncoding, Error, images::image_file};

/// Writes frames as an animation: `.gif`, `.mp4` or `.png` (animated PNG), in 8 bits where the format has no more.
///
/// # Shape
///
/// Every frame is `(rows, columns, channels)` with 1 (gray) or 3 (RGB) channels of 8 or 16 bits with the sRGB curve, all
/// of the same shape; any strides.
///
/// # Errors
///
/// [`Error::BadInput`] if the extension is another one; those of [`write_gif_animation`](crate::write_gif_animation),
/// [`write_mp4_animation`](crate::write_mp4_animation) and [`write_png_animation`](crate::write_png_animation).
pub fn write_animation<T: Sample>(
    path: impl AsRef<Path>,
    frames: &[ArrayView3<'_, T>],
    frames_per_second: f64,
) -> Result<(), Error> {
    let path = path.as_ref();
    match image_file::extension(path).as_str() {
        "gif" => crate::write_gif_animation(path, frames, frames_per_second).map(drop),
        "mp4" => crate::write_mp4_animation(path, frames, frames_per_second),
        "png" => crate::write_png_animation(path, frames, frames_per_second, ColorEncoding::Srgb).map(drop),
        _ => Err(Error::bad_input(path, "an animation is a PNG, GIF or MP4; end its name so")),
    }
}
