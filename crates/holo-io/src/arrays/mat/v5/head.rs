//! The header of a variable, parsed and checked before its numbers are read.

use std::io::{self, Read};
use std::path::Path;

use super::{Storage, TYPE_MATRIX, class_of_code, padding};
use crate::Error;
use crate::arrays::mat::{FORMAT_V5, MatClass};

/// Maximum number of dimensions that is read; the format itself has no limit.
const MAX_DIMENSIONS: usize = 32;

/// Maximum length of a name that is read; names of MATLAB have at most 63 characters.
const MAX_NAME_BYTES: u32 = 255;

/// The byte order of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::arrays::mat) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    pub(super) fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            Self::Little => u32::from_le_bytes(bytes),
            Self::Big => u32::from_be_bytes(bytes),
        }
    }

    pub(super) fn bytes(self, number: u32) -> [u8; 4] {
        match self {
            Self::Little => number.to_le_bytes(),
            Self::Big => number.to_be_bytes(),
        }
    }
}

/// The header of a variable.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::arrays::mat) struct Head {
    pub(in crate::arrays::mat) name: String,
    pub(in crate::arrays::mat) class: MatClass,
    pub(in crate::arrays::mat) complex: bool,
    /// At least two dimensions; empty for objects without a size.
    pub(in crate::arrays::mat) size: Vec<usize>,
    /// Storage type of the numbers and their size in bytes; `None` for classes that are only listed.
    pub(super) data: Option<(Storage, u64)>,
}

/// A reader of one matrix element, which counts its bytes.
pub(super) struct Matrix<'a> {
    source: &'a mut dyn Read,
    order: ByteOrder,
    /// Number of bytes of the element that are left.
    left: u64,
    path: &'a Path,
    /// Offset of the element, for messages.
    start: u64,
}

impl<'a> Matrix<'a> {
    /// Reads the tag of a matrix element; with `length`, the caller has read it.
    pub(super) fn new(
        source: &'a mut dyn Read,
        order: ByteOrder,
        path: &'a Path,
        start: u64,
        length: Option<u64>,
    ) -> Result<Self, Error> {
        let mut matrix = Self { source, order, left: length.unwrap_or(8), path, start };
        if length.is_none() {
            let (code, length) = (matrix.u32()?, matrix.u32()?);
            if code != TYPE_MATRIX {
                return Err(matrix.broken(format!("compressed data of type {code} instead of an array")));
            }
            matrix.left = u64::from(length);
        }
        Ok(matrix)
    }

    pub(super) fn broken(&self, what: impl AsRef<str>) -> Error {
        Error::broken(self.path, FORMAT_V5, format!("variable at byte {}: {}", self.start, what.as_ref()))
    }

    /// Converts an error of reading: early ends and invalid data mean a broken file.
    fn read_error(&self, error: io::Error) -> Error {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => {
                self.broken("it ends early; the file was truncated while it was written or copied")
            }
            io::ErrorKind::InvalidData => self.broken(format!("damaged compressed data: {error}")),
            _ => Error::io("read", self.path, error),
        }
    }

    /// Reads bytes that must belong to the element.
    pub(super) fn exact(&mut self, bytes: &mut [u8]) -> Result<(), Error> {
        let length = bytes.len() as u64;
        if length > self.left {
            return Err(self.broken("its parts are longer than itself"));
        }
        self.source.read_exact(bytes).map_err(|error| self.read_error(error))?;
        self.left -= length;
        Ok(())
    }

    fn u32(&mut self) -> Result<u32, Error> {
        let mut bytes = [0; 4];
        self.exact(&mut bytes)?;
        Ok(self.order.u32(bytes))
    }

    /// Reads a tag: type, length, and number of padding bytes after the data.
    fn tag(&mut self) -> Result<(u32, u32, u64), Error> {
        let first = self.u32()?;
        if first >> 16 == 0 {
            let length = self.u32()?;
            return Ok((first, length, padding(u64::from(length))));
        }
        let length = first >> 16;
        if length > 4 {
            return Err(self.broken(format!("a short element of {length} bytes; the maximum is four")));
        }
        Ok((first & 0xffff, length, u64::from(4 - length)))
    }

    /// Reads an element of at most `limit` bytes.
    fn small(&mut self, what: &str, storage: Storage, limit: u32) -> Result<Vec<u8>, Error> {
        let (code, length, padding) = self.tag()?;
        if code != storage.code() || length > limit {
            return Err(self.broken(format!("its {what} have type {code} and {length} bytes")));
        }
        let mut bytes = vec![0; length as usize + padding as usize];
        self.exact(&mut bytes)?;
        bytes.truncate(length as usize);
        Ok(bytes)
    }

    /// Reads the header, and checks that the numbers fill the rest of the element.
    pub(super) fn head(&mut self) -> Result<Head, Error> {
        let flags = self.small("flags", Storage::U32, 8)?;
        let [a, b, c, d, _, _, _, _] = flags[..] else {
            return Err(self.broken(format!("its flags have {} bytes", flags.len())));
        };
        let flags = self.order.u32([a, b, c, d]);
        let code = flags as u8;
        let Some(mut class) = class_of_code(code) else {
            return Err(Error::unsupported(
                self.path,
                format!("variable at byte {}: an array of class {code}, which MATLAB does not write", self.start),
            ));
        };
        let complex = flags & 0x800 != 0;
        // An object of the subsystem has its name here, and no size.
        let size = if code == 17 { Vec::new() } else { self.size()? };
        let name = self.small("name", Storage::I8, MAX_NAME_BYTES)?;
        let name = String::from_utf8(name).map_err(|_| self.broken("its name is not text"))?;
        if class == MatClass::U8 && flags & 0x200 != 0 {
            class = MatClass::Logical;
        }
        let data = match class {
            MatClass::Cell | MatClass::Struct | MatClass::Sparse | MatClass::Object => None,
            _ => Some(self.data(&name, class, complex, &size)?),
        };
        Ok(Head { name, class, complex, size, data })
    }

    fn size(&mut self) -> Result<Vec<usize>, Error> {
        let bytes = self.small("dimensions", Storage::I32, 4 * MAX_DIMENSIONS as u32)?;
        if bytes.len() < 8 || bytes.len() % 4 != 0 {
            return Err(self.broken(format!("its dimensions have {} bytes", bytes.len())));
        }
        let count = |bytes: &[u8; 4]| {
            let count = self.order.u32(*bytes) as i32;
            usize::try_from(count).map_err(|_| self.broken(format!("a dimension of {count}")))
        };
        bytes.as_chunks::<4>().0.iter().map(count).collect()
    }

    /// Reads the tag of the numbers and checks it against the dimensions and the length of the element.
    fn data(&mut self, name: &str, class: MatClass, complex: bool, size: &[usize]) -> Result<(Storage, u64), Error> {
        let elements = size.iter().try_fold(1_u64, |product, &count| product.checked_mul(count as u64));
        let Some(elements) = elements else {
            return Err(self.broken(format!("'{name}' has dimensions {size:?}, whose product overflows")));
        };
        let (code, length, padding) = self.tag()?;
        let length = u64::from(length);
        let Some(storage) = Storage::from_code(code) else {
            return Err(self.broken(format!("'{name}' has numbers of type {code}, which the format does not define")));
        };
        let is_text = class == MatClass::Text;
        if matches!(storage, Storage::Utf8 | Storage::Utf16 | Storage::Utf32) && !is_text {
            return Err(self.broken(format!("'{name}' has characters where its numbers should be")));
        }
        // Characters of UTF-8 and UTF-16 have a variable number of units; they are counted when they are read.
        let fits = match storage {
            Storage::Utf8 | Storage::Utf16 => length >= elements && length / 4 <= elements,
            _ => elements.checked_mul(storage.bytes() as u64) == Some(length),
        };
        if !fits {
            return Err(self.broken(format!(
                "'{name}' has {length} bytes of numbers, but dimensions {size:?} of {} bytes each",
                storage.bytes()
            )));
        }
        // Complex numbers are only listed. Some programs omit the padding at the end.
        if !complex && self.left != length && self.left != length + padding || self.left < length {
            return Err(self.broken(format!("{} bytes are left for the {length} of '{name}'", self.left)));
        }
        Ok((storage, length))
    }

    /// Reads to the end of the element, so that the checksum of a compressed one is verified.
    pub(super) fn finish(&mut self) -> Result<(), Error> {
        let mut padding = [0; 8];
        let left = (self.left as usize).min(8);
        self.exact(&mut padding[..left])?;
        match self.source.read(&mut padding[..1]) {
            Ok(0) => Ok(()),
            Ok(_) => Err(self.broken("its compressed data continue after its end")),
            Err(error) => Err(self.read_error(error)),
        }
    }

    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    pub(super) fn order(&self) -> ByteOrder {
        self.order
    }
}
