//! Encodes PNG row by row, into whatever takes bytes.

use std::io::Write;
use std::marker::PhantomData;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use holo_core::GridSize;
use ndarray::{ArrayView2, ArrayView3, Axis};

use super::bands::Bands;
use super::{Compression, Meaning};
use crate::error::MEMORY;
use crate::{AtomicFile, Error};

/// A sample of 8 or 16 bits, in the byte order of PNG.
pub trait Sample: Copy + Send + Sync {
    /// Its size in the file.
    const BYTES: usize;

    /// Puts samples that lie dense in memory into as many bytes as they have.
    fn put_dense(samples: &[Self], bytes: &mut [u8]);

    /// Puts one sample.
    fn put(self, bytes: &mut [u8]);
}

impl Sample for u8 {
    const BYTES: usize = 1;

    fn put_dense(samples: &[Self], bytes: &mut [u8]) {
        bytes.copy_from_slice(samples);
    }

    fn put(self, bytes: &mut [u8]) {
        bytes[0] = self;
    }
}

impl Sample for u16 {
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

/// What PNG needs to know of an image, checked.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub size: GridSize,
    pub channels: usize,
    width: u32,
    height: u32,
    colour: png::ColorType,
    pixel_bytes: usize,
    row_bytes: usize,
}

impl Layout {
    pub fn new(size: GridSize, channels: usize, sample_bytes: usize, path: &Path) -> Result<Self, Error> {
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
        let (width, height) = (side(size.columns, "columns")?, side(size.rows, "rows")?);
        let pixel_bytes = channels * sample_bytes;
        let row_bytes = size
            .columns
            .checked_mul(pixel_bytes)
            .filter(|&bytes| bytes < isize::MAX as usize / 4)
            .ok_or_else(|| bad(format!("rows of {width} pixels do not fit into the memory of this machine")))?;
        Ok(Self { size, channels, width, height, colour, pixel_bytes, row_bytes })
    }

    pub fn row_bytes(&self) -> usize {
        self.row_bytes
    }

    /// An encoder that knows what the header says.
    pub fn encoder<'a, T: Sample, W: Write>(&self, out: W, meaning: Meaning) -> png::Encoder<'a, W> {
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(self.colour);
        encoder.set_depth(if T::BYTES == 1 { png::BitDepth::Eight } else { png::BitDepth::Sixteen });
        if meaning == Meaning::Srgb {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        encoder
    }
}

/// Where the bytes go, and what its word is when something goes wrong.
pub(super) trait Sink: Write + 'static {
    /// Turns an error of the `png` crate, which may hide its cause, into ours.
    fn fault(&mut self, error: png::EncodingError) -> Error;
}

impl Sink for AtomicFile {
    fn fault(&mut self, error: png::EncodingError) -> Error {
        self.error(error)
    }
}

impl Sink for Vec<u8> {
    fn fault(&mut self, error: png::EncodingError) -> Error {
        Error::io("write", Path::new(MEMORY), std::io::Error::other(error.to_string()))
    }
}

/// A writer of which one owner gives bytes away and another gets it back in the end: the `png` crate keeps what it has.
struct Shared<W>(Arc<Mutex<W>>);

impl<W: Write> Write for Shared<W> {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(data)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
}

/// How the rows become bytes.
enum Rows<W: Sink> {
    /// Through the `png` crate, one row at a time.
    Scratch(Box<png::StreamWriter<'static, Shared<W>>>),
    /// In bands on all threads; the `png` crate writes the header and the chunks.
    Published(Box<png::Writer<Shared<W>>>, Bands),
}

/// A PNG on its way into `W`. Whoever owns it counts the rows.
pub(super) struct Encoder<T, W: Sink> {
    rows: Rows<W>,
    row_bytes: usize,
    out: Arc<Mutex<W>>,
    samples: PhantomData<fn(T)>,
}

impl<T: Sample, W: Sink> Encoder<T, W> {
    /// Writes the header.
    pub fn new(out: W, layout: Layout, meaning: Meaning, compression: Compression) -> Result<Self, Error> {
        let out = Arc::new(Mutex::new(out));
        let rows = Rows::new::<T>(Shared(Arc::clone(&out)), layout, meaning, compression);
        match rows {
            Ok(rows) => Ok(Self { rows, row_bytes: layout.row_bytes, out, samples: PhantomData }),
            Err(error) => Err(fault(&out, error)),
        }
    }

    /// Takes the next rows, which are no more than are missing and as wide as the image.
    pub fn write_rows(&mut self, rows: ArrayView3<'_, T>) -> Result<(), Error> {
        let outcome = match &mut self.rows {
            Rows::Scratch(writer) => {
                let mut bytes = vec![0; self.row_bytes];
                rows.outer_iter().try_for_each(|row| {
                    gather(row, &mut bytes);
                    Ok(writer.write_all(&bytes)?)
                })
            }
            Rows::Published(writer, bands) => bands.push(
                rows.dim().0,
                |row, bytes| gather(rows.index_axis(Axis(0), row), bytes),
                |data| writer.write_chunk(png::chunk::IDAT, data),
            ),
        };
        outcome.map_err(|error| fault(&self.out, error))
    }

    /// Completes the file, and returns what it was written into.
    pub fn finish(self) -> Result<W, Error> {
        let outcome = match self.rows {
            // The end of the file is written when the writer falls; should that fail, `W` knows.
            Rows::Scratch(writer) => writer.finish(),
            Rows::Published(writer, _) => writer.finish(),
        };
        outcome.map_err(|error| fault(&self.out, error))?;
        match Arc::try_unwrap(self.out) {
            Ok(out) => Ok(out.into_inner().unwrap_or_else(PoisonError::into_inner)),
            Err(out) => Err(fault(&out, std::io::Error::other("the encoder still holds its output").into())),
        }
    }
}

fn fault<W: Sink>(out: &Mutex<W>, error: png::EncodingError) -> Error {
    out.lock().unwrap_or_else(PoisonError::into_inner).fault(error)
}

impl<W: Sink> Rows<W> {
    fn new<T: Sample>(
        out: Shared<W>,
        layout: Layout,
        meaning: Meaning,
        compression: Compression,
    ) -> Result<Self, png::EncodingError> {
        let mut encoder = layout.encoder::<T, _>(out, meaning);
        Ok(match compression {
            Compression::Scratch => {
                encoder.set_compression(png::Compression::Fast);
                encoder.set_filter(png::Filter::Adaptive);
                Self::Scratch(Box::new(encoder.write_header()?.into_stream_writer_with_size(1 << 16)?))
            }
            Compression::Published => {
                let bands = Bands::new(layout.size.rows, layout.row_bytes, layout.pixel_bytes);
                Self::Published(Box::new(encoder.write_header()?), bands)
            }
        })
    }
}

/// Puts a row of any strides into its bytes.
pub(super) fn gather<T: Sample>(row: ArrayView2<'_, T>, bytes: &mut [u8]) {
    match row.as_slice() {
        Some(dense) => T::put_dense(dense, bytes),
        None => row.iter().zip(bytes.chunks_exact_mut(T::BYTES)).for_each(|(sample, bytes)| sample.put(bytes)),
    }
}
