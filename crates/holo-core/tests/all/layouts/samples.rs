//! Element types, shapes and strides for the property tests.

use holo_core::{GridSize, LightFieldShape};
use ndarray::{Array3, ArrayView3, Axis, Slice};
use proptest::prelude::*;

/// An element type with a bitwise comparison, which distinguishes NaN payloads and negative zeros.
pub trait Sample: Copy + Send + Sync + std::fmt::Debug + 'static {
    fn from_hash(hash: u64) -> Self;
    fn bits(self) -> u64;
}

macro_rules! sample {
    ($($type:ty: $from:expr, $bits:expr;)*) => {$(
        impl Sample for $type {
            fn from_hash(hash: u64) -> Self {
                ($from)(hash)
            }
            fn bits(self) -> u64 {
                ($bits)(self)
            }
        }
    )*};
}

sample! {
    u8: |hash| (hash >> 56) as u8, u64::from;
    u16: |hash| (hash >> 48) as u16, u64::from;
    half::f16: |hash: u64| half::f16::from_bits((hash >> 48) as u16), |value: half::f16| u64::from(value.to_bits());
    f32: |hash: u64| f32::from_bits((hash >> 32) as u32), |value: f32| u64::from(value.to_bits());
    f64: f64::from_bits, f64::to_bits;
}

/// A pseudo-random value for every index, the same in every run.
pub fn sample_at<T: Sample>(index: usize) -> T {
    // The finalizer of splitmix64: neighbors differ in all bits.
    let mut hash = (index as u64).wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    T::from_hash(hash ^ (hash >> 31))
}

pub fn image<T: Sample>(rows: usize, columns: usize, channels: usize) -> Array3<T> {
    Array3::from_shape_fn((rows, columns, channels), |(row, column, channel)| {
        sample_at((row * columns + column) * channels + channel)
    })
}

/// Bitwise equality of two images.
pub fn same<T: Sample>(left: ArrayView3<'_, T>, right: ArrayView3<'_, T>) -> bool {
    left.dim() == right.dim() && left.iter().zip(right.iter()).all(|(left, right)| left.bits() == right.bits())
}

/// Counts for edge cases: one, primes, and pairs that differ.
fn count() -> impl Strategy<Value = usize> {
    prop_oneof![2 => Just(1_usize), 3 => 2..=6_usize, 1 => Just(7), 1 => Just(11), 1 => Just(13)]
}

pub fn shapes() -> impl Strategy<Value = LightFieldShape> {
    (count(), count(), count(), count())
        .prop_map(|(t, s, v, u)| LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).unwrap())
}

pub fn channels() -> impl Strategy<Value = usize> {
    prop_oneof![Just(1_usize), Just(2), Just(3), Just(4), Just(5)]
}

/// The memory layout of an image.
#[derive(Debug, Clone, Copy)]
pub struct Strides {
    /// The axes that run backward.
    pub reversed: [bool; 3],
    /// The order of the axes in memory, slowest first.
    pub order: [usize; 3],
    /// The gap after each sample of an axis.
    pub step: usize,
}

impl Strides {
    pub const PLAIN: Self = Self { reversed: [false; 3], order: [0, 1, 2], step: 1 };
}

pub fn dense_strides() -> impl Strategy<Value = Strides> {
    (any::<[bool; 3]>(), Just([0, 1, 2]).prop_shuffle()).prop_map(|(reversed, order)| Strides {
        reversed,
        order,
        step: 1,
    })
}

pub fn any_strides() -> impl Strategy<Value = Strides> {
    (dense_strides(), 1..=3_usize).prop_map(|(strides, step)| Strides { step, ..strides })
}

/// Stores an image in memory with the given strides. [`arranged`] reads it back.
pub fn store<T: Sample>(image: &Array3<T>, strides: Strides) -> Array3<T> {
    let shape: [usize; 3] = image.dim().into();
    let stored = strides.order.map(|axis| shape[axis] * strides.step);
    let mut memory = Array3::from_elem(stored, sample_at::<T>(usize::MAX / 2));
    for ((row, column, channel), &value) in image.indexed_iter() {
        let index = [row, column, channel];
        let place = strides.order.map(|axis| {
            let index = if strides.reversed[axis] { shape[axis] - 1 - index[axis] } else { index[axis] };
            index * strides.step
        });
        memory[place] = value;
    }
    memory
}

/// The image that [`store`] stored, seen through permuted, reversed and stepping strides.
pub fn arranged<T>(memory: &Array3<T>, strides: Strides) -> ArrayView3<'_, T> {
    let mut view = memory.view();
    for axis in 0..3 {
        view.slice_axis_inplace(Axis(axis), Slice::new(0, None, strides.step as isize));
    }
    let mut back = [0; 3];
    for (position, &axis) in strides.order.iter().enumerate() {
        back[axis] = position;
    }
    let mut view = view.permuted_axes(back);
    for axis in (0..3).filter(|&axis| strides.reversed[axis]) {
        view.invert_axis(Axis(axis));
    }
    view
}
