//! The options of `holo array`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use holo_core::GridSize;
use holo_dataset::settings::{not_negative, positive as parse_positive, range as parse_range};
use holo_io::WorldUp;

use super::choices::{SURFACES, SurfaceArgument, WORLD_UPS, choice};
use super::values;

/// The heading of deviations in the help.
const JITTER: &str = "Deviations, as those of real arrays";

#[derive(Args, Debug)]
pub struct ArrayOptions {
    /// Where the cameras stand.
    #[arg(value_parser = choice(SURFACES))]
    pub surface: SurfaceArgument,
    /// Cameras: in one row, or columns x rows; on a sphere their number.
    #[arg(long, value_name = "N|SxT", value_parser = values::cameras)]
    pub count: GridSize,
    /// Distance between neighbors along rows and, where it differs, columns, m; of a cylinder between rows.
    #[arg(long, value_name = "X[,Y]", default_value = "0.1", value_parser = values::spacing)]
    pub spacing_m: [f64; 2],
    /// Distance from the target, m.
    #[arg(long, value_name = "R", default_value_t = 1.0, value_parser = parse_positive)]
    pub radius_m: f64,
    /// What the cameras look at, m, in the world of the scene (+Y up).
    #[arg(long = "target", alias = "target-m", value_name = "X,Y,Z", allow_hyphen_values = true, default_value = "0,0,0", value_parser = values::point)]
    pub target_m: [f64; 3],
    /// Angle that the columns of a cylinder cover, degrees.
    #[arg(long, value_name = "A", default_value_t = 360.0, value_parser = parse_positive)]
    pub span_deg: f64,
    /// Lowest and highest elevation on a sphere, degrees above the horizon.
    #[arg(long, value_name = "MIN,MAX", allow_hyphen_values = true, default_value = "0,80", value_parser = parse_range)]
    pub elevation_deg: (f64, f64),
    /// Size of every image, px.
    #[arg(long, value_name = "WxH", default_value = "800x800", value_parser = GridSize::from_str)]
    pub size: GridSize,
    /// Horizontal angle of view, degrees.
    #[arg(long = "fov-deg", alias = "angle-deg", value_name = "A", default_value_t = 40.0, value_parser = parse_positive)]
    pub angle_deg: f64,
    /// How far positions deviate from what is meant, m: a standard deviation along each axis.
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = not_negative, help_heading = JITTER)]
    pub jitter_position_m: f64,
    /// How far cameras are turned, degrees about each axis.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = not_negative, help_heading = JITTER)]
    pub jitter_rotation_deg: f64,
    /// Deviation of focal lengths, relative, such as 0.01: cameras are focused differently.
    #[arg(long, value_name = "PART", default_value_t = 0.0, value_parser = not_negative, help_heading = JITTER)]
    pub jitter_focal: f64,
    /// Deviation of the gain, relative.
    #[arg(long, value_name = "PART", default_value_t = 0.0, value_parser = not_negative, help_heading = JITTER)]
    pub jitter_gain: f64,
    /// Deviation of the gain of each color besides, relative.
    #[arg(long, value_name = "PART", default_value_t = 0.0, value_parser = not_negative, help_heading = JITTER)]
    pub jitter_color: f64,
    /// Cameras see a moving scene up to so many seconds later, evenly distributed.
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = not_negative, help_heading = JITTER)]
    pub jitter_time_s: f64,
    /// Seed of the deviations; the file has them.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = JITTER)]
    pub seed: u64,
    /// The axis that points up in the world of the file: z for Blender and nerfstudio, y as in glTF.
    #[arg(long, value_name = "z|y", default_value = "z", value_parser = choice(WORLD_UPS))]
    pub transforms_up: WorldUp,
    /// File to write.
    #[arg(long, value_name = "FILE", default_value = "transforms.json")]
    pub out: PathBuf,
}
