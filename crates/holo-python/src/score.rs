//! Scores of disparity maps and images, by the names of `holo eval --json`.

use holo_core::metrics::{
    BAD_PIXEL_THRESHOLDS_PX, NormalGeometry, Region, bumpiness, disparity_scores, median_angle_error_deg, psnr_db,
    ssim, trivial_constant, trivial_plane,
};
use holo_core::{GridSize, Sample};
use ndarray::ArrayView3;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::Image;
use crate::failure::Failure;
use crate::rig::Rig;

/// The threshold at which the best constant and plane are found: the benchmark's widest.
const FIT_THRESHOLD_PX: f64 = 0.07;

/// A disparity map against ground truth.
#[pyfunction]
pub fn evaluate<'py>(
    py: Python<'py>,
    estimate: PyReadonlyArray2<'py, f32>,
    truth: PyReadonlyArray2<'py, f32>,
    border_px: usize,
    mask: Option<PyReadonlyArray2<'py, bool>>,
    rig: Option<Rig>,
) -> Result<Bound<'py, PyDict>, Failure> {
    let (estimate, truth) = (estimate.as_array(), truth.as_array());
    let mask = mask.as_ref().map(|mask| mask.as_array());
    let region = Region { border_px, mask };
    let dict = PyDict::new(py);
    let scores = disparity_scores(&estimate, &truth, &region)?;
    for (threshold, percent) in BAD_PIXEL_THRESHOLDS_PX.into_iter().zip(scores.bad_pixels_percent) {
        dict.set_item(format!("bad_pixels_{threshold}_percent"), percent)?;
    }
    let constant = trivial_constant(&truth, FIT_THRESHOLD_PX, &region)?.bad_pixels_percent;
    dict.set_item("best_constant_bad_pixels_percent", constant)?;
    let plane = trivial_plane(&truth, FIT_THRESHOLD_PX, &region)?.bad_pixels_percent;
    dict.set_item("best_plane_bad_pixels_percent", plane)?;
    dict.set_item("mean_squared_error_x100", scores.mean_squared_error_x100)?;
    dict.set_item("q25_x100", scores.q25_x100)?;
    dict.set_item("bumpiness", bumpiness(&estimate, &truth, &region)?.value)?;
    dict.set_item("mean_absolute_error_px", scores.mean_absolute_error_px)?;
    dict.set_item("root_mean_squared_error_px", scores.root_mean_squared_error_px)?;
    let (rows, columns) = truth.dim();
    if let Some(rig) = rig.filter(|rig| rig.0.shape().lenses() == GridSize::new(rows, columns)) {
        let angle = median_angle_error_deg(&estimate, &truth, &rig.0, NormalGeometry::Pinhole, &region)?;
        dict.set_item("median_angle_deg", angle.value)?;
    }
    dict.set_item("border_px", border_px)?;
    dict.set_item("compared", scores.counts.compared)?;
    dict.set_item("estimate_not_finite", scores.counts.estimate_not_finite)?;
    dict.set_item("truth_not_finite", scores.counts.truth_not_finite)?;
    Ok(dict)
}

/// An image against another: PSNR in dB and SSIM.
#[pyfunction]
pub fn compare(image: Image<'_>, reference: Image<'_>, data_range: Option<f64>) -> Result<(f64, f64), Failure> {
    fn both<T: Sample>(image: ArrayView3<T>, reference: ArrayView3<T>, range: f64) -> Result<(f64, f64), Failure> {
        Ok((psnr_db(&image, &reference, range)?, ssim(&image, &reference, range)?))
    }
    match (&image, &reference) {
        (Image::U8(a), Image::U8(b)) => both(a.as_array(), b.as_array(), data_range.unwrap_or(255.0)),
        (Image::U16(a), Image::U16(b)) => both(a.as_array(), b.as_array(), data_range.unwrap_or(65_535.0)),
        (Image::F32(a), Image::F32(b)) => both(a.as_array(), b.as_array(), data_range.unwrap_or(1.0)),
        (Image::F64(a), Image::F64(b)) => both(a.as_array(), b.as_array(), data_range.unwrap_or(1.0)),
        _ => Err(Failure::Usage("the images have different sample types; compare images of the same type".into())),
    }
}
