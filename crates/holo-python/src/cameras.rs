//! Cameras: rigs, plenoptic cameras, arrays, sensors, displays.

pub(crate) mod camera;
pub(crate) mod rig;
pub(crate) mod sensor;
