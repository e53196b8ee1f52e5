//! Arrays of any strides in column-major order, without a second copy of the whole array.
//!
//! The first index runs fastest in MATLAB, the last in ndarray, and a raw image has yet another order. A copy in the
//! order of the file, one element at a time, would access a new cache line for each element. So the array is divided
//! into slabs of a few megabytes that are contiguous in the file, and each slab is copied in square tiles, which use
//! whole cache lines in both orders. Slabs are copied in parallel.

use ndarray::{ArrayViewD, ArrayViewMutD, Axis, Dimension, Ix2, IxDyn, Slice};
use rayon::prelude::*;

/// Wanted size of a slab in bytes.
const SLAB_BYTES: usize = 4 << 20;

/// Maximum size of a slab in bytes, for longer runs in the order of the array.
const MAX_SLAB_BYTES: usize = 32 << 20;

/// Side of a tile; also the minimum run in the order of the array that is wanted.
const TILE: usize = 32;

/// A slab of the reversed array: the first `outer.len()` axes have these indices, the next runs from `start` to `end`,
/// and the others are complete.
#[derive(Debug)]
pub(crate) struct Slab {
    pub(crate) outer: Vec<usize>,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

/// The division of an array into slabs. Axes are those of the reversed array, the last of which runs fastest in the
/// file.
pub(crate) struct Plan {
    /// The axis along which slabs divide the array.
    pub(crate) axis: usize,
    /// Number of indices of that axis in one slab.
    pub(crate) step: usize,
    /// The axis of the tiles besides the last: that of the smallest stride whose slabs are not too large.
    near: usize,
}

/// Passes the elements of `array` to `take` in column-major order, one slab after another; `prepare` processes slabs in
/// parallel.
///
/// # Errors
///
/// The first error of `take`.
pub(crate) fn column_major<T, P, E>(
    array: &ArrayViewD<'_, T>,
    prepare: impl Fn(&[T]) -> P + Sync,
    mut take: impl FnMut(P) -> Result<(), E>,
) -> Result<(), E>
where
    T: Copy + Default + Send + Sync,
    P: Send,
{
    let reversed = array.view().reversed_axes();
    if reversed.ndim() == 0 {
        return reversed.iter().try_for_each(|&value| take(prepare(&[value])));
    }
    Plan::new(reversed.shape(), reversed.strides(), size_of::<T>()).run(&reversed, prepare, |_, slab| take(slab))
}

impl Plan {
    /// Plans the slabs of an array of at least one axis.
    pub(crate) fn new(shape: &[usize], strides: &[isize], element_bytes: usize) -> Self {
        let last = shape.len() - 1;
        let inside = |axis: usize| shape[axis + 1..].iter().product::<usize>() * element_bytes;
        let mut by_stride: Vec<usize> = (0..shape.len()).filter(|&axis| shape[axis] > 1).collect();
        by_stride.sort_by_key(|&axis| strides[axis].unsigned_abs());
        // The smallest stride whose slabs are not too large; the last axis is always possible.
        let near = by_stride
            .into_iter()
            .find(|&axis| inside(axis).saturating_mul(shape[axis].min(TILE)) <= MAX_SLAB_BYTES)
            .unwrap_or(last);
        let mut axis = near;
        while axis > 0 && shape[axis] * inside(axis) < SLAB_BYTES / 4 {
            axis -= 1;
        }
        let least = if axis == near { TILE } else { 1 };
        let step = (SLAB_BYTES / inside(axis).max(1)).max(least).clamp(1, shape[axis].max(1));
        Self { axis, step, near }
    }

    /// Passes all slabs to `take` in order, gathered and prepared in parallel.
    pub(crate) fn run<T, P, E>(
        &self,
        reversed: &ArrayViewD<'_, T>,
        prepare: impl Fn(&[T]) -> P + Sync,
        mut take: impl FnMut(&Slab, P) -> Result<(), E>,
    ) -> Result<(), E>
    where
        T: Copy + Default + Send + Sync,
        P: Send,
    {
        if reversed.is_empty() {
            return Ok(());
        }
        for batch in self.slabs(reversed.shape()).chunks(rayon::current_num_threads().clamp(1, 8)) {
            let prepared: Vec<P> = batch.par_iter().map(|slab| prepare(&gather(reversed, self, slab))).collect();
            batch.iter().zip(prepared).try_for_each(|(slab, prepared)| take(slab, prepared))?;
        }
        Ok(())
    }

    fn slabs(&self, shape: &[usize]) -> Vec<Slab> {
        let outer = IxDyn(&shape[..self.axis]);
        let mut slabs = Vec::new();
        for index in ndarray::indices(outer) {
            for start in (0..shape[self.axis]).step_by(self.step) {
                let end = shape[self.axis].min(start + self.step);
                slabs.push(Slab { outer: index.slice().to_vec(), start, end });
            }
        }
        slabs
    }
}

/// Copies a slab in the order of the file.
fn gather<T: Copy + Default>(reversed: &ArrayViewD<'_, T>, plan: &Plan, slab: &Slab) -> Vec<T> {
    let mut source = reversed.view();
    for &index in &slab.outer {
        source.index_axis_inplace(Axis(0), index);
    }
    source.slice_axis_inplace(Axis(0), Slice::from(slab.start..slab.end));
    let mut values = vec![T::default(); source.len()];
    // `values` was made with the length of `source`, so the shape cannot disagree.
    let target = ArrayViewMutD::from_shape(source.raw_dim(), &mut values).expect("as many as the shape has");
    tiles(source, target, plan.near - plan.axis);
    values
}

/// Copies an array into another of the same shape, tile by tile over the axis `near` and the last.
fn tiles<T: Copy>(source: ArrayViewD<'_, T>, mut target: ArrayViewMutD<'_, T>, near: usize) {
    match source.ndim() {
        0 | 1 => target.assign(&source),
        2 if near == 0 => {
            let (Ok(source), Ok(mut target)) =
                (source.into_dimensionality::<Ix2>(), target.into_dimensionality::<Ix2>())
            else {
                unreachable!("both have two axes")
            };
            for (source, mut target) in
                source.axis_chunks_iter(Axis(0), TILE).zip(target.axis_chunks_iter_mut(Axis(0), TILE))
            {
                for (source, mut target) in
                    source.axis_chunks_iter(Axis(1), TILE).zip(target.axis_chunks_iter_mut(Axis(1), TILE))
                {
                    target.assign(&source);
                }
            }
        }
        // Slice by slice along the first axis that is not one of the two.
        _ => {
            let (axis, near) = if near == 0 { (1, 0) } else { (0, near - 1) };
            for (source, target) in source.axis_iter(Axis(axis)).zip(target.axis_iter_mut(Axis(axis))) {
                tiles(source, target, near);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{ArrayD, ShapeBuilder};
    use proptest::prelude::*;

    use super::*;

    fn check(array: &ArrayViewD<'_, u16>) {
        let mut taken = Vec::new();
        let outcome: Result<(), ()> = column_major(array, <[u16]>::to_vec, |slab| {
            taken.extend(slab);
            Ok(())
        });
        assert_eq!(outcome, Ok(()));
        // The reference implementation: the iterator of ndarray over the reversed axes.
        assert!(taken.iter().eq(array.t().iter()), "{:?} {:?}", array.shape(), array.strides());
    }

    proptest! {
        #[test]
        fn any_shape_and_strides(
            shape in prop::collection::vec(1_usize..9, 0..6),
            seed in any::<u64>(),
        ) {
            let axes = shape.len();
            let array = ArrayD::from_shape_fn(IxDyn(&shape), |index| {
                index.slice().iter().fold(7_usize, |sum, &at| sum * 31 + at) as u16
            });
            let mut order: Vec<usize> = (0..axes).collect();
            for at in (1..axes).rev() {
                order.swap(at, (seed >> (5 * at)) as usize % (at + 1));
            }
            let mut view = array.view().permuted_axes(order);
            for axis in 0..axes {
                match seed >> (40 + 3 * axis) & 7 {
                    0 => view.invert_axis(Axis(axis)),
                    1 => view.slice_axis_inplace(Axis(axis), Slice::new(0, None, 2)),
                    2 => view.slice_axis_inplace(Axis(axis), Slice::from(view.len_of(Axis(axis)) / 2..)),
                    _ => {}
                }
            }
            check(&view);
        }
    }

    #[test]
    fn arrays_of_many_slabs() {
        for (shape, order) in [
            // Lens rows, lens columns, view rows, view columns, channels of an elemental grid, a viewpoint grid, and
            // neither.
            ([31, 40, 33, 35, 3], [0, 2, 1, 3, 4]),
            ([31, 40, 33, 35, 3], [2, 0, 3, 1, 4]),
            ([31, 40, 33, 35, 3], [4, 3, 2, 1, 0]),
            ([31, 40, 33, 35, 1], [4, 2, 0, 3, 1]),
            ([1, 1, 2100, 2000, 1], [0, 1, 2, 3, 4]),
            ([5, 1, 1, 1, 900_001], [0, 1, 2, 3, 4]),
        ] {
            let memory: [usize; 5] = std::array::from_fn(|at| shape[order[at]]);
            let count = memory.iter().product::<usize>();
            let array = ArrayD::from_shape_vec(IxDyn(&memory), (0..count).map(|at| (at * 7 % 65_521) as u16).collect());
            let mut back = [0; 5];
            (0..5).for_each(|at| back[order[at]] = at);
            check(&array.unwrap().view().permuted_axes(IxDyn(&back)));
        }
        let column_major = ArrayD::from_shape_fn(vec![300, 70, 90].f(), |at| (at[0] * 3 + at[1] * 5 + at[2]) as u16);
        check(&column_major.view());
    }
}
