//! The numbers of a variable, decoded by the crate `matfile` in pieces.
//!
//! `matfile` 0.5 reads whole files, with errors: it accepts truncated files, multiplies dimensions without a check,
//! refuses `int32` (its table has `uint32` in that place) and ignores text. `tests/all/mat_matfile.rs` tests each of these,
//! so that a change in a later version is noticed. By its source it also inflates without a limit, prints to the
//! terminal, and refuses doubles that are stored as `int8`.
//!
//! Its decoding of numbers is correct. So it decodes small files that this module creates: one array each, of the
//! storage type of the numbers, in the byte order of the file; only the data are those of the file. `int32` is passed
//! as `uint32`, which has the same bits. This module converts the numbers to the type of the variable. The variable and
//! a few such pieces are in memory.

use std::any::Any;

use matfile::NumericData;
use rayon::prelude::*;

use super::head::{ByteOrder, Matrix};
use super::{HEADER_BYTES, Storage, TYPE_MATRIX, VERSION, padding};
use crate::arrays::mat::FORMAT_V5;
use crate::arrays::mat::value::Element;
use crate::files::panic_guard::catch;
use crate::{Error, Limits};

/// Bytes of numbers in a piece: a multiple of the size of every number type.
const PIECE_BYTES: usize = 1 << 20;

/// Reads `length` bytes of numbers and converts each to the type `T` without rounding; see [`Element::from_number`].
pub(super) fn read<T: Element>(
    matrix: &mut Matrix<'_>,
    storage: Storage,
    length: u64,
    limits: Limits,
) -> Result<Vec<T>, Error> {
    let path = matrix.path();
    let count = usize::try_from(length / storage.bytes() as u64).unwrap_or(usize::MAX);
    let count = limits.elements(path, "variable", &[count], size_of::<T>())?;
    let mut values = Limits::room(path, "variable", count)?;
    let mut left = count * storage.bytes();
    let mut batch = Vec::new();
    while left > 0 {
        let bytes = left.min(PIECE_BYTES * rayon::current_num_threads().clamp(1, 8));
        batch.resize(bytes, 0);
        matrix.exact(&mut batch)?;
        left -= bytes;
        let order = matrix.order();
        let pieces: Vec<Result<Vec<T>, String>> =
            batch.par_chunks(PIECE_BYTES).map(|piece| decode(piece, storage, order)).collect();
        for piece in pieces {
            values.extend(piece.map_err(|what| Error::broken(path, FORMAT_V5, what))?);
        }
    }
    Ok(values)
}

/// Decodes the bytes of a piece.
fn decode<T: Element>(bytes: &[u8], storage: Storage, order: ByteOrder) -> Result<Vec<T>, String> {
    let file = file_of(bytes, storage, order);
    let parsed = catch(|| matfile::MatFile::parse(file.as_slice()))
        .map_err(|text| format!("the decoder failed on this file ({text}); please report it"))?
        .map_err(|error| format!("the decoder refused the numbers: {error}"))?;
    let array = parsed.arrays().first().ok_or("the decoder found no numbers")?;
    let values = match array.data() {
        NumericData::Int8 { real, .. } => take(real),
        NumericData::UInt8 { real, .. } => take(real),
        NumericData::Int16 { real, .. } => take(real),
        NumericData::UInt16 { real, .. } => take(real),
        NumericData::Int32 { real, .. } => take(real),
        NumericData::UInt32 { real, .. } if storage == Storage::I32 => {
            take(&real.iter().map(|&bits| bits.cast_signed()).collect::<Vec<i32>>())
        }
        NumericData::UInt32 { real, .. } => take(real),
        NumericData::Int64 { real, .. } => take(real),
        NumericData::UInt64 { real, .. } => take(real),
        NumericData::Single { real, .. } => take(real),
        NumericData::Double { real, .. } => take(real),
    };
    values
        .filter(|values: &Vec<T>| values.len() == bytes.len() / storage.bytes())
        .ok_or_else(|| format!("a number that is stored as {storage:?} does not fit the class {}", T::CLASS.name()))
}

/// Converts stored numbers to the type of the variable; `None` if one does not fit.
#[expect(clippy::ptr_arg, reason = "downcasting needs a sized type")]
fn take<S: Element, T: Element>(values: &Vec<S>) -> Option<Vec<T>> {
    // The same type keeps every bit, those of NaN included.
    if let Some(same) = (values as &dyn Any).downcast_ref::<Vec<T>>() {
        return Some(same.clone());
    }
    values.iter().map(|value| T::from_number(value.number())).collect()
}

/// Creates a file of one array, a column.
fn file_of(data: &[u8], storage: Storage, order: ByteOrder) -> Vec<u8> {
    let (class, storage) = match storage {
        Storage::I8 => (8, storage),
        Storage::U8 | Storage::Utf8 => (9, Storage::U8),
        Storage::I16 => (10, storage),
        Storage::U16 | Storage::Utf16 => (11, Storage::U16),
        Storage::I32 | Storage::U32 | Storage::Utf32 => (13, Storage::U32),
        Storage::F32 => (7, storage),
        Storage::F64 => (6, storage),
        Storage::I64 => (14, storage),
        Storage::U64 => (15, storage),
    };
    let count = data.len() / storage.bytes();
    let fill = padding(data.len() as u64) as usize;
    let mut file = Vec::with_capacity(HEADER_BYTES + 72 + data.len() + fill);
    file.resize(HEADER_BYTES - 4, b' ');
    match order {
        ByteOrder::Little => file.extend([VERSION.to_le_bytes(), *b"IM"].concat()),
        ByteOrder::Big => file.extend([VERSION.to_be_bytes(), *b"MI"].concat()),
    }
    // Flags, two dimensions and a name of one letter take 16 bytes each; the tags of the matrix and of the data 8 each.
    let numbers = [
        [TYPE_MATRIX, 48 + 8 + (data.len() + fill) as u32],
        [Storage::U32.code(), 8],
        [class, 0],
        [Storage::I32.code(), 8],
        [count as u32, 1],
        [Storage::I8.code(), 1],
    ];
    file.extend(numbers.as_flattened().iter().flat_map(|&number| order.bytes(number)));
    file.extend(*b"x\0\0\0\0\0\0\0");
    file.extend([storage.code(), data.len() as u32].into_iter().flat_map(|number| order.bytes(number)));
    file.extend(data);
    file.resize(file.len() + fill, 0);
    file
}
