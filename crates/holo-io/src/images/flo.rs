//! Middlebury `.flo`: optical flow.
//!
//! Little-endian: the float 202021.25, width and height as 32-bit integers, then for every pixel, the top row first, the
//! movement to the right and downward in pixels. Values above 1e9 mean that the flow is unknown; this module reads and
//! writes them as NaN and 1e10.
//!
//! # Source
//!
//! Baker et al., "A Database and Evaluation Methodology for Optical Flow", IJCV 2011, and the code of its web page.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::Path;

use ndarray::{Array3, ArrayView3};

use crate::files::folder::Destination;
use crate::{AtomicFile, Error, FileDigest, Limits};

/// The first four bytes, as a float.
const TAG: f32 = 202_021.25;

/// What is larger is unknown.
const UNKNOWN_ABOVE: f32 = 1e9;

/// What is written for unknown flow.
const UNKNOWN: f32 = 1e10;

/// Bytes before the first pixel.
const HEADER_BYTES: usize = 12;

/// Writes optical flow as `.flo`. NaN becomes 1e10, "unknown".
///
/// # Shape
///
/// `flow` is `(rows, columns, 2)`, top row first: px to the right and downward; any strides.
///
/// # Errors
///
/// [`Error::BadInput`] if the image is empty, does not have two channels or has more rows or columns than 2^31 - 1;
/// [`Error::Io`] if the file cannot be written. No file of that name appears then.
///
/// # Examples
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("flow.flo");
/// let flow = ndarray::array![[[0.5_f32, -1.0], [2.0, 3.0], [0.0, 0.25]]];
/// holo_io::write_flo(&path, flow.view())?;
/// assert_eq!(std::fs::read(&path)?[..4], *b"PIEH");
/// assert_eq!(holo_io::read_flo(&path, &holo_io::Limits::default())?, flow);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_flo(path: impl Destination, flow: ArrayView3<'_, f32>) -> Result<FileDigest, Error> {
    let (rows, columns, channels) = flow.dim();
    let sizes = (i32::try_from(rows), i32::try_from(columns));
    let (Ok(height), Ok(width), 2, false) = (sizes.0, sizes.1, channels, flow.is_empty()) else {
        return Err(Error::bad_input(path.path(), format!("an image of shape {:?} cannot be a .flo", flow.shape())));
    };
    let mut file = AtomicFile::create(path)?;
    let mut encode = || -> std::io::Result<()> {
        file.write_all(&TAG.to_le_bytes())?;
        file.write_all(&width.to_le_bytes())?;
        file.write_all(&height.to_le_bytes())?;
        for row in flow.outer_iter() {
            let known = row.iter().map(|&px| if px.is_nan() { UNKNOWN } else { px });
            file.write_all(&known.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())?;
        }
        Ok(())
    };
    match encode() {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}

/// Reads optical flow from a `.flo`, `(rows, columns, 2)`, px to the right and downward. Unknown flow is NaN.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is no `.flo`, or is shorter or longer than its header
/// announces; [`Error::TooLarge`] if its values exceed the limits, before memory is allocated.
pub fn read_flo(path: impl AsRef<Path>, limits: &Limits) -> Result<Array3<f32>, Error> {
    let path = path.as_ref();
    let failed = |source| Error::io("read", path, source);
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    // The length of a pipe is known at its end only.
    let length = metadata.is_file().then_some(metadata.len());
    decode(BufReader::new(file), length, path, *limits)
}

/// Decodes a `.flo` from a stream, as [`read_flo`].
///
/// # Errors
///
/// Those of [`read_flo`].
pub fn decode_flo(source: impl Read, limits: &Limits) -> Result<Array3<f32>, Error> {
    decode(source, None, Path::new(crate::error::STREAM), *limits)
}

fn decode(mut source: impl Read, length: Option<u64>, path: &Path, limits: Limits) -> Result<Array3<f32>, Error> {
    let broken = |what: String| Error::broken(path, "flo", what);
    let mut header = [0; HEADER_BYTES];
    source.read_exact(&mut header).map_err(|source| end_or_io(source, path))?;
    let word = |k: usize| [header[k], header[k + 1], header[k + 2], header[k + 3]];
    if f32::from_le_bytes(word(0)) != TAG {
        return Err(broken("it does not begin with PIEH".into()));
    }
    let [width, height] = [4, 8].map(|k| i32::from_le_bytes(word(k)));
    let (Ok(columns), Ok(rows)) = (usize::try_from(width), usize::try_from(height)) else {
        return Err(broken(format!("its size is {width} x {height}")));
    };
    if rows == 0 || columns == 0 {
        return Err(broken(format!("its size is {width} x {height}")));
    }
    let count = limits.elements(path, "image", &[rows, columns, 2], size_of::<f32>())?;
    let expected = HEADER_BYTES as u64 + count as u64 * size_of::<f32>() as u64;
    if let Some(length) = length.filter(|&length| length != expected) {
        return Err(broken(format!("it has {length} bytes; {width} x {height} pixels need {expected}")));
    }
    let mut values = Limits::room(path, "image", count)?;
    let mut row = vec![0; columns * 8];
    for _ in 0..rows {
        source.read_exact(&mut row).map_err(|source| end_or_io(source, path))?;
        let numbers = row.chunks_exact(4).map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        values.extend(numbers.map(|px| if px.abs() > UNKNOWN_ABOVE || px.is_nan() { f32::NAN } else { px }));
    }
    let mut more = [0];
    if source.read(&mut more).map_err(|source| Error::io("read", path, source))? > 0 {
        return Err(broken("it is longer than its header announces".into()));
    }
    Array3::from_shape_vec((rows, columns, 2), values).map_err(|error| broken(error.to_string()))
}

fn end_or_io(source: std::io::Error, path: &Path) -> Error {
    match source.kind() {
        std::io::ErrorKind::UnexpectedEof => Error::broken(path, "flo", "it is shorter than its header announces"),
        _ => Error::io("read", path, source),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(width: i32, height: i32, values: &[f32]) -> Vec<u8> {
        let head = [TAG.to_le_bytes(), width.to_le_bytes(), height.to_le_bytes()];
        head.into_iter().chain(values.iter().map(|x| x.to_le_bytes())).flatten().collect()
    }

    fn error(bytes: &[u8]) -> String {
        decode_flo(bytes, &Limits::default()).expect_err("broken").to_string()
    }

    #[test]
    fn unknown_flow_is_nan() {
        let read = decode_flo(&file(1, 2, &[1.5, -2.0, 1e10, f32::NAN])[..], &Limits::default()).expect("flow");
        assert_eq!((read[[0, 0, 0]], read[[0, 0, 1]]), (1.5, -2.0));
        assert!(read[[1, 0, 0]].is_nan() && read[[1, 0, 1]].is_nan());
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.flo");
        write_flo(&path, read.view()).expect("written");
        assert_eq!(std::fs::read(&path).expect("bytes"), file(1, 2, &[1.5, -2.0, 1e10, 1e10]));
        assert!(read_flo(&path, &Limits::default()).expect("flow")[[1, 0, 0]].is_nan());
    }

    #[test]
    fn broken_files_are_errors() {
        assert!(error(&[]).contains("shorter"));
        assert!(error(&[0; 20]).contains("PIEH"));
        for (width, height) in [(0, 1), (1, 0), (-1, 5)] {
            assert!(error(&file(width, height, &[])).contains("size"), "{width} {height}");
        }
        assert!(error(&file(1, 1, &[0.0])).contains("shorter"));
        assert!(error(&file(1, 1, &[0.0; 3])).contains("longer"));
        // Refused by its length, before memory is allocated.
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.flo");
        std::fs::write(&path, file(20_000, 20_000, &[0.0; 2])).expect("written");
        let message = read_flo(&path, &Limits::default()).expect_err("too short").to_string();
        assert!(message.contains("20 bytes") && message.contains("3200000012"), "{message}");
        let small = Limits { max_bytes: 15 };
        assert!(decode_flo(&file(1, 2, &[0.0; 4])[..], &small).is_err());
    }

    #[test]
    fn other_shapes_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        for shape in [(1, 1, 3), (0, 1, 2)] {
            assert!(write_flo(folder.path().join("a.flo"), ndarray::Array3::zeros(shape).view()).is_err());
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }
}
