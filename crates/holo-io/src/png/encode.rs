//! Writes PNG row by row.

use std::io::Write;
use std::path::Path;

use ndarray::{ArrayView2, ArrayView3};

use super::filter::Filter;
use super::{Compression, Meaning};
use crate::error::MEMORY;
use crate::{AtomicFile, Error, Written, zlib};

/// A sample of 8 or 16 bits, in the byte order of PNG.
pub(super) trait Sample: Copy + Sync {
    const DEPTH: png::BitDepth;

    /// Appends a row that lies dense in memory.
    fn extend_dense(row: &[Self], bytes: &mut Vec<u8>);

    /// Appends one sample.
    fn push(self, bytes: &mut Vec<u8>);
}

impl Sample for u8 {
    const DEPTH: png::BitDepth = png::BitDepth::Eight;

    fn extend_dense(row: &[Self], bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(row);
    }

    fn push(self, bytes: &mut Vec<u8>) {
        bytes.push(self);
    }
}

impl Sample for u16 {
    const DEPTH: png::BitDepth = png::BitDepth::Sixteen;

    fn extend_dense(row: &[Self], bytes: &mut Vec<u8>) {
        bytes.extend(row.iter().flat_map(|sample| sample.to_be_bytes()));
    }

    fn push(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_be_bytes());
    }
}

/// Writes to a file that appears whole or not at all.
pub(super) fn write<T: Sample>(
    path: &Path,
    image: ArrayView3<'_, T>,
    meaning: Meaning,
    compression: Compression,
) -> Result<Written, Error> {
    let header = Header::of(image, path)?;
    let mut file = AtomicFile::create(path)?;
    match encode(&mut file, image, header, meaning, compression) {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}

/// Returns the bytes of the file.
pub(super) fn to_bytes<T: Sample>(
    image: ArrayView3<'_, T>,
    meaning: Meaning,
    compression: Compression,
) -> Result<Vec<u8>, Error> {
    let path = Path::new(MEMORY);
    let header = Header::of(image, path)?;
    let mut bytes = Vec::new();
    encode(&mut bytes, image, header, meaning, compression)
        .map_err(|error| Error::io("write", path, std::io::Error::other(error.to_string())))?;
    Ok(bytes)
}

/// What PNG needs to know of an image, checked.
struct Header {
    width: u32,
    height: u32,
    colour: png::ColorType,
}

impl Header {
    fn of<T>(image: ArrayView3<'_, T>, path: &Path) -> Result<Self, Error> {
        let (rows, columns, channels) = image.dim();
        let bad = |what: String| Error::bad_input(path, what);
        let side = |count: usize, what: &str| {
            u32::try_from(count)
                .ok()
                .filter(|&count| count > 0 && count < 1 << 31)
                .ok_or_else(|| bad(format!("a PNG has 1 to 2147483647 {what}, not {count}")))
        };
        let colour = match channels {
            1 => png::ColorType::Grayscale,
            2 => png::ColorType::GrayscaleAlpha,
            3 => png::ColorType::Rgb,
            4 => png::ColorType::Rgba,
            _ => return Err(bad(format!("a PNG has 1 to 4 channels, not {channels}"))),
        };
        Ok(Self { width: side(columns, "columns")?, height: side(rows, "rows")?, colour })
    }
}

fn encode<T: Sample>(
    out: impl Write,
    image: ArrayView3<'_, T>,
    header: Header,
    meaning: Meaning,
    compression: Compression,
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, header.width, header.height);
    encoder.set_color(header.colour);
    encoder.set_depth(T::DEPTH);
    if meaning == Meaning::Srgb {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    match compression {
        Compression::Scratch => encode_scratch(encoder, image),
        Compression::Published => encode_published(encoder, image),
    }
}

/// Streams the rows through the `png` crate.
fn encode_scratch<T: Sample>(
    mut encoder: png::Encoder<'_, impl Write>,
    image: ArrayView3<'_, T>,
) -> Result<(), png::EncodingError> {
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    let mut rows = writer.stream_writer_with_size(1 << 16)?;
    let mut bytes = Vec::new();
    for row in image.outer_iter() {
        gather(row, &mut bytes);
        rows.write_all(&bytes)?;
    }
    rows.finish()?;
    writer.finish()
}

/// Filters and compresses bands of rows on all threads; the `png` crate writes the header and the chunks.
fn encode_published<T: Sample>(
    encoder: png::Encoder<'_, impl Write>,
    image: ArrayView3<'_, T>,
) -> Result<(), png::EncodingError> {
    let mut writer = encoder.write_header()?;
    let (rows, columns, channels) = image.dim();
    let pixel_bytes = channels * size_of::<T>();
    let row_bytes = columns * pixel_bytes;
    let filter = |band: std::ops::Range<usize>, out: &mut Vec<u8>| {
        let mut filter = Filter::new(row_bytes, pixel_bytes);
        let mut bytes = Vec::with_capacity(row_bytes);
        if let Some(above) = band.start.checked_sub(1) {
            gather(image.index_axis(ndarray::Axis(0), above), &mut bytes);
            filter.set_above(&bytes);
        }
        for row in band {
            gather(image.index_axis(ndarray::Axis(0), row), &mut bytes);
            filter.append(&bytes, out);
        }
    };
    zlib::compress(rows, row_bytes + 1, filter, |data| writer.write_chunk(png::chunk::IDAT, data))?;
    writer.finish()
}

/// Replaces `bytes` by those of a row of any strides.
fn gather<T: Sample>(row: ArrayView2<'_, T>, bytes: &mut Vec<u8>) {
    bytes.clear();
    match row.as_slice() {
        Some(dense) => T::extend_dense(dense, bytes),
        None => row.iter().for_each(|sample| sample.push(bytes)),
    }
}
