//! The rig and the equations between depth and disparity.

mod disparity;
mod double_double;
mod exact;
mod rig;
