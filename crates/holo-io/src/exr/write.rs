//! Writes one part of 32-bit floats: blocks of 16 rows, compressed side by side and put down in their order.

use std::io::Cursor;
use std::path::Path;

use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Compression, LineOrder, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::Vec2;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::ExrChannel;
use crate::Error;
use crate::net::{catch, guarded};

/// What the format allows in a channel's name.
const MAX_NAME_BYTES: usize = 255;

/// Sorts the channels by name, as the format wants them, and refuses what cannot be written.
pub(super) fn check<'a>(channels: &[ExrChannel<'a>], path: &Path) -> Result<Vec<ExrChannel<'a>>, Error> {
    let bad = |what: String| Error::bad_input(path, what);
    let mut sorted = channels.to_vec();
    sorted.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
    let Some(first) = sorted.first() else { return Err(bad("an EXR needs at least one channel".into())) };
    let (rows, columns) = first.plane.dim();
    // The format's own bound, half the range of its 32-bit coordinates.
    let most = (i32::MAX / 2) as usize;
    if !(1..most).contains(&rows) || !(1..most).contains(&columns) {
        return Err(bad(format!("an image of {columns} x {rows} pixels cannot be an EXR")));
    }
    for channel in &sorted {
        let name = channel.name;
        if name.is_empty() || name.len() > MAX_NAME_BYTES || name.contains('\0') {
            return Err(bad(format!("a channel's name has 1 to {MAX_NAME_BYTES} bytes and no NUL, unlike {name:?}")));
        }
        if channel.plane.dim() != (rows, columns) {
            let (own_rows, own_columns) = channel.plane.dim();
            return Err(bad(format!(
                "channel {name} has {own_columns} x {own_rows} pixels, channel {} has {columns} x {rows}",
                first.name
            )));
        }
    }
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return Err(bad(format!("the channel {} occurs twice", pair[0].name)));
    }
    Ok(sorted)
}

/// The bytes of the file. The channels have passed [`check`].
pub(super) fn encode(channels: &[ExrChannel<'_>], path: &Path) -> Result<Vec<u8>, Error> {
    let failed = |text: String| Error::bad_input(path, format!("the EXR encoder failed: {text}"));
    let outcome = catch(|| {
        let mut bytes = Vec::new();
        write(channels, &mut bytes).map(|()| bytes)
    });
    outcome.map_err(failed)?.map_err(|error| failed(error.to_string()))
}

fn write(channels: &[ExrChannel<'_>], bytes: &mut Vec<u8>) -> exr::error::UnitResult {
    let (rows, columns) = channels[0].plane.dim();
    let describe = |channel: &ExrChannel<'_>| {
        // The crate's own conversion takes Latin-1 only; the format stores bytes, in practice UTF-8.
        ChannelDescription::new(Text::from_slice_unchecked(channel.name.as_bytes()), SampleType::F32, false)
    };
    let header = Header::new(Text::default(), (columns, rows), channels.iter().map(describe).collect())
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        // A single part has no name.
        .with_attributes(LayerAttributes::default());
    let height = Compression::ZIP16.scan_lines_per_block();
    let headers = [header].into_iter().collect();
    exr::block::write(Cursor::new(bytes), headers, true, |meta, writer| {
        let blocks = rows.div_ceil(height);
        let at_once = 4 * rayon::current_num_threads();
        for start in (0..blocks).step_by(at_once) {
            let batch = (start..blocks.min(start + at_once)).into_par_iter();
            let chunks: Vec<_> = batch
                .map(|index| {
                    let block = block(channels, index * height, height.min(rows - index * height));
                    (index, guarded(|| block.compress_to_chunk(&meta.headers)))
                })
                .collect();
            for (index, chunk) in chunks {
                writer.write_chunk(index, chunk?)?;
            }
        }
        Ok(())
    })
}

/// The rows from `first` on: of every row all samples of the first channel, then all of the second.
fn block(channels: &[ExrChannel<'_>], first: usize, height: usize) -> UncompressedBlock {
    let columns = channels[0].plane.dim().1;
    let mut data = Vec::with_capacity(channels.len() * height * columns * size_of::<f32>());
    for row in first..first + height {
        for channel in channels {
            for value in channel.plane.row(row) {
                // Blocks are in the byte order of the machine; the crate turns them into that of the file.
                data.extend(value.to_ne_bytes());
            }
        }
    }
    let index =
        BlockIndex { layer: 0, pixel_position: Vec2(0, first), pixel_size: Vec2(columns, height), level: Vec2(0, 0) };
    UncompressedBlock { index, data }
}
