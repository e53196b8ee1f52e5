//! Epipolar-plane images: slices with one spatial and one angular axis.

use ndarray::{ArrayView3, Axis, Data};

use super::LightField;
use crate::Error;
use crate::base::error::index_below;

impl<S: Data> LightField<S> {
    /// Returns the horizontal epipolar-plane image of pixel row `v` in view row `t`: that pixel row in all views from
    /// left to right.
    ///
    /// A point of disparity d is a line that moves by `-d` columns per row.
    ///
    /// # Shape
    ///
    /// `(s, u, c)`: a row for each view column, a column for each pixel.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such row of pixels or of views.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, LightFieldShape};
    /// use ndarray::Array3;
    ///
    /// let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7))?;
    /// let light_field = LightField::from_elemental_grid(Array3::<u8>::zeros((15, 28, 1)), shape)?;
    /// assert_eq!(light_field.epi_row(4, 2)?.dim(), (4, 7, 1));
    /// assert_eq!(light_field.epi_column(6, 3)?.dim(), (3, 5, 1));
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn epi_row(&self, v: usize, t: usize) -> Result<ArrayView3<'_, S::Elem>, Error> {
        index_below("lens row", v, self.samples.dim().0)?;
        index_below("view row", t, self.samples.dim().2)?;
        // (v, u, t, s, c) without t and v is (u, s, c); the view axis goes first.
        let slice = self.samples.view().index_axis_move(Axis(2), t).index_axis_move(Axis(0), v);
        Ok(slice.permuted_axes([1, 0, 2]))
    }

    /// Returns the vertical epipolar-plane image of pixel column `u` in view column `s`: that pixel column in all views
    /// from top to bottom.
    ///
    /// # Shape
    ///
    /// `(t, v, c)`: a row for each view row, a column for each pixel, so the pixel column is horizontal.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such column of pixels or of views.
    pub fn epi_column(&self, u: usize, s: usize) -> Result<ArrayView3<'_, S::Elem>, Error> {
        index_below("lens column", u, self.samples.dim().1)?;
        index_below("view column", s, self.samples.dim().3)?;
        // (v, u, t, s, c) without s and u is (v, t, c); the view axis goes first.
        let slice = self.samples.view().index_axis_move(Axis(3), s).index_axis_move(Axis(1), u);
        Ok(slice.permuted_axes([1, 0, 2]))
    }
}
