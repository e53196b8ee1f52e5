//! The command line. x comes first in all of it: sizes are columns x rows, positions column,row.

mod array;
mod camera;
mod choices;
mod dataset;
mod develop;
mod images;
mod optics;

mod spec;
mod tools;
mod values;

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand};
use holo_core::{GridSize, Layout, Projection, Sensor};
use holo_dataset::options::{
    parse_bit_depth, parse_light_units, parse_not_negative, parse_positive, parse_range, parse_sensor,
    parse_sensor_model,
};
use holo_dataset::{Exposure, Focus, Frames, LayerChoice, Output, Shard, Sky, Tool, ViewSubset};
use holo_io::{MatOrder, WorldUp};
use holo_render::{Backend, Denoise, GroundTruth, Integrator, Reuse, TextureFilter};
use holo_scene::gltf::LightUnits;

use choices::{
    BACKENDS, DENOISE, GROUND_TRUTHS, INTEGRATORS, LAYERS, LAYOUTS, MAT_ORDERS, OUTPUTS, PROJECTIONS, REUSE,
    TEXTURE_FILTERS, TOOLS, WORLD_UPS, choice,
};

pub use array::{ArrayOptions, SurfaceArgument};
pub use camera::{CameraOptions, DecodeOptions, TargetOptions, WhiteOptions};
pub use choices::DemosaicArgument;
pub use dataset::DatasetOptions;
pub use develop::{DemosaicOptions, DevelopOptions};
pub use images::{AnimateOptions, ComposeOptions, ExtractOptions, PathArgument, QuiltOptions, RotateOptions};
pub use optics::OpticsOptions;
pub use tools::{
    ApertureArgument, DepthOptions, EpiOptions, EvalOptions, InputOptions, NormalsArgument, RefocusOptions,
};
pub use values::{Crop, Pair, Places};

/// Light-field images of holoscopic (integral, plenoptic) cameras: render them from glTF scenes with exact depth and
/// disparity, convert, refocus, estimate and score.
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
    /// Render a scene (.glb, .gltf) to the raw image of a holoscopic camera, with ground truth.
    Render(Box<RenderOptions>),
    /// Render a dataset: built-in scenes and your own, each with several numbers of views. Resumes where it was stopped.
    Dataset(Box<DatasetOptions>),
    /// Merge the parts that `holo render --shard` wrote.
    Merge(MergeOptions),
    /// Describe a file or folder; for a scene also the cameras and the disparity range that a render would get.
    Info(InfoOptions),
    /// Convert a grid of views (sub-aperture images) to a grid of elemental images (micro-images), or back.
    Remap(RemapOptions),
    /// Extract views or elemental images from a light field: one, some or all of them.
    Extract(ExtractOptions),
    /// Compose a raw image from one image per view.
    Compose(ComposeOptions),
    /// Rotate every elemental image by 180 degrees, as integral displays need it.
    RotateElements(RotateOptions),
    /// Write a quilt: the views of one row side by side, as multi-view displays read them.
    Quilt(QuiltOptions),
    /// Write an animation: along a camera path through the views, or of the frames of a sequence.
    Animate(AnimateOptions),
    /// Write a built-in scene as .glb; without a name, list them.
    Scene(SceneOptions),
    /// Refocus: add all views up to one image that is sharp at a distance, or everywhere.
    Refocus(RefocusOptions),
    /// Estimate a disparity map of the central view (not meters: disparity in pixels) from all views.
    Depth(DepthOptions),
    /// Score a disparity map against ground truth (BadPix, MSE ...), or an image against another (PSNR, SSIM).
    Eval(EvalOptions),
    /// Extract an epipolar-plane image (EPI).
    Epi(EpiOptions),
    /// Write one HTML page to look at a light field in a browser: move, refocus, measure.
    View(ViewOptions),
    /// Compute what a camera will resolve before it is built: disparities, depth of field, depth resolution; or the reverse.
    Optics(OpticsOptions),
    /// Place cameras on a plane, a cylinder or a sphere, and write them (transforms.json) for `holo render --transforms`.
    Array(ArrayOptions),
    /// List plenoptic cameras, or write one as a camera file (TOML) for `--camera-file`.
    Camera(CameraOptions),
    /// Write white images of a plenoptic camera: what it records of an evenly bright scene.
    White(WhiteOptions),
    /// Render checkerboards for the calibration of a plenoptic camera, with the exact positions of their corners.
    Target(TargetOptions),
    /// Decode the raw image of an unfocused plenoptic camera to views.
    Decode(DecodeOptions),
    /// Expose an image sensor with noise to a raw image or any other in linear light: mosaic, DNG, and the same without noise.
    Develop(DevelopOptions),
    /// Demosaic the codes that `holo develop` wrote.
    Demosaic(DemosaicOptions),
    /// Pack a dataset into WebDataset archives (.tar) for training.
    Pack(PackOptions),
    /// Check a dataset, a sequence, or one folder of them, against the sizes and hashes in its manifest.json.
    Verify(VerifyOptions),
}

#[derive(Args, Clone, Debug)]
pub struct RenderOptions {
    /// The scene: .glb, or .gltf with the files it refers to.
    pub scene: PathBuf,
    /// Folder for the results; created if missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Plenoptic camera instead of a rig of views: a camera file (TOML), or a preset of `holo camera`. The pose is that of
    /// the scene's camera; --focus-m and --f-number replace those of the file. --reuse, --texture-filter and --checkpoint
    /// have no effect.
    #[arg(long, value_name = "FILE|PRESET", conflicts_with_all = ["views", "lenses", "lens_shifts", "sensor", "baseline_m", "focal_mm", "sensor_mm", "projection", "disparity"])]
    pub camera_file: Option<String>,
    /// Programs that the raw image of a plenoptic camera is also written for, separated by commas: a folder each, with a
    /// README.txt.
    #[arg(long = "for", value_name = "TOOL,..", value_parser = choice(TOOLS), value_delimiter = ',', requires = "camera_file")]
    pub tools: Vec<Tool>,
    /// Cameras anywhere instead of a grid of views: poses as NeRF and nerfstudio have them (transforms.json). Writes
    /// images/NAME.png, a folder a layer, and transforms.json; the size of images that the file does not say is --lenses.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["camera_file", "views", "sensor", "baseline_m", "focal_mm", "sensor_mm", "projection", "disparity", "focus_m", "f_number", "shard", "checkpoint", "camera", "subset", "lens_shifts"])]
    pub transforms: Option<PathBuf>,
    /// The axis that points up in the world of --transforms: z in files of Blender and nerfstudio, y in glTF.
    #[arg(long, value_name = "z|y", default_value = "z", requires = "transforms", value_parser = choice(WORLD_UPS))]
    pub transforms_up: WorldUp,
    #[command(flatten)]
    pub rig: RigOptions,
    #[command(flatten)]
    pub job: JobOptions,
    /// Render part K of N only (a range of microlens rows, or of pixel rows of a plenoptic camera); `holo merge` joins
    /// the parts. With frames A-B every N-th of them, whole.
    #[arg(long, value_name = "K/N", value_parser = Shard::from_str)]
    pub shard: Option<Shard>,
    #[command(flatten)]
    pub engine: EngineOptions,
    /// Seconds between checkpoints, from which the same command continues after an interruption; 0: none.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, default_value = "30", value_parser = parse_not_negative)]
    pub checkpoint: f64,
    /// Replace another image in DIR: one of another scene or of other options. The same command again needs no permission.
    #[arg(long)]
    pub overwrite: bool,
    /// Print no progress and no summary.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object about the run on standard output.
    #[arg(long)]
    pub json: bool,
}

/// How a scene file is read.
#[derive(Args, Clone, Debug)]
pub struct SceneFileOptions {
    /// Unit of the lights in the file: candela and lux of glTF, those of Blender's lighting mode "Standard" (683 times as bright), or `auto`, by generator and numbers.
    #[arg(long, value_name = "gltf|blender|auto", default_value = "gltf", value_parser = parse_light_units)]
    pub light_units: LightUnits,
    /// Treat closed meshes with transmission but without a volume as solid glass; otherwise they are thin, like soap bubbles.
    #[arg(long)]
    pub solid_glass: bool,
    /// Name of a material variant of the file, as `holo info` lists them.
    #[arg(long, value_name = "NAME")]
    pub material_variant: Option<String>,
    /// Frame of the file's animations, or frames A-B, each in a folder of its own with the focus and exposure of the first
    /// [default: the scene at rest]. Frame N is at N / fps seconds.
    #[arg(long, value_name = "N|A-B", allow_negative_numbers = true, value_parser = Frames::from_str)]
    pub frame: Option<Frames>,
    /// Frames per second [default: 24].
    #[arg(long, value_name = "F", allow_negative_numbers = true, requires = "frame", value_parser = parse_positive)]
    pub fps: Option<f64>,
    /// Name or index of the animation to play [default: all of the file].
    #[arg(long, value_name = "NAME", requires = "frame")]
    pub animation: Option<String>,
}

/// The options that, with the scene and the rig, determine every file.
#[derive(Args, Clone, Debug)]
pub struct JobOptions {
    #[command(flatten)]
    pub scene_file: SceneFileOptions,
    /// Light transport: what light is simulated.
    #[arg(long, value_parser = choice(INTEGRATORS), default_value = "auto")]
    pub integrator: Integrator,
    /// Samples per pixel [default: 16, with the integrator depth 1].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub spp: Option<u32>,
    /// Adaptive sampling: stop at this relative standard error of a pixel; --spp is then the maximum [default: 1024].
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_positive)]
    pub target_error: Option<f64>,
    /// Maximum number of bounces of a light path.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub max_bounces: u32,
    /// Also write the codes that an image sensor makes of the raw image, scene_raw.png with scene_raw.json: a name of
    /// `holo develop --sensor-model`.
    #[arg(long, value_name = "NAME", value_parser = parse_sensor_model)]
    pub sensor_model: Option<String>,
    /// Film speed of that sensor [default: its base speed].
    #[arg(long, value_name = "ISO", requires = "sensor_model", value_parser = parse_positive)]
    pub iso: Option<f64>,
    /// Disable Russian roulette: follow every path to its last bounce.
    #[arg(long)]
    pub no_roulette: bool,
    /// Without light that diffuse surfaces reflect to each other (with `--integrator auto`); mirrors and glass still reflect.
    #[arg(long)]
    pub no_indirect: bool,
    /// Limit what a light path may add after its first hit, against single bright pixels: darkens caustics and reflected lamps [default: no limit].
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = parse_positive)]
    pub indirect_limit: Option<f64>,
    /// Let shadow rays pass straight through smooth glass: light behind windows without noise; caustics of solid glass become plain shadows.
    #[arg(long)]
    pub transparent_shadows: bool,
    /// Without light that is scattered more than once in the roughness of a surface: rough metal gets darker, as in renderers without this model.
    #[arg(long)]
    pub no_multiple_scattering: bool,
    /// Share the light that rays find on diffuse surfaces: with `views` between groups of 16 neighboring views, whose
    /// noise is then lower and correlated.
    #[arg(long, value_parser = choice(REUSE), default_value = "views")]
    pub reuse: Reuse,
    /// Average fine textures over the part of a pixel that a sample stands for: a small bias that more samples remove.
    /// Without effect with `--denoise views`.
    #[arg(long, value_parser = choice(TEXTURE_FILTERS), default_value = "footprint")]
    pub texture_filter: TextureFilter,
    /// Reduce the noise of color: with `views` by the samples of neighboring views, a small bias that more samples remove.
    #[arg(long, value_parser = choice(DENOISE), default_value = "off")]
    pub denoise: Denoise,
    /// Hide surfaces that are not double-sided from behind, as game engines do; shadows and mirrors still show them.
    #[arg(long)]
    pub cull: bool,
    /// Environment light: linear radiance of a constant sky (one number is gray), an equirectangular map (.hdr, .exr; .png, .jpg
    /// as sRGB), or `auto`: black, and a soft sky for scenes without light.
    #[arg(long, value_name = "auto|R,G,B|FILE", allow_hyphen_values = true, default_value = "auto")]
    pub sky: Sky,
    /// Exposure compensation of 8- and 16-bit images in EV, or `auto`.
    #[arg(long, value_name = "auto|EV", default_value = "auto", allow_hyphen_values = true)]
    pub exposure: Exposure,
    /// Views for which ground truth is written.
    #[arg(long, value_parser = choice(GROUND_TRUTHS), default_value = "central")]
    pub ground_truth: GroundTruth,
    /// Layers (AOVs) to write as float maps (PFM), separated by commas [default: those of --write].
    ///
    /// Each describes the first surface, glass included, that the ray through the center of a pixel hits. scene_LAYER.pfm
    /// is of the central view; with `--ground-truth all` the folder LAYER has one of every view.
    #[arg(long, value_name = "NAME,..", value_parser = choice(LAYERS), value_delimiter = ',')]
    pub layers: Vec<LayerChoice>,
    /// Files to write, separated by commas [default: vpi,el,mat, and disparity,depth unless --layers names others; without
    /// color no vpi, el and mat].
    #[arg(long, value_name = "WHAT,..", value_parser = choice(OUTPUTS), value_delimiter = ',')]
    pub write: Vec<Output>,
    /// Order of the array in scene_5d.mat: H(v,u,t,s,c), or LF(t,s,v,u,c) as in the Light Field Toolbox.
    #[arg(long, value_name = "ORDER", value_parser = choice(MAT_ORDERS), default_value = "lenses")]
    pub mat_order: MatOrder,
    /// Bits per channel of the raw PNGs and of scene_5d.mat.
    #[arg(long, value_name = "8|16", default_value_t = 8, value_parser = parse_bit_depth)]
    pub bit_depth: u8,
    /// Random seed.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0)]
    pub seed: u64,
}

/// The sensor and the main lens.
#[derive(Args, Clone, Debug)]
pub struct MainLensOptions {
    /// Sensor resolution in pixels: hd, 4k, 8k (7952x5304), uhd8k or WIDTHxHEIGHT.
    #[arg(long, value_name = "NAME|WxH", default_value = "8k", value_parser = parse_sensor)]
    pub sensor: Sensor,
    /// f-number of the main lens, whose aperture the views sample [default: 5].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = parse_positive)]
    pub f_number: Option<f64>,
    /// Focus distance, m, `inf`, or `auto` (harmonic mean of nearest and farthest depth). Disparity is 0 there.
    #[arg(long, value_name = "Z|inf|auto", allow_negative_numbers = true, default_value = "auto")]
    pub focus_m: Focus,
    /// Smallest and largest disparity of the scene, px between adjacent views: focus distance and baseline follow.
    #[arg(long, value_name = "MIN,MAX", allow_hyphen_values = true, conflicts_with_all = ["f_number", "focus_m"], value_parser = parse_range)]
    pub disparity: Option<(f64, f64)>,
}

/// The options that determine the rig.
#[derive(Args, Clone, Debug)]
pub struct RigOptions {
    #[command(flatten)]
    pub main_lens: MainLensOptions,
    /// Views, columns x rows, or one number for both.
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, default_value = "100x100", value_parser = GridSize::from_str)]
    pub views: GridSize,
    /// Lenses, columns x rows: the microlenses, which are the pixels of one view; instead of a sensor.
    #[arg(long, value_name = "UxV", conflicts_with = "sensor", value_parser = GridSize::from_str)]
    pub lenses: Option<GridSize>,
    /// Lens array shifting: N x N exposures with the microlens array 1/N of its pitch apart, interleaved. N times as many
    /// lenses along both axes, each as wide as without.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub lens_shifts: Option<u32>,
    /// Baseline: distance between adjacent views, m.
    #[arg(long, value_name = "B", allow_negative_numbers = true, conflicts_with_all = ["f_number", "disparity"], value_parser = parse_not_negative)]
    pub baseline_m: Option<f64>,
    /// Focal length, mm [default: from the angle of view of the scene's camera].
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = parse_positive)]
    pub focal_mm: Option<f64>,
    /// Sensor size: length of the larger image side, mm.
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value_t = 36.0, value_parser = parse_positive)]
    pub sensor_mm: f64,
    /// Projection of the views.
    #[arg(long, value_parser = choice(PROJECTIONS), default_value = "perspective")]
    pub projection: Projection,
    /// Name or number of the scene's camera [default: the first].
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    /// Only some of the views: the row and column of the central one (cross), with both diagonals (star), or a list of
    /// COLUMN,ROW. Writes them as hci/input_CamNNN.png, with their numbers in the whole grid, and without path reuse.
    #[arg(long, value_name = "cross|star|C,R;C,R..", value_parser = ViewSubset::from_str)]
    pub subset: Option<ViewSubset>,
}

#[derive(Args, Clone, Debug)]
pub struct EngineOptions {
    /// Threads [default: one per core].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Ray tracing backend.
    #[arg(long, value_parser = choice(BACKENDS), default_value = "auto")]
    pub backend: Backend,
}

#[derive(Args, Debug)]
pub struct InfoOptions {
    /// A scene, a PNG, PFM, EXR, Radiance HDR or .mat, a parameters.cfg, a manifest.json, or a folder of them.
    pub file: PathBuf,
    #[command(flatten)]
    pub scene_file: SceneFileOptions,
    #[command(flatten)]
    pub rig: RigOptions,
    #[command(flatten)]
    pub engine: EngineOptions,
}

#[derive(Args, Debug)]
pub struct RemapOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// PNG to write.
    #[arg(value_parser = values::png)]
    pub output: PathBuf,
    /// Layout of the output [default: by `_el` or `_vpi` in its name, else the other one].
    #[arg(long, value_parser = choice(LAYOUTS))]
    pub to: Option<Layout>,
}

#[derive(Args, Debug)]
pub struct ViewOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// HTML page to write; it needs no other file and no network.
    #[arg(short, long, value_name = "FILE", value_parser = values::html)]
    pub out: PathBuf,
    /// Estimated disparity map of the central view, px, to compare with the ground truth.
    #[arg(long, value_name = "FILE.pfm")]
    pub estimate: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct SceneOptions {
    /// Name of the scene.
    pub name: Option<String>,
    /// File to write [default: NAME.glb].
    #[arg(long, value_name = "FILE", requires = "name")]
    pub out: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct VerifyOptions {
    /// A folder that `holo render` or `holo dataset` wrote.
    pub folder: PathBuf,
}

#[derive(Args, Debug)]
pub struct PackOptions {
    /// The folder of `holo dataset`.
    pub dataset: PathBuf,
    /// Folder for the archives: train-000000.tar, test-000000.tar and so on; created if missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Files of every light field, without `scene_`, separated by commas, such as el.png,disparity.pfm [default: all
    /// but subfolders, and beside el.png without vpi.png and 5d.mat, which have its pixels].
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub fields: Vec<String>,
    /// Largest size of an archive, MB; one light field is never divided.
    #[arg(long, value_name = "MB", default_value_t = 1000)]
    pub max_mb: u64,
    /// Print no summary.
    #[arg(long)]
    pub quiet: bool,
}

#[derive(Args, Debug)]
pub struct MergeOptions {
    /// Folder for the results; created if missing.
    pub out: PathBuf,
    /// The folders that `holo render --shard` wrote, all of them, in any order.
    #[arg(required = true)]
    pub parts: Vec<PathBuf>,
    /// Print no summary.
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
