//! Light sampling: the selection of lights at a path vertex, and a sample of each.
//!
//! The samples are all punctual lights, or one of them by resampling; points on emissive surfaces, of which one is kept
//! by resampling; and a direction of the environment map.

use super::Context;
use super::vertex::Shading;
use crate::geometry::Hit;
use crate::light::{PreparedLight, SHADOW_REACH};
use crate::sampling::{Draw, Points, Purpose};
use crate::simd::LANES;

/// The maximum number of punctual lights that are all sampled at the first vertex.
const ALL_LIGHTS: usize = 8;

/// The number of points on emissive surfaces that are RIS candidates at the first vertex, and at later ones. More
/// candidates reduce the error but cost time; the optimum is flat.
const CANDIDATES: [u32; 2] = [4, 1];

/// The weight of all candidates of a vertex together in the balance heuristic, in samples, against the one BSDF sample.
/// Any value is unbiased. The value 1 gives the most weight to scattered rays, which is best for mirrors; the number of
/// candidates gives almost all of it to the single shadow ray.
const CANDIDATES_WEIGHT: [f32; 2] = [2.0, 1.0];

/// A light sample for sixteen surface points.
pub(super) struct LightSample {
    pub to_light: [[f32; LANES]; 3],
    pub inverse_length: [f32; LANES],
    /// The end of the shadow ray, in multiples of `to_light`.
    pub far: [f32; LANES],
    /// For punctual lights the irradiance on a surface that faces the light; for lights with a pdf the radiance.
    pub strength: [[f32; LANES]; 3],
    /// The light-sampling pdf per solid angle if BSDF sampling can find the light too; otherwise infinite.
    pub pdf: [f32; LANES],
}

/// The unoccluded contribution of a light sample to sixteen pixels, with its shadow ray.
#[derive(Clone, Copy)]
pub(super) struct Contribution {
    pub value: [[f32; LANES]; 3],
    pub start: [[f32; LANES]; 3],
    pub to_light: [[f32; LANES]; 3],
    pub far: [f32; LANES],
    /// 1 / the weight of the light sample against BSDF sampling.
    pub over_weight: [f32; LANES],
}

/// The selection of light samples at one path vertex.
pub(super) struct LightSelection {
    punctual: usize,
    /// Candidate points on emissive surfaces.
    points: usize,
    /// Directions of the environment map.
    environment: usize,
    /// Whether one punctual light is selected by resampling.
    one_punctual: bool,
    /// Whether all lanes use the samples of each, and what scattered rays have found.
    gathers: bool,
}

/// As `CANDIDATES_WEIGHT`, where the scattered rays of all lanes are shared: more of them find the light.
const SHARING_WEIGHT: f32 = 0.7;

/// The role of a light sample.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// An independent sample with a shadow ray of its own.
    Independent,
    /// A RIS candidate of a group that shares one shadow ray.
    Candidate { group: usize, first: bool, last: bool },
    /// What the scattered ray of this lane has found.
    Found(usize),
}

impl LightSelection {
    #[inline(always)]
    pub fn new(context: &Context, here: &Shading, gathers: bool) -> Self {
        let punctual = context.scene.lights.len();
        let directions = if gathers { LANES } else { 1 };
        let points = candidates(here.vertex, gathers).0 as usize;
        Self {
            punctual,
            points: if context.scene.emitters.is_some() { points } else { 0 },
            environment: if context.scene.environment.is_some() { directions } else { 0 },
            one_punctual: punctual > ALL_LIGHTS || (here.vertex > 0 && punctual > 1),
            gathers,
        }
    }

    /// The number of light samples.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.punctual + self.points + self.environment + if self.gathers { LANES } else { 0 }
    }

    /// The random numbers for the choice among RIS candidates, one per group.
    #[inline(always)]
    pub fn numbers(&self, context: &Context, here: &Shading) -> Points {
        if self.one_punctual | (self.points > 0) { draw(context, here, Draw::Light) } else { [[0.0; LANES]; 2] }
    }

    /// The role of sample number `k`.
    #[inline(always)]
    pub fn role(&self, k: usize) -> Role {
        let end = self.punctual + self.points;
        if self.one_punctual && k < self.punctual {
            Role::Candidate { group: 0, first: k == 0, last: k + 1 == self.punctual }
        } else if k >= self.punctual && k < end {
            Role::Candidate { group: 1, first: k == self.punctual, last: k + 1 == end }
        } else if k >= end + self.environment {
            Role::Found(k - end - self.environment)
        } else {
            Role::Independent
        }
    }

    /// Light sample number `k`.
    #[inline(always)]
    pub fn sample(&self, context: &Context, here: &Shading, k: usize) -> LightSample {
        if k < self.punctual {
            punctual(context, here, &context.scene.lights[k])
        } else if k < self.punctual + self.points {
            emitter(context, here, (k - self.punctual) as u32, self.gathers)
        } else {
            environment(context, here, k - self.punctual - self.points, self.gathers)
        }
    }
}

/// The number of RIS candidates on emissive surfaces at path vertex number `vertex`, and their weight in samples;
/// `shares`: for lanes that share their scattered rays.
#[inline(always)]
pub(super) fn candidates(vertex: u32, shares: bool) -> (u32, f32) {
    let later = usize::from(vertex > 0);
    (CANDIDATES[later], if shares { SHARING_WEIGHT } else { CANDIDATES_WEIGHT[later] })
}

#[inline(always)]
fn draw(context: &Context, here: &Shading, draw: Draw) -> Points {
    draw_at(context, here, &here.paths.index, draw)
}

/// A function, because a closure that is called twice is not inlined into the kernel: it would be compiled for the
/// oldest processors.
#[inline(always)]
fn draw_at(context: &Context, here: &Shading, indices: &[u32; LANES], draw: Draw) -> Points {
    context.sampler.points(here.sequences, indices, Purpose::at_vertex(here.vertex, draw))
}

#[inline(always)]
fn punctual(context: &Context, here: &Shading, light: &PreparedLight) -> LightSample {
    let position = if context.scene.has_discs { draw(context, here, Draw::Disc) } else { [[0.5; LANES]; 2] };
    let incident = light.incident(&here.interaction.start, &position);
    // A disc can also be hit by a ray; it has a radiance and a pdf.
    let power = if light.is_disc() { light.disc_radiance() } else { light.power() };
    let mut strength = [[0.0; LANES]; 3];
    for c in 0..3 {
        for lane in 0..LANES {
            strength[c][lane] = power[c] * incident.attenuation[lane];
        }
    }
    LightSample {
        to_light: incident.to_light,
        inverse_length: incident.inverse_length,
        far: [light.shadow_reach(); LANES],
        strength,
        pdf: [light.pdf(); LANES],
    }
}

/// RIS candidate number `k` on emissive surfaces. The candidates of all samples of a pixel are one sequence over all
/// emissive triangles.
#[inline(always)]
fn emitter(context: &Context, here: &Shading, k: u32, gathers: bool) -> LightSample {
    let zero = [0.0; LANES];
    let mut out = LightSample {
        to_light: [zero; 3],
        inverse_length: zero,
        far: [SHADOW_REACH; LANES],
        strength: [zero; 3],
        pdf: zero,
    };
    let Some(emitters) = context.scene.emitters else { return out };
    let (count, weight) = candidates(here.vertex, gathers);
    let mut indices = [0; LANES];
    for lane in 0..LANES {
        indices[lane] = here.paths.index[lane] * count + k;
    }
    let [choice, _] = draw_at(context, here, &indices, Draw::EmitterChoice);
    let point = draw_at(context, here, &indices, Draw::Emitter);
    let sample = emitters.sample(&here.interaction.start, &choice, &point);
    let mut wanted = [false; LANES];
    for lane in 0..LANES {
        let mut squared = 0.0;
        for axis in 0..3 {
            squared += sample.to_light[axis][lane] * sample.to_light[axis][lane];
        }
        out.inverse_length[lane] = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        wanted[lane] = here.hit[lane] & (sample.pdf[lane] > 0.0);
    }
    // A pdf above 0 implies an emissive side; if both sides emit, they emit alike.
    let side = [1.0; LANES];
    let barycentrics = [&sample.u, &sample.v];
    let mut triangles = [Hit::flattened(0); LANES];
    for lane in 0..LANES {
        triangles[lane] = Hit::flattened(sample.triangle[lane] as usize);
    }
    for c in 0..3 {
        for lane in 0..LANES {
            out.strength[c][lane] = if wanted[lane] { sample.radiance[c][lane] } else { 0.0 };
        }
    }
    if sample.any_textured {
        let (appearance, geometry) = (context.scene.appearance, context.scene.geometry);
        out.strength = appearance.emission(geometry, &triangles, None, barycentrics, &side, &wanted);
    }
    if context.scene.has_alpha {
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
        // Each candidate contributes its share of all.
        for c in 0..3 {
            out.strength[c][lane] *= weight / count as f32;
        }
    }
    out
}

/// A sample of the environment map. Packets that share their light take that of lane `k`.
#[inline(always)]
fn environment(context: &Context, here: &Shading, k: usize, gathers: bool) -> LightSample {
    let zero = [0.0; LANES];
    let (to_light, strength, pdf) = match context.scene.environment {
        Some(environment) => {
            let (mut indices, mut share) = (here.paths.index, 1.0);
            if gathers {
                (indices, share) = ([here.paths.index[k]; LANES], 1.0 / LANES as f32);
            }
            let purpose = Purpose::at_vertex(here.vertex, Draw::EnvironmentLight);
            let mut sample = environment.sample(&context.sampler.points(here.sequences, &indices, purpose));
            for c in 0..3 {
                for lane in 0..LANES {
                    sample.radiance[c][lane] *= share;
                }
            }
            (sample.direction, sample.radiance, sample.pdf)
        }
        None => ([zero; 3], [zero; 3], zero),
    };
    LightSample { to_light, inverse_length: [1.0; LANES], far: [f32::INFINITY; LANES], strength, pdf }
}
