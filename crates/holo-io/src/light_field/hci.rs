//! HCI folders: one PNG a view, `parameters.cfg`, and ground truth as PFM.
//!
//! | file | what |
//! |---|---|
//! | `input_Cam000.png` ... | view `(t, s)` of T x S views; its number is `t*S + s`, so that the top left view is 0 |
//! | `gt_disp_lowres.pfm`, `gt_depth_lowres.pfm` | disparity in pixels and planar depth in meters of the central view |
//! | `gt_disp_lowres_Cam000.pfm` ... | the same of every view |
//! | `gt_disp_highres.pfm`, `gt_depth_highres.pfm` | the same of the central view, with `depth_map_scale` times the resolution |
//! | `gt_disp_highres_Cam000.pfm` ... | the same of every view; read, but not written |
//! | `parameters.cfg` | the rig |
//!
//! # Names
//!
//! A number has three digits, and more from 1000 on: `input_Cam999.png` is followed by `input_Cam1000.png`. That is the
//! format `%03d` of the HCI tools: programs that construct the names find every view of any grid; programs that sort
//! names as text do not. The reader accepts any number of leading zeros.
//!
//! # A folder is complete when it has a `parameters.cfg`
//!
//! The writer removes an older `parameters.cfg` before it writes anything else, and writes the new one last. A reader
//! that opens it first therefore never reads a partial folder.
//!
//! # Extensions of the HCI format
//!
//! - *Unequal baselines.* `baseline_mm` is the horizontal one, and `baseline_y_mm` is added only where the vertical one
//!   differs. The HCI tools use the first for both. Disparity in files is always the horizontal one.
//! - *Orthographic views.* The key `projection` is added for them.
//! - *Even counts.* The central view is row T/2, column S/2, rounded down; for odd counts it is that of the HCI tools.
//! - *No hit.* Depth is `+infinity`. The scenes of the HCI benchmark have a hit at every pixel.
//!
//! # Source
//!
//! K. Honauer, O. Johannsen, D. Kondermann, B. Goldluecke: *A Dataset and Evaluation Methodology for Depth Estimation
//! on 4D Light Fields*, ACCV 2016, and the add-on for Blender that goes with it.

mod folder;
mod names;
mod subset;
mod write;

pub use folder::HciFolder;
pub use subset::HciSubset;
pub use write::{HciHighResolution, HciImage, HciTruth};

/// Returns the name of the file of a view, by its number: view row * columns + view column.
///
/// # Examples
///
/// ```
/// assert_eq!(holo_io::hci::view_file_name(40), "input_Cam040.png");
/// ```
#[must_use]
pub fn view_file_name(index: usize) -> String {
    names::Name::View(index).to_string()
}

/// The quantity of a ground truth map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HciQuantity {
    /// Planar depth in meters, `+infinity` without a hit: `gt_depth_*`.
    Depth,
    /// Disparity in pixels between horizontally adjacent views: `gt_disp_*`.
    Disparity,
}

/// The resolution of a ground truth map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HciResolution {
    /// One value a pixel of the view: `*_lowres`.
    Low,
    /// `depth_map_scale` times as many values along each side: `*_highres`.
    High,
}

/// The name of the format in messages.
const FORMAT: &str = "HCI folder";
