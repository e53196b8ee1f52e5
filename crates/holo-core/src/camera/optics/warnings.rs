//! Warnings about rigs.

use std::fmt;

use super::{DepthRange, DisparityRange, Optics};
use crate::Error;
use crate::base::error::positive;

/// A warning that a rig does not suit a range of depths. The rig is valid all the same.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum OpticsWarning {
    /// Some depths have disparities beyond the limit.
    DisparityBeyondLimit {
        /// The disparities of the depths.
        range: DisparityRange,
        /// The largest acceptable disparity, of either sign, in pixels.
        limit_px: f64,
    },
    /// The depth resolution is coarser than the range: the baseline is too small.
    DepthResolutionTooCoarse {
        /// The depth resolution in the middle of the range, in meters; may be infinite.
        resolution_m: f64,
        /// The length of the range, in meters.
        depth_m: f64,
        /// The disparity resolution, in pixels.
        step_px: f64,
    },
}

impl fmt::Display for OpticsWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DisparityBeyondLimit { range: DisparityRange { min_px, max_px }, limit_px } => write!(
                f,
                "disparities from {min_px:.3} to {max_px:.3} px leave -{limit_px} to {limit_px} px: use a smaller \
                 baseline, more views on the same aperture, or a focus distance nearer to the harmonic mean \
                 of the depths"
            ),
            Self::DepthResolutionTooCoarse { resolution_m, depth_m, step_px } => {
                if resolution_m.is_finite() {
                    write!(f, "a step of {step_px} px is {resolution_m:.3} m deep")?;
                } else {
                    write!(f, "a step of {step_px} px reaches to infinity")?;
                }
                write!(f, ", more than the whole range of {depth_m:.3} m: use a larger baseline or more pixels a view")
            }
        }
    }
}

/// The relative rounding error of a rig and its disparities: a few dozen operations of half an ulp, with room to spare.
const ROUNDING: f64 = 1e-12;

pub(super) fn of(
    optics: &Optics,
    depths: DepthRange,
    limit_px: f64,
    step_px: f64,
) -> Result<Vec<OpticsWarning>, Error> {
    let limit_px = positive("disparity limit in pixels", limit_px)?;
    let step_px = positive("disparity step in pixels", step_px)?;
    let range = optics.disparity_range_px(depths);
    let mut warnings = Vec::new();
    // A rig that was computed for the limit itself meets it up to rounding.
    let beyond = |disparity_px: f64| disparity_px.abs() > limit_px * (1.0 + ROUNDING);
    if beyond(range.max_px) || beyond(range.min_px) {
        warnings.push(OpticsWarning::DisparityBeyondLimit { range, limit_px });
    }
    // If the disparities of the range span less than one step, the depth interval of a step around their middle is
    // longer.
    if range.max_px - range.min_px < step_px * (1.0 - ROUNDING) {
        let middle_px = f64::midpoint(range.min_px, range.max_px);
        let middle_m = optics.rig().disparity_x().to_depth_m(middle_px);
        let resolution_m = optics.depth_resolution_m(middle_m, step_px)?;
        let depth_m = depths.far_m - depths.near_m;
        warnings.push(OpticsWarning::DepthResolutionTooCoarse { resolution_m, depth_m, step_px });
    }
    Ok(warnings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GridSize, LightFieldShape, Rig};

    /// k = 500 times the baseline.
    fn optics(baseline_m: f64) -> Optics {
        let rig = Rig::builder(LightFieldShape::new(GridSize::new(5, 5), GridSize::new(360, 360)).unwrap())
            .focal_length_m(0.05)
            .sensor_size_m(0.036)
            .baseline_m(baseline_m)
            .focus_distance_m(3.0)
            .build()
            .unwrap();
        Optics::new(rig).unwrap()
    }

    #[test]
    fn a_rig_for_the_limit_meets_it() {
        for (near_m, far_m) in [(2.0, 6.0), (0.4, 1.2), (1.0 / 3.0, 7.7), (0.11, 0.13), (1.7, 311.0)] {
            for limit_px in [0.3, 1.0, 2.0, 3.7] {
                let depths = DepthRange::new(near_m, far_m).unwrap();
                let wanted = DisparityRange { min_px: -limit_px, max_px: limit_px };
                let shape = LightFieldShape::new(GridSize::new(9, 9), GridSize::new(512, 512)).unwrap();
                let lens = crate::Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 };
                let found = super::super::rig_for_disparities(depths, wanted, lens, shape.lenses()).unwrap();
                let rig = Rig::builder(shape).intrinsics(lens).baseline_m(found.baseline_m);
                let optics = Optics::new(rig.focus_distance_m(found.focus_distance_m).build().unwrap()).unwrap();
                // The range is one step of twice the limit.
                assert_eq!(of(&optics, depths, limit_px, 2.0 * limit_px).unwrap(), [], "{near_m} {far_m} {limit_px}");
                assert_eq!(of(&optics, depths, limit_px * 0.999, 2.001 * limit_px).unwrap().len(), 2);
            }
        }
    }

    #[test]
    fn baselines_too_large_and_too_small_are_named() {
        let depths = DepthRange::new(2.0, 6.0).unwrap();
        // k = 12: 2 px at either end.
        assert_eq!(optics(0.024).warnings(depths, 2.1, 0.1), Ok(vec![]));
        let warnings = optics(0.024).warnings(depths, 1.9, 0.1).unwrap();
        assert!(matches!(warnings[..], [OpticsWarning::DisparityBeyondLimit { .. }]));
        assert!(warnings[0].to_string().contains("from -2.000 to 2.000 px leave -1.9 to 1.9 px"), "{}", warnings[0]);
        // k = 0.12: the range has 0.04 px in all, less than a step.
        let warnings = optics(0.00024).warnings(depths, 2.0, 0.1).unwrap();
        let [OpticsWarning::DepthResolutionTooCoarse { resolution_m, depth_m, .. }] = warnings[..] else {
            panic!("{warnings:?}")
        };
        // The slab of 0.1 px around 3 m, 1/Z = 1/3 -+ 0.417, reaches infinity.
        assert_eq!((resolution_m, depth_m), (f64::INFINITY, 4.0));
        // Just enough: 0.04 px and a step of as much.
        assert_eq!(optics(0.00024).warnings(depths, 2.0, 0.0399), Ok(vec![]));
        assert!(
            optics(0.024).warnings(depths, 0.0, 0.1).is_err() && optics(0.024).warnings(depths, 1.0, -0.1).is_err()
        );
    }

    #[test]
    fn the_resolution_is_coarser_than_a_range_within_one_step() {
        // 1/Z from 1/6 to 1/2: 0.04 px, in a step of 0.05 px around 1/3.
        let warnings = optics(0.00024).warnings(DepthRange::new(2.0, 6.0).unwrap(), 2.0, 0.05).unwrap();
        let [OpticsWarning::DepthResolutionTooCoarse { resolution_m, .. }] = warnings[..] else {
            panic!("{warnings:?}")
        };
        let half = 0.025 / 0.12;
        let expected = 1.0 / (1.0 / 3.0 - half) - 1.0 / (1.0 / 3.0 + half);
        assert!((resolution_m - expected).abs() < 1e-12 && resolution_m > 4.0, "{resolution_m}");
    }
}
