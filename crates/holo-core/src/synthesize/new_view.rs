//! The pixels of a synthesized view, from the views that see their points.

use ndarray::{Array2, Array3, ArrayView3};

use super::fill::fill;
use super::joint::{Joint, SAME_PX};
use super::surface::{Line, Surface};
use crate::base::memory::filled;
use crate::base::parallel::*;
use crate::refocus::{Kernel, add_sample};
use crate::{Error, GridSize, Sample};

/// Views agree on a point if their points lie no farther apart than this in a view, px: then their colors are blended. Pixels at
/// edges show two surfaces, and a mean of both is nearer to them than either.
const APART_PX: f64 = 1.0;

/// A view that shows parts of the new one.
pub(super) struct Source<'a, T, G> {
    pub image: ArrayView3<'a, T>,
    pub surface: Surface,
    /// The least and the greatest disparity at which its surfaces are looked for, px.
    pub range_px: [f64; 2],
    /// How points move from the new view to this one.
    pub motion: G,
    pub weight: f32,
}

/// How the points of a new view move to another view.
pub(super) trait Motion: Sync {
    /// Where the other view may show the point of a pixel, in its own disparity; `None` if it looks elsewhere.
    fn line(&self, pixel: [f64; 2]) -> Option<Line>;

    /// The disparity of a point of a pixel in the new view, from that in the other one; `None` if the new one does not see it.
    fn disparity_px(&self, pixel: [f64; 2], other_px: f64) -> Option<f64>;
}

/// The motion between the views of a grid: rows and columns by which a point moves for each pixel of disparity.
pub(super) struct Steps(pub [f64; 2]);

impl Motion for Steps {
    fn line(&self, pixel: [f64; 2]) -> Option<Line> {
        Some(Line { from: pixel, step: self.0 })
    }

    fn disparity_px(&self, _: [f64; 2], other_px: f64) -> Option<f64> {
        Some(other_px)
    }
}

/// A view under construction: NaN where no view has shown the point yet.
pub(super) struct NewView {
    colors: Vec<f32>,
    disparity_px: Vec<f32>,
    size: [usize; 2],
    channels: usize,
}

/// A finished view: its image, its disparities, and the pixels that no view has shown.
pub(super) struct Finished {
    pub image: Array3<f32>,
    pub disparity_px: Array2<f32>,
    pub holes: Array2<bool>,
}

impl NewView {
    pub fn new(size: GridSize, channels: usize) -> Result<Self, Error> {
        let size = [size.rows, size.columns];
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

    /// Sets the pixels that are still empty and that some of the views show. With `joint`, pixels on one surface of all views are
    /// those of all views at once.
    pub fn add<'s, 'a, T: Sample, G: Motion>(
        &mut self,
        sources: &'s [Source<'a, T, G>],
        kernel: Kernel,
        joint: Option<&Joint>,
    ) {
        let ([_, columns], channels) = (self.size, self.channels);
        let lines = self.disparity_px.par_chunks_mut(columns).zip(self.colors.par_chunks_mut(columns * channels));
        lines.enumerate().for_each_init(Vec::new, |hits: &mut Vec<Hit<'s, 'a, T, G>>, (row, (disparities, colors))| {
            for (column, disparity) in disparities.iter_mut().enumerate().filter(|(_, x)| x.is_nan()) {
                let pixel = [row as f64, column as f64];
                hits.clear();
                hits.extend(sources.iter().filter_map(|source| Hit::find(source, pixel)));
                let Some(most) = most_seen(hits) else { continue };
                let (mut total, mut mean) = (0.0, 0.0);
                let color = &mut colors[column * channels..][..channels];
                let is_one_surface =
                    hits.len() == sources.len() && hits.iter().all(|hit| (hit.disparity_px - most).abs() <= SAME_PX);
                if let Some(joint) = joint.filter(|_| is_one_surface) {
                    let weighted = |of: fn(&Hit<'s, 'a, T, G>) -> f64| -> f64 {
                        hits.iter().map(|hit| f64::from(hit.source.weight) * of(hit)).sum()
                    };
                    let mean = weighted(|hit| hit.disparity_px) / weighted(|_| 1.0);
                    *disparity = mean as f32;
                    joint.add(hits.iter().map(|hit| hit.source.image), [row, column], mean, color);
                    continue;
                }
                for hit in hits.iter().filter(|hit| hit.is_near(most)) {
                    let weight = hit.source.weight;
                    total += weight;
                    mean += weight * hit.disparity_px as f32;
                    add_sample(hit.source.image, hit.place, kernel, weight, color);
                }
                *disparity = mean / total;
                color.iter_mut().for_each(|value| *value /= total);
            }
        });
    }

    /// The view, its holes filled.
    pub fn finished(mut self) -> Finished {
        let [rows, columns] = self.size;
        let holes = self.disparity_px.iter().map(|x| x.is_nan()).collect();
        fill(&mut self.disparity_px, self.size, &mut self.colors, self.channels);
        let map = |of: Vec<f32>| Array2::from_shape_vec((rows, columns), of).expect("the length is the product");
        Finished {
            image: Array3::from_shape_vec((rows, columns, self.channels), self.colors)
                .expect("the length is the product"),
            disparity_px: map(self.disparity_px),
            holes: Array2::from_shape_vec((rows, columns), holes).expect("the length is the product"),
        }
    }
}

/// A point that a view shows.
struct Hit<'s, 'a, T, G> {
    source: &'s Source<'a, T, G>,
    /// Where the view shows it.
    place: [f64; 2],
    /// Its disparity in the new view.
    disparity_px: f64,
    /// The most that it moves along an axis, px for each pixel of disparity.
    slope: f64,
}

impl<'s, 'a, T, G: Motion> Hit<'s, 'a, T, G> {
    fn find(source: &'s Source<'a, T, G>, pixel: [f64; 2]) -> Option<Self> {
        let line = source.motion.line(pixel)?;
        let found_px = source.surface.meets(&line, source.range_px)?;
        let slope = line.step[0].abs().max(line.step[1].abs());
        let disparity_px = source.motion.disparity_px(pixel, found_px)?;
        Some(Self { source, place: line.at(found_px), disparity_px, slope })
    }

    fn is_near(&self, disparity_px: f64) -> bool {
        (disparity_px - self.disparity_px).abs() * self.slope <= APART_PX
    }
}

/// The disparity that most of the views agree on, by weight; of two that as many do, the nearer one.
fn most_seen<T, G: Motion>(hits: &[Hit<'_, '_, T, G>]) -> Option<f64> {
    let support = |disparity_px: f64| -> f32 {
        hits.iter().filter(|hit| hit.is_near(disparity_px)).map(|hit| hit.source.weight).sum()
    };
    let candidates = hits.iter().map(|hit| (support(hit.disparity_px), hit.disparity_px));
    candidates.max_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|most| most.1)
}
