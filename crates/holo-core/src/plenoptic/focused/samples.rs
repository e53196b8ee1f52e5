//! The samples of a point of the scene in the micro-images around it.

use ndarray::{ArrayView2, ArrayView3};

use super::super::decode::{LEAST_LIGHT, bilinear};
use super::lenses::{FARTHEST, Lens, Lenses, REACH};
use crate::base::memory::filled;
use crate::base::parallel::*;
use crate::{Error, GridSize, RigRay};

/// The standard deviation of the weights of microlenses around a ray, pitches: the nearest one counts most, and weights change smoothly
/// from one to the next.
const BLEND: f64 = 0.45;

/// The blur at which a sample has a quarter of the weight of a sharp one, px.
const BLUR_PX: f64 = 0.8;

/// Samples of less weight, of that of the sharpest, do not take part in the search for depth.
const LEAST_SHARPNESS: f64 = 0.1;

/// A point on a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    origin_m: [f64; 2],
    slope: [f64; 2],
    /// 1 / depth; 0 at infinity.
    pub inverse_depth: f64,
}

impl Point {
    pub fn new(ray: &RigRay, inverse_depth: f64) -> Self {
        let [x, y, _] = ray.origin_m;
        Self { origin_m: [x, y], slope: [ray.direction[0], ray.direction[1]], inverse_depth }
    }

    /// The slope of the chief ray of the place where the ray meets the array.
    pub fn on_array(&self, lenses: &Lenses) -> [f64; 2] {
        [0, 1].map(|k| self.slope[k] + self.origin_m[k] * lenses.inverse_focus)
    }

    /// The same ray at a depth that the nearest microlens shows: points nearer to the array are taken to be at the least depth.
    pub fn shown(self, lenses: &Lenses) -> Self {
        let least = lenses.least_off_focus;
        let off_focus = (self.inverse_depth - lenses.inverse_focus) * least.signum();
        Self { inverse_depth: lenses.inverse_focus + off_focus.max(least.abs()) * least.signum(), ..self }
    }

    /// Where a microlens shows it, (x, y), px; `None` outside of its micro-image.
    pub fn place_px(&self, lenses: &Lenses, lens: &Lens) -> Option<[f64; 2]> {
        let off_focus = self.inverse_depth - lenses.inverse_focus;
        // Where the ray from the point through the center of the microlens passes the pupil.
        let in_pupil_m =
            [0, 1].map(|k| (self.origin_m[k] * self.inverse_depth + self.slope[k] - lens.slope[k]) / off_focus);
        let [right, up] = in_pupil_m.map(|x| x * lens.px_per_m);
        let away = right.hypot(up);
        let is_inside = away <= lenses.radius_px;
        if !is_inside {
            return None;
        }
        // Towards the border only a part of the microlens has light; the blur of the point lies to that side of its chief ray.
        let lean_px = self.blur_px(lenses, lens) * lenses.lean(lens, away);
        let factor = 1.0 + if away > 0.0 { lean_px / away } else { 0.0 };
        Some([lens.center_px[0] + factor * right, lens.center_px[1] - factor * up])
    }

    /// The radius of its blur behind a microlens, px.
    fn blur_px(&self, lenses: &Lenses, lens: &Lens) -> f64 {
        lens.blur[0] - lens.blur[1] / (self.inverse_depth - lenses.inverse_focus)
    }
}

/// A raw image and its white image.
#[derive(Clone, Copy)]
pub(super) struct RawLight<'a> {
    pub raw: ArrayView3<'a, f32>,
    pub white: ArrayView2<'a, f32>,
}

impl RawLight<'_> {
    pub fn channels(&self) -> usize {
        self.raw.dim().2
    }

    /// The white image at a place; `None` where it is dark.
    fn white(&self, (texels, parts): &([[usize; 2]; 4], [f64; 4])) -> Option<f64> {
        let white: f64 = texels.iter().zip(parts).map(|(&at, part)| part * f64::from(self.white[at])).sum();
        (white >= LEAST_LIGHT).then_some(white)
    }

    /// The mean of the channels of a pixel, without vignetting; `None` where it is dark.
    fn mean(&self, row: usize, column: usize) -> Option<f64> {
        let white = f64::from(self.white[[row, column]]);
        let sum: f64 = (0..self.channels()).map(|c| f64::from(self.raw[[row, column, c]])).sum();
        (white >= LEAST_LIGHT).then(|| sum.max(0.0) / (self.channels() as f64 * white))
    }
}

/// How bright the pixels of a raw image are to the eye, a little blurred; NaN where it is dark.
pub(super) struct Brightness {
    /// 1 is what most pixels are below.
    values: Vec<f32>,
    size: GridSize,
}

/// Every so many pixels, along each axis, one tells how bright the image is.
const BRIGHT_STEP: usize = 7;

/// The part of the pixels that are darker than a brightness of 1.
const MOST: f64 = 0.9;

impl Brightness {
    pub fn new(light: &RawLight<'_>) -> Result<Self, Error> {
        let (rows, columns) = light.white.dim();
        let pixels =
            (0..rows).step_by(BRIGHT_STEP).flat_map(|v| (0..columns).step_by(BRIGHT_STEP).map(move |u| (v, u)));
        let mut means: Vec<f64> =
            pixels.filter_map(|(v, u)| light.mean(v, u)).filter(|mean| *mean > 0.0 && mean.is_finite()).collect();
        means.sort_unstable_by(f64::total_cmp);
        let bright = means.get((means.len() as f64 * MOST) as usize).copied().unwrap_or(1.0);
        let mut values = filled("the brightness of a raw image", rows * columns, f32::NAN)?;
        values.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
            for (column, value) in line.iter_mut().enumerate() {
                *value = light.mean(row, column).map_or(f32::NAN, |mean| (mean / bright).sqrt() as f32);
            }
        });
        // Types of microlenses differ in their blur: a little more of it for all makes them more alike.
        Ok(Self { values: blurred(values, [rows, columns])?, size: GridSize::new(rows, columns) })
    }

    /// The brightness at a place; `None` outside of the light.
    fn at(&self, place_px: [f64; 2]) -> Option<f64> {
        let (texels, parts) = bilinear(place_px, self.size)?;
        let value = |[row, column]: [usize; 2]| f64::from(self.values[row * self.size.columns + column]);
        let value: f64 = texels.into_iter().zip(parts).map(|(texel, part)| part * value(texel)).sum();
        (!value.is_nan()).then_some(value)
    }
}

/// An image blurred by 1 2 1 along both axes, twice; dark pixels take no part and stay dark.
fn blurred(mut from: Vec<f32>, [rows, columns]: [usize; 2]) -> Result<Vec<f32>, Error> {
    for _ in 0..2 {
        let mut to = filled("the brightness of a raw image", from.len(), f32::NAN)?;
        to.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
            for (column, value) in line.iter_mut().enumerate() {
                if from[row * columns + column].is_nan() {
                    continue;
                }
                let (mut total, mut sum) = (0.0, 0.0);
                for (v, down) in (row.saturating_sub(1)..(row + 2).min(rows)).map(|v| (v, v.abs_diff(row))) {
                    for (u, along) in
                        (column.saturating_sub(1)..(column + 2).min(columns)).map(|u| (u, u.abs_diff(column)))
                    {
                        let near = from[v * columns + u];
                        if !near.is_nan() {
                            let weight = ((2 - down) * (2 - along)) as f32;
                            (total, sum) = (total + weight, sum + weight * near);
                        }
                    }
                }
                *value = sum / total;
            }
        });
        from = to;
    }
    Ok(from)
}

/// How far the samples of a point are from each other.
pub(super) struct Agreement {
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation.
    pub deviation: f64,
}

impl Lenses {
    /// Sums the light of a point over the microlenses that show it; returns the sum of the weights.
    pub fn color(&self, light: &RawLight<'_>, point: &Point, sums: &mut [f64]) -> f64 {
        sums.fill(0.0);
        let mut total = 0.0;
        let size = GridSize::new(light.white.nrows(), light.white.ncols());
        let on_array = point.on_array(self);
        for lens in self.around(on_array, false) {
            let away = self.away(lens, on_array);
            if away > FARTHEST {
                continue;
            }
            let Some(place_px) = point.place_px(self, lens) else { continue };
            let Some(found) = bilinear(place_px, size) else { continue };
            let Some(white) = light.white(&found) else { continue };
            let near = (-0.5 * (away / BLEND).powi(2)).exp();
            let weight = near * sharpness(point.blur_px(self, lens)) * white;
            for (c, sum) in sums.iter_mut().enumerate() {
                let value: f64 = found
                    .0
                    .iter()
                    .zip(found.1)
                    .map(|(&[row, column], part)| part * f64::from(light.raw[[row, column, c]]))
                    .sum();
                *sum += weight * value / white;
            }
            total += weight;
        }
        total
    }

    /// How well the microlenses `near` a ray that show its point, within `reach` pitches, agree on its brightness; `None` if fewer
    /// than two do.
    pub fn agreement(&self, light: &Brightness, point: &Point, near: &[(&Lens, f64)], reach: f64) -> Option<Agreement> {
        let weight_of = |lens: &Lens| sharpness(point.blur_px(self, lens));
        // The nearest ones are of all types.
        let best = near.iter().take(7).map(|(lens, _)| weight_of(lens)).fold(0.0, f64::max);
        let (mut total, mut squared_weights, mut sum, mut squares) = (0.0, 0.0, 0.0, 0.0);
        for (lens, _) in near.iter().filter(|(_, away)| *away <= reach.min(REACH)) {
            let weight = weight_of(lens) / best;
            if weight < LEAST_SHARPNESS {
                continue;
            }
            let Some(value) = point.place_px(self, lens).and_then(|place_px| light.at(place_px)) else { continue };
            total += weight;
            squared_weights += weight * weight;
            sum += weight * value;
            squares += weight * value * value;
        }
        // As many samples of equal weight vary as much.
        let count = total * total / squared_weights;
        let is_enough = count > 1.5;
        if !is_enough {
            return None;
        }
        let mean = sum / total;
        let variance = (squares / total - mean * mean).max(0.0) * count / (count - 1.0);
        // The root of the variance of few samples is too small on average, by 1/(4 (n - 1)).
        Some(Agreement { mean, deviation: variance.sqrt() * (1.0 + 0.25 / (count - 1.0)) })
    }
}

/// The weight of a sample by its blur.
fn sharpness(blur_px: f64) -> f64 {
    let blur = blur_px / BLUR_PX;
    let one = 1.0 + blur * blur;
    1.0 / (one * one)
}
