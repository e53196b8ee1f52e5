//! First-order fits, over the views of a microlens and over neighboring microlenses: where a surface goes on, its light
//! there tells its light here.
//!
//! The nodes of the same view behind (2 r + 1)^2 microlenses have estimates at known places; the value at the place of the
//! node is that of the plane through them, by weighted least squares (a local linear regression; Cleveland, 1979). A
//! gradient is no bias, and what noise is left is smooth over the microlenses: it holds nothing to match between views.

use super::super::guides::luminance;

/// The radii r, in microlenses.
pub(super) const RADII: [usize; 3] = [1, 2, 4];

/// The largest [`Plane::lever`] of a plane that tells something. In a corner of a grid of places that all have estimates it is
/// 7; beside the only packet of pixels with samples it is tens.
pub(super) const MAX_LEVER: f32 = 8.0;

/// The largest lever of a place among the estimates, not beside them.
const MAX_INNER_LEVER: f32 = 2.0;

/// The largest radius.
pub(super) const REACH: usize = RADII[RADII.len() - 1];

/// The largest ratio of the tints of two windows that tell each other's light.
const MAX_TINT_RATIO: f32 = 8.0;

/// What is added to the second moments, relative to the weight, px^2: without neighbors the mean remains.
const RIDGE: f32 = 1e-3;

/// The means of the samples of a window.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Window {
    /// The color, and the variance of its luminance.
    pub values: [f32; 4],
    /// Where the samples lie on average, px down and to the right of the point.
    pub offset: [f32; 2],
    /// The number of samples; without any there are no means.
    pub weight: f32,
    /// The tint.
    pub tint: [f32; 3],
}

impl Window {
    /// The window as a surface of another tint would show it, and the weight it has in a fit there: the square of the ratio
    /// of the luminances of the tints, at most 1. A darker window has more noise once it is brightened; a brighter one may
    /// show another material. `None` if a channel differs by more than [`MAX_TINT_RATIO`].
    #[inline(always)]
    pub fn tinted(&self, tint: &[f32; 3]) -> Option<(Self, f32)> {
        let mut out = *self;
        for c in 0..3 {
            let ratio = tint[c] / self.tint[c];
            if !(1.0 / MAX_TINT_RATIO..=MAX_TINT_RATIO).contains(&ratio) {
                return None;
            }
            out.values[c] *= ratio;
        }
        let ratio = luminance(*tint) / luminance(self.tint);
        out.values[3] *= ratio * ratio;
        let less = ratio.min(1.0 / ratio);
        Some((out, less * less))
    }
}

/// A plane through estimates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plane {
    /// The color at the place of the node, and the variance of its luminance.
    pub values: [f32; 4],
    /// The change of the color per microlens down and to the right.
    pub gradient: [[f32; 3]; 2],
    /// The weight; 0 without estimates.
    pub weight: f32,
    /// The variance there relative to that of the mean of the estimates: 1 in their middle, and the more the farther beside
    /// them.
    pub lever: f32,
}

/// The moments of estimates at places of a plane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    weight: f32,
    /// Of the places: y, x.
    first: [f32; 2],
    /// y y, y x, x x.
    second: [f32; 3],
    values: [f32; 3],
    /// The variance of the sum of the luminance.
    variance: f32,
    /// Of places with values.
    mixed: [[f32; 3]; 2],
}

impl Moments {
    /// Adds an estimate of a microlens so many microlenses down and to the right, with its weight times `factor`.
    #[inline(always)]
    pub fn add(&mut self, window: &Window, apart: [f32; 2], factor: f32) {
        let weight = window.weight * factor;
        let [y, x] = [apart[0] + window.offset[0], apart[1] + window.offset[1]];
        let [wy, wx] = [weight * y, weight * x];
        self.weight += weight;
        self.first[0] += wy;
        self.first[1] += wx;
        self.second[0] += wy * y;
        self.second[1] += wy * x;
        self.second[2] += wx * x;
        self.variance += weight * weight * window.values[3];
        for k in 0..3 {
            self.values[k] += weight * window.values[k];
            self.mixed[0][k] += wy * window.values[k];
            self.mixed[1][k] += wx * window.values[k];
        }
    }

    /// The sum of the weights.
    #[inline(always)]
    pub fn weight(&self) -> f32 {
        self.weight
    }

    /// The mean of the estimates.
    #[inline(always)]
    pub fn mean(&self) -> [f32; 3] {
        self.values.map(|sum| if self.weight > 0.0 { sum / self.weight } else { 0.0 })
    }

    /// The plane of least squares with its values at a place, or, far beside the estimates, and where a plane beside them falls
    /// below nothing, their mean.
    #[inline(always)]
    pub fn plane_or_mean_at(&self, place: [f32; 2]) -> Plane {
        let plane = self.plane_at(place);
        let [r, g, b, _] = plane.values;
        let is_light = plane.lever <= MAX_INNER_LEVER || luminance([r, g, b]) > 0.0;
        if plane.lever <= MAX_LEVER && is_light {
            return plane;
        }
        let scale = 1.0 / self.weight;
        let [r, g, b] = self.mean();
        let values = [r, g, b, self.variance * scale * scale];
        Plane { values, gradient: [[0.0; 3]; 2], weight: self.weight, lever: 1.0 }
    }

    /// The plane of least squares, with its values at a place.
    #[inline(always)]
    pub fn plane_at(&self, place: [f32; 2]) -> Plane {
        if self.weight <= 0.0 {
            return Plane::default();
        }
        let scale = 1.0 / self.weight;
        let [y, x] = self.first.map(|sum| sum * scale);
        let [to_y, to_x] = [place[0] - y, place[1] - x];
        // Central moments.
        let yy = self.second[0] * scale - y * y + RIDGE;
        let yx = self.second[1] * scale - y * x;
        let xx = self.second[2] * scale - x * x + RIDGE;
        let inverse = 1.0 / (yy * xx - yx * yx);
        let mut out = Plane { weight: self.weight, ..Plane::default() };
        for k in 0..3 {
            let mean = self.values[k] * scale;
            let [fy, fx] = [self.mixed[0][k] * scale - y * mean, self.mixed[1][k] * scale - x * mean];
            let (down, across) = ((fy * xx - fx * yx) * inverse, (fx * yy - fy * yx) * inverse);
            out.values[k] = mean + down * to_y + across * to_x;
            (out.gradient[0][k], out.gradient[1][k]) = (down, across);
        }
        // That of a mean, and more where the estimates lie to one side.
        let beside = (to_y * to_y * xx - 2.0 * to_y * to_x * yx + to_x * to_x * yy) * inverse;
        out.lever = 1.0 + beside;
        out.values[3] = self.variance * scale * scale * out.lever;
        out
    }
}
