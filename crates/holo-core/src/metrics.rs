//! How far a disparity map is from the truth, and a picture from another.
//!
//! # Disparity maps
//!
//! [`disparity_scores`], [`bumpiness`] and [`median_angle_error_deg`] follow the 4D Light Field Benchmark of Konstanz and Heidelberg
//! (K. Honauer, O. Johannsen, D. Kondermann and B. Goldluecke, *A dataset and evaluation methodology for depth estimation on 4D light
//! fields*, ACCV 2016) as its evaluation toolkit computes it, for maps of any size. What the toolkit does and the paper does not say, and
//! the two places where this module differs on purpose, stand in the documentation of each function. In short:
//!
//! - A pixel whose **estimate** is NaN or infinite is *bad*, and is left out of means and percentiles, where it has no value. (The toolkit
//!   counts NaN as good, because a comparison with NaN is false, and infinity as bad.)
//! - A pixel whose **truth** is NaN or infinite cannot be judged and is left out everywhere.
//!
//! Both are counted in [`PixelCounts`]: a score over few pixels cannot pass for a score over all.
//!
//! [`trivial_constant`] and [`trivial_plane`] score what needs no light field at all: the maps that an estimate has to beat.
//! [`error_map`] is the error as a picture.
//!
//! # Pictures
//!
//! [`psnr_db`] and [`ssim`] compare pictures of `u8`, `u16` and `f32`, whose range of values the caller states.

mod disparity;
mod error_map;
mod normals;
mod psnr;
mod region;
mod smoothness;
mod ssim;
mod trivial;

pub use disparity::{BAD_PIXEL_THRESHOLDS_PX, DisparityScores, bad_pixels_percent, disparity_scores};
pub use error_map::{ErrorColors, error_map};
pub use normals::{NormalGeometry, median_angle_error_deg, normals_from_disparity};
pub use psnr::psnr_db;
pub use region::{DEFAULT_BORDER_PX, PixelCounts, Region};
pub use smoothness::{BUMPINESS_LIMIT, bumpiness};
pub use ssim::{SSIM_WINDOW_PX, ssim};
pub use trivial::{TrivialConstant, TrivialPlane, trivial_constant, trivial_plane};

/// A score and the pixels that it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// The score, in the unit that the function names; NaN if no pixel could be measured.
    pub value: f64,
    /// How many pixels could be measured.
    pub pixels: usize,
    /// How many pixels of the region could not: a value that they need is missing, or lies outside the map.
    pub excluded: usize,
}
