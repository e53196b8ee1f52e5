//! What a variable of a MAT file can hold.

use ndarray::{ArrayD, ArrayViewD};

/// The class of a variable: how MATLAB shows and computes with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MatClass {
    /// `uint8`.
    U8,
    /// `int8`.
    I8,
    /// `uint16`.
    U16,
    /// `int16`.
    I16,
    /// `uint32`.
    U32,
    /// `int32`.
    I32,
    /// `uint64`.
    U64,
    /// `int64`.
    I64,
    /// `single`.
    F32,
    /// `double`.
    F64,
    /// `logical`, which is read as `uint8`.
    Logical,
    /// `char`.
    Text,
    /// `cell`: listed, but not read.
    Cell,
    /// `struct`: listed, but not read.
    Struct,
    /// A sparse matrix: listed, but not read.
    Sparse,
    /// An object, a function or what else only MATLAB makes: listed, but not read.
    Object,
}

impl MatClass {
    /// Returns MATLAB's own name of the class; `object` stands for all that only MATLAB makes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::U32 => "uint32",
            Self::I32 => "int32",
            Self::U64 => "uint64",
            Self::I64 => "int64",
            Self::F32 => "single",
            Self::F64 => "double",
            Self::Logical => "logical",
            Self::Text => "char",
            Self::Cell => "cell",
            Self::Struct => "struct",
            Self::Sparse => "sparse",
            Self::Object => "object",
        }
    }

    /// Returns the bytes of one element in memory, or `None` for what is not read.
    pub(crate) const fn element_bytes(self) -> Option<usize> {
        match self {
            Self::U8 | Self::I8 | Self::Logical => Some(1),
            Self::U16 | Self::I16 | Self::Text => Some(2),
            Self::U32 | Self::I32 | Self::F32 => Some(4),
            Self::U64 | Self::I64 | Self::F64 => Some(8),
            Self::Cell | Self::Struct | Self::Sparse | Self::Object => None,
        }
    }
}

/// A number that comes from a file, before it takes the type of its variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Number {
    Integer(i128),
    Float(f64),
}

/// A number type of MAT files.
pub(crate) trait Element: Copy + Default + Send + Sync + 'static {
    /// The class whose elements have this type.
    const CLASS: MatClass;
    /// Appends the bytes of numbers, least significant first.
    fn append(values: &[Self], bytes: &mut Vec<u8>);
    /// Takes a number if this type has it: nothing is rounded but an integer that becomes a float.
    fn from_number(number: Number) -> Option<Self>;
    /// The number as it is.
    fn number(self) -> Number;
    /// Puts an array into its variant.
    fn array(array: ArrayD<Self>) -> MatArray;
}

macro_rules! kinds {
    ($($name:ident $type:ty: $matlab:literal, $number:ident, $from:expr;)*) => {
        /// The value of a variable that is to be written; arrays of any strides.
        ///
        /// Every array is seen by MATLAB with the same indices, counted from 1: `array[[2, 0]]` is `array(3, 1)`. An array of
        /// one dimension becomes a row, one of none a single number.
        #[derive(Debug, Clone)]
        #[non_exhaustive]
        pub enum MatValue<'a> {
            $(#[doc = concat!("Becomes an array of `", $matlab, "`.")] $name(ArrayViewD<'a, $type>),)*
            /// Becomes a row of `char`.
            Text(&'a str),
        }

        /// The value of a variable that was read.
        ///
        /// # Shape
        ///
        /// As in MATLAB: at least two dimensions, and those of length 1 at the end are missing behind the second. In memory the
        /// first index runs fastest, as in the file.
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub enum MatArray {
            $(#[doc = concat!("An array of `", $matlab, "`.")] $name(ArrayD<$type>),)*
            /// A row of `char`.
            Text(String),
        }

        impl MatValue<'_> {
            /// Returns the class that the variable gets.
            #[must_use]
            pub const fn class(&self) -> MatClass {
                match self {
                    $(Self::$name(_) => MatClass::$name,)*
                    Self::Text(_) => MatClass::Text,
                }
            }

            /// Returns the size that MATLAB shows: at least two dimensions, none of length 1 at the end behind the second.
            #[must_use]
            pub fn size(&self) -> Vec<usize> {
                let mut size = match self {
                    $(Self::$name(array) => array.shape().to_vec(),)*
                    Self::Text("") => vec![0, 0],
                    Self::Text(text) => vec![text.encode_utf16().count()],
                };
                match size.len() {
                    0 => size = vec![1, 1],
                    1 => size.insert(0, 1),
                    _ => {}
                }
                while size.len() > 2 && size.last() == Some(&1) {
                    size.pop();
                }
                size
            }
        }

        impl MatArray {
            /// Returns a view that can be written again.
            #[must_use]
            pub fn view(&self) -> MatValue<'_> {
                match self {
                    $(Self::$name(array) => MatValue::$name(array.view()),)*
                    Self::Text(text) => MatValue::Text(text),
                }
            }

            /// Returns the numbers as `f64` in column-major order, or `None` for text.
            ///
            /// # Accuracy
            ///
            /// Exact but for 64-bit integers beyond 2^53, which are rounded to the nearest.
            #[must_use]
            pub fn to_f64(&self) -> Option<Vec<f64>> {
                match self {
                    $(Self::$name(array) => Some(array.t().iter().map(|&value| value as f64).collect()),)*
                    Self::Text(_) => None,
                }
            }
        }

        $(impl Element for $type {
            const CLASS: MatClass = MatClass::$name;

            fn append(values: &[Self], bytes: &mut Vec<u8>) {
                bytes.reserve(size_of_val(values));
                values.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
            }

            fn from_number(number: Number) -> Option<Self> {
                let from: fn(Number) -> Option<Self> = $from;
                from(number)
            }

            fn number(self) -> Number {
                Number::$number(self.into())
            }

            fn array(array: ArrayD<Self>) -> MatArray {
                MatArray::$name(array)
            }
        })*
    };
}

/// An integer type takes the integers that it has.
fn integer<T: TryFrom<i128>>(number: Number) -> Option<T> {
    match number {
        Number::Integer(value) => T::try_from(value).ok(),
        Number::Float(_) => None,
    }
}

kinds! {
    U8 u8: "uint8", Integer, integer;
    I8 i8: "int8", Integer, integer;
    U16 u16: "uint16", Integer, integer;
    I16 i16: "int16", Integer, integer;
    U32 u32: "uint32", Integer, integer;
    I32 i32: "int32", Integer, integer;
    U64 u64: "uint64", Integer, integer;
    I64 i64: "int64", Integer, integer;
    F32 f32: "single", Float, |number| match number {
        Number::Integer(value) => Some(value as f32),
        // Only a single stored as a single has this type without rounding.
        Number::Float(value) => (f64::from(value as f32) == value || value.is_nan()).then_some(value as f32),
    };
    F64 f64: "double", Float, |number| Some(match number {
        Number::Integer(value) => value as f64,
        Number::Float(value) => value,
    });
}
