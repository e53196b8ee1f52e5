//! Descriptions of cameras and displays.

pub(crate) mod camera_file;
pub(crate) mod display_file;
pub(crate) mod parameters_cfg;
pub(crate) mod transforms;
