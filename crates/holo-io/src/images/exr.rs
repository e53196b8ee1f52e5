//! OpenEXR: images of many float channels, and environment maps.
//!
//! Through the crate `exr`, one block at a time: what a header announces is compared with the memory limit first,
//! blocks are decompressed in parallel on the threads of rayon, and samples are written directly into the planes that
//! are returned. A panic of the crate on a damaged file becomes an error; see [`is_guarding`](crate::is_guarding).
//!
//! # Model
//!
//! - **Size**: an image is the *display window* of its file. Outside the data window samples are 0; samples outside the
//!   display window (overscan) are dropped.
//! - **Names**: channels have their full names with layers, such as `ViewLayer.Combined.R`. In a file of several parts
//!   the name of the part comes first.
//! - **Samples**: half and float samples are exact, `NaN` and infinity included; 32-bit integers are rounded to the
//!   nearest `f32`, so identifiers above 2^24 are not exact.
//! - **Resolution levels**: only the largest is read.
//! - **Not read**: deep data, subsampled channels, and the codings HTJ2K, ZSTD and later ones. Chromaticities are
//!   ignored.
//! - **Written**: one part, scanlines, floats of 32 or 16 bits, one of four codings, display window = data window = the
//!   planes. The same planes give the same bytes for any number of threads and any bands; the file contains neither
//!   date nor program name.
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

use std::io::{Cursor, Read, Write};
use std::path::Path;

use holo_core::GridSize;
use ndarray::{Array2, Array3, ArrayView2};

use crate::error::STREAM;
use crate::files::folder::Destination;
use crate::files::stream::{open, read_to_end, write_bytes};
use crate::{Error, FileDigest, Limits};

pub use compress::ExrCompression;
pub use samples::ExrSamples;
pub use stream::ExrWriter;

/// The format's name in messages.
const FORMAT: &str = "EXR";

/// A channel to be written.
#[derive(Debug, Clone, Copy)]
pub struct ExrChannel<'a> {
    /// The full name, such as `ViewLayer.Combined.R`: layers, dots, and the component last.
    pub name: &'a str,
    /// The samples, `(rows, columns)`, top row first; any strides.
    pub plane: ArrayView2<'a, f32>,
    /// The format of the samples in the file.
    pub samples: ExrSamples,
}

impl<'a> ExrChannel<'a> {
    /// Creates a channel of 32-bit floats, which are exact.
    #[must_use]
    pub fn float(name: &'a str, plane: ArrayView2<'a, f32>) -> Self {
        Self { name, plane, samples: ExrSamples::Float }
    }

    /// Creates a channel of 16-bit floats; see [`ExrSamples::Half`] for their range and accuracy.
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
    /// Returns the plane of a channel by its full name; of several with the same name in a faulty file, the first.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Array2<f32>> {
        self.channels.iter().find_map(|(own, plane)| (own == name).then_some(plane))
    }

    /// Returns the plane of a component of a Blender pass, such as `pass("IndexOB", "X")`, from the first view layer
    /// that has it.
    ///
    /// Blender 5 renamed some passes, such as `IndexOB` to `Object Index`; either name finds both.
    #[must_use]
    pub fn pass(&self, pass: &str, component: &str) -> Option<&Array2<f32>> {
        self.channels.iter().find_map(|(own, plane)| names::is_of_pass(own, pass, component).then_some(plane))
    }
}

/// The header of an EXR file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExrInfo {
    /// Rows and columns of the display window.
    pub size: GridSize,
    /// The full names of all channels.
    pub channels: Vec<String>,
    /// The compression of the first part, such as `"zip block"`.
    pub compression: String,
    /// Number of parts; 1 in most files.
    pub parts: usize,
    /// Whether [`read_exr_rgb`] finds RGB or luminance in it.
    pub has_color: bool,
}

/// Writes an EXR with [`ExrCompression::Zip`].
///
/// [`write_exr_with`] takes the compression as an argument; [`ExrWriter`] writes images that do not fit into memory.
///
/// # Errors
///
/// [`Error::BadInput`] if there is no channel or no pixel, if planes differ in size, if names repeat, are empty, longer
/// than 255 bytes or contain a NUL, or if a channel of 16-bit floats cannot represent its values
/// ([`ExrSamples::Half`]); [`Error::Io`] if the file cannot be written. No file of that name appears then.
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
pub fn write_exr(path: impl Destination, channels: &[ExrChannel<'_>]) -> Result<FileDigest, Error> {
    write_exr_with(path, channels, ExrCompression::Zip)
}

/// Writes an EXR with the given compression.
///
/// # Errors
///
/// Those of [`write_exr`].
pub fn write_exr_with(
    path: impl Destination,
    channels: &[ExrChannel<'_>],
    compression: ExrCompression,
) -> Result<FileDigest, Error> {
    let size = common_size(channels, path.path())?;
    let mut writer = ExrWriter::create(path, size, &formats(channels), compression)?;
    writer.write_rows(&planes(channels))?;
    writer.finish()
}

/// Encodes an EXR into a stream: the bytes that [`write_exr`] writes.
///
/// They are encoded in memory first, because a table of offsets precedes the pixels.
///
/// # Errors
///
/// [`Error::BadInput`] as in [`write_exr`]; [`Error::Io`] if `out` cannot be written.
pub fn encode_exr(out: impl Write, channels: &[ExrChannel<'_>]) -> Result<(), Error> {
    encode_exr_with(out, channels, ExrCompression::Zip)
}

/// Encodes an EXR into a stream, like [`encode_exr`]: the bytes that [`write_exr_with`] writes.
///
/// # Errors
///
/// Those of [`encode_exr`].
pub fn encode_exr_with(out: impl Write, channels: &[ExrChannel<'_>], compression: ExrCompression) -> Result<(), Error> {
    let path = Path::new(STREAM);
    let size = common_size(channels, path)?;
    let mut bytes = Vec::new();
    let mut encoder = write::Encoder::new(size, &formats(channels), compression, path, &mut bytes)?;
    encoder.write_rows(&planes(channels), path, &mut bytes)?;
    let (at, table) = encoder.finish(path, &mut bytes)?;
    bytes[at..at + table.len()].copy_from_slice(&table);
    write_bytes(out, &bytes)
}

/// The size of all planes; without planes any size, because the encoder refuses to write no channels.
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
/// The limit is for the planes that are returned; decompressed blocks take up to 64 MiB more, or one block.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not an EXR, is truncated or damaged;
/// [`Error::Unsupported`] for deep data, subsampled channels and the codings HTJ2K, ZSTD and later ones;
/// [`Error::TooLarge`] if the planes, or one block, exceed the limits, before memory is allocated for them.
pub fn read_exr(path: impl AsRef<Path>, limits: &Limits) -> Result<ExrImage, Error> {
    let path = path.as_ref();
    read::all(open(path)?, path, *limits)
}

/// Decodes an EXR from a stream, like [`read_exr`]. The encoded bytes are read into memory first.
///
/// # Errors
///
/// Those of [`read_exr`].
pub fn decode_exr(source: impl Read, limits: &Limits) -> Result<ExrImage, Error> {
    read::all(Cursor::new(read_to_end(source, *limits)?), Path::new(STREAM), *limits)
}

/// Reads the color channels of an EXR, such as an environment map, as linear RGB.
///
/// They are R, G and B without a layer; else those of a layer called `Combined`; else those of the first layer that has
/// them. Without any, a luminance channel Y (in a layer without X, Z and RY) becomes gray. Alpha is ignored, because
/// EXR stores premultiplied color. Other channels take no memory.
///
/// # Shape
///
/// `(rows, columns, 3)`, top row first.
///
/// # Errors
///
/// Those of [`read_exr`], and [`Error::Unsupported`] if there are no such channels.
pub fn read_exr_rgb(path: impl AsRef<Path>, limits: &Limits) -> Result<Array3<f32>, Error> {
    let path = path.as_ref();
    read::rgb(open(path)?, path, *limits)
}

/// Decodes the color channels of an EXR from a stream, like [`read_exr_rgb`]. The encoded bytes are read into memory
/// first.
///
/// # Errors
///
/// Those of [`read_exr_rgb`].
pub fn decode_exr_rgb(source: impl Read, limits: &Limits) -> Result<Array3<f32>, Error> {
    read::rgb(Cursor::new(read_to_end(source, *limits)?), Path::new(STREAM), *limits)
}

/// Reads the header of an EXR without its pixels.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] or [`Error::Unsupported`] if its header cannot be
/// read.
pub fn read_exr_info(path: impl AsRef<Path>) -> Result<ExrInfo, Error> {
    let path = path.as_ref();
    read::info(open(path)?, path)
}
