//! SIMD by arrays of sixteen lanes, compiled for several instruction sets.
//!
//! Hot code is written as loops over the lanes of plain arrays, which the compiler vectorizes for the instruction set
//! of its kernel ([`Kernel`]). **May import:** nothing.

pub(crate) mod angles;
#[allow(unsafe_code, reason = "calls functions compiled for AVX2 and AVX-512 after a check of the processor")]
mod dispatch;

#[cfg(test)]
pub(crate) use dispatch::run_on_all;
pub(crate) use dispatch::{Kernel, run};

/// Lanes of a packet: the number of rays that are traced together.
pub(crate) const LANES: usize = 16;

/// One value per lane, with the alignment that Embree requires.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes<T>(pub [T; LANES]);

/// One lane of an array of vectors. (Closures such as those of `array::map` are not compiled for the instruction set of
/// the kernel, so hot code uses loops and this function.)
#[inline(always)]
pub(crate) fn at<const N: usize>(field: &[[f32; LANES]; N], lane: usize) -> [f32; N] {
    let mut out = [0.0; N];
    for k in 0..N {
        out[k] = field[k][lane];
    }
    out
}

/// The number of valid lanes.
#[inline(always)]
pub(crate) fn count(valid: &Lanes<i32>) -> u64 {
    let mut count = 0;
    for lane in 0..LANES {
        count -= valid.0[lane];
    }
    count as u64
}
