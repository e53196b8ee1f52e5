//! The matching cost of every pixel on every plane.

#[cfg(test)]
mod naive;

use crate::base::parallel::*;

use super::views::{View, Views};

/// The color difference at which costs are truncated, for colors from 0 to 1.
const TRUNCATION: f32 = 0.04;

/// The integer cost of a truncated difference.
pub(crate) const WORST: f32 = 1000.0;
/// The cost, from 0 to 1, of a pixel that is outside all views.
const UNSEEN: f32 = 0.5;
/// Rows per tile: the sums of eight arms fit in the cache.
const TILE_ROWS: usize = 8;

/// The planes of a sweep: equally spaced disparities.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planes {
    pub(super) first_px: f32,
    pub(super) step_px: f32,
    pub(super) count: usize,
}

impl Planes {
    pub(super) fn disparity_px(&self, plane: f32) -> f32 {
        self.first_px + plane * self.step_px
    }
}

/// Computes the costs of the rows from `first_row` on.
///
/// # Shape
///
/// `costs` is row, column, plane; its length determines the number of rows.
pub(super) fn fill(views: &Views, planes: &Planes, first_row: usize, costs: &mut [u16]) {
    let columns = views.size.columns;
    costs.par_chunks_mut(TILE_ROWS * columns * planes.count).enumerate().for_each_init(
        Sums::default,
        |sums, (tile, costs)| {
            let rows = costs.len() / (columns * planes.count);
            fill_tile(views, planes, first_row + tile * TILE_ROWS, rows, sums, costs);
        },
    );
}

/// Sums of differences per arm, and the numbers of views in them; arm, row, column.
#[derive(Default)]
struct Sums {
    differences: Vec<f32>,
    counts: Vec<f32>,
    shifted: Vec<f32>,
    best: Vec<f32>,
}

fn fill_tile(views: &Views, planes: &Planes, first_row: usize, rows: usize, sums: &mut Sums, costs: &mut [u16]) {
    let columns = views.size.columns;
    // One extra row above and below for the 3 x 3 mean.
    let top = first_row.saturating_sub(1);
    let bottom = (first_row + rows + 1).min(views.size.rows);
    let tall = bottom - top;
    let area = tall * columns;
    sums.shifted.resize(views.channels * columns, 0.0);
    sums.best.resize(columns, 0.0);
    for plane in 0..planes.count {
        let disparity_px = planes.disparity_px(plane as f32);
        sums.differences.clear();
        sums.differences.resize(8 * area, 0.0);
        sums.counts.clear();
        sums.counts.resize(8 * area, 0.0);
        for view in &views.others {
            let shift = Shift::new(view, disparity_px, views);
            let arm = view.arm * area;
            for row in top.max(shift.rows.0)..bottom.min(shift.rows.1) {
                let start = arm + (row - top) * columns;
                let differences = &mut sums.differences[start..start + columns];
                shift.add(views, view, row, &mut sums.shifted, differences, &mut sums.counts[start..start + columns]);
            }
        }
        for arm in 0..8 {
            let range = arm * area..(arm + 1) * area;
            box_sum_columns(&mut sums.differences[range.clone()], columns);
            box_sum_columns(&mut sums.counts[range], columns);
        }
        for row in 0..rows {
            let here = first_row + row - top;
            let above = here.saturating_sub(1);
            let below = (here + 1).min(tall - 1);
            best_half(&sums.differences, &sums.counts, area, columns, [above, here, below], &mut sums.best);
            let costs = &mut costs[row * columns * planes.count..(row + 1) * columns * planes.count];
            for (cost, &best) in costs.iter_mut().skip(plane).step_by(planes.count).zip(&sums.best) {
                *cost = (best * WORST + 0.5) as u16;
            }
        }
    }
}

/// The shift of a view on one plane: the same four interpolation weights for all pixels.
struct Shift {
    /// Rows of the central view that are within the shifted view, first and end.
    rows: (usize, usize),
    columns: (usize, usize),
    down: isize,
    right: isize,
    weights: [f32; 4],
    /// The factor that makes differences of noise as large on every plane: an interpolated pixel has less of it than a whole
    /// one, and planes on which many views are interpolated would be chosen wherever nothing else decides.
    evenness: f32,
}

impl Shift {
    fn new(view: &View, disparity_px: f32, views: &Views) -> Self {
        let (down, down_part) = whole_and_fraction(-disparity_px * view.down);
        let (right, right_part) = whole_and_fraction(-disparity_px * view.right);
        let range = |shift: isize, part: f32, count: usize| {
            let needs_next = isize::from(part > 0.0);
            let first = (-shift).clamp(0, count as isize);
            let end = (count as isize - shift - needs_next).clamp(first, count as isize);
            (first as usize, end as usize)
        };
        let weights = [
            (1.0 - down_part) * (1.0 - right_part),
            (1.0 - down_part) * right_part,
            down_part * (1.0 - right_part),
            down_part * right_part,
        ];
        // The variances of the central view and of the interpolated one, for 1 a pixel.
        let variance = 1.0 + weights.iter().map(|weight| weight * weight).sum::<f32>();
        Self {
            rows: range(down, down_part, views.size.rows),
            columns: range(right, right_part, views.size.columns),
            down,
            right,
            weights,
            evenness: (2.0 / variance).sqrt(),
        }
    }

    /// Adds the truncated differences of one row.
    fn add(
        &self,
        views: &Views,
        view: &View,
        row: usize,
        shifted: &mut [f32],
        differences: &mut [f32],
        counts: &mut [f32],
    ) {
        let (first, end) = self.columns;
        if first == end {
            return;
        }
        let columns = views.size.columns;
        let width = end - first;
        let shifted = &mut shifted[..width];
        shifted.fill(0.0);
        let source_row = row.wrapping_add_signed(self.down);
        let source_column = first.wrapping_add_signed(self.right);
        let [w00, w01, w10, w11] = self.weights;
        for channel in 0..views.channels {
            let plane = channel * views.pixels();
            let start = plane + source_row * columns + source_column;
            // Where a weight is 0 the neighbor may not exist. The pixel itself then takes its place.
            let next_column = usize::from(w01 + w11 > 0.0);
            let next_row = if w10 + w11 > 0.0 { columns } else { 0 };
            let a = &view.samples[start..start + width];
            let b = &view.samples[start + next_column..start + next_column + width];
            let c = &view.samples[start + next_row..start + next_row + width];
            let d = &view.samples[start + next_row + next_column..start + next_row + next_column + width];
            let center = &views.center[plane + row * columns + first..plane + row * columns + end];
            for column in 0..width {
                let value = w00 * a[column] + w01 * b[column] + w10 * c[column] + w11 * d[column];
                shifted[column] += (value - center[column]).abs();
            }
        }
        let scale = self.evenness / (views.channels as f32 * TRUNCATION);
        for ((sum, count), shifted) in differences[first..end].iter_mut().zip(&mut counts[first..end]).zip(shifted) {
            *sum += (*shifted * scale).min(1.0);
            *count += 1.0;
        }
    }
}

/// The whole and the fractional part of a shift. Fractions within 1e-4 of a whole number become exactly 0.
fn whole_and_fraction(shift: f32) -> (isize, f32) {
    let whole = shift.floor();
    let part = shift - whole;
    if part < 1e-4 {
        (whole as isize, 0.0)
    } else if part > 1.0 - 1e-4 {
        (whole as isize + 1, 0.0)
    } else {
        (whole as isize, part)
    }
}

/// Sums of three neighbors along every row, with the border pixels repeated.
fn box_sum_columns(values: &mut [f32], columns: usize) {
    for row in values.chunks_exact_mut(columns) {
        let mut left = row[0];
        for column in 0..columns {
            let here = row[column];
            let right = if column + 1 < columns { row[column + 1] } else { here };
            row[column] = left + here + right;
            left = here;
        }
    }
}

/// The mean difference over the half of the star with the lowest mean.
///
/// An occluder hides a point from one side. The best run of five adjacent arms out of eight is taken to see the point.
fn best_half(differences: &[f32], counts: &[f32], area: usize, columns: usize, rows: [usize; 3], best: &mut [f32]) {
    const BLOCK: usize = 16;
    for start in (0..columns).step_by(BLOCK) {
        let width = BLOCK.min(columns - start);
        let mut sums = [[0.0_f32; BLOCK]; 8];
        let mut numbers = [[0.0_f32; BLOCK]; 8];
        for arm in 0..8 {
            for row in rows {
                let offset = arm * area + row * columns + start;
                for lane in 0..width {
                    sums[arm][lane] += differences[offset + lane];
                    numbers[arm][lane] += counts[offset + lane];
                }
            }
        }
        let mut all = [0.0_f32; BLOCK];
        for numbers in &numbers {
            for lane in 0..BLOCK {
                all[lane] += numbers[lane];
            }
        }
        let mut least = [f32::INFINITY; BLOCK];
        for arm in 0..8 {
            let mut sum = [0.0_f32; BLOCK];
            let mut number = [0.0_f32; BLOCK];
            for other in [arm + 6, arm + 7, arm, arm + 1, arm + 2] {
                for lane in 0..BLOCK {
                    sum[lane] += sums[other % 8][lane];
                    number[lane] += numbers[other % 8][lane];
                }
            }
            for lane in 0..BLOCK {
                // A half in which nearly all views are outside the image is excluded.
                let mean =
                    if number[lane] * 3.0 >= all[lane] { sum[lane] / number[lane].max(1e-6) } else { f32::INFINITY };
                least[lane] = least[lane].min(mean);
            }
        }
        for lane in 0..width {
            best[start + lane] = if all[lane] > 0.0 { least[lane].min(1.0) } else { UNSEEN };
        }
    }
}
