//! Encodes PNG row by row into a writer.

use std::io::Write;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use holo_core::{ColorEncoding, DynImageRef, GridSize, SampleKind};
use ndarray::{ArrayView2, ArrayView3, Axis};

use super::Compression;
use super::bands::Bands;
use crate::error::STREAM;
use crate::{AtomicFile, Error};

/// A sample of 8 or 16 bits, which PNG stores big-endian.
pub(super) trait Bytes: Copy + Send + Sync {
    /// Size of a sample in the file.
    const BYTES: usize;

    /// Writes contiguous samples into `bytes`, which has their size.
    fn put_dense(samples: &[Self], bytes: &mut [u8]);

    /// Writes one sample.
    fn put(self, bytes: &mut [u8]);
}

impl Bytes for u8 {
    const BYTES: usize = 1;

    fn put_dense(samples: &[Self], bytes: &mut [u8]) {
        bytes.copy_from_slice(samples);
    }

    fn put(self, bytes: &mut [u8]) {
        bytes[0] = self;
    }
}

impl Bytes for u16 {
    const BYTES: usize = 2;

    fn put_dense(samples: &[Self], bytes: &mut [u8]) {
        for (sample, bytes) in samples.iter().zip(bytes.chunks_exact_mut(2)) {
            sample.put(bytes);
        }
    }

    fn put(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_be_bytes());
    }
}

/// Size, channels and sample type of an image, valid for PNG.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub size: GridSize,
    pub channels: usize,
    width: u32,
    height: u32,
    pub kind: SampleKind,
    color: png::ColorType,
    depth: png::BitDepth,
    pixel_bytes: usize,
    row_bytes: usize,
}

impl Layout {
    pub fn new(size: GridSize, channels: usize, kind: SampleKind, path: &Path) -> Result<Self, Error> {
        let bad = |what: String| Error::bad_input(path, what);
        let (depth, sample_bytes) = match kind {
            SampleKind::U8 => (png::BitDepth::Eight, 1),
            SampleKind::U16 => (png::BitDepth::Sixteen, 2),
            SampleKind::F32 | SampleKind::F64 => {
                let kind = kind.name();
                return Err(bad(format!(
                    "a PNG holds integers of 8 or 16 bits, not {kind}; write PFM or EXR, or encode it"
                )));
            }
        };
        let side = |count: usize, what: &str| {
            u32::try_from(count)
                .ok()
                .filter(|&count| count > 0 && count < 1 << 31)
                .ok_or_else(|| bad(format!("a PNG has 1 to 2147483647 {what}, not {count}")))
        };
        let color = match channels {
            1 => png::ColorType::Grayscale,
            2 => png::ColorType::GrayscaleAlpha,
            3 => png::ColorType::Rgb,
            4 => png::ColorType::Rgba,
            _ => return Err(bad(format!("a PNG has 1 to 4 channels, not {channels}"))),
        };
        let (width, height) = (side(size.columns, "columns")?, side(size.rows, "rows")?);
        let pixel_bytes = channels * sample_bytes;
        let row_bytes = size
            .columns
            .checked_mul(pixel_bytes)
            .filter(|&bytes| bytes < isize::MAX as usize / 4)
            .ok_or_else(|| bad(format!("rows of {width} pixels do not fit into the memory of this machine")))?;
        Ok(Self { size, channels, width, height, kind, color, depth, pixel_bytes, row_bytes })
    }

    pub fn row_bytes(&self) -> usize {
        self.row_bytes
    }

    /// Returns an encoder of the `png` crate with this header.
    pub fn encoder<'a, W: Write>(&self, out: W, encoding: ColorEncoding) -> png::Encoder<'a, W> {
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(self.color);
        encoder.set_depth(self.depth);
        if encoding == ColorEncoding::Srgb {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        encoder
    }
}

/// The destination of the bytes, which converts errors of the encoder.
pub(super) trait Sink: Write + 'static {
    /// Converts an error of the `png` crate, which may hide an error of the destination.
    fn write_error(&mut self, error: png::EncodingError) -> Error;
}

impl Sink for AtomicFile {
    fn write_error(&mut self, error: png::EncodingError) -> Error {
        self.error(error)
    }
}

impl Sink for Vec<u8> {
    fn write_error(&mut self, error: png::EncodingError) -> Error {
        Error::io("write", Path::new(STREAM), std::io::Error::other(error.to_string()))
    }
}

/// A shared destination: the `png` crate does not return its writer, so the encoder keeps a second reference.
struct Shared<W>(Arc<Mutex<W>>);

impl<W: Write> Write for Shared<W> {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(data)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
}

/// The state of the encoder by compression.
enum Rows<W: Sink> {
    /// Through the `png` crate, one row at a time.
    Fast(Box<png::StreamWriter<'static, Shared<W>>>),
    /// In bands, in parallel; the `png` crate writes the header and the chunks.
    Best(Box<png::Writer<Shared<W>>>, Bands),
}

/// An encoder of one PNG into `W`. The caller counts the rows.
pub(super) struct Encoder<W: Sink> {
    rows: Rows<W>,
    row_bytes: usize,
    out: Arc<Mutex<W>>,
}

impl<W: Sink> Encoder<W> {
    /// Writes the header, and `description` as text (Latin-1) with the keyword of that name.
    pub fn new(
        out: W,
        layout: Layout,
        encoding: ColorEncoding,
        description: Option<&str>,
        compression: Compression,
    ) -> Result<Self, Error> {
        let out = Arc::new(Mutex::new(out));
        let rows = Rows::new(Shared(Arc::clone(&out)), layout, (encoding, description), compression);
        match rows {
            Ok(rows) => Ok(Self { rows, row_bytes: layout.row_bytes, out }),
            Err(error) => Err(write_error(&out, error)),
        }
    }

    /// Writes the next rows. The caller guarantees that there are not too many, and that columns, channels and sample
    /// type are those of the image.
    pub fn write_rows(&mut self, rows: DynImageRef<'_>) -> Result<(), Error> {
        match rows {
            DynImageRef::U8(rows) => self.push(rows),
            DynImageRef::U16(rows) => self.push(rows),
            // The layout has refused floats.
            DynImageRef::F32(_) | DynImageRef::F64(_) => Ok(()),
        }
    }

    fn push<T: Bytes>(&mut self, rows: ArrayView3<'_, T>) -> Result<(), Error> {
        let outcome = match &mut self.rows {
            Rows::Fast(writer) => {
                let mut bytes = vec![0; self.row_bytes];
                rows.outer_iter().try_for_each(|row| {
                    gather(row, &mut bytes);
                    Ok(writer.write_all(&bytes)?)
                })
            }
            Rows::Best(writer, bands) => bands.push(
                rows.dim().0,
                |row, bytes| gather(rows.index_axis(Axis(0), row), bytes),
                |data| writer.write_chunk(png::chunk::IDAT, data),
            ),
        };
        outcome.map_err(|error| write_error(&self.out, error))
    }

    /// Completes the PNG and returns the destination.
    pub fn finish(self) -> Result<W, Error> {
        let outcome = match self.rows {
            // The `png` crate writes the end of the file on drop and ignores errors there; `W` remembers them.
            Rows::Fast(writer) => writer.finish(),
            Rows::Best(writer, _) => writer.finish(),
        };
        outcome.map_err(|error| write_error(&self.out, error))?;
        match Arc::try_unwrap(self.out) {
            Ok(out) => Ok(out.into_inner().unwrap_or_else(PoisonError::into_inner)),
            Err(out) => Err(write_error(&out, std::io::Error::other("the encoder still holds its output").into())),
        }
    }
}

fn write_error<W: Sink>(out: &Mutex<W>, error: png::EncodingError) -> Error {
    out.lock().unwrap_or_else(PoisonError::into_inner).write_error(error)
}

impl<W: Sink> Rows<W> {
    fn new(
        out: Shared<W>,
        layout: Layout,
        (encoding, description): (ColorEncoding, Option<&str>),
        compression: Compression,
    ) -> Result<Self, png::EncodingError> {
        let mut encoder = layout.encoder(out, encoding);
        if let Some(text) = description {
            encoder.add_text_chunk("Description".into(), text.into())?;
        }
        Ok(match compression {
            Compression::Fast => {
                encoder.set_compression(png::Compression::Fast);
                encoder.set_filter(png::Filter::Adaptive);
                Self::Fast(Box::new(encoder.write_header()?.into_stream_writer_with_size(1 << 16)?))
            }
            Compression::Best => {
                let bands = Bands::new(layout.size.rows, layout.row_bytes, layout.pixel_bytes);
                Self::Best(Box::new(encoder.write_header()?), bands)
            }
        })
    }
}

/// Writes the rows of an image into `bytes`, `row_bytes` each.
pub(super) fn gather_image(image: &DynImageRef<'_>, row_bytes: usize, bytes: &mut [u8]) {
    fn rows<T: Bytes>(image: &ArrayView3<'_, T>, row_bytes: usize, bytes: &mut [u8]) {
        image.outer_iter().zip(bytes.chunks_exact_mut(row_bytes)).for_each(|(row, bytes)| gather(row, bytes));
    }
    match image {
        DynImageRef::U8(image) => rows(image, row_bytes, bytes),
        DynImageRef::U16(image) => rows(image, row_bytes, bytes),
        // The layout has refused floats.
        DynImageRef::F32(_) | DynImageRef::F64(_) => {}
    }
}

/// Writes a row of any strides into its bytes.
fn gather<T: Bytes>(row: ArrayView2<'_, T>, bytes: &mut [u8]) {
    match row.as_slice() {
        Some(dense) => T::put_dense(dense, bytes),
        None => row.iter().zip(bytes.chunks_exact_mut(T::BYTES)).for_each(|(sample, bytes)| sample.put(bytes)),
    }
}
