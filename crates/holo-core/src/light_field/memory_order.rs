//! The axes of an array in the order of its memory.

use ndarray::{Array5, ArrayBase, ArrayView5, Axis, Dim, Dimension, IntoDimension, RawData};

use crate::Error;
use crate::base::memory::collected;

/// Where the axes of an array with its axes in memory order come from.
pub(super) struct MemoryOrder<const N: usize> {
    /// Entry `n` is the original axis that is now axis `n`.
    pub(super) axes: [usize; N],
    /// Whether an original axis ran backward in memory.
    pub(super) reversed: [bool; N],
}

/// Turns axes that run backward in memory forward and sorts all axes by their strides, the longest first.
///
/// An array without gaps is then in standard layout. No sample moves.
pub(super) fn sorted<S: RawData, const N: usize>(
    mut array: ArrayBase<S, Dim<[usize; N]>>,
) -> (ArrayBase<S, Dim<[usize; N]>>, MemoryOrder<N>)
where
    Dim<[usize; N]>: Dimension,
    [usize; N]: IntoDimension<Dim = Dim<[usize; N]>>,
{
    let reversed: [bool; N] = std::array::from_fn(|axis| array.strides()[axis] < 0);
    for axis in (0..N).filter(|&axis| reversed[axis]) {
        array.invert_axis(Axis(axis));
    }
    let mut axes: [usize; N] = std::array::from_fn(|axis| axis);
    // An axis of length 1 may have any stride. Behind the longer axes of equal stride it does not separate them.
    axes.sort_by_key(|&axis| std::cmp::Reverse((array.strides()[axis], array.shape()[axis])));
    (array.permuted_axes(axes), MemoryOrder { axes, reversed })
}

/// The permutation that undoes another.
pub(super) fn inverse<const N: usize>(axes: [usize; N]) -> [usize; N] {
    let mut inverse = [0; N];
    for (position, &axis) in axes.iter().enumerate() {
        inverse[axis] = position;
    }
    inverse
}

/// The results of a function of every sample: in the memory order of the samples if they have no gaps, else in index
/// order.
///
/// # Errors
///
/// [`Error::OutOfMemory`] if the allocation fails.
pub(super) fn map<T, U>(samples: ArrayView5<'_, T>, function: impl FnMut(&T) -> U) -> Result<Array5<U>, Error> {
    const WHAT: &str = "a light field";
    let (ordered, order) = sorted(samples);
    let Some(slice) = ordered.as_slice() else {
        let memory = collected(WHAT, samples.iter().map(function))?;
        return Ok(Array5::from_shape_vec(samples.raw_dim(), memory).expect("one result a sample"));
    };
    let memory = collected(WHAT, slice.iter().map(function))?;
    let ordered = Array5::from_shape_vec(ordered.raw_dim(), memory).expect("one result a sample");
    let mut results = ordered.permuted_axes(inverse(order.axes));
    for axis in (0..5).filter(|&axis| order.reversed[axis]) {
        results.invert_axis(Axis(axis));
    }
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_keep_the_strides_of_arrays_without_gaps() {
        let array = Array5::from_shape_fn((2, 3, 4, 5, 2), |(a, b, c, d, e)| (((a * 3 + b) * 4 + c) * 5 + d) * 2 + e);
        let mut turned = array.view().permuted_axes([3, 0, 4, 1, 2]);
        turned.invert_axis(Axis(1));
        turned.invert_axis(Axis(4));
        let copy = map(turned, |&sample| sample as u16).unwrap();
        assert_eq!(copy.strides(), turned.strides());
        assert_eq!(copy, turned.mapv(|sample| sample as u16));
        // A single view: axes of length 1 with long strides.
        let single = array.slice_axis(Axis(2), (1..2).into()).slice_axis_move(Axis(3), (2..3).into());
        assert_eq!(map(single, |&sample| sample).unwrap(), single);
    }

    #[test]
    fn arrays_with_gaps_are_copied_in_index_order() {
        let array = Array5::from_shape_fn((4, 3, 4, 5, 1), |(a, b, c, d, _)| ((a * 3 + b) * 4 + c) * 5 + d);
        let mut part = array.slice_axis(Axis(0), (1..3).into()).slice_axis_move(Axis(2), (1..3).into());
        part.invert_axis(Axis(1));
        let part = part.permuted_axes([1, 0, 3, 2, 4]);
        let copy = map(part, |&sample| sample).unwrap();
        assert!(copy.is_standard_layout() && copy == part);
        let repeated = array.slice_axis(Axis(0), (..1).into());
        let repeated = repeated.broadcast((6, 3, 4, 5, 1)).unwrap();
        assert_eq!(map(repeated, |&sample| sample).unwrap(), repeated);
    }
}
