//! Clipping to ranges of views or of microlenses.

use std::ops::{Bound, Range, RangeBounds};

use ndarray::{Axis, Data, RawData, Slice};

use super::{LightField, LightFieldRef};
use crate::Error;
use crate::base::error::range_within;

impl<S: RawData> LightField<S> {
    /// Keeps a rectangle of views, without copying.
    ///
    /// # Shape
    ///
    /// View rows `rows` and view columns `columns`; all microlenses remain.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or ends beyond the views.
    pub fn into_clip_views(
        self,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<Self, Error> {
        let (_, _, t, s, _) = self.samples.dim();
        let (rows, columns) = (within("view rows", &rows, t)?, within("view columns", &columns, s)?);
        let samples = self.samples.slice_axis_move(Axis(2), Slice::from(rows));
        Ok(Self::trusted(samples.slice_axis_move(Axis(3), Slice::from(columns))))
    }

    /// Keeps a rectangle of microlenses, which is a part of every view, without copying.
    ///
    /// # Shape
    ///
    /// Microlens rows `rows` and microlens columns `columns`; all views remain.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or ends beyond the microlenses.
    pub fn into_clip_lenses(
        self,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<Self, Error> {
        let (v, u, ..) = self.samples.dim();
        let (rows, columns) = (within("lens rows", &rows, v)?, within("lens columns", &columns, u)?);
        let samples = self.samples.slice_axis_move(Axis(0), Slice::from(rows));
        Ok(Self::trusted(samples.slice_axis_move(Axis(1), Slice::from(columns))))
    }
}

impl<S: Data> LightField<S> {
    /// Returns a rectangle of views as a borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or ends beyond the views.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, LightFieldShape};
    /// use ndarray::Array3;
    ///
    /// let shape = LightFieldShape::new(GridSize::new(9, 9), GridSize::new(4, 5))?;
    /// let light_field = LightField::from_elemental_grid(Array3::<u8>::zeros((36, 45, 3)), shape)?;
    /// let middle = light_field.clip_views(3..6, 3..6)?;
    /// assert_eq!(middle.shape().views(), GridSize::new(3, 3));
    /// let copy = middle.to_owned()?;
    /// assert_eq!(copy, middle);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn clip_views(
        &self,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<LightFieldRef<'_, S::Elem>, Error> {
        self.as_light_field_ref().into_clip_views(rows, columns)
    }

    /// Returns a rectangle of microlenses, which is a part of every view, as a borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or ends beyond the microlenses.
    pub fn clip_lenses(
        &self,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<LightFieldRef<'_, S::Elem>, Error> {
        self.as_light_field_ref().into_clip_lenses(rows, columns)
    }
}

/// The range of indices from 0 to `count` within the given bounds.
fn within(what: &'static str, bounds: &impl RangeBounds<usize>, count: usize) -> Result<Range<usize>, Error> {
    // A bound that overflows is beyond every count.
    let start = match bounds.start_bound() {
        Bound::Included(&start) => start,
        Bound::Excluded(&start) => start.saturating_add(1),
        Bound::Unbounded => 0,
    };
    let end = match bounds.end_bound() {
        Bound::Included(&end) => end.saturating_add(1),
        Bound::Excluded(&end) => end,
        Bound::Unbounded => count,
    };
    range_within(what, &(start..end), count)?;
    Ok(start..end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LightFieldOwned;
    use ndarray::Array5;

    fn field() -> LightFieldOwned<usize> {
        let samples = Array5::from_shape_fn((3, 4, 5, 7, 1), |(v, u, t, s, _)| ((v * 10 + u) * 10 + t) * 10 + s);
        LightField::new(samples).unwrap()
    }

    #[test]
    fn all_kinds_of_ranges_are_accepted() {
        let field = field();
        assert_eq!(field.clip_views(.., ..).unwrap(), field);
        assert_eq!(field.clip_views(1..=2, ..3).unwrap(), field.clip_views(1..3, 0..3).unwrap());
        assert_eq!(field.clip_lenses(1.., ..=0).unwrap(), field.clip_lenses(1..3, 0..1).unwrap());
        assert!(matches!(field.clip_views(0..=usize::MAX, ..), Err(Error::BadRange { .. })));
        assert!(matches!(field.clip_views(5.., ..), Err(Error::BadRange { .. })));
    }
}
