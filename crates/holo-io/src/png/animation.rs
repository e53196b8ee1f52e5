//! Animated PNG: several pictures of one size in a file that shows them one after the other.

use std::path::Path;

use holo_core::{ColorEncoding, GridSize, Sample};
use ndarray::ArrayView3;

use super::encode::{Layout, gather_image};
use crate::{AtomicFile, Error, FileDigest};

/// Ticks of the clock a second in which the time of a picture is told.
const TICKS: f64 = 100.0;

/// Writes pictures as one that moves, over and over. Programs that know no animation show the first.
///
/// # Shape
///
/// Every picture is `(rows, columns, channels)` as in [`super::write_png`], all of one shape; any strides.
///
/// # Units
///
/// `pictures_per_second` is rounded to hundredths.
///
/// # Errors
///
/// [`Error::BadInput`] if there is no picture or more than 2^31 - 1, if one has another shape than the first or one that no PNG
/// has, or if there are not 0.01 to 600 pictures a second; [`Error::Io`] if the file cannot be written. No file of that name
/// appears then.
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
/// let pictures: Vec<_> = (0..4).map(|k| Array3::<u8>::from_elem((5, 7, 3), k * 60)).collect();
/// let views: Vec<_> = pictures.iter().map(|picture| picture.view()).collect();
/// write_png_animation(folder.path().join("moving.png"), &views, 25.0, ColorEncoding::Srgb)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_png_animation<T: Sample>(
    path: impl AsRef<Path>,
    pictures: &[ArrayView3<'_, T>],
    pictures_per_second: f64,
    encoding: ColorEncoding,
) -> Result<FileDigest, Error> {
    let path = path.as_ref();
    let bad = |what: String| Error::bad_input(path, what);
    let Some(first) = pictures.first() else { return Err(bad("an animation needs a picture".into())) };
    let count = u32::try_from(pictures.len()).ok().filter(|&count| count < 1 << 31);
    let count = count.ok_or_else(|| bad(format!("{} pictures are more than an animation has", pictures.len())))?;
    if !(0.01..=600.0).contains(&pictures_per_second) {
        return Err(bad(format!("{pictures_per_second} pictures a second cannot be told; give 0.01 to 600")));
    }
    let (rows, columns, channels) = first.dim();
    if let Some(other) = pictures.iter().find(|picture| picture.dim() != first.dim()) {
        return Err(bad(format!(
            "a picture is of shape {:?} where the first is of {:?}",
            other.shape(),
            first.shape()
        )));
    }
    let layout = Layout::new(GridSize::new(rows, columns), channels, T::KIND, path)?;
    let mut file = AtomicFile::create(path)?;
    let mut encode = || -> Result<(), png::EncodingError> {
        let mut encoder = layout.encoder(&mut file, encoding);
        encoder.set_compression(png::Compression::Balanced);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.set_animated(count, 0)?;
        // Within 1 to 60,000 by the check above.
        encoder.set_frame_delay(TICKS as u16, (pictures_per_second * TICKS).round() as u16)?;
        let mut writer = encoder.write_header()?;
        let mut bytes = vec![0; layout.row_bytes() * rows];
        for picture in pictures {
            gather_image(&(*picture).into(), layout.row_bytes(), &mut bytes);
            writer.write_image_data(&bytes)?;
        }
        writer.finish()
    };
    match encode() {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}
