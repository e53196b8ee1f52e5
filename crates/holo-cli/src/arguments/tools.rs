//! The options of the commands that look at a light field: refocus, depth, eval, epi.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{ArgGroup, Args, ValueEnum};
use holo_core::GridSize;

use holo_dataset::options::parse_positive;

use super::{LayoutArgument, OrderArgument, Pair, values};

/// A light field and what it is.
#[derive(Args, Clone, Debug)]
pub struct InputOptions {
    /// A raw PNG, a .mat, an .h5, or a folder: of `holo render`, of the HCI benchmark, of a gantry, or of images, one a view.
    pub input: PathBuf,
    /// What the input is [default: by `_el` or `_vpi` in its name].
    #[arg(long, value_enum)]
    pub from: Option<LayoutArgument>,
    /// Views, columns x rows, or one number for both [default: from the parameters.cfg beside the input].
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, value_parser = GridSize::from_str)]
    pub views: Option<GridSize>,
    /// The order of the images of a folder of images.
    #[arg(long, value_enum, default_value_t = OrderArgument::RowMajor)]
    pub order: OrderArgument,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("focus").required(true).args(["disparity", "distance_m", "slope", "all_in_focus", "stack"])))]
pub struct RefocusOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Sharp where points move by so many pixels between neighbouring views.
    #[arg(long, value_name = "D", allow_negative_numbers = true, value_parser = values::finite)]
    pub disparity: Option<f64>,
    /// Sharp at this distance, m, or `inf`; needs a rig.
    #[arg(long, value_name = "Z", allow_negative_numbers = true, value_parser = values::distance)]
    pub distance_m: Option<f64>,
    /// Sharp where the Light Field Toolbox is at this slope.
    #[arg(long, value_name = "SLOPE", allow_negative_numbers = true, value_parser = values::finite)]
    pub slope: Option<f64>,
    /// Sharp everywhere, by a map of disparity.
    #[arg(long, value_name = "MAP.pfm")]
    pub all_in_focus: Option<PathBuf>,
    /// N pictures, sharp from disparity A to B; FILE gets a number.
    #[arg(long, value_name = "A,B,N", allow_hyphen_values = true, value_parser = values::stack)]
    pub stack: Option<(f64, f64, usize)>,
    /// Which views are added up: all, disc:D, square:D or gaussian:D, D in views.
    #[arg(long, value_name = "SHAPE", default_value = "all", value_parser = values::aperture)]
    pub aperture: ApertureArgument,
    /// How a view is sampled between its pixels.
    #[arg(long, value_enum, default_value_t = KernelArgument::Cubic)]
    pub kernel: KernelArgument,
    /// The picture to write: .png, or .pfm for linear floats.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

/// `--aperture`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApertureArgument {
    All,
    Disc(f64),
    Square(f64),
    Gaussian(f64),
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum KernelArgument {
    /// Catmull and Rom's cubic: sharper.
    Cubic,
    /// The two or four nearest pixels.
    Bilinear,
}

#[derive(Args, Debug)]
pub struct DepthOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// The estimate to write: disparity of the central view, px between neighbouring views.
    #[arg(long, value_name = "FILE.pfm")]
    pub out: PathBuf,
    /// Least and greatest disparity to look for [default: those of parameters.cfg, else -4,4].
    #[arg(long, value_name = "MIN,MAX", allow_hyphen_values = true, value_parser = values::range)]
    pub range: Option<(f64, f64)>,
    /// How much work it is worth.
    #[arg(long, value_enum, default_value_t = EffortArgument::Balanced)]
    pub effort: EffortArgument,
    /// How sure the estimate is, 0 to 1, as another map.
    #[arg(long, value_name = "FILE.pfm")]
    pub confidence: Option<PathBuf>,
    /// No summary.
    #[arg(long)]
    pub quiet: bool,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffortArgument {
    /// A handful of views.
    Draft,
    Fast,
    Balanced,
    /// All that helps.
    Thorough,
}

#[derive(Args, Debug)]
pub struct EvalOptions {
    /// What is judged: a disparity map (.pfm) or a picture (.png).
    pub estimate: PathBuf,
    /// What it is held against, of the same kind and size.
    pub truth: PathBuf,
    /// Pixels at every edge that do not count (maps only).
    #[arg(long, value_name = "PX", default_value_t = 15)]
    pub border: usize,
    /// Only pixels where this picture is not black (maps only).
    #[arg(long, value_name = "FILE.png")]
    pub mask: Option<PathBuf>,
    /// The signed error as a picture: red too far, white right, blue too near.
    #[arg(long, value_name = "FILE.png", value_parser = values::png)]
    pub error_map: Option<PathBuf>,
    /// The error at which the picture's colours are full, px.
    #[arg(long, value_name = "PX", default_value_t = 0.2, value_parser = parse_positive)]
    pub error_range: f64,
    /// One JSON object on standard output instead of a table.
    #[arg(long)]
    pub json: bool,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("slice").required(true).args(["row", "column"])))]
pub struct EpiOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Row V of the pixels, as the views of view row T see it, from 0.
    #[arg(long, value_name = "V,T", value_parser = values::row_of_pixels)]
    pub row: Option<Pair>,
    /// Column U of the pixels, as the views of view column S see it, from 0.
    #[arg(long, value_name = "U,S", value_parser = values::row_of_pixels)]
    pub column: Option<Pair>,
    /// The picture to write: .png, or .pfm where the input holds floats.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}
