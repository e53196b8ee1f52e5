//! MP4 through the program `ffmpeg`, which gets the frames through a pipe.

use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use holo_core::Sample;
use ndarray::ArrayView3;

use super::gif::byte;
use crate::Error;
use crate::files::atomic::AtomicPath;

/// Writes frames as H.264 in an MP4 file, by the program `ffmpeg`, which must be on `PATH`.
///
/// # Shape
///
/// Every frame is `(rows, columns, channels)` with 1 (gray) or 3 (RGB) channels of 8 or 16 bits, all of the same shape;
/// any strides. 16 bits are rounded to 8. An odd side gets one more row or column, because the format halves the
/// resolution of color.
///
/// # Accuracy
///
/// H.264 is lossy: constant rate factor 18, which the encoder's authors call visually lossless.
///
/// # Errors
///
/// [`Error::BadInput`] if there are no frames, if their shapes differ, if the samples are floats, or if there are other
/// than 1 or 3 channels or no pixels, or if `frames_per_second` is not 0.01 to 600; [`Error::Io`] if `ffmpeg` is missing or fails, with its message, or if the file cannot be
/// written. No file of that name appears then.
pub fn write_mp4_animation<T: Sample>(
    path: impl AsRef<Path>,
    frames: &[ArrayView3<'_, T>],
    frames_per_second: f64,
) -> Result<(), Error> {
    let path = path.as_ref();
    let Some(first) = frames.first() else { return Err(Error::bad_input(path, "an animation needs a frame")) };
    let (rows, columns, channels) = first.dim();
    let is_possible = !T::KIND.is_float() && matches!(channels, 1 | 3) && rows * columns > 0;
    if !is_possible || frames.iter().any(|frame| frame.dim() != first.dim()) {
        return Err(Error::bad_input(path, "the frames of an MP4 are gray or RGB integers of one size"));
    }
    if !(0.01..=600.0).contains(&frames_per_second) {
        let what = format!("{frames_per_second} frames a second cannot be written; give 0.01 to 600");
        return Err(Error::bad_input(path, what));
    }
    let failed = |error: io::Error| Error::io("write", path, error);
    let file = AtomicPath::create(path)?;
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-nostdin", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    ffmpeg.args(["-s", &format!("{columns}x{rows}"), "-r", &frames_per_second.to_string(), "-i", "-", "-an"]);
    ffmpeg.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p"]);
    ffmpeg.args(["-movflags", "+faststart", "-f", "mp4"]).arg(file.temporary_path());
    ffmpeg.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = ffmpeg.spawn().map_err(|error| match error.kind() {
        ErrorKind::NotFound => failed(io::Error::new(
            ErrorKind::NotFound,
            "MP4 needs the program ffmpeg on PATH; install it, or write .gif or .png",
        )),
        _ => failed(error),
    })?;
    if let Some(mut pipe) = child.stdin.take() {
        let mut rgb = Vec::with_capacity(rows * columns * 3);
        for frame in frames {
            rgb.clear();
            for pixel in frame.rows() {
                rgb.extend([0, 1, 2].map(|channel: usize| byte(pixel[channel.min(channels - 1)])));
            }
            // ffmpeg reports by its exit code why it closed the pipe.
            if pipe.write_all(&rgb).is_err() {
                break;
            }
        }
    }
    let mut message = String::new();
    let _ = child.stderr.take().map(|mut pipe| pipe.read_to_string(&mut message));
    let status = child.wait().map_err(failed)?;
    if !status.success() {
        return Err(failed(io::Error::other(format!("ffmpeg failed: {}", message.trim()))));
    }
    file.commit().map(drop)
}
