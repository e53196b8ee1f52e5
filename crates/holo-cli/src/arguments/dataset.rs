//! The options of `holo dataset` and `holo generate`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use holo_core::GridSize;

use holo_dataset::Shard;
use holo_dataset::settings::{Preset, not_negative};
use holo_io::WorldUp;

use super::choices::{WORLD_UPS, choice};
use super::headings::QUALITY;
use super::{EngineOptions, OfDataset, Settings, preset, preset_help};

/// Every option can also stand in a TOML file, under its long name; the command line wins.
#[derive(Args, Clone, Debug)]
pub struct DatasetOptions {
    /// Built-in scenes, separated by commas, `paper` for the fifteen of the paper's dataset, `stratified` for four that vary
    /// one difficulty each, or `none` [default: sixteen, or none with --glb; `holo scene` lists them].
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Your own scenes, .glb or .gltf; each is named after its file.
    #[arg(long, value_name = "FILE,..", value_delimiter = ',')]
    pub glb: Vec<PathBuf>,
    /// With --glb: all built-in scenes too.
    #[arg(long, conflicts_with = "scenes")]
    pub gallery: bool,
    /// Poses of NeRF and nerfstudio (transforms.json): every scene is rendered at each, as a scene of its own
    /// (`garden_POSE`), instead of where its camera stands. Views have the size of the images in the file, or --lenses if
    /// it says none.
    #[arg(long, value_name = "FILE", conflicts_with = "sensor")]
    pub transforms: Option<PathBuf>,
    /// The axis that points up in the world of --transforms: z in files of Blender and nerfstudio, y in glTF.
    #[arg(long, value_name = "z|y", default_value = "z", requires = "transforms", value_parser = choice(WORLD_UPS))]
    pub transforms_up: WorldUp,
    #[command(flatten)]
    pub collection: CollectionOptions,
}

/// Every option can also stand in a TOML file, under its long name; the command line wins.
#[derive(Args, Clone, Debug)]
pub struct GenerateOptions {
    /// The number of scenes, named by six digits from 000000.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub count: u64,
    /// The recipe: mixed, hci-like, thin-and-slanted, specular, plenoptic-raw, or your own TOML file.
    /// The set keeps its text in recipe.toml.
    #[arg(long, value_name = "NAME|FILE", default_value = "mixed")]
    pub recipe: String,
    #[command(flatten)]
    pub collection: CollectionOptions,
}

/// The options of both commands: output folder, cameras, settings.
#[derive(Args, Clone, Debug)]
pub struct CollectionOptions {
    /// Folder for the dataset; created if missing. What is complete in it is not rendered again.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// TOML file with options: `spp = 64`, `scenes = ["garden", "chess"]`.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Settings with a name: draft, clean, reference, hci, urbanlf, paper-8k.
    #[arg(long, value_name = "NAME", value_parser = preset, help_heading = QUALITY, long_help = preset_help())]
    pub preset: Option<&'static Preset>,
    /// Numbers of views, each columns x rows or one number for both, separated by commas: every scene is rendered with each
    /// [default: that of --preset, else 20,40,60,80,100, and 9 of `holo generate`].
    #[arg(long = "views", alias = "splits", value_name = "SxT|N,..", value_delimiter = ',', value_parser = GridSize::from_str)]
    pub view_counts: Vec<GridSize>,
    /// Plenoptic cameras instead of rigs of views, separated by commas: camera files (TOML) or presets of `holo camera`.
    /// Every scene is rendered with each, into a folder with the name of the camera; --focus-m and --f-number replace
    /// those of the files.
    #[arg(long, value_name = "FILE|PRESET,..", value_delimiter = ',', conflicts_with_all = ["view_counts", "sensor", "lenses", "disparity"])]
    pub camera_file: Vec<String>,
    #[command(flatten)]
    pub settings: Settings<OfDataset>,
    /// Render every N-th job only, starting with the K-th: N machines with K from 1 to N render the whole.
    #[arg(long, value_name = "K/N", value_parser = Shard::from_str)]
    pub shard: Option<Shard>,
    #[command(flatten)]
    pub engine: EngineOptions,
    /// Seconds between checkpoints, from which the same command continues after an interruption; 0: none.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, default_value = "30", value_parser = not_negative)]
    pub checkpoint: f64,
    /// Print no progress and no summary.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object per job on standard output, and one about all of them at the end.
    #[arg(long)]
    pub json: bool,
}
