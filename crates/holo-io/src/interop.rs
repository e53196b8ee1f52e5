//! Calibrations of plenoptic cameras as the files of other programs.

mod lftoolbox;
mod libpleno;
mod lytro;
mod pip;
mod plenopticam;
mod plenpy;
mod raytrix;

use holo_core::plenoptic::{MicrolensIndex, PlenopticCamera};

pub use lftoolbox::LensletGridModel;
pub use libpleno::{BoardCorner, Libpleno};
pub use lytro::{LytroImage, LytroModel};
pub use pip::pip_configuration;
pub use plenopticam::plenopticam_calibration;
pub use plenpy::plenpy_files;
pub use raytrix::raytrix_calibration;

/// The micro-images whose centers lie on the sensor, with those centers in pixels from the upper left corner, row by row.
#[must_use]
pub fn micro_images(camera: &PlenopticCamera) -> Vec<(MicrolensIndex, [f64; 2])> {
    let size = camera.sensor().size;
    let is_on_sensor = |[x, y]: [f64; 2]| x >= 0.0 && y >= 0.0 && x < size.columns as f64 && y < size.rows as f64;
    let mut all: Vec<(MicrolensIndex, [f64; 2])> = camera
        .lens_lines(0..size.rows)
        .flat_map(|line| camera.lenses_on_line(line, 0..size.rows).collect::<Vec<_>>())
        .map(|lens| (lens, camera.micro_image_center_px(lens)))
        .filter(|(_, center)| is_on_sensor(*center))
        .collect();
    all.sort_by_key(|(lens, _)| *lens);
    all
}
