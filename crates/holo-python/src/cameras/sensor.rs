//! Image sensors: codes of an image, and color of a mosaic.

use holo_core::sensor::{ColorFilter, Demosaic, ElectronsAtOne, sensor_presets};
use holo_dataset::DevelopJob;
use numpy::{PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::arrays::{give, give_json};
use crate::cameras::camera::PlenopticCamera;
use crate::failure::Failure;
use crate::options;

/// What decides the codes beside the image.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Exposing {
    sensor_model: Option<String>,
    camera: Option<PlenopticCamera>,
    electrons_at_one: Option<f64>,
    iso: Option<f64>,
    time_s: Option<f64>,
    camera_seed: u64,
    seed: u64,
    frame: u64,
    frames: u64,
    dark: bool,
}

/// The names of the sensors and their descriptions.
#[pyfunction]
pub fn names() -> Vec<(&'static str, &'static str)> {
    sensor_presets().iter().map(|preset| (preset.name, preset.description)).collect()
}

/// The codes that a sensor makes of linear light, axes (row, column, channel), and what they were made with.
#[pyfunction]
pub fn develop<'py>(
    py: Python<'py>,
    image: PyReadonlyArray3<'py, f32>,
    request: Exposing,
) -> Result<(Bound<'py, PyAny>, Bound<'py, PyAny>), Failure> {
    let mut job = DevelopJob::new("the image".into());
    (job.sensor, job.camera) = (request.sensor_model, request.camera.map(|camera| camera.0));
    job.electrons_at_one = request.electrons_at_one.map(ElectronsAtOne::Given);
    (job.iso, job.time_s, job.camera_seed) = (request.iso, request.time_s, request.camera_seed);
    (job.seed, job.frame, job.frames, job.is_dark) = (request.seed, request.frame, request.frames, request.dark);
    let image = image.as_array();
    let (codes, info) = py.detach(|| job.expose(image))?;
    let info = serde_json::to_value(&info).map_err(|why| Failure::Failed(why.to_string()))?;
    Ok((give(py, codes), give_json(py, &info)?))
}

/// A white image of a file, axes (row, column).
#[pyfunction]
pub fn read_white(py: Python<'_>, path: std::path::PathBuf) -> Result<Bound<'_, PyAny>, Failure> {
    let white = py.detach(|| holo_dataset::read_white(&path))?;
    Ok(give(py, white))
}

/// Three colors in every pixel of a mosaic, axes (row, column, channel).
#[pyfunction]
pub fn demosaic<'py>(
    py: Python<'py>,
    mosaic: PyReadonlyArray2<'py, f32>,
    filter: &str,
    method: &str,
) -> Result<Bound<'py, PyAny>, Failure> {
    let filters = ColorFilter::ALL.map(|filter| (filter.name(), filter));
    let filter = options::choice("filter", filter, &filters)?;
    let method = options::choice("method", method, &Demosaic::ALL.map(|method| (method.name(), method)))?;
    // The methods need rows without gaps.
    let mosaic = mosaic.as_array().as_standard_layout().into_owned();
    Ok(give(py, py.detach(|| holo_core::sensor::demosaic(mosaic.view(), filter, method))?))
}
