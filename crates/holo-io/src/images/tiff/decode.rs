//! Decodes a TIFF of integers or floats.

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek};
use std::path::Path;

use holo_core::{DynImage, GridSize, SampleKind};
use ndarray::Array3;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::{FORMAT, TiffInfo};
use crate::error::STREAM;
use crate::files::panic_guard::decoded;
use crate::files::stream::read_to_end;
use crate::{Error, Limits};

/// Memory of the decoder for the numbers of one tag and for one compressed strip or tile, in addition to the image.
const WORKING_BYTES: usize = 64 << 20;

/// Reads a TIFF: gray or RGB, with or without alpha, of 8- or 16-bit unsigned integers or 32- or 64-bit floats; in strips
/// or tiles; uncompressed, deflated, LZW or PackBits. Of several images in a file, the first.
///
/// # Shape
///
/// `(rows, columns, channels)` with 1 to 4 channels.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not a TIFF, is truncated or damaged;
/// [`Error::Unsupported`] if it has other samples, colors or an orientation, or its channels are apart;
/// [`Error::TooLarge`] if its samples exceed the limits, before memory is allocated for them.
pub fn read_tiff(path: impl AsRef<Path>, limits: &Limits) -> Result<DynImage, Error> {
    let path = path.as_ref();
    decode(open(path)?, path, *limits)
}

/// Decodes a TIFF from a stream, like [`read_tiff`]. The encoded bytes are read into memory first.
///
/// # Errors
///
/// Those of [`read_tiff`].
pub fn decode_tiff(source: impl Read, limits: &Limits) -> Result<DynImage, Error> {
    let bytes = read_to_end(source, *limits)?;
    decode(Cursor::new(bytes), Path::new(STREAM), *limits)
}

/// Reads the header of a TIFF without its pixels.
///
/// # Errors
///
/// Those of [`read_tiff`], but for the limits.
pub fn read_tiff_info(path: impl AsRef<Path>) -> Result<TiffInfo, Error> {
    let path = path.as_ref();
    decoded(path, FORMAT, || start(open(path)?, path, Limits::default()).map(|(_, info)| info))
}

fn open(path: &Path) -> Result<BufReader<File>, Error> {
    File::open(path).map(BufReader::new).map_err(|error| Error::io("read", path, error))
}

fn decode<R: Read + Seek>(source: R, path: &Path, limits: Limits) -> Result<DynImage, Error> {
    decoded(path, FORMAT, || {
        let (mut decoder, info) = start(source, path, limits)?;
        let shape = (info.size.rows, info.size.columns, info.channels);
        limits.elements(path, "image", &[shape.0, shape.1, shape.2], info.kind.bytes())?;
        let samples = decoder.read_image().map_err(|error| decode_error(error, path, limits))?;
        fn image<T>(shape: (usize, usize, usize), samples: Vec<T>) -> Option<DynImage>
        where
            DynImage: From<Array3<T>>,
        {
            Array3::from_shape_vec(shape, samples).ok().map(DynImage::from)
        }
        let image = match samples {
            DecodingResult::U8(samples) => image(shape, samples),
            DecodingResult::U16(samples) => image(shape, samples),
            DecodingResult::F32(samples) => image(shape, samples),
            DecodingResult::F64(samples) => image(shape, samples),
            _ => None,
        };
        image.filter(|image| image.kind() == info.kind).ok_or_else(|| {
            Error::broken(path, FORMAT, "the image data do not have the size or type that the header announces")
        })
    })
}

/// Reads up to the pixels.
fn start<R: Read + Seek>(source: R, path: &Path, limits: Limits) -> Result<(Decoder<R>, TiffInfo), Error> {
    let failed = |error| decode_error(error, path, limits);
    let unsupported = |what: String| Error::unsupported(path, what);
    let mut working = tiff::decoder::Limits::default();
    working.decoding_buffer_size = usize::try_from(limits.max_bytes).unwrap_or(usize::MAX);
    working.intermediate_buffer_size = working.decoding_buffer_size.saturating_add(WORKING_BYTES);
    working.ifd_value_size = WORKING_BYTES;
    let mut decoder = Decoder::new(source).map_err(failed)?.with_limits(working);
    let (columns, rows) = decoder.dimensions().map_err(failed)?;
    let color = decoder.colortype().map_err(failed)?;
    let (channels, bits) = match color {
        ColorType::Gray(bits) => (1, bits),
        ColorType::GrayA(bits) => (2, bits),
        ColorType::RGB(bits) => (3, bits),
        ColorType::RGBA(bits) => (4, bits),
        other => {
            return Err(unsupported(format!(
                "a TIFF of color {other:?}; gray and RGB, with or without alpha, can be read"
            )));
        }
    };
    let mut number = |tag| decoder.find_tag_unsigned::<u16>(tag).map_err(failed);
    let (orientation, planes) = (number(Tag::Orientation)?, number(Tag::PlanarConfiguration)?);
    if orientation.is_some_and(|orientation| orientation != 1) {
        return Err(unsupported("a TIFF that is stored turned or mirrored; save it upright".into()));
    }
    if planes == Some(2) && channels > 1 {
        return Err(unsupported(
            "a TIFF with its channels in separate planes; save it with interleaved channels".into(),
        ));
    }
    let formats = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(failed)?.unwrap_or_default();
    let is_float = formats.first() == Some(&3);
    let is_plain = formats.iter().all(|&format| Some(&format) == formats.first())
        && matches!(formats.first(), None | Some(1 | 3 | 4));
    let kind = match (is_plain, is_float, bits) {
        (true, false, 8) => SampleKind::U8,
        (true, false, 16) => SampleKind::U16,
        (true, true, 32) => SampleKind::F32,
        (true, true, 64) => SampleKind::F64,
        _ => {
            return Err(unsupported(format!(
                "a TIFF of {bits}-bit samples of format {formats:?}; unsigned integers of 8 and 16 bits and floats of 32 \
                 and 64 bits can be read"
            )));
        }
    };
    Ok((decoder, TiffInfo { size: GridSize::new(rows as usize, columns as usize), channels, kind }))
}

/// Converts an error of the decoder: to a broken file, an error of the operating system, or a limit.
fn decode_error(error: TiffError, path: &Path, limits: Limits) -> Error {
    match error {
        TiffError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            Error::broken(path, FORMAT, "the file ends early; it was truncated while it was written or copied")
        }
        // The decompressors report damaged data so.
        TiffError::IoError(error) if error.raw_os_error().is_none() => Error::broken(path, FORMAT, error.to_string()),
        TiffError::IoError(error) => Error::io("read", path, error),
        TiffError::LimitsExceeded => {
            Error::TooLarge { path: path.to_owned(), what: "image", needed: u64::MAX, allowed: limits.max_bytes }
        }
        TiffError::UnsupportedError(what) => Error::unsupported(path, what.to_string()),
        error => Error::broken(path, FORMAT, error.to_string()),
    }
}
