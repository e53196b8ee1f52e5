//! A rig as the numbers that MAT and HDF5 files contain: those of the manifest, rows first.

use std::path::Path;

use holo_core::{LightFieldShape, Projection, Rig};

use crate::{Error, meters_to_millimeters, millimeters_to_meters};

/// The numbers of a rig but the counts of views and microlenses, which are those of the samples.
pub(crate) struct RigValues {
    /// Vertical, then horizontal.
    pub(crate) baseline_m: [f64; 2],
    pub(crate) focal_length_mm: f64,
    pub(crate) sensor_size_mm: f64,
    pub(crate) focus_distance_m: f64,
    pub(crate) projection: &'static str,
}

impl From<&Rig> for RigValues {
    fn from(rig: &Rig) -> Self {
        Self {
            baseline_m: [rig.baseline_y_m(), rig.baseline_x_m()],
            focal_length_mm: meters_to_millimeters(rig.focal_length_m()),
            sensor_size_mm: meters_to_millimeters(rig.sensor_size_m()),
            focus_distance_m: rig.focus_distance_m(),
            projection: match rig.projection() {
                Projection::Perspective => "perspective",
                Projection::Orthographic => "orthographic",
            },
        }
    }
}

/// Checks that a rig has these numbers of views and microlenses.
pub(crate) fn check_split(path: &Path, rig: Option<&Rig>, shape: &LightFieldShape) -> Result<(), Error> {
    match rig {
        Some(rig) if rig.shape() != shape => {
            Err(Error::bad_input(path, format!("the rig is for {:?}, but the light field has {shape:?}", rig.shape())))
        }
        _ => Ok(()),
    }
}

/// The rig of a file: `None` if a number is missing, an error of `holo-core` if the numbers are invalid.
pub(crate) type FoundRig = Option<Result<Rig, holo_core::Error>>;

/// Builds a rig from the numbers of a file.
///
/// `lengths` are focal length and sensor size in millimeters and the focus distance in meters. Without a projection the
/// rig is perspective; a single baseline applies to both axes.
pub(crate) fn rig(
    path: &Path,
    shape: LightFieldShape,
    baseline_m: Option<Vec<f64>>,
    lengths: [Option<Vec<f64>>; 3],
    projection: Option<&str>,
) -> Result<FoundRig, Error> {
    let [Some(focal), Some(sensor), Some(focus)] = lengths else { return Ok(None) };
    let Some(baseline_m) = baseline_m else { return Ok(None) };
    let broken = |what: String| Error::broken(path, "rig", what);
    let one = |name: &str, numbers: Vec<f64>| match numbers[..] {
        [number] => Ok(number),
        _ => Err(broken(format!("`{name}` has {} numbers instead of one", numbers.len()))),
    };
    let (baseline_y_m, baseline_x_m) = match baseline_m[..] {
        [both] => (both, both),
        [y, x] => (y, x),
        _ => return Err(broken(format!("`baseline_m` has {} numbers instead of two", baseline_m.len()))),
    };
    let projection = match projection {
        None | Some("perspective") => Projection::Perspective,
        Some("orthographic") => Projection::Orthographic,
        Some(other) => return Err(broken(format!("`projection` is '{other}'"))),
    };
    let rig = Rig::builder(shape)
        .focal_length_m(millimeters_to_meters(one("focal_length_mm", focal)?))
        .sensor_size_m(millimeters_to_meters(one("sensor_size_mm", sensor)?))
        .baseline_x_m(baseline_x_m)
        .baseline_y_m(baseline_y_m)
        .focus_distance_m(one("focus_distance_m", focus)?)
        .projection(projection)
        .build();
    Ok(Some(rig))
}
