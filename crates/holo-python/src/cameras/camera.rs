//! Plenoptic cameras.

use std::collections::BTreeMap;

use holo_core::GridSize;
use holo_core::plenoptic::{Calibration, presets};
use holo_io::CameraFile;
use holo_io::interop::LensletGridModel;
use ndarray::Array1;
use numpy::{PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{give, give_quantities};
use crate::cameras::rig::{Rig, Size, size};
use crate::failure::Failure;

/// A plenoptic camera: main lens, microlens array and sensor.
///
/// `PlenopticCamera.open("lytro-illum")` is a preset of `PlenopticCamera.presets()`, or a camera file in TOML, or the
/// `intrinsics.js` of COMPOTE.
#[pyclass(frozen, module = "holo", from_py_object)]
#[derive(Clone)]
pub struct PlenopticCamera(pub CameraFile);

#[pymethods]
impl PlenopticCamera {
    /// A preset by its name, or a camera file, focused and stopped down as given.
    #[staticmethod]
    #[pyo3(signature = (path_or_preset, *, focus_m=None, f_number=None))]
    fn open(path_or_preset: &str, focus_m: Option<f64>, f_number: Option<f64>) -> Result<Self, Failure> {
        adjusted(CameraFile::open(path_or_preset)?, focus_m, f_number)
    }

    /// A camera from the text of a camera file.
    #[staticmethod]
    #[pyo3(signature = (toml, name="camera"))]
    fn from_toml(toml: &str, name: &str) -> Result<Self, Failure> {
        Ok(Self(CameraFile::parse(toml, name)?))
    }

    /// The names of the presets and their descriptions.
    #[staticmethod]
    fn presets() -> BTreeMap<&'static str, &'static str> {
        presets().iter().map(|preset| (preset.name, preset.description)).collect()
    }

    /// The name of the camera.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Whether some numbers of the camera are guesses, because they are not published.
    #[getter]
    fn is_approximate(&self) -> bool {
        self.0.is_approximate
    }

    /// Pixels of the sensor, (rows, columns).
    #[getter]
    fn sensor(&self) -> Size {
        size(self.0.camera.sensor().size)
    }

    /// The camera as a camera file.
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    /// The same camera with another focus distance in meters or another f-number.
    #[pyo3(signature = (*, focus_m=None, f_number=None))]
    fn adjusted(&self, focus_m: Option<f64>, f_number: Option<f64>) -> Result<Self, Failure> {
        adjusted(self.0.clone(), focus_m, f_number)
    }

    /// The light of a scene of radiance 1, axes (row, column), float32.
    fn white_image<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        Ok(give(py, py.detach(|| self.0.camera.white_image())?))
    }

    /// The same camera with the microlens array that a white image shows, and how well it does; `None` without a lattice.
    fn calibrated<'py>(
        &self,
        py: Python<'py>,
        white: PyReadonlyArray2<'py, f32>,
    ) -> Result<Option<(Self, Fit)>, Failure> {
        let white = white.as_array();
        let found = py.detach(|| self.0.camera.calibrated(white))?;
        Ok(found.map(|found| {
            let fit = fit(&found);
            (Self(CameraFile { camera: found.camera, ..self.0.clone() }), fit)
        }))
    }

    /// An unknown camera, by the width of a pixel; `None` without a lattice.
    #[staticmethod]
    fn of_white_image<'py>(
        py: Python<'py>,
        white: PyReadonlyArray2<'py, f32>,
        pixel_m: f64,
    ) -> Result<Option<(Self, Fit)>, Failure> {
        let white = white.as_array();
        let found = py.detach(|| holo_core::plenoptic::PlenopticCamera::of_white_image(white, pixel_m))?;
        Ok(found.map(|found| {
            let (fit, name) = (fit(&found), "calibrated".to_owned());
            (Self(CameraFile { name, camera: found.camera, is_approximate: true, sensor_noise: None }), fit)
        }))
    }

    /// The centers of the micro-images: "row", "column" and "type" of the microlenses, int32, and "x", "y" in pixels, whose
    /// centers are at 0.5, float64.
    fn micro_images<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Failure> {
        let camera = &self.0.camera;
        let rows = 0..camera.sensor().size.rows;
        let lines = camera.lens_lines(rows.clone());
        let lenses: Vec<_> = lines.flat_map(|line| camera.lenses_on_line(line, rows.clone())).collect();
        let centers: Vec<[f64; 2]> = lenses.iter().map(|lens| camera.micro_image_center_px(*lens)).collect();
        let dict = PyDict::new(py);
        dict.set_item("row", give(py, lenses.iter().map(|lens| lens.row).collect::<Array1<i32>>()))?;
        dict.set_item("column", give(py, lenses.iter().map(|lens| lens.column).collect::<Array1<i32>>()))?;
        let types = lenses.iter().map(|lens| camera.array().type_of(*lens) as i32);
        dict.set_item("type", give(py, types.collect::<Array1<i32>>()))?;
        for (name, axis) in [("x", 0), ("y", 1)] {
            dict.set_item(name, give(py, centers.iter().map(|center| center[axis]).collect::<Array1<f64>>()))?;
        }
        Ok(dict)
    }

    /// The rig that the views are equivalent to, with `views` an axis.
    #[pyo3(signature = (views=None))]
    fn equivalent_rig(&self, views: Option<usize>) -> Result<Rig, Failure> {
        let camera = &self.0.camera;
        let views = views.map_or_else(|| camera.decodable_views(), Ok)?;
        if camera.has_rendered_views() {
            return Ok(Rig(camera.decoded_rig(views)?));
        }
        let pitch_m = camera.array().pitch_m;
        let pixels = camera.sensor().size;
        let across = |count: usize| (count as f64 / camera.micro_image_pitch_px()).floor().max(1.0) as usize;
        let lenses = GridSize::new(across(pixels.rows), across(pixels.columns));
        Ok(Rig(camera.equivalent_rig(GridSize::new(views, views), lenses, pitch_m, 1.0)?))
    }

    /// Properties as `holo optics --json` names them, and those of points at the depths in meters.
    #[pyo3(signature = (depths_m=Vec::new()))]
    fn optics<'py>(&self, py: Python<'py>, depths_m: Vec<f64>) -> Result<Bound<'py, PyAny>, Failure> {
        let rows = py.detach(|| holo_dataset::camera_optics(&self.0.camera, &depths_m))?;
        give_quantities(py, rows)
    }

    /// Scores the camera, which a calibration found, against the folder of `holo target` that `truth` names: as
    /// `holo eval-calibration --json` names it.
    fn score<'py>(&self, py: Python<'py>, truth: std::path::PathBuf) -> Result<Bound<'py, PyAny>, Failure> {
        let rows = py.detach(|| holo_dataset::calibration_score(&self.0, &truth))?;
        give_quantities(py, rows)
    }

    /// Scores a grid of micro-images, `*.grid.json` of LFToolbox, against the folder of `holo target` that `truth` names.
    #[staticmethod]
    fn score_grid<'py>(
        py: Python<'py>,
        grid: std::path::PathBuf,
        truth: std::path::PathBuf,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let rows = py.detach(|| {
            let grid = LensletGridModel::read(grid)?;
            holo_dataset::grid_score(&grid, &truth)
        })?;
        give_quantities(py, rows)
    }

    /// The camera that a raw image describes itself, if it does.
    #[staticmethod]
    fn of_raw(py: Python<'_>, raw: std::path::PathBuf) -> Result<Option<Self>, Failure> {
        Ok(py.detach(|| holo_dataset::camera_of_raw(&raw))?.map(Self))
    }

    /// Reads a raw image in linear light, axes (row, column, channel), with a white image for its colors.
    fn read_raw<'py>(
        &self,
        py: Python<'py>,
        raw: std::path::PathBuf,
        white: Option<PyReadonlyArray2<'py, f32>>,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let white = white.map(|white| white.as_array().to_owned());
        let image = py.detach(|| {
            let camera = &self.0.camera;
            let white = white.map_or_else(|| camera.white_image(), Ok)?;
            holo_dataset::read_raw(&raw, camera, &white)
        })?;
        Ok(give(py, image))
    }

    /// Decodes a raw image.
    fn decode_arrays<'py>(
        &self,
        py: Python<'py>,
        raw: PyReadonlyArray3<'py, f32>,
        white: Option<PyReadonlyArray2<'py, f32>>,
        views: Option<usize>,
        depth_m: Option<PyReadonlyArray2<'py, f32>>,
    ) -> Result<Views<'py>, Failure> {
        let camera = &self.0.camera;
        let views = views.map_or_else(|| camera.decodable_views(), Ok)?;
        let (raw, white) = (raw.as_array(), white.as_ref().map(|white| white.as_array()));
        let depth_m = depth_m.as_ref().map(|depth| depth.as_array());
        let decoded = py.detach(|| {
            let own = if white.is_none() { Some(camera.white_image()?) } else { None };
            let Some(white) = white.or_else(|| own.as_ref().map(|own| own.view())) else {
                return Err(holo_core::Error::ZeroCount { what: "white images" });
            };
            match depth_m {
                Some(depth_m) => camera.decode_along(raw, white, views, depth_m),
                None => camera.decode(raw, white, views),
            }
        })?;
        let (field, weight) = (decoded.light_field.into_samples(), decoded.weight.into_samples());
        let depth = decoded.depth_m.map(|depth| give(py, depth));
        Ok((give(py, field), give(py, weight), Rig(decoded.rig), decoded.roll_rad, depth))
    }

    fn __repr__(&self) -> String {
        let (rows, columns) = self.sensor();
        let approximate = if self.0.is_approximate { ", approximate" } else { "" };
        format!("<PlenopticCamera '{}': {columns} x {rows} px{approximate}>", self.0.name)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let make = py.get_type::<Self>().getattr("from_toml")?;
        Ok((make, (self.to_toml(), self.0.name.clone())))
    }
}

/// Radiance and weight, axes (v, u, t, s, c), the rig, the roll in radians, and of a focused camera the depth in meters, axes (v, u).
type Views<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Rig, f64, Option<Bound<'py, PyAny>>);

/// Number of micro-images, root mean square and largest distance in pixels, radii in pixels.
type Fit = (usize, f64, f64, Vec<f64>);

fn fit(found: &Calibration) -> Fit {
    (found.count, found.rms_px, found.largest_px, found.radii_px.clone())
}

fn adjusted(mut file: CameraFile, focus_m: Option<f64>, f_number: Option<f64>) -> Result<PlenopticCamera, Failure> {
    if let Some(focus_m) = focus_m {
        file = file.with_focus_m(focus_m)?;
    }
    if let Some(f_number) = f_number {
        file = file.with_f_number(f_number)?;
    }
    Ok(PlenopticCamera(file))
}
