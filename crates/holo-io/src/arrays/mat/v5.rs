//! MAT files of version 5: elements of a type, a length and data; written little-endian.

pub(super) mod head;
pub(super) mod numbers;
pub(super) mod read;
pub(super) mod write;

use super::MatClass;

/// Bytes of the header.
const HEADER_BYTES: usize = 128;

/// The version in the header, in the byte order of the file.
const VERSION: u16 = 0x0100;

/// The limit of MATLAB: a variable of version 5 has fewer bytes in total.
pub(super) const MAX_VARIABLE_BYTES: u64 = 1 << 31;

/// Upper bound of the size of tags, flags, dimensions and name of a variable.
pub(super) const VARIABLE_HEAD_BYTES: u64 = 4096;

/// Types of elements that hold no numbers.
const TYPE_MATRIX: u32 = 14;
const TYPE_COMPRESSED: u32 = 15;

/// The storage types of numbers and characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Storage {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
    I64,
    U64,
    Utf8,
    Utf16,
    Utf32,
}

impl Storage {
    const fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::I8,
            2 => Self::U8,
            3 => Self::I16,
            4 => Self::U16,
            5 => Self::I32,
            6 => Self::U32,
            7 => Self::F32,
            9 => Self::F64,
            12 => Self::I64,
            13 => Self::U64,
            16 => Self::Utf8,
            17 => Self::Utf16,
            18 => Self::Utf32,
            _ => return None,
        })
    }

    const fn code(self) -> u32 {
        match self {
            Self::I8 => 1,
            Self::U8 => 2,
            Self::I16 => 3,
            Self::U16 => 4,
            Self::I32 => 5,
            Self::U32 => 6,
            Self::F32 => 7,
            Self::F64 => 9,
            Self::I64 => 12,
            Self::U64 => 13,
            Self::Utf8 => 16,
            Self::Utf16 => 17,
            Self::Utf32 => 18,
        }
    }

    const fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 | Self::Utf8 => 1,
            Self::I16 | Self::U16 | Self::Utf16 => 2,
            Self::I32 | Self::U32 | Self::F32 | Self::Utf32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }

    /// The storage type that a class is written as: that of its numbers; for text UTF-8, because SciPy does not read
    /// `uint16` beyond ASCII.
    const fn of(class: MatClass) -> Option<Self> {
        Some(match class {
            MatClass::U8 | MatClass::Logical => Self::U8,
            MatClass::I8 => Self::I8,
            MatClass::Text => Self::Utf8,
            MatClass::U16 => Self::U16,
            MatClass::I16 => Self::I16,
            MatClass::U32 => Self::U32,
            MatClass::I32 => Self::I32,
            MatClass::U64 => Self::U64,
            MatClass::I64 => Self::I64,
            MatClass::F32 => Self::F32,
            MatClass::F64 => Self::F64,
            MatClass::Cell | MatClass::Struct | MatClass::Sparse | MatClass::Object => return None,
        })
    }
}

/// Returns the class of a code in the flags of a matrix; `None` for codes that MATLAB does not write.
const fn class_of_code(code: u8) -> Option<MatClass> {
    Some(match code {
        1 => MatClass::Cell,
        2 => MatClass::Struct,
        // Objects, functions, and objects that the subsystem data of the file describe.
        3 | 16 | 17 => MatClass::Object,
        4 => MatClass::Text,
        5 => MatClass::Sparse,
        6 => MatClass::F64,
        7 => MatClass::F32,
        8 => MatClass::I8,
        9 => MatClass::U8,
        10 => MatClass::I16,
        11 => MatClass::U16,
        12 => MatClass::I32,
        13 => MatClass::U32,
        14 => MatClass::I64,
        15 => MatClass::U64,
        _ => return None,
    })
}

/// Returns the code of a class; `None` for classes that are not written.
const fn code_of_class(class: MatClass) -> Option<u8> {
    Some(match class {
        MatClass::Text => 4,
        MatClass::F64 => 6,
        MatClass::F32 => 7,
        MatClass::I8 => 8,
        MatClass::U8 => 9,
        MatClass::I16 => 10,
        MatClass::U16 => 11,
        MatClass::I32 => 12,
        MatClass::U32 => 13,
        MatClass::I64 => 14,
        MatClass::U64 => 15,
        MatClass::Logical | MatClass::Cell | MatClass::Struct | MatClass::Sparse | MatClass::Object => return None,
    })
}

/// Number of padding bytes of an element of this length, up to a multiple of eight.
const fn padding(bytes: u64) -> u64 {
    bytes.wrapping_neg() % 8
}
