//! Sixteen values side by side, and code that is compiled for several instruction sets.
//!
//! Hot code is written as loops over the lanes of plain arrays, which the compiler vectorizes for the instruction set of its
//! kernel ([`Kernel`]). **May enter:** nothing.

pub(crate) mod angles;
#[allow(unsafe_code)]
mod dispatch;

#[cfg(test)]
pub(crate) use dispatch::run_on_all;
pub(crate) use dispatch::{Kernel, run};

/// Rays in a packet.
pub(crate) const LANES: usize = 16;

/// One value a ray, aligned as Embree wants it.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes<T>(pub [T; LANES]);

/// One lane of a vector field. (Closures such as those of `array::map` are not compiled for the kernel's instruction set;
/// hot code is written with loops and with this.)
#[inline(always)]
pub(crate) fn at(field: &[[f32; LANES]; 3], lane: usize) -> [f32; 3] {
    [field[0][lane], field[1][lane], field[2][lane]]
}

/// Valid lanes.
#[inline(always)]
pub(crate) fn count(valid: &Lanes<i32>) -> u64 {
    let mut count = 0;
    for lane in 0..LANES {
        count -= valid.0[lane];
    }
    count as u64
}
