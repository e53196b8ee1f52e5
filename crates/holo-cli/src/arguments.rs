//! The command line. On it x comes first everywhere: sizes are columns x rows, positions column, row.

mod choices;
mod dataset;
mod optics;
mod pictures;
mod spec;
mod tools;
mod values;

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand};
use holo_core::{GridSize, Layout, Projection, Sensor};
use holo_dataset::options::{parse_bit_depth, parse_not_negative, parse_positive, parse_sensor};
use holo_dataset::{Exposure, Focus, LayerChoice, Output, Shard, Sky};
use holo_io::MatOrder;
use holo_render::{Backend, GroundTruth, Integrator};

use choices::{BACKENDS, GROUND_TRUTHS, INTEGRATORS, LAYERS, LAYOUTS, MAT_ORDERS, OUTPUTS, PROJECTIONS, choice};

pub use dataset::DatasetOptions;
pub use optics::OpticsOptions;
pub use pictures::{AnimateOptions, ComposeOptions, ExtractOptions, PathArgument, QuiltOptions, RotateOptions};
pub use tools::{ApertureArgument, DepthOptions, EpiOptions, EvalOptions, InputOptions, RefocusOptions};
pub use values::{Crop, Pair, Places};

/// Holoscopic (integral, plenoptic 1.0) images from glTF scenes, with exact depth and disparity.
///
/// Everywhere x comes before y: sizes are columns x rows, positions are column,row and count from 0.
#[derive(Parser, Debug)]
#[command(name = "holo", version, propagate_version = true, subcommand_required = true, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand, Debug)]
pub enum Command {
    /// Render a scene (.glb, .gltf) into a raw holoscopic image with ground truth.
    Render(Box<RenderOptions>),
    /// Make a dataset: scenes of the gallery and your own, each with several numbers of views; or go on with one.
    Dataset(Box<DatasetOptions>),
    /// Put the parts of `holo render --shard` together.
    Merge(MergeOptions),
    /// Say what a file holds; for a scene also which rig and disparity range a render would get.
    Info(InfoOptions),
    /// Turn a grid of views into a grid of elemental images, or back.
    Remap(RemapOptions),
    /// Cut views or elemental images out of a raw image: one, some or all of them.
    Extract(ExtractOptions),
    /// Put pictures of single views together into a raw image.
    Compose(ComposeOptions),
    /// Turn every elemental image by 180 degrees, as integral displays need it.
    RotateElements(RotateOptions),
    /// Put the views of one row side by side as multi-view displays read them.
    Quilt(QuiltOptions),
    /// Make a moving picture of a way through the views.
    Animate(AnimateOptions),
    /// Write a scene of the built-in gallery as .glb; without a name, list them.
    Scene(SceneOptions),
    /// Add all views up to one picture that is sharp at a distance, or everywhere.
    Refocus(RefocusOptions),
    /// Estimate the disparity of the central view from the others.
    Depth(DepthOptions),
    /// Score a disparity map against the truth (BadPix, MSE ...), or a picture against another (PSNR, SSIM).
    Eval(EvalOptions),
    /// Cut an epipolar-plane image out of a light field.
    Epi(EpiOptions),
    /// Make one HTML page in which a light field is moved through, refocused and measured.
    View(ViewOptions),
    /// Work out what a camera will see before it is built: disparities, depth of field, resolution; and the reverse.
    Optics(OpticsOptions),
    /// Check a dataset, or one folder of it, against the digests in its manifest.json: hashes, sizes, what is missing.
    Verify(VerifyOptions),
}

#[derive(Args, Clone, Debug)]
pub struct RenderOptions {
    /// The scene: .glb, or .gltf with the files it refers to.
    pub scene: PathBuf,
    /// Folder for the results; made if missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub rig: RigOptions,
    #[command(flatten)]
    pub job: JobOptions,
    /// Part K of N of the picture alone, cut between rows of lenses: DIR is then for `holo merge`.
    #[arg(long, value_name = "K/N", value_parser = Shard::from_str)]
    pub shard: Option<Shard>,
    #[command(flatten)]
    pub engine: EngineOptions,
    /// No progress and no summary.
    #[arg(long)]
    pub quiet: bool,
    /// One JSON object about the run on standard output.
    #[arg(long)]
    pub json: bool,
}

/// What decides, with the scene and the rig, every file that is written.
#[derive(Args, Clone, Debug)]
pub struct JobOptions {
    /// How light is modelled.
    #[arg(long, value_parser = choice(INTEGRATORS), default_value = "auto")]
    pub integrator: Integrator,
    /// Rays through every pixel [default: 16, with the integrator depth 1].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub spp: Option<u32>,
    /// Relative standard error at which a pixel needs no more samples; --spp is then the most it gets [default: 1024].
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_positive)]
    pub target_error: Option<f64>,
    /// How often light is scattered at most on its way to a pixel.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub max_bounces: u32,
    /// Follow every path to its last bounce, however little it carries.
    #[arg(long)]
    pub no_roulette: bool,
    /// Let `--integrator auto` leave out light that comes from other surfaces, except in mirrors and glass.
    #[arg(long)]
    pub no_indirect: bool,
    /// Radiance of a constant sky, linear, or an equirectangular map around the scene (.hdr, .exr).
    #[arg(long, value_name = "R,G,B|FILE", allow_hyphen_values = true, default_value = "0,0,0")]
    pub sky: Sky,
    /// Stops by which 8- and 16-bit images are brightened, or `auto`.
    #[arg(long, value_name = "auto|EV", default_value = "auto", allow_hyphen_values = true)]
    pub exposure: Exposure,
    /// Layers for the central view or for all views.
    #[arg(long, value_parser = choice(GROUND_TRUTHS), default_value = "central")]
    pub ground_truth: GroundTruth,
    /// Layers to write as float maps (PFM), separated by commas [default: those of --write].
    ///
    /// Each tells what the ray through a pixel's centre meets first, glass included. scene_LAYER.pfm is the central
    /// view's; with `--ground-truth all` the folder LAYER has one of every view.
    #[arg(long, value_name = "NAME,..", value_parser = choice(LAYERS), value_delimiter = ',')]
    pub layers: Vec<LayerChoice>,
    /// What to write, separated by commas [default: vpi,el,mat, and disparity,depth unless --layers names others; without
    /// colour no vpi, el and mat].
    #[arg(long, value_name = "WHAT,..", value_parser = choice(OUTPUTS), value_delimiter = ',')]
    pub write: Vec<Output>,
    /// Order of the array in scene_5d.mat: H(v,u,t,s,c), or LF(t,s,v,u,c) as in the Light Field Toolbox.
    #[arg(long, value_name = "ORDER", value_parser = choice(MAT_ORDERS), default_value = "lenses")]
    pub mat_order: MatOrder,
    /// Bits a channel of the raw PNGs and of scene_5d.mat.
    #[arg(long, value_name = "8|16", default_value_t = 8, value_parser = parse_bit_depth)]
    pub bit_depth: u8,
    /// Chooses the random numbers.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0)]
    pub seed: u64,
}

/// The sensor and the main lens.
#[derive(Args, Clone, Debug)]
pub struct MainLensOptions {
    /// The sensor behind the lenses: hd, 4k, 8k (the paper's 7952x5304), uhd8k or WIDTHxHEIGHT.
    #[arg(long, value_name = "NAME|WxH", default_value = "8k", value_parser = parse_sensor)]
    pub sensor: Sensor,
    /// The views sample the aperture of an f/N lens [default: 5].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = parse_positive)]
    pub f_number: Option<f64>,
    /// Distance of the focus plane, m, `inf`, or `auto` (harmonic mean of nearest and farthest depth).
    #[arg(long, value_name = "Z|inf|auto", allow_negative_numbers = true, default_value = "auto")]
    pub focus_m: Focus,
}

/// What decides the rig.
#[derive(Args, Clone, Debug)]
pub struct RigOptions {
    #[command(flatten)]
    pub main_lens: MainLensOptions,
    /// Views, columns x rows, or one number for both.
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, default_value = "100x100", value_parser = GridSize::from_str)]
    pub views: GridSize,
    /// Lenses, columns x rows (the pixels of one view), instead of a sensor.
    #[arg(long, value_name = "UxV", conflicts_with = "sensor", value_parser = GridSize::from_str)]
    pub lenses: Option<GridSize>,
    /// Distance between neighbouring views, m.
    #[arg(long, value_name = "B", allow_negative_numbers = true, conflicts_with = "f_number", value_parser = parse_not_negative)]
    pub baseline_m: Option<f64>,
    /// Focal length, mm [default: from the camera's angle of view].
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = parse_positive)]
    pub focal_mm: Option<f64>,
    /// Length of the larger image side on the sensor, mm.
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value_t = 36.0, value_parser = parse_positive)]
    pub sensor_mm: f64,
    /// How views are projected.
    #[arg(long, value_parser = choice(PROJECTIONS), default_value = "perspective")]
    pub projection: Projection,
    /// Name or number of the scene's camera [default: the first].
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
}

#[derive(Args, Clone, Debug)]
pub struct EngineOptions {
    /// Threads [default: one per core].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// What finds the hits: Embree, the built-in BVH, or Embree where there is one.
    #[arg(long, value_parser = choice(BACKENDS), default_value = "auto")]
    pub backend: Backend,
}

#[derive(Args, Debug)]
pub struct InfoOptions {
    /// A scene, a PNG, PFM, EXR, Radiance HDR or .mat, a parameters.cfg, a manifest.json, or a folder of them.
    pub file: PathBuf,
    #[command(flatten)]
    pub rig: RigOptions,
    #[command(flatten)]
    pub engine: EngineOptions,
}

#[derive(Args, Debug)]
pub struct RemapOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// The PNG to write.
    #[arg(value_parser = values::png)]
    pub output: PathBuf,
    /// What the output shall be [default: by `_el` or `_vpi` in its name, else the other one].
    #[arg(long, value_parser = choice(LAYOUTS))]
    pub to: Option<Layout>,
}

#[derive(Args, Debug)]
pub struct ViewOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// The page to write; it needs no other file and no network.
    #[arg(short, long, value_name = "FILE", value_parser = values::html)]
    pub out: PathBuf,
    /// An estimate of the central view's disparity in px, to be shown beside the truth.
    #[arg(long, value_name = "FILE.pfm")]
    pub estimate: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct SceneOptions {
    /// Which scene of the gallery.
    pub name: Option<String>,
    /// The .glb to write.
    #[arg(long, value_name = "FILE", requires = "name")]
    pub out: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct VerifyOptions {
    /// A folder that `holo render` or `holo dataset` wrote.
    pub folder: PathBuf,
}

#[derive(Args, Debug)]
pub struct MergeOptions {
    /// Folder for the results; made if missing.
    pub out: PathBuf,
    /// The folders that `holo render --shard` wrote, all of them, in any order.
    #[arg(required = true)]
    pub parts: Vec<PathBuf>,
    /// No summary.
    #[arg(long)]
    pub quiet: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
