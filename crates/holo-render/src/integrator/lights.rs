//! Light that arrives straight from a light (next-event estimation), and the weights that share the work with rays that
//! meet lights by chance.
//!
//! Punctual lights can only be asked. Emissive surfaces and surroundings with a map are asked as well and met by
//! scattered rays: each way counts by the balance heuristic. The constant sky is only met. The discs of distant lights
//! are asked by everything that is not perfectly smooth, and met by what is.
//!
//! Of emissive surfaces several points are asked what they would give without their shadow, and a shadow ray goes to one
//! of them, drawn by that (Talbot et al., "Importance Resampling for Global Illumination", 2005).

use super::Context;
use super::scatterer::Scatterer;
use super::shade::Shading;
use crate::accel::{NO_TRIANGLE, RayHits, Rays};
use crate::geometry::Hit;
use crate::light::{PreparedLight, SHADOW_REACH};
use crate::sampling::{Draw, Points, Purpose};
use crate::simd::count;
use crate::simd::{LANES, Lanes};
use holo_scene::MAX_RADIANCE;

/// Up to this many lights the first event asks every one.
const ALL_LIGHTS: usize = 8;

/// Points on emissive surfaces that the first event asks, and later ones. Measured on six scenes of the gallery, lit by rooms,
/// windows and lanterns, 4 samples a pixel: against one point the squared error falls to 0.43 (plaster) to 0.72 (lanterns), and
/// the time grows by 12 to 29 %. Eight points cost another 4 to 32 % and gain 2 to 17 %.
const POINTS_ASKED: [u32; 2] = [4, 1];

/// How often all points of one event together count against the direction that its surface scatters to (the factor of the
/// asking way in the balance heuristic; any value is unbiased). With 1 the scattered ray, which tells most of mirrors, keeps
/// its weight; with all points' worth everything hangs on the one shadow ray.
const WEIGHT_OF_POINTS: [f32; 2] = [2.0, 1.0];

/// The largest f32 below 1.
const ONE_MINUS: f32 = 1.0 - f32::EPSILON / 2.0;

/// Light on its way to sixteen points.
struct Arriving {
    to_light: [[f32; LANES]; 3],
    inverse_length: [f32; LANES],
    /// How far to look, in multiples of `to_light`.
    far: [f32; LANES],
    /// Irradiance of a surface that faces the light; radiance where the light was asked with a density.
    strength: [[f32; LANES]; 3],
    /// The density with which the light was asked, if scattered rays may meet it as well; else infinite.
    asked: [f32; LANES],
}

/// What light adds to the pixels if nothing stands in its way.
#[derive(Clone, Copy)]
struct Gain {
    gain: [[f32; LANES]; 3],
    start: [[f32; LANES]; 3],
    to_light: [[f32; LANES]; 3],
    far: [f32; LANES],
}

/// Adds what arrives from all lights to `gain`; returns the shadow rays traced.
///
/// One loop over all that shines: what it calls is large, and compiled into the kernel once.
#[inline(always)]
pub(super) fn add(context: &Context, here: &Shading, scatterer: &Scatterer, gain: &mut [[f32; LANES]; 3]) -> u64 {
    let mut shadow_rays = 0;
    let punctual = context.scene.lights.len();
    let points = if context.scene.emitters.is_some() { points_asked(here.event).0 as usize } else { 0 };
    let all = punctual + points + usize::from(context.scene.surroundings.is_some());
    let one_of_all = punctual > ALL_LIGHTS || (here.event > 0 && punctual > 1);
    let numbers = if one_of_all | (points > 0) { draw(context, here, Draw::Light) } else { [[0.0; LANES]; 2] };
    let mut reservoir = Reservoir::new(numbers[0]);
    for k in 0..all {
        let arriving = if k < punctual {
            punctual_light(context, here, &context.scene.lights[k])
        } else if k < punctual + points {
            emitter(context, here, (k - punctual) as u32)
        } else {
            surroundings(context, here)
        };
        let mut arrived = arrived(here, scatterer, &arriving);
        if one_of_all && k < punctual {
            reservoir.offer(&arrived);
            if k + 1 < punctual {
                continue;
            }
            arrived = reservoir.chosen();
        }
        if k >= punctual && k < punctual + points {
            if k == punctual {
                reservoir = Reservoir::new(numbers[1]);
            }
            reservoir.offer(&arrived);
            if k + 1 < punctual + points {
                continue;
            }
            arrived = reservoir.chosen();
        }
        shadow_rays += add_unless_hidden(context, here, &arrived, gain);
    }
    shadow_rays
}

#[inline(always)]
fn draw(context: &Context, here: &Shading, draw: Draw) -> Points {
    context.sampler.points(here.sequences, &here.paths.sample, Purpose::event(here.event, draw))
}

#[inline(always)]
fn punctual_light(context: &Context, here: &Shading, light: &PreparedLight) -> Arriving {
    let place = if context.scene.has_discs { draw(context, here, Draw::Disc) } else { [[0.5; LANES]; 2] };
    let arrivals = light.arrivals(&here.surfaces.start, &place);
    let power = light.power();
    let mut strength = [[0.0; LANES]; 3];
    for c in 0..3 {
        for lane in 0..LANES {
            strength[c][lane] = power[c] * arrivals.attenuation[lane];
        }
    }
    Arriving {
        to_light: arrivals.to_light,
        inverse_length: arrivals.inverse_length,
        far: [light.shadow_reach(); LANES],
        strength,
        asked: [f32::INFINITY; LANES],
    }
}

/// How many points on emissive surfaces the event number `event` asks, and how much they count.
#[inline(always)]
fn points_asked(event: u32) -> (u32, f32) {
    let later = usize::from(event > 0);
    (POINTS_ASKED[later], WEIGHT_OF_POINTS[later])
}

/// Point number `k` of something that glows, of those that this event asks: together with those of the other samples
/// they are one sequence, spread over all that glows.
#[inline(always)]
fn emitter(context: &Context, here: &Shading, k: u32) -> Arriving {
    let zero = [0.0; LANES];
    let mut out = Arriving {
        to_light: [zero; 3],
        inverse_length: zero,
        far: [SHADOW_REACH; LANES],
        strength: [zero; 3],
        asked: zero,
    };
    let Some(emitters) = context.scene.emitters else { return out };
    let (points, weight) = points_asked(here.event);
    let mut indices = [0; LANES];
    for lane in 0..LANES {
        indices[lane] = here.paths.sample[lane] * points + k;
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
    // A density above 0 means that the point shows a side that glows; if both do, they glow alike.
    let side = [1.0; LANES];
    let place = [&sample.u, &sample.v];
    let mut triangles = [Hit::flattened(0); LANES];
    for lane in 0..LANES {
        triangles[lane] = Hit::flattened(sample.triangle[lane] as usize);
    }
    out.strength = context.scene.appearance.emission(context.scene.geometry, &triangles, place, &side, &wanted);
    if context.scene.has_holes {
        for lane in (0..LANES).filter(|&lane| wanted[lane]) {
            let place = [sample.u[lane], sample.v[lane]];
            let opacity = context.scene.appearance.opacity(context.scene.geometry, triangles[lane], place);
            for c in 0..3 {
                out.strength[c][lane] *= opacity;
            }
        }
    }
    out.to_light = sample.to_light;
    for lane in 0..LANES {
        out.asked[lane] = sample.pdf[lane] * weight;
        // Each point stands for its share of all.
        for c in 0..3 {
            out.strength[c][lane] *= weight / points as f32;
        }
    }
    out
}

/// A direction of the surroundings.
#[inline(always)]
fn surroundings(context: &Context, here: &Shading) -> Arriving {
    let zero = [0.0; LANES];
    let (to_light, strength, asked) = match context.scene.surroundings {
        Some(surroundings) => {
            let sample = surroundings.sample(&draw(context, here, Draw::Surroundings));
            (sample.direction, sample.radiance, sample.pdf)
        }
        None => ([zero; 3], [zero; 3], zero),
    };
    Arriving { to_light, inverse_length: [1.0; LANES], far: [f32::INFINITY; LANES], strength, asked }
}

/// What the surfaces send on of it.
#[inline(always)]
fn arrived(here: &Shading, scatterer: &Scatterer, arriving: &Arriving) -> Gain {
    let response = scatterer.respond(&arriving.to_light, &arriving.inverse_length);
    let mut gain = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let asked = arriving.asked[lane];
        // The balance heuristic over the density it was asked with: 1 / (asked + met).
        let shared = 1.0 / (asked + response.density[lane]);
        let factor = if asked == f32::INFINITY { 1.0 } else { shared };
        let factor = if asked > 0.0 { factor } else { 0.0 };
        for c in 0..3 {
            let sent = here.paths.throughput[c][lane] * response.value[c][lane];
            gain[c][lane] = (sent * (arriving.strength[c][lane] * factor)).min(MAX_RADIANCE);
        }
    }
    Gain { gain, start: response.start, to_light: arriving.to_light, far: arriving.far }
}

/// One light for every lane, drawn by what each would give without its shadow.
struct Reservoir {
    number: [f32; LANES],
    total: [f32; LANES],
    weight: [f32; LANES],
    kept: Gain,
}

impl Reservoir {
    #[inline(always)]
    fn new(number: [f32; LANES]) -> Self {
        let zero = [0.0; LANES];
        let kept = Gain { gain: [zero; 3], start: [zero; 3], to_light: [zero; 3], far: zero };
        Self { number, total: zero, weight: zero, kept }
    }

    /// The light takes the place with its share of what was seen so far; what is left of the random number within that
    /// share is used again.
    #[inline(always)]
    fn offer(&mut self, light: &Gain) {
        let mut takes = [false; LANES];
        for lane in 0..LANES {
            let gives = light.gain[0][lane] + light.gain[1][lane] + light.gain[2][lane];
            let total = self.total[lane] + gives;
            let share = if total > 0.0 { gives / total } else { 0.0 };
            let number = self.number[lane];
            takes[lane] = number < share;
            let rest = if takes[lane] { number / share } else { (number - share) / (1.0 - share) };
            self.number[lane] = if rest >= 0.0 { rest.min(ONE_MINUS) } else { 0.0 };
            self.weight[lane] = if takes[lane] { gives } else { self.weight[lane] };
            self.total[lane] = total;
        }
        for lane in 0..LANES {
            self.kept.far[lane] = if takes[lane] { light.far[lane] } else { self.kept.far[lane] };
        }
        for k in 0..3 {
            for lane in 0..LANES {
                self.kept.gain[k][lane] = if takes[lane] { light.gain[k][lane] } else { self.kept.gain[k][lane] };
                self.kept.start[k][lane] = if takes[lane] { light.start[k][lane] } else { self.kept.start[k][lane] };
                let to_light = self.kept.to_light[k][lane];
                self.kept.to_light[k][lane] = if takes[lane] { light.to_light[k][lane] } else { to_light };
            }
        }
    }

    /// The light that was drawn, with the weight that makes up for the others.
    #[inline(always)]
    fn chosen(&self) -> Gain {
        let mut out = self.kept;
        for lane in 0..LANES {
            let factor = if self.weight[lane] > 0.0 { self.total[lane] / self.weight[lane] } else { 0.0 };
            for c in 0..3 {
                out.gain[c][lane] = (out.gain[c][lane] * factor).min(MAX_RADIANCE);
            }
        }
        out
    }
}

/// What escaping rays find: sky, surroundings, the discs of distant lights.
#[inline(always)]
pub(super) fn beyond(context: &Context, direction: &[[f32; LANES]; 3], density: &[f32; LANES]) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for c in 0..3 {
        out[c] = [context.scene.sky[c]; LANES];
    }
    if let Some(surroundings) = context.scene.surroundings {
        let radiance = surroundings.radiance(direction);
        let asked = surroundings.pdf(direction);
        for lane in 0..LANES {
            let weight = balance(density[lane], asked[lane]);
            for c in 0..3 {
                out[c][lane] += radiance[c][lane] * weight;
            }
        }
    }
    if context.scene.has_discs {
        for light in context.scene.lights {
            for lane in 0..LANES {
                let seen = (density[lane] == f32::INFINITY) & light.disc_shows(direction, lane);
                let radiance = light.disc_radiance();
                for c in 0..3 {
                    out[c][lane] += if seen { radiance[c] } else { 0.0 };
                }
            }
        }
    }
    out
}

/// How much of what glows counts where rays meet it by chance.
#[inline(always)]
pub(super) fn weight_of_glow(context: &Context, here: &Shading) -> [f32; LANES] {
    let mut out = [1.0; LANES];
    let Some(emitters) = context.scene.emitters else { return out };
    let mut part = [0; LANES];
    let [mut squared, mut cosine] = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        part[lane] = context.scene.geometry.part_index(here.surfaces.triangle[lane]);
        let mut along = 0.0;
        for axis in 0..3 {
            let way = here.packet.rays.origin[axis][lane] - here.surfaces.position[axis][lane];
            squared[lane] += way * way;
            along += way * here.surfaces.geometric_normal[axis][lane];
        }
        cosine[lane] = here.surfaces.side[lane] * along / squared[lane].sqrt();
    }
    let asked = emitters.pdf(&part, &squared, &cosine);
    // By the event that scattered the ray hither. Camera rays have an infinite density: nothing else asked for them.
    let (_, weight) = points_asked(here.event.saturating_sub(1));
    for lane in 0..LANES {
        out[lane] = balance(here.paths.density[lane], asked[lane] * weight);
    }
    out
}

/// The share of a way with density `own` where the other way has `other` (Veach and Guibas, 1995).
#[inline(always)]
fn balance(own: f32, other: f32) -> f32 {
    // An infinite density of its own gives 1.
    if other > 0.0 { 1.0 / (1.0 + other / own) } else { 1.0 }
}

/// Adds what arrives to the lanes whose shadow ray is free; returns the rays traced.
#[inline(always)]
fn add_unless_hidden(context: &Context, here: &Shading, arriving: &Gain, gain: &mut [[f32; LANES]; 3]) -> u64 {
    let mut lit = Lanes([0; LANES]);
    for lane in 0..LANES {
        let any = arriving.gain[0][lane] + arriving.gain[1][lane] + arriving.gain[2][lane] > 0.0;
        lit.0[lane] = -i32::from(any & here.hit[lane]);
    }
    let count = count(&lit);
    if count == 0 {
        return 0;
    }
    let mut rays = Rays { origin: arriving.start, direction: arriving.to_light, far: arriving.far, ..Rays::EMPTY };
    context.scene.engine.occluded(&lit, &mut rays, here.coherence);
    for lane in 0..LANES {
        let free = (lit.0[lane] != 0) & (rays.far[lane] >= 0.0);
        for c in 0..3 {
            gain[c][lane] += if free { arriving.gain[c][lane] } else { 0.0 };
        }
    }
    count
}

/// Valid lanes whose rays leave the scene; `sky_alone` if they were only asked whether they do.
#[inline(always)]
pub(super) fn missed(packet: &RayHits, valid: &Lanes<i32>, sky_alone: bool) -> [bool; LANES] {
    let mut out = [false; LANES];
    for lane in 0..LANES {
        let hit = if sky_alone { packet.rays.far[lane] < 0.0 } else { packet.hits.triangle[lane] != NO_TRIANGLE };
        out[lane] = (valid.0[lane] != 0) & !hit;
    }
    out
}
