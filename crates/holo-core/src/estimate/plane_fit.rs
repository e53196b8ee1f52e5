//! Edge-preserving smoothing: at every pixel a plane fit to the measurements around it that belong to the same surface.

#[cfg(test)]
mod naive;

use crate::base::parallel::*;

use super::measure::Measurements;
use crate::base::memory::filled;
use crate::{Error, GridSize};

/// The color difference at which the weight of a neighbor is 1/4, for colors from 0 to 1.
const COLOR: f32 = 0.1;
/// The weight of the current disparity beside its measurement, in 1/px^2. It determines pixels without information.
const PRIOR: f32 = 4.0;
/// The information, in 1/px^2, from which on only the nearest neighbors are used: a standard error of 0.007 px.
const ENOUGH: f32 = 20_000.0;
/// The largest distance of a neighbor from the surface, in standard errors of the neighborhood of the pixel.
const ERRORS: f32 = 12.0;
/// The ridge regularization of the slopes, for neighbors that do not span a plane.
const RIDGE: f32 = 1e-3;

/// The settings of the plane fits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// Half the side of the square of neighbors, in pixels.
    pub(super) radius_px: usize,
    /// The distance from a well measured surface beyond which a neighbor belongs to another surface.
    pub(super) gate_px: f32,
    /// The same for a surface without information.
    pub(super) widest_px: f32,
}

impl Fit {
    /// Returns the fitted planes around all pixels. `before` has those of the round before, or none; a plane whose pixel has
    /// another disparity since is not used.
    pub(super) fn smooth(
        &self,
        size: GridSize,
        map: &[f32],
        found: &Measurements,
        before: &[Plane],
    ) -> Result<Vec<Plane>, Error> {
        let mut planes = filled("planes around pixels", map.len(), Plane::default())?;
        let neighbors = Neighbors::new(self, size, map, found)?;
        planes.par_iter_mut().with_min_len(size.columns).enumerate().for_each(|(pixel, plane)| {
            let before = before.get(pixel).filter(|plane| plane.here == map[pixel]);
            *plane = neighbors.plane_at(pixel / size.columns, pixel % size.columns, before);
        });
        Ok(planes)
    }
}

/// Disparity as a linear function of the distance to a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Plane {
    pub(super) here: f32,
    pub(super) by_row: f32,
    pub(super) by_column: f32,
    /// The information of the fit, in 1/px^2.
    pub(super) information: f32,
}

/// Neighbors in a row that are added at once.
const LANES: usize = 8;
type Lanes = [f32; LANES];

struct Neighbors<'a> {
    fit: &'a Fit,
    size: GridSize,
    map: &'a [f32],
    found: &'a Measurements,
    channels: usize,
    /// The means of the measurements and the current disparities.
    values: Vec<f32>,
    /// The weights of the distances, row by row of the square, and [`LANES`] more.
    near: Vec<f32>,
}

impl<'a> Neighbors<'a> {
    fn new(fit: &'a Fit, size: GridSize, map: &'a [f32], found: &'a Measurements) -> Result<Self, Error> {
        let mut values = filled("a disparity map", map.len(), 0.0)?;
        values.par_iter_mut().with_min_len(size.columns).enumerate().for_each(|(pixel, value)| {
            let information = found.information[pixel];
            *value = (information * found.disparity_px[pixel] + PRIOR * map[pixel]) / (information + PRIOR);
        });
        let side = 2 * fit.radius_px + 1;
        let from_center = |k: usize| (k as f32 - fit.radius_px as f32).powi(2);
        let per_square = 1.0 / ((fit.radius_px * fit.radius_px) as f32 * 0.75);
        let weight = |k: usize| 1.0 / (1.0 + (from_center(k / side) + from_center(k % side)) * per_square);
        let near = (0..side * side).map(weight).chain([0.0; LANES]);
        Ok(Self { fit, size, map, found, channels: found.image.len() / map.len(), values, near: near.collect() })
    }

    fn plane_at(&self, row: usize, column: usize, before: Option<&Plane>) -> Plane {
        let here = self.map[row * self.size.columns + column];
        let gate_px = self.gate_px(row, column);
        // The first gate is flat. The second follows the slope of the first fit, or of the round before.
        let flat = Plane { here, ..Plane::default() };
        let sloped = before.map_or_else(|| self.fitted(row, column, &flat, gate_px, 1), |plane| *plane);
        let mut plane = self.fitted(row, column, &sloped, gate_px, 1);
        for stride in [2, 4] {
            if plane.information < ENOUGH {
                plane = self.fitted(row, column, &plane, gate_px, stride);
            }
        }
        plane
    }

    /// The largest distance of a neighbor from the surface: wide without information, narrow at the edges of textured
    /// objects.
    fn gate_px(&self, row: usize, column: usize) -> f32 {
        let mut information = 1e-6;
        for row in row.saturating_sub(2)..(row + 3).min(self.size.rows) {
            for column in column.saturating_sub(2)..(column + 3).min(self.size.columns) {
                information += self.found.information[row * self.size.columns + column];
            }
        }
        let Fit { gate_px, widest_px, .. } = *self.fit;
        (gate_px * gate_px + ERRORS * ERRORS / information).sqrt().min(widest_px)
    }

    /// The least-squares plane through every `stride`-th neighbor.
    fn fitted(&self, row: usize, column: usize, last: &Plane, gate_px: f32, stride: usize) -> Plane {
        let GridSize { rows, columns } = self.size;
        let radius = self.fit.radius_px;
        // Counted from the pixel outward, so that the pixel is always included.
        let (above, before) = ((row / stride).min(radius), (column / stride).min(radius));
        let (below, after) = (((rows - 1 - row) / stride).min(radius), ((columns - 1 - column) / stride).min(radius));
        let (left, count) = (column - before * stride, before + 1 + after);
        let color: [f32; 3] =
            std::array::from_fn(|channel| self.color(channel.min(self.channels - 1))[row * columns + column]);
        let per_square = 1.0 / (self.channels as f32 * COLOR * COLOR);
        let mut moments = LaneMoments::default();
        for step in 0..above + 1 + below {
            let other_row = row + step * stride - above * stride;
            let y = other_row as f32 - row as f32;
            let near = &self.near[(radius + step - above) * (2 * radius + 1) + radius - before..];
            for first in (0..count).step_by(LANES) {
                let taken = (count - first).min(LANES);
                let run = Run { first: other_row * columns + left + first * stride, stride, taken };
                let x: Lanes = std::array::from_fn(|lane| ((first + lane) * stride) as f32 - (before * stride) as f32);
                let mut near = Run { first, stride: 1, taken }.of(near);
                for (lane, near) in near.iter_mut().enumerate() {
                    *near = if lane < taken { *near } else { 0.0 };
                }
                let so_far = run.of(self.map);
                let mut squares = [0.0; LANES];
                for channel in 0..self.channels {
                    let other = run.of(self.color(channel));
                    for lane in 0..LANES {
                        squares[lane] += (other[lane] - color[channel]) * (other[lane] - color[channel]);
                    }
                }
                let mut weight = [0.0; LANES];
                for lane in 0..LANES {
                    let off = (so_far[lane] - last.here - last.by_row * y - last.by_column * x[lane]) / gate_px;
                    // Tukey's biweight: the weight is 0 beyond the gate. It is 0 in lanes that are not taken, as `near` is.
                    let same = (1.0 - off * off).max(0.0);
                    let factor = same * near[lane] / (1.0 + squares[lane] * per_square);
                    weight[lane] = factor * factor;
                }
                moments.add(&weight, &run.of(&self.found.information), &x, y, &run.of(&self.values), last.here);
            }
        }
        let mut plane = moments.sum().solve(radius * stride);
        plane.here += last.here;
        plane
    }

    fn color(&self, channel: usize) -> &[f32] {
        let pixels = self.map.len();
        &self.found.image[channel * pixels..(channel + 1) * pixels]
    }
}

/// Every `stride`-th pixel of a row from `first` on, `taken` of them: up to [`LANES`].
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    stride: usize,
    taken: usize,
}

impl Run {
    /// The values of these pixels. Lanes that are not taken hold values of other pixels, or 0.
    #[inline]
    fn of(self, values: &[f32]) -> Lanes {
        let Self { first, stride, taken } = self;
        match values[first..].first_chunk() {
            Some(run) if stride == 1 => *run,
            _ => std::array::from_fn(|lane| if lane < taken { values[first + lane * stride] } else { 0.0 }),
        }
    }
}

/// [`Moments`] of every lane.
#[derive(Default)]
struct LaneMoments {
    one: Lanes,
    x: Lanes,
    y: Lanes,
    xx: Lanes,
    xy: Lanes,
    yy: Lanes,
    d: Lanes,
    dx: Lanes,
    dy: Lanes,
    information: Lanes,
}

impl LaneMoments {
    /// Adds pixels of a row with disparities relative to `base`.
    fn add(&mut self, weight: &Lanes, information: &Lanes, x: &Lanes, y: f32, values: &Lanes, base: f32) {
        for lane in 0..LANES {
            let w = weight[lane] * (information[lane] + PRIOR);
            let (wx, wy, wd) = (w * x[lane], w * y, w * (values[lane] - base));
            self.one[lane] += w;
            self.x[lane] += wx;
            self.y[lane] += wy;
            self.xx[lane] += wx * x[lane];
            self.xy[lane] += wx * y;
            self.yy[lane] += wy * y;
            self.d[lane] += wd;
            self.dx[lane] += wd * x[lane];
            self.dy[lane] += wd * y;
            self.information[lane] += weight[lane] * information[lane];
        }
    }

    fn sum(&self) -> Moments {
        let sum = |lanes: &Lanes| lanes.iter().sum();
        Moments {
            one: sum(&self.one),
            x: sum(&self.x),
            y: sum(&self.y),
            xx: sum(&self.xx),
            xy: sum(&self.xy),
            yy: sum(&self.yy),
            d: sum(&self.d),
            dx: sum(&self.dx),
            dy: sum(&self.dy),
            information: sum(&self.information),
        }
    }
}

/// Weighted sums of 1, x, y, their products, and their products with the value.
#[derive(Debug, Default)]
struct Moments {
    one: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
    d: f32,
    dx: f32,
    dy: f32,
    information: f32,
}

impl Moments {
    /// The least-squares plane; without neighbors the plane 0.
    fn solve(&self, radius: usize) -> Plane {
        if self.one <= 0.0 {
            return Plane { here: 0.0, by_row: 0.0, by_column: 0.0, information: 0.0 };
        }
        let (mean_x, mean_y, mean_d) = (self.x / self.one, self.y / self.one, self.d / self.one);
        let ridge = self.one * (radius * radius) as f32 * RIDGE;
        let xx = self.xx - self.x * mean_x + ridge;
        let yy = self.yy - self.y * mean_y + ridge;
        let xy = self.xy - self.x * mean_y;
        let dx = self.dx - self.d * mean_x;
        let dy = self.dy - self.d * mean_y;
        // By the Cauchy-Schwarz inequality it is at least the ridge squared.
        let determinant = xx * yy - xy * xy;
        let by_column = (dx * yy - dy * xy) / determinant;
        let by_row = (dy * xx - dx * xy) / determinant;
        let here = mean_d - by_column * mean_x - by_row * mean_y;
        Plane { here, by_row, by_column, information: self.information }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reference implementation of `solve`: Cramer's rule on the full 3 x 3 equations in f64.
    fn naive_solve(points: &[(f64, f64, f64, f64)], radius: usize) -> f64 {
        let sum = |f: &dyn Fn(f64, f64, f64) -> f64| points.iter().map(|&(w, x, y, d)| w * f(x, y, d)).sum::<f64>();
        let one = sum(&|_, _, _| 1.0);
        let ridge = one * (radius * radius) as f64 * f64::from(RIDGE);
        let (x, y, d) = (sum(&|x, _, _| x), sum(&|_, y, _| y), sum(&|_, _, d| d));
        let matrix = [
            [one, x, y],
            [x, sum(&|x, _, _| x * x) + ridge, sum(&|x, y, _| x * y)],
            [y, sum(&|x, y, _| x * y), sum(&|_, y, _| y * y) + ridge],
        ];
        let right = [d, sum(&|x, _, d| x * d), sum(&|_, y, d| y * d)];
        naive::solved(&matrix, &right)[0]
    }

    #[test]
    fn solve_agrees_with_cramers_rule() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for _ in 0..200 {
            let points: Vec<_> = (0..20).map(|_| (random(), random() * 8.0 - 4.0, random() * 8.0, random())).collect();
            let mut moments = LaneMoments::default();
            for (k, &(w, x, y, d)) in points.iter().enumerate() {
                let in_lane =
                    |value: f64| std::array::from_fn(|lane| if lane == k % LANES { value as f32 } else { 0.0 });
                // The information is 0, and the weight is that of the current disparity.
                let weight = in_lane(w / f64::from(PRIOR));
                moments.add(&weight, &[0.0; LANES], &in_lane(x), y as f32, &in_lane(d), 0.0);
            }
            let difference = f64::from(moments.sum().solve(4).here) - naive_solve(&points, 4);
            // Twenty terms of about 1, rounded to f32, over a determinant that points on one side of the pixel make
            // small.
            assert!(difference.abs() < 1e-4, "{difference}");
        }
    }

    #[test]
    fn smoothing_keeps_steps_and_reduces_noise() {
        // Two planes with a jump of 1 px between columns 9 and 10, measured with an error of 0.05 px of either sign.
        let size = GridSize::new(20, 20);
        let truth = |pixel: usize| {
            let (row, column) = (pixel / 20, pixel % 20);
            0.01 * row as f32 + if column < 10 { 0.0 } else { 1.0 + 0.02 * column as f32 }
        };
        let map: Vec<f32> = (0..400).map(truth).collect();
        let noisy = (0..400).map(|pixel| truth(pixel) + if pixel % 3 == 0 { 0.1 } else { -0.05 }).collect();
        let found = Measurements { disparity_px: noisy, information: vec![400.0; 400], image: vec![0.5; 400] };
        let fit = Fit { radius_px: 4, gate_px: 0.25, widest_px: 0.5 };
        let smoothed: Vec<f32> = fit.smooth(size, &map, &found, &[]).unwrap().iter().map(|plane| plane.here).collect();
        for pixel in 0..400 {
            let error = (smoothed[pixel] - truth(pixel)).abs();
            // A corner has 25 neighbors: an error of 0.071 root mean square becomes about 0.071 / 5 * 2 (the value at
            // the end of a fitted line has twice the error of the mean). A plane across the step would be 0.5 off.
            assert!(error < 0.04, "pixel {pixel}: {error}");
        }
    }
}
