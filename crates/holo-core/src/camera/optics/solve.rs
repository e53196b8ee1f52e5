//! The rig for a given range of disparities.

use super::{DepthRange, DisparityRange};
use crate::base::error::positive;
use crate::{Disparity, Error, GridSize, Intrinsics, Projection};

/// The focus distance and the baseline for a range of disparities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisparitySolution {
    /// The focus distance, in meters; may be infinite.
    pub focus_distance_m: f64,
    /// The distance between adjacent views, in meters.
    pub baseline_m: f64,
    /// Eq. 3 with these numbers.
    pub disparity: Disparity,
}

/// Returns the focus distance and the baseline for which the nearest depth has the largest disparity and the farthest
/// depth the smallest.
///
/// For disparities of equal size at both ends, the focus distance is the harmonic mean of the two depths.
///
/// # Units
///
/// Depths in meters, the farthest may be infinite; disparities in pixels between adjacent views; `lenses` is the
/// spatial resolution of a view.
///
/// # Errors
///
/// [`Error::ImpossibleRange`] if the largest disparity is not above the smallest, or if the focus plane would be beyond
/// infinity; [`Error::BadNumber`] if a number is NaN, infinite or of the wrong sign.
///
/// # Source
///
/// Eq. 3 for both ends, solved: `k = (d1 - d2) / (1/Z1 - 1/Z2)`, `F = (d1 - d2) Z1 / (d1 Z1/Z2 - d2)`, `baseline = k
/// sens / (f N)`.
///
/// # Examples
///
/// ```
/// use holo_core::optics::{DepthRange, DisparityRange, rig_for_disparities};
/// use holo_core::{GridSize, Intrinsics};
///
/// let intrinsics = Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 };
/// let wanted = DisparityRange { min_px: -2.0, max_px: 2.0 };
/// let found = rig_for_disparities(DepthRange::new(2.0, 6.0)?, wanted, intrinsics, GridSize::new(512, 512))?;
/// assert_eq!(found.focus_distance_m, 3.0);
/// assert!((found.disparity.from_depth_m(2.0) - 2.0).abs() < 1e-12);
/// assert!((found.disparity.from_depth_m(6.0) + 2.0).abs() < 1e-12);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn rig_for_disparities(
    depths: DepthRange,
    disparities: DisparityRange,
    intrinsics: Intrinsics,
    lenses: GridSize,
) -> Result<DisparitySolution, Error> {
    let DepthRange { near_m, far_m } = DepthRange::new(depths.near_m, depths.far_m)?;
    let DisparityRange { min_px, max_px } = disparities;
    for (what, value) in [("smallest disparity in pixels", min_px), ("largest disparity in pixels", max_px)] {
        if !value.is_finite() {
            return Err(Error::BadNumber { what, value, need: "finite" });
        }
    }
    if min_px >= max_px {
        return Err(Error::ImpossibleRange { why: "the largest disparity must be above the smallest" });
    }
    let focal_length_m = positive("focal length in meters", intrinsics.focal_length_m)?;
    let sensor_size_m = positive("sensor size in meters", intrinsics.sensor_size_m)?;
    let pixels = positive("pixels along the larger side of a view", lenses.larger() as f64)?;
    // Z1/Z2, which is 0 for an infinite Z2.
    let ratio = near_m / far_m;
    let span_px = max_px - min_px;
    let scale_m_px = positive("disparity scale in meter-pixels", span_px * near_m / (1.0 - ratio))?;
    let beyond_px = max_px * ratio - min_px;
    if beyond_px < 0.0 {
        let why = "the farthest depth would lie nearer than the focus plane, and that beyond infinity; \
                   choose a lower smallest disparity, or a larger ratio of the disparities";
        return Err(Error::ImpossibleRange { why });
    }
    // + 0.0 turns -0 into +0, whose quotient is +infinity: a focus at infinity.
    let focus_distance_m = span_px * near_m / (beyond_px + 0.0);
    let baseline_m = positive("baseline in meters", scale_m_px * sensor_size_m / (focal_length_m * pixels))?;
    let disparity = Disparity::new(scale_m_px, focus_distance_m, Projection::Perspective)?;
    Ok(DisparitySolution { focus_distance_m, baseline_m, disparity })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LightFieldShape, Rig};

    const INTRINSICS: Intrinsics = Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 };
    const LENSES: GridSize = GridSize::new(240, 360);

    fn solve(near_m: f64, far_m: f64, min_px: f64, max_px: f64) -> Result<DisparitySolution, Error> {
        rig_for_disparities(DepthRange { near_m, far_m }, DisparityRange { min_px, max_px }, INTRINSICS, LENSES)
    }

    #[test]
    fn solutions_have_the_requested_disparities() {
        for (near_m, far_m) in [(2.0, 6.0), (0.01, 0.011), (1.0, f64::INFINITY), (3.0, 1e9)] {
            for (min_px, max_px) in [(-2.0, 2.0), (-0.5, 3.0), (-4.0, -1.0), (-1e-3, 1e-3), (0.0, 2.0), (-3.0, 0.0)] {
                // Disparities of one sign need a focus in front of or behind all; in front there is always room.
                let found = solve(near_m, far_m, min_px, max_px).unwrap();
                let rig = Rig::builder(LightFieldShape::new(GridSize::new(5, 5), LENSES).unwrap())
                    .intrinsics(INTRINSICS)
                    .baseline_m(found.baseline_m)
                    .focus_distance_m(found.focus_distance_m)
                    .build()
                    .unwrap();
                // k and F are good to some ulp; what that is in disparity grows with how near together the depths are:
                // by k/Z over the span.
                let bound = 1e-14 * rig.disparity().scale_m_px() / near_m;
                assert!(
                    (rig.disparity().from_depth_m(near_m) - max_px).abs() < bound,
                    "{near_m} {far_m} {min_px} {max_px}"
                );
                assert!(
                    (rig.disparity().from_depth_m(far_m) - min_px).abs() < bound,
                    "{near_m} {far_m} {min_px} {max_px}"
                );
            }
        }
    }

    #[test]
    fn focus_and_baseline_by_hand() {
        // The harmonic mean of 2 and 6 is 3; k = 4/(1/2 - 1/6) = 12; f N / sens = 500.
        let found = solve(2.0, 6.0, -2.0, 2.0).unwrap();
        assert!((found.focus_distance_m - 3.0).abs() < 1e-15 && (found.baseline_m - 12.0 / 500.0).abs() < 1e-16);
        // Infinity at 0 px: the focus is there.
        assert_eq!(solve(2.0, f64::INFINITY, 0.0, 2.0).unwrap().focus_distance_m, f64::INFINITY);
        // Infinity at -2 px and 2 m at +2: 1/F is half of 1/2.
        assert!((solve(2.0, f64::INFINITY, -2.0, 2.0).unwrap().focus_distance_m - 4.0).abs() < 1e-15);
        // The far end in focus.
        assert!((solve(2.0, 6.0, 0.0, 2.0).unwrap().focus_distance_m - 6.0).abs() < 1e-14);
    }

    #[test]
    fn impossible_requests_are_errors() {
        // 1/F = 1/6 - 1/12 > 0 for 1 px at 6 m with k = 12; 3 px there would need 1/F = 1/6 - 3/12 < 0.
        assert!(solve(2.0, 6.0, 1.0, 5.0).is_ok());
        assert!(matches!(solve(2.0, 6.0, 3.0, 7.0), Err(Error::ImpossibleRange { .. })));
        assert!(matches!(solve(2.0, 6.0, 1.0, 1.0), Err(Error::ImpossibleRange { .. })));
        assert!(matches!(solve(2.0, 6.0, 2.0, -2.0), Err(Error::ImpossibleRange { .. })));
        assert!(matches!(solve(6.0, 2.0, -2.0, 2.0), Err(Error::ImpossibleRange { .. })));
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(solve(2.0, 6.0, -2.0, bad).is_err() && solve(bad, 6.0, -2.0, 2.0).is_err());
        }
        assert!(solve(2.0, f64::NAN, -2.0, 2.0).is_err());
        let nothing = GridSize::new(0, 0);
        let depths = DepthRange { near_m: 2.0, far_m: 6.0 };
        let disparities = DisparityRange { min_px: -2.0, max_px: 2.0 };
        assert!(rig_for_disparities(depths, disparities, INTRINSICS, nothing).is_err());
    }
}
