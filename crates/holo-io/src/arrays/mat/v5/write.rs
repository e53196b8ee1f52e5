//! The writer of variables, each slab by slab.

use std::io::{self, Seek, SeekFrom, Write};

use ndarray::ArrayViewD;

use super::{HEADER_BYTES, Storage, TYPE_COMPRESSED, TYPE_MATRIX, VERSION, code_of_class, padding};
use crate::arrays::mat::order::column_major;
use crate::arrays::mat::value::{Element, MatValue, for_each_array};
use crate::files::zlib::{Piece, Stream};

/// The descriptive text at the beginning of the file. MATLAB requires the first words. No clock, so that equal inputs
/// give equal bytes.
const TEXT: &str = "MATLAB 5.0 MAT-file, written by holo";

/// The header of the file.
pub(in crate::arrays::mat) fn header() -> Vec<u8> {
    header_of(TEXT, VERSION)
}

/// The header of a file of any version since 5, with its text.
pub(in crate::arrays::mat) fn header_of(text: &str, version: u16) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(116, b' ');
    // No subsystem data.
    bytes.resize(124, 0);
    bytes.extend(version.to_le_bytes());
    bytes.extend(b"IM");
    debug_assert_eq!(bytes.len(), HEADER_BYTES);
    bytes
}

/// Writes a variable uncompressed. The caller has checked its name and its size.
pub(in crate::arrays::mat) fn plain(out: &mut impl Write, name: &str, value: &MatValue<'_>) -> io::Result<()> {
    let variable = Variable::new(name, value)?;
    out.write_all(&variable.head)?;
    each_slab(value, &|bytes| bytes, &mut |bytes: Vec<u8>| out.write_all(&bytes))?;
    out.write_all(&[0; 8][..variable.padding])
}

/// Writes a variable compressed. The compressed length, which comes first in the file, is written last.
pub(in crate::arrays::mat) fn compressed(
    out: &mut (impl Write + Seek),
    name: &str,
    value: &MatValue<'_>,
) -> io::Result<()> {
    let variable = Variable::new(name, value)?;
    let start = out.stream_position()?;
    out.write_all(&tag(TYPE_COMPRESSED, 0))?;
    let mut stream = Stream::new(&mut *out)?;
    stream.push(&Piece::compress(&variable.head)?)?;
    each_slab(value, &|bytes| Piece::compress(&bytes), &mut |piece: io::Result<Piece>| stream.push(&piece?))?;
    stream.push(&Piece::compress(&[0; 8][..variable.padding])?)?;
    let bytes = stream.finish()?;
    let length = u32::try_from(bytes).map_err(|_| io::Error::other("the compressed variable is longer than 4 GiB"))?;
    let end = out.stream_position()?;
    out.seek(SeekFrom::Start(start))?;
    out.write_all(&tag(TYPE_COMPRESSED, length))?;
    out.seek(SeekFrom::Start(end)).map(|_| ())
}

/// A variable without its data.
struct Variable {
    head: Vec<u8>,
    padding: usize,
}

impl Variable {
    fn new(name: &str, value: &MatValue<'_>) -> io::Result<Self> {
        let unwritable = || io::Error::other("this variable cannot be written");
        let class = value.class();
        let (code, storage) = code_of_class(class).zip(Storage::of(class)).ok_or_else(unwritable)?;
        let size = value.size();
        let data = match value {
            // The dimensions count units of UTF-16 nevertheless.
            MatValue::Text(text) => text.len() as u64,
            _ => size.iter().product::<usize>() as u64 * storage.bytes() as u64,
        };

        let mut head = Vec::new();
        element(&mut head, Storage::U32, &[u32::from(code), 0].map(u32::to_le_bytes).concat());
        let mut dimensions = Vec::new();
        for &count in &size {
            dimensions.extend(i32::try_from(count).map_err(|_| unwritable())?.to_le_bytes());
        }
        element(&mut head, Storage::I32, &dimensions);
        element(&mut head, Storage::I8, name.as_bytes());
        // Data of up to four bytes are stored within the eight bytes of the tag.
        let short = (1..=4).contains(&data);
        let padding = if short { 4 - data } else { padding(data) };
        head.extend(if short {
            (storage.code() | (data as u32) << 16).to_le_bytes().to_vec()
        } else {
            tag(storage.code(), u32::try_from(data).map_err(|_| unwritable())?).to_vec()
        });
        let total = u32::try_from(head.len() as u64 + data + padding).map_err(|_| unwritable())?;
        head.splice(0..0, tag(TYPE_MATRIX, total));
        Ok(Self { head, padding: padding as usize })
    }
}

const fn tag(code: u32, length: u32) -> [u8; 8] {
    let ([a, b, c, d], [e, f, g, h]) = (code.to_le_bytes(), length.to_le_bytes());
    [a, b, c, d, e, f, g, h]
}

/// Appends a small element, padded.
fn element(bytes: &mut Vec<u8>, storage: Storage, data: &[u8]) {
    let length = data.len() as u32;
    if (1..=4).contains(&length) {
        bytes.extend((storage.code() | length << 16).to_le_bytes());
        bytes.extend(data);
        bytes.resize(bytes.len() + 4 - data.len(), 0);
    } else {
        bytes.extend(tag(storage.code(), length));
        bytes.extend(data);
        bytes.resize(bytes.len() + padding(data.len() as u64) as usize, 0);
    }
}

/// Passes the data of a variable to `take` as bytes, slab by slab.
fn each_slab<P: Send>(
    value: &MatValue<'_>,
    prepare: &(impl Fn(Vec<u8>) -> P + Sync),
    take: &mut impl FnMut(P) -> io::Result<()>,
) -> io::Result<()> {
    fn numbers<T: Element, P: Send>(
        array: &ArrayViewD<'_, T>,
        prepare: &(impl Fn(Vec<u8>) -> P + Sync),
        take: &mut impl FnMut(P) -> io::Result<()>,
    ) -> io::Result<()> {
        let prepare = |values: &[T]| {
            let mut bytes = Vec::new();
            T::append_le_bytes(values, &mut bytes);
            prepare(bytes)
        };
        column_major(array, prepare, take)
    }
    for_each_array!(MatValue, value, array => numbers(array, prepare, take), text => match text.is_empty() {
        true => Ok(()),
        false => take(prepare(text.as_bytes().to_vec())),
    })
}
