//! MP4 by the program ffmpeg, which gets the frames through a pipe.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use holo_core::Sample;
use ndarray::ArrayView3;

use crate::failure::Failure;

/// Writes frames of gray or RGB as H.264 in 8 bits. An odd side gets one more row or column, because the format halves the
/// resolution of color.
pub fn write<T: Sample>(out: &Path, frames: &[ArrayView3<'_, T>], fps: f64) -> Result<(), Failure> {
    let failed = |what: String| Failure::Failed(format!("cannot write {}: {what}", out.display()));
    let Some(&(rows, columns, channels)) = frames.first().map(ArrayView3::dim).as_ref() else {
        return Err(failed("an animation needs a frame".into()));
    };
    // Written beside its place and renamed: a reader never sees half of it.
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    let part = out.with_file_name(format!(".{name}.{}.part.mp4", std::process::id()));
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-nostdin", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    ffmpeg.args(["-s", &format!("{columns}x{rows}"), "-r", &fps.to_string(), "-i", "-", "-an"]);
    ffmpeg.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p"]);
    ffmpeg.args(["-movflags", "+faststart"]).arg(&part);
    ffmpeg.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = ffmpeg.spawn().map_err(|error| match error.kind() {
        ErrorKind::NotFound => failed("MP4 needs the program ffmpeg on PATH; install it, or write .gif or .png".into()),
        _ => failed(format!("ffmpeg does not start: {error}")),
    })?;
    // Its end is reported by the exit code; a pipe that it closed early is no error of its own.
    if let Some(mut pipe) = child.stdin.take() {
        let mut bytes = Vec::with_capacity(rows * columns * 3);
        for frame in frames {
            bytes.clear();
            for pixel in frame.rows() {
                bytes.extend([0, 1, 2].map(|channel: usize| byte(pixel[channel.min(channels - 1)])));
            }
            if pipe.write_all(&bytes).is_err() {
                break;
            }
        }
    }
    let mut message = String::new();
    let _ = child.stderr.take().map(|mut pipe| pipe.read_to_string(&mut message));
    let status = child.wait().map_err(|error| failed(format!("ffmpeg: {error}")))?;
    if !status.success() {
        let _ = std::fs::remove_file(&part);
        return Err(failed(format!("ffmpeg failed: {}", message.trim())));
    }
    std::fs::rename(&part, out).map_err(|error| failed(error.to_string()))
}

/// The sample in 8 bits.
fn byte<T: Sample>(sample: T) -> u8 {
    (sample.to_f32() / T::WHITE.unwrap_or(1.0) * 255.0).round() as u8
}
