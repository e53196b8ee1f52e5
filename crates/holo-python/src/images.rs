//! What is computed from light fields and images: grids, color, refocusing, disparity.

use holo_core::refocus::{Aperture, ApertureShape, FocalPlane, Kernel, Refocus};
use holo_core::{
    BaselineRatio, ColorEncoding, DynLightField, Layout, LightField, LightFieldRef, PlaneSweepOptions, Sample,
    ViewDisparities, ViewIndex, ViewSynthesis, for_each_sample,
};
use holo_dataset::{ViewSubset, estimate_from_views};
use holo_io::Compression;
use ndarray::Array3;
use numpy::{PyReadonlyArray2, PyReadonlyArray4, PyReadonlyArray5};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{Field, Image, give, give_field};
use crate::cameras::rig::Rig;
use crate::failure::Failure;
use crate::options;

/// A grid of elemental images ("el") or of views ("vpi"), axes (row, column, channel).
#[pyfunction]
pub fn to_grid<'py>(py: Python<'py>, field: Field<'py>, layout: &str) -> Result<Bound<'py, PyAny>, Failure> {
    let layout = options::layout(layout)?;
    let field = field.borrow()?;
    for_each_sample!(DynLightFieldRef, field, field => Ok(give(py, py.detach(|| grid(&field, layout))?)))
}

/// A grid of a layout, axes (row, column, channel).
pub fn grid<T: Sample>(field: &LightFieldRef<'_, T>, layout: Layout) -> Result<Array3<T>, holo_core::Error> {
    match layout {
        Layout::ElementalGrid => field.to_elemental_grid(),
        Layout::ViewpointGrid => field.to_viewpoint_grid(),
    }
}

/// The samples in linear light as float32.
#[pyfunction]
pub fn to_linear<'py>(py: Python<'py>, field: Field<'py>, is_srgb: bool) -> Result<Bound<'py, PyAny>, Failure> {
    let encoding = if is_srgb { ColorEncoding::Srgb } else { ColorEncoding::Linear };
    let field = field.borrow()?;
    let linear = py.detach(|| -> Result<_, holo_core::Error> {
        let owned: DynLightField = for_each_sample!(DynLightFieldRef, field, field => field.to_owned()?.into());
        owned.into_linear(encoding)
    })?;
    Ok(give(py, linear.into_samples()))
}

/// The exposure in EV at which 99 % of the pixels that are not black lie below 80 % of the range.
#[pyfunction]
pub fn automatic_exposure(py: Python<'_>, field: PyReadonlyArray5<'_, f32>) -> Result<f64, Failure> {
    let field = LightField::new(field.as_array())?;
    Ok(py.detach(|| holo_render::exposure::automatic_exposure(&field)))
}

/// Codes of 8 or 16 bits on the sRGB curve.
#[pyfunction]
pub fn encode<'py>(
    py: Python<'py>,
    field: PyReadonlyArray5<'py, f32>,
    bits: u8,
    exposure_ev: f64,
) -> Result<Bound<'py, PyAny>, Failure> {
    let field = LightField::new(field.as_array())?;
    let coded: DynLightField = match bits {
        8 => py.detach(|| holo_render::exposure::encode_8bit(&field, exposure_ev))?.into(),
        16 => py.detach(|| holo_render::exposure::encode_16bit(&field, exposure_ev))?.into(),
        _ => return Err(Failure::Usage(format!("bits={bits}: give 8 or 16"))),
    };
    Ok(give_field(py, coded))
}

/// The kernels between pixels, and their names.
pub const KERNELS: [(&str, Kernel); 2] = [("cubic", Kernel::CatmullRom), ("bilinear", Kernel::Bilinear)];

/// Where a light field is in focus.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct FocusRequest<'py> {
    disparity_px: Option<f64>,
    slope: Option<f64>,
    map: Option<PyReadonlyArray2<'py, f32>>,
    /// Distance in m, tilts to the right and up in radians, and the rig.
    plane: Option<(f64, f64, f64, Rig)>,
    aperture: String,
    kernel: String,
    baseline_ratio: f64,
}

/// One image of a light field in linear light, axes (row, column, channel).
#[pyfunction]
pub fn refocus<'py>(
    py: Python<'py>,
    field: PyReadonlyArray5<'py, f32>,
    request: FocusRequest<'py>,
) -> Result<Bound<'py, PyAny>, Failure> {
    let field = LightField::new(field.as_array())?;
    let views = field.shape().views();
    let center = ((views.rows / 2) as f64, (views.columns / 2) as f64);
    let refocus = Refocus::with_aperture(Aperture::shaped(views, center, aperture(&request.aperture)?)?)
        .kernel(options::choice("kernel", &request.kernel, &KERNELS)?)
        .baseline_ratio(BaselineRatio::vertical_over_horizontal(request.baseline_ratio)?);
    let map = request.map.as_ref().map(|map| map.as_array());
    if let Some((distance_m, right, up, Rig(rig))) = request.plane {
        let plane = FocalPlane::new(distance_m).and_then(|plane| plane.tilted(right, up))?;
        return Ok(give(py, py.detach(|| refocus.at_plane(&field, &rig, plane))?));
    }
    let image: Array3<f32> = py.detach(|| match (request.disparity_px, request.slope, map) {
        (Some(disparity_px), _, _) => refocus.at_disparity(&field, disparity_px),
        (None, Some(slope), _) => refocus.at_slope(&field, slope),
        (None, None, Some(map)) => refocus.all_in_focus(&field, &map),
        (None, None, None) => refocus.at_disparity(&field, 0.0),
    })?;
    Ok(give(py, image))
}

/// `all`, or a shape with its size.
pub fn aperture(text: &str) -> Result<ApertureShape, Failure> {
    text.parse().map_err(|why| Failure::Usage(format!("aperture={text:?}: {why}")))
}

/// The disparities that a view is synthesized with: of one plane, of the central view, or of all views.
#[derive(FromPyObject)]
pub enum Disparities<'py> {
    /// One number, px.
    Plane(f64),
    /// Axes (row, column).
    Central(PyReadonlyArray2<'py, f32>),
    /// Axes (microlens row, microlens column, view row, view column).
    All(PyReadonlyArray4<'py, f32>),
}

/// A view between the views in linear light, its disparities, and where no view shows it.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "three arrays")]
pub fn synthesize<'py>(
    py: Python<'py>,
    field: PyReadonlyArray5<'py, f32>,
    at: (f64, f64),
    disparities: Disparities<'py>,
    kernel: &str,
    baseline_ratio: f64,
) -> Result<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>), Failure> {
    let field = LightField::new(field.as_array())?;
    let synthesis = ViewSynthesis::default()
        .kernel(options::choice("kernel", kernel, &KERNELS)?)
        .baseline_ratio(BaselineRatio::vertical_over_horizontal(baseline_ratio)?);
    let (t, s) = field.shape().central_view();
    let disparities = match &disparities {
        Disparities::Plane(disparity_px) => ViewDisparities::Plane(*disparity_px),
        Disparities::Central(map) => ViewDisparities::OfView(map.as_array(), ViewIndex { row: t, column: s }),
        Disparities::All(maps) => ViewDisparities::OfAll(maps.as_array()),
    };
    let view = py.detach(|| synthesis.at(&field, disparities, at))?;
    Ok((give(py, view.image), give(py, view.disparity_px), give(py, view.holes)))
}

/// Disparity of the central view and its confidence, axes (row, column).
#[pyfunction]
pub fn plane_sweep<'py>(
    py: Python<'py>,
    field: Field<'py>,
    range_px: Option<(f32, f32)>,
    effort: &str,
    baseline_ratio: f64,
    subset: Option<&str>,
) -> Result<(Bound<'py, PyAny>, Bound<'py, PyAny>), Failure> {
    let subset = subset.map(str::parse::<ViewSubset>).transpose();
    let subset = subset.map_err(|why| Failure::Usage(format!("subset: {why}")))?;
    let mut sweep = PlaneSweepOptions::default()
        .effort(options::effort(effort)?)
        .baseline_ratio(BaselineRatio::vertical_over_horizontal(baseline_ratio)?);
    if let Some((min, max)) = range_px {
        sweep = sweep.range_px(min, max);
    }
    let field = field.borrow()?;
    let estimate = py.detach(|| -> Result<_, Failure> {
        for_each_sample!(DynLightFieldRef, field, field => {
            let Some(subset) = subset else { return Ok(holo_core::plane_sweep(&field, &sweep)?) };
            let (row, column) = field.shape().central_view();
            let taken: Vec<_> = subset.views(field.shape().views()).into_iter().map(|view| (view, view)).collect();
            Ok(estimate_from_views(&field, &taken, ViewIndex::new(row, column), &sweep)?)
        })
    })?;
    Ok((give(py, estimate.disparity_px), give(py, estimate.confidence)))
}

/// A PNG of an image in memory: integers as they are, floats on the sRGB curve.
#[pyfunction]
pub fn png<'py>(py: Python<'py>, image: Image<'py>) -> Result<Bound<'py, PyBytes>, Failure> {
    let image = image.borrow();
    let bytes = py.detach(|| {
        let mut bytes = Vec::new();
        holo_io::encode_png(&mut bytes, image, ColorEncoding::Srgb, Compression::Fast).map(|()| bytes)
    })?;
    Ok(PyBytes::new(py, &bytes))
}
