//! Light fields of textured planes, without noise.

use holo_core::{BaselineRatio, LightField, LightFieldOwned};
use ndarray::{Array2, Array5};

/// A surface of disparity `here + by_row * v + by_column * u` at the pixel `(v, u)` of the central view.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    pub here: f64,
    pub by_row: f64,
    pub by_column: f64,
}

impl Surface {
    pub fn disparity_px(&self, v: f64, u: f64) -> f64 {
        self.here + self.by_row * v + self.by_column * u
    }

    /// The pixel of the central view that is seen at `(v, u)` of the view `down` and `right` of it.
    ///
    /// There is `v' = v - d down`, `u' = u - d right`, and d is linear in `(v, u)`; solved for `(v, u)`.
    pub fn source(&self, v: f64, u: f64, down: f64, right: f64) -> (f64, f64) {
        let d = self.disparity_px(v, u) / (1.0 - self.by_row * down - self.by_column * right);
        (v + d * down, u + d * right)
    }
}

/// A smooth texture: waves of 9 to 31 pixels in four directions, another phase for each channel.
pub fn texture(v: f64, u: f64, channel: usize) -> f64 {
    let phase = channel as f64 * 1.3;
    let wave = |by_row: f64, by_column: f64, phase: f64| (by_row * v + by_column * u + phase).sin();
    0.5 + 0.12 * wave(0.55, 0.25, phase)
        + 0.12 * wave(-0.31, 0.48, 2.0 * phase + 1.0)
        + 0.1 * wave(0.2, 0.62, 0.5 * phase)
        + 0.1 * wave(0.69, -0.1, phase + 2.0)
}

/// `shape` is (V, U, T, S, C).
pub fn plane(shape: [usize; 5], surface: Surface) -> (LightFieldOwned<f32>, Array2<f32>) {
    plane_of(shape, surface, BaselineRatio::EQUAL)
}

/// The same seen by a rig with the given baselines.
pub fn plane_of(shape: [usize; 5], surface: Surface, ratio: BaselineRatio) -> (LightFieldOwned<f32>, Array2<f32>) {
    let (middle_row, middle_column) = ((shape[2] / 2) as f64, (shape[3] / 2) as f64);
    let samples = Array5::from_shape_fn(shape, |(v, u, t, s, channel)| {
        let (v, u) = surface.source(
            v as f64,
            u as f64,
            (t as f64 - middle_row) * ratio.vertical(),
            (s as f64 - middle_column) * ratio.horizontal(),
        );
        texture(v, u, channel) as f32
    });
    let truth = Array2::from_shape_fn((shape[0], shape[1]), |(v, u)| surface.disparity_px(v as f64, u as f64) as f32);
    (LightField::new(samples).unwrap(), truth)
}

/// The largest difference farther than `border` from the image edges.
pub fn worst(estimate: &Array2<f32>, truth: &Array2<f32>, border: usize) -> f32 {
    let (rows, columns) = truth.dim();
    let mut worst = 0.0_f32;
    for v in border..rows - border {
        for u in border..columns - border {
            worst = worst.max((estimate[[v, u]] - truth[[v, u]]).abs());
        }
    }
    worst
}
