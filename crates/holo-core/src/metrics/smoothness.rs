//! Bumpiness, the measure of the benchmark for the roughness of the error of a disparity map in smooth regions.

use ndarray::ArrayRef2;

use super::region::same_shape;
use super::{Region, Score};
use crate::{Error, Real};

/// The upper limit of the norm of the Hessian of a pixel, applied before the mean.
pub const BUMPINESS_LIMIT: f64 = 0.05;

/// The radius of the two consecutive filters, in pixels.
const REACH_PX: usize = 2;

/// Returns the bumpiness of a disparity map: the mean norm of the Hessian of its error, clamped to 0.05 per pixel,
/// times 100.
///
/// A constant or linear error has bumpiness 0; the maximum, reached by noise, is 5. The measure is for smooth or planar
/// regions: pass their mask with the [`Region`].
///
/// A pixel is excluded if one of the 5 x 5 pixels around it is not finite in one of the maps or is outside the map.
/// With a border of at least 2 px the edge of the map excludes no pixel.
///
/// # Shape
///
/// Two maps of equal, arbitrary shape.
///
/// # Errors
///
/// [`Error::Shape`] if the maps or the mask differ in shape; [`Error::NothingToMeasure`] if border and mask
/// exclude all pixels.
///
/// # Source
///
/// Honauer et al. 2016, and `BumpinessPlanes` and `BumpinessContinSurf` of the toolkit, which differ only in their
/// masks: the Frobenius norm of (xx, xy, yx, yy), each of them two consecutive Scharr filters of scikit-image. Those
/// filters weight the two neighbors by +1 and -1 and do not halve the difference. As in the toolkit, and therefore in
/// published scores, the value is **four times** the norm of the Hessian before the clamp. At the edge of the map the
/// toolkit extends the error; its border of 15 px excludes these pixels.
pub fn bumpiness<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    region: &Region<'_>,
) -> Result<Score, Error> {
    let shape = same_shape(estimate, truth)?;
    let (mut sum, mut score) = (0.0, Score { value: f64::NAN, pixels: 0, excluded: 0 });
    for pixel in region.pixels(shape)? {
        let Some(patch) = error_patch(estimate, truth, shape, pixel) else {
            score.excluded += 1;
            continue;
        };
        score.pixels += 1;
        sum += hessian_norm(&patch).min(BUMPINESS_LIMIT);
    }
    if score.pixels + score.excluded == 0 {
        return Err(Error::NothingToMeasure { what: "bumpiness", shape, border_px: region.border_px });
    }
    if score.pixels > 0 {
        score.value = 100.0 * sum / score.pixels as f64;
    }
    Ok(score)
}

/// The errors of the 5 x 5 pixels around a pixel, or `None` if one does not exist.
fn error_patch<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    [rows, columns]: [usize; 2],
    [row, column]: [usize; 2],
) -> Option<[[f64; 5]; 5]> {
    let inside = |index: usize, count: usize| index >= REACH_PX && index < count.saturating_sub(REACH_PX);
    if !inside(row, rows) || !inside(column, columns) {
        return None;
    }
    let mut patch = [[0.0; 5]; 5];
    for (i, line) in patch.iter_mut().enumerate() {
        for (j, error) in line.iter_mut().enumerate() {
            let pixel = [row + i - REACH_PX, column + j - REACH_PX];
            // The difference is not finite unless both values are.
            *error = estimate[pixel].to_f64() - truth[pixel].to_f64();
            if !error.is_finite() {
                return None;
            }
        }
    }
    Some(patch)
}

/// The norm of (xx, xy, yx, yy) at the center of a patch, in the toolkit's scale.
///
/// Two consecutive Scharr filters are one separable filter of 5 x 5. Its factor along an axis has D = (1, 0, -1) for
/// each derivative along that axis and S = (3, 10, 3)/16 for each derivative across it.
fn hessian_norm(patch: &[[f64; 5]; 5]) -> f64 {
    /// D after D.
    const TWICE: [f64; 5] = [1.0, 0.0, -2.0, 0.0, 1.0];
    /// D after S, times 16.
    const ONCE: [f64; 5] = [3.0, 10.0, 0.0, -10.0, -3.0];
    /// S after S, times 256.
    const NEVER: [f64; 5] = [9.0, 60.0, 118.0, 60.0, 9.0];
    let filtered = |down: &[f64; 5], along: &[f64; 5]| -> f64 {
        let line = |line: &[f64; 5]| line.iter().zip(along).map(|(error, weight)| error * weight).sum::<f64>();
        patch.iter().zip(down).map(|(errors, weight)| line(errors) * weight).sum::<f64>() / 256.0
    };
    let (xx, yy, xy) = (filtered(&NEVER, &TWICE), filtered(&TWICE, &NEVER), filtered(&ONCE, &ONCE));
    (xx * xx + 2.0 * xy * xy + yy * yy).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    const INNER: Region<'_> = Region::with_border(2);

    fn of_error(shape: (usize, usize), error: impl Fn(f64, f64) -> f64) -> f64 {
        // An arbitrary ground truth of multiples of 1/64, so that the subtraction is exact.
        let truth = Array2::from_shape_fn(shape, |(row, column)| ((row * 7 + column * 3) % 11) as f64 / 64.0);
        let estimate =
            Array2::from_shape_fn(shape, |(row, column)| truth[[row, column]] + error(row as f64, column as f64));
        let score = bumpiness(&estimate, &truth, &INNER).unwrap();
        assert_eq!((score.pixels, score.excluded), ((shape.0 - 4) * (shape.1 - 4), 0));
        score.value
    }

    #[test]
    fn planes_have_bumpiness_zero() {
        assert_eq!(of_error((8, 9), |row, column| 3.0 + row / 8.0 - column / 4.0), 0.0);
    }

    #[test]
    fn parabolas_have_four_times_the_norm_of_their_hessian() {
        // Errors are multiples of 2^-20 below 1, their differences exact; the last bits come from the truth that was
        // added: 1e-9.
        let a = 1.0 / 1024.0;
        let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9, "{value} for {expected}");
        // a x^2: xx = 2a, and four times that.
        close(of_error((9, 9), |_, x| a * x * x), 100.0 * 4.0 * 2.0 * a);
        close(of_error((9, 9), |y, _| a * y * y), 100.0 * 4.0 * 2.0 * a);
        // a x y: xy = yx = a, and both count.
        close(of_error((9, 9), |y, x| a * x * y), 100.0 * 4.0 * 2.0_f64.sqrt() * a);
        // All together: xx = 2a, yy = -2a, xy = a: norm a sqrt(4 + 4 + 2).
        close(of_error((9, 9), |y, x| a * (x * x - y * y + x * y)), 100.0 * 4.0 * 10.0_f64.sqrt() * a);
    }

    #[test]
    fn pixels_are_clamped_to_the_limit() {
        // A mean of clamped values, each 0.05, rounds a few times.
        assert!((of_error((7, 7), |_, x| x * x) - 5.0).abs() < 1e-13);
        // One bump of 1 px in the middle of 9 x 9: the 5 x 5 pixels that see it are at the limit where any filter has a
        // weight, which is everywhere: (0, 0), (0, 2), (2, 2) by NEVER x TWICE, the odd ones by ONCE x ONCE. The others
        // are 0.
        let mut bump = Array2::<f32>::zeros((9, 9));
        bump[[4, 4]] = 1.0;
        let score = bumpiness(&bump, &Array2::<f32>::zeros((9, 9)), &INNER).unwrap();
        assert_eq!(score.pixels, 25);
        // The weakest of the 25 is (1, 0): xx: 60 * 2/256; the corner (2, 2): sqrt(9^2 + 9^2 + 2 * 9^2)/256 = 0.07. All
        // above 0.05.
        assert!((score.value - 5.0).abs() < 1e-13);
    }

    #[test]
    fn holes_and_edges_are_excluded_and_counted() {
        let flat = Array2::<f64>::zeros((9, 10));
        let mut hole = flat.clone();
        hole[[4, 2]] = f64::NAN;
        let score = bumpiness(&hole, &flat, &Region::with_border(0)).unwrap();
        // 5 rows x 6 columns are far enough from the edge; those in columns 2..=4 of all five rows see the hole.
        assert_eq!(score, Score { value: 0.0, pixels: 15, excluded: 75 });
        assert_eq!(bumpiness(&flat, &hole, &Region::with_border(0)), Ok(score));
        let small = Array2::<f64>::zeros((3, 4));
        let score = bumpiness(&small, &small, &Region::with_border(1)).unwrap();
        assert!(score.value.is_nan() && score.excluded == 2);
        assert!(bumpiness(&small, &small, &Region::with_border(2)).is_err());
    }
}
