//! Rigs: where the views are, and what they see.

use std::collections::BTreeMap;

use holo_core::optics::{DepthRange, Optics};
use holo_core::{Disparity, GridSize, Intrinsics, LightFieldShape, Projection};
use holo_dataset::Camera;
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{give, give_quantities};
use crate::failure::Failure;
use crate::options;

/// Rows and columns.
pub type Size = (usize, usize);

pub fn size(size: GridSize) -> Size {
    (size.rows, size.columns)
}

/// A grid of cameras: pinholes in a plane that look the same way, with sensors shifted so that they agree at the focus
/// distance.
///
/// `views` are (rows T, columns S), `lenses` are (rows V, columns U), the pixels of a view. Lengths are in meters.
#[pyclass(frozen, module = "holo", from_py_object)]
#[derive(Clone)]
pub struct Rig(pub holo_core::Rig);

#[pymethods]
impl Rig {
    #[new]
    #[pyo3(signature = (views, lenses, *, focal_length_m, sensor_size_m=0.036, baseline_m, baseline_y_m=None,
        focus_distance_m=f64::INFINITY, projection="perspective"))]
    #[allow(clippy::too_many_arguments, reason = "the keywords of a constructor")]
    fn new(
        views: Size,
        lenses: Size,
        focal_length_m: f64,
        sensor_size_m: f64,
        baseline_m: f64,
        baseline_y_m: Option<f64>,
        focus_distance_m: f64,
        projection: &str,
    ) -> Result<Self, Failure> {
        let shape = LightFieldShape::new(GridSize::new(views.0, views.1), GridSize::new(lenses.0, lenses.1))?;
        let choices = [("perspective", Projection::Perspective), ("orthographic", Projection::Orthographic)];
        let rig = holo_core::Rig::builder(shape)
            .intrinsics(Intrinsics { focal_length_m, sensor_size_m })
            .baseline_x_m(baseline_m)
            .baseline_y_m(baseline_y_m.unwrap_or(baseline_m))
            .focus_distance_m(focus_distance_m)
            .projection(options::choice("projection", projection, &choices)?);
        Ok(Self(rig.build()?))
    }

    /// Views, (rows T, columns S).
    #[getter]
    fn views(&self) -> Size {
        size(self.0.shape().views())
    }

    /// Microlenses, which are the pixels of a view: (rows V, columns U).
    #[getter]
    fn lenses(&self) -> Size {
        size(self.0.shape().lenses())
    }

    /// Focal length, m.
    #[getter]
    fn focal_length_m(&self) -> f64 {
        self.0.focal_length_m()
    }

    /// Size of the larger image side on the sensor, m.
    #[getter]
    fn sensor_size_m(&self) -> f64 {
        self.0.sensor_size_m()
    }

    /// Distance between horizontally adjacent views, m.
    #[getter]
    fn baseline_m(&self) -> f64 {
        self.0.baseline_x_m()
    }

    /// Distance between vertically adjacent views, m.
    #[getter]
    fn baseline_y_m(&self) -> f64 {
        self.0.baseline_y_m()
    }

    /// Distance of the plane whose disparity is 0, m; may be infinite.
    #[getter]
    fn focus_distance_m(&self) -> f64 {
        self.0.focus_distance_m()
    }

    /// "perspective" or "orthographic".
    #[getter]
    fn projection(&self) -> &'static str {
        match self.0.projection() {
            Projection::Perspective => "perspective",
            Projection::Orthographic => "orthographic",
        }
    }

    /// Disparity in pixels between horizontally adjacent views of a depth along the optical axis in meters (Eq. 3);
    /// numbers or arrays of any shape, float64.
    fn disparity_from_depth<'py>(&self, py: Python<'py>, depth_m: Numbers<'py>) -> Bound<'py, PyAny> {
        self.convert(py, &depth_m, Disparity::from_depth_m)
    }

    /// Depth along the optical axis in meters of a disparity in pixels, the inverse of `disparity_from_depth`.
    fn depth_from_disparity<'py>(&self, py: Python<'py>, disparity_px: Numbers<'py>) -> Bound<'py, PyAny> {
        self.convert(py, &disparity_px, Disparity::to_depth_m)
    }

    /// Origin and direction of the ray of the place (jx, jy) in [0, 1) x [0, 1) of the pixel (v, u) of the view (t, s),
    /// in the coordinates of the rig: x right, y up, and -z into the scene; m. The direction is 1 long along the axis.
    #[pyo3(signature = (v, u, t, s, jx=0.5, jy=0.5))]
    #[allow(clippy::many_single_char_names, reason = "the axes of a light field")]
    fn ray(&self, v: usize, u: usize, t: usize, s: usize, jx: f64, jy: f64) -> ([f64; 3], [f64; 3]) {
        let ray = self.0.ray(v, u, t, s, jx, jy);
        (ray.origin_m, ray.direction)
    }

    /// Where the view (t, s) sees a point in the coordinates of the rig: (row, column) in pixels, whose centers are at
    /// 0.5; None behind the camera.
    fn project(&self, point_m: [f64; 3], t: usize, s: usize) -> Option<(f64, f64)> {
        self.0.project(point_m, t, s)
    }

    /// Depth of field, angles and sizes as `holo optics --json` names them. `depths_m` are the nearest and the farthest
    /// depth of a scene.
    #[pyo3(signature = (depths_m=None, *, circle_px=1.0, step_px=0.1))]
    fn optics<'py>(
        &self,
        py: Python<'py>,
        depths_m: Option<(f64, f64)>,
        circle_px: f64,
        step_px: f64,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let depths = depths_m.map(|(near_m, far_m)| DepthRange::new(near_m, far_m)).transpose()?;
        let rows = holo_dataset::rig_optics(&Optics::new(self.0)?, depths, circle_px, step_px)?;
        give_quantities(py, rows)
    }

    fn __repr__(&self) -> String {
        let ((t, s), (v, u)) = (self.views(), self.lenses());
        format!(
            "Rig(views=({t}, {s}), lenses=({v}, {u}), focal_length_m={}, sensor_size_m={}, baseline_m={}, baseline_y_m={}, \
             focus_distance_m={}, projection='{}')",
            self.focal_length_m(),
            self.sensor_size_m(),
            self.baseline_m(),
            self.baseline_y_m(),
            self.focus_distance_m(),
            self.projection()
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __hash__(&self) -> u64 {
        let numbers = [self.focal_length_m(), self.baseline_m(), self.focus_distance_m()];
        numbers.iter().fold(self.0.shape().views().count() as u64, |hash, x| hash.rotate_left(17) ^ x.to_bits())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        let numbers = vec![
            self.focal_length_m(),
            self.sensor_size_m(),
            self.baseline_m(),
            self.baseline_y_m(),
            self.focus_distance_m(),
        ];
        let make = py.import("holo.rig")?.getattr("_rig_from_numbers")?;
        Ok((make, (vec![self.views(), self.lenses()], numbers, self.projection())))
    }
}

/// Views and lenses, the five lengths, and the projection: for pickles.
type Parts = (Vec<Size>, Vec<f64>, &'static str);

/// A number, or an array of any shape.
#[derive(FromPyObject)]
pub enum Numbers<'py> {
    One(f64),
    F64(PyReadonlyArrayDyn<'py, f64>),
    F32(PyReadonlyArrayDyn<'py, f32>),
}

impl Rig {
    fn convert<'py>(
        &self,
        py: Python<'py>,
        numbers: &Numbers<'py>,
        convert: impl Fn(Disparity, f64) -> f64,
    ) -> Bound<'py, PyAny> {
        let disparity = self.0.disparity();
        match numbers {
            Numbers::One(x) => pyo3::types::PyFloat::new(py, convert(disparity, *x)).into_any(),
            Numbers::F64(array) => give(py, array.as_array().mapv(|x| convert(disparity, x))),
            Numbers::F32(array) => give(py, array.as_array().mapv(|x| convert(disparity, f64::from(x)))),
        }
    }
}

/// The rig that the options describe without a scene.
#[pyfunction]
#[pyo3(signature = (options, depths_m=None, lens_pitch_mm=None))]
pub fn planned_rig(
    options: BTreeMap<String, String>,
    depths_m: Option<(f64, f64)>,
    lens_pitch_mm: Option<f64>,
) -> Result<Rig, Failure> {
    let depths = depths_m.map(|(near_m, far_m)| DepthRange::new(near_m, far_m)).transpose()?;
    let settings = options::settings(&options, None, Camera::default(), None)?;
    let rig = settings.camera.rig().cloned().unwrap_or_default();
    Ok(Rig(holo_dataset::planned_rig(&rig, lens_pitch_mm, depths)?))
}
