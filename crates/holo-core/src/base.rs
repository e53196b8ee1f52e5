//! What every room uses: sizes, kinds of samples, the color curve, memory, threads, text that is shown.

pub mod color;
pub(crate) mod error;
pub(crate) mod grid;
pub(crate) mod memory;
pub(crate) mod millimeters;
pub(crate) mod parallel;
pub(crate) mod real;
pub(crate) mod shown;
