//! The pdf of environment map sampling: constant in each cell of a grid over the image.
//!
//! The weight of a cell is the mean luminance of the bilinear image over it, times its solid angle. The mean is the
//! exact integral, so a cell has weight 0 only if the image is black there. Sampling selects a row by its share of the
//! whole, then a cell by its share of the row, then a point in the cell that is uniform in u and in the height above
//! the equator, hence in solid angle.
//!
//! Random numbers have 24 bits, so all probabilities are integer multiples (steps) of 2^-24. Every cell with a weight
//! above 0 gets at least one step (taken from the most probable cell), the others are rounded, and the pdf is computed
//! from the steps. No direction with radiance is ever excluded, and the pdf is exact for maps of any size and contrast;
//! prefix sums in f32 would lose dark regions beside the sun. Rows next to the poles get few steps, so their pdf
//! deviates from proportionality by up to half a step (5 % in the outermost of 2048 rows, 1 % in the fourth).

use rayon::prelude::*;

use crate::sampling::Points;
use crate::simd::LANES;
use crate::simd::angles::versine;

/// The maximum number of cells. Two cells per texel and axis approximate the bilinear image well; more would not fit
/// into the cache.
const MAX_COLUMNS: usize = 4096;
/// Even, so that no row of cells crosses the equator.
const MAX_ROWS: usize = 2048;

/// The total probability in steps; a random number is an integer number of steps.
const STEPS: u32 = 1 << 24;

pub(super) struct Cells {
    columns: usize,
    rows: usize,
    cell_rows: Vec<CellRow>,
    /// The start of the probability interval of every row, in steps, and the end of the last.
    row_starts: Vec<u32>,
    /// The same for the cells of every row: `columns + 1` entries per row.
    column_starts: Vec<u32>,
    black: bool,
}

/// A row of cells. Heights are versines, 1 - cos(angle from the nearer pole), which are accurate near the poles.
#[derive(Clone, Copy)]
struct CellRow {
    /// The versine of its upper edge.
    upper: f32,
    /// The versine of its lower edge.
    lower: f32,
    /// 1 if the upper pole is nearer, -1 otherwise.
    pole: f32,
    /// The pdf, per steradian, of a cell with a probability of one step within the row.
    unit_pdf: f32,
}

/// Sixteen sampled points of the image.
pub(super) struct CellSample {
    /// Distance from the left edge of the image, 0 to 1.
    pub u: [f32; LANES],
    /// 1 - cos(angle from the pole `pole`).
    pub versine: [f32; LANES],
    /// 1 for the upper pole, -1 for the lower.
    pub pole: [f32; LANES],
    /// The pdf per steradian.
    pub pdf: [f32; LANES],
}

impl Cells {
    pub fn build(texel_columns: usize, texel_rows: usize, texels: &[[f32; 3]]) -> Self {
        let (columns, rows) = ((2 * texel_columns).min(MAX_COLUMNS), (2 * texel_rows).min(MAX_ROWS));
        let across: Vec<Footprint> = (0..columns).map(|k| Footprint::of(k, columns, texel_columns)).collect();
        let mut column_starts = vec![0; rows * (columns + 1)];
        let means: Vec<f64> = column_starts
            .par_chunks_mut(columns + 1)
            .enumerate()
            .map(|(row, starts)| {
                let mut line = vec![0.0; texel_columns];
                let down = Footprint::of(row, rows, texel_rows);
                for (offset, weight) in down.weights.iter().enumerate() {
                    let texel_row = (down.first + offset as i64).clamp(0, texel_rows as i64 - 1) as usize;
                    for (sum, texel) in line.iter_mut().zip(&texels[texel_row * texel_columns..]) {
                        *sum += weight * luminance(*texel);
                    }
                }
                let weights: Vec<f64> = across.iter().map(|footprint| footprint.periodic_sum(&line)).collect();
                share_out(&weights, starts);
                weights.iter().sum::<f64>() / columns as f64
            })
            .collect();

        let heights = |row: usize| {
            let from_pole = |edge: usize| versine(std::f64::consts::PI * edge as f64 / rows as f64);
            if 2 * row < rows {
                (from_pole(row), from_pole(row + 1), 1.0)
            } else {
                (from_pole(rows - row), from_pole(rows - row - 1), -1.0)
            }
        };
        let weights: Vec<f64> = means
            .iter()
            .enumerate()
            .map(|(row, mean)| {
                let (upper, lower, _) = heights(row);
                mean * (upper - lower).abs()
            })
            .collect();
        let mut row_starts = vec![0; rows + 1];
        share_out(&weights, &mut row_starts);
        let black = !weights.iter().any(|&w| w > 0.0);
        let cell_rows = (0..rows)
            .map(|row| {
                let (upper, lower, pole) = heights(row);
                let steps = if black { 0 } else { row_starts[row + 1] - row_starts[row] };
                let probability = f64::from(steps) / f64::from(STEPS) / f64::from(STEPS);
                let solid_angle = std::f64::consts::TAU * (upper - lower).abs() / columns as f64;
                let unit_pdf = (probability / solid_angle) as f32;
                CellRow { upper: upper as f32, lower: lower as f32, pole, unit_pdf }
            })
            .collect();
        Self { columns, rows, cell_rows, row_starts, column_starts, black }
    }

    pub fn is_black(&self) -> bool {
        self.black
    }

    /// The pdf at points (u, v) of the image, per steradian.
    #[inline(always)]
    pub fn pdf(&self, [u, v]: &Points) -> [f32; LANES] {
        let mut cell = [0; LANES];
        let mut row = [0; LANES];
        for lane in 0..LANES {
            let column = ((u[lane] * self.columns as f32) as u32).min(self.columns as u32 - 1);
            row[lane] = ((v[lane] * self.rows as f32) as u32).min(self.rows as u32 - 1);
            cell[lane] = row[lane] * (self.columns as u32 + 1) + column;
        }
        self.pdfs(&row, &cell)
    }

    /// Samples one point per lane.
    #[inline(always)]
    pub fn sample(&self, [across, down]: &Points) -> CellSample {
        let (wanted_row, wanted_column) = (steps(down), steps(across));
        let row = search(&self.row_starts, &[0; LANES], self.rows, &wanted_row);
        let mut first = [0; LANES];
        for lane in 0..LANES {
            first[lane] = row[lane] * (self.columns as u32 + 1);
        }
        let cell = search(&self.column_starts, &first, self.columns, &wanted_column);
        let within_row = within(&self.row_starts, &row, &wanted_row);
        let within_cell = within(&self.column_starts, &cell, &wanted_column);
        let mut out =
            CellSample { u: [0.0; LANES], versine: [0.0; LANES], pole: [0.0; LANES], pdf: self.pdfs(&row, &cell) };
        let mut edges = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let cell_row = &self.cell_rows[row[lane] as usize];
            edges[0][lane] = cell_row.upper;
            edges[1][lane] = cell_row.lower;
            out.pole[lane] = cell_row.pole;
        }
        let inverse = 1.0 / self.columns as f32;
        for lane in 0..LANES {
            out.u[lane] = ((cell[lane] - first[lane]) as f32 + within_cell[lane]) * inverse;
            out.versine[lane] = edges[0][lane] + (edges[1][lane] - edges[0][lane]) * within_row[lane];
        }
        out
    }

    #[inline(always)]
    fn pdfs(&self, row: &[u32; LANES], cell: &[u32; LANES]) -> [f32; LANES] {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            let k = cell[lane] as usize;
            let width = self.column_starts[k + 1] - self.column_starts[k];
            out[lane] = width as f32 * self.cell_rows[row[lane] as usize].unit_pdf;
        }
        out
    }
}

/// Random numbers in integer steps.
#[inline(always)]
fn steps(numbers: &[f32; LANES]) -> [u32; LANES] {
    let mut out = [0; LANES];
    for lane in 0..LANES {
        out[lane] = ((numbers[lane] * STEPS as f32) as u32).min(STEPS - 1);
    }
    out
}

/// Per lane the last of the `count` entries from `first` on that is at most `wanted`.
#[inline(always)]
fn search(starts: &[u32], first: &[u32; LANES], count: usize, wanted: &[u32; LANES]) -> [u32; LANES] {
    let mut found = *first;
    let mut size = count;
    while size > 1 {
        let half = size / 2;
        for lane in 0..LANES {
            // As a product: a branch would be mispredicted half of the time.
            let beyond = starts[found[lane] as usize + half] <= wanted[lane];
            found[lane] += half as u32 * u32::from(beyond);
        }
        size -= half;
    }
    found
}

/// The relative position of the steps in their intervals, strictly between 0 and 1, at the middle of the step.
#[inline(always)]
fn within(starts: &[u32], interval: &[u32; LANES], wanted: &[u32; LANES]) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let k = interval[lane] as usize;
        let (start, end) = (starts[k], starts[k + 1]);
        out[lane] = ((wanted[lane] - start) as f32 + 0.5) / (end - start) as f32;
    }
    // (2^24 - 1/2) / 2^24 is rounded up to 1.
    for lane in 0..LANES {
        out[lane] = out[lane].min(1.0 - f32::EPSILON / 2.0);
    }
    out
}

/// Luminance, Rec. 709. Every coefficient is above 0, so that light of any color is sampled.
fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// Distributes all steps in proportion to `weights`; every weight above 0 gets at least one step. `starts` has one more
/// entry than `weights`. If all weights are 0 the last one gets all steps.
fn share_out(weights: &[f64], starts: &mut [u32]) {
    let total: f64 = weights.iter().sum();
    let (mut sum, mut before, mut lacking, mut widest) = (0.0, 0, 0, 0);
    for (k, &weight) in weights.iter().enumerate() {
        sum += weight;
        // The same sum in the same order as `total`, so that the last interval ends exactly at STEPS.
        let end = if total > 0.0 { (sum / total * f64::from(STEPS)).round() as u32 } else { 0 };
        let missing = u32::from(weight > 0.0 && end == before);
        starts[k + 1] = end - before + missing;
        lacking += missing;
        before = end;
        if starts[k + 1] > starts[widest + 1] {
            widest = k;
        }
    }
    // Of n weights, m lack a step. The largest has at least 2^24 / (n - m) steps, and m (n - m) <= n^2 / 4 is at most
    // 2^22 for the 4096 cells of a row.
    starts[widest + 1] -= lacking;
    starts[0] = 0;
    for k in 1..starts.len() {
        starts[k] += starts[k - 1];
    }
    if let Some(last) = starts.last_mut() {
        *last = STEPS;
    }
}

/// The weights of the texels along one axis in the mean of the bilinear image over a cell.
struct Footprint {
    /// The first texel, possibly outside the image.
    first: i64,
    /// The weights of this and the following texels; their sum is 1.
    weights: Vec<f64>,
}

impl Footprint {
    /// The footprint of cell `k` of `cells` over `texels`.
    fn of(k: usize, cells: usize, texels: usize) -> Self {
        let size = texels as f64 / cells as f64;
        let (low, high) = (k as f64 * size, (k + 1) as f64 * size);
        // Texel i has its center at i + 1/2 and a tent filter of width 2.
        let (first, last) = ((low - 0.5).floor(), (high + 0.5).floor());
        let weight = |i: i64| {
            let center = i as f64 + 0.5;
            let share = (tent_integral(high - center) - tent_integral(low - center)) / size;
            // Rounding errors are set to 0.
            if share > 1e-12 { share } else { 0.0 }
        };
        Self { first: first as i64, weights: (first as i64..=last as i64).map(weight).collect() }
    }

    /// The weighted sum over a periodic line.
    fn periodic_sum(&self, line: &[f64]) -> f64 {
        let texel = |offset: usize| line[(self.first + offset as i64).rem_euclid(line.len() as i64) as usize];
        self.weights.iter().enumerate().map(|(offset, weight)| weight * texel(offset)).sum()
    }
}

/// The integral of max(0, 1 - |t|) up to `t`.
fn tent_integral(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    if t < 0.0 { 0.5 * (1.0 + t) * (1.0 + t) } else { 1.0 - 0.5 * (1.0 - t) * (1.0 - t) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn widths(weights: &[f64]) -> Vec<u32> {
        let mut starts = vec![0; weights.len() + 1];
        share_out(weights, &mut starts);
        assert_eq!((starts[0], starts[weights.len()]), (0, STEPS));
        starts.windows(2).map(|w| w[1] - w[0]).collect()
    }

    #[test]
    fn shares_are_proportional_to_a_step() {
        let weights: Vec<f64> = (0..1000).map(|k| f64::from(k * 7919 % 1000)).collect();
        let total: f64 = weights.iter().sum();
        for (width, weight) in widths(&weights).iter().zip(&weights) {
            // Two roundings by half a step.
            assert!((f64::from(*width) - weight / total * f64::from(STEPS)).abs() <= 1.0);
            assert_eq!(*width == 0, *weight == 0.0);
        }
    }

    #[test]
    fn every_positive_weight_gets_a_step() {
        let mut weights = vec![1e-30; MAX_COLUMNS];
        weights[1234] = 1e30;
        weights[7] = 0.0;
        let widths = widths(&weights);
        assert_eq!(widths[1234], STEPS - MAX_COLUMNS as u32 + 2);
        assert_eq!(widths.iter().filter(|&&w| w == 1).count(), MAX_COLUMNS - 2);
        assert_eq!(widths[7], 0);
        // The worst case: half of the cells lack a step, the others are equal.
        let half: Vec<f64> = (0..MAX_COLUMNS).map(|k| if k % 2 == 0 { 1.0 } else { 1e-20 }).collect();
        assert!(self::widths(&half).iter().all(|&w| w >= 1));
    }

    /// Compared with the bilinear function, summed over a thousand points per cell: the midpoint rule has an error
    /// below 1e-6 here, at the kinks of the function.
    #[test]
    fn footprints_are_means_of_the_bilinear_function() {
        let line = [3.0, 0.0, 1.0, 7.0, 2.0];
        for cells in [1, 2, 3, 5, 7, 10] {
            for k in 0..cells {
                let expected: f64 = (0..1000)
                    .map(|i| {
                        let x = (k as f64 + (f64::from(i) + 0.5) / 1000.0) / cells as f64 * 5.0 - 0.5;
                        let texel = |i: f64| line[(i as i64).rem_euclid(5) as usize];
                        let (whole, fraction) = (x.floor(), x - x.floor());
                        (texel(whole) * (1.0 - fraction) + texel(whole + 1.0) * fraction) / 1000.0
                    })
                    .sum();
                let mean = Footprint::of(k, cells, 5).periodic_sum(&line);
                assert!((mean - expected).abs() < 1e-5, "cell {k} of {cells}: {mean} {expected}");
            }
        }
    }
}
