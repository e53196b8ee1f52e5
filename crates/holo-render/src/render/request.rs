//! What to render, and what comes of it.

use std::ops::Range;

use holo_core::{LightFieldOwned, Rig, ViewIndex};
use ndarray::Array3;

use crate::error::Error;
use crate::film::layers::{Layer, LayerSet, Layers};
use crate::geometry::LARGEST_COORDINATE;
use crate::integrator::{Integrator, RayCounts, direct};
use crate::sampling::{MOST_SAMPLES, Sampling};
use holo_scene::MAX_RADIANCE;

/// Scattering events at most: far more than any scene needs, far less than the purposes of random numbers.
const MOST_BOUNCES: u32 = 65_536;

/// The largest number up to which f32 holds all whole ones: 2^24.
pub(super) const MOST_NUMBERED: usize = 1 << 24;

/// What to render.
#[derive(Clone, Debug)]
pub struct Request {
    /// The cameras.
    pub rig: Rig,
    /// How light is modelled.
    pub integrator: Integrator,
    /// Rays through every pixel: 1 goes through its centre, more are spread over it (a box filter).
    pub samples: u32,
    /// Chooses the random numbers.
    pub seed: u64,
    /// Radiance of the constant sky, linear RGB.
    pub sky: [f32; 3],
    /// Scattering events at most, for the integrator `Path` and for `Auto` when it chooses that.
    pub max_bounces: u32,
    /// Whether paths that carry little may end at random, those that survive counting for more (unbiased).
    pub roulette: bool,
    /// Relative standard error per pixel at which it needs no more samples; `samples` are the most it gets then.
    pub target_error: Option<f64>,
    /// Whether `Auto` follows light from surface to surface; without, only to mirrors and glass.
    pub indirect: bool,
    /// Which layers are wanted beside colour; always of what the ray through the pixel's centre meets first, whatever
    /// `samples` is.
    pub layers: LayerSet,
    /// For which views they are wanted.
    pub ground_truth: GroundTruth,
    /// Which views are rendered.
    pub views: Views,
    /// How the samples of a pixel are chosen.
    pub sampling: Sampling,
    /// The rows of lenses that are wanted; `None`: all. They come out as they would within the whole if they are such as
    /// [`Renderer::part_of_lens_rows`](super::Renderer::part_of_lens_rows) gives.
    pub lens_rows: Option<Range<usize>>,
}

impl Request {
    /// Everything as the command line has it by default, with one sample and without a sky.
    #[must_use]
    pub fn new(rig: Rig) -> Self {
        Self {
            rig,
            integrator: Integrator::Auto,
            samples: 1,
            seed: 0,
            sky: [0.0; 3],
            max_bounces: 8,
            roulette: true,
            target_error: None,
            indirect: true,
            layers: DEPTH_AND_DISPARITY,
            ground_truth: GroundTruth::Central,
            views: Views::All,
            sampling: Sampling::default(),
            lens_rows: None,
        }
    }
}

/// What nearly everybody wants.
pub(super) const DEPTH_AND_DISPARITY: LayerSet = LayerSet::of(&[Layer::Depth, Layer::Disparity]);

/// Which views of a rig are rendered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Views {
    /// Every one, at its place.
    #[default]
    All,
    /// These, side by side in one row: the light fields of [`Rendered`] have 1 x N views. Every pixel has the random numbers
    /// that it has in the whole image.
    List(Vec<ViewIndex>),
}

/// For which views ground truth is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundTruth {
    /// The central view of the rig, whether it is among [`Request::views`] or not.
    #[default]
    Central,
    /// Every view of [`Request::views`] (the central one as well).
    All,
}

/// What was rendered. Light fields lie in memory as elemental grids; all arrays have the lens rows that were asked for.
#[derive(Debug)]
pub struct Rendered {
    /// Linear RGB radiance; `None` from the integrator `Depth`.
    pub color: Option<LightFieldOwned<f32>>,
    /// The layers of the central view, axes (v, u, c).
    pub central: Layers<Array3<f32>>,
    /// The layers of all views, if they were asked for.
    pub all: Option<Layers<LightFieldOwned<f32>>>,
    /// The integrator used.
    pub integrator: Integrator,
    /// Why it was.
    pub why: String,
    /// How many rays it took, ground truth included.
    pub rays: RayCounts,
    /// How many samples the picture took: views x lenses x samples unless there was a target error.
    pub samples: u64,
}

impl Request {
    /// Refuses what cannot be rendered of a scene of so many instances and materials.
    pub(super) fn check(&self, [instances, materials]: [usize; 2]) -> Result<(), Error> {
        let split = self.rig.shape();
        if !(1..=MOST_SAMPLES).contains(&self.samples) {
            return Err(Error::BadSetting(format!(
                "{} samples per pixel; 1 to {MOST_SAMPLES} can be drawn",
                self.samples
            )));
        }
        if self.target_error.is_some_and(|target| !(target > 0.0 && target.is_finite())) {
            return Err(Error::BadSetting("the target error must be finite and above 0".into()));
        }
        if !(1..=MOST_BOUNCES).contains(&self.max_bounces) {
            let asked = self.max_bounces;
            return Err(Error::BadSetting(format!("{asked} bounces; 1 to {MOST_BOUNCES} can be followed")));
        }
        if split.lenses().count() > u32::MAX as usize || split.views().count() > u32::MAX as usize {
            return Err(Error::BadSetting("2^32 or more lenses or views".into()));
        }
        if self.sky.iter().any(|c| !(0.0..=MAX_RADIANCE).contains(c)) {
            return Err(Error::BadSetting(format!("the sky {:?} must lie between 0 and {MAX_RADIANCE:e}", self.sky)));
        }
        // Rays are linear in all indices: what the corners are, no ray between them exceeds.
        let (lenses, views) = (split.lenses(), split.views());
        for (v, u) in [(0, 0), (lenses.rows - 1, lenses.columns - 1)] {
            for (t, s) in [(0, 0), (views.rows - 1, views.columns - 1)] {
                let ray = self.rig.ray(v, u, t, s, 0.5, 0.5);
                if !ray.origin_m.iter().chain(&ray.direction).all(|x| x.abs() < LARGEST_COORDINATE) {
                    return Err(Error::BadSetting(format!(
                        "the rig is too large: a ray starts at {:?} m and runs along {:?}; choose a smaller baseline or sensor",
                        ray.origin_m, ray.direction
                    )));
                }
            }
        }
        for (layer, what, count) in
            [(Layer::ObjectId, "instances", instances), (Layer::MaterialId, "materials", materials)]
        {
            if self.layers.contains(layer) && count > MOST_NUMBERED {
                return Err(Error::BadSetting(format!(
                    "the layer '{layer}' numbers at most {MOST_NUMBERED} {what}; the scene has {count}: leave it out"
                )));
            }
        }
        if let Views::List(list) = &self.views {
            let outside = list.iter().find(|view| view.row >= views.rows || view.column >= views.columns);
            if let Some(ViewIndex { row, column }) = outside {
                return Err(Error::BadSetting(format!(
                    "view row {row}, column {column} is none of the {} rows and {} columns of views",
                    views.rows, views.columns
                )));
            }
            if list.is_empty() {
                return Err(Error::BadSetting("the list of views is empty; name one or more".into()));
            }
        }
        let rows = self.lens_rows();
        if rows.is_empty() || rows.end > lenses.rows {
            let count = lenses.rows;
            return Err(Error::BadSetting(format!("lens rows {rows:?} are not some of the {count} that there are")));
        }
        Ok(())
    }

    /// The rows of lenses that are wanted.
    pub(super) fn lens_rows(&self) -> Range<usize> {
        self.lens_rows.clone().unwrap_or(0..self.rig.shape().lenses().rows)
    }

    /// Scattering events that the integrator follows.
    pub(super) fn bounces(&self, integrator: Integrator) -> u32 {
        if integrator == Integrator::Direct { direct::BOUNCES } else { self.max_bounces }
    }
}
