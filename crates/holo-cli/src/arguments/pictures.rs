//! The options of the commands that take light fields apart and put them together: extract, compose, rotate-elements, quilt,
//! animate.

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
    /// A part of every image alone: its left column, its top row, its width and height in pixels.
    #[arg(long, value_name = "X,Y,WxH", value_parser = values::crop)]
    pub crop: Option<Crop>,
    /// The PNG to write, or the PFM where the input holds floats; of several, each gets _rROW_cCOLUMN in its name.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

#[derive(Args, Debug)]
pub struct ComposeOptions {
    /// The pictures in their order, or a folder: its PNGs, ordered by name, numbers by their size.
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// Views, columns x rows, or one number for both.
    #[arg(long, value_name = "SxT|N", allow_negative_numbers = true, value_parser = GridSize::from_str)]
    pub views: GridSize,
    /// How the pictures run through the grid of views.
    #[arg(long, value_parser = choice(ORDERS), default_value = "row-major")]
    pub order: ViewOrder,
    /// The PNG to write.
    #[arg(long, value_name = "FILE", value_parser = values::png)]
    pub out: PathBuf,
    /// Which grid to write [default: by `_el` or `_vpi` in the name of --out].
    #[arg(long, value_parser = choice(LAYOUTS))]
    pub to: Option<Layout>,
}

#[derive(Args, Debug)]
pub struct RotateOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// The PNG to write.
    #[arg(value_parser = values::png)]
    pub output: PathBuf,
    /// Turn the raw image as a whole instead: as a sensor behind a main lens records it.
    #[arg(long)]
    pub whole: bool,
    /// What the output shall be [default: by `_el` or `_vpi` in its name, else as the input].
    #[arg(long, value_parser = choice(LAYOUTS))]
    pub to: Option<Layout>,
}

#[derive(Args, Debug)]
pub struct QuiltOptions {
    #[command(flatten)]
    pub input: InputOptions,
    /// Tiles of the quilt, columns x rows. Where the row has more views, they are taken at even distances.
    #[arg(long, value_name = "CxR", value_parser = GridSize::from_str)]
    pub tiles: GridSize,
    /// The row of views, from 0 [default: the central one].
    #[arg(long, value_name = "T")]
    pub row: Option<usize>,
    /// The PNG to write, or the PFM where the input holds floats.
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
    /// The way through the views.
    #[arg(long, value_enum, default_value_t = PathArgument::Circle)]
    pub path: PathArgument,
    /// The row of views for sweep and swing, from 0 [default: the central one].
    #[arg(long, value_name = "T")]
    pub row: Option<usize>,
    /// Pictures a second.
    #[arg(long, value_name = "N", default_value_t = 25.0, value_parser = values::frame_rate)]
    pub fps: f64,
    /// Write every picture into a file of its own, FILE with a number, instead of one that moves.
    #[arg(long)]
    pub frames: bool,
    /// The animated PNG to write; browsers show it, it repeats without end.
    #[arg(long, value_name = "FILE", value_parser = values::png_or_pfm)]
    pub out: PathBuf,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathArgument {
    /// Around the middle of the grid.
    Circle,
    /// A row from left to right.
    Sweep,
    /// A row from left to right and back.
    Swing,
    /// All views, row by row.
    Serpentine,
}
