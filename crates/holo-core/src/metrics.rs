//! Error measures of disparity maps and of images.
//!
//! # Disparity maps
//!
//! [`disparity_scores`], [`bumpiness`] and [`median_angle_error_deg`] follow the 4D Light Field Benchmark of Konstanz
//! and Heidelberg (K. Honauer, O. Johannsen, D. Kondermann and B. Goldluecke, *A dataset and evaluation methodology for
//! depth estimation on 4D light fields*, ACCV 2016) and its evaluation toolkit, for maps of any size. The documentation
//! of each function states what only the toolkit specifies, and the two deliberate differences. In short:
//!
//! - A pixel whose **estimate** is NaN or infinite is *bad*, and is excluded from means and percentiles. (The toolkit
//!   counts NaN as good, because a comparison with NaN is false, and infinity as bad.)
//! - A pixel whose **ground truth** is NaN or infinite is excluded from all measures.
//!
//! [`PixelCounts`] has the numbers of both.
//!
//! [`trivial_constant`] and [`trivial_plane`] are trivial baselines: the scores of the best constant and of a good
//! plane, which use the ground truth and no light field. [`error_map`] is the error as an image.
//!
//! # Images
//!
//! [`psnr_db`] and [`ssim`] compare images of integers and floats; the caller specifies the range of values.

mod disparity;
mod error_map;
mod normals;
mod psnr;
mod region;
mod smoothness;
mod ssim;
mod trivial;

pub use disparity::{
    BAD_PIXEL_THRESHOLDS_PX, DisparityScores, FINE_THRESHOLD_PX, bad_pixels_percent, disparity_scores,
    fattening_percent, thinning_percent,
};
pub use error_map::{ErrorColors, error_map};
pub use normals::{NormalGeometry, median_angle_error_deg, normals_from_disparity};
pub use psnr::psnr_db;
pub use region::{DEFAULT_BORDER_PX, PixelCounts, Region};
pub use smoothness::{BUMPINESS_LIMIT, bumpiness};
pub use ssim::{SSIM_WINDOW_PX, ssim};
pub use trivial::{TrivialConstant, TrivialPlane, trivial_constant, trivial_plane};

/// A score and the numbers of its pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// The score, in the unit of the function; NaN if no pixel could be measured.
    pub value: f64,
    /// The number of measured pixels.
    pub pixels: usize,
    /// The number of excluded pixels of the region: a required value is missing or outside the map.
    pub excluded: usize,
}
