//! `lf.h5` of the old HCI benchmark (Wanner, Meister and Goldluecke, 2013).
//!
//! | what | axes | type |
//! |---|---|---|
//! | `/LF` | (view row, view column, row, column, channel) | uint8 |
//! | `/GT_DEPTH` (`/GT`, `/Depth` in other files) | (view row, view column, row, column), or (row, column) of the central view | depth, floats |
//!
//! View columns run from right to left. Attributes of the file: `dH`, `focalLength` and `shift`, of which the disparity
//! between adjacent views is dH focalLength / depth - shift, in px, positive nearer than the plane of disparity 0.
//!
//! # Source
//!
//! The benchmark's page for the disparity. The order of the columns: six readers of these files reverse it; the program that
//! wrote them is not published, and no file was available for a test.

use std::path::Path;

use ::hdf5::{Dataset, File, SliceOrIndex};
use holo_core::{DynLightField, GridSize, LightField, LightFieldShape, Rig};
use ndarray::{Array2, ArrayD, Axis, Ix2, Ix5};

use super::library::{Failure, open};
use super::read::read_part;
use super::storage::find;
use super::{FORMAT, Hdf5Map, attributes};
use crate::{Error, Limits};

/// The names that ground truth has.
const DEPTHS: [&str; 3] = ["GT_DEPTH", "GT", "Depth"];

/// The largest focal length that is in image widths; larger ones are in pixels.
const LARGEST_IN_WIDTHS: f64 = 10.0;

/// The sensor width that stands for the unknown one, m.
const SENSOR_M: f64 = 0.035;

/// An open `lf.h5`.
#[derive(Debug)]
pub(crate) struct OldHciFile {
    file: File,
    samples: Dataset,
    path: std::path::PathBuf,
    limits: Limits,
    /// Lengths of the axes (view row, view column, row, column, channel).
    dimensions: [usize; 5],
    shape: LightFieldShape,
    /// dH focalLength, px m, and shift, px.
    disparity: Option<[f64; 2]>,
    rig: Option<Rig>,
}

/// Whether a file has the dataset of such a light field.
pub(crate) fn is_old_hci(path: &Path) -> Result<bool, Error> {
    Ok(find(&open(path)?, path, "LF")?.is_some_and(|samples| samples.ndim() == 5))
}

impl OldHciFile {
    pub fn open(path: &Path, limits: &Limits) -> Result<Self, Error> {
        let failed = |error| Failure { path, is_writing: false }.error(error);
        let broken = |what: String| Error::broken(path, FORMAT, what);
        let file = open(path)?;
        let samples = find(&file, path, "LF")?.ok_or_else(|| broken("there is no dataset /LF".into()))?;
        let dimensions: [usize; 5] = samples
            .get_shape()
            .map_err(failed)?
            .try_into()
            .map_err(|found: Vec<usize>| broken(format!("/LF has {} axes instead of five", found.len())))?;
        let [t, s, v, u, channels] = dimensions;
        let shape =
            LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).map_err(|why| Error::core(path, why))?;
        if channels == 0 {
            return Err(broken("/LF has no channels".into()));
        }
        let number = |name: &str| -> Result<Option<f64>, Error> {
            let found = attributes::read_numbers(&file, name).map_err(failed)?;
            Ok(found.and_then(|all| all.first().copied()).filter(|value| value.is_finite()))
        };
        let (step, focal, shift) = (number("dH")?, number("focalLength")?, number("shift")?);
        let (disparity, rig) = match (step, focal, shift) {
            (Some(step), Some(focal), Some(shift)) => {
                let rig = rig(shape, [step, number("dV")?.unwrap_or(step)], focal, shift);
                (Some([step * focal, shift]), rig)
            }
            _ => (None, None),
        };
        Ok(Self { file, samples, path: path.to_owned(), limits: *limits, dimensions, shape, disparity, rig })
    }

    pub fn shape(&self) -> LightFieldShape {
        self.shape
    }

    pub fn rig(&self) -> Option<Rig> {
        self.rig
    }

    /// Reads all samples; view columns run from left to right.
    pub fn read(&self) -> Result<DynLightField, Error> {
        let samples: ArrayD<u8> =
            read_part(&self.samples, &self.dimensions.map(|count| (0..count).into()), &self.path, self.limits)?;
        let mut samples = samples
            .into_dimensionality::<Ix5>()
            .map_err(|error| Error::broken(&self.path, FORMAT, error.to_string()))?;
        samples.invert_axis(Axis(1));
        let samples = samples.permuted_axes([2, 3, 0, 1, 4]);
        LightField::new(samples).map(DynLightField::from).map_err(|error| Error::core(&self.path, error))
    }

    /// Depth, or disparity between adjacent views, of the central view; `None` if the file has no depth, or not what
    /// disparity needs.
    pub fn central_map(&self, map: Hdf5Map) -> Result<Option<Array2<f32>>, Error> {
        let mut first = None;
        for name in DEPTHS {
            if first.is_none() {
                first = find(&self.file, &self.path, name)?.map(|dataset| (name, dataset));
            }
        }
        let Some((name, dataset)) = first else { return Ok(None) };
        let [t, s, v, u, _] = self.dimensions;
        let (row, column) = self.shape.central_view();
        let all = [SliceOrIndex::from(0..v), (0..u).into()];
        let depth: ArrayD<f32> = match dataset.shape().as_slice() {
            shape if *shape == [t, s, v, u] => {
                read_part(&dataset, &[row.into(), (s - 1 - column).into(), all[0], all[1]], &self.path, self.limits)?
            }
            shape if *shape == [v, u] => read_part(&dataset, &all, &self.path, self.limits)?,
            shape => {
                let what = format!("/{name} has shape {shape:?}, which is neither that of all views nor of one");
                return Err(Error::broken(&self.path, FORMAT, what));
            }
        };
        let depth =
            depth.into_dimensionality::<Ix2>().map_err(|error| Error::broken(&self.path, FORMAT, error.to_string()))?;
        Ok(match (map, self.disparity) {
            (Hdf5Map::Depth, _) => Some(depth),
            (Hdf5Map::Disparity, Some([scale, shift])) => {
                Some(depth.mapv(|depth| (scale / f64::from(depth) - shift) as f32))
            }
            _ => None,
        })
    }
}

/// The rig of the same disparities. The focal length is in widths of the image, or in pixels: the baseline is then in the
/// unit of the depth.
fn rig(shape: LightFieldShape, [step, vertical]: [f64; 2], focal: f64, shift: f64) -> Option<Rig> {
    let lenses = shape.lenses();
    let larger = lenses.columns.max(lenses.rows) as f64;
    let columns = lenses.columns as f64;
    let (focal_px, baseline) = match focal.abs() < LARGEST_IN_WIDTHS {
        true => (focal * columns, [vertical, step].map(|step| step / columns)),
        false => (focal, [vertical, step]),
    };
    let focus_m = if shift == 0.0 { f64::INFINITY } else { step * focal / shift };
    Rig::builder(shape)
        .baseline_y_m(baseline[0].abs())
        .baseline_x_m(baseline[1].abs())
        .focal_length_m(focal_px * SENSOR_M / larger)
        .sensor_size_m(SENSOR_M)
        .focus_distance_m(focus_m)
        .build()
        .ok()
}
