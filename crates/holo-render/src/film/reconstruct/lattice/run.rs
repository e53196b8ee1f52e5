//! The reconstruction of a raw image: evidence, choices and means of the microlenses, band by band.

use std::cell::OnceCell;
use std::ops::Range;

use rayon::prelude::*;

use super::super::cells::Sums;
use super::super::choice::{Choice, Evidence, LEVELS};
use super::super::{SMOOTHED, SPREAD_REACH};
use super::LENSES;
use super::blocks::Blocks;
use super::gather::{Neighborhood, Sampled, WINDOW_COUNT};
use super::{Lattice, Source};
use crate::film::error_distribution::ErrorDistribution;
use crate::film::guides::luminance;
use crate::simd::{self, Kernel};

/// Rows of microlenses that are reconstructed together.
const BAND_ROWS: usize = 16;

/// The reconstruction of a raw image, or the estimate of its error.
pub(crate) struct LatticeReconstruction<'a> {
    pub lattice: &'a Lattice,
    /// The samples of the pixels of the lattice.
    pub sources: &'a [Source],
    /// Whether the error is that of reconstructed color; otherwise that of the samples.
    pub filters: bool,
    /// The rows of the sensor to reconstruct; the others are only read.
    pub rows: Range<usize>,
    /// Color, 3 channels, of all pixels of the lattice, if it is to be replaced: radiance times share.
    pub color: Option<&'a mut [f32]>,
    /// The estimated relative error of every pixel, if wanted. 0 for pixels without light.
    pub error: Option<&'a mut [f32]>,
}

/// What is known of a block of viewpoints of a microlens.
#[derive(Clone, Copy)]
struct Observed {
    evidence: Evidence,
    /// Sums over its sampled pixels of the pixels of their windows.
    counts: [f64; LEVELS],
    pixels: f64,
}

/// A finished pixel.
struct Finished {
    place: usize,
    /// `None` if color is not replaced.
    color: Option<[f32; 3]>,
    error: f32,
}

/// A microlens that is observed, for every instruction set.
struct ObserveLens<'a, 'b>(&'b LatticeReconstruction<'a>, Neighborhood<'b>);

impl Kernel for ObserveLens<'_, '_> {
    type Output = Vec<Observed>;

    #[inline(always)]
    fn run(self) -> Vec<Observed> {
        self.0.observe(&self.1)
    }
}

/// A microlens that is finished, with the choices from a number on.
struct FinishLens<'a, 'b>(&'b LatticeReconstruction<'a>, Neighborhood<'b>, (&'b [Vec<Choice>], usize));

impl Kernel for FinishLens<'_, '_> {
    type Output = Vec<Finished>;

    #[inline(always)]
    fn run(self) -> Vec<Finished> {
        let Self(reconstruction, near, (chosen, first)) = self;
        reconstruction.finish(&near, chosen, first)
    }
}

impl LatticeReconstruction<'_> {
    /// The number of calls of `advance`.
    pub fn steps(lattice: &Lattice, rows: &Range<usize>) -> usize {
        lattice.lens_rows(rows).len().div_ceil(BAND_ROWS)
    }

    /// Reconstructs; returns the distribution of the error over the pixels with light. `advance` is called after every band
    /// of microlenses and returns whether to go on.
    pub fn run(mut self, advance: impl Fn() -> bool) -> ErrorDistribution {
        let mut distribution = ErrorDistribution::default();
        let (lattice, columns) = (self.lattice, self.lattice.grid[1]);
        let lens_rows = lattice.lens_rows(&self.rows);
        let (sources, sampled) = (self.sources, Sampled::find(lattice, self.sources));
        let near = |lens: usize| Neighborhood::new(lattice, sources, sampled.as_ref(), lens);
        for start in lens_rows.clone().step_by(BAND_ROWS) {
            let band = start..(start + BAND_ROWS).min(lens_rows.end);
            let wider = |by: usize| {
                let rows = band.start.saturating_sub(by)..(band.end + by).min(lattice.grid[0]);
                rows.start * columns..rows.end * columns
            };
            let (observed_lenses, chosen_lenses) = (wider(SMOOTHED + LENSES), wider(SMOOTHED));
            let first = observed_lenses.start;
            let observed: Vec<Vec<Observed>> =
                observed_lenses.into_par_iter().map(|lens| simd::run(ObserveLens(&self, near(lens)))).collect();
            let first_chosen = chosen_lenses.start;
            let chosen: Vec<Vec<Choice>> =
                chosen_lenses.into_par_iter().map(|lens| self.choose(lens, &observed, first)).collect();
            let finish = |lens: usize| simd::run(FinishLens(&self, near(lens), (&chosen, first_chosen)));
            let finished: Vec<Vec<Finished>> = wider(0).into_par_iter().map(finish).collect();
            for pixels in finished {
                let errors: Vec<f32> = pixels.iter().map(|pixel| pixel.error).collect();
                distribution.extend(&errors);
                for Finished { place, color, error } in pixels {
                    if let (Some(all), Some(color)) = (&mut self.color, color) {
                        all[3 * place..3 * place + 3].copy_from_slice(&color);
                    }
                    if let Some(all) = &mut self.error {
                        all[place] = error;
                    }
                }
            }
            if !advance() {
                break;
            }
        }
        distribution
    }

    /// The number of windows, from the pixel itself to the largest one.
    fn levels(&self) -> usize {
        if self.filters { WINDOW_COUNT } else { 1 }
    }

    /// The evidence of the blocks of a microlens, from about every second row and column of its pixels. Empty for a
    /// microlens without pixels.
    #[inline(always)]
    fn observe(&self, near: &Neighborhood) -> Vec<Observed> {
        let (lattice, levels, lens) = (self.lattice, self.levels(), near.lens());
        let blocks = lattice.blocks();
        let own = &lattice.lenses[lens];
        if own.rows.is_empty() {
            return Vec::new();
        }
        let nothing = Observed { evidence: Evidence::NONE, counts: [0.0; LEVELS], pixels: 0.0 };
        let around = luminance(self.mean_of(lens));
        let mut out = vec![nothing; blocks.count()];
        for row in own.rows.clone() {
            let t = lattice.view(own.center[1], row);
            for column in own.columns.clone() {
                let s = lattice.view(own.center[0], column);
                let place = lattice.place(row, column);
                let is_sampled = t.is_multiple_of(2) && s.is_multiple_of(2);
                if !is_sampled || lattice.owners[place] as usize != lens || !self.sources[place].is_lit() {
                    continue;
                }
                let found = near.gather([row, column], levels - 1);
                let mut estimates = [None; LEVELS];
                let block = &mut out[blocks.of([t, s])];
                for (level, sums) in found.iter().enumerate().take(levels).filter(|(_, sums)| sums.weight > 0.0) {
                    let [r, g, b, noise] = sums.means();
                    estimates[level] = Some([luminance([r, g, b]), noise]);
                    block.counts[level] += f64::from(sums.weight);
                }
                block.evidence.add(&estimates, levels, around, false);
                block.pixels += 1.0;
            }
        }
        out
    }

    /// The microlenses of the same type at most `distance` rows and columns of the table away, as numbers from `first` on.
    fn alike(&self, lens: usize, distance: usize, first: usize, count: usize) -> impl Iterator<Item = usize> {
        let lattice = self.lattice;
        let own_type = lattice.lenses[lens].lens_type;
        let is_alike = move |other: &usize| lattice.lenses[*other].lens_type == own_type;
        let numbers = lattice.around(lens, distance).filter(is_alike);
        numbers.filter_map(move |other| other.checked_sub(first).filter(|&number| number < count))
    }

    /// The choices of the blocks of a microlens from the evidence around it, which is that of the microlenses from
    /// `first` on. Blocks without evidence choose as the others do on average.
    fn choose(&self, lens: usize, observed: &[Vec<Observed>], first: usize) -> Vec<Choice> {
        let (lattice, levels) = (self.lattice, self.levels());
        if lattice.lenses[lens].rows.is_empty() {
            return Vec::new();
        }
        let blocks = lattice.blocks();
        let of_block = |block: usize| {
            let (mut near, mut lenses) = (Evidence::NONE, 0.0);
            let (mut window_pixels, mut pixels) = ([0.0; LEVELS], 0.0);
            for number in self.alike(lens, LENSES, first, observed.len()) {
                let Some(found) = observed[number].get(block).filter(|found| found.pixels > 0.0) else { continue };
                near.merge(&found.evidence, levels);
                lenses += 1.0;
                pixels += found.pixels;
                for (sum, count) in window_pixels.iter_mut().zip(found.counts) {
                    *sum += count;
                }
            }
            // Means over overlapping windows are one observation.
            let observations = window_pixels
                .map(|sum: f64| (lenses * (blocks.size() * pixels / sum).max(1.0) / pixels).min(1.0) as f32);
            near.choose(levels, &observations)
        };
        let choices: Vec<Option<Choice>> = (0..blocks.count()).map(of_block).collect();
        let mean = mean(choices.iter().flatten());
        choices.into_iter().map(|choice| choice.unwrap_or(mean)).collect()
    }

    /// The pixels of a microlens from the choices around it, which are those of the microlenses from `first` on.
    #[inline(always)]
    fn finish(&self, near: &Neighborhood, chosen: &[Vec<Choice>], first: usize) -> Vec<Finished> {
        let (lattice, lens) = (self.lattice, near.lens());
        let blocks = lattice.blocks();
        let own = &lattice.lenses[lens];
        let smooth = self.smooth(lens, &blocks, chosen, first);
        let mut out = Vec::new();
        let mean = OnceCell::new();
        for row in own.rows.start.max(self.rows.start)..own.rows.end.min(self.rows.end) {
            for column in own.columns.clone() {
                let place = lattice.place(row, column);
                let source = &self.sources[place];
                if lattice.owners[place] as usize != lens || source.share <= 0.0 {
                    continue;
                }
                let view = [lattice.view(own.center[1], row), lattice.view(own.center[0], column)];
                let choice = blocks.interpolate(&smooth, view);
                let color = self.color.is_some().then(|| self.color_of((near, &mean), [row, column], choice.level));
                out.push(Finished { place, color, error: choice.error.sqrt() });
            }
        }
        out
    }

    /// The means of the choices of a microlens and its neighbors.
    fn smooth(&self, lens: usize, blocks: &Blocks, chosen: &[Vec<Choice>], first: usize) -> Vec<Choice> {
        let near: Vec<&Vec<Choice>> = self
            .alike(lens, SMOOTHED, first, chosen.len())
            .map(|number| &chosen[number])
            .filter(|choices| !choices.is_empty())
            .collect();
        (0..blocks.count()).map(|block| mean(near.iter().map(|choices| &choices[block]))).collect()
    }

    /// The light of a pixel: the mean over a window, or a mixture of those over two, times its share. Without samples in any it
    /// is the mean of its microlens.
    #[inline(always)]
    fn color_of(
        &self,
        (near, mean): (&Neighborhood, &OnceCell<[f32; 3]>),
        [row, column]: [usize; 2],
        level: f32,
    ) -> [f32; 3] {
        // Means of levels may be rounded up.
        let level = level.clamp(0.0, (self.levels() - 1) as f32);
        let (lower, upper) = (level.floor() as usize, level.ceil() as usize);
        let part = level - lower as f32;
        let sums = near.gather([row, column], self.levels() - 1);
        let share = self.sources[self.lattice.place(row, column)].share;
        // Without samples the next larger window.
        let means = |level: usize| sums[level..self.levels()].iter().find(|sums| sums.weight > 0.0).map(Sums::means);
        let color = match (means(lower), means(upper)) {
            (Some([r, g, b, _]), None) => [r, g, b],
            (Some(low), Some(high)) => {
                std::array::from_fn(|c| if part > 0.0 { low[c] + (high[c] - low[c]) * part } else { low[c] })
            }
            (None, _) => *mean.get_or_init(|| self.mean_of(near.lens())),
        };
        color.map(|value| value * share)
    }

    /// The mean radiance of the samples behind a microlens, or, without any, behind the nearest of its type that have some:
    /// that of pixels without samples in any window.
    fn mean_of(&self, lens: usize) -> [f32; 3] {
        (0..=SPREAD_REACH).find_map(|lines| self.mean_around(lens, lines)).unwrap_or_default()
    }

    /// That of the microlenses of the type of one which are at most so many rows and columns of the table away.
    fn mean_around(&self, lens: usize, lines: usize) -> Option<[f32; 3]> {
        let mut all = Sums::default();
        for lens in self.alike(lens, lines, 0, self.lattice.lenses.len()) {
            let own = &self.lattice.lenses[lens];
            for (row, column) in own.rows.clone().flat_map(|row| own.columns.clone().map(move |column| (row, column))) {
                let place = self.lattice.place(row, column);
                if self.lattice.owners[place] as usize == lens && self.sources[place].has_samples() {
                    all.add(&self.sources[place].sums());
                }
            }
        }
        (all.weight > 0.0).then(|| all.color.map(|sum| sum / all.weight))
    }
}

/// The mean of choices; without any the pixel itself.
fn mean<'a>(choices: impl Iterator<Item = &'a Choice>) -> Choice {
    let (mut sum, mut count) = (Choice::default(), 0.0);
    for choice in choices {
        sum.level += choice.level;
        sum.error += choice.error;
        count += 1.0;
    }
    if count > 0.0 { Choice { level: sum.level / count, error: sum.error / count } } else { sum }
}
