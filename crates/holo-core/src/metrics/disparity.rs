//! The general measures of the benchmark for disparity maps, BadPix, MSE and Q25, and also MAE and RMSE.

use ndarray::ArrayRef2;

use super::region::errors;
use super::{PixelCounts, Region};
use crate::base::error::not_negative;
use crate::{Error, Real};

/// The thresholds of the benchmark's BadPix measures, in pixels.
pub const BAD_PIXEL_THRESHOLDS_PX: [f64; 3] = [0.01, 0.03, 0.07];

/// The threshold of the benchmark's scores of fine structures, in pixels.
pub const FINE_THRESHOLD_PX: f64 = 0.15;

/// The general measures of one disparity map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisparityScores {
    /// The numbers of compared and of excluded pixels.
    pub counts: PixelCounts,
    /// BadPix for each of [`BAD_PIXEL_THRESHOLDS_PX`], in percent.
    pub bad_pixels_percent: [f64; 3],
    /// MSE: the mean squared error, times 100, in square pixels.
    pub mean_squared_error_x100: f64,
    /// Q25: the largest absolute error of the best quarter of the pixels, times 100, in pixels.
    pub q25_x100: f64,
    /// The mean absolute error, in pixels.
    pub mean_absolute_error_px: f64,
    /// The root of the mean squared error, in pixels.
    pub root_mean_squared_error_px: f64,
}

/// Returns BadPix for 0.01, 0.03 and 0.07 px, MSE and Q25 of a disparity map, with the mean absolute error and the root
/// of the MSE.
///
/// BadPix counts a pixel without a finite estimate as bad. The other measures exclude it and are NaN if no pixel
/// remains; compare them only if [`PixelCounts::estimate_not_finite`] agrees. Pixels without a finite ground truth are
/// excluded.
///
/// # Shape
///
/// Two maps of equal, arbitrary shape.
///
/// # Units
///
/// Pixels between adjacent views, in both maps.
///
/// # Accuracy
///
/// In `f64`, summed row by row. The toolkit subtracts and compares in `f32`, the type of the maps: a pixel whose error
/// is within 1e-7 px of a threshold may be classified differently.
///
/// # Errors
///
/// [`Error::Shape`] if the maps or the mask differ in shape; [`Error::NothingToMeasure`] if no pixel has a finite
/// truth.
///
/// # Source
///
/// Honauer et al. 2016, and `BadPix`, `MSE(factor=100)` and `Quantile(25)` of the toolkit. Q25 is, as there, the
/// element floor(n/4) of the n sorted errors, without interpolation. One difference: the toolkit counts NaN as good,
/// because a comparison with NaN is false.
///
/// # Examples
///
/// ```
/// use holo_core::metrics::{Region, disparity_scores};
/// use ndarray::array;
///
/// let truth = array![[1.0_f32, 1.0], [2.0, f32::INFINITY]];
/// let estimate = array![[1.0_f32, 1.5], [f32::NAN, 0.0]];
/// let scores = disparity_scores(&estimate, &truth, &Region::with_border(0))?;
/// // Of the three pixels with ground truth, one is off by half a pixel and one has no estimate.
/// assert_eq!(scores.bad_pixels_percent, [200.0 / 3.0; 3]);
/// assert_eq!(scores.mean_squared_error_x100, 12.5);
/// assert_eq!(scores.counts.estimate_not_finite, 1);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn disparity_scores<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    region: &Region<'_>,
) -> Result<DisparityScores, Error> {
    let (errors, counts) = errors(estimate, truth, region, "disparity error")?;
    let mut absolute: Vec<f64> = errors.into_iter().map(f64::abs).collect();
    let count = absolute.len() as f64;
    let mean_squared_error = absolute.iter().map(|error| error * error).sum::<f64>() / count;
    let mean_absolute_error_px = absolute.iter().sum::<f64>() / count;
    let bad_pixels_percent = BAD_PIXEL_THRESHOLDS_PX.map(|threshold_px| percent_above(&absolute, counts, threshold_px));
    let quarter = absolute.len() / 4;
    let q25 = if absolute.is_empty() { f64::NAN } else { *absolute.select_nth_unstable_by(quarter, f64::total_cmp).1 };
    Ok(DisparityScores {
        counts,
        bad_pixels_percent,
        mean_squared_error_x100: 100.0 * mean_squared_error,
        q25_x100: 100.0 * q25,
        mean_absolute_error_px,
        root_mean_squared_error_px: mean_squared_error.sqrt(),
    })
}

/// Returns BadPix: the percentage of pixels with an error *above* a threshold, among those with a finite ground truth.
///
/// A pixel without a finite estimate is bad.
///
/// # Units
///
/// The threshold in pixels, the result in percent.
///
/// # Errors
///
/// As [`disparity_scores`]; [`Error::BadNumber`] if the threshold is negative, infinite or NaN.
///
/// # Source
///
/// As [`disparity_scores`].
pub fn bad_pixels_percent<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    threshold_px: f64,
    region: &Region<'_>,
) -> Result<f64, Error> {
    let threshold_px = not_negative("bad pixel threshold in pixels", threshold_px)?;
    let (errors, counts) = errors(estimate, truth, region, "disparity error")?;
    Ok(percent_above(&errors, counts, threshold_px))
}

/// Returns the fattening: the percentage of pixels whose estimate is too near, by more than a threshold, among those with
/// a finite ground truth. The measure is for what surrounds fine structures: pass their mask with the [`Region`].
///
/// A pixel without a finite estimate is not too near.
///
/// # Units
///
/// The threshold in pixels, the result in percent.
///
/// # Errors
///
/// As [`bad_pixels_percent`].
///
/// # Source
///
/// `FineFattening` of the toolkit, whose threshold is [`FINE_THRESHOLD_PX`].
pub fn fattening_percent<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    threshold_px: f64,
    region: &Region<'_>,
) -> Result<f64, Error> {
    let threshold_px = not_negative("fattening threshold in pixels", threshold_px)?;
    percent_of(estimate, truth, region, |error_px| error_px > threshold_px)
}

/// Returns the thinning: the percentage of pixels whose estimate is too far, by more than a threshold, among those with a
/// finite ground truth. The measure is for fine structures: pass their mask with the [`Region`].
///
/// A pixel without a finite estimate is not too far.
///
/// # Units
///
/// The threshold in pixels, the result in percent.
///
/// # Errors
///
/// As [`bad_pixels_percent`].
///
/// # Source
///
/// `FineThinning` of the toolkit, whose threshold is [`FINE_THRESHOLD_PX`].
pub fn thinning_percent<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    threshold_px: f64,
    region: &Region<'_>,
) -> Result<f64, Error> {
    let threshold_px = not_negative("thinning threshold in pixels", threshold_px)?;
    percent_of(estimate, truth, region, |error_px| error_px < -threshold_px)
}

/// The percentage of pixels with a finite truth whose error is as wanted.
fn percent_of<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    region: &Region<'_>,
    is_counted: impl Fn(f64) -> bool,
) -> Result<f64, Error> {
    let (errors, counts) = errors(estimate, truth, region, "disparity error")?;
    let counted = errors.into_iter().filter(|&error| is_counted(error)).count();
    Ok(100.0 * counted as f64 / (counts.region - counts.truth_not_finite) as f64)
}

/// BadPix of a list of errors and its counts.
fn percent_above(errors: &[f64], counts: PixelCounts, threshold_px: f64) -> f64 {
    let bad = errors.iter().filter(|error| error.abs() > threshold_px).count() + counts.estimate_not_finite;
    100.0 * bad as f64 / (counts.region - counts.truth_not_finite) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array2, array};

    const ALL: Region<'_> = Region::with_border(0);

    #[test]
    fn every_general_measure_of_eight_pixels_by_hand() {
        // Binary fractions, so that every error is exact: absolute errors 0, 0, 1/128, 1/64, 1/16, 1/8, 1/4, 1/2.
        let truth = Array2::from_elem((2, 4), 1.0_f32);
        let estimate =
            array![[1.0_f32, 1.0 + 1.0 / 128.0, 1.0 - 1.0 / 16.0, 1.25], [1.0, 1.0 - 1.0 / 64.0, 1.125, 0.5]];
        let scores = disparity_scores(&estimate, &truth, &ALL).unwrap();
        // Above 0.01: 1/64 and larger, 5 of 8. Above 0.03: 1/16 = 0.0625 and larger, 4. Above 0.07: 1/8 and larger, 3.
        assert_eq!(scores.bad_pixels_percent, [62.5, 50.0, 37.5]);
        let squares = 1.0 / 16384.0 + 1.0 / 4096.0 + 1.0 / 256.0 + 1.0 / 64.0 + 1.0 / 16.0 + 1.0 / 4.0;
        assert_eq!(scores.mean_squared_error_x100, 100.0 * squares / 8.0);
        assert_eq!(scores.root_mean_squared_error_px, (squares / 8.0).sqrt());
        assert_eq!(scores.mean_absolute_error_px, (1.0 / 128.0 + 1.0 / 64.0 + 1.0 / 16.0 + 0.875) / 8.0);
        // Element 8/4 = 2 of the sorted errors.
        assert_eq!(scores.q25_x100, 100.0 / 128.0);
    }

    #[test]
    fn an_error_equal_to_the_threshold_is_good() {
        let truth = array![[0.0, 0.0, 0.0, 0.0]];
        let estimate = array![[0.07, -0.07, 0.07_f64.next_up(), -0.07_f64.next_up()]];
        assert_eq!(bad_pixels_percent(&estimate, &truth, 0.07, &ALL), Ok(50.0));
        assert_eq!(bad_pixels_percent(&truth, &truth, 0.0, &ALL), Ok(0.0));
        for threshold in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(bad_pixels_percent(&estimate, &truth, threshold, &ALL).is_err(), "{threshold}");
        }
    }

    /// The difference of two f32 of one sign is exact if neither is more than twice the other. In other pairs that differ
    /// by a threshold both are at most 0.14: rounding changes their difference and the threshold by 4e-9 each.
    #[test]
    fn errors_in_f32_are_classified_alike_beside_the_thresholds() {
        for threshold_px in BAD_PIXEL_THRESHOLDS_PX {
            for k in -500..=500 {
                let truth = (f64::from(k) * 7e-3) as f32;
                for beside_px in [-1.1e-6, -5e-7, -1.1e-7, 1.1e-7, 5e-7, 1.1e-6] {
                    for sign in [-1.0, 1.0] {
                        let estimate = (f64::from(truth) + sign * (threshold_px + beside_px)) as f32;
                        let error_px = (f64::from(estimate) - f64::from(truth)).abs();
                        if (error_px - threshold_px).abs() <= 1e-7 {
                            continue;
                        }
                        let is_bad = (estimate - truth).abs() > threshold_px as f32;
                        let found = bad_pixels_percent(&array![[estimate]], &array![[truth]], threshold_px, &ALL);
                        assert_eq!(found, Ok(if is_bad { 100.0 } else { 0.0 }), "{estimate} {truth} {threshold_px}");
                    }
                }
            }
        }
    }

    #[test]
    fn fattening_and_thinning_are_the_two_signs_of_large_errors() {
        let truth = array![[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f64::NAN]];
        let estimate = array![[0.15, 0.15_f64.next_up(), 1.0, -0.15, -9.0, f64::NAN, f64::INFINITY, 1.0]];
        assert_eq!(fattening_percent(&estimate, &truth, FINE_THRESHOLD_PX, &ALL), Ok(200.0 / 7.0));
        assert_eq!(thinning_percent(&estimate, &truth, FINE_THRESHOLD_PX, &ALL), Ok(100.0 / 7.0));
        for threshold in [-1.0, f64::NAN] {
            assert!(fattening_percent(&estimate, &truth, threshold, &ALL).is_err());
            assert!(thinning_percent(&estimate, &truth, threshold, &ALL).is_err());
        }
    }

    #[test]
    fn a_quarter_of_few_pixels_is_the_best_one() {
        for (count, expected) in [(1, 0.0), (3, 0.0), (4, 100.0), (7, 100.0), (8, 200.0), (100, 2500.0)] {
            let truth = Array2::<f64>::zeros((1, count));
            // In descending order: the measure must sort.
            let estimate = Array2::from_shape_fn((1, count), |(_, column)| (count - 1 - column) as f64);
            let scores = disparity_scores(&estimate, &truth, &ALL).unwrap();
            assert_eq!(scores.q25_x100, expected, "{count} pixels");
        }
    }

    #[test]
    fn missing_estimates_are_bad_and_missing_truth_is_excluded() {
        let truth = array![[0.0, 0.0, 0.0, f64::NAN, f64::NEG_INFINITY]];
        let estimate = array![[0.5, f64::NAN, f64::INFINITY, 0.0, 0.0]];
        let scores = disparity_scores(&estimate, &truth, &ALL).unwrap();
        assert_eq!(scores.bad_pixels_percent, [100.0; 3]);
        assert_eq!(scores.mean_squared_error_x100, 25.0);
        assert_eq!(scores.q25_x100, 50.0);
        assert_eq!(scores.counts, PixelCounts { region: 5, truth_not_finite: 2, estimate_not_finite: 2, compared: 1 });
        // No estimate: all pixels are bad, and the means are NaN.
        let scores = disparity_scores(&Array2::from_elem((1, 5), f32::NAN), &truth, &ALL).unwrap();
        assert_eq!(scores.bad_pixels_percent, [100.0; 3]);
        assert!(scores.mean_squared_error_x100.is_nan() && scores.q25_x100.is_nan());
        assert!(scores.mean_absolute_error_px.is_nan() && scores.root_mean_squared_error_px.is_nan());
        assert_eq!(scores.counts.compared, 0);
    }

    #[test]
    fn the_default_border_is_fifteen_pixels() {
        let truth = Array2::<f32>::zeros((32, 33));
        let inside = |row: usize, column: usize| (15..17).contains(&row) && (15..18).contains(&column);
        let estimate = Array2::from_shape_fn((32, 33), |(row, column)| if inside(row, column) { 0.0_f32 } else { 9.0 });
        let scores = disparity_scores(&estimate, &truth, &Region::default()).unwrap();
        assert_eq!((scores.counts.compared, scores.bad_pixels_percent), (6, [0.0; 3]));
    }
}
