//! The command line. x comes first in all of it: sizes are columns x rows, positions column,row.

mod array;
mod camera;
mod choices;
pub mod config;
mod dataset;
mod develop;
mod export;
mod headings;
mod images;
mod optics;
mod preview;
mod settings;
mod similar;
mod spec;
mod tools;
mod values;

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand};
use holo_core::Layout;
use holo_dataset::Shard;
use holo_dataset::settings::{PRESETS, Preset, not_negative, positive};
use holo_io::WorldUp;
use holo_render::Backend;

use choices::{BACKENDS, LAYOUTS, WORLD_UPS, choice};
use headings::{CAMERA, FILES, QUALITY, RUNNING};

pub use array::ArrayOptions;
pub use camera::{
    Benchmark, CalibrateOptions, CalibrationBenchmarkOptions, CameraOptions, DecodeOptions, EvalCalibrationOptions,
    TargetOptions, WhiteOptions,
};
pub use choices::{DemosaicArgument, NormalsArgument, SurfaceArgument};
pub use dataset::{CollectionOptions, DatasetOptions, GenerateOptions};
pub use develop::{DemosaicOptions, DevelopOptions};
pub use export::ExportOptions;
pub use images::{
    AnimateOptions, ComposeOptions, DisplayOptions, ExtractOptions, PathArgument, QuiltOptions, RotateOptions,
};
pub use optics::OpticsOptions;
pub use preview::PreviewOptions;
pub use settings::{OfDataset, OfInfo, OfPreview, OfRender, Settings};
pub use similar::with_similar_value;
pub use spec::open_camera;
pub use tools::{
    CorrespondOptions, DepthOptions, DisparityArgument, EpiOptions, EvalOptions, InputOptions, RefocusOptions,
    SynthesizeOptions, ViewpointOptions,
};
pub use values::{Crop, Pair, Places, Seeds};

/// Light-field images of holoscopic (integral, plenoptic) cameras: render them from glTF scenes with exact depth and
/// disparity, convert, refocus, estimate and score.
///
/// Everywhere x comes before y: sizes are columns x rows, positions are column,row and count from 0.
#[derive(Parser, Debug)]
#[command(name = "holo", version, propagate_version = true, subcommand_required = true, arg_required_else_help = true)]
pub struct Arguments {
    /// Memory that the command may use, GB; on Linux [default: nine tenths of what is free].
    #[arg(long, global = true, value_name = "GB", value_parser = positive, help_heading = RUNNING, hide_short_help = true)]
    pub memory_gb: Option<f64>,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand, Debug)]
pub enum Command {
    /// Render a scene (.glb, .gltf) to the raw image of a holoscopic camera, with ground truth.
    #[command(after_long_help = RENDER_EXAMPLES)]
    Render(Box<RenderOptions>),
    /// Render a dataset: built-in scenes and your own, each with several numbers of views or plenoptic cameras. Resumes where
    /// it was stopped.
    Dataset(Box<DatasetOptions>),
    /// Draw scenes from a recipe, and render them: training sets of any size. Resumes where it was stopped.
    #[command(after_long_help = GENERATE_EXAMPLES)]
    Generate(Box<GenerateOptions>),
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
    /// Map a light field to a display of lenses before a panel, or simulate what an eye sees of it.
    Display(DisplayOptions),
    /// Write an animation: along a camera path through the views, or of the frames of a sequence.
    Animate(AnimateOptions),
    /// Write a built-in scene as .glb; without a name, list them.
    Scene(SceneOptions),
    /// Refocus: add all views up to one image that is sharp at a distance, or everywhere.
    Refocus(RefocusOptions),
    /// Synthesize the view of a place between the views, with the help of disparities.
    Synthesize(SynthesizeOptions),
    /// Find where other cameras of an array see the points of a camera's pixels, and which are hidden.
    Correspond(CorrespondOptions),
    /// Estimate the disparity of the central view, px, or the depth of a camera of an array, m.
    Depth(DepthOptions),
    /// Score a disparity map against ground truth (BadPix, MSE ...), or an image against another (PSNR, SSIM).
    Eval(EvalOptions),
    /// Extract an epipolar-plane image (EPI).
    Epi(EpiOptions),
    /// Write one HTML page to look at a light field in a browser: move, refocus, measure.
    View(ViewOptions),
    /// Show a scene live in a browser while its camera is set up: orbit, focus, views, disparities; then render it.
    Preview(Box<PreviewOptions>),
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
    /// Find the microlens array of a plenoptic camera by its white images.
    Calibrate(CalibrateOptions),
    /// Score a calibrated plenoptic camera: its numbers, centers, corners of boards and their depths, against the truth.
    EvalCalibration(EvalCalibrationOptions),
    /// Render the data of a benchmark, with the truth.
    #[command(subcommand)]
    Benchmark(Benchmark),
    /// Decode the raw image of a plenoptic camera to views.
    Decode(DecodeOptions),
    /// Expose an image sensor with noise to a raw image or any other in linear light: mosaic, DNG, and the same without noise.
    Develop(DevelopOptions),
    /// Demosaic the codes that `holo develop` wrote.
    Demosaic(DemosaicOptions),
    /// Export light fields as the files that programs of others read: for training, compression, numpy.
    Export(ExportOptions),
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
    #[arg(long, value_name = "DIR", help_heading = FILES)]
    pub out: PathBuf,
    /// TOML file with settings: `spp = 64`, `views = "20x20"`. The command line wins.
    #[arg(long, value_name = "FILE", help_heading = RUNNING)]
    pub config: Option<PathBuf>,
    /// Settings with a name: draft, clean, reference, hci, urbanlf, paper-8k.
    #[arg(long, value_name = "NAME", value_parser = preset, help_heading = QUALITY, long_help = preset_help())]
    pub preset: Option<&'static Preset>,
    /// Plenoptic camera instead of a rig of views.
    ///
    /// A camera file (TOML), or a preset of `holo camera`. The pose is that of the scene's camera or of --transforms;
    /// --focus-m and --f-number replace those of the file.
    #[arg(long, value_name = "FILE|PRESET", help_heading = CAMERA, conflicts_with_all = ["views", "lenses", "lens-shifts", "sensor", "baseline-m", "focal-mm", "sensor-mm", "projection", "disparity", "subset"])]
    pub camera_file: Option<String>,
    /// Poses of many cameras (transforms.json).
    ///
    /// Poses as NeRF and nerfstudio have them. Alone it writes images/NAME.png, a folder a
    /// layer, and transforms.json; with --views a light field at every pose, with --camera-file a raw image, each in a
    /// folder of its own. The size of images that the file does not say is --lenses.
    #[arg(long, value_name = "FILE", help_heading = CAMERA, conflicts_with_all = ["focal-mm", "sensor-mm", "camera"])]
    pub transforms: Option<PathBuf>,
    /// The axis that points up in the world of --transforms: z in files of Blender and nerfstudio, y in glTF.
    #[arg(long, value_name = "z|y", default_value = "z", requires = "transforms", value_parser = choice(WORLD_UPS), help_heading = CAMERA, hide_short_help = true)]
    pub transforms_up: WorldUp,
    #[command(flatten)]
    pub settings: Settings<OfRender>,
    /// Render with several seeds, such as 0-4 or 1,5,9, each into DIR/seed_N: images whose noise is independent.
    #[arg(long, value_name = "A-B|N,..", value_parser = Seeds::from_str, conflicts_with = "seed", help_heading = QUALITY, hide_short_help = true)]
    pub seeds: Option<Seeds>,
    /// Render part K of N only.
    ///
    /// Rows of microlenses or of a sensor's pixels, which `holo merge` joins; of several frames or poses every N-th, whole.
    #[arg(long, value_name = "K/N", value_parser = Shard::from_str, help_heading = RUNNING)]
    pub shard: Option<Shard>,
    #[command(flatten)]
    pub engine: EngineOptions,
    /// Seconds between checkpoints, from which the same command continues after an interruption; 0: none.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, default_value = "30", value_parser = not_negative, help_heading = RUNNING, hide_short_help = true)]
    pub checkpoint: f64,
    /// Replace another image in DIR.
    ///
    /// One of another scene or of other options. The same command again needs no permission.
    #[arg(long, help_heading = RUNNING)]
    pub overwrite: bool,
    /// Print no progress and no summary.
    #[arg(long, help_heading = RUNNING)]
    pub quiet: bool,
    /// Print one JSON object about the run on standard output.
    #[arg(long, help_heading = RUNNING)]
    pub json: bool,
}

#[derive(Args, Clone, Debug)]
pub struct EngineOptions {
    /// Threads [default: one per core].
    #[arg(long, help_heading = RUNNING, hide_short_help = true, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Ray tracing backend.
    #[arg(long, help_heading = RUNNING, hide_short_help = true, value_parser = choice(BACKENDS), default_value = "auto")]
    pub backend: Backend,
}

#[derive(Args, Debug)]
pub struct InfoOptions {
    /// A scene, a PNG, PFM, EXR, DNG, Radiance HDR or .mat, a parameters.cfg, a manifest.json, or a folder of them.
    pub file: PathBuf,
    #[command(flatten)]
    pub settings: Settings<OfInfo>,
    #[command(flatten)]
    pub engine: EngineOptions,
}

#[derive(Args, Debug)]
pub struct RemapOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// PNG to write, or PFM if the input has floats.
    #[arg(value_parser = values::png_or_pfm)]
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
    /// Files of every light field, without `scene_`, separated by commas, such as el.png,masks.fine.png [default: all, but
    /// beside el.png neither vpi.png, 5d.mat nor the views of hci, which have its pixels].
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub fields: Option<Vec<String>>,
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

/// Examples of `holo render`, for its long help.
const RENDER_EXAMPLES: &str = "\
Examples:
  holo render scene.glb --out raw                                       # 100 x 100 views, 8K, 16 samples a pixel
  holo render scene.glb --out soon --preset draft                       # the fastest image of the same
  holo render scene.glb --out hci --preset hci                          # 9 x 9 views as in the HCI benchmark, with truth
  holo render scene.glb --out near --eye 0,1,2 --target 0,0.5,0 --views 9 --lenses 512x512 --disparity=-1.5,1.5
  holo render scene.glb --out lytro --camera-file lytro-illum           # the raw image of a plenoptic camera
  holo render scene.glb --out film --views 9 --lenses 512x512 --frame 0-47";

const GENERATE_EXAMPLES: &str = "\
Examples:
  holo generate --count 1000 --recipe hci-like --spp 4 --integrator direct --out set # 9 x 9 views of 192 x 192 px, with truth
  holo generate --count 1000 --recipe hci-like --spp 4 --integrator direct --out set --shard 2/4
  holo generate --count 20 --out large --lenses 512x512
  holo generate --count 100 --out own --recipe own.toml                              # a recipe with models of one's own";

/// The long help of `--preset`: every preset with its settings.
fn preset_help() -> String {
    let line = |preset: &Preset| {
        let given = preset.given();
        let settings: Vec<String> = given.iter().map(|(key, text)| format!("--{key} {text}")).collect();
        format!("- {}: {} ({})", preset.name, preset.help, settings.join(" "))
    };
    let lines: Vec<String> = PRESETS.iter().map(line).collect();
    let first = "Settings with a name, below those of --config and of the command line; an option of the command \
                 line replaces all settings of the preset that exclude it.";
    format!("{first}\n\n{}", lines.join("\n"))
}

/// Parses the name of a preset.
fn preset(text: &str) -> Result<&'static Preset, String> {
    Preset::by_name(text).ok_or_else(|| {
        let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        format!("give one of {}", names.join(", "))
    })
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
