//! HCI folders: one PNG a view, the camera parameters, and ground truth as PFM.
//!
//! | file | what |
//! |---|---|
//! | `input_Cam000.png` ... | view `(t, s)` of T x S views; the number is `t*S + s`, the top left view is 0 |
//! | `gt_disp_lowres.pfm`, `gt_depth_lowres.pfm` | disparity in pixels and planar depth in metres of the central view |
//! | `gt_disp_lowres_Cam000.pfm` ... | the same of every view |
//! | `gt_disp_highres.pfm` ... | the same `depth_map_scale` times as fine; only read |
//! | `parameters.cfg` | the rig |
//!
//! # Names
//!
//! A number has three digits, and more from 1000 on: `input_Cam999.png` is followed by `input_Cam1000.png`. That is what
//! the format `%03d` of the HCI tools gives, so programs that build the names find every view of any grid; programs that
//! sort names as text do not. A reader here takes any number of leading zeros.
//!
//! # A folder is complete when its `parameters.cfg` is there
//!
//! It is taken away before anything else is written and written last. A reader who asks for it first therefore never
//! takes a half-written folder for a light field.
//!
//! # What the HCI tools do not know
//!
//! - *Unequal baselines.* `baseline_mm` is the horizontal one, and `baseline_y_mm` is added only where the vertical one
//!   differs. The HCI tools take the first for both. Disparity in files is always the horizontal one.
//! - *Orthographic views.* The key `projection` is added then.
//! - *Even counts.* The central view is row T/2, column S/2, rounded down; for odd counts that is the HCI tools' own.
//! - *No hit.* Depth is `+infinity`, where the scenes of the HCI benchmark have a wall.
//!
//! # Source
//!
//! K. Honauer, O. Johannsen, D. Kondermann, B. Goldluecke: *A Dataset and Evaluation Methodology for Depth Estimation on
//! 4D Light Fields*, ACCV 2016, and the add-on for Blender that goes with it.

mod folder;
mod names;
mod write;

pub use folder::HciFolder;
pub use write::{HciImage, HciTruth};

/// What a map of ground truth holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HciQuantity {
    /// Planar depth in metres: `gt_depth_*`.
    Depth,
    /// Disparity in pixels between horizontally adjacent views: `gt_disp_*`.
    Disparity,
}

/// How fine a map of ground truth is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HciResolution {
    /// One value a pixel of the view: `*_lowres`.
    Low,
    /// `depth_map_scale` times as many along each side: `*_highres`.
    High,
}

/// What errors call the folder.
const FORMAT: &str = "HCI folder";
