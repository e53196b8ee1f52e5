//! From rays to values: one integrator a file.

pub(crate) mod depth;
pub(crate) mod direct;

use holo_core::Disparity;

use crate::accel::{Engine, LANES};
use crate::geometry::Geometry;
use crate::light::PreparedLight;
use crate::primary::{Pixels, RigTables};
use crate::render::Stop;
use crate::sampling;
use crate::surface::Appearance;

/// What the pixels of a light field hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// The cheapest one that shows what the scene has: `Direct` where anything shines, else `Depth`.
    #[default]
    Auto,
    /// Ground truth alone, no colour.
    Depth,
    /// One bounce: every punctual light with hard shadows, and the sky with occlusion, on Lambertian surfaces.
    Direct,
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
    pub seed: u64,
    pub samples: u32,
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
    /// From a surface towards a light or the sky.
    pub shadow: u64,
}

impl std::ops::Add for RayCounts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { primary: self.primary + other.primary, shadow: self.shadow + other.shadow }
    }
}

impl Context<'_> {
    /// The random sequences of a packet's pixels.
    #[inline(always)]
    fn sequences(&self, pixels: &Pixels) -> [u32; LANES] {
        let [v, u, t, s] = pixels.axes;
        let (mut lens, mut view) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            lens[lane] = v.index[lane] * self.columns[0] + u.index[lane];
            view[lane] = t.index[lane] * self.columns[1] + s.index[lane];
        }
        sampling::sequences(self.seed, &lens, &view)
    }
}
