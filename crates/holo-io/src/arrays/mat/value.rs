//! Classes and values of the variables of MAT files.

use ndarray::{ArrayD, ArrayViewD};

/// The class of a variable in MATLAB.
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
    /// `cell`; listed, but not read.
    Cell,
    /// `struct`; listed, but not read.
    Struct,
    /// A sparse matrix; listed, but not read.
    Sparse,
    /// An object, a function or another class that only MATLAB writes; listed, but not read.
    Object,
}

impl MatClass {
    /// Returns the name of the class in MATLAB; `object` for all classes that only MATLAB writes.
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

    /// Returns the size of an element in memory in bytes, or `None` for classes that are not read.
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

/// A number of a file, before its conversion to the type of the variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Number {
    Integer(i128),
    Float(f64),
}

/// A number type of MAT files.
pub(crate) trait Element: Copy + Default + Send + Sync + 'static {
    /// The class whose elements have this type.
    const CLASS: MatClass;
    /// Appends the bytes of numbers, little-endian.
    fn append_le_bytes(values: &[Self], bytes: &mut Vec<u8>);
    /// Converts a number to this type; `None` if that is not exact, except that an integer may be rounded to a float.
    fn from_number(number: Number) -> Option<Self>;
    /// Converts to [`Number`], which is exact.
    fn number(self) -> Number;
    /// Wraps an array in its variant.
    fn array(array: ArrayD<Self>) -> MatArray;
}

/// Passes all number classes to a macro: variant, Rust type, name in MATLAB, variant of [`Number`], conversion from it.
macro_rules! for_each_class {
    ($macro:ident) => {
        $macro! {
            U8 u8 "uint8" Integer integer;
            I8 i8 "int8" Integer integer;
            U16 u16 "uint16" Integer integer;
            I16 i16 "int16" Integer integer;
            U32 u32 "uint32" Integer integer;
            I32 i32 "int32" Integer integer;
            U64 u64 "uint64" Integer integer;
            I64 i64 "int64" Integer integer;
            F32 f32 "single" Float single;
            F64 f64 "double" Float double;
        }
    };
}

/// Defines the enums of values.
macro_rules! define_values {
    ($($name:ident $type:ident $matlab:literal $number:ident $from:ident;)*) => {
        /// The value of a variable that is to be written: an array of any strides, or text.
        ///
        /// In MATLAB the indices are the same, counted from 1: `array[[2, 0]]` is `array(3, 1)`. An array of one
        /// dimension becomes a row, one without dimensions a single number.
        #[derive(Debug, Clone)]
        #[non_exhaustive]
        pub enum MatValue<'a> {
            $(#[doc = concat!("An array of `", $matlab, "`.")] $name(ArrayViewD<'a, $type>),)*
            /// A row of `char`.
            Text(&'a str),
        }

        /// The value of a variable that was read.
        ///
        /// # Shape
        ///
        /// As in MATLAB: at least two dimensions, without trailing dimensions of length 1 after the second. In memory
        /// the first index runs fastest, as in the file.
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub enum MatArray {
            $(#[doc = concat!("An array of `", $matlab, "`.")] $name(ArrayD<$type>),)*
            /// A row of `char`.
            Text(String),
        }
    };
}

for_each_class!(define_values);

/// Evaluates an expression with the array of a value, or another with its text.
macro_rules! for_each_array {
    ($type:ident, $value:expr, $array:ident => $body:expr, $text:pat => $text_body:expr) => {
        match $value {
            $type::U8($array) => $body,
            $type::I8($array) => $body,
            $type::U16($array) => $body,
            $type::I16($array) => $body,
            $type::U32($array) => $body,
            $type::I32($array) => $body,
            $type::U64($array) => $body,
            $type::I64($array) => $body,
            $type::F32($array) => $body,
            $type::F64($array) => $body,
            $type::Text($text) => $text_body,
        }
    };
}
pub(super) use for_each_array;

impl MatValue<'_> {
    /// Returns the size of the variable in MATLAB: at least two dimensions, without trailing dimensions of length 1
    /// after the second.
    #[must_use]
    pub fn size(&self) -> Vec<usize> {
        let mut size = for_each_array!(Self, self, array => array.shape().to_vec(), text => match text.is_empty() {
            true => vec![0, 0],
            false => vec![text.encode_utf16().count()],
        });
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

/// Implements what depends on the variant of a number type.
macro_rules! implement_elements {
    ($($name:ident $type:ident $matlab:literal $number:ident $from:ident;)*) => {
        impl MatValue<'_> {
            /// Returns the class of the variable.
            #[must_use]
            pub const fn class(&self) -> MatClass {
                match self {
                    $(Self::$name(_) => MatClass::$name,)*
                    Self::Text(_) => MatClass::Text,
                }
            }
        }

        impl MatArray {
            /// Returns a view of the value, which can be written.
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
            /// Exact, except that 64-bit integers beyond 2^53 are rounded to the nearest `f64`.
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

            fn append_le_bytes(values: &[Self], bytes: &mut Vec<u8>) {
                bytes.reserve(size_of_val(values));
                values.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
            }

            fn from_number(number: Number) -> Option<Self> {
                $from(number)
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

for_each_class!(implement_elements);

/// Converts an integer to an integer type that contains it.
fn integer<T: TryFrom<i128>>(number: Number) -> Option<T> {
    match number {
        Number::Integer(value) => T::try_from(value).ok(),
        Number::Float(_) => None,
    }
}

/// Converts to `f32`: integers are rounded, floats must be exact.
fn single(number: Number) -> Option<f32> {
    match number {
        Number::Integer(value) => Some(value as f32),
        Number::Float(value) => (f64::from(value as f32) == value || value.is_nan()).then_some(value as f32),
    }
}

/// Converts to `f64`: integers are rounded.
fn double(number: Number) -> Option<f64> {
    Some(match number {
        Number::Integer(value) => value as f64,
        Number::Float(value) => value,
    })
}
