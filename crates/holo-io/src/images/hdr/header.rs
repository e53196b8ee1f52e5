//! The header of a Radiance HDR file: lines of text, an empty line, and the line of size and orientation.

use std::io::{BufRead, Read};
use std::path::Path;

use holo_core::GridSize;

use super::{FORMAT, HdrInfo};
use crate::Error;

/// Maximum length of a header in bytes. Long headers exist, because every tool adds its command line.
const MAX_BYTES: u64 = 1 << 16;

/// Whether a scanline is a row or a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Major {
    Rows,
    Columns,
}

/// The header, with sizes and orientation as in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Header {
    pub major: Major,
    /// Number of scanlines, and pixels in each.
    pub scanlines: usize,
    pub length: usize,
    /// Whether the first scanline is the bottom row or the rightmost column.
    pub flip_scanlines: bool,
    /// Whether the first pixel of a scanline is at the right or at the bottom.
    pub flip_pixels: bool,
    pub exposure: f64,
    pub color_correction: [f64; 3],
}

impl Header {
    /// Reads up to the first scanline.
    pub fn read(source: &mut impl BufRead, path: &Path) -> Result<Self, Error> {
        let broken = |what: String| Error::broken(path, FORMAT, what);
        let mut source = source.take(MAX_BYTES);
        let signature = line(&mut source, path)?;
        if !(signature.starts_with("#?RADIANCE") || signature.starts_with("#?RGBE")) {
            return Err(broken("the first line is neither #?RADIANCE nor #?RGBE".into()));
        }
        let (mut exposure, mut color_correction) = (1.0, [1.0; 3]);
        loop {
            let line = line(&mut source, path)?;
            // Lines with white space before the name are quoted from the headers of other files.
            match line.split_once('=') {
                _ if line.is_empty() => break,
                Some(("FORMAT", "32-bit_rle_rgbe")) => {}
                Some(("FORMAT", format)) => {
                    let format: String = format.chars().take(40).collect();
                    return Err(Error::unsupported(
                        path,
                        format!("pixels of the format {format:?} cannot be read; 32-bit_rle_rgbe can"),
                    ));
                }
                Some(("EXPOSURE", text)) => exposure *= factors::<1>(text).ok_or_else(|| bad(path, &line))?[0],
                Some(("COLORCORR", text)) => {
                    let more = factors::<3>(text).ok_or_else(|| bad(path, &line))?;
                    color_correction = std::array::from_fn(|channel| color_correction[channel] * more[channel]);
                }
                _ => {}
            }
        }
        // Products of factors that are in range need not be, and the reader divides in f32.
        let divisors = color_correction.map(|correction| (correction * exposure) as f32);
        if !divisors.iter().all(|divisor| divisor.is_normal()) {
            return Err(broken("EXPOSURE and COLORCORR multiply to a number out of range".into()));
        }
        let resolution = line(&mut source, path)?;
        let (major, [(flip_scanlines, scanlines), (flip_pixels, length)]) =
            parse_resolution(&resolution).ok_or_else(|| {
                let shown: String = resolution.chars().take(60).collect();
                broken(format!("the size is given as {shown:?}, not like -Y 512 +X 1024"))
            })?;
        Ok(Self { major, scanlines, length, flip_scanlines, flip_pixels, exposure, color_correction })
    }

    /// The public part of the header.
    pub fn info(&self) -> HdrInfo {
        let size = match self.major {
            Major::Rows => GridSize::new(self.scanlines, self.length),
            Major::Columns => GridSize::new(self.length, self.scanlines),
        };
        HdrInfo { size, exposure: self.exposure, color_correction: self.color_correction }
    }
}

fn bad(path: &Path, line: &str) -> Error {
    let line: String = line.chars().take(60).collect();
    Error::broken(path, FORMAT, format!("the header line {line:?} does not hold finite numbers above 0"))
}

/// Reads one line without its line end.
fn line(source: &mut std::io::Take<impl BufRead>, path: &Path) -> Result<String, Error> {
    let mut bytes = Vec::new();
    source.read_until(b'\n', &mut bytes).map_err(|source| Error::io("read", path, source))?;
    if bytes.pop() != Some(b'\n') {
        let what = if source.limit() == 0 {
            format!("the header is longer than {MAX_BYTES} bytes")
        } else {
            "the file ends inside its header".into()
        };
        return Err(Error::broken(path, FORMAT, what));
    }
    if bytes.last() == Some(&b'\r') {
        bytes.pop();
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Parses exactly `N` finite numbers above 0.
fn factors<const N: usize>(text: &str) -> Option<[f64; N]> {
    let mut factors = [0.0; N];
    let mut words = text.split_whitespace();
    for factor in &mut factors {
        *factor = words.next()?.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0)?;
    }
    words.next().is_none().then_some(factors)
}

/// Parses the resolution line, `-Y 512 +X 1024` or one of the other seven orientations: for scanlines and for pixels,
/// whether they are flipped, and their number.
fn parse_resolution(text: &str) -> Option<(Major, [(bool, usize); 2])> {
    let mut words = text.split_whitespace();
    let mut axis = || Some((words.next()?, words.next()?));
    let (first, second) = (axis()?, axis()?);
    if words.next().is_some() {
        return None;
    }
    let count = |text: &str| {
        let digits = text.bytes().all(|byte| byte.is_ascii_digit());
        text.parse::<u32>().ok().filter(|&count| digits && count > 0).map(|count| count as usize)
    };
    // Y points up in the format, so -Y runs from the top row down.
    let direction = |axis: &str| match axis {
        "-Y" => Some((Major::Rows, false)),
        "+Y" => Some((Major::Rows, true)),
        "+X" => Some((Major::Columns, false)),
        "-X" => Some((Major::Columns, true)),
        _ => None,
    };
    let ((major, flip_scanlines), (minor, flip_pixels)) = (direction(first.0)?, direction(second.0)?);
    (major != minor).then_some(())?;
    Some((major, [(flip_scanlines, count(first.1)?), (flip_pixels, count(second.1)?)]))
}
