//! PFM: float images, gray or RGB.
//!
//! Own code, because no crate reads odd heights correctly. The writer writes what the HCI tools write: `Pf\nW H\n-1\n`,
//! little-endian 32-bit floats, the bottom row first.

mod header;

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;

use holo_core::GridSize;
use ndarray::{Array2, Array3, ArrayView2, ArrayView3, Axis};

use crate::error::STREAM;
use crate::files::folder::{Destination, Folder};
use crate::files::stream::read_to_end;
use crate::{AtomicFile, Error, FileDigest, Limits};
use header::Header;

/// Bytes that are read or written at a time; a multiple of four.
const BLOCK_BYTES: usize = 1 << 16;

/// The contents of a PFM file.
#[derive(Debug, Clone, PartialEq)]
pub struct Pfm {
    /// The values, `(rows, columns, channels)` with 1 or 3 channels, top row first, as in the file: not multiplied by
    /// the scale.
    pub values: Array3<f32>,
    /// The magnitude of the scale in the header, usually 1. The format does not define its unit.
    pub scale: f64,
}

impl Pfm {
    /// Encodes a PFM file into a stream, little-endian.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if there are no pixels, if there are neither 1 nor 3 channels, or if the scale is not finite
    /// and above 0; [`Error::Io`] if `out` cannot be written.
    pub fn encode(&self, mut out: impl Write) -> Result<(), Error> {
        let path = Path::new(STREAM);
        if !(self.scale.is_finite() && self.scale > 0.0) {
            return Err(Error::bad_input(
                path,
                format!("the scale of a PFM is finite and above 0, not {}", self.scale),
            ));
        }
        check(self.values.view(), path)?;
        encode(&mut out, self.values.view(), self.scale)
            .and_then(|()| out.flush())
            .map_err(|error| Error::io("write", path, error))
    }
}

/// The header of a PFM file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PfmInfo {
    /// Rows and columns.
    pub size: GridSize,
    /// 1 for gray (`Pf`), 3 for RGB (`PF`).
    pub channels: usize,
    /// The magnitude of the scale.
    pub scale: f64,
    /// Whether the file is little-endian (its scale is negative).
    pub little_endian: bool,
}

/// Writes a float image of one channel as PFM, such as depth or disparity.
///
/// # Shape
///
/// `image` is `(rows, columns)`, top row first; any strides.
///
/// # Errors
///
/// [`Error::BadInput`] if the image is empty; [`Error::Io`] if the file cannot be written. No file of that name appears
/// then.
///
/// # Examples
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("depth.pfm");
/// let depth_m = ndarray::array![[1.5, f32::INFINITY], [2.5, 3.5], [4.5, 5.5]];
/// holo_io::write_pfm(&path, depth_m.view())?;
/// assert!(std::fs::read(&path)?.starts_with(b"Pf\n2 3\n-1\n"));
/// assert_eq!(holo_io::read_pfm_gray(&path, &holo_io::Limits::default())?, depth_m);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_pfm(path: impl Destination, image: ArrayView2<'_, f32>) -> Result<FileDigest, Error> {
    write(&path, image.insert_axis(Axis(2)))
}

/// Writes an RGB float image as PFM.
///
/// # Shape
///
/// `image` is `(rows, columns, 3)`, top row first; any strides.
///
/// # Errors
///
/// [`Error::BadInput`] if the image is empty or does not have three channels; [`Error::Io`] if the file cannot be
/// written. No file of that name appears then.
pub fn write_pfm_rgb(path: impl Destination, image: ArrayView3<'_, f32>) -> Result<FileDigest, Error> {
    if image.dim().2 != 3 {
        return Err(Error::bad_input(path.path(), format!("an RGB PFM has 3 channels, not {}", image.dim().2)));
    }
    write(&path, image)
}

fn write(path: &dyn Destination, image: ArrayView3<'_, f32>) -> Result<FileDigest, Error> {
    check(image, path.path())?;
    let mut file = AtomicFile::create(path)?;
    match encode(&mut file, image, 1.0) {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}

fn check(image: ArrayView3<'_, f32>, path: &Path) -> Result<(), Error> {
    if image.is_empty() || ![1, 3].contains(&image.dim().2) {
        return Err(Error::bad_input(path, format!("an image of shape {:?} cannot be a PFM", image.shape())));
    }
    Ok(())
}

fn encode(out: &mut impl Write, image: ArrayView3<'_, f32>, scale: f64) -> std::io::Result<()> {
    let (rows, columns, channels) = image.dim();
    let magic = if channels == 1 { "Pf" } else { "PF" };
    // A negative scale means little-endian; 1.0 prints as 1.
    write!(out, "{magic}\n{columns} {rows}\n-{scale}\n")?;
    let mut block = Vec::with_capacity(BLOCK_BYTES);
    for row in image.outer_iter().rev() {
        for value in row.iter() {
            block.extend(value.to_le_bytes());
            if block.len() == BLOCK_BYTES {
                out.write_all(&block)?;
                block.clear();
            }
        }
    }
    out.write_all(&block)
}

/// Reads a PFM, gray or RGB, of either byte order.
///
/// `#` comments and any white space in the header are accepted. The data must have exactly the length that the header
/// announces.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not a PFM, or is shorter or longer than its
/// header announces; [`Error::TooLarge`] if its values exceed the limits. All are checked before memory is allocated.
pub fn read_pfm(path: impl AsRef<Path>, limits: &Limits) -> Result<Pfm, Error> {
    let path = path.as_ref();
    let failed = |source| Error::io("read", path, source);
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    if metadata.is_file() {
        return decode(&mut BufReader::with_capacity(BLOCK_BYTES, file), metadata.len(), path, *limits);
    }
    // The length of a pipe, which the check needs, is known at its end only.
    let mut bytes = Vec::new();
    file.take(limits.max_bytes.saturating_add(header::MAX_BYTES)).read_to_end(&mut bytes).map_err(failed)?;
    decode(&mut bytes.as_slice(), bytes.len() as u64, path, *limits)
}

/// Reads a PFM of an open folder, like [`read_pfm`].
///
/// # Errors
///
/// Those of [`read_pfm`] and [`Folder::open_regular`].
pub fn read_pfm_in(folder: &Folder, name: &str, limits: &Limits) -> Result<Pfm, Error> {
    let path = folder.path_of(name);
    let file = folder.open_regular(name, limits.max_bytes.saturating_add(header::MAX_BYTES))?;
    let length = file.metadata().map_err(|source| Error::io("read", &path, source))?.len();
    decode(&mut BufReader::with_capacity(BLOCK_BYTES, file), length, &path, *limits)
}

/// Reads a PFM of one channel, such as depth or disparity, as `(rows, columns)`, top row first.
///
/// # Errors
///
/// Those of [`read_pfm`], and [`Error::Unsupported`] if the file is RGB.
pub fn read_pfm_gray(path: impl AsRef<Path>, limits: &Limits) -> Result<Array2<f32>, Error> {
    let path = path.as_ref();
    let pfm = read_pfm(path, limits)?;
    if pfm.values.dim().2 != 1 {
        return Err(Error::unsupported(path, "this PFM is RGB (PF); one of a single channel (Pf) is needed"));
    }
    Ok(pfm.values.remove_axis(Axis(2)))
}

/// Decodes a PFM from a stream, like [`read_pfm`]. The encoded bytes are read into memory first: the check of their
/// length precedes the result.
///
/// # Errors
///
/// Those of [`read_pfm`].
pub fn decode_pfm(source: impl Read, limits: &Limits) -> Result<Pfm, Error> {
    let bytes = read_to_end(source, *limits)?;
    decode(&mut bytes.as_slice(), bytes.len() as u64, Path::new(STREAM), *limits)
}

/// Reads the header of a PFM without its values.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if its header is not that of a PFM.
pub fn read_pfm_info(path: impl AsRef<Path>) -> Result<PfmInfo, Error> {
    let path = path.as_ref();
    let file = File::open(path).map_err(|source| Error::io("read", path, source))?;
    Ok(Header::read(&mut BufReader::new(file), path)?.info)
}

fn decode(source: &mut impl BufRead, length: u64, path: &Path, limits: Limits) -> Result<Pfm, Error> {
    let header = Header::read(source, path)?;
    let PfmInfo { size, channels, scale, little_endian } = header.info;
    header.check_length(source, length, path)?;
    let count = limits.elements(path, "image", &[size.rows, size.columns, channels], size_of::<f32>())?;
    let mut values = Limits::room(path, "image", count)?;
    values.resize(count, 0.0_f32);
    let from_bytes = if little_endian { f32::from_le_bytes } else { f32::from_be_bytes };
    let mut block = vec![0; BLOCK_BYTES];
    for row in values.chunks_exact_mut(size.columns * channels).rev() {
        for part in row.chunks_mut(BLOCK_BYTES / 4) {
            let bytes = &mut block[..part.len() * 4];
            source.read_exact(bytes).map_err(|source| header::read_error(source, path))?;
            for (value, bytes) in part.iter_mut().zip(bytes.chunks_exact(4)) {
                *value = from_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            }
        }
    }
    let values = Array3::from_shape_vec((size.rows, size.columns, channels), values)
        .map_err(|error| Error::broken(path, "PFM", error.to_string()))?;
    Ok(Pfm { values, scale })
}
