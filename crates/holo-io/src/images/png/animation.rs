//! Animated PNG.

use std::path::Path;

use holo_core::{ColorEncoding, GridSize, Sample};
use ndarray::ArrayView3;

use super::encode::{Layout, gather_image};
use crate::{AtomicFile, Error, FileDigest};

/// Unit of the frame delay: ticks a second.
const TICKS: f64 = 100.0;

/// Writes frames as an animated PNG that loops forever. Programs without support for animation show the first frame.
///
/// # Shape
///
/// Every frame is `(rows, columns, channels)` as in [`write_png`](crate::write_png), all of the same shape; any
/// strides.
///
/// # Units
///
/// `frames_per_second` is rounded to hundredths.
///
/// # Errors
///
/// [`Error::BadInput`] if there are no frames or more than 2^31 - 1, if their shapes differ, if the samples are floats
/// or the shape is not one of [`write_png`](crate::write_png), or if `frames_per_second` is not 0.01 to 600;
/// [`Error::Io`] if the file cannot be written. No file of that name appears then.
///
/// # Source
///
/// "Portable Network Graphics (PNG) Specification", third edition (W3C, 2025), chapter 4.9.
///
/// # Examples
///
/// ```
/// use holo_io::{ColorEncoding, write_png_animation};
/// use ndarray::Array3;
///
/// # let folder = tempfile::tempdir()?;
/// let frames: Vec<_> = (0..4).map(|k| Array3::<u8>::from_elem((5, 7, 3), k * 60)).collect();
/// let views: Vec<_> = frames.iter().map(|frame| frame.view()).collect();
/// write_png_animation(folder.path().join("animation.png"), &views, 25.0, ColorEncoding::Srgb)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_png_animation<T: Sample>(
    path: impl AsRef<Path>,
    frames: &[ArrayView3<'_, T>],
    frames_per_second: f64,
    encoding: ColorEncoding,
) -> Result<FileDigest, Error> {
    let path = path.as_ref();
    let bad = |what: String| Error::bad_input(path, what);
    let Some(first) = frames.first() else { return Err(bad("an animation needs a frame".into())) };
    let count = u32::try_from(frames.len()).ok().filter(|&count| count < 1 << 31);
    let count = count.ok_or_else(|| bad(format!("{} frames are more than an animation can have", frames.len())))?;
    if !(0.01..=600.0).contains(&frames_per_second) {
        return Err(bad(format!("{frames_per_second} frames a second cannot be written; give 0.01 to 600")));
    }
    let (rows, columns, channels) = first.dim();
    if let Some(other) = frames.iter().find(|frame| frame.dim() != first.dim()) {
        return Err(bad(format!("a frame has shape {:?}, but the first has {:?}", other.shape(), first.shape())));
    }
    let layout = Layout::new(GridSize::new(rows, columns), channels, T::KIND, path)?;
    let mut file = AtomicFile::create(path)?;
    let mut encode = || -> Result<(), png::EncodingError> {
        let mut encoder = layout.encoder(&mut file, encoding);
        encoder.set_compression(png::Compression::Balanced);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.set_animated(count, 0)?;
        // Within 1 to 60,000 by the check above.
        encoder.set_frame_delay(TICKS as u16, (frames_per_second * TICKS).round() as u16)?;
        let mut writer = encoder.write_header()?;
        let mut bytes = vec![0; layout.row_bytes() * rows];
        for frame in frames {
            gather_image(&(*frame).into(), layout.row_bytes(), &mut bytes);
            writer.write_image_data(&bytes)?;
        }
        writer.finish()
    };
    match encode() {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}
