//! Light sampling: which lights a path vertex asks for light, and a sample of each.
//!
//! Every punctual light, or all of them as candidates for one; some points on emissive surfaces, candidates for one as well;
//! a direction of the environment map.

use super::Context;
use super::shade::Shading;
use crate::geometry::Hit;
use crate::light::{PreparedLight, SHADOW_REACH};
use crate::sampling::{Draw, Points, Purpose};
use crate::simd::LANES;

/// Up to this many punctual lights the first vertex samples every one.
const ALL_LIGHTS: usize = 8;

/// Points on emissive surfaces that are RIS candidates at the first vertex, and at later ones. Measured on six scenes of the gallery,
/// lit by rooms, windows and lanterns, 4 samples a pixel: against one point the squared error falls to 0.43 (plaster) to 0.72
/// (lanterns), and the time grows by 12 to 29 %. Eight points cost another 4 to 32 % and gain 2 to 17 %.
const CANDIDATES: [u32; 2] = [4, 1];

/// How many samples all candidates of a vertex together count as against the one direction that the BSDF samples (the factor of
/// light sampling in the balance heuristic; any value is unbiased). With 1 the scattered ray, which matters most for mirrors, keeps
/// its weight; with as many as there are candidates everything depends on the one shadow ray.
const CANDIDATES_COUNT_AS: [f32; 2] = [2.0, 1.0];

/// Light on its way to sixteen points.
pub(super) struct LightSample {
    pub to_light: [[f32; LANES]; 3],
    pub inverse_length: [f32; LANES],
    /// How far to look, in multiples of `to_light`.
    pub far: [f32; LANES],
    /// Irradiance of a surface that faces the light; radiance where the light was sampled by a pdf.
    pub strength: [[f32; LANES]; 3],
    /// The light-sampling pdf per solid angle, if scattered rays may hit the light as well; else infinite.
    pub pdf: [f32; LANES],
}

/// The light samples of one vertex.
pub(super) struct LightSelection {
    punctual: usize,
    /// Points on emissive surfaces.
    points: usize,
    environment: bool,
    /// Whether one punctual light stands for all.
    one_punctual: bool,
}

/// What becomes of a light sample.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// It counts for itself.
    Counts,
    /// It is one of the candidates of a group for a single shadow ray.
    Candidate { group: usize, first: bool, last: bool },
}

impl LightSelection {
    #[inline(always)]
    pub fn new(context: &Context, here: &Shading) -> Self {
        let punctual = context.scene.lights.len();
        Self {
            punctual,
            points: if context.scene.emitters.is_some() { candidates(here.event).0 as usize } else { 0 },
            environment: context.scene.surroundings.is_some(),
            one_punctual: punctual > ALL_LIGHTS || (here.event > 0 && punctual > 1),
        }
    }

    /// How many samples there are.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.punctual + self.points + usize::from(self.environment)
    }

    /// The random numbers that choose among candidates, one for each group.
    #[inline(always)]
    pub fn numbers(&self, context: &Context, here: &Shading) -> Points {
        if self.one_punctual | (self.points > 0) { draw(context, here, Draw::Light) } else { [[0.0; LANES]; 2] }
    }

    /// What becomes of sample number `k`.
    #[inline(always)]
    pub fn role(&self, k: usize) -> Role {
        let behind = self.punctual + self.points;
        if self.one_punctual && k < self.punctual {
            Role::Candidate { group: 0, first: k == 0, last: k + 1 == self.punctual }
        } else if k >= self.punctual && k < behind {
            Role::Candidate { group: 1, first: k == self.punctual, last: k + 1 == behind }
        } else {
            Role::Counts
        }
    }

    /// Sample number `k`.
    #[inline(always)]
    pub fn sample(&self, context: &Context, here: &Shading, k: usize) -> LightSample {
        if k < self.punctual {
            punctual(context, here, &context.scene.lights[k])
        } else if k < self.punctual + self.points {
            emitter(context, here, (k - self.punctual) as u32)
        } else {
            environment(context, here)
        }
    }
}

/// How many points on emissive surfaces are candidates at the vertex number `event`, and as how many samples they count.
#[inline(always)]
pub(super) fn candidates(event: u32) -> (u32, f32) {
    let later = usize::from(event > 0);
    (CANDIDATES[later], CANDIDATES_COUNT_AS[later])
}

#[inline(always)]
fn draw(context: &Context, here: &Shading, draw: Draw) -> Points {
    context.sampler.points(here.sequences, &here.paths.sample, Purpose::event(here.event, draw))
}

#[inline(always)]
fn punctual(context: &Context, here: &Shading, light: &PreparedLight) -> LightSample {
    let position = if context.scene.has_discs { draw(context, here, Draw::Disc) } else { [[0.5; LANES]; 2] };
    let arrivals = light.arrivals(&here.surfaces.start, &position);
    let power = light.power();
    let mut strength = [[0.0; LANES]; 3];
    for c in 0..3 {
        for lane in 0..LANES {
            strength[c][lane] = power[c] * arrivals.attenuation[lane];
        }
    }
    LightSample {
        to_light: arrivals.to_light,
        inverse_length: arrivals.inverse_length,
        far: [light.shadow_reach(); LANES],
        strength,
        pdf: [f32::INFINITY; LANES],
    }
}

/// Candidate number `k` on emissive surfaces: together with those of the other samples they are one sequence, spread over all
/// emissive triangles.
#[inline(always)]
fn emitter(context: &Context, here: &Shading, k: u32) -> LightSample {
    let zero = [0.0; LANES];
    let mut out = LightSample {
        to_light: [zero; 3],
        inverse_length: zero,
        far: [SHADOW_REACH; LANES],
        strength: [zero; 3],
        pdf: zero,
    };
    let Some(emitters) = context.scene.emitters else { return out };
    let (count, weight) = candidates(here.event);
    let mut indices = [0; LANES];
    for lane in 0..LANES {
        indices[lane] = here.paths.sample[lane] * count + k;
    }
    let draw = |draw| context.sampler.points(here.sequences, &indices, Purpose::event(here.event, draw));
    let [choice, _] = draw(Draw::EmitterChoice);
    let sample = emitters.sample(&here.surfaces.start, &choice, &draw(Draw::Emitter));
    let mut wanted = [false; LANES];
    for lane in 0..LANES {
        let mut squared = 0.0;
        for axis in 0..3 {
            squared += sample.to_light[axis][lane] * sample.to_light[axis][lane];
        }
        out.inverse_length[lane] = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        wanted[lane] = here.hit[lane] & (sample.pdf[lane] > 0.0);
    }
    // A pdf above 0 means that the point shows a side that emits; if both do, they emit alike.
    let side = [1.0; LANES];
    let barycentrics = [&sample.u, &sample.v];
    let mut triangles = [Hit::flattened(0); LANES];
    for lane in 0..LANES {
        triangles[lane] = Hit::flattened(sample.triangle[lane] as usize);
    }
    out.strength = context.scene.appearance.emission(context.scene.geometry, &triangles, barycentrics, &side, &wanted);
    if context.scene.has_holes {
        for lane in (0..LANES).filter(|&lane| wanted[lane]) {
            let barycentrics = [sample.u[lane], sample.v[lane]];
            let opacity = context.scene.appearance.opacity(context.scene.geometry, triangles[lane], barycentrics);
            for c in 0..3 {
                out.strength[c][lane] *= opacity;
            }
        }
    }
    out.to_light = sample.to_light;
    for lane in 0..LANES {
        out.pdf[lane] = sample.pdf[lane] * weight;
        // Each candidate stands for its share of all.
        for c in 0..3 {
            out.strength[c][lane] *= weight / count as f32;
        }
    }
    out
}

/// A direction of the environment map.
#[inline(always)]
fn environment(context: &Context, here: &Shading) -> LightSample {
    let zero = [0.0; LANES];
    let (to_light, strength, pdf) = match context.scene.surroundings {
        Some(surroundings) => {
            let sample = surroundings.sample(&draw(context, here, Draw::EnvironmentLight));
            (sample.direction, sample.radiance, sample.pdf)
        }
        None => ([zero; 3], [zero; 3], zero),
    };
    LightSample { to_light, inverse_length: [1.0; LANES], far: [f32::INFINITY; LANES], strength, pdf }
}
