//! The options of `holo optics`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use holo_core::GridSize;

use holo_dataset::options::parse_positive;

use super::{MainLensOptions, values};

/// A camera in numbers, or one that is there.
#[derive(Args, Debug)]
pub struct OpticsOptions {
    /// A folder or file whose rig is looked at instead of one from numbers.
    #[arg(conflicts_with_all = ["sensor", "f_number", "views", "lenses", "lens_pitch_mm", "baseline_m", "focal_mm", "sensor_mm", "focus_m", "wanted"])]
    pub input: Option<PathBuf>,
    #[command(flatten)]
    pub main_lens: MainLensOptions,
    /// Views, columns x rows, or one number for both [default: 100x100].
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, value_parser = GridSize::from_str)]
    pub views: Option<GridSize>,
    /// Lenses, columns x rows (the pixels of one view), instead of a sensor.
    #[arg(long, value_name = "UxV", conflicts_with_all = ["sensor", "lens_pitch_mm"], value_parser = GridSize::from_str)]
    pub lenses: Option<GridSize>,
    /// Distance between neighbouring micro-lenses, mm: tells the views from the pixels behind one lens.
    #[arg(long, value_name = "P", conflicts_with = "views", value_parser = parse_positive)]
    pub lens_pitch_mm: Option<f64>,
    /// Distance between neighbouring views, m.
    #[arg(long, value_name = "B", conflicts_with_all = ["f_number", "lens_pitch_mm"], value_parser = parse_positive)]
    pub baseline_m: Option<f64>,
    /// Focal length of the main lens, mm.
    #[arg(long, value_name = "F", default_value_t = 50.0, value_parser = parse_positive)]
    pub focal_mm: f64,
    /// Length of the larger image side on the sensor, mm.
    #[arg(long, value_name = "S", default_value_t = 36.0, value_parser = parse_positive)]
    pub sensor_mm: f64,
    /// Nearest and farthest depth of what will be photographed, m; the farthest may be `inf`.
    #[arg(long, value_name = "NEAR,FAR", value_parser = values::depths)]
    pub depths_m: Option<(f64, f64)>,
    /// Find focus and baseline for which the depths have these disparities, px: least and greatest.
    #[arg(long, value_name = "MIN,MAX", id = "wanted", requires = "depths_m", allow_hyphen_values = true, conflicts_with_all = ["baseline_m", "f_number", "focus_m", "lens_pitch_mm"], value_parser = values::range)]
    pub disparity: Option<(f64, f64)>,
    /// The largest disparity that is welcome, px, of either sign.
    #[arg(long, value_name = "W", default_value_t = 2.0, value_parser = parse_positive)]
    pub limit_px: f64,
    /// The smallest difference of disparity that an estimate tells apart, px.
    #[arg(long, value_name = "D", default_value_t = 0.1, value_parser = parse_positive)]
    pub step_px: f64,
    /// What counts as sharp in a picture of all views: the width of a point's blur, px.
    #[arg(long, value_name = "C", default_value_t = 1.0, value_parser = parse_positive)]
    pub circle_px: f64,
    /// One JSON object on standard output instead of a table.
    #[arg(long)]
    pub json: bool,
}
