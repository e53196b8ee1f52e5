//! From rays to values: one integrator a file.

mod adaptive;
pub(crate) mod auto;
pub(crate) mod depth;
pub(crate) mod direct;
mod lights;
pub(crate) mod path;
mod scatterer;
mod shade;
pub(crate) mod truth;

use holo_core::Disparity;

use crate::accel::{Engine, LANES};
use crate::appearance::Appearance;
use crate::emitters::Emitters;
use crate::environment::Surroundings;
use crate::geometry::Geometry;
use crate::light::PreparedLight;
use crate::primary::{Pixels, RigTables};
use crate::render::Stop;
use crate::sampling::{self, Purpose};

/// What the pixels of a light field hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// The cheapest one that is exact for the scene, up to [`crate::Request::indirect`].
    #[default]
    Auto,
    /// Ground truth alone, no colour.
    Depth,
    /// One bounce: what lights, emitters and the sky send to the first surface. What mirrors and glass show is black
    /// except for sky and emitters.
    Direct,
    /// Light that is scattered up to [`crate::Request::max_bounces`] times.
    Path,
}

/// What every integrator reads while it works.
pub(crate) struct Context<'a> {
    pub engine: &'a dyn Engine,
    pub geometry: &'a Geometry,
    pub appearance: &'a Appearance,
    pub lights: &'a [PreparedLight],
    pub sky: [f32; 3],
    pub tables: RigTables,
    pub disparity: Disparity,
    /// The camera's axes (right, up, back) in the world.
    pub to_world: [[f64; 3]; 3],
    pub seed: u64,
    pub samples: u32,
    /// Scattering events at most.
    pub max_bounces: u32,
    /// Whether weak paths may end at random.
    pub roulette: bool,
    /// Relative standard error after which a pixel needs no more samples.
    pub target_error: Option<f64>,
    /// Whether light is followed from surfaces other than metal and glass.
    pub indirect: bool,
    pub emitters: Option<&'a Emitters>,
    pub surroundings: Option<&'a Surroundings>,
    /// Whether any light has an extent on the sky.
    pub has_discs: bool,
    /// Whether surfaces that glow may have holes.
    pub has_holes: bool,
    /// Whether rays must know what they hit even if nothing more is scattered there.
    pub has_glow: bool,
    /// Lens columns and view columns, for the numbers of lenses and views.
    pub columns: [u32; 2],
    /// Asked between samples.
    pub stop: &'a Stop<'a>,
}

/// Rays traced, by what they were for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From a pixel into the scene.
    pub primary: u64,
    /// From a surface towards a light.
    pub shadow: u64,
    /// Scattered by a surface.
    pub other: u64,
}

impl RayCounts {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.other
    }
}

impl std::ops::Add for RayCounts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            primary: self.primary + other.primary,
            shadow: self.shadow + other.shadow,
            other: self.other + other.other,
        }
    }
}

impl Context<'_> {
    /// Whether rays that the event number `event` (from 0) scatters can bring anything.
    #[inline(always)]
    pub fn scatters_on(&self, event: u32) -> bool {
        event + 1 < self.max_bounces || self.has_glow || self.shines_from_beyond()
    }

    /// Whether rays that leave the scene find anything.
    #[inline(always)]
    pub fn shines_from_beyond(&self) -> bool {
        self.sky[0] + self.sky[1] + self.sky[2] > 0.0 || self.surroundings.is_some() || self.has_discs
    }

    /// Whether scattered rays must remember how likely their direction was.
    #[inline(always)]
    pub fn needs_density(&self) -> bool {
        self.emitters.is_some() || self.surroundings.is_some()
    }

    /// The random sequences of a packet's pixels.
    #[inline(always)]
    pub fn sequences(&self, pixels: &Pixels) -> [u32; LANES] {
        let [v, u, t, s] = pixels.axes;
        let (mut lens, mut view) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            lens[lane] = v.index[lane] * self.columns[0] + u.index[lane];
            view[lane] = t.index[lane] * self.columns[1] + s.index[lane];
        }
        sampling::sequences(self.seed, &lens, &view)
    }

    /// Where sample `sample` of every pixel lies within its pixel: at the same place for the 4 x 4 views of a block, at
    /// places of its own for every block and every lens.
    ///
    /// What is shared keeps a packet's rays a narrow bundle: with places of their own, rays and shadow rays of direct
    /// light took three times as long. Every view alone sees points as good as its own, and its error is the same. The
    /// mean over many views is less exact than it could be: over 12 x 12 views at 16 samples its relative squared error
    /// is 8e-5 where independent places give 5e-6 (a view alone has 7e-4).
    #[inline(always)]
    pub fn points(&self, pixels: &Pixels, sample: u32) -> sampling::Points {
        let [v, u, t, s] = pixels.axes;
        let (mut lens, mut block) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            lens[lane] = v.index[lane] * self.columns[0] + u.index[lane];
            let side = views_that_share();
            // Set apart from the views themselves by the highest bit.
            block[lane] = (t.index[lane] / side * self.columns[1] + s.index[lane] / side) | 1 << 31;
        }
        sampling::points(&sampling::sequences(self.seed, &lens, &block), sample, Purpose::PIXEL)
    }
}

/// How wide a block of views is whose samples lie at the same places of their pixels.
#[inline(always)]
fn views_that_share() -> u32 {
    #[cfg(feature = "bench")]
    if crate::bench::sampler() != crate::bench::Sampler::Shared {
        return 1;
    }
    4
}
