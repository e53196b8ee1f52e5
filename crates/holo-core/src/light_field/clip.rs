//! Clipping: fewer views, fewer lenses, or a piece of one image.

use std::ops::Range;

use ndarray::{ArrayView3, Axis, Data, DataMut, RawData, Slice};

use super::{LightField, LightFieldView, LightFieldViewMut};
use crate::Error;
use crate::error::range_within;

impl<S: RawData> LightField<S> {
    /// Keeps a rectangle of views and drops the others, without copying.
    ///
    /// # Shape
    ///
    /// View rows `rows` and view columns `columns`; all lenses stay.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or reaches beyond the views.
    pub fn into_clip_views(self, rows: Range<usize>, columns: Range<usize>) -> Result<Self, Error> {
        let (_, _, t, s, _) = self.samples.dim();
        range_within("view rows", &rows, t)?;
        range_within("view columns", &columns, s)?;
        let samples = self.samples.slice_axis_move(Axis(2), Slice::from(rows));
        Ok(Self::trusted(samples.slice_axis_move(Axis(3), Slice::from(columns))))
    }

    /// Keeps a rectangle of lenses, that is a piece of every view, and drops the others, without copying.
    ///
    /// # Shape
    ///
    /// Lens rows `rows` and lens columns `columns`; all views stay.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or reaches beyond the lenses.
    pub fn into_clip_lenses(self, rows: Range<usize>, columns: Range<usize>) -> Result<Self, Error> {
        let (v, u, ..) = self.samples.dim();
        range_within("lens rows", &rows, v)?;
        range_within("lens columns", &columns, u)?;
        let samples = self.samples.slice_axis_move(Axis(0), Slice::from(rows));
        Ok(Self::trusted(samples.slice_axis_move(Axis(1), Slice::from(columns))))
    }
}

impl<S: Data> LightField<S> {
    /// Returns a rectangle of views as a borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or reaches beyond the views.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, Split};
    /// use ndarray::Array3;
    ///
    /// let split = Split::new(GridSize::new(9, 9), GridSize::new(4, 5))?;
    /// let light_field = LightField::from_elemental_grid(Array3::<u8>::zeros((36, 45, 3)), split)?;
    /// let middle = light_field.clip_views(3..6, 3..6)?;
    /// assert_eq!(middle.split().views(), GridSize::new(3, 3));
    /// let copy = middle.to_owned();
    /// assert_eq!(copy, middle);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn clip_views(&self, rows: Range<usize>, columns: Range<usize>) -> Result<LightFieldView<'_, S::Elem>, Error> {
        self.borrowed().into_clip_views(rows, columns)
    }

    /// Returns a rectangle of lenses, that is a piece of every view, as a borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or reaches beyond the lenses.
    pub fn clip_lenses(&self, rows: Range<usize>, columns: Range<usize>) -> Result<LightFieldView<'_, S::Elem>, Error> {
        self.borrowed().into_clip_lenses(rows, columns)
    }

    /// Returns a piece of view `(t, s)`.
    ///
    /// # Shape
    ///
    /// `(v, u, c)`, with as many rows and columns as the ranges.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such view; [`Error::BadRange`] if a range is empty or reaches beyond the image.
    pub fn crop_view(
        &self,
        t: usize,
        s: usize,
        rows: Range<usize>,
        columns: Range<usize>,
    ) -> Result<ArrayView3<'_, S::Elem>, Error> {
        crop(self.view(t, s)?, rows, columns)
    }

    /// Returns a piece of the elemental image of lens `(v, u)`.
    ///
    /// # Shape
    ///
    /// `(t, s, c)`, with as many rows and columns as the ranges.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such lens; [`Error::BadRange`] if a range is empty or reaches beyond the image.
    pub fn crop_elemental(
        &self,
        v: usize,
        u: usize,
        rows: Range<usize>,
        columns: Range<usize>,
    ) -> Result<ArrayView3<'_, S::Elem>, Error> {
        crop(self.elemental(v, u)?, rows, columns)
    }
}

impl<S: DataMut> LightField<S> {
    /// Returns a rectangle of views as a mutably borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or reaches beyond the views.
    pub fn clip_views_mut(
        &mut self,
        rows: Range<usize>,
        columns: Range<usize>,
    ) -> Result<LightFieldViewMut<'_, S::Elem>, Error> {
        self.borrowed_mut().into_clip_views(rows, columns)
    }

    /// Returns a rectangle of lenses as a mutably borrowed light field.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or reaches beyond the lenses.
    pub fn clip_lenses_mut(
        &mut self,
        rows: Range<usize>,
        columns: Range<usize>,
    ) -> Result<LightFieldViewMut<'_, S::Elem>, Error> {
        self.borrowed_mut().into_clip_lenses(rows, columns)
    }
}

fn crop<T>(image: ArrayView3<'_, T>, rows: Range<usize>, columns: Range<usize>) -> Result<ArrayView3<'_, T>, Error> {
    range_within("image rows", &rows, image.dim().0)?;
    range_within("image columns", &columns, image.dim().1)?;
    let image = image.slice_axis_move(Axis(0), Slice::from(rows));
    Ok(image.slice_axis_move(Axis(1), Slice::from(columns)))
}
