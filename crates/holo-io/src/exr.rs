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
//! - **Written**: one part, scanlines, 32-bit floats, ZIP over 16 lines, display window = data window = the planes. The
//!   same planes give the same bytes, whatever the number of threads; there is neither date nor name of a program.
//!
//! # Source
//!
//! *The OpenEXR File Layout*, and *Technical Introduction to OpenEXR*, Academy Software Foundation.

mod dwa;
mod names;
mod parts;
mod read;
mod write;

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::Path;

use holo_core::GridSize;
use ndarray::{Array2, Array3, ArrayView2};

use crate::error::MEMORY;
use crate::{AtomicFile, Error, Limits, Written};

/// The format's name in messages.
const FORMAT: &str = "EXR";

/// One channel to be written.
#[derive(Debug, Clone, Copy)]
pub struct ExrChannel<'a> {
    /// The full name, such as `ViewLayer.Combined.R`: layers, dots, and the component last.
    pub name: &'a str,
    /// The samples, `(rows, columns)`, top row first; any strides.
    pub plane: ArrayView2<'a, f32>,
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

/// Writes an EXR of 32-bit floats, ZIP-compressed.
///
/// The compressed file is in memory once, because a table at its front holds where its blocks begin.
///
/// # Errors
///
/// [`Error::BadInput`] if there is no channel or no pixel, if planes differ in size, or if names repeat, are empty, longer
/// than 255 bytes or contain a NUL; [`Error::Io`] if the file cannot be written. No file of that name appears then.
///
/// # Examples
///
/// ```
/// use holo_io::ExrChannel;
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join(holo_io::dataset::CENTRAL_EXR);
/// let depth_m = ndarray::array![[1.5, f32::INFINITY], [2.5, 3.5]];
/// holo_io::write_exr(&path, &[ExrChannel { name: "ViewLayer.Depth.Z", plane: depth_m.view() }])?;
/// let image = holo_io::read_exr(&path, &holo_io::Limits::default())?;
/// assert_eq!(image.channel("ViewLayer.Depth.Z"), Some(&depth_m));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_exr(path: impl AsRef<Path>, channels: &[ExrChannel<'_>]) -> Result<Written, Error> {
    use std::io::Write;

    let path = path.as_ref();
    let sorted = write::check(channels, path)?;
    // First, so that a folder that cannot be written to is found out before the work.
    let mut file = AtomicFile::create(path)?;
    let bytes = write::encode(&sorted, path)?;
    match file.write_all(&bytes) {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}

/// Returns the bytes that [`write_exr`] would write.
///
/// # Errors
///
/// [`Error::BadInput`] as there.
pub fn encode_exr(channels: &[ExrChannel<'_>]) -> Result<Vec<u8>, Error> {
    let path = Path::new(MEMORY);
    write::encode(&write::check(channels, path)?, path)
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
