//! The encoder of one part of scanlines, top to bottom: blocks are compressed in parallel and written in order.
//!
//! The offset table of the blocks comes before them in the file, but is known after the last one. So the file begins
//! with an empty table, and the caller overwrites it at the end.

use std::io::{Cursor, Write};
use std::ops::Range;
use std::path::Path;

use exr::meta::attribute::{ChannelDescription, LineOrder, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::meta::{BlockDescription, Headers};
use holo_core::GridSize;
use ndarray::ArrayView2;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::samples::{self, Scratch};
use super::{ExrCompression, ExrSamples};
use crate::Error;
use crate::files::panic_guard::{catch, guarded};

/// Maximum length of the name of a channel in the format.
const MAX_NAME_BYTES: usize = 255;

/// Maximum size of the blocks that wait for compression, in bytes, unless one block is larger.
const BATCH_BYTES: usize = 64 << 20;

/// A channel in the order of the file.
struct Channel {
    /// Its index in the order of the caller.
    place: usize,
    name: String,
    samples: ExrSamples,
}

/// Sorts the channels by name, as the format requires, and checks sizes and names.
fn check(size: GridSize, channels: &[(&str, ExrSamples)], path: &Path) -> Result<Vec<Channel>, Error> {
    let bad = |what: String| Error::bad_input(path, what);
    // The bound of the format: half the range of its 32-bit coordinates.
    let most = (i32::MAX / 2) as usize;
    if !(1..most).contains(&size.rows) || !(1..most).contains(&size.columns) {
        return Err(bad(format!("an image of {} x {} pixels cannot be an EXR", size.columns, size.rows)));
    }
    let mut sorted = Vec::with_capacity(channels.len());
    for (place, &(name, samples)) in channels.iter().enumerate() {
        if name.is_empty() || name.len() > MAX_NAME_BYTES || name.contains('\0') {
            return Err(bad(format!("a channel's name has 1 to {MAX_NAME_BYTES} bytes and no NUL, unlike {name:?}")));
        }
        if samples == ExrSamples::Half && ExrSamples::is_identifier(name) {
            return Err(bad(format!(
                "channel {name} holds identifiers, which are not exact in 16-bit floats above 2048; write it in 32-bit \
                 floats"
            )));
        }
        sorted.push(Channel { place, name: name.to_owned(), samples });
    }
    if sorted.is_empty() {
        return Err(bad("an EXR needs at least one channel".into()));
    }
    sorted.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return Err(bad(format!("the channel {} occurs twice", pair[0].name)));
    }
    Ok(sorted)
}

/// The encoder of one file.
pub(super) struct Encoder {
    channels: Vec<Channel>,
    compression: ExrCompression,
    headers: Headers,
    size: GridSize,
    line_bytes: usize,
    /// Number of rows that were written.
    rows: usize,
    /// Complete blocks that wait for compression, and the incomplete one.
    waiting: Vec<Vec<u8>>,
    block: Vec<u8>,
    at_once: usize,
    /// Position of the offset table in the file, its entries so far, and the position of the next block.
    table_at: usize,
    table: Vec<u64>,
    position: u64,
    /// Set by an error, after which the rows in the file are unknown.
    has_failed: bool,
}

impl Encoder {
    /// Writes the header and an empty table.
    pub fn new(
        size: GridSize,
        channels: &[(&str, ExrSamples)],
        compression: ExrCompression,
        path: &Path,
        out: &mut impl Write,
    ) -> Result<Self, Error> {
        let channels = check(size, channels, path)?;
        let line_bytes = channels
            .iter()
            .try_fold(0_usize, |sum, channel| sum.checked_add(channel.samples.bytes().checked_mul(size.columns)?));
        // The format counts the bytes of a block in 31 bits.
        let block_bytes = line_bytes.and_then(|bytes| bytes.checked_mul(compression.lines()));
        let (Some(line_bytes), Some(block_bytes @ ..=0x7fff_ffff)) = (line_bytes, block_bytes) else {
            let what = format!(
                "{} channels of {} columns are too much for the {} lines of one block; write them to several files",
                channels.len(),
                size.columns,
                compression.lines()
            );
            return Err(Error::bad_input(path, what));
        };
        let describe = |channel: &Channel| {
            // The conversion of the crate accepts Latin-1 only; the format stores bytes, in practice UTF-8.
            ChannelDescription::new(Text::from_slice_unchecked(channel.name.as_bytes()), channel.samples.kind(), false)
        };
        let descriptions = channels.iter().map(describe).collect();
        let header = Header::new(Text::default(), (size.columns, size.rows), descriptions)
            .with_encoding(compression.coding(), BlockDescription::ScanLines, LineOrder::Increasing)
            // A single part has no name.
            .with_attributes(LayerAttributes::default());
        let blocks = header.chunk_count;
        let headers: Headers = [header].into_iter().collect();
        let start = head(&headers, path)?;
        out.write_all(&start).map_err(|error| Error::io("write", path, error))?;
        Ok(Self {
            channels,
            compression,
            headers,
            size,
            line_bytes,
            rows: 0,
            waiting: Vec::new(),
            block: Vec::new(),
            at_once: (BATCH_BYTES / block_bytes).clamp(1, 4 * rayon::current_num_threads()),
            table_at: start.len() - blocks * size_of::<u64>(),
            table: Vec::with_capacity(blocks),
            position: start.len() as u64,
            has_failed: false,
        })
    }

    /// Writes the next rows: one plane a channel, in the order of the caller.
    pub fn write_rows(
        &mut self,
        planes: &[ArrayView2<'_, f32>],
        path: &Path,
        out: &mut impl Write,
    ) -> Result<(), Error> {
        if self.has_failed {
            return Err(Error::bad_input(path, "an earlier band of rows could not be written"));
        }
        let outcome = self.check_rows(planes, path).and_then(|rows| self.take_rows(planes, rows, path, out));
        self.has_failed = outcome.is_err();
        outcome
    }

    fn check_rows(&self, planes: &[ArrayView2<'_, f32>], path: &Path) -> Result<usize, Error> {
        let bad = |what: String| Err(Error::bad_input(path, what));
        if planes.len() != self.channels.len() {
            return bad(format!("{} planes were given for {} channels", planes.len(), self.channels.len()));
        }
        let rows = planes[0].dim().0;
        for channel in &self.channels {
            let (own_rows, own_columns) = planes[channel.place].dim();
            if (own_rows, own_columns) != (rows, self.size.columns) {
                return bad(format!(
                    "channel {} has {own_columns} x {own_rows} pixels where {} x {rows} are needed",
                    channel.name, self.size.columns
                ));
            }
        }
        let left = self.size.rows - self.rows;
        if rows > left {
            return bad(format!("{rows} rows were given, but of {} only {left} are missing", self.size.rows));
        }
        Ok(rows)
    }

    fn take_rows(
        &mut self,
        planes: &[ArrayView2<'_, f32>],
        rows: usize,
        path: &Path,
        out: &mut impl Write,
    ) -> Result<(), Error> {
        let lines = self.compression.lines();
        let mut row = 0;
        while row < rows {
            // Pieces that end at the ends of blocks.
            let mut pieces = Vec::new();
            while row < rows && pieces.len() < self.at_once {
                let end = rows.min(row + lines - (self.rows + row) % lines);
                pieces.push(row..end);
                row = end;
            }
            let first = pieces[0].start;
            let gathered: Vec<_> = pieces.into_par_iter().map(|piece| self.gather(planes, piece, path)).collect();
            for bytes in gathered {
                let bytes = bytes?;
                if self.block.is_empty() {
                    self.block = bytes;
                } else {
                    self.block.extend_from_slice(&bytes);
                }
                let whole = (self.size.rows - self.first_of_block()).min(lines) * self.line_bytes;
                if self.block.len() == whole {
                    self.waiting.push(std::mem::take(&mut self.block));
                }
                if self.waiting.len() >= self.at_once {
                    self.compress(path, out)?;
                }
            }
            debug_assert!(row > first, "every iteration takes rows");
        }
        self.rows += rows;
        Ok(())
    }

    /// The first row of the incomplete block.
    fn first_of_block(&self) -> usize {
        (self.table.len() + self.waiting.len()) * self.compression.lines()
    }

    /// Returns the samples of some rows in the order of a block.
    fn gather(&self, planes: &[ArrayView2<'_, f32>], rows: Range<usize>, path: &Path) -> Result<Vec<u8>, Error> {
        let order = self.compression.byte_order();
        let mut scratch = Scratch::default();
        let mut bytes = Vec::with_capacity(rows.len() * self.line_bytes);
        for row in rows {
            for channel in &self.channels {
                let line = planes[channel.place].row(row);
                samples::append(line, channel.samples, order, &mut scratch, &mut bytes).map_err(|(column, value)| {
                    let (name, row) = (&channel.name, self.rows + row);
                    Error::bad_input(
                        path,
                        format!(
                            "channel {name}, row {row}, column {column}: {value} is beyond 65504, the largest 16-bit \
                             float; write the channel in 32-bit floats, or scale it"
                        ),
                    )
                })?;
            }
        }
        Ok(bytes)
    }

    /// Compresses and writes the waiting blocks.
    fn compress(&mut self, path: &Path, out: &mut impl Write) -> Result<(), Error> {
        let (lines, compression, headers) = (self.compression.lines(), self.compression, self.headers.as_slice());
        let first = self.table.len();
        let blocks: Vec<_> =
            std::mem::take(&mut self.waiting).into_iter().enumerate().map(|(at, block)| (first + at, block)).collect();
        let compress =
            |(index, block): (usize, Vec<u8>)| (index, guarded(|| compression.compress(block, index * lines, headers)));
        let compressed: Vec<_> =
            catch(|| blocks.into_par_iter().map(compress).collect()).map_err(|text| failed(path, &text))?;
        for (index, block) in compressed {
            let block = block.map_err(|error| failed(path, &error.to_string()))?;
            // Checked in `new`: rows are fewer than 2^30 and a block has less than 2^31 bytes.
            let mut start = ((index * lines) as i32).to_le_bytes().to_vec();
            start.extend((block.len() as i32).to_le_bytes());
            out.write_all(&start)
                .and_then(|()| out.write_all(&block))
                .map_err(|error| Error::io("write", path, error))?;
            self.table.push(self.position);
            self.position += (start.len() + block.len()) as u64;
        }
        Ok(())
    }

    /// Writes the waiting blocks. Returns the position and the bytes of the offset table, which the caller overwrites.
    pub fn finish(mut self, path: &Path, out: &mut impl Write) -> Result<(usize, Vec<u8>), Error> {
        if self.has_failed {
            return Err(Error::bad_input(path, "the image is not complete: a band of rows could not be written"));
        }
        if self.rows != self.size.rows {
            let what = format!("the image is not complete: {} of {} rows were written", self.rows, self.size.rows);
            return Err(Error::bad_input(path, what));
        }
        self.compress(path, out)?;
        Ok((self.table_at, self.table.iter().flat_map(|position| position.to_le_bytes()).collect()))
    }
}

fn failed(path: &Path, text: &str) -> Error {
    Error::bad_input(path, format!("the EXR encoder failed: {text}"))
}

/// The bytes of a file up to its first block, with an empty offset table.
fn head(headers: &Headers, path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let outcome = catch(|| {
        // The crate writes a header only as the beginning of a file, so writing the file is aborted after it.
        exr::block::write(Cursor::new(&mut bytes), headers.clone(), true, |_, _| Err(exr::error::Error::Aborted))
    });
    match outcome {
        Ok(Err(exr::error::Error::Aborted)) => Ok(bytes),
        Ok(Err(error)) => Err(failed(path, &error.to_string())),
        Ok(Ok(())) => Err(failed(path, "it completed a file without blocks")),
        Err(text) => Err(failed(path, &text)),
    }
}
