//! Cells: the samples of a few neighboring views behind one microlens, added up.
//!
//! Within a cell nothing moves by more than [`MAX_MOVEMENT_PX`], so its samples count as those of its middle view. Windows
//! are rectangles of cells, whose sums are differences of four sums from the first cell on (summed-area tables; Crow,
//! 1984), so that they cost the same at any size.

use std::mem;
use std::ops::Range;

use super::super::guides::{CHANNELS, SAMPLES, luminance};
use super::super::tint;
use super::Field;
use super::fit::{MAX_LEVER, Moments, Window};

/// The largest movement, px, of anything within a cell.
const MAX_MOVEMENT_PX: f32 = 0.1;

/// The largest movement, px, of a sample against the point between their views.
pub(super) const MAX_PARTING_PX: f32 = 0.25;

/// The largest side of a cell, in views.
const LARGEST: usize = 5;

/// The largest variance that is summed: squares of the largest radiance do not fit into f32.
pub(super) const MAX_VARIANCE: f32 = 1e24;

/// The values of [`Sums`].
const VALUES: usize = 12;

/// Sums over samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Of the color.
    pub color: [f32; 3],
    /// The variance of the sum of the luminance.
    pub variance: f32,
    /// The number of samples.
    pub weight: f32,
    /// Of the middle views of their cells, rows and columns, from that of the middle of all views.
    pub views: [f32; 2],
    /// Of the tint.
    pub tint: [f32; 3],
}

/// The cells of the views behind one microlens.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// The side of a cell, in views; those at the end may have fewer.
    pub size: usize,
    /// Rows and columns of cells.
    pub counts: [usize; 2],
    views: [usize; 2],
    /// The sums of all cells above and to the left of each corner of a cell.
    table: Vec<[f32; VALUES]>,
    /// The mean disparities of the pixels of the cells, with or without samples.
    pub disparities: Vec<f32>,
    /// The smallest and the largest of them.
    pub disparity_range: [f32; 2],
    /// Those of its pixels.
    pub pixel_range: [f32; 2],
    /// The light over the views.
    trend: Moments,
}

impl Sums {
    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        for c in 0..3 {
            self.color[c] += other.color[c];
            self.tint[c] += other.tint[c];
        }
        self.variance += other.variance;
        self.weight += other.weight;
        for axis in 0..2 {
            self.views[axis] += other.views[axis];
        }
    }

    /// The mean color and the variance of the mean luminance.
    #[inline(always)]
    pub fn means(&self) -> [f32; 4] {
        let scale = 1.0 / self.weight;
        let [r, g, b] = self.color;
        [r * scale, g * scale, b * scale, self.variance.max(0.0) * scale * scale]
    }
}

impl Cells {
    /// Finds those of a microlens, in place of others, whose memory it uses again.
    #[inline(always)]
    pub fn find(&mut self, field: &Field, v: usize, u: usize) {
        let [_, _, rows, columns] = field.grid.shape;
        let pixel_range = pixel_range(field, v, u);
        let size = size(field, pixel_range);
        let counts = [rows.div_ceil(size), columns.div_ceil(size)];
        let width = counts[1] + 1;
        let (mut table, mut disparities) = (mem::take(&mut self.table), mem::take(&mut self.disparities));
        table.clear();
        table.resize((counts[0] + 1) * width, [0.0; VALUES]);
        disparities.clear();
        disparities.resize(counts[0] * counts[1], 0.0);
        let mut out = Self {
            size,
            counts,
            views: [rows, columns],
            table,
            disparities,
            disparity_range: [f32::INFINITY, f32::NEG_INFINITY],
            pixel_range,
            trend: Moments::default(),
        };
        for t in 0..rows {
            let (colors, guides) = field.line(v, t);
            let (colors, guides) = (&colors[u * columns..][..columns], &guides[u * columns..][..columns]);
            let row = t / size;
            for k in 0..counts[1] {
                let cell = &mut out.table[(row + 1) * width + k + 1];
                let mut disparities = 0.0;
                for s in k * size..((k + 1) * size).min(columns) {
                    let [difference, disparity, weight, packed] = guides[s];
                    disparities += disparity;
                    if weight == 0.0 {
                        continue;
                    }
                    let of_mean =
                        if weight == 1.0 { single_variance(colors, guides, s) } else { difference * difference };
                    let [r, g, b] = colors[s];
                    cell[0] += r * weight;
                    cell[1] += g * weight;
                    cell[2] += b * weight;
                    cell[3] += weight * weight * of_mean.min(MAX_VARIANCE);
                    cell[4] += weight;
                    let tint = tint::unpack(packed);
                    for c in 0..3 {
                        cell[7 + c] += tint[c] * weight;
                    }
                }
                out.disparities[row * counts[1] + k] += disparities;
            }
        }
        for row in 0..counts[0] {
            let mut line = [0.0f32; VALUES];
            for column in 0..counts[1] {
                let [down, across] = out.extent([row, column]);
                let disparity = &mut out.disparities[row * counts[1] + column];
                *disparity /= (down * across) as f32;
                let [low, high] = out.disparity_range;
                out.disparity_range = if disparity.is_finite() {
                    [low.min(*disparity), high.max(*disparity)]
                } else {
                    [f32::NEG_INFINITY, f32::INFINITY]
                };
                let [y, x] = [out.to_middle(0, row), out.to_middle(1, column)];
                let mut cell = out.table[(row + 1) * width + column + 1];
                (cell[5], cell[6]) = (cell[4] * y, cell[4] * x);
                if cell[4] > 0.0 {
                    let values = sums(cell).means();
                    let window = Window { values, offset: [y, x], weight: cell[4], tint: [1.0; 3] };
                    out.trend.add(&window, [0.0; 2], 1.0);
                }
                let above = out.table[row * width + column + 1];
                for k in 0..VALUES {
                    line[k] += cell[k];
                    out.table[(row + 1) * width + column + 1][k] = above[k] + line[k];
                }
            }
        }
        *self = out;
    }

    /// Whether no view has samples.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.trend.weight() == 0.0
    }

    /// Whether there are fewer samples than views, so that some have none.
    #[inline(always)]
    pub fn is_sparse(&self) -> bool {
        self.trend.weight() < (self.views[0] * self.views[1]) as f32
    }

    /// The light at a view on the plane through all of them, and the variance of its luminance; where not all have samples,
    /// nothing far beside those.
    #[inline(always)]
    pub fn trend_at(&self, [t, s]: [usize; 2]) -> Window {
        let place = [0, 1].map(|axis| [t, s][axis] as f32 - self.views[axis] as f32 / 2.0);
        let plane = self.trend.plane_at(place);
        let weight = if self.is_sparse() && plane.lever > MAX_LEVER { 0.0 } else { plane.weight };
        Window { values: plane.values, offset: [0.0; 2], weight, tint: [1.0; 3] }
    }

    /// The sums of a rectangle of cells.
    #[inline(always)]
    pub fn sums(&self, rows: &Range<usize>, columns: &Range<usize>) -> Sums {
        let width = self.counts[1] + 1;
        let corner = |row: usize, column: usize| &self.table[row * width + column];
        let [a, b] = [corner(rows.start, columns.start), corner(rows.start, columns.end)];
        let [c, d] = [corner(rows.end, columns.start), corner(rows.end, columns.end)];
        let value = |k: usize| (d[k] - c[k]) - (b[k] - a[k]);
        // Numbers of samples are whole and exact; without any, rounding is what is left of the others.
        if value(4) == 0.0 { Sums::default() } else { sums(std::array::from_fn(value)) }
    }

    /// The sums of the cells around a view.
    #[inline(always)]
    pub fn sums_around(&self, [t, s]: [usize; 2]) -> Sums {
        let near = |axis: usize, view: usize| {
            let cell = view / self.size;
            cell.saturating_sub(1)..(cell + 2).min(self.counts[axis])
        };
        self.sums(&near(0, t), &near(1, s))
    }

    /// Whether nothing moves by half a pixel within `farthest` (in views times the movement per disparity), and all moves
    /// nearly alike.
    #[inline(always)]
    pub fn is_still(&self, farthest: f32) -> bool {
        let [low, high] = self.pixel_range;
        low.abs().max(high.abs()) * farthest < 0.5 && (high - low) * farthest <= MAX_PARTING_PX
    }

    /// The view in the middle of a cell along axis 0 (rows) or 1 (columns).
    #[inline(always)]
    pub fn middle(&self, axis: usize, k: usize) -> f32 {
        let (first, end) = (k * self.size, ((k + 1) * self.size).min(self.views[axis]));
        (first + end - 1) as f32 / 2.0
    }

    /// That view from the one in the middle of all.
    #[inline(always)]
    fn to_middle(&self, axis: usize, k: usize) -> f32 {
        self.middle(axis, k) - self.views[axis] as f32 / 2.0
    }

    /// The mean view of some samples from a view.
    #[inline(always)]
    pub fn away(&self, sums: &Sums, axis: usize, view: usize) -> f32 {
        sums.views[axis] / sums.weight - (view as f32 - self.views[axis] as f32 / 2.0)
    }

    /// The rows and columns of views of a cell.
    #[inline(always)]
    fn extent(&self, cell: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|axis| self.size.min(self.views[axis] - cell[axis] * self.size))
    }
}

/// The sums of these values of the table.
#[inline(always)]
fn sums([r, g, b, variance, weight, y, x, tint_r, tint_g, tint_b, ..]: [f32; VALUES]) -> Sums {
    let tint = [tint_r, tint_g, tint_b];
    Sums { color: [r, g, b], variance: variance.max(0.0), weight, views: [y, x], tint }
}

/// The variance of the luminance of pixel `s` of a row of views, which has a single sample: from the difference to its
/// neighbor, which sees nearly the same. Without one with samples, the square of the luminance.
#[inline(always)]
fn single_variance(colors: &[[f32; 3]], guides: &[[f32; CHANNELS]], s: usize) -> f32 {
    let own = luminance(colors[s]);
    // Pairs are neighbors of even and odd number, then any.
    for k in [s ^ 1, s + 1, s.wrapping_sub(1)] {
        if k < guides.len() && guides[k][SAMPLES] > 0.0 {
            let apart = own - luminance(colors[k]);
            // The variance of the partner's mean counts with it.
            return apart * apart * guides[k][SAMPLES] / (guides[k][SAMPLES] + 1.0);
        }
    }
    own * own
}

/// The smallest and the largest disparity of the pixels behind a microlens; infinite if one of them is not finite.
#[inline(always)]
fn pixel_range(field: &Field, v: usize, u: usize) -> [f32; 2] {
    let [_, _, rows, columns] = field.grid.shape;
    let (mut low, mut high, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0);
    for t in 0..rows {
        for guides in &field.line(v, t).1[u * columns..][..columns] {
            low = low.min(guides[1]);
            high = high.max(guides[1]);
            sum += guides[1];
        }
    }
    if f32::is_finite(sum) { [low, high] } else { [f32::NEG_INFINITY, f32::INFINITY] }
}

/// The side of the cells of a microlens whose pixels have disparities in this range.
#[inline(always)]
fn size(field: &Field, [low, high]: [f32; 2]) -> usize {
    let movement = low.abs().max(high.abs()) * field.grid.movement[0].max(field.grid.movement[1]);
    let size = MAX_MOVEMENT_PX / movement;
    if size >= 1.0 { (size as usize).min(LARGEST) } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The partner is the other pixel of the pair, else a neighbor with samples; its mean has a variance of its own.
    #[test]
    fn the_variance_of_one_sample_is_that_of_a_difference() {
        let colors = [9.0, 2.0, 5.0].map(|light| [light; 3]);
        for (samples, expected) in [
            ([1.0, 1.0, 1.0], 49.0 / 2.0),
            ([0.0, 1.0, 1.0], 9.0 / 2.0),
            ([0.0, 1.0, 3.0], 9.0 * 3.0 / 4.0),
            ([0.0, 1.0, 0.0], 4.0),
        ] {
            let guides = samples.map(|count| {
                let mut guides = [0.0; CHANNELS];
                guides[SAMPLES] = count;
                guides
            });
            let found = single_variance(&colors, &guides, 1);
            assert!((found / expected - 1.0).abs() < 1e-5, "{samples:?}: {found} for {expected}");
        }
    }
}
