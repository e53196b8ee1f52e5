//! Decodes any PNG to samples of 8 or 16 bits.

use std::io::{BufRead, Cursor, Read, Seek};
use std::path::Path;

use holo_core::{ColorEncoding, DynImage, GridSize};
use ndarray::Array3;

use super::PngInfo;
use crate::error::STREAM;
use crate::files::stream::{open, read_to_end};
use crate::{Error, Limits};

/// Range of the memory limit of the decoder for rows and headers, in bytes, in addition to the image.
const WORKING_BYTES: std::ops::RangeInclusive<u64> = 1 << 20..=256 << 20;

/// Reads a PNG: gray, RGB or palette, 1 to 16 bits, interlaced or not.
///
/// # Shape
///
/// `(rows, columns, channels)` with 1 (gray), 2 (gray, alpha), 3 (RGB) or 4 (RGB, alpha) channels. Palettes become RGB,
/// fewer than 8 bits become 8.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not a PNG, is truncated or damaged;
/// [`Error::TooLarge`] if its samples exceed the limits, before memory is allocated for them.
pub fn read_png(path: impl AsRef<Path>, limits: &Limits) -> Result<DynImage, Error> {
    let path = path.as_ref();
    decode(open(path)?, path, *limits)
}

/// Decodes a PNG from a stream, like [`read_png`]. The encoded bytes are read into memory first.
///
/// # Errors
///
/// Those of [`read_png`].
pub fn decode_png(source: impl Read, limits: &Limits) -> Result<DynImage, Error> {
    let bytes = read_to_end(source, *limits)?;
    decode(Cursor::new(bytes), Path::new(STREAM), *limits)
}

/// Reads the header of a PNG without its pixels.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if its header is not that of a PNG.
pub fn read_png_info(path: impl AsRef<Path>) -> Result<PngInfo, Error> {
    let path = path.as_ref();
    start(open(path)?, path, Limits::NONE).map(|(_, info)| info)
}

/// Reads up to the pixels.
fn start<R: BufRead + Seek>(source: R, path: &Path, limits: Limits) -> Result<(png::Reader<R>, PngInfo), Error> {
    let working = limits.max_bytes.clamp(*WORKING_BYTES.start(), *WORKING_BYTES.end()) as usize;
    let mut decoder = png::Decoder::new_with_limits(source, png::Limits { bytes: working });
    decoder.set_transformations(png::Transformations::EXPAND);
    // Text and color profiles are ignored, so that they take no memory and cause no errors.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let reader = decoder.read_info().map_err(|error| decode_error(error, path, limits))?;
    check_palette(reader.info(), path)?;
    let (color, depth) = reader.output_color_type();
    let size = reader.info();
    let info = PngInfo {
        size: GridSize::new(size.height as usize, size.width as usize),
        channels: color.samples(),
        bits: if depth == png::BitDepth::Sixteen { 16 } else { 8 },
        encoding: if size.srgb.is_some() { ColorEncoding::Srgb } else { ColorEncoding::Linear },
    };
    Ok((reader, info))
}

/// Refuses palettes that are not 1 to 256 complete RGB entries: `png` 0.18.1 panics on an incomplete one (image-png
/// issue 694).
fn check_palette(info: &png::Info<'_>, path: &Path) -> Result<(), Error> {
    let bytes = info.palette.as_ref().map_or(0, |palette| palette.len());
    if info.color_type == png::ColorType::Indexed && (!bytes.is_multiple_of(3) || !(3..=768).contains(&bytes)) {
        return Err(Error::broken(path, "PNG", format!("a palette of {bytes} bytes is not 1 to 256 colors")));
    }
    Ok(())
}

fn decode<R: BufRead + Seek>(source: R, path: &Path, limits: Limits) -> Result<DynImage, Error> {
    let (mut reader, info) = start(source, path, limits)?;
    let shape = (info.size.rows, info.size.columns, info.channels);
    let counts = [shape.0, shape.1, shape.2];
    let samples = if info.bits == 8 {
        let count = limits.elements(path, "image", &counts, 1)?;
        let mut samples = Limits::room::<u8>(path, "image", count)?;
        read_rows(&mut reader, path, limits, count, |bytes| samples.extend_from_slice(bytes))?;
        Array3::from_shape_vec(shape, samples).ok().map(DynImage::U8)
    } else {
        let count = limits.elements(path, "image", &counts, 2)?;
        let mut samples = Limits::room::<u16>(path, "image", count)?;
        let pair = |bytes: &[u8]| u16::from_be_bytes([bytes[0], bytes[1]]);
        read_rows(&mut reader, path, limits, count * 2, |bytes| samples.extend(bytes.chunks_exact(2).map(pair)))?;
        Array3::from_shape_vec(shape, samples).ok().map(DynImage::U16)
    };
    // The pixels may be complete in a file that is truncated after them.
    reader.finish().map_err(|error| decode_error(error, path, limits))?;
    samples.ok_or_else(|| Error::broken(path, "PNG", "the image data are shorter than the header announces"))
}

/// Passes the image to `take` from top to bottom, in pieces of whole samples.
fn read_rows<R: BufRead + Seek>(
    reader: &mut png::Reader<R>,
    path: &Path,
    limits: Limits,
    bytes: usize,
    mut take: impl FnMut(&[u8]),
) -> Result<(), Error> {
    let failed = |error| decode_error(error, path, limits);
    if reader.info().interlaced {
        // Interlaced rows arrive out of order, so the whole image is needed at once.
        let mut image = Limits::room(path, "image", bytes)?;
        image.resize(bytes, 0);
        let frame = reader.next_frame(&mut image).map_err(failed)?;
        // The first frame of an animation may be smaller than the image; the caller checks the length.
        take(&image[..frame.buffer_size().min(bytes)]);
    } else {
        // The memory was only reserved: pages are touched as data arrive, so a short file that announces a large image
        // uses little memory.
        while let Some(row) = reader.next_row().map_err(failed)? {
            take(row.data());
        }
    }
    Ok(())
}

/// Converts an error of the decoder: to a broken file, an error of the operating system, or a limit.
fn decode_error(error: png::DecodingError, path: &Path, limits: Limits) -> Error {
    match error {
        png::DecodingError::IoError(source) if source.kind() == std::io::ErrorKind::UnexpectedEof => {
            Error::broken(path, "PNG", "the file ends early; it was truncated while it was written or copied")
        }
        png::DecodingError::IoError(source) => Error::io("read", path, source),
        png::DecodingError::LimitsExceeded => {
            Error::TooLarge { path: path.to_owned(), what: "image", needed: u64::MAX, allowed: limits.max_bytes }
        }
        error => Error::broken(path, "PNG", error.to_string()),
    }
}
