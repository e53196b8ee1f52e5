//! Peak signal-to-noise ratio of two images.

use ndarray::ArrayRef3;

use crate::base::error::positive;
use crate::{Error, Sample};

/// Returns the peak signal-to-noise ratio of two images over all pixels and channels, in decibels; infinity if they are
/// equal.
///
/// # Shape
///
/// Two images `(row, column, channel)` of equal, arbitrary shape.
///
/// # Units
///
/// `data_range` is the difference between the largest and the smallest value that a sample can have: 255 for `u8`,
/// 65535 for `u16`; for `f32` the caller specifies it, often 1.
///
/// # Accuracy
///
/// Differences and their squares in `f64`, summed row by row. A NaN in an image makes the result NaN.
///
/// # Errors
///
/// [`Error::Shape`] if the images differ in shape; [`Error::ZeroCount`] if they are empty; [`Error::BadNumber`] if the
/// range is not finite and above 0.
///
/// # Source
///
/// 10 log10(range^2 / mean squared difference), as scikit-image's `peak_signal_noise_ratio`.
///
/// # Examples
///
/// ```
/// use holo_core::metrics::psnr_db;
/// use ndarray::array;
///
/// // Off by a tenth of the range everywhere: 20 dB.
/// let decibels = psnr_db(&array![[[10.0_f32], [20.0]]], &array![[[20.0_f32], [10.0]]], 100.0)?;
/// assert!((decibels - 20.0).abs() < 1e-12);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn psnr_db<T: Sample>(image: &ArrayRef3<T>, reference: &ArrayRef3<T>, data_range: f64) -> Result<f64, Error> {
    let data_range = check_images(image, reference, data_range)?;
    let mut sum = 0.0;
    for (row, reference_row) in image.outer_iter().zip(reference.outer_iter()) {
        // A sum a row: the partial sums stay short, and the order is fixed.
        let squares = row.iter().zip(reference_row.iter()).map(|(a, b)| (a.to_f64() - b.to_f64()).powi(2));
        sum += squares.sum::<f64>();
    }
    Ok(10.0 * (data_range * data_range / (sum / image.len() as f64)).log10())
}

/// Checks that two images have equal shapes and that the range is valid, and returns the range.
pub(super) fn check_images<T>(image: &ArrayRef3<T>, reference: &ArrayRef3<T>, data_range: f64) -> Result<f64, Error> {
    if image.dim() != reference.dim() {
        let (expected, found) = (reference.shape().to_vec(), image.shape().to_vec());
        return Err(Error::Shape { what: "image", expected, found });
    }
    for (what, count) in ["image rows", "image columns", "channels"].into_iter().zip(image.shape()) {
        if *count == 0 {
            return Err(Error::ZeroCount { what });
        }
    }
    positive("data range", data_range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array3, array};

    #[test]
    fn decibels_by_hand() {
        // One of four samples off by 51 = 255/5: mean square 51^2/4, ratio 25 * 4 = 100, 20 dB.
        let reference = array![[[0_u8, 10]], [[200, 255]]];
        let mut image = reference.clone();
        image[[0, 0, 1]] = 61;
        assert!((psnr_db(&image, &reference, 255.0).unwrap() - 20.0).abs() < 1e-12);
        // The same in u16, where a difference of u8 would have wrapped, and with the sign turned.
        let (reference, image) = (reference.mapv(u16::from), image.mapv(u16::from));
        assert!((psnr_db(&reference, &image, 255.0).unwrap() - 20.0).abs() < 1e-12);
    }

    #[test]
    fn equal_images_give_infinity_and_invalid_ones_are_errors() {
        let image = Array3::from_elem((2, 3, 1), 7_u8);
        assert_eq!(psnr_db(&image, &image, 255.0), Ok(f64::INFINITY));
        for range in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(psnr_db(&image, &image, range).is_err(), "{range}");
        }
        let other = Array3::from_elem((3, 2, 1), 7_u8);
        assert!(matches!(psnr_db(&image, &other, 255.0), Err(Error::Shape { .. })));
        let empty = Array3::<f32>::zeros((2, 0, 1));
        assert_eq!(psnr_db(&empty, &empty, 1.0), Err(Error::ZeroCount { what: "image columns" }));
        let lost = Array3::from_elem((1, 1, 1), f32::NAN);
        assert!(psnr_db(&lost, &lost, 1.0).unwrap().is_nan());
    }
}
