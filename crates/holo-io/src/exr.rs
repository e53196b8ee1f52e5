//! OpenEXR: many channels of floats in one file, and environment maps.
//!
//! Through the crate `exr`, one block at a time: what a header announces is compared with the budget first, blocks are
//! decompressed side by side on rayon's threads, and samples go straight into the planes that are returned. Nothing that
//! the crate does on a damaged file ends the process: [`is_guarding`](crate::is_guarding).
//!
//! # Model
//!
//! - **Frame**: an image is the *display window* of its file. Where the data window does not reach, samples are 0; what
//!   lies outside the display window (overscan) is dropped.
//! - **Names**: channels keep their full names, layers and all, such as `ViewLayer.Combined.R`. In a file of several parts
//!   the name of the part comes first.
//! - **Samples**: half and float samples arrive with their value, `NaN` and infinity included; 32-bit integers are rounded
//!   to the nearest `f32`, so identifiers above 2^24 are not exact.
//! - **Resolution levels**: only the largest is read.
//! - **Not read**: deep data, subsampled channels, and the codings HTJ2K, ZSTD and later ones. Chromaticities are not
//!   looked at.
//! - **Written**: one part, scanlines, floats of 32 or 16 bits, one of four codings, display window = data window = the
//!   planes. The same planes give the same bytes, whatever the number of threads and however they are cut into bands;
//!   there is neither date nor name of a program.
//!
//! # Source
//!
//! *The OpenEXR File Layout*, and *Technical Introduction to OpenEXR*, Academy Software Foundation.

mod compress;
mod dwa;
mod names;
mod parts;
mod read;
mod samples;
mod stream;
mod write;

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::Path;

use holo_core::GridSize;
use ndarray::{Array2, Array3, ArrayView2};

use crate::error::MEMORY;
use crate::{Error, FileDigest, Limits};

pub use compress::ExrCompression;
pub use samples::ExrSamples;
pub use stream::ExrWriter;

/// The format's name in messages.
const FORMAT: &str = "EXR";

/// One channel to be written.
#[derive(Debug, Clone, Copy)]
pub struct ExrChannel<'a> {
    /// The full name, such as `ViewLayer.Combined.R`: layers, dots, and the component last.
    pub name: &'a str,
    /// The samples, `(rows, columns)`, top row first; any strides.
    pub plane: ArrayView2<'a, f32>,
    /// What the samples are in the file.
    pub samples: ExrSamples,
}

impl<'a> ExrChannel<'a> {
    /// A channel of 32-bit floats: every value as it is.
    #[must_use]
    pub fn float(name: &'a str, plane: ArrayView2<'a, f32>) -> Self {
        Self { name, plane, samples: ExrSamples::Float }
    }

    /// A channel of 16-bit floats: half the size; see [`ExrSamples::Half`] for what it cannot hold.
    #[must_use]
    pub fn half(name: &'a str, plane: ArrayView2<'a, f32>) -> Self {
        Self { name, plane, samples: ExrSamples::Half }
    }
}

/// All channels of an EXR file.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrImage {
    /// Full names and planes `(rows, columns)`, top row first, in the order of the file: sorted by name in each part.
    pub channels: Vec<(String, Array2<f32>)>,
}

impl ExrImage {
    /// Returns the plane of a channel by its full name; the first, should a faulty file have several.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Array2<f32>> {
        self.channels.iter().find_map(|(own, plane)| (own == name).then_some(plane))
    }

    /// Returns a component of a pass of Blender's, of the first view layer that has it: `pass("IndexOB", "X")`.
    ///
    /// Blender 5 has other names for some passes than Blender before it, such as `Object Index` for `IndexOB`; either name
    /// finds both.
    #[must_use]
    pub fn pass(&self, pass: &str, component: &str) -> Option<&Array2<f32>> {
        self.channels.iter().find_map(|(own, plane)| names::is_of_pass(own, pass, component).then_some(plane))
    }
}

/// What the header of an EXR file says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExrInfo {
    /// Rows and columns of the display window.
    pub size: GridSize,
    /// The full names of all channels.
    pub channels: Vec<String>,
    /// The coding of the first part, such as `"zip block"`.
    pub compression: String,
    /// Number of parts; 1 in most files.
    pub parts: usize,
    /// Whether [`read_exr_rgb`] finds colour (or one luminance) in it.
    pub has_colour: bool,
}

/// Writes an EXR, ZIP-compressed over 16 lines.
///
/// [`write_exr_with`] has the choice of the compression, [`ExrWriter`] writes what does not fit into memory.
///
/// # Errors
///
/// [`Error::BadInput`] if there is no channel or no pixel, if planes differ in size, if names repeat, are empty, longer
/// than 255 bytes or contain a NUL, or if 16-bit floats are asked for what they cannot hold ([`ExrSamples::Half`]);
/// [`Error::Io`] if the file cannot be written. No file of that name appears then.
///
/// # Examples
///
/// ```
/// use holo_io::ExrChannel;
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join(holo_io::dataset::CENTRAL_EXR);
/// let depth_m = ndarray::array![[1.5, f32::INFINITY], [2.5, 3.5]];
/// holo_io::write_exr(&path, &[ExrChannel::float("ViewLayer.Depth.Z", depth_m.view())])?;
/// let image = holo_io::read_exr(&path, &holo_io::Limits::default())?;
/// assert_eq!(image.channel("ViewLayer.Depth.Z"), Some(&depth_m));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_exr(path: impl AsRef<Path>, channels: &[ExrChannel<'_>]) -> Result<FileDigest, Error> {
    write_exr_with(path, channels, ExrCompression::Zip)
}

/// Writes an EXR, compressed as one likes.
///
/// # Errors
///
/// Those of [`write_exr`].
pub fn write_exr_with(
    path: impl AsRef<Path>,
    channels: &[ExrChannel<'_>],
    compression: ExrCompression,
) -> Result<FileDigest, Error> {
    let path = path.as_ref();
    let size = common_size(channels, path)?;
    let mut writer = ExrWriter::create(path, size, &formats(channels), compression)?;
    writer.write_rows(&planes(channels))?;
    writer.finish()
}

/// Returns the bytes that [`write_exr`] would write.
///
/// # Errors
///
/// [`Error::BadInput`] as there.
pub fn encode_exr(channels: &[ExrChannel<'_>]) -> Result<Vec<u8>, Error> {
    encode_exr_with(channels, ExrCompression::Zip)
}

/// Returns the bytes that [`write_exr_with`] would write.
///
/// # Errors
///
/// [`Error::BadInput`] as there.
pub fn encode_exr_with(channels: &[ExrChannel<'_>], compression: ExrCompression) -> Result<Vec<u8>, Error> {
    let path = Path::new(MEMORY);
    let size = common_size(channels, path)?;
    let mut bytes = Vec::new();
    let mut encoder = write::Encoder::new(size, &formats(channels), compression, path, &mut bytes)?;
    encoder.write_rows(&planes(channels), path, &mut bytes)?;
    let (at, table) = encoder.finish(path, &mut bytes)?;
    bytes[at..at + table.len()].copy_from_slice(&table);
    Ok(bytes)
}

/// The size of all planes; without any, one that is refused later.
fn common_size(channels: &[ExrChannel<'_>], path: &Path) -> Result<GridSize, Error> {
    let Some(first) = channels.first() else { return Ok(GridSize::new(1, 1)) };
    let (rows, columns) = first.plane.dim();
    for channel in channels {
        let (own_rows, own_columns) = channel.plane.dim();
        if (own_rows, own_columns) != (rows, columns) {
            let what = format!(
                "channel {} has {own_columns} x {own_rows} pixels, channel {} has {columns} x {rows}",
                channel.name, first.name
            );
            return Err(Error::bad_input(path, what));
        }
    }
    Ok(GridSize::new(rows, columns))
}

fn formats<'a>(channels: &[ExrChannel<'a>]) -> Vec<(&'a str, ExrSamples)> {
    channels.iter().map(|channel| (channel.name, channel.samples)).collect()
}

fn planes<'a>(channels: &[ExrChannel<'a>]) -> Vec<ArrayView2<'a, f32>> {
    channels.iter().map(|channel| channel.plane).collect()
}

/// Reads all channels of an EXR: every part, any sample type, scanlines or tiles.
///
/// The budget is for the planes that are returned; blocks on their way take up to 64 MiB more, or one block.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not an EXR, is truncated or damaged;
/// [`Error::Unsupported`] for what the module's introduction lists; [`Error::TooLarge`] if the planes, or one block,
/// exceed the limits, before memory is taken for them.
pub fn read_exr(path: impl AsRef<Path>, limits: &Limits) -> Result<ExrImage, Error> {
    let path = path.as_ref();
    read::all(open(path)?, path, *limits)
}

/// Reads an EXR that is in memory, like [`read_exr`].
///
/// # Errors
///
/// Those of [`read_exr`].
pub fn decode_exr(bytes: &[u8], limits: &Limits) -> Result<ExrImage, Error> {
    read::all(Cursor::new(bytes), Path::new(MEMORY), *limits)
}

/// Reads the colour of an EXR, such as an environment map, as linear RGB `(rows, columns, 3)`, top row first.
///
/// The colour is R, G and B without a layer; else those of a layer called `Combined`; else those of the first layer that
/// has them. Without any, a channel Y that stands for luminance (not one beside X or Z) becomes grey. Alpha is ignored:
/// colour is premultiplied in EXR, so it already is the light that arrives. Other channels take no memory.
///
/// # Errors
///
/// Those of [`read_exr`], and [`Error::Unsupported`] if there is no such colour.
pub fn read_exr_rgb(path: impl AsRef<Path>, limits: &Limits) -> Result<Array3<f32>, Error> {
    let path = path.as_ref();
    read::rgb(open(path)?, path, *limits)
}

/// Reads the colour of an EXR that is in memory, like [`read_exr_rgb`].
///
/// # Errors
///
/// Those of [`read_exr_rgb`].
pub fn decode_exr_rgb(bytes: &[u8], limits: &Limits) -> Result<Array3<f32>, Error> {
    read::rgb(Cursor::new(bytes), Path::new(MEMORY), *limits)
}

/// Reads the header of an EXR without its pixels.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] or [`Error::Unsupported`] if its header cannot be.
pub fn read_exr_info(path: impl AsRef<Path>) -> Result<ExrInfo, Error> {
    let path = path.as_ref();
    read::info(open(path)?, path)
}

fn open(path: &Path) -> Result<BufReader<File>, Error> {
    let file = File::open(path).map_err(|source| Error::io("read", path, source))?;
    Ok(BufReader::with_capacity(1 << 18, file))
}
