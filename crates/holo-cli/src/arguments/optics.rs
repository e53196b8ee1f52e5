//! The options of `holo optics`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use holo_core::GridSize;

use holo_dataset::options::parse_positive;

use super::{MainLensOptions, values};

/// A camera in numbers, or that of a file.
#[derive(Args, Debug)]
pub struct OpticsOptions {
    /// Folder or file whose camera parameters are used instead of numbers.
    #[arg(conflicts_with_all = ["sensor", "f_number", "views", "lenses", "lens_pitch_mm", "baseline_m", "focal_mm", "sensor_mm", "focus_m", "disparity"])]
    pub input: Option<PathBuf>,
    /// Plenoptic camera instead of a rig: a camera file (TOML), or a preset of `holo camera`.
    #[arg(long, value_name = "FILE|PRESET", conflicts_with_all = ["input", "sensor", "views", "lenses", "lens_pitch_mm", "baseline_m", "focal_mm", "sensor_mm", "disparity"])]
    pub camera_file: Option<String>,
    #[command(flatten)]
    pub main_lens: MainLensOptions,
    /// Views, columns x rows, or one number for both [default: 100x100].
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, value_parser = GridSize::from_str)]
    pub views: Option<GridSize>,
    /// Lenses, columns x rows: the microlenses, which are the pixels of one view; instead of a sensor.
    #[arg(long, value_name = "UxV", conflicts_with_all = ["sensor", "lens_pitch_mm"], value_parser = GridSize::from_str)]
    pub lenses: Option<GridSize>,
    /// Microlens pitch, mm: the number of views is the number of pixels behind one microlens.
    #[arg(long, value_name = "P", conflicts_with_all = ["views", "disparity"], value_parser = parse_positive)]
    pub lens_pitch_mm: Option<f64>,
    /// Baseline: distance between adjacent views, m.
    #[arg(long, value_name = "B", conflicts_with_all = ["f_number", "lens_pitch_mm", "disparity"], value_parser = parse_positive)]
    pub baseline_m: Option<f64>,
    /// Focal length of the main lens, mm.
    #[arg(long, value_name = "F", default_value_t = 50.0, value_parser = parse_positive)]
    pub focal_mm: f64,
    /// Sensor size: length of the larger image side, mm.
    #[arg(long, value_name = "S", default_value_t = 36.0, value_parser = parse_positive)]
    pub sensor_mm: f64,
    /// Nearest and farthest depth of the scene, m; the farthest may be `inf`.
    #[arg(long, value_name = "NEAR,FAR", value_parser = values::depths)]
    pub depths_m: Option<(f64, f64)>,
    /// Largest acceptable magnitude of disparity, px.
    #[arg(long, value_name = "W", default_value_t = 2.0, value_parser = parse_positive)]
    pub limit_px: f64,
    /// Smallest disparity step that an estimator resolves, px.
    #[arg(long, value_name = "D", default_value_t = 0.1, value_parser = parse_positive)]
    pub step_px: f64,
    /// Circle of confusion: width of the blur of a point that still counts as sharp, px.
    #[arg(long, value_name = "C", default_value_t = 1.0, value_parser = parse_positive)]
    pub circle_px: f64,
    /// Print one JSON object on standard output instead of a table.
    #[arg(long)]
    pub json: bool,
}
