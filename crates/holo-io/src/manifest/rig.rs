//! The rig as files hold it: the same numbers, in the units that files use.

use std::path::Path;

use holo_core::{GridSize, Intrinsics, Projection, RigParameters, Split};

use crate::error::MEMORY;
use crate::{Error, millimetres};

/// The numbers of a rig in the units of a manifest.
///
/// # Units
///
/// As the names say. Lengths in millimetres are the metres of [`RigParameters`] with the decimal point moved, so 0.035
/// m is 35.0 mm and not 35.00000000000001 mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManifestRig {
    /// Views, rows T and columns S.
    pub views: GridSize,
    /// Lenses, rows V and columns U: the pixels of one view.
    pub lenses: GridSize,
    /// Distance between horizontally adjacent views.
    pub baseline_x_m: f64,
    /// Distance between vertically adjacent views.
    pub baseline_y_m: f64,
    /// Focal length of every view's camera.
    pub focal_length_mm: f64,
    /// Size of the sensor along the larger side of a view.
    pub sensor_size_mm: f64,
    /// Distance of the focus plane; may be infinite.
    pub focus_distance_m: f64,
    /// Perspective or orthographic views.
    pub projection: Projection,
}

impl From<&RigParameters> for ManifestRig {
    fn from(parameters: &RigParameters) -> Self {
        Self {
            views: parameters.split.views(),
            lenses: parameters.split.lenses(),
            baseline_x_m: parameters.baseline_x_m,
            baseline_y_m: parameters.baseline_y_m,
            focal_length_mm: millimetres::from_metres(parameters.intrinsics.focal_length_m),
            sensor_size_mm: millimetres::from_metres(parameters.intrinsics.sensor_size_m),
            focus_distance_m: parameters.focus_distance_m,
            projection: parameters.projection,
        }
    }
}

impl ManifestRig {
    /// Returns the same rig in metres, for [`holo_core::Rig::new`].
    ///
    /// # Errors
    ///
    /// [`Error::Core`] if the views and lenses make no image.
    pub fn parameters(&self) -> Result<RigParameters, Error> {
        let split = Split::new(self.views, self.lenses).map_err(|error| Error::core(Path::new(MEMORY), error))?;
        Ok(RigParameters {
            split,
            intrinsics: Intrinsics {
                focal_length_m: millimetres::to_metres(self.focal_length_mm),
                sensor_size_m: millimetres::to_metres(self.sensor_size_mm),
            },
            baseline_x_m: self.baseline_x_m,
            baseline_y_m: self.baseline_y_m,
            focus_distance_m: self.focus_distance_m,
            projection: self.projection,
        })
    }
}
