//! Scores of disparity maps and images, by the names of `holo eval --json`.

pub(crate) mod benchmark;

use holo_core::Sample;
use holo_core::metrics::{psnr_db, ssim};
use holo_dataset::{MapScoring, QuantityValue};
use ndarray::ArrayView3;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::Image;
use crate::cameras::rig::Rig;
use crate::failure::Failure;

/// A disparity map against ground truth, over all scored pixels and by region.
#[pyfunction]
pub fn evaluate<'py>(
    py: Python<'py>,
    estimate: PyReadonlyArray2<'py, f32>,
    truth: PyReadonlyArray2<'py, f32>,
    border_px: usize,
    mask: Option<PyReadonlyArray2<'py, bool>>,
    rig: Option<Rig>,
    regions: Vec<(String, PyReadonlyArray2<'py, bool>)>,
) -> Result<Bound<'py, PyDict>, Failure> {
    let regions: Vec<_> = regions.into_iter().map(|(name, mask)| (name, mask.as_array().to_owned())).collect();
    let mask = mask.as_ref().map(|mask| mask.as_array());
    let scoring = MapScoring::with_border(border_px).mask(mask).rig(rig.map(|rig| rig.0)).regions(&regions);
    let dict = PyDict::new(py);
    for row in scoring.scores(estimate.as_array(), truth.as_array())? {
        match row.value {
            QuantityValue::Number(value) => dict.set_item(row.key, value)?,
            QuantityValue::Count(count) => dict.set_item(row.key, count)?,
            _ => {}
        }
    }
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
