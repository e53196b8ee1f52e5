//! Animated GIF: 256 colors a frame, for pages and slides that show no animated PNG.

use std::io;
use std::path::Path;

use holo_core::Sample;
use ndarray::ArrayView3;

use crate::{AtomicFile, Error, FileDigest};

/// Unit of the frame delay: ticks a second.
const TICKS: f64 = 100.0;

/// The speed of the choice of colors, 1 (best) to 30.
const SPEED: i32 = 10;

/// Writes frames as an animated GIF that loops forever. The colors of every frame are reduced to 256.
///
/// # Shape
///
/// Every frame is `(rows, columns, channels)` with 1 (gray) or 3 (RGB) channels of 8 or 16 bits, all of the same shape;
/// any strides. 16 bits are rounded to 8.
///
/// # Units
///
/// The delay between frames is a whole number of hundredths of a second, at least 2, below which browsers slow down:
/// `frames_per_second` is rounded to the nearest possible one, up to 50.
///
/// # Errors
///
/// [`Error::BadInput`] if there are no frames, if their shapes differ, if the samples are floats, if there are other than
/// 1 or 3 channels or more than 65,535 rows or columns, or if `frames_per_second` is not 0.01 to 600; [`Error::Io`] if the
/// file cannot be written. No file of that name appears then.
///
/// # Source
///
/// "Graphics Interchange Format, Version 89a" (CompuServe, 1990).
pub fn write_gif_animation<T: Sample>(
    path: impl AsRef<Path>,
    frames: &[ArrayView3<'_, T>],
    frames_per_second: f64,
) -> Result<FileDigest, Error> {
    let path = path.as_ref();
    let bad = |what: String| Error::bad_input(path, what);
    let Some(first) = frames.first() else { return Err(bad("an animation needs a frame".into())) };
    let (rows, columns, channels) = first.dim();
    if let Some(other) = frames.iter().find(|frame| frame.dim() != first.dim()) {
        return Err(bad(format!("a frame has shape {:?}, but the first has {:?}", other.shape(), first.shape())));
    }
    if T::KIND.is_float() || !matches!(channels, 1 | 3) {
        return Err(bad(format!("{channels} channels of {} are no GIF; give gray or RGB integers", T::KIND.name())));
    }
    let side = |count: usize| u16::try_from(count).ok().filter(|&count| count > 0);
    let (Some(height), Some(width)) = (side(rows), side(columns)) else {
        return Err(bad(format!("{columns} x {rows} pixels are no GIF; each side has 1 to 65535")));
    };
    if !(0.01..=600.0).contains(&frames_per_second) {
        return Err(bad(format!("{frames_per_second} frames a second cannot be written; give 0.01 to 600")));
    }
    let delay = (TICKS / frames_per_second).round().max(2.0) as u16;
    let mut file = AtomicFile::create(path)?;
    let mut encode = || -> Result<(), gif::EncodingError> {
        let mut encoder = gif::Encoder::new(&mut file, width, height, &[])?;
        encoder.set_repeat(gif::Repeat::Infinite)?;
        let mut rgb = Vec::with_capacity(rows * columns * 3);
        for frame in frames {
            rgb.clear();
            for pixel in frame.rows() {
                rgb.extend([0, 1, 2].map(|channel| byte(pixel[channel.min(channels - 1)])));
            }
            let mut frame = gif::Frame::from_rgb_speed(width, height, &rgb, SPEED);
            frame.delay = delay;
            encoder.write_frame(&frame)?;
        }
        Ok(())
    };
    match encode() {
        Ok(()) => file.commit(),
        Err(gif::EncodingError::Io(error)) => Err(Error::io("write", path, error)),
        Err(error) => Err(Error::io("write", path, io::Error::other(error.to_string()))),
    }
}

/// The sample in 8 bits.
pub(super) fn byte<T: Sample>(sample: T) -> u8 {
    (sample.to_f32() / T::WHITE.unwrap_or(1.0) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_become_bytes() {
        assert_eq!([0, 128, 255].map(byte::<u8>), [0, 128, 255]);
        assert_eq!([0, 257, 32_896, 65_535].map(byte::<u16>), [0, 1, 128, 255]);
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 9.0].map(byte::<f32>), [0, 0, 128, 255, 255]);
    }
}
