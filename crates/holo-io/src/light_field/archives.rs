//! Archives whose files do not say themselves in which order they hold the views.

use std::path::{Path, PathBuf};

use holo_core::{DynImage, DynLightField, GridSize, Layout, LightField, LightFieldShape, Rig, for_each_sample};
use ndarray::{Array3, Axis, Slice};

/// Views along an axis of a Lytro's ESLF.
pub(super) const ESLF_VIEWS: usize = 14;

/// The distance of the plane in focus, and the width of it that the views see, of the MIT archive, m.
const MIT_FOCUS_M: f64 = 1.27;
const MIT_WIDTH_M: f64 = 0.5;

/// The sensor width that stands for the unknown one, m.
const SENSOR_M: f64 = 0.035;

/// Whether a file is named as an ESLF of Lytro Desktop: `NAME_eslf.png` or `NAME.eslf.png`. That is an elemental image array
/// of 14 x 14 views, whose last row or column of microlenses may be cut off.
pub(super) fn is_eslf(path: &Path) -> bool {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    stem.ends_with("_eslf") || stem.ends_with(".eslf")
}

/// The shape of an ESLF of this size in pixels.
pub(super) fn eslf_shape(size: GridSize, views: GridSize) -> Result<LightFieldShape, holo_core::Error> {
    let lenses = GridSize::new(size.rows.div_ceil(views.rows), size.columns.div_ceil(views.columns));
    LightFieldShape::new(views, lenses)
}

/// The light field of an ESLF. Pixels beyond the image are 0.
pub(super) fn eslf(image: DynImage, shape: LightFieldShape) -> Result<DynLightField, holo_core::Error> {
    fn padded<T: Clone + Default>(image: Array3<T>, raw: GridSize) -> Array3<T> {
        let (rows, columns, channels) = image.dim();
        if (rows, columns) == (raw.rows, raw.columns) {
            return image;
        }
        let mut whole = Array3::from_elem((raw.rows, raw.columns, channels), T::default());
        let mut part = whole.slice_axis_mut(Axis(0), Slice::from(..rows));
        part.slice_axis_mut(Axis(1), Slice::from(..columns)).assign(&image);
        whole
    }
    let raw = shape.raw_size();
    let image: DynImage = for_each_sample!(DynImage, image, image => padded(image, raw).into());
    DynLightField::from_grid(image, Layout::ElementalGrid, shape)
}

/// The same views in reversed order of their rows, of their columns, or of both.
pub(super) fn reversed(field: DynLightField, rows: bool, columns: bool) -> Result<DynLightField, holo_core::Error> {
    for_each_sample!(DynLightField, field, field => {
        let mut samples = field.into_samples();
        for (axis, is_reversed) in [(2, rows), (3, columns)] {
            if is_reversed {
                samples.invert_axis(Axis(axis));
            }
        }
        LightField::new(samples).map(DynLightField::from)
    })
}

/// A folder of the perspective views of the MIT Synthetic Light Field Archive (Wetzstein et al.): `NAME-01.png` to
/// `NAME-25.png` in a folder `NAME_5x5_apA`, with A the width of the aperture: in millimeters, if it is 10 or more, else in
/// centimeters. Views are numbered row by row from the lower left.
pub(super) struct MitFolder {
    pub views: GridSize,
    pub aperture_m: f64,
}

impl MitFolder {
    /// By the name of a folder; `None` if it is another.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().into_owned();
        let (rest, aperture) = name.rsplit_once("_ap")?;
        let (columns, rows) = rest.rsplit_once('_')?.1.split_once('x')?;
        let views = GridSize::new(rows.parse().ok()?, columns.parse().ok()?);
        let aperture: f64 = aperture.parse().ok().filter(|aperture: &f64| *aperture > 0.0 && aperture.is_finite())?;
        let aperture_m = if aperture >= 10.0 { aperture / 1e3 } else { aperture / 1e2 };
        (views.rows > 0 && views.columns > 0).then_some(Self { views, aperture_m })
    }

    /// Whether the files are numbered from 1 to the number of views.
    pub fn has(&self, files: &[PathBuf]) -> bool {
        let number = |file: &PathBuf| -> Option<usize> {
            let stem = file.file_stem()?.to_string_lossy().into_owned();
            let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
            stem[stem.len() - digits..].parse().ok()
        };
        files.len() == self.views.count() && files.iter().enumerate().all(|(k, file)| number(file) == Some(k + 1))
    }

    /// The rig, which the README of the archive describes.
    pub fn rig(&self, shape: LightFieldShape) -> Option<Rig> {
        let baseline = |count: usize| if count > 1 { self.aperture_m / (count - 1) as f64 } else { 0.0 };
        let lenses = shape.lenses();
        let larger = lenses.columns.max(lenses.rows) as f64 / lenses.columns as f64;
        Rig::builder(shape)
            .baseline_y_m(baseline(self.views.rows))
            .baseline_x_m(baseline(self.views.columns))
            .focal_length_m(SENSOR_M * MIT_FOCUS_M / (MIT_WIDTH_M * larger))
            .sensor_size_m(SENSOR_M)
            .focus_distance_m(MIT_FOCUS_M)
            .build()
            .ok()
    }
}
