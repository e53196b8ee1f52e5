//! The header of a DNG: directories of a TIFF, without pixels.
//!
//! Own code, because the crate `tiff` opens no image behind a color filter. A file is read at a few places of a few
//! kilobytes, whatever it announces.
//!
//! # Source
//!
//! Adobe, *TIFF, Revision 6.0* (1992) and *Digital Negative Specification 1.4* (2012).

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use holo_core::GridSize;

use crate::Error;

/// The name of the format in messages.
const FORMAT: &str = "DNG";

/// Entries of a directory that are read; their tags ascend, and DNGs have some hundred.
const MAX_ENTRIES: usize = 4096;

/// The largest number of values of an entry that is read, and so of directories inside the first.
const MAX_VALUES: usize = 16;

/// Bytes of an entry.
const ENTRY_BYTES: usize = 12;

const IMAGE_WIDTH: u16 = 256;
const IMAGE_LENGTH: u16 = 257;
const BITS_PER_SAMPLE: u16 = 258;
const PHOTOMETRIC: u16 = 262;
const SUB_DIRECTORIES: u16 = 330;
const FILTER_SIZE: u16 = 33_421;
const FILTER: u16 = 33_422;
const DNG_VERSION: u16 = 50_706;
const WHITE_LEVEL: u16 = 50_717;

/// The photometric interpretation of codes behind a color filter array.
const COLOR_FILTER_ARRAY: u32 = 32_803;

/// The colors of a filter by their numbers.
const COLORS: [char; 7] = ['R', 'G', 'B', 'C', 'M', 'Y', 'W'];

/// The header of a DNG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DngInfo {
    /// Rows and columns.
    pub size: GridSize,
    /// Bits of a stored code.
    pub bits: u32,
    /// The code of a saturated pixel, if the file states it.
    pub white: Option<u32>,
    /// The colors of 2 x 2 pixels row by row, such as `"GRBG"`; `None` without a filter or with one of another size.
    pub filter: Option<String>,
}

/// Reads the header of a DNG: that of the codes behind a color filter, also beside a preview.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is no DNG, is truncated, or states no size.
pub fn read_dng_info(path: impl AsRef<Path>) -> Result<DngInfo, Error> {
    let path = path.as_ref();
    let failed = |error: io::Error| match error.kind() {
        ErrorKind::UnexpectedEof => {
            Error::broken(path, FORMAT, "the file ends early; it was truncated while it was written or copied")
        }
        ErrorKind::InvalidData => Error::broken(path, FORMAT, error.to_string()),
        _ => Error::io("read", path, error),
    };
    File::open(path).and_then(|file| info(BufReader::new(file))).map_err(failed)
}

/// Whether a file that begins as a TIFF is a DNG. One that cannot be read is none.
pub(crate) fn is_dng(source: &mut (impl Read + Seek)) -> bool {
    let found = Tiff::open(source).and_then(|(mut tiff, offset)| tiff.directory(offset));
    found.is_ok_and(|directory| has_version(&directory))
}

fn has_version(directory: &[Entry]) -> bool {
    directory.iter().any(|entry| entry.tag == DNG_VERSION)
}

fn info(source: impl Read + Seek) -> io::Result<DngInfo> {
    let (mut tiff, offset) = Tiff::open(source)?;
    let mut directory = tiff.directory(offset)?;
    if !has_version(&directory) {
        return Err(invalid("it has no version of DNG"));
    }
    // The first directory may be that of a preview.
    if tiff.number_of(&directory, PHOTOMETRIC)? != Some(COLOR_FILTER_ARRAY) {
        for offset in tiff.numbers_of(&directory, SUB_DIRECTORIES)? {
            let inner = tiff.directory(offset)?;
            if tiff.number_of(&inner, PHOTOMETRIC)? == Some(COLOR_FILTER_ARRAY) {
                directory = inner;
                break;
            }
        }
    }
    let mut count = |tag| -> io::Result<usize> {
        let count = tiff.number_of(&directory, tag)?.filter(|&count| count > 0);
        count.map(|count| count as usize).ok_or_else(|| invalid("it states no size of its image"))
    };
    let size = GridSize::new(count(IMAGE_LENGTH)?, count(IMAGE_WIDTH)?);
    let is_two_by_two = tiff.numbers_of(&directory, FILTER_SIZE)? == [2, 2];
    let colors = tiff.numbers_of(&directory, FILTER)?;
    let filter = colors.iter().map(|&color| COLORS.get(color as usize).copied()).collect::<Option<String>>();
    Ok(DngInfo {
        size,
        // The default of TIFF.
        bits: tiff.number_of(&directory, BITS_PER_SAMPLE)?.unwrap_or(1),
        white: tiff.number_of(&directory, WHITE_LEVEL)?,
        filter: filter.filter(|_| is_two_by_two && colors.len() == 4),
    })
}

fn invalid(what: &'static str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, what)
}

/// A TIFF of 32-bit offsets.
struct Tiff<R> {
    source: R,
    is_big_endian: bool,
}

/// An entry of a directory: its values, or their place, in four bytes.
struct Entry {
    tag: u16,
    kind: u16,
    count: u32,
    value: [u8; 4],
}

impl<R: Read + Seek> Tiff<R> {
    /// Reads the first bytes: also the offset of the first directory.
    fn open(mut source: R) -> io::Result<(Self, u32)> {
        let mut header = [0; 8];
        source.rewind()?;
        source.read_exact(&mut header)?;
        let is_big_endian = match header {
            [b'I', b'I', 42, 0, ..] => false,
            [b'M', b'M', 0, 42, ..] => true,
            _ => return Err(invalid("it is no TIFF of 32-bit offsets")),
        };
        let tiff = Self { source, is_big_endian };
        let first = tiff.number(&header[4..]);
        Ok((tiff, first))
    }

    /// The number in at most four bytes.
    fn number(&self, bytes: &[u8]) -> u32 {
        let push = |number: u32, byte: &u8| (number << 8) | u32::from(*byte);
        if self.is_big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) }
    }

    /// Fills the bytes from a place of the file on.
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> io::Result<()> {
        self.source.seek(SeekFrom::Start(offset.into()))?;
        self.source.read_exact(bytes)
    }

    fn directory(&mut self, offset: u32) -> io::Result<Vec<Entry>> {
        let mut count = [0; 2];
        self.read(offset, &mut count)?;
        let count = (self.number(&count) as usize).min(MAX_ENTRIES);
        let mut bytes = vec![0; count * ENTRY_BYTES];
        self.source.read_exact(&mut bytes)?;
        let entry = |bytes: &[u8]| Entry {
            tag: self.number(&bytes[..2]) as u16,
            kind: self.number(&bytes[2..4]) as u16,
            count: self.number(&bytes[4..8]),
            value: [bytes[8], bytes[9], bytes[10], bytes[11]],
        };
        Ok(bytes.chunks_exact(ENTRY_BYTES).map(entry).collect())
    }

    /// The unsigned integers of a tag; none if it is missing, has other values or too many.
    fn numbers_of(&mut self, directory: &[Entry], tag: u16) -> io::Result<Vec<u32>> {
        let Some(entry) = directory.iter().find(|entry| entry.tag == tag) else { return Ok(Vec::new()) };
        let bytes_each = match entry.kind {
            1 => 1,
            3 => 2,
            4 | 13 => 4,
            _ => return Ok(Vec::new()),
        };
        let length = match usize::try_from(entry.count) {
            Ok(count) if count <= MAX_VALUES => count * bytes_each,
            _ => return Ok(Vec::new()),
        };
        let mut values = vec![0; length];
        match entry.value.get(..length) {
            Some(value) => values.copy_from_slice(value),
            None => self.read(self.number(&entry.value), &mut values)?,
        }
        Ok(values.chunks_exact(bytes_each).map(|value| self.number(value)).collect())
    }

    /// The first of them.
    fn number_of(&mut self, directory: &[Entry], tag: u16) -> io::Result<Option<u32>> {
        Ok(self.numbers_of(directory, tag)?.first().copied())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// A DNG without pixels.
    fn dng(is_big_endian: bool) -> Vec<u8> {
        let short = |n: u16| if is_big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let long = |n: u32| if is_big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let pair = |a: u16, b: u16| {
            let (a, b) = (short(a), short(b));
            [a[0], a[1], b[0], b[1]]
        };
        let entries = [
            (IMAGE_WIDTH, 4, 1, long(7)),
            (IMAGE_LENGTH, 3, 1, pair(5, 0)),
            (BITS_PER_SAMPLE, 3, 1, pair(16, 0)),
            (PHOTOMETRIC, 3, 1, pair(32_803, 0)),
            (FILTER_SIZE, 3, 2, pair(2, 2)),
            (FILTER, 1, 4, [1, 0, 2, 1]),
            (DNG_VERSION, 1, 4, [1, 4, 0, 0]),
            (WHITE_LEVEL, 4, 1, long(1023)),
        ];
        let mut bytes = if is_big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        bytes.extend(long(8));
        bytes.extend(short(entries.len() as u16));
        for (tag, kind, count, value) in entries {
            bytes.extend([short(tag), short(kind)].concat());
            bytes.extend(long(count));
            bytes.extend(value);
        }
        bytes.extend(long(0));
        bytes
    }

    fn expected() -> DngInfo {
        DngInfo { size: GridSize::new(5, 7), bits: 16, white: Some(1023), filter: Some("GRBG".into()) }
    }

    #[test]
    fn either_byte_order_is_read() {
        for is_big_endian in [false, true] {
            let bytes = dng(is_big_endian);
            assert_eq!(info(Cursor::new(&bytes)).unwrap(), expected());
            assert!(is_dng(&mut Cursor::new(&bytes)));
        }
    }

    /// Colors of another pattern than 2 x 2 are not named.
    #[test]
    fn other_filters_are_not_named() {
        let bytes = dng(false);
        let without = Ok(DngInfo { filter: None, ..expected() });
        for (place, count, changed) in [(FILTER_SIZE, 2_u32, [4, 0, 2, 0]), (FILTER, 3, [1, 0, 2, 0])] {
            let mut other = bytes.clone();
            let at = bytes.windows(2).position(|pair| pair == place.to_le_bytes()).unwrap();
            other[at + 4..at + 8].copy_from_slice(&count.to_le_bytes());
            other[at + 8..at + 12].copy_from_slice(&changed);
            assert_eq!(info(Cursor::new(other)).map_err(|why| why.to_string()), without, "{place}");
        }
    }

    #[test]
    fn the_codes_are_found_behind_a_preview() {
        let mut bytes = dng(false);
        // The directory of the codes becomes an inner one of a new first one.
        let entries =
            [(PHOTOMETRIC, 3_u16, 1_u32, 2_u32), (SUB_DIRECTORIES, 4, 1, 8), (DNG_VERSION, 1, 4, 0x0000_0401)];
        let first = (bytes.len() as u32).to_le_bytes();
        bytes[4..8].copy_from_slice(&first);
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in entries {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            bytes.extend(count.to_le_bytes());
            bytes.extend(value.to_le_bytes());
        }
        assert_eq!(info(Cursor::new(bytes)).unwrap(), expected());
    }

    #[test]
    fn a_written_dng_has_its_header() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("raw.dng");
        let sensor = holo_core::sensor::SensorPreset::by_name("lytro-illum").unwrap().model;
        crate::write_dng(&path, ndarray::Array2::zeros((5, 7)).view(), &sensor, "lytro-illum").unwrap();
        assert_eq!(read_dng_info(&path).unwrap(), expected());
        assert_eq!(crate::detect_format(&path).unwrap(), crate::FileFormat::Dng);
        let image = ndarray::Array3::<u8>::zeros((2, 3, 1));
        crate::write_tiff(&path, image.view()).unwrap();
        assert_eq!(crate::detect_format(&path).unwrap(), crate::FileFormat::Tiff);
        assert!(matches!(read_dng_info(&path), Err(Error::Broken { .. })));
    }

    /// Truncated anywhere and with any byte changed: an error or other numbers, no panic and no large allocation.
    #[test]
    fn damaged_headers_are_no_panic() {
        for is_big_endian in [false, true] {
            let whole = dng(is_big_endian);
            for keep in 0..whole.len() - 4 {
                assert!(info(Cursor::new(&whole[..keep])).is_err(), "{keep}");
                assert!(!is_dng(&mut Cursor::new(&whole[..keep])), "{keep}");
            }
            for (at, change) in (0..whole.len()).flat_map(|at| [1_u8, 0x80, 0xff].map(|change| (at, change))) {
                let mut bytes = whole.clone();
                bytes[at] ^= change;
                drop(info(Cursor::new(&bytes)));
                is_dng(&mut Cursor::new(&bytes));
            }
        }
    }
}
