//! Eq. 1: the numbers of views and of microlenses of a raw image.

use crate::{Error, GridSize};

/// The shape of a light field: (rows, columns) of views, T x S, and of microlenses, V x U.
///
/// The raw image has `V*T` rows and `U*S` columns in either layout. No count is zero, and the number of samples of one
/// channel fits the address space.
///
/// # Source
///
/// Eq. 1: the number of views per axis times the number of microlenses per axis is the number of pixels per axis. The
/// text of the paper calls its `M` the number of microlenses, but its Table I holds only if `M` is the number of views;
/// see [`Sensor`](crate::Sensor) for the table.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape};
///
/// let shape = LightFieldShape::new(GridSize::new(100, 100), GridSize::new(53, 79))?;
/// assert_eq!(shape.raw_size(), GridSize::new(5300, 7900));
/// assert_eq!(shape.central_view(), (50, 50));
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LightFieldShape {
    views: GridSize,
    lenses: GridSize,
}

impl LightFieldShape {
    /// Returns the shape with `views` (T rows x S columns) and `lenses` (V rows x U columns of microlenses).
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if any of the four counts is zero; [`Error::TooLarge`] if `T*S*V*U` is more than
    /// `isize::MAX`, the largest length of an array.
    pub fn new(views: GridSize, lenses: GridSize) -> Result<Self, Error> {
        for (what, count) in [
            ("view rows", views.rows),
            ("view columns", views.columns),
            ("lens rows", lenses.rows),
            ("lens columns", lenses.columns),
        ] {
            if count == 0 {
                return Err(Error::ZeroCount { what });
            }
        }
        let shape = Self { views, lenses };
        checked_product(&shape.array_shape(1)).map(|_| shape).ok_or(Error::TooLarge { what: "raw image" })
    }

    /// Returns the number of views: T rows x S columns.
    #[must_use]
    pub const fn views(&self) -> GridSize {
        self.views
    }

    /// Returns the number of microlenses, which is the spatial resolution of a view: V rows x U columns.
    #[must_use]
    pub const fn lenses(&self) -> GridSize {
        self.lenses
    }

    /// Returns the size of the raw image in pixels: V*T rows x U*S columns, the same in both layouts.
    #[must_use]
    pub const fn raw_size(&self) -> GridSize {
        // No overflow: `new` checks the product of all four.
        GridSize::new(self.views.rows * self.lenses.rows, self.views.columns * self.lenses.columns)
    }

    /// Returns the number of samples of one channel, `V*U*T*S`.
    #[must_use]
    pub const fn sample_count(&self) -> usize {
        self.views.rows * self.views.columns * self.lenses.rows * self.lenses.columns
    }

    /// Returns the row and column `(t, s)` of the central view: `(T/2, S/2)`, rounded down.
    ///
    /// With an even count no view is in the middle of the rig; this is then the next view to the right or below.
    #[must_use]
    pub const fn central_view(&self) -> (usize, usize) {
        (self.views.rows / 2, self.views.columns / 2)
    }

    /// Returns the shape `[V, U, T, S, channels]` of the 5D array.
    #[must_use]
    pub const fn array_shape(&self, channels: usize) -> [usize; 5] {
        [self.lenses.rows, self.lenses.columns, self.views.rows, self.views.columns, channels]
    }
}

/// The product of all counts, if it fits in an `isize` as the length of an array must.
pub(crate) fn checked_product(counts: &[usize]) -> Option<usize> {
    let product = counts.iter().try_fold(1_usize, |product, &count| product.checked_mul(count))?;
    isize::try_from(product).is_ok().then_some(product)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_counts_are_named() {
        let good = GridSize::new(2, 3);
        assert_eq!(LightFieldShape::new(GridSize::new(0, 3), good), Err(Error::ZeroCount { what: "view rows" }));
        assert_eq!(LightFieldShape::new(GridSize::new(2, 0), good), Err(Error::ZeroCount { what: "view columns" }));
        assert_eq!(LightFieldShape::new(good, GridSize::new(0, 3)), Err(Error::ZeroCount { what: "lens rows" }));
        assert_eq!(LightFieldShape::new(good, GridSize::new(2, 0)), Err(Error::ZeroCount { what: "lens columns" }));
        // The zero is reported, although the other product overflows.
        assert_eq!(
            LightFieldShape::new(GridSize::new(usize::MAX, usize::MAX), GridSize::new(usize::MAX, 0)),
            Err(Error::ZeroCount { what: "lens columns" })
        );
    }

    #[test]
    fn sizes_are_checked_and_not_wrapped() {
        let huge = GridSize::new(65_536, 65_536);
        // 2^64 wraps to 0 in 64 bits.
        assert_eq!(LightFieldShape::new(huge, huge), Err(Error::TooLarge { what: "raw image" }));
        assert_eq!(
            LightFieldShape::new(GridSize::new(65_536, 65_536), GridSize::new(65_536, 1 << 15)),
            Err(Error::TooLarge { what: "raw image" })
        );
        // isize::MAX = 2^63 - 1, so 2^62 is the largest power of two.
        let largest = LightFieldShape::new(huge, GridSize::new(1 << 15, 1 << 15)).unwrap();
        assert_eq!(largest.sample_count(), 1 << 62);
        assert!(LightFieldShape::new(GridSize::new(usize::MAX, 1), GridSize::new(1, 1)).is_err());
    }

    #[test]
    fn sizes_multiply_by_axis() {
        let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(5, 7)).unwrap();
        assert_eq!(shape.raw_size(), GridSize::new(10, 21));
        assert_eq!(shape.sample_count(), 210);
        assert_eq!(shape.array_shape(4), [5, 7, 2, 3, 4]);
        assert_eq!(shape.central_view(), (1, 1));
        assert_eq!(GridSize::new(usize::MAX, 2).count(), usize::MAX);
    }
}
