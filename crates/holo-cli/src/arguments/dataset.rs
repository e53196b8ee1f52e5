//! The options of `holo dataset`.

use std::path::PathBuf;

use clap::Args;
use holo_core::{GridSize, Sensor};

use super::{EngineOptions, FocusArgument, JobOptions, Shard, values};

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
    /// Views per axis, or columns x rows, separated by commas.
    #[arg(long, value_name = "SxT|N,..", value_delimiter = ',', default_value = "20,40,60,80,100", value_parser = values::size)]
    pub splits: Vec<GridSize>,
    /// The sensor behind the lenses: hd, 4k, 8k (the paper's 7952x5304), uhd8k or WIDTHxHEIGHT.
    #[arg(long, value_name = "NAME|WxH", default_value = "8k", value_parser = values::sensor)]
    pub sensor: Sensor,
    /// The views sample the aperture of an f/N lens.
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 5.0, value_parser = values::positive)]
    pub f_number: f64,
    /// Distance of the focus plane, m, `inf`, or `auto` (harmonic mean of nearest and farthest depth).
    #[arg(long, value_name = "Z|inf|auto", allow_negative_numbers = true, default_value = "auto")]
    pub focus_m: FocusArgument,
    #[command(flatten)]
    pub job: JobOptions,
    /// Do every N-th job only, beginning with the K-th: N machines with K from 1 to N make the whole, without talking.
    #[arg(long, value_name = "K/N", value_parser = values::shard)]
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
