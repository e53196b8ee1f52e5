//! Errors of rendered views.

use holo_core::ViewIndex;
use holo_core::color::{linear_to_srgb8, srgb8_to_linear_table};

/// Views as images, pixel by pixel.
pub type Images = Vec<Vec<[f32; 3]>>;

/// Corners, middles of the edges and center of an odd or even number of views an axis.
#[must_use]
pub fn nine(views: usize) -> Vec<ViewIndex> {
    let places = [0, views / 2, views - 1];
    places.iter().flat_map(|&row| places.map(|column| ViewIndex { row, column })).collect()
}

/// The next three values.
pub fn rgb<'a>(mut values: impl Iterator<Item = &'a f32>) -> Option<[f32; 3]> {
    Some([*values.next()?, *values.next()?, *values.next()?])
}

/// Luminance of Rec. 709.
#[must_use]
pub fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// The relative error |x - g| / g of the luminance of a pixel in sRGB codes; g is that of `reference`, linear and cut at 1,
/// where codes are. `None` where it is black.
#[must_use]
pub fn error_of_codes(codes: [u8; 3], reference: [f32; 3]) -> Option<f64> {
    let table = srgb8_to_linear_table();
    let reference = luminance(reference.map(|x| x.min(1.0)));
    (reference > 0.0).then(|| (luminance(codes.map(|code| table[usize::from(code)])) / reference - 1.0).abs())
}

/// As [`error_of_codes`], of linear values that are rounded to codes.
#[must_use]
pub fn error_in_8bit(linear: [f32; 3], reference: [f32; 3]) -> Option<f64> {
    error_of_codes(linear.map(linear_to_srgb8), reference)
}

/// The relative squared error of a view: the mean of (x - a)(x - b) / (m^2 + 0.01 mean(m^2)) over pixels and channels,
/// with two independent references a and b and their mean m, so that the noise of the references has the expectation 0 in
/// it. The worst pixel of a hundred is left out.
#[must_use]
pub fn squared_error(image: &[[f32; 3]], references: &[Images; 2], view: usize) -> f64 {
    squared_bias([image; 2], references, view)
}

/// The squared error that two images with independent noise have in common, as [`squared_error`]: the noise of the images
/// has the expectation 0 in it too.
#[must_use]
pub fn squared_bias(images: [&[[f32; 3]]; 2], references: &[Images; 2], view: usize) -> f64 {
    let [errors, noise] = errors_and_noise(images, [&references[0][view], &references[1][view]]);
    mean_without_worst(errors) - mean_without_worst(noise)
}

/// The relative squared error against one reference r, the mean of (x - r)^2 / (r^2 + 0.01 mean(r^2)) over pixels and
/// channels: without the worst pixel of a hundred, and over all.
#[must_use]
pub fn relative_squared_error(image: &[[f32; 3]], reference: &[[f32; 3]]) -> [f64; 2] {
    let [errors, _] = errors_and_noise([image; 2], [reference; 2]);
    let all = errors.iter().sum::<f64>() / errors.len() as f64;
    [mean_without_worst(errors), all]
}

/// The mean squared difference of two images.
#[must_use]
pub fn squared_difference(image: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let squares = image.as_flattened().iter().zip(reference.as_flattened()).map(|(x, r)| f64::from(x - r).powi(2));
    squares.sum::<f64>() / (3 * image.len()) as f64
}

/// For every pixel the error of the mean of the images against that of the references, and the part of it that is their
/// noise: (x - a)(y - b) is the difference of ((x + y) - (a + b))^2 / 4 and ((x - y) - (a - b))^2 / 4.
///
/// The worst pixels are left out of either for itself. Leaving out those where the first is largest would leave out noise
/// of the references that agrees by chance, and keep that which disagrees: errors well below it would become negative.
fn errors_and_noise(images: [&[[f32; 3]]; 2], references: [&[[f32; 3]]; 2]) -> [Vec<f64>; 2] {
    let [a, b] = references;
    let floor = 0.01
        * a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from((a + b) / 2.0).powi(2)).sum::<f64>()
        / (3 * a.len()) as f64;
    let mut found = [Vec::with_capacity(a.len()), Vec::with_capacity(a.len())];
    for k in 0..a.len() {
        let mut sums = [0.0; 2];
        for c in 0..3 {
            let ([x, y], [a, b]) = (images.map(|image| f64::from(image[k][c])), references.map(|r| f64::from(r[k][c])));
            let scale = 1.0 / (((a + b) / 2.0).powi(2) + floor) / 3.0;
            sums[0] += (((x + y) - (a + b)) / 2.0).powi(2) * scale;
            sums[1] += (((x - y) - (a - b)) / 2.0).powi(2) * scale;
        }
        found.iter_mut().zip(sums).for_each(|(values, sum)| values.push(sum));
    }
    found
}

/// The mean without the largest of a hundred.
fn mean_without_worst(values: Vec<f64>) -> f64 {
    let values = sorted(&values);
    let kept = &values[..values.len() * 99 / 100];
    kept.iter().sum::<f64>() / kept.len() as f64
}

/// The values in increasing order.
#[must_use]
pub fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_and_the_worst_pixel_of_a_hundred_is_left_out() {
        // mean(r^2) = 4, so that the floor is 0.04.
        let reference = vec![[2.0_f32; 3]; 200];
        let mut image: Vec<[f32; 3]> = vec![[2.2, 2.0, 2.0]; 200];
        image[7] = [12.0; 3];
        image[90] = [-8.0; 3];
        let [without, all] = relative_squared_error(&image, &reference);
        let usual = 0.2_f64.powi(2) / 4.04 / 3.0;
        assert!((without - usual).abs() < 1e-8, "{without}");
        assert!((all - (198.0 * usual + 2.0 * 100.0 / 4.04) / 200.0).abs() < 1e-6, "{all}");
    }

    #[test]
    fn noise_of_the_references_has_the_expectation_zero() {
        // Each reference is off at every pixel, in ways that do not correlate; the image is right.
        let noisy =
            |phase: usize| (0..400_usize).map(|k| [if (k / phase).is_multiple_of(2) { 1.1 } else { 0.9 }; 3]).collect();
        let references: [Images; 2] = [vec![noisy(1)], vec![noisy(2)]];
        let right = vec![[1.0_f32; 3]; 400];
        let of_both = squared_error(&right, &references, 0);
        let [of_one, _] = relative_squared_error(&right, &references[0][0]);
        assert!(of_both.abs() < 2e-4 && of_one > 9e-3, "{of_both} {of_one}");
    }

    /// Errors far below the noise of the references are found, also where that noise has few and large values.
    #[test]
    fn small_errors_are_found_below_noise_that_is_larger() {
        // The noise of a pixel is the cube of a sum of two uniform numbers: its largest hundredth has a fifth of the squares.
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / 16_777_216.0 - 0.5
        };
        let mut noisy = || (0..40_000).map(|_| [1.0 + 0.2 * (uniform() + uniform()).powi(3); 3]).collect();
        let references: [Images; 2] = [vec![noisy()], vec![noisy()]];
        let off = |by: f32| vec![[1.0 + by; 3]; 40_000];
        let [noise, _] = relative_squared_error(&off(0.0), &references[0][0]);
        let [none, some] = [0.0, 0.01].map(|by| squared_error(&off(by), &references, 0));
        assert!(noise > 1e-3 && none.abs() < 4e-5 && (some - 1e-4).abs() < 4e-5, "{noise} {none} {some}");
    }
}
