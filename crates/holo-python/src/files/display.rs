//! Displays: the image for a panel behind lenses, and what an eye sees of it.

use std::path::PathBuf;

use holo_core::display::{PanelMapping, ViewSpread};
use holo_core::{BaselineRatio, GridSize, LightField};
use holo_io::DisplayFile;
use numpy::{IntoPyArray, PyArray3, PyReadonlyArray3, PyReadonlyArray5};
use pyo3::prelude::*;

use crate::cameras::rig::Rig;
use crate::failure::Failure;

/// A panel behind a sheet of lenses.
#[pyclass(module = "holo._holo", frozen)]
pub struct Display {
    file: DisplayFile,
}

/// How a light field is shown.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ShowRequest {
    disparity_px: f64,
    /// The scene to scale.
    rig: Option<Rig>,
    row: Option<usize>,
    baseline_ratio: f64,
}

#[pymethods]
impl Display {
    #[new]
    fn read(file: PathBuf) -> Result<Self, Failure> {
        Ok(Self { file: DisplayFile::read(file)? })
    }

    fn name(&self) -> &str {
        &self.file.name
    }

    /// Rows and columns of the panel, its width and height in meters, and rows and columns of an image of its lenses.
    fn sizes(&self) -> ((usize, usize), [f64; 2], (usize, usize)) {
        let (panel, image) = (self.file.display.panel().size, self.file.display.resolution());
        ((panel.rows, panel.columns), self.file.display.size_m(), (image.rows, image.columns))
    }

    fn panel_image<'py>(
        &self,
        py: Python<'py>,
        field: PyReadonlyArray5<'py, f32>,
        request: ShowRequest,
    ) -> Result<Bound<'py, PyArray3<f32>>, Failure> {
        let field = LightField::new(field.as_array())?;
        let mapping = PanelMapping {
            spread: request.rig.map_or(ViewSpread::WholeZone, |Rig(rig)| ViewSpread::ToScale(rig)),
            screen_disparity_px: request.disparity_px,
            baseline_ratio: BaselineRatio::vertical_over_horizontal(request.baseline_ratio)?,
            view_row: request.row,
        };
        let image = py.detach(|| self.file.display.panel_image(&field, &mapping))?;
        Ok(image.into_pyarray(py))
    }

    fn seen_from<'py>(
        &self,
        py: Python<'py>,
        panel_image: PyReadonlyArray3<'py, f32>,
        eye_m: [f64; 3],
        size: (usize, usize),
        rays: usize,
    ) -> Result<Bound<'py, PyArray3<f32>>, Failure> {
        let (image, size) = (panel_image.as_array(), GridSize::new(size.0, size.1));
        Ok(py.detach(|| self.file.display.seen_from(&image, eye_m, size, rays))?.into_pyarray(py))
    }
}
