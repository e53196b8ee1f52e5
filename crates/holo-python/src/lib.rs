//! The native part of the Python package `holo`: what the libraries do, on numpy arrays.
//!
//! Thin: arguments become those of the libraries, results become arrays and dictionaries. Classes, defaults and
//! documentation are in `python/holo`, which is what users import. Axes are (v, u, t, s, c) everywhere.
//!
//! While Rust works, other Python threads run. Renders run on a thread of their own, so that Ctrl-C stops them.
#![forbid(unsafe_code)]

mod arrays;
mod cameras;
mod failure;
mod files;
mod images;
mod options;
mod render;
mod scene;
mod score;
mod watch;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line `holo` and returns its exit code. Ends the process after help and malformed options.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| holo_cli::run(words))
}

#[pymodule]
fn _holo(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<cameras::rig::Rig>()?;
    module.add_class::<cameras::camera::PlenopticCamera>()?;
    module.add_class::<files::Reader>()?;
    module.add_class::<files::array::CameraFolder>()?;
    module.add_class::<files::display::Display>()?;
    let functions = [
        wrap_pyfunction!(main, module)?,
        wrap_pyfunction!(scene::gallery_names, module)?,
        wrap_pyfunction!(scene::gallery_glb, module)?,
        wrap_pyfunction!(scene::meshes_to_glb, module)?,
        wrap_pyfunction!(render::render, module)?,
        wrap_pyfunction!(render::render_folder, module)?,
        wrap_pyfunction!(cameras::rig::planned_rig, module)?,
        wrap_pyfunction!(images::to_grid, module)?,
        wrap_pyfunction!(images::to_linear, module)?,
        wrap_pyfunction!(images::automatic_exposure, module)?,
        wrap_pyfunction!(images::encode, module)?,
        wrap_pyfunction!(images::refocus, module)?,
        wrap_pyfunction!(images::synthesize, module)?,
        wrap_pyfunction!(images::plane_sweep, module)?,
        wrap_pyfunction!(images::png, module)?,
        wrap_pyfunction!(files::write_light_field, module)?,
        wrap_pyfunction!(files::write_hci, module)?,
        wrap_pyfunction!(files::export, module)?,
        wrap_pyfunction!(files::array::place_cameras, module)?,
        wrap_pyfunction!(files::export_targets, module)?,
        wrap_pyfunction!(score::benchmark::calibration_benchmark, module)?,
        wrap_pyfunction!(files::write_image, module)?,
        wrap_pyfunction!(files::read_image, module)?,
        wrap_pyfunction!(score::evaluate, module)?,
        wrap_pyfunction!(score::compare, module)?,
        wrap_pyfunction!(cameras::sensor::develop, module)?,
        wrap_pyfunction!(cameras::sensor::demosaic, module)?,
        wrap_pyfunction!(cameras::sensor::read_white, module)?,
        wrap_pyfunction!(cameras::sensor::names, module)?,
    ];
    functions.into_iter().try_for_each(|function| module.add_function(function))
}
