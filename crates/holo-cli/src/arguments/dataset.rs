//! The options of `holo dataset`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use holo_core::GridSize;

use holo_dataset::Shard;

use super::{EngineOptions, JobOptions, MainLensOptions};

/// Every option can stand in a TOML file as well, under its long name; the command line wins.
#[derive(Args, Clone, Debug)]
pub struct DatasetOptions {
    /// Folder for the dataset; made if missing. What is done in it already is not done again.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// A TOML file with options: `spp = 64`, `scenes = ["garden", "chess"]`.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Scenes of the gallery, separated by commas, or `none` [default: all; `holo scene` lists them].
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Scenes of your own, .glb or .gltf, beside those of the gallery; each is called as its file.
    #[arg(long, value_name = "FILE,..", value_delimiter = ',')]
    pub glb: Vec<PathBuf>,
    /// Numbers of views, each columns x rows or one number for both, separated by commas: every scene is rendered with each.
    #[arg(long = "views", alias = "splits", value_name = "SxT|N,..", value_delimiter = ',', default_value = "20,40,60,80,100", value_parser = GridSize::from_str)]
    pub view_counts: Vec<GridSize>,
    #[command(flatten)]
    pub main_lens: MainLensOptions,
    #[command(flatten)]
    pub job: JobOptions,
    /// Do every N-th job only, beginning with the K-th: N machines with K from 1 to N make the whole, without talking.
    #[arg(long, value_name = "K/N", value_parser = Shard::from_str)]
    pub shard: Option<Shard>,
    #[command(flatten)]
    pub engine: EngineOptions,
    /// No progress and no summary.
    #[arg(long)]
    pub quiet: bool,
    /// One JSON object a job on standard output, and one about all of them at the end.
    #[arg(long)]
    pub json: bool,
}
