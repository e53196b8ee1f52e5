//! Disparity estimation by multi-view stereo: a plane sweep with semi-global matching and refinement.
//!
//! 1. `views.rs` selects a star or a grid of views around the central one and copies them as planes of `f32`. `pyramid.rs`
//!    halves their resolution until they are small. The steps below begin with the smallest, and its estimate guides
//!    the next: what has no texture in the noise of single pixels has some in means of many.
//! 2. `cost.rs` shifts every view by every disparity and computes the color difference to the central view: truncated,
//!    summed over 3 x 3 pixels, and over the half of the views with the lowest mean, because an occluder hides a point
//!    from the views of one side. From one disparity to the next the outermost view moves by up to a pixel
//!    (`effort.rs`). Where the costs are noise, the coarser estimate decides (`pyramid.rs`).
//! 3. `scanline.rs` aggregates the costs along eight directions, so that pixels without texture follow textured
//!    neighbors. `sweep.rs` selects the disparity of the lowest cost.
//! 4. `measure.rs` makes one Gauss-Newton step per pixel, with the views in which the pixel is visible according to the
//!    current map and with robust weights. It also estimates the variance of the step, without what is noise of the
//!    gradients. `gloss.rs` takes off light that changes from view to view.
//! 5. `plane_fit.rs` fits a plane to the steps around every pixel and to the coarser estimate, weighted by their precision,
//!    by similarity of color and by membership in the same surface; in plain areas over squares of pixels (`cells.rs`).
//!    `sharpen.rs` moves the edges of the map to those of the image. Steps 4 and 5 are repeated. The precision of the fit
//!    gives the confidence.
//!
//! `cargo xtask report` measures error and time on scenes of the gallery.
//!
//! # Errors
//!
//! Percent of the pixels that are off by more than 0.07 px: 9 x 9 views of 512 x 512 px with disparities within 1.5 px (`holo render
//! --preset hci --integrator direct`, 8 samples, 16 of `chess` and `mountains`, 12 of `glasses`; pixels that see something, but for a border of
//! 15 px). Next to them OpenCV's SGBM on two views, and the best of 61 planes by mean differences of all views in 5 x 5 pixels. antinous is a
//! scene of the HCI benchmark (disparities within -3.3 to 2.8 px).
//!
//! | scene | fast | balanced | thorough | SGBM | planes |
//! |---|---|---|---|---|---|
//! | garden | 17.1 | 16.0 | 15.7 | 35.1 | 18.6 |
//! | mirror | 23.5 | 20.8 | 19.6 | 70.3 | 64.2 |
//! | clockwork | 32.6 | 28.4 | 24.2 | 64.8 | 56.6 |
//! | glasses | 12.3 | 11.5 | 10.8 | 64.1 | 45.9 |
//! | bottles | 23.8 | 19.3 | 17.4 | 81.7 | 52.2 |
//! | birdcage | 18.1 | 17.3 | 16.4 | 57.1 | 28.8 |
//! | chess | 11.3 | 5.4 | 4.8 | 48.1 | 41.5 |
//! | mountains | 5.2 | 3.9 | 2.7 | 59.3 | 30.7 |
//! | billiards | 4.7 | 3.3 | 2.5 | 71.0 | 45.6 |
//! | tiles | 3.3 | 2.3 | 1.7 | 39.1 | 17.1 |
//! | plaster | 40.7 | 34.1 | 20.1 | 89.7 | 80.5 |
//! | curtains | 54.2 | 52.4 | 50.7 | 76.4 | 69.1 |
//! | lanterns | 16.7 | 13.0 | 8.9 | 66.1 | 46.6 |
//! | dominoes | 4.5 | 3.8 | 3.4 | 60.0 | 29.0 |
//! | fruit | 4.9 | 4.2 | 3.6 | 64.0 | 26.4 |
//! | fence | 41.4 | 37.2 | 33.5 | 61.6 | 43.4 |
//! | antinous | 10.0 | 8.9 | 7.9 | 22.7 | 30.2 |
//!
//! Seven of ten wrong pixels of `glasses` are glass. `curtains` are a veil, with holes of one or two pixels, before a plain wall. `plaster` is
//! without texture.
//!
//! # Limits
//!
//! The estimate is wrong on mirrors and glass, which show objects at other distances; on glossy surfaces without texture,
//! whose light moves with the eye (texture tells gloss from parallax); on surfaces at grazing angles with little texture; at
//! pixels along depth edges, and most of those that some views do not see; and where objects are about a pixel wide, as in grass.
//!
//! # Memory
//!
//! With n views and C matched channels: `5.4 C (n + 1) V U` bytes for samples, `(125 + 8 C) V U` for maps,
//! and 256 MiB or `512 planes U` bytes, whichever is more, for costs (less for small views).

mod any_views;
mod cells;
mod cost;
mod effort;
mod gloss;
mod measure;
mod plane;
mod plane_fit;
mod pyramid;
mod scanline;
mod sharpen;
mod sums;
mod sweep;
#[cfg(test)]
mod tests;
mod views;

pub use any_views::{OffsetView, evenly_chosen_views, plane_sweep_of_views};
pub(crate) use cost::WORST;
pub use effort::Effort;
pub(crate) use scanline::aggregate;

use ndarray::{Array2, Data};

use crate::{BaselineRatio, Error, LightField, Sample};
use cost::Planes;
use effort::Settings;
use measure::Image;
use plane::Plane;
use plane_fit::Fit;
use pyramid::Prior;
use views::Views;

/// The largest number of planes of a sweep: 4096 of them cost 2 MiB a pixel column.
const MOST_PLANES: usize = 4096;
/// The standard error of confidence 1/2.
const HALF_CONFIDENCE_PX: f32 = 0.02;
/// The gate of a coarser level: surfaces that are a pixel apart are half of one apart there.
const COARSE_GATE: f32 = 0.3;
/// The gate of a surface without information, in gates.
const WIDEST: f32 = 2.0;
/// The largest absolute disparity of a range.
const LARGEST_PX: f32 = 1e6;

/// The options of [`plane_sweep`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PlaneSweepOptions {
    /// The smallest disparity, in pixels between adjacent views: that of the farthest point.
    pub disparity_min_px: f32,
    /// The largest disparity, in pixels between adjacent views: that of the nearest point.
    pub disparity_max_px: f32,
    /// The trade-off between time and error.
    pub effort: Effort,
    /// The ratio of the baselines: [`Rig::baseline_ratio`](crate::Rig::baseline_ratio). With another ratio than that of
    /// the rig, points do not coincide in any plane.
    pub baseline_ratio: BaselineRatio,
}

impl Default for PlaneSweepOptions {
    /// From -4 to 4 pixels, with balanced effort and equal baselines.
    fn default() -> Self {
        Self {
            disparity_min_px: -4.0,
            disparity_max_px: 4.0,
            effort: Effort::default(),
            baseline_ratio: BaselineRatio::EQUAL,
        }
    }
}

impl PlaneSweepOptions {
    /// Sets the smallest and the largest disparity, in pixels between adjacent views.
    #[must_use]
    pub const fn range_px(mut self, min_px: f32, max_px: f32) -> Self {
        (self.disparity_min_px, self.disparity_max_px) = (min_px, max_px);
        self
    }

    /// Sets the trade-off between time and error.
    #[must_use]
    pub const fn effort(mut self, effort: Effort) -> Self {
        self.effort = effort;
        self
    }

    /// Sets the ratio of the baselines.
    #[must_use]
    pub const fn baseline_ratio(mut self, ratio: BaselineRatio) -> Self {
        self.baseline_ratio = ratio;
        self
    }
}

/// The disparity of the central view, estimated by [`plane_sweep`].
#[derive(Debug, Clone, PartialEq)]
pub struct DisparityEstimate {
    /// Disparity in pixels between adjacent views, positive nearer than the focus plane; `(v, u)`.
    pub disparity_px: Array2<f32>,
    /// The confidence from 0, no information, to 1; `(v, u)`.
    pub confidence: Array2<f32>,
}

/// Estimates the disparity of every pixel of the central view: multi-view stereo by plane sweep.
///
/// Some views are compared with the central one. Every pixel gets the plane of constant disparity in which the
/// colors of the views agree best. The disparity of every pixel is then refined between the planes.
///
/// # Shape
///
/// `(v, u)` for both maps. The first three channels are matched, or the first one of one or two. The light field has at
/// least two views, in a grid, a row or a column. Views in which a point is outside the image are excluded.
///
/// # Units
///
/// Disparity in pixels between adjacent views: a point at `(v, u)` of the central view is at `(v - r_y*d*dt, u -
/// r_x*d*ds)` in the view `dt` rows down and `ds` columns right, where `r_y` and `r_x` are the two numbers of the
/// [`BaselineRatio`], both 1 for equal baselines. Samples may be `u8`, `u16` or `f32` of any scale.
///
/// # Accuracy
///
/// Slanted planes with a smooth texture and without noise: within 0.01 px for [`Effort::Balanced`] and up, outside a
/// border of 7 pixels. Noise and flat areas: `cargo xtask report`. Mirrors and glass get the disparity of their reflections and refractions, or an arbitrary one.
/// Regions without texture follow their neighbors. The result does not depend on the number of threads.
///
/// # Errors
///
/// [`Error::BadNumber`] if the range is empty or not within +-1e6 px, or a sample of a selected view is NaN or
/// infinite; [`Error::ZeroCount`] if there is only one view; [`Error::NoBaseline`] if all views lie along an axis whose
/// baseline is 0; [`Error::TooManyPlanes`] if the range needs more than 4096 planes at this effort;
/// [`Error::OutOfMemory`] and [`Error::TooLarge`] if there is not enough memory.
///
/// # Source
///
/// Plane sweep: Collins 1996. Coarse to fine: Quam 1984. Selection of half of the views: Kang, Szeliski and Chai 2001. Aggregation along
/// scanlines: Hirschmueller 2008. Refinement: a Gauss-Newton step per pixel (Lucas and Kanade 1981) and a weighted
/// plane fit to the steps around it. Edges: the weighted median of Ma et al. 2013.
///
/// # Examples
///
/// ```
/// use holo_core::{Effort, LightField, PlaneSweepOptions, plane_sweep};
/// use ndarray::Array5;
///
/// // 3 x 3 views of a wall whose points move half a pixel from view to view.
/// let wall = |v: f32, u: f32| 0.5 + 0.2 * (0.7 * u).sin() + 0.2 * (0.6 * v).cos();
/// let samples = Array5::from_shape_fn((24, 24, 3, 3, 1), |(v, u, t, s, _)| {
///     wall(v as f32 + 0.5 * (t as f32 - 1.0), u as f32 + 0.5 * (s as f32 - 1.0))
/// });
/// let light_field = LightField::new(samples)?;
/// let options = PlaneSweepOptions::default().range_px(-1.0, 1.0).effort(Effort::Balanced);
/// let estimate = plane_sweep(&light_field, &options)?;
/// assert!((estimate.disparity_px[[12, 12]] - 0.5).abs() < 0.01);
/// assert!(estimate.confidence[[12, 12]] > 0.9);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn plane_sweep<S>(light_field: &LightField<S>, options: &PlaneSweepOptions) -> Result<DisparityEstimate, Error>
where
    S: Data,
    S::Elem: Sample,
{
    check_range(options.disparity_min_px, options.disparity_max_px)?;
    let settings = options.effort.settings();
    let views = Views::gather(light_field, &settings, options.baseline_ratio)?;
    estimated(&views, &settings, options)
}

/// The estimate from views, within the range of the options.
fn estimated(views: &Views, settings: &Settings, options: &PlaneSweepOptions) -> Result<DisparityEstimate, Error> {
    let (map, planes) = solve(views, settings, options.disparity_min_px, options.disparity_max_px, 0)?;
    let confidence = planes.into_iter().map(|plane| confidence(plane.information)).collect();
    let shape = (views.size.rows, views.size.columns);
    Ok(DisparityEstimate {
        disparity_px: Array2::from_shape_vec(shape, map).expect("one value a pixel"),
        confidence: Array2::from_shape_vec(shape, confidence).expect("one value a pixel"),
    })
}

/// The map of a level and its fits, after those of the coarser levels.
fn solve(
    views: &Views,
    settings: &Settings,
    low: f32,
    high: f32,
    level: usize,
) -> Result<(Vec<f32>, Vec<Plane>), Error> {
    // A range of too many planes is refused before any work. Coarser levels have fewer.
    let planes = spread(views, settings, low, high)?;
    let guide = views.guide()?;
    let prior = match views.halved()? {
        Some(coarse) => {
            let (map, fitted) = solve(&coarse, settings, 0.5 * low, 0.5 * high, level + 1)?;
            Some(Prior::new(&coarse, &map, &fitted, &guide, views.size)?)
        }
        None => None,
    };
    let mut map = sweep::sweep(views, &planes, &guide, prior.as_ref(), sweep::BAND_BYTES)?;
    drop(guide);
    if let Some(prior) = &prior {
        prior.replace(&mut map, planes.step_px);
    }
    let coarse = prior.as_ref().map_or(&[][..], Prior::planes);

    // The sweep is accurate to one step or to half a pixel of the outermost view, and every round to less. A larger
    // difference is another surface.
    let mut gate_px = planes.step_px.max(0.5 / views.reach()) * if level > 0 { COARSE_GATE } else { 1.0 };
    let mut image = views.center.clone();
    let mut fitted = Vec::new();
    for _ in 0..settings.refinements {
        let gradients = Image { samples: &image, is_mean: !fitted.is_empty() };
        let found = measure::measure(views, &map, gradients, high, planes.step_px)?;
        let fit = Fit { radius_px: settings.radius_px, gate_px, widest_px: WIDEST * gate_px };
        fitted = fit.smooth(views.size, &map, &found, &fitted, coarse)?;
        map = sharpen::sharpen(views.size, &fitted, &found.image)?;
        map.iter_mut().for_each(|disparity_px| *disparity_px = disparity_px.clamp(low, high));
        image = found.image;
        gate_px *= settings.next_gate;
    }
    Ok((map, fitted))
}

fn check_range(low: f32, high: f32) -> Result<(), Error> {
    for (what, value) in [("smallest disparity in pixels", low), ("largest disparity in pixels", high)] {
        // No range contains NaN.
        if !(-LARGEST_PX..=LARGEST_PX).contains(&value) {
            return Err(Error::BadNumber { what, value: f64::from(value), need: "within -1e6 to 1e6" });
        }
    }
    if low < high {
        return Ok(());
    }
    let need = "above the smallest disparity";
    Err(Error::BadNumber { what: "largest disparity in pixels", value: f64::from(high), need })
}

/// The planes of a sweep: from one to the next the outermost view moves by the step of the settings.
fn spread(views: &Views, settings: &Settings, low: f32, high: f32) -> Result<Planes, Error> {
    let step_px = settings.step_px / views.reach();
    let count = (((high - low) / step_px).ceil() as usize).saturating_add(1).max(5);
    if count > MOST_PLANES {
        return Err(Error::TooManyPlanes { low_px: low, high_px: high, planes: count, most: MOST_PLANES });
    }
    Ok(Planes { first_px: low, step_px: (high - low) / (count - 1) as f32, count })
}

/// The confidence of an amount of information: 0 for none, 1 in the limit.
fn confidence(information: f32) -> f32 {
    let scaled = information * HALF_CONFIDENCE_PX * HALF_CONFIDENCE_PX;
    if scaled.is_finite() { scaled / (1.0 + scaled) } else { 1.0 }
}
