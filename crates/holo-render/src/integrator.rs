//! From rays to values: one integrator a file.

pub(crate) mod depth;
pub(crate) mod direct;

use holo_core::Disparity;

use crate::accel::{Engine, LANES};
use crate::geometry::Geometry;
use crate::light::PreparedLight;
use crate::primary::{Pixels, RigTables};
use crate::render::Stop;
use crate::sampling::{self, Purpose};
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
    pub fn sequences(&self, pixels: &Pixels) -> [u32; LANES] {
        let [v, u, t, s] = pixels.axes;
        let (mut lens, mut view) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            lens[lane] = v.index[lane] * self.columns[0] + u.index[lane];
            view[lane] = t.index[lane] * self.columns[1] + s.index[lane];
        }
        sampling::sequences(self.seed, &lens, &view)
    }

    /// Where sample `sample` of every pixel lies within its pixel.
    ///
    /// The 4 x 4 views of a block share the sixteenth of the pixel in which their samples lie, each with its own place in
    /// it; from sample to sample the sixteenths are the points of one sequence, so that every 16 samples visit each once.
    /// Every view alone sees independent points of the whole pixel (no bias). What is shared keeps a packet's rays a
    /// narrow bundle: with a place of its own for each, dense scenes took three times as long.
    #[inline(always)]
    pub fn points(&self, pixels: &Pixels, sequences: &[u32; LANES], sample: u32) -> sampling::Points {
        let [v, u, t, s] = pixels.axes;
        let (mut lens, mut block) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            lens[lane] = v.index[lane] * self.columns[0] + u.index[lane];
            // Set apart from the views themselves by the highest bit.
            block[lane] = (t.index[lane] / 4 * self.columns[1] + s.index[lane] / 4) | 1 << 31;
        }
        let cells = sampling::points(&sampling::sequences(self.seed, &lens, &block), sample, Purpose::Pixel);
        let mut points = sampling::points(sequences, sample, Purpose::Pixel);
        for axis in 0..2 {
            for lane in 0..LANES {
                points[axis][lane] = ((cells[axis][lane] * 4.0).floor() + points[axis][lane]) * 0.25;
            }
        }
        points
    }
}
