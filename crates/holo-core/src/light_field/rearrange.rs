//! Eq. 4: from one layout to the other, the only place where one grid becomes the other.
//!
//! For a fixed lens row `v` and view row `t`, row `v*T + t` of the elemental grid and row `t*V + v` of the viewpoint grid hold the
//! same U*S pixels: the one as U groups of S, the other as S groups of U. The whole job is therefore V*T independent
//! transpositions of a single row each (24 KB in 8K RGB8), which fit the cache, and rows of the destination go to rayon's threads.

pub mod naive;
mod transpose;

use ndarray::{Array3, ArrayView3, ArrayViewMut2, ArrayViewMut3, Axis, Data, Slice};
use rayon::prelude::*;

use crate::light_field::checked_length;
use crate::{Error, LightField};
pub(crate) use transpose::Scratch;

/// Bytes below which a rearrangement stays on the calling thread: waking the others costs more than it saves.
const PARALLEL_BYTES: usize = 1 << 17;

/// Bytes of destination rows that one task of a parallel rearrangement moves at least.
const TASK_BYTES: usize = 1 << 18;

impl<S> LightField<S>
where
    S: Data,
    S::Elem: Copy + Send + Sync,
{
    /// Returns the elemental grid (the raw image behind the lenses) as a new image.
    ///
    /// # Shape
    ///
    /// `(V*T, U*S, C)`: row, column, channel.
    ///
    /// # Panics
    ///
    /// As any `Vec` does, when there is no memory for a copy of the samples. Their size never overflows: it was checked when the
    /// light field was made.
    ///
    /// # Source
    ///
    /// Eq. 4, the way back. [`naive::to_elemental_grid`] is the equation to the letter.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, Split};
    /// use ndarray::array;
    ///
    /// // Two views of one row of three pixels, a and b.
    /// let split = Split::new(GridSize::new(1, 2), GridSize::new(1, 3))?;
    /// let views = array![[['a'], ['b'], ['c'], ['A'], ['B'], ['C']]];
    /// let light_field = LightField::from_viewpoint_grid(views, split)?;
    /// assert_eq!(light_field.to_elemental_grid(), array![[['a'], ['A'], ['b'], ['B'], ['c'], ['C']]]);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    #[must_use]
    pub fn to_elemental_grid(&self) -> Array3<S::Elem> {
        let mut image = self.blank_grid();
        self.to_elemental_grid_into(image.view_mut()).expect("the image was made to measure");
        image
    }

    /// Returns the viewpoint grid (all views side by side) as a new image.
    ///
    /// # Shape
    ///
    /// `(T*V, S*U, C)`: row, column, channel.
    ///
    /// # Panics
    ///
    /// As [`LightField::to_elemental_grid`].
    ///
    /// # Source
    ///
    /// Eq. 4. [`naive::to_viewpoint_grid`] is the equation to the letter.
    #[must_use]
    pub fn to_viewpoint_grid(&self) -> Array3<S::Elem> {
        let mut image = self.blank_grid();
        self.to_viewpoint_grid_into(image.view_mut()).expect("the image was made to measure");
        image
    }

    /// Writes the elemental grid into an existing image of any strides.
    ///
    /// # Shape
    ///
    /// `(V*T, U*S, C)`: row, column, channel.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the image has another shape; it is then unchanged.
    pub fn to_elemental_grid_into(&self, image: ArrayViewMut3<'_, S::Elem>) -> Result<(), Error> {
        let (_, _, t, _, _) = self.samples().dim();
        self.fill_rows("elemental grid", image, |row| (row / t, row % t), fill_elemental_row)
    }

    /// Writes the viewpoint grid into an existing image of any strides.
    ///
    /// # Shape
    ///
    /// `(T*V, S*U, C)`: row, column, channel.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the image has another shape; it is then unchanged.
    pub fn to_viewpoint_grid_into(&self, image: ArrayViewMut3<'_, S::Elem>) -> Result<(), Error> {
        let (v, ..) = self.samples().dim();
        self.fill_rows("viewpoint grid", image, |row| (row % v, row / v), fill_viewpoint_row)
    }

    /// An image of the raw size. There is no safe way to leave it uninitialised, so it is filled with a sample.
    fn blank_grid(&self) -> Array3<S::Elem> {
        let (raw, samples) = (self.split().raw_size(), self.samples());
        let (sample, length) = (samples[[0, 0, 0, 0, 0]], samples.len());
        let memory = if length * size_of::<S::Elem>() < PARALLEL_BYTES {
            vec![sample; length]
        } else {
            // Most of the time goes into the first touch of each page, which the threads can share.
            rayon::iter::repeat_n(sample, length).collect()
        };
        Array3::from_shape_vec((raw.rows, raw.columns, self.channels()), memory).expect("the length is the product")
    }

    /// Fills every row of `image` from the samples `(u, s, c)` of the lens row and view row that `source` names for it.
    fn fill_rows(
        &self,
        what: &'static str,
        mut image: ArrayViewMut3<'_, S::Elem>,
        source: impl Fn(usize) -> (usize, usize) + Sync,
        fill: impl Fn(ArrayView3<'_, S::Elem>, ArrayViewMut2<'_, S::Elem>, &mut Scratch<S::Elem>) + Sync,
    ) -> Result<(), Error> {
        let (split, channels) = (self.split(), self.channels());
        let raw = split.raw_size();
        let expected = [raw.rows, raw.columns, channels];
        if image.shape() != expected {
            return Err(Error::Shape { what, expected: expected.to_vec(), found: image.shape().to_vec() });
        }
        let samples = self.samples();
        let fill_row = |scratch: &mut Scratch<S::Elem>, (row, destination): (usize, ArrayViewMut2<'_, S::Elem>)| {
            let (v, t) = source(row);
            // (v, u, t, s, c) without t and v is (u, s, c).
            fill(samples.index_axis(Axis(2), t).index_axis_move(Axis(0), v), destination, scratch);
        };
        let bytes = checked_length::<S::Elem>(&split, channels)? * size_of::<S::Elem>();
        let rows = image.axis_iter_mut(Axis(0));
        if bytes < PARALLEL_BYTES {
            let mut scratch = Scratch::new();
            rows.enumerate().for_each(|row| fill_row(&mut scratch, row));
        } else {
            let rows_per_task = (TASK_BYTES / (bytes / raw.rows).max(1)).max(1);
            rows.into_par_iter().enumerate().with_min_len(rows_per_task).for_each_init(Scratch::new, fill_row);
        }
        Ok(())
    }
}

/// Writes the samples `(u, s, c)` of one lens row and view row as a row of the elemental grid: U groups of S pixels.
fn fill_elemental_row<T: Copy>(samples: ArrayView3<'_, T>, row: ArrayViewMut2<'_, T>, scratch: &mut Scratch<T>) {
    fill_row(samples, row, scratch);
}

/// Writes the samples `(u, s, c)` of one lens row and view row as a row of the viewpoint grid: S groups of U pixels.
pub(crate) fn fill_viewpoint_row<T: Copy>(
    samples: ArrayView3<'_, T>,
    row: ArrayViewMut2<'_, T>,
    scratch: &mut Scratch<T>,
) {
    fill_row(samples.permuted_axes([1, 0, 2]), row, scratch);
}

/// Writes samples `(group, member, c)` one group after the other.
///
/// The destination is usually a slice, and the source is then one of three things: already in this order, in the other
/// order, or neither.
fn fill_row<T: Copy>(samples: ArrayView3<'_, T>, mut row: ArrayViewMut2<'_, T>, scratch: &mut Scratch<T>) {
    let (groups, members, channels) = samples.dim();
    if let Some(destination) = row.as_slice_mut() {
        if let Some(source) = samples.as_slice() {
            return destination.copy_from_slice(source);
        }
        let transposed = samples.view().permuted_axes([1, 0, 2]);
        if let Some(source) = transposed.as_slice() {
            return scratch.transpose(source, destination, [members, groups, channels]);
        }
        if transposed.outer_iter().all(|line| line.is_standard_layout()) {
            // A clip: lines without gaps, with gaps between them.
            return scratch.transpose_lines(transposed, destination);
        }
    }
    // The way that is right for any strides and fast for none.
    for (group, samples) in samples.outer_iter().enumerate() {
        row.slice_axis_mut(Axis(0), Slice::from(group * members..(group + 1) * members)).assign(&samples);
    }
}
