//! The options of the commands that extract and compose images: extract, compose, rotate-elements, quilt, display, animate.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{ArgGroup, Args, ValueEnum};
use holo_core::{GridSize, Layout, ViewOrder};

use super::choices::{LAYOUTS, ORDERS, choice};
use super::tools::InputOptions;
use super::{Crop, Places, values};

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("image").required(true).args(["view", "lens"])))]
pub struct ExtractOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Viewpoint images: the column and row of one, from 0; or several: `all`, `0-9,4`, `0-99:10,all`.
    #[arg(long, value_name = "S,T", allow_hyphen_values = true)]
    pub view: Option<Places>,
    /// Elemental images: the column and row of a lens, from 0; or several, as with --view.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true)]
    pub lens: Option<Places>,
    /// Crop every image: left column, top row, width and height in pixels.
    #[arg(long, value_name = "X,Y,WxH", value_parser = values::crop)]
    pub crop: Option<Crop>,
    /// PNG to write, or PFM if the input has floats; several get _rROW_cCOLUMN in their names.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

#[derive(Args, Debug)]
pub struct ComposeOptions {
    /// The images in order, or a folder: its PNGs in natural order (2 before 10).
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// Views, columns x rows, or one number for both.
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, value_parser = GridSize::from_str)]
    pub views: GridSize,
    /// Order of the images in the grid of views.
    #[arg(long, value_parser = choice(ORDERS), default_value = "row-major")]
    pub order: ViewOrder,
    /// PNG to write.
    #[arg(long, value_name = "FILE", value_parser = values::png)]
    pub out: PathBuf,
    /// Layout of the output [default: by `_el` or `_vpi` in the name of --out].
    #[arg(long, value_parser = choice(LAYOUTS))]
    pub to: Option<Layout>,
}

#[derive(Args, Debug)]
pub struct RotateOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// PNG to write, or PFM if the input has floats.
    #[arg(value_parser = values::png_or_pfm)]
    pub output: PathBuf,
    /// Rotate the whole raw image instead: as a sensor behind a main lens records it.
    #[arg(long)]
    pub whole: bool,
    /// Layout of the output [default: by `_el` or `_vpi` in its name, else as the input].
    #[arg(long, value_parser = choice(LAYOUTS))]
    pub to: Option<Layout>,
}

#[derive(Args, Debug)]
pub struct DisplayOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// The display: a file with its panel and lenses (TOML), or the `visual.json` of a Looking Glass.
    #[arg(long, value_name = "FILE")]
    pub display: PathBuf,
    /// What appears in the plane of the lenses has a disparity of D px between adjacent views [default: 0].
    #[arg(long, value_name = "D", allow_negative_numbers = true, conflicts_with = "distance_m", value_parser = values::finite)]
    pub disparity: Option<f64>,
    /// What appears in the plane of the lenses is at this distance from the cameras, m; needs the camera parameters.
    #[arg(long, value_name = "Z", allow_negative_numbers = true, value_parser = values::distance)]
    pub distance_m: Option<f64>,
    /// Show the scene as a model, enlarged or reduced alike in all directions; needs the camera parameters.
    ///
    /// Without it the views fill the zone of the lenses, and depths are scaled to fit it.
    #[arg(long)]
    pub to_scale: bool,
    /// Row of views for cylindrical lenses, from 0 [default: the middle].
    #[arg(long, value_name = "T")]
    pub row: Option<usize>,
    /// Write what an eye at this place sees of the display instead: m from the middle of the lenses to the right, up, to the viewer.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::point)]
    pub eye: Option<[f64; 3]>,
    /// Image to write, PNG, or PFM if the input has floats: as many pixels as the panel, or with --eye about one a lens.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

#[derive(Args, Debug)]
pub struct QuiltOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Tiles of the quilt, columns x rows. If the row has more views, evenly spaced ones are taken.
    #[arg(long, value_name = "CxR", value_parser = GridSize::from_str)]
    pub tiles: GridSize,
    /// Row of views, from 0 [default: the central one].
    #[arg(long, value_name = "T")]
    pub row: Option<usize>,
    /// PNG to write, or PFM if the input has floats.
    ///
    /// The first view is at the bottom left, the last at the top right. Looking Glass displays read the tiles and the shape of a
    /// view from a name that ends in _qsCxRaWIDTH/HEIGHT, such as city_qs8x6a1.5.png.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

#[derive(Args, Debug)]
pub struct AnimateOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Camera path through the views; of a sequence once in its whole time [default: circle, of a sequence the central view].
    #[arg(long, value_enum)]
    pub path: Option<PathArgument>,
    /// Row of views for sweep and ping-pong, from 0 [default: the central one].
    #[arg(long, value_name = "T")]
    pub row: Option<usize>,
    /// Frames per second [default: 25, of a sequence its own].
    #[arg(long, value_name = "N", value_parser = values::frame_rate)]
    pub fps: Option<f64>,
    /// Write every frame into a file of its own, FILE with a number, instead of one animation.
    #[arg(long)]
    pub frames: bool,
    /// Animation to write: .png or .gif, which browsers play in a loop, or .mp4, which needs ffmpeg. With --frames an image.
    #[arg(long, value_name = "FILE", value_parser = values::animation)]
    pub out: PathBuf,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathArgument {
    /// A circle around the central view.
    Circle,
    /// One row from left to right.
    Sweep,
    /// One row from left to right and back.
    #[value(alias = "swing")]
    PingPong,
    /// All views, row by row.
    Serpentine,
}
