//! The pixels of a synthesized view, from the views that see their points.

use ndarray::{Array2, Array3, Data};

use super::SynthesizedView;
use super::fill::fill;
use super::surface::{Line, Surface};
use crate::memory::filled;
use crate::parallel::*;
use crate::refocus::Kernel;
use crate::{Error, GridSize, LightField, Sample, ViewIndex};

/// Views agree on a point if their points lie no farther apart than this in a view, px: then their colors are blended. Pixels at
/// edges show two surfaces, and a mean of both is nearer to them than either.
const APART_PX: f64 = 1.0;

/// A view of the light field that shows parts of the new one.
pub(super) struct Source {
    pub view: ViewIndex,
    pub surface: Surface,
    /// Rows and columns by which a point moves from the new view to this one, for each pixel of disparity.
    pub steps: [f64; 2],
    pub weight: f32,
}

/// A view under construction: NaN where no view has shown the point yet.
pub(super) struct NewView {
    colors: Vec<f32>,
    disparity_px: Vec<f32>,
    size: [usize; 2],
    channels: usize,
}

impl NewView {
    pub fn new(lenses: GridSize, channels: usize) -> Result<Self, Error> {
        let size = [lenses.rows, lenses.columns];
        Ok(Self {
            colors: filled("a synthesized view", size[0] * size[1] * channels, 0.0)?,
            disparity_px: filled("the disparity of a synthesized view", size[0] * size[1], f32::NAN)?,
            size,
            channels,
        })
    }

    pub fn has_holes(&self) -> bool {
        self.disparity_px.iter().any(|x| x.is_nan())
    }

    /// Sets the pixels that are still empty and that some of the views show.
    pub fn add<S>(&mut self, light_field: &LightField<S>, sources: &[Source], kernel: Kernel, range_px: [f64; 2])
    where
        S: Data + Sync,
        S::Elem: Sample,
    {
        let ([_, columns], channels) = (self.size, self.channels);
        let lines = self.disparity_px.par_chunks_mut(columns).zip(self.colors.par_chunks_mut(columns * channels));
        lines.enumerate().for_each_init(Vec::new, |hits: &mut Vec<Hit<'_>>, (row, (disparities, colors))| {
            for (column, disparity) in disparities.iter_mut().enumerate().filter(|(_, x)| x.is_nan()) {
                let line = |source: &Source| Line { from: [row as f64, column as f64], step: source.steps };
                hits.clear();
                hits.extend(
                    sources.iter().filter_map(|source| Some((source.surface.meets(&line(source), range_px)?, source))),
                );
                let Some(most) = most_seen(hits) else { continue };
                let (mut total, mut mean) = (0.0, 0.0);
                let color = &mut colors[column * channels..][..channels];
                for (found, source) in hits.iter().filter(|hit| is_near(most, hit)) {
                    total += source.weight;
                    mean += source.weight * *found as f32;
                    source.add_color(light_field, line(source).at(*found), kernel, color);
                }
                *disparity = mean / total;
                color.iter_mut().for_each(|value| *value /= total);
            }
        });
    }

    /// The view, its holes filled.
    pub fn finished(mut self) -> Result<SynthesizedView, Error> {
        let [rows, columns] = self.size;
        let holes = self.disparity_px.iter().map(|x| x.is_nan()).collect();
        fill(&mut self.disparity_px, self.size, &mut self.colors, self.channels);
        let map = |of: Vec<f32>| Array2::from_shape_vec((rows, columns), of).expect("the length is the product");
        Ok(SynthesizedView {
            image: Array3::from_shape_vec((rows, columns, self.channels), self.colors)
                .expect("the length is the product"),
            disparity_px: map(self.disparity_px),
            holes: Array2::from_shape_vec((rows, columns), holes).expect("the length is the product"),
        })
    }
}

/// A point that a view shows at its disparity, px.
type Hit<'a> = (f64, &'a Source);

fn is_near(disparity_px: f64, hit: &Hit<'_>) -> bool {
    (disparity_px - hit.0).abs() * hit.1.slope() <= APART_PX
}

/// The disparity that most of the views agree on, by weight; of two that as many do, the nearer one.
fn most_seen(hits: &[Hit<'_>]) -> Option<f64> {
    let support =
        |disparity_px: f64| hits.iter().filter(|hit| is_near(disparity_px, hit)).map(|hit| hit.1.weight).sum::<f32>();
    let candidates = hits.iter().map(|hit| (support(hit.0), hit.0));
    candidates.max_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|most| most.1)
}

impl Source {
    /// The most that a point moves along an axis, px for each pixel of disparity.
    fn slope(&self) -> f64 {
        self.steps[0].abs().max(self.steps[1].abs())
    }

    /// Adds the weighted color of a place.
    fn add_color<S>(&self, light_field: &LightField<S>, [row, column]: [f64; 2], kernel: Kernel, color: &mut [f32])
    where
        S: Data,
        S::Elem: Sample,
    {
        let samples = light_field.samples();
        let (rows, columns, ..) = samples.dim();
        let [(first_row, down), (first_column, along)] = [row, column]
            .map(|at| (at.floor() as isize - 1, kernel.weights(at - at.floor()).map(|weight| weight as f32)));
        let inside = |at: isize, count: usize| at.clamp(0, count as isize - 1) as usize;
        let row_of = |k: usize| inside(first_row + k as isize, rows);
        let column_of = |k: usize| inside(first_column + k as isize, columns);
        for (k, weight) in
            (0..16).map(|k| (k, self.weight * down[k / 4] * along[k % 4])).filter(|(_, weight)| *weight != 0.0)
        {
            for (channel, value) in color.iter_mut().enumerate() {
                let place = [row_of(k / 4), column_of(k % 4), self.view.row, self.view.column, channel];
                *value += weight * samples[place].to_f32();
            }
        }
    }
}
