//! Sizes of grids and places in them, rows first.

use std::fmt;
use std::str::FromStr;

/// Rows and columns of something laid out in a grid: views, lenses or pixels.
///
/// In code rows come first, as in ndarray; as text columns come first, as in image tools: `"60x40"` is 60 columns and 40
/// rows.
///
/// # Examples
///
/// ```
/// use holo_core::GridSize;
///
/// let full_hd = GridSize::new(1080, 1920);
/// assert_eq!(full_hd.count(), 1080 * 1920);
/// assert_eq!(full_hd, [1080, 1920].into());
/// assert_eq!(full_hd.to_string(), "1920x1080");
/// assert_eq!("1920x1080".parse(), Ok(full_hd));
/// assert_eq!("7".parse(), Ok(GridSize::new(7, 7)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct GridSize {
    /// Number of rows, the vertical count.
    pub rows: usize,
    /// Number of columns, the horizontal count.
    pub columns: usize,
}

/// A text that is no [`GridSize`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParseGridSizeError;

/// A view by its row and column, both from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ViewIndex {
    /// Row `t` of the view.
    pub row: usize,
    /// Column `s` of the view.
    pub column: usize,
}

/// A lens by its row and column, both from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LensIndex {
    /// Row `v` of the lens.
    pub row: usize,
    /// Column `u` of the lens.
    pub column: usize,
}

impl GridSize {
    /// Puts a number of rows and a number of columns together, rows first.
    #[must_use]
    pub const fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns }
    }

    /// Returns `rows * columns`, or `usize::MAX` if the product is larger.
    ///
    /// A [`LightFieldShape`](crate::LightFieldShape) only holds grids whose product fits, so the count of its views and lenses is always exact.
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

/// What view and lens indices have in common.
macro_rules! index {
    ($name:ident) => {
        impl $name {
            /// Puts a row and a column together, row first.
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
