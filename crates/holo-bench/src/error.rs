//! Errors of rendered views.

use holo_core::ViewIndex;

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
    mean_without_worst(&errors_of_pixels(images, [&references[0][view], &references[1][view]]))
}

/// The relative squared error against one reference r, the mean of (x - r)^2 / (r^2 + 0.01 mean(r^2)) over pixels and
/// channels: without the worst pixel of a hundred, and over all.
#[must_use]
pub fn relative_squared_error(image: &[[f32; 3]], reference: &[[f32; 3]]) -> [f64; 2] {
    let errors = errors_of_pixels([image; 2], [reference; 2]);
    [mean_without_worst(&errors), errors.iter().sum::<f64>() / errors.len() as f64]
}

/// The mean squared difference of two images.
#[must_use]
pub fn squared_difference(image: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let squares = image.as_flattened().iter().zip(reference.as_flattened()).map(|(x, r)| f64::from(x - r).powi(2));
    squares.sum::<f64>() / (3 * image.len()) as f64
}

/// The error of every pixel, as [`squared_bias`]; those last that are farthest from the mean of the references.
fn errors_of_pixels(images: [&[[f32; 3]]; 2], [a, b]: [&[[f32; 3]]; 2]) -> Vec<f64> {
    let mean = |k: usize, c: usize| f64::from(a[k][c] + b[k][c]) / 2.0;
    let bright = (0..a.len()).flat_map(|k| (0..3).map(move |c| (k, c))).map(|(k, c)| mean(k, c).powi(2)).sum::<f64>();
    let floor = 0.01 * bright / (3 * a.len()) as f64;
    // The pixel's error, and the same against the mean of the references, by which the worst are found.
    let mut errors: Vec<[f64; 2]> = (0..a.len())
        .map(|k| {
            let mut error = [0.0; 2];
            for c in 0..3 {
                let ([x, y], m) = (images.map(|image| f64::from(image[k][c])), mean(k, c));
                let scale = 1.0 / (m * m + floor) / 3.0;
                error[0] += (x - f64::from(a[k][c])) * (y - f64::from(b[k][c])) * scale;
                error[1] += ((x + y) / 2.0 - m).powi(2) * scale;
            }
            error
        })
        .collect();
    errors.sort_by(|x, y| x[1].total_cmp(&y[1]));
    errors.into_iter().map(|error| error[0]).collect()
}

/// The mean without the last of a hundred.
fn mean_without_worst(errors: &[f64]) -> f64 {
    let kept = &errors[..errors.len() * 99 / 100];
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
}
