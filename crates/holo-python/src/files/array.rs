//! The images of cameras anywhere, and what they make together.

use std::path::PathBuf;

use holo_core::refocus::{FocalPlane, FocalSurface};
use holo_core::{CameraJitter, GridSize, Pinhole};
use holo_dataset::{
    ArrayViewpoint, Placement, Surface, correspondences, estimate_depth, jittered, synthesize_from_array,
    synthetic_aperture,
};
use holo_io::{ArrayFolder, Limits};
use ndarray::Array3;
use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::images::{KERNELS, aperture};
use crate::options;

/// A folder with the images of cameras anywhere.
#[pyclass(module = "holo._holo", frozen)]
pub struct CameraFolder {
    array: ArrayFolder,
}

/// Where cameras stand, and how they deviate from it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PlacementRequest {
    surface: String,
    count: (usize, usize),
    spacing_m: [f64; 2],
    span_rad: f64,
    elevation_rad: [f64; 2],
    target_m: [f64; 3],
    radius_m: f64,
    size: (usize, usize),
    angle_rad: f64,
    jitter: [f64; 6],
    seed: u64,
}

/// Writes the cameras of a placement; returns their number.
#[pyfunction]
pub fn place_cameras(request: PlacementRequest, out: PathBuf, up: &str) -> Result<usize, Failure> {
    let count = GridSize::new(request.count.0, request.count.1);
    let span_rad = request.span_rad;
    let surfaces = [
        ("plane", Surface::Plane { count, spacing_m: request.spacing_m }),
        ("cylinder", Surface::Cylinder { count, span_rad, spacing_m: request.spacing_m[0] }),
        ("sphere", Surface::Sphere { count: count.count(), elevation_rad: request.elevation_rad }),
    ];
    let surface = options::choice("surface", &request.surface, &surfaces)?;
    let (target_m, radius_m) = (request.target_m, request.radius_m);
    let size = GridSize::new(request.size.0, request.size.1);
    let focal_px = Placement::focal_px(size.columns, request.angle_rad)?;
    let meant = Placement { surface, target_m, radius_m, size, focal_px }.cameras()?;
    let [position_m, rotation_rad, focal, gain, color, time_s] = request.jitter;
    let jitter = CameraJitter { position_m, rotation_rad, focal, gain, color, time_s };
    let array = jittered(meant, &jitter, request.seed)?;
    array.write(&out, options::world_up(up)?)?;
    Ok(array.cameras.len())
}

/// Where a view stands and what it looks at, and what is up in it.
type Viewpoint = (Option<[f64; 3]>, Option<[f64; 3]>, Option<[f64; 3]>);

/// The axes right, up and back and the position, the focal length in pixels, rows and columns, and the principal point.
type Numbers = ([[f64; 3]; 3], [f64; 3], f64, (usize, usize), [f64; 2]);

/// Where a synthetic aperture is in focus, and which cameras it has.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ApertureRequest<'py> {
    distance_m: Option<f64>,
    tilt_rad: (f64, f64),
    depth_m: Option<PyReadonlyArray2<'py, f32>>,
    aperture: String,
    kernel: String,
}

/// Axes (row, column, channel), depth and holes (row, column).
type Synthesized<'py> = (Bound<'py, PyArray3<f32>>, Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<bool>>);

/// Row and column with the axes (row, column, 2), depth and visibility (row, column).
type Found<'py> = (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<bool>>);

/// Depth and confidence (row, column), and the number of other cameras.
type Estimated<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>, usize);

#[pymethods]
impl CameraFolder {
    #[new]
    fn open(py: Python<'_>, folder: PathBuf, up: &str) -> Result<Self, Failure> {
        let up = options::world_up(up)?;
        Ok(Self { array: py.detach(|| ArrayFolder::open(folder, up))? })
    }

    fn names(&self) -> Vec<String> {
        self.array.cameras().iter().map(|camera| camera.name.clone()).collect()
    }

    fn camera(&self, k: usize) -> Result<Numbers, Failure> {
        Ok(numbers(&self.array.pinhole(k)?))
    }

    /// The camera of a view that stands anywhere.
    fn view(&self, viewpoint: Viewpoint) -> Result<Numbers, Failure> {
        Ok(numbers(&placed(viewpoint).camera(&self.array)?))
    }

    fn image<'py>(&self, py: Python<'py>, k: usize) -> Result<Bound<'py, PyArray3<f32>>, Failure> {
        Ok(py.detach(|| self.array.image(k, &Limits::default()))?.into_pyarray(py))
    }

    fn depth<'py>(&self, py: Python<'py>, k: usize) -> Result<Option<Bound<'py, PyArray2<f32>>>, Failure> {
        Ok(py.detach(|| self.array.depth_m(k, &Limits::default()))?.map(|map| map.into_pyarray(py)))
    }

    /// The number of the camera with this name.
    fn position(&self, name: &str) -> Option<usize> {
        self.array.position(name)
    }

    fn central_cameras(&self) -> Vec<usize> {
        self.array.central_cameras()
    }

    fn correspondences<'py>(&self, py: Python<'py>, from: usize, to: usize) -> Result<Found<'py>, Failure> {
        let found = py.detach(|| correspondences(&self.array, from, to))?;
        let (rows, columns) = found.dim();
        let places = Array3::from_shape_fn((rows, columns, 2), |(row, column, axis)| found[[row, column]].place[axis]);
        let (depth_m, is_visible) = (found.map(|one| one.depth_m), found.map(|one| one.is_visible));
        Ok((places.into_pyarray(py), depth_m.into_pyarray(py), is_visible.into_pyarray(py)))
    }

    /// Depth and confidence, and how many other cameras they are from.
    fn estimate_depth<'py>(
        &self,
        py: Python<'py>,
        k: Option<usize>,
        depths_m: [f64; 2],
        effort: &str,
    ) -> Result<Estimated<'py>, Failure> {
        let effort = options::effort(effort)?;
        let found = py.detach(|| {
            let k = k.map_or_else(|| ArrayViewpoint::default().nearest(&self.array), Ok)?;
            estimate_depth(&self.array, k, depths_m, effort)
        })?;
        Ok((found.depth_m.into_pyarray(py), found.confidence.into_pyarray(py), found.others))
    }

    fn refocus<'py>(
        &self,
        py: Python<'py>,
        viewpoint: Viewpoint,
        request: ApertureRequest<'py>,
    ) -> Result<Bound<'py, PyArray3<f32>>, Failure> {
        let shape = aperture(&request.aperture)?;
        let kernel = options::choice("kernel", &request.kernel, &KERNELS)?;
        let view = placed(viewpoint).camera(&self.array)?;
        let map = request.depth_m.as_ref().map(|map| map.as_array());
        let surface = match (request.distance_m, map) {
            (_, Some(map)) => FocalSurface::Depth(map),
            (distance_m, None) => {
                let (right, up) = request.tilt_rad;
                let plane =
                    FocalPlane::new(distance_m.unwrap_or(f64::INFINITY)).and_then(|plane| plane.tilted(right, up))?;
                FocalSurface::Plane(plane)
            }
        };
        let image = py.detach(|| synthetic_aperture(&self.array, view, shape, kernel, surface))?;
        Ok(image.into_pyarray(py))
    }

    fn synthesize<'py>(
        &self,
        py: Python<'py>,
        viewpoint: Viewpoint,
        kernel: &str,
    ) -> Result<Synthesized<'py>, Failure> {
        let kernel = options::choice("kernel", kernel, &KERNELS)?;
        let view = placed(viewpoint).camera(&self.array)?;
        let made = py.detach(|| synthesize_from_array(&self.array, &view, kernel))?;
        Ok((made.image.into_pyarray(py), made.depth_m.into_pyarray(py), made.holes.into_pyarray(py)))
    }
}

fn numbers(camera: &Pinhole) -> Numbers {
    let size = (camera.size().rows, camera.size().columns);
    (camera.axes(), camera.position_m(), camera.focal_px(), size, camera.principal_point())
}

fn placed((eye, target, up): Viewpoint) -> ArrayViewpoint {
    ArrayViewpoint { eye, target, up }
}
