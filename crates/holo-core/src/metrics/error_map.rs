//! The error of a disparity map as an image.

use ndarray::{Array3, ArrayRef2};

use super::region::same_shape;
use crate::base::error::positive;
use crate::{Error, Real};

/// The colors of [`error_map`]: sRGB codes, mixed linearly as codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ErrorColors {
    /// Too far away: the disparity is smaller than the ground truth by the range or more.
    pub too_far: [u8; 3],
    /// Correct.
    pub correct: [u8; 3],
    /// Too near: the disparity is larger than the ground truth by the range or more.
    pub too_near: [u8; 3],
    /// The estimate is NaN or infinite.
    pub no_estimate: [u8; 3],
    /// The ground truth is NaN or infinite.
    pub no_truth: [u8; 3],
}

impl Default for ErrorColors {
    /// Red too far, white correct, blue too near, as in the benchmark; black without an estimate, gray without ground
    /// truth.
    fn default() -> Self {
        Self {
            too_far: [190, 20, 30],
            correct: [255, 255, 255],
            too_near: [25, 80, 190],
            no_estimate: [0, 0, 0],
            no_truth: [128, 128, 128],
        }
    }
}

/// Returns the signed error of a disparity map as an image: white is correct, red too far, blue too near.
///
/// # Shape
///
/// Two maps (V, U) of equal, arbitrary shape; the result is (V, U, 3), sRGB.
///
/// # Units
///
/// `range_px` is the error in pixels at which colors saturate; 0.2 in the benchmark.
///
/// # Errors
///
/// [`Error::Shape`] if the maps differ in shape; [`Error::BadNumber`] if the range is not finite and above 0.
///
/// # Examples
///
/// ```
/// use holo_core::metrics::{ErrorColors, error_map};
/// use ndarray::array;
///
/// let colors = ErrorColors::default();
/// let image = error_map(&array![[1.0_f32, 1.5]], &array![[1.0_f32, 1.0]], 0.2, &colors)?;
/// assert_eq!(image, array![[[255_u8, 255, 255], [25, 80, 190]]]);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn error_map<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    range_px: f64,
    colors: &ErrorColors,
) -> Result<Array3<u8>, Error> {
    let [rows, columns] = same_shape(estimate, truth)?;
    let range_px = positive("range of the error map in pixels", range_px)?;
    let mut image = Array3::zeros((rows, columns, 3));
    for ((row, column), truth) in truth.indexed_iter() {
        let (truth, estimate) = (truth.to_f64(), estimate[[row, column]].to_f64());
        let color = if !truth.is_finite() {
            colors.no_truth
        } else if !estimate.is_finite() {
            colors.no_estimate
        } else {
            let share = (estimate - truth) / range_px;
            mix(colors.correct, if share < 0.0 { colors.too_far } else { colors.too_near }, share.abs().min(1.0))
        };
        for channel in 0..3 {
            image[[row, column, channel]] = color[channel];
        }
    }
    Ok(image)
}

fn mix(from: [u8; 3], to: [u8; 3], share: f64) -> [u8; 3] {
    // The value is between two codes, so the conversion only rounds.
    std::array::from_fn(|channel| {
        let (from, to) = (f64::from(from[channel]), f64::from(to[channel]));
        (from + share * (to - from)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array2, array};

    #[test]
    fn colors_follow_the_sign_and_saturate_at_the_range() {
        let colors = ErrorColors::default();
        let truth = array![[0.0, 0.0, 0.0, 0.0, 0.0, f64::NAN]];
        let estimate = array![[-0.2_f32, -9.0, 0.1, 9.0, f32::INFINITY, f32::NAN]];
        let image = error_map(&estimate, &truth, 0.2, &colors).unwrap();
        let at = |column: usize| std::array::from_fn::<u8, 3, _>(|channel| image[[0, column, channel]]);
        // -0.2 in f32 is slightly more than 0.2 away: saturated.
        assert_eq!((at(0), at(1), at(3)), (colors.too_far, colors.too_far, colors.too_near));
        assert_eq!((at(4), at(5)), (colors.no_estimate, colors.no_truth));
        // Half of the range: (255 + 25)/2, (255 + 80)/2 = 167.5 and (255 + 190)/2 = 222.5; 0.1 in f32 is a little above
        // 0.1.
        assert_eq!(at(2), [140, 167, 222]);
    }

    #[test]
    fn bad_ranges_and_shapes_are_errors() {
        let map = Array2::<f32>::zeros((2, 3));
        for range in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(error_map(&map, &map, range, &ErrorColors::default()).is_err(), "{range}");
        }
        assert!(error_map(&map, &Array2::<f32>::zeros((3, 2)), 1.0, &ErrorColors::default()).is_err());
    }
}
