//! The arguments of `holo preview`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args;
use holo_dataset::settings::Preset;
use holo_io::WorldUp;

use super::choices::{WORLD_UPS, choice};
use super::{EngineOptions, OfPreview, Settings, preset};

#[derive(Args, Clone, Debug)]
pub struct PreviewOptions {
    /// The scene: .glb, or .gltf with the files it refers to [default: the page begins with the gallery].
    pub scene: Option<PathBuf>,
    /// Folder that the page's renders go into, each into a new folder of its own.
    #[arg(long, value_name = "DIR", default_value = "holo-preview")]
    pub out: PathBuf,
    /// Port; 0: a free one.
    #[arg(long, value_name = "P", default_value_t = 0)]
    pub port: u16,
    /// Print the address, and open no browser.
    #[arg(long)]
    pub no_open: bool,
    /// Address to listen on: 0.0.0.0 lets other computers use the page, if they have its whole address.
    #[arg(long, value_name = "IP", default_value = "127.0.0.1")]
    pub listen: IpAddr,
    /// Settings with a name, below those of the command line.
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub preset: Option<&'static Preset>,
    /// Plenoptic camera instead of a rig of views: a camera file (TOML), or a preset of `holo camera`.
    #[arg(long, value_name = "FILE|PRESET")]
    pub camera_file: Option<String>,
    /// Poses to look from (transforms.json): the page has a list of them.
    #[arg(long, value_name = "FILE")]
    pub transforms: Option<PathBuf>,
    /// The axis that points up in the world of --transforms: z in files of Blender and nerfstudio, y in glTF.
    #[arg(long, value_name = "z|y", default_value = "z", requires = "transforms", value_parser = choice(WORLD_UPS))]
    pub transforms_up: WorldUp,
    #[command(flatten)]
    pub settings: Settings<OfPreview>,
    #[command(flatten)]
    pub engine: EngineOptions,
}
