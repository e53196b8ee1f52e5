//! Reconstruction across views: the noise of a light field from the samples of neighboring views.
//!
//! Adjacent views see nearly the same image. Behind one microlens, views that are k apart see spots of the scene that
//! are k disparities apart, in pixels; at 100 x 100 views of an 8K sensor that is a hundredth of a pixel for adjacent
//! views. So every pixel becomes a mean over a window of views: of the same microlens where nothing moves by more than
//! 0.15 px within the radius of the window, else of the microlenses along the disparity of the pixel ([`gather`]).
//! Among nested windows up to 41 x 41 views, [`choice`] takes the largest one that no smaller one contradicts, per
//! microlens and block of views. With more samples, differences that noise used to hide count, and windows shrink.
//! Views at the border have windows that lie to one side of them.
//!
//! # Bias
//! A mean over views is biased where the views differ: by the movement within the window (up to 0.2 px, twice the 0.15 px
//! for windows to one side), by reflections and refractions, which have disparities of their own, and by light that
//! depends on the direction. The bias that the choice allows is of the order of the noise that remains, and it vanishes
//! as the samples grow. The estimated error contains it where it is significant.
//!
//! # Determinism
//! A pixel depends on the samples of at most [`HALO`] lens rows above and below it, so parts of a light field that are
//! rendered with that margin have the same bytes.

mod choice;
mod gather;
pub(crate) mod lattice;
mod windows;

use std::collections::VecDeque;
use std::ops::Range;

use rayon::prelude::*;

use self::choice::{Choice, Evidence, LENSES};
use self::gather::{GATHER_LEVELS, GATHERED_VIEWS, gather};
use self::windows::{BoxMean, LEVELS, Planes, Radii, Sums, VALUES, move_windows};
use super::error_distribution::ErrorDistribution;
use super::guides::{CHANNELS, luminance};
use crate::simd;

/// The largest movement, px, of anything within the window of one microlens.
const MAX_MOVEMENT_PX: f32 = 0.15;

/// The largest radius of a window of one microlens, in views. At 100 x 100 views of the 8K sensor most scenes move slowly
/// enough for it; with twice the radius the error falls where the center sees diffuse surfaces, and grows in the corners,
/// whose windows lie to one side.
const LARGEST_RADIUS: usize = 20;

/// The smallest radius, in views, within which nothing may move by more than that; where anything does, windows follow the
/// disparity to other microlenses.
const SMALLEST_RADIUS: usize = 4;

/// The largest distance, in microlenses along an axis, of a sample that a pixel gathers.
const REACH: usize = 4;

/// Neighboring microlenses on each side whose choices are averaged.
const SMOOTHED: usize = 1;

/// The number of lens rows above and below a pixel on which it depends.
pub(crate) const HALO: usize = SMOOTHED + LENSES + REACH;

/// The approximate size of blocks, in views, that choose together.
const BLOCK: usize = 8;

/// A light field, in the layout of the elemental image array.
pub(crate) struct Reconstruction<'a> {
    /// Lens rows and columns, view rows and columns.
    pub shape: [usize; 4],
    /// Color, 3 channels; reconstructed in place if it is to be replaced.
    pub color: &'a mut [f32],
    /// The guides of [`super::guides`].
    pub guides: &'a mut [f32],
    /// Movement between vertically and between horizontally adjacent views, in multiples of the disparity.
    pub movement: [f32; 2],
    /// Samples per pixel.
    pub samples: u32,
    /// Whether the error is that of reconstructed color; otherwise that of the samples, which then stay.
    pub filters: bool,
    /// Whether color is replaced; otherwise only its error is estimated.
    pub replaces: bool,
    /// The lens rows to reconstruct; the others are only read.
    pub rows: Range<usize>,
    /// The estimated relative error of every pixel, if wanted.
    pub error: Option<&'a mut [f32]>,
}

/// The samples as they were rendered.
struct Field<'a> {
    shape: [usize; 4],
    movement: [f32; 2],
    /// Color by lens row.
    rows: Vec<&'a [f32]>,
    guides: &'a [f32],
}

/// The windows of a microlens.
#[derive(Clone, Copy)]
struct Lens {
    radii: Radii,
    /// Whether windows follow the disparity to other microlenses.
    gathers: bool,
}

impl Lens {
    /// The number of windows, from the view itself to the largest one.
    fn levels(&self) -> usize {
        if self.gathers { GATHER_LEVELS } else { self.radii.count() }
    }

    /// About how many views the windows of a view have.
    fn window_views(&self, views: [usize; 2]) -> [f64; LEVELS] {
        if self.gathers {
            return GATHERED_VIEWS;
        }
        std::array::from_fn(|level| {
            let [rows, columns] = views.map(|count| self.radii.window(level, count / 2, count).len());
            (rows * columns) as f64
        })
    }
}

/// Blocks of views along the two axes.
#[derive(Clone, Copy)]
struct Blocks {
    views: [usize; 2],
    counts: [usize; 2],
}

/// Memory of a thread.
#[derive(Default)]
struct Scratch {
    sums: Sums,
    means: [Planes; LEVELS],
}

impl Field<'_> {
    /// Color and guides of all pixels of lens row `v` in view row `t`.
    #[inline(always)]
    fn line(&self, v: usize, t: usize) -> (&[[f32; 3]], &[[f32; CHANNELS]]) {
        let [_, lens_columns, view_rows, view_columns] = self.shape;
        let width = lens_columns * view_columns;
        let colors = self.rows[v][t * width * 3..(t + 1) * width * 3].as_chunks().0;
        let guides = &self.guides[(v * view_rows + t) * width * CHANNELS..][..width * CHANNELS];
        (colors, guides.as_chunks().0)
    }

    #[inline(always)]
    fn color(&self, v: usize, u: usize, t: usize, s: usize) -> [f32; 3] {
        self.line(v, t).0[u * self.shape[3] + s]
    }

    #[inline(always)]
    fn guides(&self, v: usize, u: usize, t: usize, s: usize) -> [f32; CHANNELS] {
        self.line(v, t).1[u * self.shape[3] + s]
    }

    /// The means over the windows of `level` of a microlens, for all views.
    fn box_means(&self, [v, u]: [usize; 2], lens: &Lens, levels: impl Iterator<Item = usize>, scratch: &mut Scratch) {
        let [_, _, view_rows, view_columns] = self.shape;
        let [source, means @ ..] = &mut scratch.means;
        source.iter_mut().for_each(Vec::clear);
        for t in 0..view_rows {
            for s in 0..view_columns {
                let ([r, g, b], [difference, _]) = (self.color(v, u, t, s), self.guides(v, u, t, s));
                for (plane, value) in source.iter_mut().zip([r, g, b, difference]) {
                    plane.push(value);
                }
            }
        }
        let (views, radii) = ([view_rows, view_columns], &lens.radii);
        for level in levels.filter(|&level| level > 0) {
            let (smaller, larger) = means.split_at_mut(level - 1);
            match smaller.last() {
                Some(ended) if radii.is_moved(level) => move_windows(ended, views, radii, level, &mut larger[0]),
                _ => {
                    simd::run(BoxMean { source, views, radii, level, scratch: &mut scratch.sums, out: &mut larger[0] })
                }
            }
        }
    }

    /// The evidence of all blocks of views of a microlens, from about every second row and column of views.
    fn evidence(&self, [v, u]: [usize; 2], lens: &Lens, blocks: &Blocks, scratch: &mut Scratch) -> Vec<Evidence> {
        let [_, _, view_rows, view_columns] = self.shape;
        let levels = lens.levels();
        if !lens.gathers {
            self.box_means([v, u], lens, 0..levels, scratch);
        }
        let mut out = vec![Evidence::new(levels); blocks.count()];
        for t in sampled(view_rows) {
            for s in sampled(view_columns) {
                let (mut bright, mut difference) = ([0.0; LEVELS], [0.0; LEVELS]);
                let gathered = lens.gathers.then(|| gather(self, [v, u, t, s], levels - 1));
                for level in 0..levels {
                    let [r, g, b, d] = match &gathered {
                        Some(means) => means[level],
                        None => std::array::from_fn(|k| scratch.means[level][k][t * view_columns + s]),
                    };
                    (bright[level], difference[level]) = (luminance([r, g, b]), d);
                }
                out[blocks.of([t, s])].add(&bright, &difference);
            }
        }
        out
    }
}

/// Every second view of an axis, the first and the last among them: their windows are moved the most.
fn sampled(count: usize) -> impl Iterator<Item = usize> + Clone {
    let half = count.div_ceil(2);
    (0..half).step_by(2).chain((half..count).rev().step_by(2))
}

impl Blocks {
    fn new(views: [usize; 2]) -> Self {
        Self { views, counts: views.map(|count| count.div_ceil(BLOCK)) }
    }

    fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// The block of a view.
    fn of(&self, view: [usize; 2]) -> usize {
        let [row, column] = [0, 1].map(|k| view[k] * self.counts[k] / self.views[k]);
        row * self.counts[1] + column
    }

    /// The average number of views of a block.
    fn size(&self) -> f64 {
        (self.views[0] * self.views[1]) as f64 / self.count() as f64
    }

    /// Interpolates linearly between the centers of the blocks along one axis: the lower block, and the weight of the
    /// upper one.
    fn between(&self, axis: usize, view: usize) -> (usize, f32) {
        let place = (view as f32 + 0.5) * self.counts[axis] as f32 / self.views[axis] as f32 - 0.5;
        let last = self.counts[axis] - 1;
        let place = place.clamp(0.0, last as f32);
        let lower = (place as usize).min(last.saturating_sub(1));
        (lower, place - lower as f32)
    }

    /// Interpolates the choices of a microlens at a view.
    fn interpolate(&self, choices: &[Choice], [t, s]: [usize; 2]) -> Choice {
        let ((top, down), (left, across)) = (self.between(0, t), self.between(1, s));
        let mut out = Choice::default();
        for (row, row_weight) in [(top, 1.0 - down), (top + 1, down)] {
            for (column, column_weight) in [(left, 1.0 - across), (left + 1, across)] {
                let weight = row_weight * column_weight;
                if weight > 0.0 {
                    let choice = choices[row * self.counts[1] + column];
                    out.level += choice.level * weight;
                    out.error += choice.error * weight;
                }
            }
        }
        out
    }
}

impl Reconstruction<'_> {
    /// Reconstructs; returns the distribution of the error. `advance` is called after every lens row and returns whether
    /// to go on.
    pub fn run(mut self, advance: impl Fn() -> bool) -> ErrorDistribution {
        let [lens_rows, lens_columns, view_rows, view_columns] = self.shape;
        if self.samples == 1 {
            self.differences_between_views();
        }
        let row_length = view_rows * lens_columns * view_columns;
        let lenses = self.lenses();
        let blocks = Blocks::new([view_rows, view_columns]);
        let mut originals = VecDeque::<Vec<f32>>::new();
        let mut evidence = VecDeque::<(usize, Vec<Vec<Evidence>>)>::new();
        let mut choices = VecDeque::<(usize, Vec<Vec<Choice>>)>::new();
        let mut distribution = ErrorDistribution::default();
        for v in self.rows.clone() {
            let (done, rest) = self.color.split_at(v * row_length * 3);
            let first_original = v - originals.len();
            let mut rows: Vec<&[f32]> = done.chunks_exact(row_length * 3).take(first_original).collect();
            rows.extend(originals.iter().map(Vec::as_slice));
            rows.extend(rest.chunks_exact(row_length * 3));
            let field = Field { shape: self.shape, movement: self.movement, rows, guides: self.guides };
            let near = |distance: usize| v.saturating_sub(distance)..(v + distance + 1).min(lens_rows);
            for row in near(SMOOTHED + LENSES) {
                if evidence.back().is_none_or(|(last, _)| *last < row) {
                    evidence.push_back((row, field.evidence_of_row(row, &lenses, &blocks)));
                }
            }
            for row in near(SMOOTHED) {
                if choices.back().is_none_or(|(last, _)| *last < row) {
                    choices.push_back((row, choices_of_row(&evidence, row, &lenses, &blocks, lens_columns)));
                }
            }
            let out = field.reconstruct_row(v, &lenses, &blocks, &choices, self.replaces);
            drop(field);
            if self.replaces {
                let end = (v + 1) * row_length * 3;
                originals.push_back(self.color[v * row_length * 3..end].to_vec());
                let shape = [view_rows, lens_columns, view_columns];
                scatter(&out, shape, &mut self.color[v * row_length * 3..end]);
            }
            out.iter().for_each(|(_, errors)| distribution.extend(errors));
            if let Some(error) = &mut self.error {
                let row = &mut error[v * row_length..(v + 1) * row_length];
                row.par_chunks_mut(lens_columns * view_columns).enumerate().for_each(|(t, row)| {
                    for (u, row) in row.chunks_exact_mut(view_columns).enumerate() {
                        for (s, error) in row.iter_mut().enumerate() {
                            *error = out[u].1[t * view_columns + s];
                        }
                    }
                });
            }
            while originals.len() > REACH {
                originals.pop_front();
            }
            evidence.retain(|(row, _)| row + SMOOTHED + LENSES > v);
            choices.retain(|(row, _)| row + SMOOTHED > v);
            if !advance() {
                break;
            }
        }
        distribution
    }

    /// With one sample per pixel there are no halves; the differences between neighboring views take their place: of
    /// every 2 x 2 views the three differences of a Haar wavelet, which have the variance of a view, are uncorrelated,
    /// and do not contain the mean. Their signs alternate, so that gradients cancel.
    fn differences_between_views(&mut self) {
        let [_, lens_columns, view_rows, view_columns] = self.shape;
        let width = lens_columns * view_columns;
        let color = &*self.color;
        let length = view_rows * width;
        self.guides.par_chunks_mut(length * CHANNELS).zip(color.par_chunks(length * 3)).for_each(|(guides, color)| {
            for u in 0..lens_columns {
                let place = |t: usize, s: usize| t * width + u * view_columns + s;
                let bright = |t: usize, s: usize| {
                    let at = place(t, s) * 3;
                    luminance([color[at], color[at + 1], color[at + 2]])
                };
                for t in 0..view_rows {
                    for s in 0..view_columns {
                        // The last of an odd number of views belongs to the two before it too.
                        let start = |k: usize, count: usize| (k - k % 2).min(count.saturating_sub(2));
                        let (top, left) = (start(t, view_rows), start(s, view_columns));
                        let (bottom, right) = ((top + 1).min(view_rows - 1), (left + 1).min(view_columns - 1));
                        let [a, b, c, d] =
                            [bright(top, left), bright(top, right), bright(bottom, left), bright(bottom, right)];
                        // Which view gets which difference alternates too.
                        let turn = (top / 2 * 3 + left / 2 * 5) / 2;
                        let difference = if view_rows == 1 || view_columns == 1 {
                            [a - d, 0.0][(t - top + s - left + turn) % 2]
                        } else {
                            // 3 differences stand for 4 views.
                            let scale = (4.0f32 / 3.0).sqrt() / 2.0;
                            let differences = [a - b + c - d, a + b - c - d, a - b - c + d, 0.0];
                            differences[((t - top) * 2 + (s - left) + turn) % 4] * scale
                        };
                        let sign = if (top / 2 + left / 2) % 2 == 0 { 1.0 } else { -1.0 };
                        guides[place(t, s) * CHANNELS] = sign * difference;
                    }
                }
            }
        });
    }

    /// The windows of all microlenses, from the fastest movement that they and their neighbors see.
    fn lenses(&self) -> Vec<Lens> {
        let [lens_rows, lens_columns, view_rows, view_columns] = self.shape;
        let movement = self.movement[0].max(self.movement[1]);
        let width = lens_columns * view_columns;
        let fastest: Vec<f32> = self
            .guides
            .par_chunks(view_rows * width * CHANNELS)
            .flat_map_iter(|row| {
                let mut fastest = vec![0.0f32; lens_columns];
                for line in row.chunks_exact(width * CHANNELS) {
                    for (fastest, views) in fastest.iter_mut().zip(line.chunks_exact(view_columns * CHANNELS)) {
                        for guides in views.chunks_exact(CHANNELS) {
                            let speed = movement * guides[1].abs();
                            *fastest = fastest.max(if speed.is_nan() { f32::INFINITY } else { speed });
                        }
                    }
                }
                fastest
            })
            .collect();
        let near = |k: usize, count: usize| k.saturating_sub(1)..(k + 2).min(count);
        let lens = |k: usize| {
            let (v, u) = (k / lens_columns, k % lens_columns);
            let around = near(v, lens_rows).flat_map(|v| near(u, lens_columns).map(move |u| v * lens_columns + u));
            let speed = around.map(|k| fastest[k]).fold(0.0, f32::max);
            let radius = (MAX_MOVEMENT_PX / speed).min(LARGEST_RADIUS as f32) as usize;
            let gathers = radius < SMALLEST_RADIUS;
            match self.filters {
                true => Lens { radii: Radii::up_to(radius.max(SMALLEST_RADIUS)), gathers },
                false => Lens { radii: Radii::SINGLE, gathers: false },
            }
        };
        (0..lens_rows * lens_columns).into_par_iter().map(lens).collect()
    }
}

impl Field<'_> {
    fn evidence_of_row(&self, v: usize, lenses: &[Lens], blocks: &Blocks) -> Vec<Vec<Evidence>> {
        let lens_columns = self.shape[1];
        (0..lens_columns)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, u| {
                self.evidence([v, u], &lenses[v * lens_columns + u], blocks, scratch)
            })
            .collect()
    }

    /// Color, if it is wanted, and relative error of the views of every microlens of row `v`.
    fn reconstruct_row(
        &self,
        v: usize,
        lenses: &[Lens],
        blocks: &Blocks,
        choices: &VecDeque<(usize, Vec<Vec<Choice>>)>,
        with_color: bool,
    ) -> Vec<(Vec<f32>, Vec<f32>)> {
        let [_, lens_columns, view_rows, view_columns] = self.shape;
        let one = |scratch: &mut Scratch, u: usize| {
            let lens = &lenses[v * lens_columns + u];
            let highest = (lens.levels() - 1) as f32;
            let columns = u.saturating_sub(SMOOTHED)..(u + SMOOTHED + 1).min(lens_columns);
            let near: Vec<&Vec<Choice>> = choices
                .iter()
                .filter(|(row, _)| row.abs_diff(v) <= SMOOTHED)
                .flat_map(|(_, row)| &row[columns.clone()])
                .collect();
            let scale = 1.0 / near.len() as f32;
            let smooth: Vec<Choice> = (0..blocks.count())
                .map(|block| {
                    let mut mean = Choice::default();
                    for choices in &near {
                        mean.level += choices[block].level.min(highest) * scale;
                        mean.error += choices[block].error * scale;
                    }
                    // The mean of equal levels may be rounded up.
                    mean.level = mean.level.min(highest);
                    mean
                })
                .collect();
            // Interpolated choices are rounded; within the limits they have the means that are there.
            let lowest = smooth.iter().fold(highest, |low, choice| low.min(choice.level)).floor();
            let largest = smooth.iter().fold(0.0f32, |high, choice| high.max(choice.level)).ceil();
            if with_color && !lens.gathers {
                // Moved windows have the means of those that end at the border.
                let needed = if lens.radii.is_moved(lowest as usize) { lowest - 1.0 } else { lowest };
                self.box_means([v, u], lens, needed as usize..=largest as usize, scratch);
            }
            let (mut color, mut error) = (Vec::new(), Vec::new());
            for t in 0..view_rows {
                for s in 0..view_columns {
                    let mut choice = blocks.interpolate(&smooth, [t, s]);
                    error.push(choice.error.sqrt());
                    if !with_color {
                        continue;
                    }
                    choice.level = choice.level.clamp(lowest, largest);
                    let [lower, upper] = [choice.level.floor(), choice.level.ceil()].map(|level| level as usize);
                    let part = choice.level - lower as f32;
                    let [low, high]: [[f32; VALUES]; 2] = if lens.gathers {
                        let means = gather(self, [v, u, t, s], upper);
                        [means[lower], means[upper]]
                    } else {
                        [lower, upper]
                            .map(|level| std::array::from_fn(|k| scratch.means[level][k][t * view_columns + s]))
                    };
                    color.extend((0..3).map(|c| if part > 0.0 { low[c] + (high[c] - low[c]) * part } else { low[c] }));
                }
            }
            (color, error)
        };
        (0..lens_columns).into_par_iter().map_init(Scratch::default, one).collect()
    }
}

/// The choices of the microlenses of row `v` from the evidence around it.
fn choices_of_row(
    evidence: &VecDeque<(usize, Vec<Vec<Evidence>>)>,
    v: usize,
    lenses: &[Lens],
    blocks: &Blocks,
    lens_columns: usize,
) -> Vec<Vec<Choice>> {
    let one = |near: &mut Vec<Evidence>, u: usize| {
        let lens = &lenses[v * lens_columns + u];
        let columns = u.saturating_sub(LENSES)..(u + LENSES + 1).min(lens_columns);
        let window_views = lens.window_views(blocks.views);
        (0..blocks.count())
            .map(|block| {
                near.clear();
                for (_, row) in evidence.iter().filter(|(row, _)| row.abs_diff(v) <= LENSES) {
                    near.extend(row[columns.clone()].iter().map(|blocks| blocks[block]));
                }
                choice::choose(near, lens.levels(), &window_views, blocks.size())
            })
            .collect()
    };
    (0..lens_columns).into_par_iter().map_init(Vec::new, one).collect()
}

/// Writes the colors of one lens row into its lines of the elemental image array.
fn scatter(lenses: &[(Vec<f32>, Vec<f32>)], [_, lens_columns, view_columns]: [usize; 3], row: &mut [f32]) {
    row.par_chunks_mut(lens_columns * view_columns * 3).enumerate().for_each(|(t, line)| {
        for ((color, _), line) in lenses.iter().zip(line.chunks_exact_mut(view_columns * 3)) {
            line.copy_from_slice(&color[t * view_columns * 3..(t + 1) * view_columns * 3]);
        }
    });
}

#[cfg(test)]
mod tests;
