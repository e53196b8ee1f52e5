//! Eq. 3: disparity from depth and back.

mod maps;
mod stereo;

pub use stereo::StereoPair;

use crate::Error;
use crate::base::error::{not_negative, positive_or_infinite};

/// The projection of one view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Projection {
    /// All rays of a view start in one point, as in a pinhole camera.
    Perspective,
    /// All rays of a view are parallel, as behind a telecentric lens: the paper's "VPIs are orthographic, EIs are
    /// perspective". Disparity is `k (F - Z) / F^2`.
    Orthographic,
}

/// The map between depth and disparity along one axis of a rig.
///
/// Disparity is the movement of a point between **adjacent** views: positive for points nearer than the focus plane, 0
/// on it, negative behind it. A point at `(row, column)` of one view is at `(row - d_y*dt, column - d_x*ds)` in the
/// view `dt` rows down and `ds` columns right.
///
/// # Other programs
///
/// | program | its number for a disparity of d px |
/// |---|---|
/// | HCI 4D benchmark: `gt_disp_*.pfm`, its toolkit | d |
/// | plenpy 0.9, `get_disparity` | d |
/// | plenpy 0.9, `get_refocus` | slope d (T-1)/T for T views along the axis |
/// | LFToolbox 0.5, `LFFiltShiftSum` | slope -d (T-1)/T: [`slope_from_disparity`](crate::refocus::slope_from_disparity) |
///
/// All of them for arrays in the order of the views of this crate, without flips: row 0 is the top one, column 0 the left
/// one. The factor comes from shifts that run from -T/2 to T/2 over T views. A program that counts views from the other
/// side sees the opposite sign.
///
/// # Units
///
/// Depth in meters along the optical axis, disparity in pixels. The scale k = baseline * f * N / sens is in
/// meter-pixels.
///
/// # Source
///
/// Eq. 3 as `k * (F - Z) / (Z * F)`. The form of the paper, a difference of reciprocals, cancels for Z near F.
///
/// # Examples
///
/// ```
/// use holo_core::{Disparity, Projection};
///
/// let disparity = Disparity::new(36.571, f64::INFINITY, Projection::Perspective)?;
/// assert_eq!(disparity.from_depth_m(f64::INFINITY), 0.0);
/// assert_eq!(disparity.from_depth_m(2.0), 36.571 / 2.0);
/// assert_eq!(disparity.to_depth_m(36.571), 1.0);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disparity {
    scale_m_px: f64,
    focus_distance_m: f64,
    projection: Projection,
}

impl Disparity {
    /// Returns the map for a scale k in meter-pixels, a focus distance in meters (may be infinite) and a projection.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the scale is NaN, infinite or negative or the focus distance is not above 0;
    /// [`Error::OrthographicFocus`] if an orthographic map has an infinite focus distance.
    pub fn new(scale_m_px: f64, focus_distance_m: f64, projection: Projection) -> Result<Self, Error> {
        let scale_m_px = not_negative("disparity scale in meter-pixels", scale_m_px)?;
        let focus_distance_m = positive_or_infinite("focus distance in meters", focus_distance_m)?;
        if projection == Projection::Orthographic && focus_distance_m.is_infinite() {
            return Err(Error::OrthographicFocus { focus_distance_m });
        }
        Ok(Self { scale_m_px, focus_distance_m, projection })
    }

    /// Returns the scale k = baseline * f * N / sens, in meter-pixels.
    #[must_use]
    pub const fn scale_m_px(&self) -> f64 {
        self.scale_m_px
    }

    /// Returns the focus distance, in meters; may be infinite.
    #[must_use]
    pub const fn focus_distance_m(&self) -> f64 {
        self.focus_distance_m
    }

    /// Returns the projection.
    #[must_use]
    pub const fn projection(&self) -> Projection {
        self.projection
    }

    /// Returns the disparity of depth `+infinity`, which also stands for rays without a hit.
    ///
    /// Perspective: `-k/F`, or 0 with the focus at infinity. Orthographic: `-infinity`. 0 without a baseline.
    #[must_use]
    pub fn at_infinity_px(self) -> f64 {
        self.from_depth_m(f64::INFINITY)
    }

    /// Returns the disparity, in pixels between adjacent views, of a point at planar depth `depth_m`.
    ///
    /// A depth of `+infinity` gives the disparity of infinity, so a map with infinite depth for "no hit" needs no mask.
    /// NaN gives NaN. Depth 0 gives an infinite disparity (perspective). Without a baseline the result is 0 for every
    /// depth.
    ///
    /// # Accuracy
    ///
    /// Within 4 ulp of the exact value for the stored k and F, at every depth, including Z = F * (1 +- 1e-15): the
    /// subtraction, two divisions and one multiplication each round once, and no cancellation follows the first
    /// rounding. For k = 0 or k above 1e-280, an intermediate result overflows or underflows only if the final result
    /// does.
    ///
    /// # Source
    ///
    /// Eq. 3.
    #[must_use]
    #[allow(clippy::wrong_self_convention, reason = "`from` names the quantity of the argument")]
    pub fn from_depth_m(self, depth_m: f64) -> f64 {
        let Self { scale_m_px: k, focus_distance_m: focus_m, projection } = self;
        if k == 0.0 {
            // Views in one place see the same image. Otherwise 0 * infinity would give NaN.
            return if depth_m.is_nan() { f64::NAN } else { 0.0 };
        }
        match projection {
            // This is right for Z = infinity too: k/infinity = 0.
            Projection::Perspective if focus_m.is_infinite() => k / depth_m,
            Projection::Perspective if depth_m == f64::INFINITY => -k / focus_m,
            Projection::Perspective => {
                // (F-Z)/max(F,Z) lies in [-1, 1] for every positive Z, where Z*F or (F-Z)/F could leave the range of
                // f64.
                let (smaller, larger) = if depth_m < focus_m { (depth_m, focus_m) } else { (focus_m, depth_m) };
                k * ((focus_m - depth_m) / larger) / smaller
            }
            Projection::Orthographic => k * ((focus_m - depth_m) / focus_m) / focus_m,
        }
    }

    /// Returns the planar depth, in meters, at which a point has the disparity `disparity_px`.
    ///
    /// The disparity of infinity gives exactly `+infinity`. No point in front of a perspective rig has a lower
    /// disparity; the formula then gives a negative depth, so that the two maps remain inverses. Without a baseline the
    /// result is NaN.
    ///
    /// # Accuracy
    ///
    /// Within 3 ulp of the exact value for the given disparity, the stored k and F: a fused multiply-add, a division
    /// and a multiplication. (The rounding of the disparity itself changes a far depth by about Z/F * 2^-53 of it.)
    ///
    /// # Source
    ///
    /// Eq. 3 solved for Z: `k * F / (d * F + k)`; orthographic: `F * (k - d * F) / k`.
    #[must_use]
    pub fn to_depth_m(self, disparity_px: f64) -> f64 {
        self.depth_or_infinity(disparity_px, disparity_px == self.at_infinity_px())
    }

    fn depth_or_infinity(self, disparity_px: f64, is_infinity: bool) -> f64 {
        let Self { scale_m_px: k, focus_distance_m: focus_m, projection } = self;
        if k == 0.0 {
            return f64::NAN;
        }
        if is_infinity {
            // -k/F is rounded, so d*F + k would be a rounding error of either sign instead of 0.
            return f64::INFINITY;
        }
        match projection {
            Projection::Perspective if focus_m.is_infinite() => k / disparity_px,
            Projection::Perspective => k / disparity_px.mul_add(focus_m, k) * focus_m,
            Projection::Orthographic => (-disparity_px).mul_add(focus_m, k) / k * focus_m,
        }
    }
}
