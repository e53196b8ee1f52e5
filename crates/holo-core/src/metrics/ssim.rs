//! Structural similarity of two images.

use std::ops::Range;

use crate::base::parallel::*;
use ndarray::{ArrayRef3, ArrayView3};

use super::psnr::check_images;
use crate::{Error, Sample};

/// The rows and columns of the window, in pixels, and the smallest size of an image.
pub const SSIM_WINDOW_PX: usize = 2 * RADIUS + 1;

/// The radius of scikit-image, which truncates the Gaussian at 3.5 deviations: floor(3.5 * 1.5 + 0.5).
const RADIUS: usize = 5;

/// The deviation of the Gaussian window, in pixels.
const SIGMA_PX: f64 = 1.5;

/// Rows of windows per task. Each task filters 10 extra rows.
const BAND: usize = 64;

/// The five means of a window: x, y, x^2, y^2, x*y.
type Moments = [f64; 5];

/// Returns the mean structural similarity (SSIM) of two images: 1 for equal images, about 0 for unrelated ones.
///
/// The mean is over all windows within the image, then over the channels.
///
/// # Shape
///
/// Two images `(row, column, channel)` of equal shape, at least 11 x 11 pixels.
///
/// # Units
///
/// `data_range` is the difference between the largest and the smallest value that a sample can have: 255 for `u8`,
/// 65535 for `u16`; for `f32` the caller specifies it, often 1.
///
/// # Accuracy
///
/// In `f64`; the result does not depend on the number of threads. A NaN in an image makes the result NaN.
///
/// # Errors
///
/// [`Error::Shape`] if the images differ in shape; [`Error::ZeroCount`] if they are empty; [`Error::NothingToMeasure`]
/// if they are smaller than a window; [`Error::BadNumber`] if the range is not finite and above 0.
///
/// # Source
///
/// Z. Wang, A. C. Bovik, H. R. Sheikh and E. P. Simoncelli, *Image quality assessment: from error visibility to
/// structural similarity*, 2004: a Gaussian window of 11 x 11 pixels and deviation 1.5, K1 = 0.01, K2 = 0.03, moments
/// of the population. These are the settings `gaussian_weights=True, sigma=1.5, use_sample_covariance=False` of
/// scikit-image's `structural_similarity`.
///
/// # Examples
///
/// ```
/// use holo_core::metrics::ssim;
/// use ndarray::Array3;
///
/// let image = Array3::from_shape_fn((16, 16, 3), |(row, column, _)| (row * column) as u8);
/// assert!((ssim(&image, &image, 255.0)? - 1.0).abs() < 1e-12);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn ssim<T: Sample>(image: &ArrayRef3<T>, reference: &ArrayRef3<T>, data_range: f64) -> Result<f64, Error> {
    let data_range = check_images(image, reference, data_range)?;
    let (rows, columns, channels) = image.dim();
    if rows < SSIM_WINDOW_PX || columns < SSIM_WINDOW_PX {
        let shape = [rows, columns];
        return Err(Error::NothingToMeasure { what: "structural similarity", shape, border_px: RADIUS });
    }
    let (image, reference) = (image.view(), reference.view());
    let (windows_down, windows_along) = (rows - 2 * RADIUS, columns - 2 * RADIUS);
    let weights = window();
    let mut sum = 0.0;
    for channel in 0..channels {
        let bands: Vec<f64> = (0..windows_down.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                let first = band * BAND;
                let windows = first..(first + BAND).min(windows_down);
                band_sum(image, reference, channel, windows, &weights, data_range)
            })
            .collect();
        // In a fixed order, for any number of threads.
        sum += bands.iter().sum::<f64>() / (windows_down * windows_along) as f64;
    }
    Ok(sum / channels as f64)
}

/// The weights of the window along one axis; their sum is 1.
fn window() -> [f64; SSIM_WINDOW_PX] {
    let weights: [f64; SSIM_WINDOW_PX] =
        std::array::from_fn(|tap| (-0.5 * ((tap as f64 - RADIUS as f64) / SIGMA_PX).powi(2)).exp());
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

/// The sum of the similarity over some rows of windows of one channel.
fn band_sum<T: Sample>(
    image: ArrayView3<'_, T>,
    reference: ArrayView3<'_, T>,
    channel: usize,
    windows: Range<usize>,
    weights: &[f64; SSIM_WINDOW_PX],
    data_range: f64,
) -> f64 {
    // Along the rows first: every row of the band once.
    let columns = image.dim().1;
    let mut products: Vec<Moments> = vec![[0.0; 5]; columns];
    let rows: Vec<Vec<Moments>> = (windows.start..windows.end + 2 * RADIUS)
        .map(|row| {
            for (column, product) in products.iter_mut().enumerate() {
                let x = image[[row, column, channel]].to_f64();
                let y = reference[[row, column, channel]].to_f64();
                *product = [x, y, x * x, y * y, x * y];
            }
            products.windows(SSIM_WINDOW_PX).map(|products| weighted(weights, products.iter())).collect()
        })
        .collect();
    // Then down the columns.
    let mut sum = 0.0;
    for rows in rows.windows(SSIM_WINDOW_PX) {
        let row: f64 = (0..columns - 2 * RADIUS)
            .map(|column| similarity(weighted(weights, rows.iter().map(|row| &row[column])), data_range))
            .sum();
        sum += row;
    }
    sum
}

fn weighted<'a>(weights: &[f64; SSIM_WINDOW_PX], moments: impl Iterator<Item = &'a Moments>) -> Moments {
    let mut sum = [0.0; 5];
    for (weight, moments) in weights.iter().zip(moments) {
        for (sum, moment) in sum.iter_mut().zip(moments) {
            *sum += weight * moment;
        }
    }
    sum
}

/// The similarity of one window from the means of x, y, x^2, y^2 and x*y.
fn similarity([x, y, xx, yy, xy]: Moments, data_range: f64) -> f64 {
    let (c1, c2) = ((0.01 * data_range).powi(2), (0.03 * data_range).powi(2));
    let (variances, covariance) = ((xx - x * x) + (yy - y * y), xy - x * y);
    (2.0 * x * y + c1) * (2.0 * covariance + c2) / ((x * x + y * y + c1) * (variances + c2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::psnr_db;
    use ndarray::Array3;

    // The output of `ssim_reference.py` with scikit-image 0.26.0.
    const SSIM_U8: f64 = 0.9711817414895046;
    const PSNR_U8: f64 = 25.17464397889864;
    const SSIM_U16: f64 = 0.8928973611495303;
    const PSNR_U16: f64 = 17.008175848151488;
    const SSIM_F32: f64 = 0.9721351741364946;
    const PSNR_F32: f64 = 31.229239589736153;

    /// The reference implementation: for every window, the weighted means, variances and covariance about the means.
    fn naive(image: &Array3<f64>, reference: &Array3<f64>, range: f64) -> f64 {
        let (rows, columns, channels) = image.dim();
        let weights = window();
        let (mut sum, mut count) = (0.0, 0.0);
        for channel in 0..channels {
            for row in 0..rows - 10 {
                for column in 0..columns - 10 {
                    let mean = |value: &dyn Fn(f64, f64) -> f64| {
                        let mut mean = 0.0;
                        for i in 0..11 {
                            for j in 0..11 {
                                let at = [row + i, column + j, channel];
                                mean += weights[i] * weights[j] * value(image[at], reference[at]);
                            }
                        }
                        mean
                    };
                    let (x, y) = (mean(&|x, _| x), mean(&|_, y| y));
                    let (xx, yy) = (mean(&|a, _| (a - x) * (a - x)), mean(&|_, b| (b - y) * (b - y)));
                    let xy = mean(&|a, b| (a - x) * (b - y));
                    let (c1, c2) = ((0.01 * range).powi(2), (0.03 * range).powi(2));
                    sum += (2.0 * x * y + c1) * (2.0 * xy + c2) / ((x * x + y * y + c1) * (xx + yy + c2));
                    count += 1.0;
                }
            }
        }
        sum / count
    }

    /// The images of `ssim_reference.py`.
    fn images() -> (Array3<u16>, Array3<u16>) {
        let first = Array3::from_shape_fn((20, 24, 3), |(r, c, k)| ((r * 7 + c * 13 + k * 29 + r * c) % 251) as u16);
        let second = Array3::from_shape_fn((20, 24, 3), |(r, c, k)| {
            let noise = (r * 31 + c * 17 + k * 5 + r * r * c) % 37;
            (usize::from(first[[r, c, k]]) * 7 / 8 + noise) as u16
        });
        (first, second)
    }

    #[test]
    fn numbers_are_those_of_scikit_image() {
        let (first, second) = images();
        // Both compute in f64: 1e-9 is about 1e6 roundings of values of about 1.
        let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9, "{value} for {expected}");
        let (a, b) = (first.mapv(|value| value as u8), second.mapv(|value| value as u8));
        close(ssim(&a, &b, 255.0).unwrap(), SSIM_U8);
        close(psnr_db(&a, &b, 255.0).unwrap(), PSNR_U8);
        let (a, b) = (first.mapv(|value| value * 257), second.mapv(|value| value * 200));
        close(ssim(&a, &b, 65535.0).unwrap(), SSIM_U16);
        close(psnr_db(&a, &b, 65535.0).unwrap(), PSNR_U16);
        // Multiples of 1/256 are exact in f32.
        let (a, b) = (first.mapv(|value| f32::from(value) / 256.0), second.mapv(|value| f32::from(value) / 256.0));
        close(ssim(&a, &b, 2.0).unwrap(), SSIM_F32);
        close(psnr_db(&a, &b, 2.0).unwrap(), PSNR_F32);
    }

    #[test]
    fn bands_and_separable_filters_agree_with_the_reference_implementation() {
        // Taller than one band.
        let image = Array3::from_shape_fn((150, 17, 2), |(r, c, k)| ((r * r + 3 * c * r + k * 11) % 97) as f32);
        let reference = Array3::from_shape_fn((150, 17, 2), |(r, c, k)| ((r * r + 2 * c * r + k * 7) % 89) as f32);
        let found = ssim(&image, &reference, 96.0).unwrap();
        let expected = naive(&image.mapv(f64::from), &reference.mapv(f64::from), 96.0);
        // E[x^2] - E[x]^2 against E[(x - E[x])^2]: 96^2 * 2^-52 * some ten roundings against c2 = 8.
        assert!((found - expected).abs() < 1e-11, "{found} for {expected}");
    }

    #[cfg(feature = "rayon")]
    #[test]
    fn threads_change_no_bit() {
        let image = Array3::from_shape_fn((300, 40, 1), |(r, c, _)| ((r * c) % 255) as u8);
        let reference = image.mapv(|value| value / 2 + 9);
        let in_pool = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| ssim(&image, &reference, 255.0).unwrap()).to_bits()
        };
        assert_eq!(in_pool(1), in_pool(3));
    }

    #[test]
    fn constant_images_by_hand_and_small_images_are_errors() {
        // Without structure only the means are left: (2ab + c1)/(a^2 + b^2 + c1).
        let (a, b) = (Array3::from_elem((11, 11, 1), 100_u8), Array3::from_elem((11, 11, 1), 50_u8));
        let c1 = 2.55_f64.powi(2);
        let expected = (2.0 * 5000.0 + c1) / (12500.0 + c1);
        // The variances are 0 up to 1e4 * 2^-52 * 20 against c2 = 58.
        assert!((ssim(&a, &b, 255.0).unwrap() - expected).abs() < 1e-11);
        let small = Array3::from_elem((11, 10, 1), 1_u8);
        assert!(matches!(ssim(&small, &small, 255.0), Err(Error::NothingToMeasure { .. })));
    }
}
