//! The options of `holo optics`.

use std::path::PathBuf;

use clap::Args;
use holo_dataset::settings::positive as parse_positive;

use super::settings::{OfOptics, Settings};
use super::values;

/// A camera in numbers, or that of a file.
#[derive(Args, Debug)]
pub struct OpticsOptions {
    /// Folder or file whose camera parameters are used instead of numbers.
    #[arg(conflicts_with_all = ["sensor", "f-number", "views", "lenses", "lens_pitch_mm", "baseline-m", "focal-mm", "sensor-mm", "focus-m", "disparity"])]
    pub input: Option<PathBuf>,
    /// Plenoptic camera instead of a rig: a camera file (TOML), or a preset of `holo camera`.
    #[arg(long, value_name = "FILE|PRESET", conflicts_with_all = ["input", "sensor", "views", "lenses", "lens_pitch_mm", "baseline-m", "focal-mm", "sensor-mm", "disparity"])]
    pub camera_file: Option<String>,
    #[command(flatten)]
    pub settings: Settings<OfOptics>,
    /// Microlens pitch, mm: the number of views is the number of pixels behind one microlens.
    #[arg(long, value_name = "P", conflicts_with_all = ["views", "lenses", "baseline-m", "disparity"], value_parser = parse_positive)]
    pub lens_pitch_mm: Option<f64>,
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
    /// Also draw what a main lens of glass does, from the axis to the corner, as curves in this image (.svg).
    #[arg(long, value_name = "FILE.svg", requires = "camera_file", value_parser = values::svg)]
    pub plot: Option<PathBuf>,
    /// Print one JSON object on standard output instead of a table.
    #[arg(long)]
    pub json: bool,
}
