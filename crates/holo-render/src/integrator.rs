//! From rays to values: one integrator a file.

pub(crate) mod auto;
pub(crate) mod depth;
pub(crate) mod direct;
mod direct_light;
mod light_sampling;
mod mis;
pub(crate) mod path;
mod paths;
mod resampling;
mod scatterer;
mod shade;
pub(crate) mod truth;

use crate::accel::Engine;
use crate::camera::RaySource;
use crate::geometry::Geometry;
use crate::light::Emitters;
use crate::light::EnvironmentLight;
use crate::light::PreparedLight;
use crate::material::Appearance;
use crate::progress::Stop;
use crate::sampling::Sampler;

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
    pub scene: SceneData<'a>,
    pub camera: RaySource,
    pub sampler: Sampler,
    pub policy: Policy,
    /// Asked between samples.
    pub stop: &'a Stop<'a>,
}

/// What rays meet.
#[derive(Clone, Copy)]
pub(crate) struct SceneData<'a> {
    pub engine: &'a dyn Engine,
    pub geometry: &'a Geometry,
    pub appearance: &'a Appearance,
    pub lights: &'a [PreparedLight],
    pub emitters: Option<&'a Emitters>,
    pub surroundings: Option<&'a EnvironmentLight>,
    pub sky: [f32; 3],
    /// The camera's axes (right, up, back) in the world.
    pub to_world: [[f64; 3]; 3],
    /// Whether any light has an extent on the sky.
    pub has_discs: bool,
    /// Whether surfaces that glow may have holes.
    pub has_holes: bool,
    /// Whether rays must know what they hit even if nothing more is scattered there.
    pub has_glow: bool,
}

/// How far paths are followed, and when a pixel has enough of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Policy {
    /// Scattering events at most.
    pub max_bounces: u32,
    /// Whether weak paths may end at random.
    pub roulette: bool,
    /// Relative standard error after which a pixel needs no more samples.
    pub target_error: Option<f64>,
    /// Whether light is followed from surfaces other than metal and glass.
    pub indirect: bool,
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

impl SceneData<'_> {
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
}

impl Context<'_> {
    /// Whether rays that the event number `event` (from 0) scatters can bring anything.
    #[inline(always)]
    pub fn scatters_on(&self, event: u32) -> bool {
        event + 1 < self.policy.max_bounces || self.scene.has_glow || self.scene.shines_from_beyond()
    }
}
