//! Sizes of grids and indices of their elements, rows first.

use std::fmt;
use std::str::FromStr;

/// The numbers of rows and columns of a grid of views, microlenses or pixels.
///
/// In code, rows come first, as in ndarray. In text, columns come first, as in image tools: `"60x40"` is 60 columns and
/// 40 rows.
///
/// # Examples
///
/// ```
/// use holo_core::GridSize;
///
/// let full_hd = GridSize::new(1080, 1920);
/// assert_eq!(full_hd.count(), 1080 * 1920);
/// assert_eq!(full_hd, [1080, 1920].into());
/// assert_eq!(GridSize::new(7, 7), GridSize::from(7));
/// assert_eq!(full_hd.to_string(), "1920x1080");
/// assert_eq!("1920x1080".parse(), Ok(full_hd));
/// assert_eq!("7".parse(), Ok(GridSize::new(7, 7)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct GridSize {
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
}

/// The error for a text that is not a [`GridSize`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParseGridSizeError;

/// The row and column of a view, both from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ViewIndex {
    /// Row `t` of the view.
    pub row: usize,
    /// Column `s` of the view.
    pub column: usize,
}

/// The row and column of a microlens, both from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LensIndex {
    /// Row `v` of the microlens.
    pub row: usize,
    /// Column `u` of the microlens.
    pub column: usize,
}

impl GridSize {
    /// Returns the size with the given numbers of rows and columns.
    #[must_use]
    pub const fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns }
    }

    /// Returns `rows * columns`, or `usize::MAX` if the product is larger.
    ///
    /// The product always fits for the grids of a [`LightFieldShape`](crate::LightFieldShape).
    #[must_use]
    pub const fn count(self) -> usize {
        self.rows.saturating_mul(self.columns)
    }

    /// Returns the larger of the two counts.
    #[must_use]
    pub const fn larger(self) -> usize {
        if self.rows > self.columns { self.rows } else { self.columns }
    }
}

impl From<usize> for GridSize {
    /// As many rows as columns.
    fn from(count: usize) -> Self {
        Self::new(count, count)
    }
}

impl From<[usize; 2]> for GridSize {
    /// Rows first.
    fn from([rows, columns]: [usize; 2]) -> Self {
        Self { rows, columns }
    }
}

impl fmt::Display for GridSize {
    /// Columns first.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.columns, self.rows)
    }
}

impl FromStr for GridSize {
    type Err = ParseGridSizeError;

    /// `COLUMNSxROWS`, or one number for both; neither may be 0.
    fn from_str(text: &str) -> Result<Self, ParseGridSizeError> {
        let number = |part: &str| match part.trim().parse() {
            Ok(0) | Err(_) => Err(ParseGridSizeError),
            Ok(count) => Ok(count),
        };
        match text.split_once(['x', 'X']) {
            Some((columns, rows)) => Ok(Self::new(number(rows)?, number(columns)?)),
            None => number(text).map(|count| Self::new(count, count)),
        }
    }
}

impl fmt::Display for ParseGridSizeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("write COLUMNSxROWS, such as 30x20, both from 1 up")
    }
}

impl std::error::Error for ParseGridSizeError {}

/// Constructors and conversions of view and lens indices.
macro_rules! index {
    ($name:ident) => {
        impl $name {
            /// Returns the index with the given row and column.
            #[must_use]
            pub const fn new(row: usize, column: usize) -> Self {
                Self { row, column }
            }
        }

        impl From<[usize; 2]> for $name {
            /// Row first.
            fn from([row, column]: [usize; 2]) -> Self {
                Self { row, column }
            }
        }

        impl From<(usize, usize)> for $name {
            /// Row first.
            fn from((row, column): (usize, usize)) -> Self {
                Self { row, column }
            }
        }
    };
}

index!(ViewIndex);
index!(LensIndex);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_columns_by_rows() {
        assert_eq!("30x20".parse(), Ok(GridSize::new(20, 30)));
        assert_eq!("30 X 20".parse(), Ok(GridSize::new(20, 30)));
        for size in [GridSize::new(1, 1), GridSize::new(5304, 7952)] {
            assert_eq!(size.to_string().parse(), Ok(size));
        }
        for bad in ["", "x", "0x3", "3x", "3x4x5", "-1x2", "99999999999999999999x1"] {
            assert_eq!(bad.parse::<GridSize>(), Err(ParseGridSizeError), "{bad}");
        }
    }

    #[test]
    fn arrays_are_rows_first() {
        assert_eq!(GridSize::from([2, 3]), GridSize { rows: 2, columns: 3 });
        assert_eq!(ViewIndex::from([2, 3]), ViewIndex { row: 2, column: 3 });
        assert_eq!(LensIndex::from((2, 3)), LensIndex { row: 2, column: 3 });
    }
}
