//! Edge-preserving smoothing: at every pixel a plane fit to the measurements around it that belong to the same surface.

use crate::parallel::*;

use super::measure::Measurements;
use crate::memory::filled;
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
    /// Returns the map of the fitted planes, and the information of every fit.
    pub(super) fn smooth(
        &self,
        size: GridSize,
        map: &[f32],
        found: &Measurements,
    ) -> Result<(Vec<f32>, Vec<f32>), Error> {
        let mut smoothed = filled("a disparity map", map.len(), 0.0)?;
        let mut information = filled("the information of a disparity map", map.len(), 0.0)?;
        let neighbors = Neighbors { fit: self, size, map, found, channels: found.image.len() / map.len() };
        smoothed.par_iter_mut().zip(information.par_iter_mut()).with_min_len(size.columns).enumerate().for_each(
            |(pixel, (smoothed, information))| {
                let plane = neighbors.plane_at(pixel / size.columns, pixel % size.columns);
                (*smoothed, *information) = (plane.here, plane.information);
            },
        );
        Ok((smoothed, information))
    }
}

/// Disparity as a linear function of the distance to a pixel.
#[derive(Debug, Clone, Copy)]
struct Plane {
    here: f32,
    by_row: f32,
    by_column: f32,
    information: f32,
}

struct Neighbors<'a> {
    fit: &'a Fit,
    size: GridSize,
    map: &'a [f32],
    found: &'a Measurements,
    channels: usize,
}

impl Neighbors<'_> {
    fn plane_at(&self, row: usize, column: usize) -> Plane {
        let here = self.map[row * self.size.columns + column];
        let gate_px = self.gate_px(row, column);
        // The first gate is flat. The second follows the slope of the first fit.
        let mut plane = Plane { here, by_row: 0.0, by_column: 0.0, information: 0.0 };
        for _ in 0..2 {
            plane = self.fitted(row, column, &plane, gate_px, 1);
        }
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
        let radius = self.fit.radius_px * stride;
        // Counted from the pixel outward, so that the pixel is always included.
        let top = row - row.min(radius) / stride * stride;
        let left = column - column.min(radius) / stride * stride;
        let (bottom, right) = ((row + radius).min(rows - 1), (column + radius).min(columns - 1));
        let center = row * columns + column;
        let per_square = 1.0 / ((radius * radius) as f32 * 0.75);
        let per_color = 1.0 / (self.channels as f32 * COLOR * COLOR);
        let mut moments = Moments::default();
        for other_row in (top..=bottom).step_by(stride) {
            let y = other_row as f32 - row as f32;
            for other_column in (left..=right).step_by(stride) {
                let x = other_column as f32 - column as f32;
                let other = other_row * columns + other_column;
                let so_far = self.map[other];
                let off = (so_far - last.here - last.by_row * y - last.by_column * x) / gate_px;
                // Tukey's biweight: the weight is 0 beyond the gate.
                let same = 1.0 - off * off;
                if same <= 0.0 {
                    continue;
                }
                let alike = 1.0 / (1.0 + self.color_distance(center, other) * per_color);
                let near = 1.0 / (1.0 + (x * x + y * y) * per_square);
                let weight = (same * alike * near) * (same * alike * near);
                let information = self.found.information[other];
                let value = (information * self.found.disparity_px[other] + PRIOR * so_far) / (information + PRIOR);
                moments.add(weight * (information + PRIOR), x, y, value - last.here);
                moments.information += weight * information;
            }
        }
        let mut plane = moments.solve(radius);
        plane.here += last.here;
        plane
    }

    fn color_distance(&self, one: usize, other: usize) -> f32 {
        let mut squares = 0.0;
        for channel in self.found.image.chunks_exact(self.map.len()).take(self.channels) {
            let difference = channel[one] - channel[other];
            squares += difference * difference;
        }
        squares
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
    fn add(&mut self, weight: f32, x: f32, y: f32, d: f32) {
        let (wx, wy, wd) = (weight * x, weight * y, weight * d);
        self.one += weight;
        self.x += wx;
        self.y += wy;
        self.xx += wx * x;
        self.xy += wx * y;
        self.yy += wy * y;
        self.d += wd;
        self.dx += wd * x;
        self.dy += wd * y;
    }

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
        let determinant = |m: [[f64; 3]; 3]| {
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        };
        let mut replaced = matrix;
        for row in 0..3 {
            replaced[row][0] = right[row];
        }
        determinant(replaced) / determinant(matrix)
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
            let mut moments = Moments::default();
            for &(w, x, y, d) in &points {
                moments.add(w as f32, x as f32, y as f32, d as f32);
            }
            let difference = f64::from(moments.solve(4).here) - naive_solve(&points, 4);
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
        let (smoothed, _) = fit.smooth(size, &map, &found).unwrap();
        for pixel in 0..400 {
            let error = (smoothed[pixel] - truth(pixel)).abs();
            // A corner has 25 neighbors: an error of 0.071 root mean square becomes about 0.071 / 5 * 2 (the value at
            // the end of a fitted line has twice the error of the mean). A plane across the step would be 0.5 off.
            assert!(error < 0.04, "pixel {pixel}: {error}");
        }
    }
}
