//! Comparisons with other programs and other versions.

pub(crate) mod blender;
pub(crate) mod consumers;
pub(crate) mod renderers;
pub(crate) mod speed;
pub(crate) mod wild;
