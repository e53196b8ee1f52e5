//! The decoder of one scanline of RGBE pixels: flat, or in one of two run-length codings.
//!
//! New coding, of scanlines of 8 to 32767 pixels: the bytes 2, 2 and the length (most significant byte first), then the
//! four components one after the other, each as runs: a byte n above 128 repeats the next byte n - 128 times, a byte n
//! up to 128 is followed by n bytes. Old coding: pixels, of which (1, 1, 1, n) repeats the one before n times; such
//! markers in succession are the bytes of one number, the least significant first. Without markers that is a flat
//! scanline.

use std::io::{self, BufRead};
use std::path::Path;

use super::FORMAT;
use crate::Error;

/// The lengths of scanlines for which the new coding is defined; its marker would be ambiguous otherwise.
const NEW_CODING: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// Why a scanline cannot be read.
#[derive(Debug)]
pub(super) enum ScanlineError {
    Io(io::Error),
    Broken(String),
}

impl From<io::Error> for ScanlineError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl ScanlineError {
    /// Converts to an error of this crate; `at` is the position in the file.
    pub fn into_error(self, path: &Path, at: &str) -> Error {
        match self {
            Self::Io(error) if error.kind() == io::ErrorKind::UnexpectedEof => Error::broken(
                path,
                FORMAT,
                format!("{at}: the file ends early; it was truncated while it was written or copied"),
            ),
            Self::Io(error) => Error::io("read", path, error),
            Self::Broken(what) => Error::broken(path, FORMAT, format!("{at}: {what}")),
        }
    }
}

/// Reads one scanline of `length` pixels into `pixels`.
pub(super) fn read(source: &mut impl BufRead, pixels: &mut Vec<[u8; 4]>, length: usize) -> Result<(), ScanlineError> {
    let first = pixel(source)?;
    match first {
        [2, 2, high @ 0..0x80, low] if NEW_CODING.contains(&length) => {
            let announced = usize::from(high) << 8 | usize::from(low);
            if announced != length {
                return Err(ScanlineError::Broken(format!("it announces {announced} pixels, the header {length}")));
            }
            pixels.resize(length, [0; 4]);
            (0..4).try_for_each(|component| read_component(source, pixels, component))
        }
        _ => {
            pixels.clear();
            read_pixels(source, first, pixels, length)
        }
    }
}

fn pixel(source: &mut impl BufRead) -> io::Result<[u8; 4]> {
    let mut pixel = [0; 4];
    source.read_exact(&mut pixel)?;
    Ok(pixel)
}

/// Reads one component of a scanline in the new coding.
fn read_component(source: &mut impl BufRead, pixels: &mut [[u8; 4]], component: usize) -> Result<(), ScanlineError> {
    let mut rest = pixels;
    let mut bytes = [0; 128];
    while !rest.is_empty() {
        let mut code = [0];
        source.read_exact(&mut code)?;
        let count = usize::from(if code[0] > 128 { code[0] - 128 } else { code[0] });
        if count == 0 || count > rest.len() {
            return Err(ScanlineError::Broken(format!("a run of {count} where {} pixels are left", rest.len())));
        }
        if code[0] > 128 {
            source.read_exact(&mut bytes[..1])?;
            let value = bytes[0];
            bytes[..count].fill(value);
        } else {
            source.read_exact(&mut bytes[..count])?;
        }
        let (run, behind) = rest.split_at_mut(count);
        for (pixel, &byte) in run.iter_mut().zip(&bytes) {
            pixel[component] = byte;
        }
        rest = behind;
    }
    Ok(())
}

/// Reads a flat scanline or one in the old coding; `first` is its first pixel.
fn read_pixels(
    source: &mut impl BufRead,
    first: [u8; 4],
    pixels: &mut Vec<[u8; 4]>,
    length: usize,
) -> Result<(), ScanlineError> {
    let mut next = first;
    // Bits by which the next marker's count is shifted.
    let mut shift = 0;
    loop {
        if let [1, 1, 1, count] = next {
            let Some(&previous) = pixels.last() else {
                return Err(ScanlineError::Broken("a run begins before the first pixel".into()));
            };
            let left = length - pixels.len();
            // A length has 32 bits, so after four bytes of the count only zeros are valid.
            let count = if shift < 32 { u64::from(count) << shift } else { u64::from(count) << 32 };
            if count > left as u64 {
                return Err(ScanlineError::Broken(format!("a run of at least {count} where {left} pixels are left")));
            }
            pixels.resize(pixels.len() + count as usize, previous);
            shift = 32.min(shift + 8);
        } else {
            pixels.push(next);
            shift = 0;
        }
        if pixels.len() == length {
            return Ok(());
        }
        next = pixel(source)?;
    }
}
