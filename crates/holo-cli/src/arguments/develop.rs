//! Options of `holo develop` and `holo demosaic`.

use std::path::PathBuf;

use clap::Args;
use holo_dataset::DevelopOutput;
use holo_dataset::settings::{Malformed, SensorName, SettingType, positive as parse_positive};

use super::choices::{DEMOSAIC, DEVELOP_OUTPUTS, DemosaicArgument, choice};

#[derive(Args, Clone, Debug)]
pub struct DevelopOptions {
    /// The image in linear light: raw.exr of a plenoptic camera, an elemental image array, a white image; EXR, PFM or PNG.
    /// A PNG that says so is on the sRGB curve.
    pub image: PathBuf,
    /// The codes: NAME.png or NAME.dng. Other files are written beside it, and NAME.json with sensor and exposure.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Camera file or preset, whose sensor has noise.
    #[arg(long, value_name = "FILE|PRESET")]
    pub camera_file: Option<String>,
    /// A sensor: imx250, cmv12000, lytro-illum or lytro-f01 [default: that of the camera file].
    #[arg(long, value_name = "NAME", value_parser = parse_sensor_model)]
    pub sensor_model: Option<String>,
    /// Film speed: gain relative to that of the sensor's base speed [default: the base speed].
    #[arg(long, value_name = "ISO", value_parser = parse_positive)]
    pub iso: Option<f64>,
    /// Electrons of a pixel of value 1, or `auto`: 99 % of the lit pixels below 80 % of saturation [default: as in the
    /// camera file, else auto].
    #[arg(long, value_name = "N|auto", value_parser = parse_electrons)]
    pub electrons: Option<f64>,
    /// Exposure time, s, for the dark current [default: 0.01].
    #[arg(long, value_name = "SECONDS", value_parser = parse_positive)]
    pub exposure_s: Option<f64>,
    /// Seed of the noise.
    #[arg(long, default_value = "0")]
    pub seed: u64,
    /// Camera of the kind: frames of one camera share its fixed pattern.
    #[arg(long, value_name = "N", default_value = "0")]
    pub camera_seed: u64,
    /// Number of the frame.
    #[arg(long, value_name = "N", default_value = "0")]
    pub frame: u64,
    /// Write the mean of so many frames, as for white images.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u64).range(1..=65_536))]
    pub frames: u64,
    /// Keep the shutter closed: a dark frame of the size of the image.
    #[arg(long)]
    pub dark: bool,
    /// Files to write, separated by commas [default: all that the sensor has].
    #[arg(long, value_name = "FILE,..", value_parser = choice(DEVELOP_OUTPUTS), value_delimiter = ',')]
    pub write: Option<Vec<DevelopOutput>>,
    /// Print no summary.
    #[arg(long)]
    pub quiet: bool,
}

#[derive(Args, Clone, Debug)]
pub struct DemosaicOptions {
    /// The codes: NAME.png of `holo develop`, with NAME.json beside it.
    pub mosaic: PathBuf,
    /// The image: .exr, .pfm, or .png of 16 bits in linear light.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// How the missing colors are found [default: malvar; with a camera micro-images].
    #[arg(long, value_parser = choice(DEMOSAIC))]
    pub method: Option<DemosaicArgument>,
    /// The plenoptic camera whose micro-images do not mix.
    #[arg(long, value_name = "FILE|PRESET")]
    pub camera_file: Option<String>,
    /// Print no summary.
    #[arg(long)]
    pub quiet: bool,
}

/// Infinity stands for `auto`.
fn parse_electrons(text: &str) -> Result<f64, Malformed> {
    if text == "auto" { Ok(f64::INFINITY) } else { parse_positive(text) }
}

/// The name of a sensor.
fn parse_sensor_model(text: &str) -> Result<String, Malformed> {
    SensorName::parse(text).map(|sensor| sensor.name().to_owned())
}
