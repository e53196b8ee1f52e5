//! The reference implementation of the step in f64: a linear fit with one slope for all channels by the full normal
//! equations.

use super::super::views::{ARMS, View, Views, test_views};
use super::{FLOOR, Image, OF_GRADIENT, ROBUST, measure_pixel as fast, visible_steps};

/// Keys' kernel with a = -1/2, piece by piece as in his paper (1981, Eq. 15).
fn kernel(distance: f64) -> f64 {
    let s = distance.abs();
    if s < 1.0 {
        1.5 * s.powi(3) - 2.5 * s.powi(2) + 1.0
    } else if s < 2.0 {
        -0.5 * s.powi(3) + 2.5 * s.powi(2) - 4.0 * s + 2.0
    } else {
        0.0
    }
}

/// A plane of samples at a position between its pixels, with the border pixels extended.
fn sample(plane: &[f32], (rows, columns): (usize, usize), y: f64, x: f64) -> f64 {
    let mut sum = 0.0;
    for row in -2..=rows as isize + 1 {
        for column in -2..=columns as isize + 1 {
            let inside =
                (row.clamp(0, rows as isize - 1) as usize) * columns + column.clamp(0, columns as isize - 1) as usize;
            sum += kernel(y - row as f64) * kernel(x - column as f64) * f64::from(plane[inside]);
        }
    }
    sum
}

/// Whether, in a view, another pixel of the same line occludes this one.
fn is_hidden(map: &[f32], (rows, columns): (usize, usize), row: usize, column: usize, view: &View) -> bool {
    let (down, right) = ARMS[view.arm];
    (1..rows.max(columns) as isize).any(|distance| {
        let other_row = row.wrapping_add_signed(down * distance);
        let other_column = column.wrapping_add_signed(right * distance);
        other_row < rows && other_column < columns && {
            let nearer = f64::from(map[other_row * columns + other_column]) - f64::from(map[row * columns + column]);
            (distance as f64) < nearer * f64::from(view.reach)
        }
    })
}

/// The difference of two neighbors over their distance.
fn slope(plane: &[f32], columns: usize, ends: [(usize, usize); 2], distance: usize) -> f64 {
    let at = |(row, column): (usize, usize)| f64::from(plane[row * columns + column]);
    if distance == 0 { 0.0 } else { (at(ends[1]) - at(ends[0])) / distance as f64 }
}

/// The inverse of a small matrix by Gauss-Jordan elimination.
fn inverse(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let size = matrix.len();
    let mut inverse: Vec<Vec<f64>> =
        (0..size).map(|row| (0..size).map(|column| f64::from(row == column)).collect()).collect();
    for pivot in 0..size {
        let best = (pivot..size).max_by(|&a, &b| matrix[a][pivot].abs().total_cmp(&matrix[b][pivot].abs())).unwrap();
        matrix.swap(pivot, best);
        inverse.swap(pivot, best);
        let scale = matrix[pivot][pivot];
        for column in 0..size {
            matrix[pivot][column] /= scale;
            inverse[pivot][column] /= scale;
        }
        for row in (0..size).filter(|&row| row != pivot) {
            let factor = matrix[row][pivot];
            for column in 0..size {
                matrix[row][column] -= factor * matrix[pivot][column];
                inverse[row][column] -= factor * inverse[pivot][column];
            }
        }
    }
    inverse
}

/// The weighted squared distances of places from their mean, which the noise of a gradient takes for a movement.
fn spread(places: &[([f64; 2], f64)]) -> f64 {
    let total: f64 = places.iter().map(|(_, weight)| weight).sum();
    let along = |axis: usize| {
        let middle = places.iter().map(|(place, weight)| weight * place[axis]).sum::<f64>() / total;
        places.iter().map(|(place, weight)| weight * (place[axis] - middle).powi(2)).sum::<f64>()
    };
    along(0) + along(1)
}

/// The step, its information with that of noise, that of noise, and the mean color of one pixel.
fn measure_pixel(views: &Views, map: &[f32], image: &[f32], row: usize, column: usize) -> (f64, f64, f64, Vec<f64>) {
    let (rows, columns) = (views.size.rows, views.size.columns);
    let (pixels, channels) = (views.pixels(), views.channels);
    let pixel = row * columns + column;
    let disparity_px = f64::from(map[pixel]);
    let center: Vec<f64> = (0..channels).map(|channel| f64::from(views.center[channel * pixels + pixel])).collect();

    // (down, right, differences to the central view) of every view in which the pixel is visible.
    let mut seen = Vec::new();
    for view in &views.others {
        let (y, x) =
            (row as f64 - disparity_px * f64::from(view.down), column as f64 - disparity_px * f64::from(view.right));
        let is_inside = (0.0..=(rows - 1) as f64).contains(&y) && (0.0..=(columns - 1) as f64).contains(&x);
        if is_inside && !is_hidden(map, (rows, columns), row, column, view) {
            let plane = |channel: usize| &view.samples[channel * pixels..(channel + 1) * pixels];
            let differences: Vec<f64> =
                (0..channels).map(|channel| sample(plane(channel), (rows, columns), y, x) - center[channel]).collect();
            seen.push((f64::from(view.down), f64::from(view.right), differences));
        }
    }
    if seen.is_empty() {
        return (0.0, 0.0, 0.0, center);
    }
    let squares: Vec<f64> = seen
        .iter()
        .map(|(_, _, differences)| differences.iter().map(|d| d * d).sum::<f64>() / channels as f64)
        .collect();
    let mut sorted = squares.clone();
    sorted.sort_by(f64::total_cmp);
    let scale = 3.0 * sorted[sorted.len() / 2] + f64::from(FLOOR).powi(2);
    let weights: Vec<f64> = squares.iter().map(|square| 1.0 / (1.0 + square / scale)).collect();

    // Observations (channel, h, difference, weight), including the central view with h = 0 and difference 0.
    let mut observations = Vec::new();
    for channel in 0..channels {
        let plane = &image[channel * pixels..(channel + 1) * pixels];
        let (above, below) = (row.saturating_sub(1), (row + 1).min(rows - 1));
        let (left, right) = (column.saturating_sub(1), (column + 1).min(columns - 1));
        let by_row = slope(plane, columns, [(above, column), (below, column)], below - above);
        let by_column = slope(plane, columns, [(row, left), (row, right)], right - left);
        observations.push((channel, 0.0, 0.0, 1.0));
        for ((down, right, differences), weight) in seen.iter().zip(&weights) {
            observations.push((channel, down * by_row + right * by_column, differences[channel], *weight));
        }
    }
    // Unknowns: the slope, then one constant per channel.
    let mut normal = vec![vec![0.0; channels + 1]; channels + 1];
    let mut right_side = vec![0.0; channels + 1];
    for &(channel, h, difference, weight) in &observations {
        normal[0][0] += weight * h * h;
        normal[0][channel + 1] += weight * h;
        normal[channel + 1][0] += weight * h;
        normal[channel + 1][channel + 1] += weight;
        right_side[0] += weight * h * difference;
        right_side[channel + 1] += weight * difference;
    }
    let covariance = inverse(normal);
    let solution: Vec<f64> =
        covariance.iter().map(|row| row.iter().zip(&right_side).map(|(a, b)| a * b).sum()).collect();
    let residual: f64 = observations
        .iter()
        .map(|&(channel, h, difference, weight)| {
            weight * (difference - solution[channel + 1] - solution[0] * h).powi(2)
        })
        .sum();
    let total = 1.0 + weights.iter().sum::<f64>();
    let variance = f64::from(ROBUST) * residual / (total * channels as f64) + f64::from(FLOOR).powi(2);
    let places: Vec<([f64; 2], f64)> = std::iter::once(([0.0; 2], 1.0))
        .chain(seen.iter().zip(&weights).map(|((down, right, _), weight)| ([*down, *right], *weight)))
        .collect();
    let noise = spread(&places) * f64::from(OF_GRADIENT) * channels as f64;
    let mean = (0..channels)
        .map(|channel| {
            let sum: f64 = seen.iter().zip(&weights).map(|((_, _, d), weight)| weight * d[channel]).sum();
            center[channel] + sum / total
        })
        .collect();
    (solution[0], 1.0 / covariance[0][0] / variance, noise, mean)
}

#[test]
fn steps_agree_with_the_normal_equations() {
    let mut known = 0;
    for (rows, columns, channels) in [(16, 17, 3), (14, 9, 1), (3, 2, 3)] {
        let views = test_views(rows, columns, channels);
        let pixels = rows * columns;
        // A tilted ground with a box on it: some views are occluded, and some pixels are outside the image.
        let map: Vec<f32> = (0..pixels)
            .map(|pixel| match (pixel / columns, pixel % columns) {
                (5..=9, 4..=7) => 1.55,
                (row, column) => -0.31 + 0.013 * row as f32 + 0.021 * column as f32,
            })
            .collect();
        let image = Image { samples: &views.center, is_mean: false };
        for pixel in 0..pixels {
            let (row, column) = (pixel / columns, pixel % columns);
            let (delta, information, noise, mean) = measure_pixel(&views, &map, &views.center, row, column);
            let limits = visible_steps(&views, &map, row, column, 1.55);
            let mut found_mean = vec![0.0; channels];
            let found = fast(&views, map[pixel], image, [row, column], &limits, &mut found_mean);
            let (squares, products) = found.fit(&found.gradients, &found.pulls);
            let at = format!("{rows}x{columns}x{channels} pixel {pixel}");
            // Sums of at most 43 products in f32 have errors of at most 43 half ulps, 2.6e-6. Their differences (sums of
            // squares less those of means, squares less the fitted part) are a tenth of the sums here: 2.6e-5.
            let step = if squares > 1e-12 { f64::from(products / squares) } else { 0.0 };
            assert!((step - delta).abs() < 2.6e-5 * (delta.abs() + 0.05), "{at}: {step}, {delta}");
            let found_information = if found.variance > 0.0 { f64::from(squares / found.variance) } else { 0.0 };
            assert!(
                (found_information - information).abs() < 2.6e-5 * (information + 1.0),
                "{at}: {found_information}, {information}"
            );
            assert!((f64::from(found.noise) - noise).abs() < 2.6e-5 * (noise + 1.0), "{at}: {}, {noise}", found.noise);
            known += usize::from(information > 0.0);
            for (found, mean) in found_mean.iter().zip(mean) {
                // A mean of numbers below 1, without cancellation.
                assert!((f64::from(*found) - mean).abs() < 1e-6, "{at}: {found}, {mean}");
            }
        }
    }
    assert!(known > 100, "only {known} pixels with information");
}
