//! Shift-and-sum with a disparity for each pixel.
//!
//! Pixels share no work: each takes sixteen samples of every view.

use crate::base::parallel::*;
use ndarray::{Array3, ArrayView2, ArrayView5};

use super::Refocus;
use super::kernel::Shift;
use crate::base::memory::{collected, filled};
use crate::{Error, Real, Sample};

pub(super) fn all_in_focus<T: Sample, D: Real>(
    refocus: &Refocus,
    samples: ArrayView5<'_, T>,
    disparity_px: ArrayView2<'_, D>,
) -> Result<Array3<f32>, Error> {
    let shape: [usize; 5] = samples.dim().into();
    let [rows, columns, _, _, channels] = shape;
    let mut image = filled("a refocused image", rows * columns * channels, f32::NAN)?;

    // Samples are addressed by a sum of strides. A light field with gaps or reversed axes is copied first.
    let forward = samples.strides().iter().all(|&stride| stride >= 0);
    let copy: Vec<T>;
    let (memory, strides) = match samples.as_slice_memory_order() {
        Some(memory) if forward => (memory, std::array::from_fn(|axis| samples.strides()[axis] as usize)),
        _ => {
            copy = collected("a copy of a light field", samples.iter().copied())?;
            (&copy[..], std::array::from_fn(|axis| shape[axis + 1..].iter().product()))
        }
    };
    let source = Source { memory, strides, shape };

    image.par_chunks_mut(columns * channels).enumerate().for_each_init(Vec::new, |along, (v, line)| {
        for (u, pixel) in line.chunks_exact_mut(channels).enumerate() {
            let disparity_px = disparity_px[[v, u]].to_f64();
            if disparity_px.is_finite() {
                source.refocus_pixel(refocus, disparity_px, (v, u), along, pixel);
            }
        }
    });
    Ok(Array3::from_shape_vec((rows, columns, channels), image).expect("the length is the product"))
}

/// A light field without gaps as memory and strides.
struct Source<'a, T> {
    memory: &'a [T],
    strides: [usize; 5],
    shape: [usize; 5],
}

/// The offsets of four samples of a line, and their weights.
struct Taps {
    offsets: [usize; 4],
    weights: [f32; 4],
}

impl<T: Sample> Source<'_, T> {
    /// Sums one pixel over all views. `along` is scratch memory.
    fn refocus_pixel(
        &self,
        refocus: &Refocus,
        disparity_px: f64,
        (v, u): (usize, usize),
        along: &mut Vec<Option<Taps>>,
        pixel: &mut [f32],
    ) {
        let [rows, columns, view_rows, view_columns, _] = self.shape;
        let [row_stride, column_stride, view_row_stride, view_column_stride, _] = self.strides;
        let taps = |position: f64, pixel: usize, count: usize, stride: usize, base: usize| {
            let shift = Shift::new(position, count, refocus.kernel);
            shift.covered.contains(&pixel).then(|| Taps {
                offsets: std::array::from_fn(|tap| base + shift.source(pixel, tap, count) * stride),
                weights: shift.weights,
            })
        };
        let vertical_px = disparity_px * refocus.ratio.vertical();
        let horizontal_px = disparity_px * refocus.ratio.horizontal();
        along.clear();
        along.extend((0..view_columns).map(|s| {
            let position = -horizontal_px * (s as f64 - refocus.reference.1);
            taps(position, u, columns, column_stride, s * view_column_stride)
        }));
        let down = (0..view_rows).map(|t| {
            let position = -vertical_px * (t as f64 - refocus.reference.0);
            taps(position, v, rows, row_stride, t * view_row_stride)
        });
        let down: Vec<_> = down.collect();
        match pixel.len() {
            3 => self.sum::<3>(refocus, &down, along, 0, pixel),
            4 => self.sum::<4>(refocus, &down, along, 0, pixel),
            channels => {
                for channel in 0..channels {
                    self.sum::<1>(refocus, &down, along, channel, &mut pixel[channel..=channel]);
                }
            }
        }
    }

    /// Sums `N` channels of one pixel, from channel `first` on.
    fn sum<const N: usize>(
        &self,
        refocus: &Refocus,
        down: &[Option<Taps>],
        along: &[Option<Taps>],
        first: usize,
        pixel: &mut [f32],
    ) {
        let (weights, stride) = (refocus.aperture.weights(), self.strides[4]);
        let (mut total, mut sum) = (0.0, [0.0_f32; N]);
        for (down, weights) in down.iter().zip(weights.outer_iter()) {
            let Some(down) = down else { continue };
            // The views of a row first, as in the sum of whole images, with the same bound of the rounding error.
            let mut row_sum = [0.0_f32; N];
            for (along, &weight) in along.iter().zip(weights) {
                let Some(along) = along else { continue };
                if weight == 0.0 {
                    continue;
                }
                total += weight;
                for (row, row_weight) in down.offsets.into_iter().zip(down.weights) {
                    let mut line = [0.0_f32; N];
                    for (column, column_weight) in along.offsets.into_iter().zip(along.weights) {
                        let place = row + column + first * stride;
                        for channel in 0..N {
                            line[channel] += column_weight * self.memory[place + channel * stride].to_f32();
                        }
                    }
                    for channel in 0..N {
                        row_sum[channel] += weight * row_weight * line[channel];
                    }
                }
            }
            for channel in 0..N {
                sum[channel] += row_sum[channel];
            }
        }
        for channel in 0..N {
            pixel[channel] = sum[channel] / total;
        }
    }
}
