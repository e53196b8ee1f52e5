//! Shift-and-sum with a disparity for each pixel.

use ndarray::{Array3, ArrayView2, ArrayView5};
use rayon::prelude::*;

use super::Refocus;
use super::kernel::Shift;
use crate::light_field::filled_memory;
use crate::{Error, Real, Sample};

pub(super) fn all_in_focus<T: Sample, D: Real>(
    refocus: &Refocus,
    samples: ArrayView5<'_, T>,
    disparity_px: ArrayView2<'_, D>,
) -> Result<Array3<f32>, Error> {
    let (rows, columns, _, _, channels) = samples.dim();
    let mut picture = filled_memory(rows * columns * channels, f32::NAN)?;
    picture.par_chunks_mut(columns * channels).enumerate().for_each_init(Vec::new, |sum, (v, line)| {
        for (u, pixel) in line.chunks_exact_mut(channels).enumerate() {
            let disparity_px = disparity_px[[v, u]].to_f64();
            if disparity_px.is_finite() {
                refocus_pixel(refocus, &samples, disparity_px, (v, u), sum, pixel);
            }
        }
    });
    Ok(Array3::from_shape_vec((rows, columns, channels), picture).expect("the length is the product"))
}

/// Sums up one pixel over all views. `sum` is memory that is used again.
fn refocus_pixel<T: Sample>(
    refocus: &Refocus,
    samples: &ArrayView5<'_, T>,
    disparity_px: f64,
    (v, u): (usize, usize),
    sum: &mut Vec<f32>,
    pixel: &mut [f32],
) {
    let (rows, columns, view_rows, view_columns, channels) = samples.dim();
    let shift = |disparity: f64, view: usize, reference: f64, count: usize| {
        Shift::new(-disparity * (view as f64 - reference), count, refocus.kernel)
    };
    let along: Vec<Shift> = (0..view_columns).map(|s| shift(disparity_px, s, refocus.reference.1, columns)).collect();
    let weights = refocus.aperture.weights();
    pixel.fill(0.0);
    let mut total = 0.0;
    for t in 0..view_rows {
        let down = shift(disparity_px * refocus.vertical_ratio, t, refocus.reference.0, rows);
        if !down.covered.contains(&v) {
            continue;
        }
        // The row of views first, as the sum over whole images does, so that the error grows no faster.
        sum.clear();
        sum.resize(channels, 0.0);
        for (s, along) in along.iter().enumerate() {
            let weight = weights[[t, s]];
            if weight == 0.0 || !along.covered.contains(&u) {
                continue;
            }
            total += weight;
            for (i, &down_weight) in down.weights.iter().enumerate().filter(|&(_, &weight)| weight != 0.0) {
                let row = down.source(v, i, rows);
                for (j, &along_weight) in along.weights.iter().enumerate().filter(|&(_, &weight)| weight != 0.0) {
                    let column = along.source(u, j, columns);
                    let weight = weight * down_weight * along_weight;
                    for (c, sum) in sum.iter_mut().enumerate() {
                        *sum += weight * samples[[row, column, t, s, c]].to_f32();
                    }
                }
            }
        }
        for (pixel, sum) in pixel.iter_mut().zip(sum.iter()) {
            *pixel += sum;
        }
    }
    pixel.iter_mut().for_each(|sample| *sample /= total);
}
