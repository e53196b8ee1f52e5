//! Integrators: from rays to pixel values. One integrator per file.

pub(crate) mod aov;
pub(crate) mod auto;
pub(crate) mod depth;
pub(crate) mod direct;
mod direct_light;
mod light_sampling;
mod mis;
pub(crate) mod path;
mod paths;
pub(crate) mod progress;
mod resampling;
mod reuse;
mod scatterer;
mod shade;
mod straight_shadows;
mod unseen;
mod vertex;

use crate::accel::Engine;
use crate::camera::RaySource;
use crate::camera::moved::Moved;
use crate::film::guides::Movement;
use crate::geometry::Geometry;
use crate::integrator::progress::Stop;
use crate::light::Emitters;
use crate::light::EnvironmentLight;
use crate::light::PreparedLight;
use crate::material::Appearance;
use crate::sampling::Sampler;

/// The integrator of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// The cheapest integrator that is exact for the scene, up to the choice of [`crate::Request::indirect`].
    #[default]
    Auto,
    /// Ground truth only, without color.
    Depth,
    /// Direct light, a single bounce: light that the first hit receives from punctual lights, emissive surfaces and the
    /// environment. Mirrors and glass show only emission and the environment; everything else in them is black.
    Direct,
    /// Path tracing: light with up to [`crate::Request::max_bounces`] bounces.
    Path,
}

/// The inputs of an integrator.
pub(crate) struct Context<'a> {
    pub scene: SceneData<'a>,
    pub camera: RaySource,
    pub sampler: Sampler,
    pub policy: Policy,
    /// What the guides of the reconstruction hold, if they are wanted.
    pub guides: Option<Movement>,
    /// Whether statistics of the inverse depth are wanted.
    pub inverse_depths: bool,
    /// Where the camera stands, if not at the origin of the scene's coordinates.
    pub moved: Option<&'a Moved>,
    /// Checked between samples.
    pub stop: &'a Stop<'a>,
}

/// The scene as the integrators use it.
#[derive(Clone, Copy)]
pub(crate) struct SceneData<'a> {
    pub engine: &'a dyn Engine,
    pub geometry: &'a Geometry,
    pub appearance: &'a Appearance,
    pub lights: &'a [PreparedLight],
    pub emitters: Option<&'a Emitters>,
    pub environment: Option<&'a EnvironmentLight>,
    pub sky: [f32; 3],
    /// What camera rays receive instead of the environment.
    pub backdrop: Option<[f32; 3]>,
    /// The axes of the camera (right, up, back) in world coordinates.
    pub to_world: [[f64; 3]; 3],
    /// Whether any directional light has an angular diameter.
    pub has_discs: bool,
    /// Whether materials use alpha, so that emissive surfaces may have an opacity below 1.
    pub has_alpha: bool,
    /// Whether there are bodies of glass, so that paths carry the media around them.
    pub has_media: bool,
    /// Whether surfaces emit, so that rays must be intersected even after the last bounce.
    pub has_emission: bool,
}

/// The termination of paths and of sampling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Policy {
    /// The maximum number of bounces.
    pub max_bounces: u32,
    /// Whether paths are subject to Russian roulette.
    pub roulette: bool,
    /// The target of the relative standard error of a pixel, for adaptive sampling.
    pub target_error: Option<f64>,
    /// Whether paths continue from surfaces other than metal and glass.
    pub indirect: bool,
    /// Whether the views of a packet share the light that their scattered rays find.
    pub reuse: bool,
    /// Whether light is scattered more than once between the microfacets of rough surfaces.
    pub multiple_scattering: bool,
    /// The largest contribution of one path vertex after the first.
    pub indirect_limit: f32,
    /// Whether shadow rays go straight through smooth glass.
    pub transparent_shadows: bool,
}

/// The number of traced rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Camera rays, from a pixel into the scene: one per sample. Those of views that share light are traced twice and counted
    /// once; those that only find what a pixel without samples shows are not counted.
    pub primary: u64,
    /// Shadow rays, from a surface towards a light.
    pub shadow: u64,
    /// Secondary rays, which a surface has scattered.
    pub secondary: u64,
}

impl RayCounts {
    /// The number of all rays.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.secondary
    }
}

impl std::ops::Add for RayCounts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            primary: self.primary + other.primary,
            shadow: self.shadow + other.shadow,
            secondary: self.secondary + other.secondary,
        }
    }
}

impl SceneData<'_> {
    /// Whether rays that miss the scene receive light: from the environment, or from the disc of a directional light.
    #[inline(always)]
    pub fn has_light_at_infinity(&self) -> bool {
        self.sky[0] + self.sky[1] + self.sky[2] > 0.0 || self.environment.is_some() || self.has_discs
    }

    /// Whether scattered rays need the pdf of their direction for multiple importance sampling.
    #[inline(always)]
    pub fn needs_bsdf_pdf(&self) -> bool {
        self.emitters.is_some() || self.environment.is_some() || self.has_discs
    }
}

impl Context<'_> {
    /// Whether rays that are scattered at path vertex number `vertex` (from 0) can contribute.
    #[inline(always)]
    pub fn continues_after(&self, vertex: u32) -> bool {
        vertex + 1 < self.policy.max_bounces || self.scene.has_emission || self.scene.has_light_at_infinity()
    }
}
