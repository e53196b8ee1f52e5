//! Eq. 4: elemental grid to viewpoint grid and back.
//!
//! For a fixed lens row `v` and view row `t`, row `v*T + t` of the elemental grid and row `t*V + v` of the viewpoint
//! grid hold the same U*S pixels: the former as U groups of S, the latter as S groups of U. The rearrangement is V*T
//! independent transpositions of a single row (24 KB for 8K RGB8). A row fits the cache, and rayon's threads share the
//! rows of the destination.

pub mod naive;
mod transpose;

use crate::base::parallel::*;
use ndarray::{Array3, ArrayView3, ArrayViewMut2, ArrayViewMut3, Axis, Data, Slice};

use crate::base::memory::{filled, reserved};
use crate::light_field::checked_length;
use crate::{Error, LightField};
pub(crate) use transpose::Scratch;

/// Bytes below which a rearrangement stays on the calling thread, because waking others would take longer.
const PARALLEL_BYTES: usize = 1 << 17;

/// The least number of bytes of destination rows that one task of a parallel rearrangement moves.
const TASK_BYTES: usize = 1 << 18;

impl<S> LightField<S>
where
    S: Data,
    S::Elem: Copy + Send + Sync,
{
    /// Returns a copy of the elemental grid: the elemental image array, the raw image behind the microlenses.
    ///
    /// # Shape
    ///
    /// `(V*T, U*S, C)`: row, column, channel.
    ///
    /// # Accuracy
    ///
    /// Exact: samples are only moved.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the allocation of the image fails.
    ///
    /// # Source
    ///
    /// Eq. 4, inverted. [`naive::to_elemental_grid`] is its reference implementation.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, LightFieldShape};
    /// use ndarray::array;
    ///
    /// // Two views of one row of three pixels, a and b.
    /// let shape = LightFieldShape::new(GridSize::new(1, 2), GridSize::new(1, 3))?;
    /// let views = array![[['a'], ['b'], ['c'], ['A'], ['B'], ['C']]];
    /// let light_field = LightField::from_viewpoint_grid(views, shape)?;
    /// assert_eq!(light_field.to_elemental_grid()?, array![[['a'], ['A'], ['b'], ['B'], ['c'], ['C']]]);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn to_elemental_grid(&self) -> Result<Array3<S::Elem>, Error> {
        let mut image = self.grid_memory("an elemental grid")?;
        self.to_elemental_grid_into(image.view_mut())?;
        Ok(image)
    }

    /// Returns a copy of the viewpoint grid: the sub-aperture image array, all views side by side.
    ///
    /// # Shape
    ///
    /// `(T*V, S*U, C)`: row, column, channel.
    ///
    /// # Accuracy
    ///
    /// Exact: samples are only moved.
    ///
    /// # Errors
    ///
    /// As [`LightField::to_elemental_grid`].
    ///
    /// # Source
    ///
    /// Eq. 4. [`naive::to_viewpoint_grid`] is its reference implementation.
    pub fn to_viewpoint_grid(&self) -> Result<Array3<S::Elem>, Error> {
        let mut image = self.grid_memory("a viewpoint grid")?;
        self.to_viewpoint_grid_into(image.view_mut())?;
        Ok(image)
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
        self.fill_rows("elemental grid", image, |row| (row / t, row % t), fill_row)
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

    /// An image of the raw size that is filled with the first sample, because safe code cannot leave it uninitialized.
    fn grid_memory(&self, what: &'static str) -> Result<Array3<S::Elem>, Error> {
        let (raw, samples) = (self.shape().raw_size(), self.samples());
        let (sample, length) = (samples[[0, 0, 0, 0, 0]], samples.len());
        let memory = if length * size_of::<S::Elem>() < PARALLEL_BYTES {
            filled(what, length, sample)?
        } else {
            // The first write to a page takes longer than the copies. Here all threads share those writes.
            let mut memory = reserved(what, length)?;
            #[cfg(feature = "rayon")]
            memory.par_extend(rayon::iter::repeat_n(sample, length));
            #[cfg(not(feature = "rayon"))]
            memory.resize(length, sample);
            memory
        };
        Ok(Array3::from_shape_vec((raw.rows, raw.columns, self.channels()), memory).expect("the length is the product"))
    }

    /// Fills every row of `image` from the samples `(u, s, c)` of the lens row and view row that `source` names for it.
    fn fill_rows(
        &self,
        what: &'static str,
        mut image: ArrayViewMut3<'_, S::Elem>,
        source: impl Fn(usize) -> (usize, usize) + Sync,
        fill: impl Fn(ArrayView3<'_, S::Elem>, ArrayViewMut2<'_, S::Elem>, &mut Scratch<S::Elem>) + Sync,
    ) -> Result<(), Error> {
        let (shape, channels) = (self.shape(), self.channels());
        let raw = shape.raw_size();
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
        let bytes = checked_length::<S::Elem>(&shape, channels)? * size_of::<S::Elem>();
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

/// Writes the samples `(u, s, c)` of one lens row and view row as a row of the viewpoint grid: S groups of U pixels.
pub(crate) fn fill_viewpoint_row<T: Copy>(
    samples: ArrayView3<'_, T>,
    row: ArrayViewMut2<'_, T>,
    scratch: &mut Scratch<T>,
) {
    fill_row(samples.permuted_axes([1, 0, 2]), row, scratch);
}

/// Writes samples `(group, member, c)` group by group.
///
/// If the destination is a slice, a source in this order is copied and a source in the other order is transposed in the
/// cache. All other cases take the general loop.
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
            // A clip of the views or microlenses: lines without gaps, with gaps between them.
            return scratch.transpose_lines(transposed, destination);
        }
    }
    // Correct for any strides.
    for (group, samples) in samples.outer_iter().enumerate() {
        row.slice_axis_mut(Axis(0), Slice::from(group * members..(group + 1) * members)).assign(&samples);
    }
}
