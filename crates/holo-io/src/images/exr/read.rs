//! Reads a file block by block and decompresses blocks in parallel.
//!
//! The parallel reader of the crate `exr` is not used: it runs on threads of its own, in which a panic ends the
//! process. Blocks are read in the order of the file, without its offset table, which some programs leave empty.

use std::io::{Read, Seek};
use std::path::Path;

use exr::block::UncompressedBlock;
use exr::block::reader::{ChunksReader, Reader};
use exr::meta::MetaData;
use holo_core::GridSize;
use ndarray::{Array2, Array3};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::dwa;
use super::names::{self, Channel};
use super::parts::{Destination, Part, block_bytes, display_size, is_largest_level};
use super::{ExrImage, ExrInfo, FORMAT};
use crate::files::panic_guard::{catch, guarded};
use crate::{Error, Limits};

/// Maximum size of the uncompressed blocks that are in memory at the same time, in bytes, unless one block is larger.
const BATCH_BYTES: usize = 64 << 20;

/// Runs the reader inside the panic guard.
fn safely<T>(path: &Path, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    catch(work).unwrap_or_else(|text| {
        let what = format!("the decoder failed on this file ({text}); the file is likely damaged; please report it");
        Err(Error::broken(path, FORMAT, what))
    })
}

/// Converts an error of the crate `exr`. `at` is the position in the file, with a colon and a space at its end.
fn read_error(error: exr::error::Error, path: &Path, at: &str) -> Error {
    match error {
        exr::error::Error::Io(error) => Error::io("read", path, error),
        exr::error::Error::NotSupported(what) => {
            Error::unsupported(path, format!("{at}this EXR file has what cannot be read: {what}"))
        }
        // The message of the crate at the end of the file.
        exr::error::Error::Invalid(what) if what == "reference to missing bytes" => Error::broken(
            path,
            FORMAT,
            format!("{at}the file ends early; it was truncated while it was written or copied"),
        ),
        error => Error::broken(path, FORMAT, format!("{at}{error}")),
    }
}

/// Reads the header and checks the sizes in it.
fn start<R: Read + Seek>(source: R, path: &Path, limits: Limits) -> Result<Reader<R>, Error> {
    let reader = exr::block::read(source, false).map_err(|error| read_error(error, path, "header: "))?;
    for header in reader.headers() {
        let (rows, columns) = display_size(header);
        if rows == 0 || columns == 0 || header.layer_size.area() == 0 {
            return Err(Error::broken(path, FORMAT, "header: a window without pixels"));
        }
        // Before the offset table is skipped: its length is a product of numbers from the file.
        limits.elements(path, "table of blocks", &[header.chunk_count], size_of::<u64>())?;
    }
    Ok(reader)
}

pub(super) fn info<R: Read + Seek>(source: R, path: &Path) -> Result<ExrInfo, Error> {
    safely(path, || {
        let reader = start(source, path, Limits::NONE)?;
        let channels = names::all(&reader.meta_data().headers);
        let Some(first) = reader.headers().first() else {
            return Err(Error::broken(path, FORMAT, "header: no parts"));
        };
        let (rows, columns) = display_size(first);
        let compression = first.compression.to_string();
        Ok(ExrInfo {
            size: GridSize::new(rows, columns),
            has_color: names::color(&channels).is_some(),
            channels: channels.into_iter().map(|channel| channel.name).collect(),
            compression: compression.strip_suffix(" compression").unwrap_or(&compression).to_owned(),
            parts: reader.headers().len(),
        })
    })
}

pub(super) fn all<R: Read + Seek>(source: R, path: &Path, limits: Limits) -> Result<ExrImage, Error> {
    safely(path, || {
        let reader = start(source, path, limits)?;
        let headers = &reader.meta_data().headers;
        let channels = names::all(headers);
        let shapes: Vec<_> = channels.iter().map(|channel| display_size(&headers[channel.part])).collect();
        // All planes together, before the first is allocated.
        let mut total = 0_usize;
        for &(rows, columns) in &shapes {
            let plane = limits.elements(path, "image", &[rows, columns], size_of::<f32>())?;
            total = total.saturating_add(plane);
            limits.elements(path, "image", &[total], size_of::<f32>())?;
        }
        let mut wanted = Vec::new();
        let mut buffers = Vec::new();
        for (buffer, (channel, &(rows, columns))) in channels.iter().zip(&shapes).enumerate() {
            wanted.push((channel.part, Destination { channel: channel.channel, buffer, first: 0, step: 1 }));
            buffers.push(zeros(rows * columns, path)?);
        }
        fill(reader, &wanted, &mut buffers, path, limits)?;
        let mut planes = Vec::with_capacity(channels.len());
        for ((channel, shape), values) in channels.into_iter().zip(shapes).zip(buffers) {
            planes
                .push((channel.name, Array2::from_shape_vec(shape, values).map_err(|error| shape_error(path, error))?));
        }
        Ok(ExrImage { channels: planes })
    })
}

pub(super) fn rgb<R: Read + Seek>(source: R, path: &Path, limits: Limits) -> Result<Array3<f32>, Error> {
    safely(path, || {
        let reader = start(source, path, limits)?;
        let headers = &reader.meta_data().headers;
        let channels = names::all(headers);
        let Some(color) = names::color(&channels) else { return Err(no_color(&channels, path)) };
        let part = channels[color[0]].part;
        let (rows, columns) = display_size(&headers[part]);
        let count = limits.elements(path, "image", &[rows, columns, 3], size_of::<f32>())?;
        let wanted: Vec<_> = color
            .iter()
            .enumerate()
            .map(|(first, &index)| (part, Destination { channel: channels[index].channel, buffer: 0, first, step: 3 }))
            .collect();
        let mut buffers = [zeros(count, path)?];
        fill(reader, &wanted, &mut buffers, path, limits)?;
        let [values] = buffers;
        Array3::from_shape_vec((rows, columns, 3), values).map_err(|error| shape_error(path, error))
    })
}

fn zeros(count: usize, path: &Path) -> Result<Vec<f32>, Error> {
    let mut values = Limits::room(path, "image", count)?;
    values.resize(count, 0.0);
    Ok(values)
}

fn shape_error(path: &Path, error: ndarray::ShapeError) -> Error {
    Error::broken(path, FORMAT, error.to_string())
}

/// The error for a file without color channels.
fn no_color(channels: &[Channel], path: &Path) -> Error {
    const SHOWN: usize = 12;
    let mut names: Vec<&str> = channels.iter().take(SHOWN).map(|channel| channel.name.as_str()).collect();
    if channels.len() > SHOWN {
        names.push("...");
    }
    Error::unsupported(
        path,
        format!(
            "this EXR file has no color channels: neither R, G and B of one layer nor a luminance Y, but {}",
            names.join(", ")
        ),
    )
}

/// Reads the blocks of all parts with a wanted channel.
fn fill<R: Read + Seek>(
    reader: Reader<R>,
    wanted: &[(usize, Destination)],
    buffers: &mut [Vec<f32>],
    path: &Path,
    limits: Limits,
) -> Result<(), Error> {
    let meta: MetaData = reader.meta_data().clone();
    let mut of_parts = vec![Vec::new(); meta.headers.len()];
    for &(part, to) in wanted {
        of_parts[part].push(to);
    }
    let mut parts = Vec::with_capacity(meta.headers.len());
    let mut largest = 1;
    for (header, here) in meta.headers.iter().zip(of_parts) {
        // Blocks of other parts are skipped, but the crate reads each of them as a whole.
        largest = largest.max(block_bytes(header, path, limits)?);
        parts.push(if here.is_empty() { None } else { Some(Part::new(header, here, path, limits)?) });
    }
    let at_once = (BATCH_BYTES / largest).clamp(1, 4 * rayon::current_num_threads());
    let mut chunks = reader.all_chunks(false).map_err(|error| read_error(error, path, "table of blocks: "))?;
    let total = chunks.expected_chunk_count();
    let mut number = 0;
    while parts.iter().flatten().any(|part| !part.is_complete()) {
        let mut batch = Vec::new();
        while batch.len() < at_once {
            let Some(chunk) = chunks.next() else { break };
            number += 1;
            let chunk = chunk.map_err(|error| read_error(error, path, &format!("block {number} of {total}: ")))?;
            let header = &meta.headers[chunk.layer_index];
            let at = || format!("block {number} of {total}: ");
            if !dwa::is_plausible(header, &chunk.compressed_block).map_err(|error| read_error(error, path, &at()))? {
                return Err(Error::broken(path, FORMAT, format!("{}it announces more than it can contain", at())));
            }
            if parts[chunk.layer_index].is_some() && is_largest_level(header, &chunk) {
                batch.push((number, chunk));
            }
        }
        if batch.is_empty() {
            let (missing, of) =
                parts.iter().flatten().map(Part::missing).find(|(missing, _)| *missing > 0).unwrap_or((0, 0));
            return Err(Error::broken(path, FORMAT, format!("{missing} of {of} blocks of pixels are missing")));
        }
        let blocks: Vec<_> = batch
            .into_par_iter()
            .map(|(number, chunk)| guarded(|| (number, UncompressedBlock::decompress_chunk(chunk, &meta, false))))
            .collect();
        for (number, block) in blocks {
            let block = block.map_err(|error| read_error(error, path, &format!("block {number} of {total}: ")))?;
            if let Some(part) = &mut parts[block.index.layer] {
                part.place(&block, buffers, path)?;
            }
        }
    }
    Ok(())
}
