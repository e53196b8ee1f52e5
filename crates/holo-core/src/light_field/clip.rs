//! Clipping to ranges of views, of microlenses, or of the pixels of one image.

use std::ops::{Bound, Range, RangeBounds};

use ndarray::{ArrayView3, Axis, Data, DataMut, RawData, Slice};

use super::{LightField, LightFieldRef, LightFieldRefMut};
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

    /// Returns a part of view `(t, s)`.
    ///
    /// # Shape
    ///
    /// `(v, u, c)`, with as many rows and columns as the ranges.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such view; [`Error::BadRange`] if a range is empty or ends beyond the
    /// image.
    pub fn crop_view(
        &self,
        t: usize,
        s: usize,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<ArrayView3<'_, S::Elem>, Error> {
        crop(self.view(t, s)?, rows, columns)
    }

    /// Returns a part of the elemental image of microlens `(v, u)`.
    ///
    /// # Shape
    ///
    /// `(t, s, c)`, with as many rows and columns as the ranges.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such microlens; [`Error::BadRange`] if a range is empty or ends beyond the
    /// image.
    pub fn crop_elemental_image(
        &self,
        v: usize,
        u: usize,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<ArrayView3<'_, S::Elem>, Error> {
        crop(self.elemental_image(v, u)?, rows, columns)
    }
}

impl<S: DataMut> LightField<S> {
    /// Returns a rectangle of views as a mutably borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or ends beyond the views.
    pub fn clip_views_mut(
        &mut self,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<LightFieldRefMut<'_, S::Elem>, Error> {
        self.as_light_field_mut().into_clip_views(rows, columns)
    }

    /// Returns a rectangle of microlenses as a mutably borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or ends beyond the microlenses.
    pub fn clip_lenses_mut(
        &mut self,
        rows: impl RangeBounds<usize>,
        columns: impl RangeBounds<usize>,
    ) -> Result<LightFieldRefMut<'_, S::Elem>, Error> {
        self.as_light_field_mut().into_clip_lenses(rows, columns)
    }
}

fn crop<'a, T>(
    image: ArrayView3<'a, T>,
    rows: impl RangeBounds<usize>,
    columns: impl RangeBounds<usize>,
) -> Result<ArrayView3<'a, T>, Error> {
    let (height, width, _) = image.dim();
    let (rows, columns) = (within("image rows", &rows, height)?, within("image columns", &columns, width)?);
    let image = image.slice_axis_move(Axis(0), Slice::from(rows));
    Ok(image.slice_axis_move(Axis(1), Slice::from(columns)))
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
