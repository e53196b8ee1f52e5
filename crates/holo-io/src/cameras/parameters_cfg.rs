//! `parameters.cfg`: the camera parameters of a light field, with the keys of the HCI benchmark.
//!
//! The file is an INI file in the dialect of Python's `configparser`: `key = value`, `=` as the only delimiter, `%%`
//! for a percent sign.

mod ini;
mod keys;
mod pose;

use std::collections::BTreeMap;
use std::path::Path;

use holo_core::{GridSize, LightFieldShape, Projection, Rig};

use crate::error::STREAM;
use crate::files::folder::{Destination, Folder};
use crate::files::limits::read_small_file;
use crate::{Error, FileDigest, meters_to_millimeters, millimeters_to_meters, write_file};

pub use pose::CameraPose;

/// Maximum size of a `parameters.cfg`, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The contents of a `parameters.cfg`, in the units of the file.
///
/// Fields that are `None` or empty may be missing from a file that is read. The writer omits a number that is `None`,
/// and writes an empty text as an empty value. Unknown keys are kept in [`other`](Self::other) and written again.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Rig, LightFieldShape};
/// use holo_io::ParametersCfg;
///
/// let rig = Rig::builder(LightFieldShape::new(GridSize::new(9, 9), GridSize::new(512, 512))?)
///     .focal_length_m(0.1)
///     .sensor_size_m(0.035)
///     .baseline_m(0.025)
///     .focus_distance_m(4.25)
///     .build()?;
/// let mut parameters = ParametersCfg::from_rig(&rig);
/// parameters.scene = "cotton".into();
/// let text = parameters.to_text()?;
/// assert!(text.starts_with("[intrinsics]\nfocal_length_mm = 100.0\nimage_resolution_x_px = 512\n"));
/// let read = ParametersCfg::from_text(&text)?;
/// assert_eq!(read, parameters);
/// assert_eq!(read.rig()?, rig);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ParametersCfg {
    /// Focal length of the camera of every view, mm.
    pub focal_length_mm: f64,
    /// Pixels of one view: `image_resolution_y_px` rows (V microlenses) and `image_resolution_x_px` columns (U
    /// microlenses).
    pub image_resolution_px: GridSize,
    /// Size of the sensor along the larger side of a view, mm.
    pub sensor_size_mm: f64,
    /// The f-number of the camera of a view; 100 stands for a pinhole.
    pub fstop: Option<f64>,
    /// Number of views: `num_cams_y` rows (T) and `num_cams_x` columns (S).
    pub num_cams: GridSize,
    /// Distance between horizontally adjacent views, mm.
    pub baseline_mm: f64,
    /// Distance between vertically adjacent views, mm, where it differs. The key `baseline_y_mm` is an extension of the
    /// HCI format.
    pub baseline_y_mm: Option<f64>,
    /// Distance of the focus plane, m; infinity is 0 in the file.
    pub focus_distance_m: f64,
    /// Projection of the views; perspective if the file has no such key. The key `projection` is an extension of the
    /// HCI format, written only for orthographic views.
    pub projection: Projection,
    /// Position `center_cam_{x,y,z}_m` and rotation `center_cam_r{x,y,z}_rad` of the rig in Blender's world space.
    pub center_cam: Option<CameraPose>,
    /// Disparity that the sensor shift subtracts, in pixels: `b f N / (s F)`.
    pub offset: Option<f64>,
    /// Name of the scene.
    pub scene: String,
    /// Category of the scene.
    pub category: String,
    /// Date of rendering; see [`date_from_epoch`] for a reproducible one.
    pub date: String,
    /// Version of the scene.
    pub version: String,
    /// Authors, separated by `, `.
    pub authors: String,
    /// Contact of the authors.
    pub contact: String,
    /// Random seed; -1 in files of the HCI tools that were written without a render.
    pub cycles_seed: Option<i64>,
    /// Smallest disparity of the scene in pixels between horizontally adjacent views.
    pub disp_min: Option<f64>,
    /// Largest disparity of the scene in pixels between horizontally adjacent views.
    pub disp_max: Option<f64>,
    /// Smallest disparity of the frustum preview of the HCI tools, pixels.
    pub frustum_disp_min: Option<f64>,
    /// Largest disparity of the frustum preview of the HCI tools, pixels.
    pub frustum_disp_max: Option<f64>,
    /// Resolution of the high-resolution ground truth, relative to that of a view.
    pub depth_map_scale: Option<f64>,
    /// Unknown keys with their values, by section and key.
    pub other: BTreeMap<(String, String), String>,
}

impl ParametersCfg {
    /// Returns the parameters of a rig. Texts, pose and disparities are empty; `fstop` is 100, `depth_map_scale` 1 and
    /// `cycles_seed` 0, as the HCI tools set them.
    #[must_use]
    pub fn from_rig(rig: &Rig) -> Self {
        let focal_length_mm = meters_to_millimeters(rig.focal_length_m());
        let sensor_size_mm = meters_to_millimeters(rig.sensor_size_m());
        let baseline_mm = meters_to_millimeters(rig.baseline_x_m());
        let lenses = rig.shape().lenses();
        // The formula of the HCI tools; an infinite focus distance gives 0.
        let offset =
            baseline_mm * focal_length_mm / rig.focus_distance_m() / 1000.0 / sensor_size_mm * lenses.larger() as f64;
        Self {
            focal_length_mm,
            image_resolution_px: lenses,
            sensor_size_mm,
            fstop: Some(100.0),
            num_cams: rig.shape().views(),
            baseline_mm,
            baseline_y_mm: (rig.baseline_y_m() != rig.baseline_x_m())
                .then(|| meters_to_millimeters(rig.baseline_y_m())),
            focus_distance_m: rig.focus_distance_m(),
            projection: rig.projection(),
            center_cam: None,
            offset: Some(offset),
            scene: String::new(),
            category: String::new(),
            date: String::new(),
            version: String::new(),
            authors: String::new(),
            contact: String::new(),
            cycles_seed: Some(0),
            disp_min: None,
            disp_max: None,
            frustum_disp_min: None,
            frustum_disp_max: None,
            depth_map_scale: Some(1.0),
            other: BTreeMap::new(),
        }
    }

    /// Returns the rig.
    ///
    /// # Errors
    ///
    /// [`Error::Core`] if the numbers make no rig.
    pub fn rig(&self) -> Result<Rig, Error> {
        let shape = LightFieldShape::new(self.num_cams, self.image_resolution_px);
        let baseline_x_m = millimeters_to_meters(self.baseline_mm);
        let core = |error| Error::core(Path::new(STREAM), error);
        Rig::builder(shape.map_err(core)?)
            .focal_length_m(millimeters_to_meters(self.focal_length_mm))
            .sensor_size_m(millimeters_to_meters(self.sensor_size_mm))
            .baseline_x_m(baseline_x_m)
            .baseline_y_m(self.baseline_y_mm.map_or(baseline_x_m, millimeters_to_meters))
            .focus_distance_m(self.focus_distance_m)
            .projection(self.projection)
            .build()
            .map_err(core)
    }

    /// Sets `disp_min` and `disp_max` to a disparity range in pixels, rounded as the HCI tools do: `floor(10 min)/10 -
    /// 0.1` and `ceil(10 max)/10 + 0.1`.
    pub fn set_disparity_range_px(&mut self, min_px: f64, max_px: f64) {
        // In whole tenths until the one division, so that -2.0 does not come out as -2.0000000000000004.
        self.disp_min = Some(((10.0 * min_px).floor() - 1.0) / 10.0);
        self.disp_max = Some(((10.0 * max_px).ceil() + 1.0) / 10.0);
    }

    /// Returns the text of the file.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a text has a control character, such as a line feed, or a name in `other` cannot be
    /// written.
    pub fn to_text(&self) -> Result<String, Error> {
        keys::write(self, Path::new(STREAM))
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    ///
    /// [`Error::Broken`] if a line is neither a section, a comment nor `key = value`, if a key occurs twice, if the
    /// value of a number does not parse, or if a number of the rig is missing: focal length, resolution, sensor size,
    /// number of cameras, baseline, focus distance. [`Error::Unsupported`] if the projection is unknown.
    pub fn from_text(text: &str) -> Result<Self, Error> {
        keys::read(text, Path::new(STREAM))
    }

    /// Writes the file, usually called `parameters.cfg`.
    ///
    /// # Errors
    ///
    /// Those of [`ParametersCfg::to_text`], and [`Error::Io`] if the file cannot be written.
    pub fn write(&self, path: impl Destination) -> Result<FileDigest, Error> {
        let text = keys::write(self, path.path())?;
        write_file(path, text.as_bytes())
    }

    /// Reads a file. Text that is not UTF-8 is decoded as Latin-1.
    ///
    /// # Errors
    ///
    /// Those of [`ParametersCfg::from_text`]; [`Error::Io`] if the file cannot be read; [`Error::TooLarge`] if it has
    /// more than 1 MiB.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::decode(read_small_file(path, MAX_BYTES)?, path)
    }

    /// Reads a file of an open folder, like [`ParametersCfg::read`].
    ///
    /// # Errors
    ///
    /// Those of [`ParametersCfg::read`] and [`Folder::open_regular`].
    pub fn read_in(folder: &Folder, name: &str) -> Result<Self, Error> {
        Self::decode(folder.read(name, MAX_BYTES)?, &folder.path_of(name))
    }

    fn decode(bytes: Vec<u8>, path: &Path) -> Result<Self, Error> {
        let text = String::from_utf8(bytes)
            .unwrap_or_else(|error| error.as_bytes().iter().map(|&byte| char::from(byte)).collect());
        keys::read(&text, path)
    }
}

/// Formats a number of seconds since 1970, such as `SOURCE_DATE_EPOCH`, as a date `YYYY-MM-DD` (UTC): the form of the
/// HCI tools.
///
/// No function of this crate reads a clock, so equal inputs give equal files. A caller that wants a date in a file
/// passes a fixed one.
#[must_use]
pub fn date_from_epoch(seconds: i64) -> String {
    // Days to civil date in the proleptic Gregorian calendar. Years begin in March, so that leap days come last.
    let days = i128::from(seconds.div_euclid(86_400)) + 719_468;
    let (era, day_of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = year_of_era + era * 400 + i128::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, date) in [
            (0, "1970-01-01"),
            (-1, "1969-12-31"),
            (951_782_400, "2000-02-29"),
            (951_868_800, "2000-03-01"),
            (1_700_000_000, "2023-11-14"),
            (4_107_542_399, "2100-02-28"),
            (4_107_542_400, "2100-03-01"),
        ] {
            assert_eq!(date_from_epoch(seconds), date);
        }
        // No overflow at either end.
        let _ = (date_from_epoch(i64::MIN), date_from_epoch(i64::MAX));
    }
}
