//! The value of a setting in a manifest.

use std::collections::BTreeMap;

use holo_core::GridSize;

/// The value of a setting, as in JSON.
///
/// JSON has no infinity: such a number is written as the text `inf`, `-inf` or `nan`, and these three texts are read as
/// numbers.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ManifestValue {
    /// Not set.
    None,
    /// A truth value.
    Bool(bool),
    /// An integer.
    Integer(i64),
    /// Any other number. Written and read again, it has the same bits, except that all NaN become one.
    Float(f64),
    /// A text.
    Text(String),
    /// A list of values.
    List(Vec<ManifestValue>),
    /// Values by name.
    Table(BTreeMap<String, ManifestValue>),
}

impl From<bool> for ManifestValue {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<i64> for ManifestValue {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<u32> for ManifestValue {
    fn from(value: u32) -> Self {
        Self::Integer(i64::from(value))
    }
}

impl From<usize> for ManifestValue {
    /// A count beyond `i64`, which no array has, becomes the nearest `f64`.
    fn from(value: usize) -> Self {
        i64::try_from(value).map_or(Self::Float(value as f64), Self::Integer)
    }
}

impl From<f64> for ManifestValue {
    fn from(value: f64) -> Self {
        Self::Float(value)
    }
}

impl From<&str> for ManifestValue {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for ManifestValue {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl<T: Into<ManifestValue>> From<Vec<T>> for ManifestValue {
    fn from(values: Vec<T>) -> Self {
        Self::List(values.into_iter().map(Into::into).collect())
    }
}

impl<T: Into<ManifestValue>> From<Option<T>> for ManifestValue {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::None, Into::into)
    }
}

impl From<GridSize> for ManifestValue {
    /// A table of `columns` and `rows`.
    fn from(size: GridSize) -> Self {
        Self::Table(BTreeMap::from([
            ("columns".to_owned(), size.columns.into()),
            ("rows".to_owned(), size.rows.into()),
        ]))
    }
}

impl ManifestValue {
    /// Returns the number of an `Integer` (rounded beyond 2^53) or a `Float`, else `None`.
    #[must_use]
    pub fn as_f64(&self) -> Option<f64> {
        match *self {
            Self::Integer(value) => Some(value as f64),
            Self::Float(value) => Some(value),
            _ => None,
        }
    }

    /// Returns a number, integers too.
    #[must_use]
    pub const fn as_number(&self) -> Option<f64> {
        match *self {
            Self::Float(value) => Some(value),
            Self::Integer(value) => Some(value as f64),
            _ => None,
        }
    }

    /// Returns the text of a `Text`, else `None`.
    #[must_use]
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}
