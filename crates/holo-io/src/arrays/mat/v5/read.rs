//! The reader: the list of the variables, and the value of one.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use ndarray::{ArrayD, IxDyn, ShapeBuilder};

use super::head::{ByteOrder, Head, Matrix};
use super::{HEADER_BYTES, Storage, TYPE_COMPRESSED, TYPE_MATRIX, VERSION, numbers};
use crate::arrays::mat::value::Element;
use crate::arrays::mat::{FORMAT_V5, MatArray, MatClass, unreadable};
use crate::files::zlib::Inflated;
use crate::{Error, Limits};

/// Maximum number of variables, because each takes some memory before it is read.
const MAX_VARIABLES: usize = 1 << 16;

/// Position and header of a variable.
#[derive(Debug, Clone)]
pub(in crate::arrays::mat) struct Entry {
    /// Offset of the element after its tag.
    start: u64,
    length: u64,
    compressed: bool,
    pub(in crate::arrays::mat) head: Head,
}

/// A file whose variables are listed.
pub(in crate::arrays::mat) struct Reader<'a, R> {
    source: R,
    order: ByteOrder,
    path: &'a Path,
    limits: Limits,
    pub(in crate::arrays::mat) entries: Vec<Entry>,
}

impl<'a, R: Read + Seek> Reader<'a, R> {
    /// Reads the header of the file and of every variable. `length` is that of the file.
    pub(in crate::arrays::mat) fn new(
        mut source: R,
        length: u64,
        path: &'a Path,
        limits: Limits,
    ) -> Result<Self, Error> {
        let order = header(&mut source, path)?;
        let mut reader = Self { source, order, path, limits, entries: Vec::new() };
        let mut at = HEADER_BYTES as u64;
        while at < length {
            let mut tag = [0; 8];
            reader.seek(at)?;
            if length - at < 8 {
                return Err(reader.broken(at, "the file ends in the middle of a tag; it was truncated"));
            }
            reader.source.read_exact(&mut tag).map_err(|error| Error::io("read", path, error))?;
            let [a, b, c, d, e, f, g, h] = tag;
            let (code, bytes) = (order.u32([a, b, c, d]), u64::from(order.u32([e, f, g, h])));
            let start = at + 8;
            if code != TYPE_MATRIX && code != TYPE_COMPRESSED {
                return Err(reader.broken(at, &format!("an element of type {code} instead of a variable")));
            }
            if bytes > length - start {
                let what =
                    format!("it has {bytes} bytes, but the file ends after {}; it was truncated", length - start);
                return Err(reader.broken(at, &what));
            }
            let compressed = code == TYPE_COMPRESSED;
            let head = reader.element(start, bytes, compressed, |matrix| matrix.head())?;
            // Variables without a name are internal to MATLAB.
            if !head.name.is_empty() {
                if reader.entries.len() == MAX_VARIABLES {
                    return Err(Error::unsupported(path, format!("more than {MAX_VARIABLES} variables")));
                }
                reader.entries.push(Entry { start, length: bytes, compressed, head });
            }
            at = start + bytes;
        }
        Ok(reader)
    }

    fn broken(&self, at: u64, what: &str) -> Error {
        Error::broken(self.path, FORMAT_V5, format!("byte {at}: {what}"))
    }

    fn seek(&mut self, at: u64) -> Result<(), Error> {
        self.source.seek(SeekFrom::Start(at)).map(|_| ()).map_err(|error| Error::io("read", self.path, error))
    }

    /// Passes the decompressed bytes of an element to `work`.
    fn element<T>(
        &mut self,
        start: u64,
        bytes: u64,
        compressed: bool,
        work: impl FnOnce(&mut Matrix<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        self.seek(start)?;
        let mut element = self.source.by_ref().take(bytes);
        if compressed {
            let mut inflated = Inflated::new(element);
            work(&mut Matrix::new(&mut inflated, self.order, self.path, start - 8, None)?)
        } else {
            work(&mut Matrix::new(&mut element, self.order, self.path, start - 8, Some(bytes))?)
        }
    }

    /// Reads a variable, and subtracts its size from the memory limit.
    pub(in crate::arrays::mat) fn value(&mut self, index: usize) -> Result<MatArray, Error> {
        let Entry { start, length, compressed, head } = self.entries[index].clone();
        let limits = self.limits;
        let value = self.element(start, length, compressed, |matrix| {
            // The header was read before.
            if matrix.head()? != head {
                return Err(matrix.broken("the file changed while it was read"));
            }
            value(matrix, &head, limits)
        })?;
        if let Some(bytes) = head.class.element_bytes() {
            let taken = head.size.iter().product::<usize>().saturating_mul(bytes) as u64;
            self.limits.max_bytes = self.limits.max_bytes.saturating_sub(taken);
        }
        Ok(value)
    }
}

/// Reads the header of the file and returns its byte order.
fn header(source: &mut impl Read, path: &Path) -> Result<ByteOrder, Error> {
    let mut header = [0; HEADER_BYTES];
    source.read_exact(&mut header).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => Error::broken(path, FORMAT_V5, "the file ends inside its header"),
        _ => Error::io("read", path, error),
    })?;
    let [.., a, b, c, d] = header;
    let (order, version) = match &[c, d] {
        b"IM" => (ByteOrder::Little, u16::from_le_bytes([a, b])),
        b"MI" => (ByteOrder::Big, u16::from_be_bytes([a, b])),
        _ => {
            return Err(Error::broken(
                path,
                FORMAT_V5,
                "the header does not end in IM or MI; it may be a file of MATLAB 4",
            ));
        }
    };
    if version != VERSION {
        return Err(Error::unsupported(path, format!("a MAT file of version {version:#06x}; 0x0100 can be read here")));
    }
    Ok(order)
}

fn value(matrix: &mut Matrix<'_>, head: &Head, limits: Limits) -> Result<MatArray, Error> {
    let Some((storage, bytes)) = head.data.filter(|_| !head.complex) else {
        return Err(unreadable(matrix.path(), &head.name, head.class, head.complex));
    };
    match head.class {
        MatClass::U8 | MatClass::Logical => array::<u8>(matrix, head, storage, bytes, limits),
        MatClass::I8 => array::<i8>(matrix, head, storage, bytes, limits),
        MatClass::U16 => array::<u16>(matrix, head, storage, bytes, limits),
        MatClass::I16 => array::<i16>(matrix, head, storage, bytes, limits),
        MatClass::U32 => array::<u32>(matrix, head, storage, bytes, limits),
        MatClass::I32 => array::<i32>(matrix, head, storage, bytes, limits),
        MatClass::U64 => array::<u64>(matrix, head, storage, bytes, limits),
        MatClass::I64 => array::<i64>(matrix, head, storage, bytes, limits),
        MatClass::F32 => array::<f32>(matrix, head, storage, bytes, limits),
        MatClass::F64 => array::<f64>(matrix, head, storage, bytes, limits),
        MatClass::Text => text(matrix, head, storage, bytes, limits),
        class => Err(unreadable(matrix.path(), &head.name, class, false)),
    }
}

fn array<T: Element>(
    matrix: &mut Matrix<'_>,
    head: &Head,
    storage: Storage,
    bytes: u64,
    limits: Limits,
) -> Result<MatArray, Error> {
    let values = numbers::read::<T>(matrix, storage, bytes, limits)?;
    matrix.finish()?;
    let array =
        ArrayD::from_shape_vec(IxDyn(&head.size).f(), values).map_err(|error| matrix.broken(error.to_string()))?;
    Ok(T::array(array))
}

/// Reads a row of characters.
fn text(matrix: &mut Matrix<'_>, head: &Head, storage: Storage, bytes: u64, limits: Limits) -> Result<MatArray, Error> {
    let name = &head.name;
    let elements = head.size.iter().product::<usize>();
    if elements > 0 && (head.size[0] != 1 || head.size.len() > 2) {
        return Err(Error::unsupported(
            matrix.path(),
            format!("'{name}' has text of several rows; one row can be read"),
        ));
    }
    let units = numbers::read::<u32>(matrix, storage, bytes, limits)?;
    let text: Option<String> = match storage {
        Storage::Utf8 => {
            let bytes: Option<Vec<u8>> = units.iter().map(|&unit| u8::try_from(unit).ok()).collect();
            bytes.and_then(|bytes| String::from_utf8(bytes).ok())
        }
        Storage::Utf32 => units.iter().map(|&unit| char::from_u32(unit)).collect(),
        // Numbers of any width are units of UTF-16.
        _ => {
            let units: Option<Vec<u16>> = units.iter().map(|&unit| u16::try_from(unit).ok()).collect();
            units.and_then(|units| String::from_utf16(&units).ok())
        }
    };
    let text = text.ok_or_else(|| matrix_error(matrix.path(), name, "is not text"))?;
    if ![text.chars().count(), text.encode_utf16().count(), text.len()].contains(&elements) {
        return Err(matrix_error(matrix.path(), name, "has another length than its dimensions"));
    }
    matrix.finish()?;
    Ok(MatArray::Text(text))
}

fn matrix_error(path: &Path, name: &str, what: &str) -> Error {
    Error::broken(path, FORMAT_V5, format!("'{name}' {what}"))
}
