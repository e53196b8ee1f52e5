//! The options of plenoptic cameras.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use holo_core::GridSize;
use holo_dataset::CalibrationBenchmark;
use holo_dataset::settings::positive as parse_positive;

use super::EngineOptions;

#[derive(Args, Debug)]
pub struct CameraOptions {
    /// Name of the preset, or a camera file, which is written with every key.
    pub name: Option<String>,
    /// File to write [default: the standard output].
    #[arg(long, value_name = "FILE", requires = "name")]
    pub out: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct WhiteOptions {
    /// Plenoptic camera: a camera file (TOML), or a preset of `holo camera`.
    #[arg(long, value_name = "FILE|PRESET")]
    pub camera_file: String,
    /// Also the white images at these f-numbers.
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = parse_positive)]
    pub f_numbers: Vec<f64>,
    /// Folder for white.exr, white.png and those of the f-numbers.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

#[derive(Args, Debug)]
pub struct TargetOptions {
    /// Plenoptic camera: a camera file (TOML), or a preset of `holo camera`.
    #[arg(long, value_name = "FILE|PRESET")]
    pub camera_file: String,
    /// Inner corners of the checkerboard, columns x rows.
    #[arg(long, value_name = "WxH", default_value = "9x5", value_parser = GridSize::from_str)]
    pub checkerboard: GridSize,
    /// Side of a square, mm.
    #[arg(long, value_name = "S", value_parser = parse_positive)]
    pub square_mm: f64,
    /// Poses, one image each: TOML with `[[pose]]`, `position_m = [x, y, z]` of the board's center before a camera that
    /// looks along -z, and `rotation_deg = [x, y, z]` [default: five around the focus].
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub spp: u32,
    /// Folder for the images, corners.csv, centers.csv and the white image; created if missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Replace another image in DIR. The same command again needs no permission.
    #[arg(long)]
    pub overwrite: bool,
    #[command(flatten)]
    pub engine: EngineOptions,
}

#[derive(Args, Debug)]
pub struct CalibrateOptions {
    /// White images of one f-number, in linear light: EXR, PNG or TIFF of floats (integers in a TIFF count as sRGB), or a `.RAW` of
    /// Lytro. Several have less noise than one.
    #[arg(required = true, value_name = "WHITE")]
    pub white: Vec<PathBuf>,
    /// Camera file to write (TOML).
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// What is known of the camera but for its microlens array: a camera file (TOML), or a preset of `holo camera`.
    #[arg(long, value_name = "FILE|PRESET", required_unless_present = "pixel_um", conflicts_with = "pixel_um")]
    pub camera_file: Option<String>,
    /// The width of a pixel, um, if nothing else is known. Depths then cannot follow from disparities.
    #[arg(long, value_name = "UM", value_parser = parse_positive)]
    pub pixel_um: Option<f64>,
    /// PNG of the centers that were found, in nine windows of the white image.
    #[arg(long, value_name = "FILE", value_parser = super::values::png)]
    pub image: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct EvalCalibrationOptions {
    /// The camera that was found: a camera file (TOML), `intrinsics.js` of COMPOTE, or a grid of micro-images alone, `*.grid.json` of
    /// LFToolbox.
    #[arg(value_name = "RESULT")]
    pub result: String,
    /// Folder of `holo target` with the true camera and its corners.
    #[arg(long, value_name = "DIR")]
    pub truth: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// A benchmark.
#[derive(Subcommand, Debug)]
pub enum Benchmark {
    /// Boards and white images of seven plenoptic cameras, each behind a thin lens and behind glass, with the truth. Continues where
    /// it was stopped.
    Calibration(CalibrationBenchmarkOptions),
}

#[derive(Args, Debug)]
pub struct CalibrationBenchmarkOptions {
    /// Folder for the benchmark; created if missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Sensors and boards of full size [default: a quarter of the pixels, with microlenses of full size].
    #[arg(long)]
    pub full: bool,
    /// These cameras only.
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = PossibleValuesParser::new(CalibrationBenchmark::camera_names()))]
    pub cameras: Vec<String>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub spp: u32,
    /// Say how much it is, and stop.
    #[arg(long)]
    pub dry_run: bool,
    /// Replace other images in DIR. The same command again needs no permission.
    #[arg(long)]
    pub overwrite: bool,
    #[command(flatten)]
    pub engine: EngineOptions,
}

#[derive(Args, Debug)]
pub struct DecodeOptions {
    /// The raw image: raw.exr, or a PNG in linear light such as raw_linear.png, whose views are then relative to its
    /// brightest code; the folder of either; or .lfp, .lfr, .raw of a Lytro camera.
    pub raw: PathBuf,
    /// The white image, also MOD_NNNN.RAW of a Lytro camera [default: computed from the camera].
    #[arg(long, value_name = "FILE")]
    pub white: Option<PathBuf>,
    /// Plenoptic camera: a camera file (TOML), or a preset of `holo camera` [default: camera.toml beside the raw image, or that
    /// of the Lytro's metadata].
    #[arg(long, value_name = "FILE|PRESET")]
    pub camera_file: Option<String>,
    /// Of a focused camera: the depth of the pixels of the raw image, such as raw_depth.pfm [default: an estimate].
    #[arg(long, value_name = "FILE.pfm")]
    pub depth: Option<PathBuf>,
    /// Views along each axis [default: those whose pixels are fully lit; of a focused camera 5].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub views: Option<u32>,
    /// The scene that was rendered: adds depth and disparity of the central view.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Name or number of the scene's camera [default: the first].
    #[arg(long, value_name = "NAME|INDEX", requires = "scene")]
    pub camera: Option<String>,
    /// Folder for the light field; created if missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Replace another image in DIR. The same command again needs no permission.
    #[arg(long)]
    pub overwrite: bool,
    #[command(flatten)]
    pub engine: EngineOptions,
}
