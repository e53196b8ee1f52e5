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
    let [a, b] = [&references[0][view], &references[1][view]];
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
    errors.truncate(errors.len() * 99 / 100);
    errors.iter().map(|error| error[0]).sum::<f64>() / errors.len() as f64
}

/// The values in increasing order.
#[must_use]
pub fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}
