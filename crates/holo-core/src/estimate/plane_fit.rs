//! Edge-preserving smoothing: at every pixel a plane fit to the measurements around it that belong to the same surface.

#[cfg(test)]
mod naive;

use crate::base::parallel::*;

use super::cells::Cells;
use super::measure::Measurements;
use super::plane::Plane;
use crate::base::memory::filled;
use crate::{Error, GridSize};

/// The color difference from which on a pixel belongs to another surface, for colors from 0 to 1.
const COLOR: f32 = 0.2;
/// The same for squares of pixels: only what is plain needs them.
const PLAIN_COLOR: f32 = 0.1;
/// The largest side of squares, px: 2 to the power of this.
const DOUBLINGS: usize = 3;
/// The information, in 1/px^2, from which on only the nearest neighbors are used: a standard error of 0.01 px.
const ENOUGH: f32 = 10_000.0;
/// What squares of twice the side must have of the information: four times as much in a plain area, and less in a colorful
/// one, where few of them look like the pixel.
const WIDER: f32 = 3.0;
/// The largest distance of a neighbor from the surface, in standard errors of the neighborhood of the pixel.
const ERRORS: f32 = 8.5;
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
    /// another disparity since is not used. `coarse` has those of the coarser level, or none.
    pub(super) fn smooth(
        &self,
        size: GridSize,
        map: &[f32],
        found: &Measurements,
        before: &[Plane],
        coarse: &[Plane],
    ) -> Result<Vec<Plane>, Error> {
        let mut planes = filled("planes around pixels", map.len(), Plane::default())?;
        let neighbors = Neighbors::new(self, size, map, found, coarse)?;
        planes.par_iter_mut().with_min_len(size.columns).enumerate().for_each(|(pixel, plane)| {
            let before = before.get(pixel).filter(|plane| plane.here == map[pixel]);
            *plane = neighbors.plane_at(pixel / size.columns, pixel % size.columns, before);
        });
        Ok(planes)
    }
}

/// Neighbors in a row that are added at once.
const LANES: usize = 8;
type Lanes = [f32; LANES];

struct Neighbors<'a> {
    fit: &'a Fit,
    size: GridSize,
    found: &'a Measurements,
    channels: usize,
    /// Pixels, and squares of 2, 4 and 8 pixels a side.
    cells: Vec<Cells<'a>>,
    /// The weights of the distances, row by row of the square, and [`LANES`] more.
    near: Vec<f32>,
}

impl<'a> Neighbors<'a> {
    fn new(
        fit: &'a Fit,
        size: GridSize,
        map: &'a [f32],
        found: &'a Measurements,
        coarse: &[Plane],
    ) -> Result<Self, Error> {
        let mut cells = vec![Cells::pixels(size, map, found, coarse, fit.widest_px)?];
        for doubling in 0..DOUBLINGS {
            let doubled = cells[doubling].doubled()?;
            cells.push(doubled);
        }
        let side = 2 * fit.radius_px + 1;
        let from_center = |k: usize| (k as f32 - fit.radius_px as f32).powi(2);
        let per_square = 1.0 / ((fit.radius_px * fit.radius_px) as f32 * 0.75);
        let weight = |k: usize| 1.0 / (1.0 + (from_center(k / side) + from_center(k % side)) * per_square);
        let near = (0..side * side).map(weight).chain([0.0; LANES]);
        Ok(Self { fit, size, found, channels: found.image.len() / map.len(), cells, near: near.collect() })
    }

    fn plane_at(&self, row: usize, column: usize, before: Option<&Plane>) -> Plane {
        let here = self.cells[0].map[row * self.size.columns + column];
        let gate_px = self.gate_px(row, column);
        // The first gate is flat. The second follows the slope of the first fit, or of the round before.
        let flat = Plane { here, ..Plane::default() };
        let sloped = before.map_or_else(|| self.fitted(row, column, &flat, gate_px, &self.cells[0]), |plane| *plane);
        let mut plane = self.fitted(row, column, &sloped, gate_px, &self.cells[0]);
        for cells in &self.cells[1..] {
            if plane.information < ENOUGH {
                let wider = self.fitted(row, column, &plane, gate_px, cells);
                if wider.information > WIDER * plane.information {
                    plane = wider;
                }
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

    /// The least-squares plane through the neighbors among `cells`.
    fn fitted(&self, row: usize, column: usize, last: &Plane, gate_px: f32, cells: &Cells) -> Plane {
        let (GridSize { rows, columns }, side, radius) = (cells.size, cells.side, self.fit.radius_px);
        // Counted from the square of the pixel outward, so that it is always included.
        let (middle_row, middle_column) = (row / side, column / side);
        let (above, before) = (middle_row.min(radius), middle_column.min(radius));
        let (below, after) = ((rows - 1 - middle_row).min(radius), (columns - 1 - middle_column).min(radius));
        let (left, count) = (middle_column - before, before + 1 + after);
        // From the pixel to the middle of a square.
        let away = |cell: usize, place: usize| (cell * side) as f32 + 0.5 * (side - 1) as f32 - place as f32;
        let here = row * self.size.columns + column;
        let color: [f32; 3] =
            std::array::from_fn(|channel| self.found.image[channel.min(self.channels - 1) * self.size.count() + here]);
        let widest = if side == 1 { COLOR } else { PLAIN_COLOR };
        let per_square = 1.0 / (self.channels as f32 * widest * widest);
        let mut moments = LaneMoments::default();
        for step in 0..above + 1 + below {
            let other_row = middle_row + step - above;
            let y = away(other_row, row);
            let near = &self.near[(radius + step - above) * (2 * radius + 1) + radius - before..];
            for first in (0..count).step_by(LANES) {
                let taken = (count - first).min(LANES);
                let run = Run { first: other_row * columns + left + first, taken };
                let x: Lanes = std::array::from_fn(|lane| away(left + first + lane, column));
                let mut near = Run { first, taken }.of(near);
                for (lane, near) in near.iter_mut().enumerate() {
                    *near = if lane < taken { *near } else { 0.0 };
                }
                let so_far = run.of(&cells.map);
                let mut squares = [0.0; LANES];
                for (channel, plane) in cells.image.chunks_exact(cells.map.len()).enumerate() {
                    let other = run.of(plane);
                    for lane in 0..LANES {
                        squares[lane] += (other[lane] - color[channel]) * (other[lane] - color[channel]);
                    }
                }
                let mut weight = [0.0; LANES];
                for lane in 0..LANES {
                    let off = (so_far[lane] - last.here - last.by_row * y - last.by_column * x[lane]) / gate_px;
                    // Tukey's biweight: the weight is 0 beyond the gate. It is 0 in lanes that are not taken, as `near` is.
                    let same = (1.0 - off * off).max(0.0);
                    let alike = (1.0 - squares[lane] * per_square).max(0.0);
                    let factor = same * near[lane] * alike;
                    weight[lane] = factor * factor;
                }
                let own = [&cells.weights, &cells.information].map(|values| run.of(values));
                moments.add(&weight, &own, &x, y, &run.of(&cells.values), last.here);
            }
        }
        let mut plane = moments.sum().solve(radius * side);
        plane.here += last.here;
        plane
    }
}

/// The pixels of a row from `first` on, `taken` of them: up to [`LANES`].
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    taken: usize,
}

impl Run {
    /// The values of these pixels. Lanes that are not taken hold values of other pixels, or 0.
    #[inline]
    fn of(self, values: &[f32]) -> Lanes {
        let Self { first, taken } = self;
        match values[first..].first_chunk() {
            Some(run) => *run,
            None => std::array::from_fn(|lane| if lane < taken { values[first + lane] } else { 0.0 }),
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
    /// Adds values of a row relative to `base`, whose weights and information are `own` times those of the
    /// neighborhood.
    fn add(&mut self, weight: &Lanes, [own, information]: &[Lanes; 2], x: &Lanes, y: f32, values: &Lanes, base: f32) {
        for lane in 0..LANES {
            let w = weight[lane] * own[lane];
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
                moments.add(&in_lane(w), &[[1.0; LANES]; 2], &in_lane(x), y as f32, &in_lane(d), 0.0);
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
        let smoothed: Vec<f32> =
            fit.smooth(size, &map, &found, &[], &[]).unwrap().iter().map(|plane| plane.here).collect();
        for pixel in 0..400 {
            let error = (smoothed[pixel] - truth(pixel)).abs();
            // A corner has 25 neighbors: an error of 0.071 root mean square becomes about 0.071 / 5 * 2 (the value at
            // the end of a fitted line has twice the error of the mean). A plane across the step would be 0.5 off.
            assert!(error < 0.04, "pixel {pixel}: {error}");
        }
    }
}
