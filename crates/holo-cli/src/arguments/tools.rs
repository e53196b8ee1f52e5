//! The options of the commands that analyze a light field: refocus, depth, eval, epi.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{ArgGroup, Args};
use holo_core::refocus::{ApertureShape, Kernel};
use holo_core::{Effort, GridSize, Layout, ViewOrder};

use holo_dataset::ViewSubset;
use holo_dataset::settings::{positive as parse_positive, range as parse_range};
use holo_io::WorldUp;

use super::choices::{EFFORTS, KERNELS, LAYOUTS, NORMALS, NormalsArgument, ORDERS, WORLD_UPS, choice};
use super::{Pair, values};

/// A light field, and what its files do not tell.
#[derive(Args, Clone, Debug)]
pub struct InputOptions {
    /// Light field: a raw PNG or EXR, a .mat, an .h5, or a folder (of `holo render`, with any of its files, of the HCI
    /// benchmark, of the Stanford gantry, or of PNGs, one per view).
    pub input: PathBuf,
    /// Layout of a raw image [default: by `_el` or `_vpi` in its name].
    #[arg(long, value_parser = choice(LAYOUTS))]
    pub from: Option<Layout>,
    /// Views, columns x rows, or one number for both [default: from the parameters.cfg beside the input].
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, value_parser = GridSize::from_str)]
    pub views: Option<GridSize>,
    /// Order of the views in a folder of PNGs.
    #[arg(long, value_parser = choice(ORDERS), default_value = "row-major")]
    pub order: ViewOrder,
}

/// Where a view of an array of cameras stands.
#[derive(Args, Clone, Debug)]
pub struct ViewpointOptions {
    /// Where the view stands, m, in the world of the scene (+Y up) [default: the camera nearest to the middle of all]. For a folder of
    /// `holo render --transforms`, as the next three.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::point)]
    pub eye: Option<[f64; 3]>,
    /// What it looks at, m [default: as the camera nearest to it].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::point)]
    pub target: Option<[f64; 3]>,
    /// What is up in its image.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::point)]
    pub up: Option<[f64; 3]>,
    /// The axis that points up in the world of transforms.json: z for Blender and nerfstudio, y as in glTF.
    #[arg(long, value_name = "z|y", default_value = "z", value_parser = choice(WORLD_UPS))]
    pub transforms_up: WorldUp,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("focus").required(true).args(["disparity", "distance_m", "slope", "all_in_focus", "stack"])))]
pub struct RefocusOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Focus where the disparity between adjacent views is D px.
    #[arg(long, value_name = "D", allow_negative_numbers = true, value_parser = values::finite)]
    pub disparity: Option<f64>,
    /// Focus at this distance, m, or `inf`; needs the camera parameters.
    #[arg(long, value_name = "Z", allow_negative_numbers = true, value_parser = values::distance)]
    pub distance_m: Option<f64>,
    /// Tilt the plane of --distance-m: its right side moves away by R degrees, its upper side by U.
    #[arg(long, value_name = "R,U", allow_hyphen_values = true, value_parser = values::tilt)]
    pub tilt_deg: Option<[f64; 2]>,
    /// Focus at a slope of MATLAB's Light Field Toolbox.
    #[arg(long, value_name = "SLOPE", allow_negative_numbers = true, value_parser = values::finite)]
    pub slope: Option<f64>,
    /// Sharp everywhere: all-in-focus by a disparity map of the central view; of an array of cameras by the depth of the view, m.
    #[arg(long, value_name = "MAP.pfm")]
    pub all_in_focus: Option<PathBuf>,
    /// Focal stack: N images focused from disparity A to B; FILE gets a number.
    #[arg(long, value_name = "A,B,N", allow_hyphen_values = true, value_parser = values::stack)]
    pub stack: Option<(f64, f64, usize)>,
    /// Synthetic aperture, which views are added up: all, disc:D, square:D or gaussian:D, D in views; of an array of cameras in m.
    #[arg(long, value_name = "SHAPE", default_value = "all", value_parser = ApertureShape::from_str)]
    pub aperture: ApertureShape,
    #[command(flatten)]
    pub viewpoint: ViewpointOptions,
    /// Interpolation between the pixels of a view.
    #[arg(long, value_parser = choice(KERNELS), default_value = "cubic")]
    pub kernel: Kernel,
    /// Image to write: .png, or .pfm for linear floats.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

#[derive(Args, Debug)]
pub struct SynthesizeOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Where the view is: the column and row among the views, from 0, which may be fractions; of an array of cameras give --eye.
    #[arg(long, value_name = "S,T", allow_hyphen_values = true, required_unless_present_any = ["eye", "target"], conflicts_with_all = ["eye", "target", "up"], value_parser = values::viewpoint)]
    pub at: Option<[f64; 2]>,
    #[command(flatten)]
    pub viewpoint: ViewpointOptions,
    /// Where the surfaces are: `truth` that was rendered, of all views or of the central one; an `estimate` of the central view;
    /// a map of it in a file; or `off`: views are blended as they are [default: truth where the input has it, else estimate].
    #[arg(long, value_name = "truth|estimate|off|FILE.pfm")]
    pub disparity: Option<DisparityArgument>,
    /// Interpolation between the pixels of a view. `cubic` takes what four views show of one surface as samples of one image.
    #[arg(long, value_parser = choice(KERNELS), default_value = "cubic")]
    pub kernel: Kernel,
    /// Image to write: .png, or .pfm for linear floats. NAME_holes.png, which is also written, is white where no view shows the point.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

#[derive(Args, Debug)]
pub struct CorrespondOptions {
    /// Folder with the images and depths of cameras or light fields anywhere, and their transforms.json.
    pub input: PathBuf,
    /// Camera whose pixels are looked for: its name in transforms.json; of a light field the central view, or NAME:S,T.
    #[arg(long, value_name = "NAME")]
    pub from: String,
    /// Camera that may see them [default: every other one, of light fields the central views; FILE gets _NAME].
    #[arg(long, value_name = "NAME")]
    pub to: Option<String>,
    /// Array of numpy to write, float64: for every row and column the row, the column and the depth in the other camera, m, and 1 if it
    /// sees the point, else 0. Rows and columns count from 0 and are whole in the middle of a pixel.
    #[arg(long, value_name = "FILE.npy", value_parser = values::npy)]
    pub out: PathBuf,
}

/// `--disparity` of `holo synthesize`.
#[derive(Clone, Debug, PartialEq)]
pub enum DisparityArgument {
    Truth,
    Estimate,
    Off,
    File(PathBuf),
}

impl FromStr for DisparityArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "truth" => Ok(Self::Truth),
            "estimate" => Ok(Self::Estimate),
            "off" => Ok(Self::Off),
            file if file.to_ascii_lowercase().ends_with(".pfm") => Ok(Self::File(file.into())),
            _ => Err("give truth, estimate, off, or a disparity map (.pfm)".into()),
        }
    }
}

#[derive(Args, Debug)]
pub struct DepthOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Disparity map to write: of the central view, px between adjacent views. Of cameras anywhere the depth of one, m.
    #[arg(long, value_name = "FILE.pfm")]
    pub out: PathBuf,
    /// Use some of the views: cross, star, or positions; a folder with some of the views needs no word for it.
    #[arg(long, value_name = "cross|star|S,T;S,T..", value_parser = ViewSubset::from_str)]
    pub subset: Option<ViewSubset>,
    /// Nearest and farthest depth to search, m, instead of --range; cameras anywhere need it, light fields their parameters.
    #[arg(long, value_name = "NEAR,FAR", conflicts_with = "range", value_parser = values::depths)]
    pub depths_m: Option<(f64, f64)>,
    /// Camera of a folder with transforms.json whose depth is estimated, of a light field NAME:S,T [default: the nearest to the
    /// middle of all].
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Smallest and largest disparity to search, px [default: those of the input's parameters, else -4,4].
    #[arg(long, value_name = "MIN,MAX", allow_hyphen_values = true, value_parser = parse_range)]
    pub range: Option<(f64, f64)>,
    /// Quality against time.
    #[arg(long, value_parser = choice(EFFORTS), default_value = "balanced")]
    pub effort: Effort,
    /// Confidence map to write, 0 to 1.
    #[arg(long, value_name = "FILE.pfm")]
    pub confidence: Option<PathBuf>,
    /// Seconds of the estimate to write, as a submission to the HCI benchmark has them (runtimes/SCENE.txt).
    #[arg(long, value_name = "FILE.txt")]
    pub runtime: Option<PathBuf>,
    /// Print no summary.
    #[arg(long)]
    pub quiet: bool,
}

#[derive(Args, Debug)]
pub struct EvalOptions {
    /// The estimate: a disparity map (.pfm) or an image (.png).
    pub estimate: PathBuf,
    /// The ground truth, of the same kind and size; a map may have a multiple of the rows and columns (high resolution).
    pub truth: PathBuf,
    /// Width of the excluded border, px (maps only).
    #[arg(long, value_name = "PX", default_value_t = 15)]
    pub border: usize,
    /// Score only pixels where this image is not black (maps only); `none`: all [default: scene_hit_mask.png beside or above the
    /// truth, which is black where the scene is not hit].
    #[arg(long, value_name = "FILE.png|none")]
    pub mask: Option<PathBuf>,
    /// Signed error as an image to write: red too far, white right, blue too near.
    #[arg(long, value_name = "FILE.png", value_parser = values::png)]
    pub error_map: Option<PathBuf>,
    /// Error at which the colors of that image saturate, px.
    #[arg(long, value_name = "PX", default_value_t = 0.2, value_parser = parse_positive)]
    pub error_range: f64,
    /// Geometry of the median angle between normals (maps with a parameters.cfg beside the truth).
    #[arg(long, value_parser = choice(NORMALS), default_value = "pinhole")]
    pub normals: NormalsArgument,
    /// Print one JSON object on standard output instead of a table.
    #[arg(long)]
    pub json: bool,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("slice").args(["row", "column"])))]
pub struct EpiOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Row V of the pixels, as the views of view row T see it, from 0 [default: the central ones].
    #[arg(long, value_name = "V,T", value_parser = values::row_of_pixels)]
    pub row: Option<Pair>,
    /// Column U of the pixels, as the views of view column S see it, from 0.
    #[arg(long, value_name = "U,S", value_parser = values::row_of_pixels)]
    pub column: Option<Pair>,
    /// Image to write: .png, or .pfm if the input has floats.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}
