//! One setting of a manifest.

use std::collections::BTreeMap;

use holo_core::GridSize;

/// The value of a setting, as JSON knows values.
///
/// JSON has no infinity: such a number is written as the text `inf`, `-inf` or `nan`, and these three texts are read as
/// numbers.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Setting {
    /// Not set.
    None,
    /// Yes or no.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// Any other number; comes back with the same bits.
    Float(f64),
    /// A text.
    Text(String),
    /// Several values in order.
    List(Vec<Setting>),
    /// Several values by name.
    Table(BTreeMap<String, Setting>),
}

impl From<bool> for Setting {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<i64> for Setting {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<u32> for Setting {
    fn from(value: u32) -> Self {
        Self::Integer(i64::from(value))
    }
}

impl From<usize> for Setting {
    /// A count beyond `i64` (no array has so many elements) becomes the nearest number.
    fn from(value: usize) -> Self {
        i64::try_from(value).map_or(Self::Float(value as f64), Self::Integer)
    }
}

impl From<f64> for Setting {
    fn from(value: f64) -> Self {
        Self::Float(value)
    }
}

impl From<&str> for Setting {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for Setting {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl<T: Into<Setting>> From<Vec<T>> for Setting {
    fn from(values: Vec<T>) -> Self {
        Self::List(values.into_iter().map(Into::into).collect())
    }
}

impl<T: Into<Setting>> From<Option<T>> for Setting {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::None, Into::into)
    }
}

impl From<GridSize> for Setting {
    /// A table of `columns` and `rows`.
    fn from(size: GridSize) -> Self {
        Self::Table(BTreeMap::from([
            ("columns".to_owned(), size.columns.into()),
            ("rows".to_owned(), size.rows.into()),
        ]))
    }
}

impl Setting {
    /// Returns a number of either kind.
    #[must_use]
    pub fn as_f64(&self) -> Option<f64> {
        match *self {
            Self::Integer(value) => Some(value as f64),
            Self::Float(value) => Some(value),
            _ => None,
        }
    }

    /// Returns a text; a text that reads as a number that is not finite is a number.
    #[must_use]
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}
