//! The reading state of one part of a file: where its samples are written, and which of its blocks were read.

use std::path::Path;

use exr::block::UncompressedBlock;
use exr::meta::BlockDescription;
use exr::meta::attribute::{IntegerBounds, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;

use super::FORMAT;
use crate::{Error, Limits};

/// The destination of the samples of one channel: `values[first + step * (row * columns + column)]` of a buffer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Destination {
    pub channel: usize,
    pub buffer: usize,
    pub first: usize,
    pub step: usize,
}

/// A part of a file that is being read.
pub(super) struct Part {
    /// In the order of the channels.
    wanted: Vec<Destination>,
    channels: Vec<SampleType>,
    block: (usize, usize),
    blocks_across: usize,
    /// Whether each block was read, in rows of blocks.
    arrived: Vec<bool>,
    missing: usize,
    frame: Frame,
}

/// The size of the display window, and the position of the data window in it.
#[derive(Debug, Clone, Copy)]
struct Frame {
    rows: usize,
    columns: usize,
    /// Offset from row and column in the data window to those in the display window.
    shift: (i64, i64),
}

/// Rows and columns of the display window.
pub(super) fn display_size(header: &Header) -> (usize, usize) {
    let size = header.shared_attributes.display_window.size;
    (size.height(), size.width())
}

/// The size of the largest block of a part in bytes, checked against the limit.
pub(super) fn block_bytes(header: &Header, path: &Path, limits: Limits) -> Result<usize, Error> {
    let size = header.max_block_pixel_size();
    limits.elements(path, "block of pixels", &[size.height(), size.width(), header.channels.bytes_per_pixel], 1)
}

impl Part {
    pub fn new(header: &Header, mut wanted: Vec<Destination>, path: &Path, limits: Limits) -> Result<Self, Error> {
        wanted.sort_by_key(|to| to.channel);
        let display: IntegerBounds = header.shared_attributes.display_window;
        let data = header.data_window();
        let (rows, columns) = display_size(header);
        let shift = |data: i32, display: i32| i64::from(data) - i64::from(display);
        let frame = Frame {
            rows,
            columns,
            shift: (shift(data.position.y(), display.position.y()), shift(data.position.x(), display.position.x())),
        };
        let size = header.max_block_pixel_size();
        let block = (size.height(), size.width());
        // Of the largest level only: the table of the file has entries for all levels.
        let blocks_across = data.size.width().div_ceil(block.1);
        let count =
            limits.elements(path, "list of blocks", &[data.size.height().div_ceil(block.0), blocks_across], 1)?;
        let mut arrived = Limits::room(path, "list of blocks", count)?;
        arrived.resize(count, false);
        let channels = header.channels.list.iter().map(|channel| channel.sample_type).collect();
        Ok(Self { wanted, channels, block, blocks_across, arrived, missing: count, frame })
    }

    pub fn is_complete(&self) -> bool {
        self.missing == 0
    }

    /// Number of blocks that were not read, and of all blocks.
    pub fn missing(&self) -> (usize, usize) {
        (self.missing, self.arrived.len())
    }

    /// Copies the wanted samples of a block into the buffers.
    pub fn place(&mut self, block: &UncompressedBlock, buffers: &mut [Vec<f32>], path: &Path) -> Result<(), Error> {
        let broken = |what: String| Error::broken(path, FORMAT, what);
        let (x, y) = (block.index.pixel_position.x(), block.index.pixel_position.y());
        let (width, height) = (block.index.pixel_size.width(), block.index.pixel_size.height());
        let place = (y / self.block.0) * self.blocks_across + x / self.block.1;
        match self.arrived.get_mut(place) {
            Some(arrived @ false) => *arrived = true,
            _ => return Err(broken(format!("the block at row {y}, column {x} occurs twice"))),
        }
        self.missing -= 1;
        // Of every row, the block holds all samples of the first channel, then all of the second.
        let line_bytes: usize = self.channels.iter().map(|kind| kind.bytes_per_sample() * width).sum();
        if block.data.len() != line_bytes * height {
            return Err(broken(format!("the block at row {y}, column {x} has {} bytes", block.data.len())));
        }
        for (index, line) in block.data.chunks_exact(line_bytes.max(1)).enumerate() {
            let Some(row) = inside(y + index, self.frame.shift.0, self.frame.rows) else { continue };
            let mut start = 0;
            let mut wanted = self.wanted.as_slice();
            for (channel, kind) in self.channels.iter().enumerate() {
                let samples = &line[start..start + kind.bytes_per_sample() * width];
                start += samples.len();
                while let Some((to, behind)) = wanted.split_first().filter(|(to, _)| to.channel == channel) {
                    self.frame.place_line(samples, *kind, (row, x), *to, &mut buffers[to.buffer]);
                    wanted = behind;
                }
            }
        }
        Ok(())
    }
}

/// Converts a coordinate from the data window to the display window; `None` outside of it.
fn inside(coordinate: usize, shift: i64, size: usize) -> Option<usize> {
    usize::try_from(coordinate as i64 + shift).ok().filter(|&coordinate| coordinate < size)
}

impl Frame {
    /// Converts the samples of a line that are inside the display window.
    fn place_line(
        &self,
        samples: &[u8],
        kind: SampleType,
        (row, x): (usize, usize),
        to: Destination,
        values: &mut [f32],
    ) {
        let put = |column: usize, value: f32, values: &mut [f32]| {
            if let Some(column) = inside(x + column, self.shift.1, self.columns) {
                values[to.first + to.step * (row * self.columns + column)] = value;
            }
        };
        // Blocks are in the byte order of the machine.
        match kind {
            SampleType::F16 => {
                for (column, bytes) in samples.chunks_exact(2).enumerate() {
                    put(column, f16::from_ne_bytes([bytes[0], bytes[1]]).to_f32(), values);
                }
            }
            SampleType::F32 => {
                for (column, bytes) in samples.chunks_exact(4).enumerate() {
                    put(column, f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]), values);
                }
            }
            SampleType::U32 => {
                for (column, bytes) in samples.chunks_exact(4).enumerate() {
                    put(column, u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32, values);
                }
            }
        }
    }
}

/// Whether a chunk belongs to the largest resolution level.
pub(super) fn is_largest_level(header: &Header, chunk: &exr::block::chunk::Chunk) -> bool {
    match (&chunk.compressed_block, header.blocks) {
        (exr::block::chunk::CompressedBlock::Tile(tile), BlockDescription::Tiles(_)) => {
            tile.coordinates.is_largest_resolution_level()
        }
        _ => true,
    }
}
