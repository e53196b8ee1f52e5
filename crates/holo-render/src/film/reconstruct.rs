//! Reconstruction across views: the light of a pixel from the samples of others.
//!
//! Adjacent views see nearly the same image. Behind one microlens, views that are k apart see spots of the scene that
//! are k disparities apart, in pixels; at 100 x 100 views of an 8K sensor that is a hundredth of a pixel for adjacent
//! views. So few pixels need samples of their own. The steps, each a file:
//!
//! 1. [Cells](cells) add up the samples of a few views behind a microlens.
//! 2. [Nodes](nodes), some pixels behind every microlens, take means of the cells around that see their point of the scene,
//!    along its disparity, over nested windows.
//! 3. [Fits](fit) go through the nodes of neighboring microlenses.
//! 4. The [choice] is the estimate with most samples that no smaller one contradicts.
//! 5. A pixel takes its light from the [nodes around](spread) that show its surface.
//!
//! # Bias
//! A mean over views is biased where light depends on the direction (reflections and refractions have disparities of their
//! own), a fit where light is curved. The bias that the choice allows is of the order of the noise that remains, and it
//! vanishes as the samples grow. The estimated error contains it where it is significant.
//!
//! # Determinism
//! A pixel depends on the samples of at most [`HALO`] lens rows above and below it, so parts of a light field that are
//! rendered with that margin have the same bytes.

mod cells;
mod choice;
mod estimate;
mod fit;
pub(crate) mod lattice;
mod nodes;
mod rows;
mod spread;
mod steps;

use std::ops::Range;

use rayon::prelude::*;

use self::choice::LENSES;
use self::spread::SpreadLine;
use self::steps::Steps;
use super::error_distribution::ErrorDistribution;
use super::guides::CHANNELS;
use crate::simd;

/// The largest distance, in microlenses along an axis, of a sample that a node gathers.
const REACH: usize = 4;

/// The largest distance, in microlenses along an axis, of a node that a pixel takes its light from.
const SPREAD_REACH: usize = 8;

/// Neighboring microlenses on each side whose choices are averaged.
const SMOOTHED: usize = 1;

/// The distances, in rows, of what the steps need of the one before: finished nodes, choices, evidence, nodes, cells.
const AHEAD: [usize; 5] = {
    let (finished, chosen) = (SPREAD_REACH, SPREAD_REACH + SMOOTHED);
    let evidence = chosen + LENSES;
    let nodes = evidence + fit::REACH;
    [finished, chosen, evidence, nodes, nodes + REACH]
};

/// The number of lens rows above and below a pixel on which it depends.
pub(crate) const HALO: usize = AHEAD[4];

/// Whether a value is at most the limit, and a number: disparities of what is infinitely far away may be none.
#[inline(always)]
fn is_within(value: f32, limit: f32) -> bool {
    value <= limit
}

/// A light field, in the layout of the elemental image array.
pub(crate) struct Reconstruction<'a> {
    /// Lens rows and columns, view rows and columns.
    pub shape: [usize; 4],
    /// Color, 3 channels; reconstructed in place if it is to be replaced.
    pub color: &'a mut [f32],
    /// The guides of [`super::guides`].
    pub guides: &'a [f32],
    /// Movement between vertically and between horizontally adjacent views, in multiples of the disparity.
    pub movement: [f32; 2],
    /// Whether the error is that of reconstructed color; otherwise that of the samples, which then stay.
    pub filters: bool,
    /// Whether color is replaced; otherwise only its error is estimated.
    pub replaces: bool,
    /// The lens rows to reconstruct; the others are only read.
    pub rows: Range<usize>,
    /// The estimated relative error of every pixel, if wanted.
    pub error: Option<&'a mut [f32]>,
}

/// The pixels of a light field.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// Lens rows and columns, view rows and columns.
    shape: [usize; 4],
    /// Movement between vertically and between horizontally adjacent views, in multiples of the disparity.
    movement: [f32; 2],
}

/// The samples as they were rendered.
struct Field<'a> {
    grid: Grid,
    color: &'a [f32],
    guides: &'a [f32],
}

impl Field<'_> {
    /// Color and guides of all pixels of lens row `v` in view row `t`.
    #[inline(always)]
    fn line(&self, v: usize, t: usize) -> (&[[f32; 3]], &[[f32; CHANNELS]]) {
        let [_, lens_columns, view_rows, view_columns] = self.grid.shape;
        let width = lens_columns * view_columns;
        let line = v * view_rows + t;
        let colors = &self.color[line * width * 3..(line + 1) * width * 3];
        let guides = &self.guides[line * width * CHANNELS..][..width * CHANNELS];
        (colors.as_chunks().0, guides.as_chunks().0)
    }
}

impl Reconstruction<'_> {
    /// Reconstructs; returns the distribution of the error. `advance` is called after every lens row and returns whether
    /// to go on.
    pub fn run(mut self, advance: impl Fn() -> bool) -> ErrorDistribution {
        let [_, lens_columns, view_rows, view_columns] = self.shape;
        let width = lens_columns * view_columns;
        let grid = Grid { shape: self.shape, movement: self.movement };
        let mut steps = Steps::new(self.shape, self.rows.start);
        let mut distribution = ErrorDistribution::default();
        let replaces = self.replaces && self.filters;
        for v in self.rows.clone() {
            let field = Field { grid, color: self.color, guides: self.guides };
            steps.advance(&field, v, self.filters);
            let first = v * view_rows * width;
            let guides = &self.guides[first * CHANNELS..][..view_rows * width * CHANNELS];
            let colors = &mut self.color[first * 3..][..view_rows * width * 3];
            let mut unwanted = vec![0.0; if self.error.is_some() { 0 } else { view_rows * width }];
            let errors = match &mut self.error {
                Some(error) => &mut error[first..][..view_rows * width],
                None => &mut unwanted,
            };
            let lines = colors.par_chunks_mut(width * 3).zip(guides.par_chunks(width * CHANNELS));
            let parts: Vec<ErrorDistribution> = lines
                .zip(errors.par_chunks_mut(width))
                .enumerate()
                .map(|(t, ((color, guides), error))| {
                    let (color, guides) = (color.as_chunks_mut().0, guides.as_chunks().0);
                    simd::run(SpreadLine {
                        grid,
                        steps: &steps,
                        place: [v, t],
                        color: if replaces { Some(color) } else { None },
                        guides,
                        error,
                    });
                    let mut part = ErrorDistribution::default();
                    part.extend(error);
                    part
                })
                .collect();
            parts.iter().for_each(|part| distribution.merge(part));
            if !advance() {
                break;
            }
        }
        distribution
    }
}

#[cfg(test)]
mod tests;
