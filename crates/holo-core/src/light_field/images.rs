//! Single views and elemental images, and iterators over them.

use ndarray::{ArrayView3, ArrayView5, ArrayViewMut3, ArrayViewMut5, Axis, Data, DataMut};
#[cfg(feature = "rayon")]
use rayon::prelude::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use super::LightField;
use crate::Error;
use crate::base::error::index_below;

impl<S: Data> LightField<S> {
    /// Returns view `(t, s)`, the viewpoint image or sub-aperture image, as a borrowed image.
    ///
    /// # Shape
    ///
    /// `(v, u, c)`: V rows, U columns.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such view.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, LightFieldShape};
    /// use ndarray::Array3;
    ///
    /// let shape = LightFieldShape::new(GridSize::new(2, 2), GridSize::new(3, 3))?;
    /// let light_field = LightField::from_elemental_grid(Array3::<u8>::zeros((6, 6, 3)), shape)?;
    /// assert_eq!(light_field.view(1, 1)?.dim(), (3, 3, 3));
    /// assert!(light_field.view(2, 0).is_err());
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn view(&self, t: usize, s: usize) -> Result<ArrayView3<'_, S::Elem>, Error> {
        self.check_view(t, s)?;
        Ok(view_at(&self.samples.view(), t, s).1)
    }

    /// Returns the elemental image (micro-image) of microlens `(v, u)` as a borrowed image.
    ///
    /// # Shape
    ///
    /// `(t, s, c)`: T rows, S columns.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such microlens.
    pub fn elemental_image(&self, v: usize, u: usize) -> Result<ArrayView3<'_, S::Elem>, Error> {
        self.check_lens(v, u)?;
        Ok(elemental_at(&self.samples.view(), v, u).1)
    }

    /// Returns all views row by row with their `(t, s)`.
    pub fn views(
        &self,
    ) -> impl ExactSizeIterator<Item = ((usize, usize), ArrayView3<'_, S::Elem>)> + DoubleEndedIterator {
        let samples = self.samples.view();
        let columns = samples.dim().3;
        (0..samples.dim().2 * columns).map(move |index| view_at(&samples, index / columns, index % columns))
    }

    /// Returns all elemental images row by row with their `(v, u)`.
    pub fn elemental_images(
        &self,
    ) -> impl ExactSizeIterator<Item = ((usize, usize), ArrayView3<'_, S::Elem>)> + DoubleEndedIterator {
        let samples = self.samples.view();
        let columns = samples.dim().1;
        (0..samples.dim().0 * columns).map(move |index| elemental_at(&samples, index / columns, index % columns))
    }

    /// Returns all views with their `(t, s)` as a parallel iterator.
    #[cfg(feature = "rayon")]
    pub fn par_views(&self) -> impl IndexedParallelIterator<Item = ((usize, usize), ArrayView3<'_, S::Elem>)>
    where
        S::Elem: Sync,
    {
        let samples = self.samples.view();
        let columns = samples.dim().3;
        (0..samples.dim().2 * columns)
            .into_par_iter()
            .map(move |index| view_at(&samples, index / columns, index % columns))
    }

    /// Returns all elemental images with their `(v, u)` as a parallel iterator.
    #[cfg(feature = "rayon")]
    pub fn par_elemental_images(&self) -> impl IndexedParallelIterator<Item = ((usize, usize), ArrayView3<'_, S::Elem>)>
    where
        S::Elem: Sync,
    {
        let samples = self.samples.view();
        let columns = samples.dim().1;
        (0..samples.dim().0 * columns)
            .into_par_iter()
            .map(move |index| elemental_at(&samples, index / columns, index % columns))
    }

    pub(super) fn check_view(&self, t: usize, s: usize) -> Result<(), Error> {
        index_below("view row", t, self.samples.dim().2)?;
        index_below("view column", s, self.samples.dim().3)
    }

    pub(super) fn check_lens(&self, v: usize, u: usize) -> Result<(), Error> {
        index_below("lens row", v, self.samples.dim().0)?;
        index_below("lens column", u, self.samples.dim().1)
    }
}

impl<S: DataMut> LightField<S> {
    /// Returns view `(t, s)` as a mutable image; the mutable form of [`LightField::view`].
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such view.
    pub fn view_mut(&mut self, t: usize, s: usize) -> Result<ArrayViewMut3<'_, S::Elem>, Error> {
        self.check_view(t, s)?;
        // The later axis first: removing an axis renumbers those behind it.
        Ok(self.samples.view_mut().index_axis_move(Axis(3), s).index_axis_move(Axis(2), t))
    }

    /// Returns the elemental image of microlens `(v, u)` as a mutable image; the mutable form of
    /// [`LightField::elemental_image`].
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such microlens.
    pub fn elemental_image_mut(&mut self, v: usize, u: usize) -> Result<ArrayViewMut3<'_, S::Elem>, Error> {
        self.check_lens(v, u)?;
        Ok(self.samples.view_mut().index_axis_move(Axis(1), u).index_axis_move(Axis(0), v))
    }

    /// Returns all views row by row, mutable, with their `(t, s)`.
    pub fn views_mut(&mut self) -> impl Iterator<Item = ((usize, usize), ArrayViewMut3<'_, S::Elem>)> {
        tiles_mut(self.samples.view_mut().permuted_axes([2, 3, 0, 1, 4]))
    }

    /// Returns all elemental images row by row, mutable, with their `(v, u)`.
    pub fn elemental_images_mut(&mut self) -> impl Iterator<Item = ((usize, usize), ArrayViewMut3<'_, S::Elem>)> {
        tiles_mut(self.samples.view_mut())
    }

    /// Returns all views, mutable, with their `(t, s)` as a parallel iterator.
    ///
    /// It allocates a list of the views, about a hundred bytes each.
    #[cfg(feature = "rayon")]
    pub fn par_views_mut(&mut self) -> impl IndexedParallelIterator<Item = ((usize, usize), ArrayViewMut3<'_, S::Elem>)>
    where
        S::Elem: Send,
    {
        self.views_mut().collect::<Vec<_>>().into_par_iter()
    }

    /// Returns all elemental images, mutable, with their `(v, u)` as a parallel iterator.
    ///
    /// It allocates a list of the images, about a hundred bytes each.
    #[cfg(feature = "rayon")]
    pub fn par_elemental_images_mut(
        &mut self,
    ) -> impl IndexedParallelIterator<Item = ((usize, usize), ArrayViewMut3<'_, S::Elem>)>
    where
        S::Elem: Send,
    {
        self.elemental_images_mut().collect::<Vec<_>>().into_par_iter()
    }
}

fn view_at<'a, T>(samples: &ArrayView5<'a, T>, t: usize, s: usize) -> ((usize, usize), ArrayView3<'a, T>) {
    // The copy of the view has the lifetime of the data. The later axis first: removing an axis renumbers those behind
    // it.
    ((t, s), samples.index_axis_move(Axis(3), s).index_axis_move(Axis(2), t))
}

fn elemental_at<'a, T>(samples: &ArrayView5<'a, T>, v: usize, u: usize) -> ((usize, usize), ArrayView3<'a, T>) {
    ((v, u), samples.index_axis_move(Axis(1), u).index_axis_move(Axis(0), v))
}

/// Splits an array along its first two axes, row by row.
fn tiles_mut<'a, T>(samples: ArrayViewMut5<'a, T>) -> impl Iterator<Item = ((usize, usize), ArrayViewMut3<'a, T>)> {
    let mut rows_left = Some(samples);
    let rows = std::iter::from_fn(move || {
        let rows = rows_left.take().filter(|rows| !rows.is_empty())?;
        let (first, rest) = rows.split_at(Axis(0), 1);
        rows_left = Some(rest);
        Some(first.index_axis_move(Axis(0), 0))
    });
    rows.enumerate().flat_map(|(row, tiles)| {
        let mut tiles_left = Some(tiles);
        let tiles = std::iter::from_fn(move || {
            let tiles = tiles_left.take().filter(|tiles| !tiles.is_empty())?;
            let (first, rest) = tiles.split_at(Axis(0), 1);
            tiles_left = Some(rest);
            Some(first.index_axis_move(Axis(0), 0))
        });
        tiles.enumerate().map(move |(column, tile)| ((row, column), tile))
    })
}
