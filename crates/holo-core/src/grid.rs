//! Sizes of grids and places in them, rows first.

/// Rows and columns of something laid out in a grid: views, lenses or pixels.
///
/// # Examples
///
/// ```
/// let full_hd = holo_core::GridSize::new(1080, 1920);
/// assert_eq!(full_hd.count(), 1080 * 1920);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GridSize {
    /// Number of rows, the vertical count.
    pub rows: usize,
    /// Number of columns, the horizontal count.
    pub columns: usize,
}

impl GridSize {
    /// Puts a number of rows and a number of columns together, rows first.
    #[must_use]
    pub const fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns }
    }

    /// Returns `rows * columns`, or `usize::MAX` if the product is larger.
    ///
    /// A [`Split`](crate::Split) only holds grids whose product fits, so the count of its views and lenses is always exact.
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

/// A view by its row and column, both from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ViewIndex {
    /// Row `t` of the view.
    pub row: usize,
    /// Column `s` of the view.
    pub column: usize,
}

impl ViewIndex {
    /// Puts a row and a column together, row first.
    #[must_use]
    pub const fn new(row: usize, column: usize) -> Self {
        Self { row, column }
    }
}
