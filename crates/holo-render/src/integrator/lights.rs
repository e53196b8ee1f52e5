//! Light that arrives straight from a light (next-event estimation), and the weights that share the work with rays that
//! meet lights by chance.
//!
//! Punctual lights can only be asked. Emissive surfaces and surroundings with a map are asked as well and met by
//! scattered rays: each way counts by the balance heuristic. The constant sky is only met. The discs of distant lights
//! are asked by everything that is not perfectly smooth, and met by what is.

use super::Context;
use super::depth::count;
use super::scatterer::Scatterer;
use super::shade::Shading;
use crate::accel::{LANES, Lanes, NO_TRIANGLE, Rays};
use crate::light::{PreparedLight, SHADOW_REACH, STRONGEST};
use crate::sampling::{self, Draw, Points, Purpose};

/// Up to this many lights the first event asks every one.
const ALL_LIGHTS: usize = 8;

/// The largest f32 below 1.
const ONE_MINUS: f32 = 1.0 - f32::EPSILON / 2.0;

/// Light on its way to sixteen points, before anybody looked for what stands in between.
struct Arriving {
    /// Radiance that it adds to the pixels.
    gain: [[f32; LANES]; 3],
    start: [[f32; LANES]; 3],
    to_light: [[f32; LANES]; 3],
    /// How far to look, in multiples of `to_light`.
    far: [f32; LANES],
}

/// Adds what arrives from all lights to `gain`; returns the shadow rays traced.
#[inline(always)]
pub(super) fn add(context: &Context, here: &Shading, scatterer: &Scatterer, gain: &mut [[f32; LANES]; 3]) -> u64 {
    let mut shadow_rays = 0;
    let draw = |draw| sampling::points_at(here.sequences, &here.sample, Purpose::event(here.event, draw));
    let place = if context.has_discs { draw(Draw::Disc) } else { [[0.5; LANES]; 2] };
    if here.event == 0 && context.lights.len() <= ALL_LIGHTS {
        for light in context.lights {
            let arriving = unshadowed(light, here, scatterer, &place);
            shadow_rays += add_unless_hidden(context, here, &arriving, gain);
        }
    } else if !context.lights.is_empty() {
        let [number, _] = draw(Draw::Light);
        let arriving = one_of_all(context, here, scatterer, number, &place);
        shadow_rays += add_unless_hidden(context, here, &arriving, gain);
    }
    if let Some(emitters) = context.emitters {
        let [_, choice] = draw(Draw::Light);
        let sample = emitters.sample(&here.surfaces.start, &choice, &draw(Draw::Emitter));
        let mut inverse_length = [0.0; LANES];
        for lane in 0..LANES {
            let mut squared = 0.0;
            for axis in 0..3 {
                squared += sample.to_light[axis][lane] * sample.to_light[axis][lane];
            }
            inverse_length[lane] = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        }
        let mut wanted = [false; LANES];
        for lane in 0..LANES {
            wanted[lane] = here.hit[lane] & (sample.pdf[lane] > 0.0);
        }
        // A density above 0 means that the point shows a side that glows; if both do, they glow alike.
        let side = [1.0; LANES];
        let mut radiance =
            context.appearance.emission(context.geometry, &sample.triangle, [&sample.u, &sample.v], &side, &wanted);
        if context.has_holes {
            for lane in (0..LANES).filter(|&lane| wanted[lane]) {
                let place = [sample.u[lane], sample.v[lane]];
                let opacity = context.appearance.opacity(context.geometry, sample.triangle[lane], place);
                for c in 0..3 {
                    radiance[c][lane] *= opacity;
                }
            }
        }
        let arriving =
            weighted(here, scatterer, sample.to_light, &inverse_length, &radiance, &sample.pdf, SHADOW_REACH);
        shadow_rays += add_unless_hidden(context, here, &arriving, gain);
    }
    if let Some(surroundings) = context.surroundings {
        let sample = surroundings.sample(&draw(Draw::Surroundings));
        let one = [1.0; LANES];
        let far = f32::INFINITY;
        let arriving = weighted(here, scatterer, sample.direction, &one, &sample.radiance, &sample.pdf, far);
        shadow_rays += add_unless_hidden(context, here, &arriving, gain);
    }
    shadow_rays
}

/// What escaping rays find: sky, surroundings, the discs of distant lights.
#[inline(always)]
pub(super) fn beyond(context: &Context, direction: &[[f32; LANES]; 3], density: &[f32; LANES]) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for c in 0..3 {
        out[c] = [context.sky[c]; LANES];
    }
    if let Some(surroundings) = context.surroundings {
        let radiance = surroundings.radiance(direction);
        let asked = surroundings.pdf(direction);
        for lane in 0..LANES {
            let weight = balance(density[lane], asked[lane]);
            for c in 0..3 {
                out[c][lane] += radiance[c][lane] * weight;
            }
        }
    }
    if context.has_discs {
        for light in context.lights {
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
    let Some(emitters) = context.emitters else { return out };
    let mut part = [0; LANES];
    let [mut squared, mut cosine] = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        part[lane] = context.geometry.part_index(here.surfaces.triangle[lane] as usize);
        let mut along = 0.0;
        for axis in 0..3 {
            let way = here.packet.rays.origin[axis][lane] - here.surfaces.position[axis][lane];
            squared[lane] += way * way;
            along += way * here.surfaces.geometric_normal[axis][lane];
        }
        cosine[lane] = here.surfaces.side[lane] * along / squared[lane].sqrt();
    }
    let asked = emitters.pdf(&part, &squared, &cosine);
    for lane in 0..LANES {
        out[lane] = balance(here.density[lane], asked[lane]);
    }
    out
}

/// The share of a way with density `own` where the other way has `other` (Veach and Guibas, 1995).
#[inline(always)]
fn balance(own: f32, other: f32) -> f32 {
    // An infinite density of its own gives 1.
    if other > 0.0 { 1.0 / (1.0 + other / own) } else { 1.0 }
}

/// What arrives from one punctual light.
#[inline(always)]
fn unshadowed(light: &PreparedLight, here: &Shading, scatterer: &Scatterer, place: &Points) -> Arriving {
    let arrivals = light.arrivals(&here.surfaces.start, place);
    let response = scatterer.respond(&arrivals.to_light, &arrivals.inverse_length);
    let power = light.power();
    let mut gain = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        for c in 0..3 {
            let sent = here.throughput[c][lane] * response.value[c][lane];
            gain[c][lane] = (sent * (power[c] * arrivals.attenuation[lane])).min(STRONGEST);
        }
    }
    Arriving { gain, start: response.start, to_light: arrivals.to_light, far: [light.shadow_reach(); LANES] }
}

/// One punctual light for every lane, drawn by what each would give without its shadow.
#[inline(always)]
fn one_of_all(
    context: &Context,
    here: &Shading,
    scatterer: &Scatterer,
    mut number: [f32; LANES],
    place: &Points,
) -> Arriving {
    let zero = [0.0; LANES];
    let mut chosen = Arriving { gain: [zero; 3], start: here.surfaces.start, to_light: [zero; 3], far: zero };
    let [mut total, mut weight] = [zero; 2];
    for light in context.lights {
        let arriving = unshadowed(light, here, scatterer, place);
        for lane in 0..LANES {
            // A reservoir of one: the light takes the place with its share of what was seen so far, and what is left of
            // the random number within that share is used again.
            let gives = arriving.gain[0][lane] + arriving.gain[1][lane] + arriving.gain[2][lane];
            total[lane] += gives;
            let share = if total[lane] > 0.0 { gives / total[lane] } else { 0.0 };
            let takes = number[lane] < share;
            number[lane] = if takes { number[lane] / share } else { (number[lane] - share) / (1.0 - share) };
            number[lane] = if number[lane] >= 0.0 { number[lane].min(ONE_MINUS) } else { 0.0 };
            weight[lane] = if takes { gives } else { weight[lane] };
            chosen.far[lane] = if takes { arriving.far[lane] } else { chosen.far[lane] };
            for k in 0..3 {
                chosen.gain[k][lane] = if takes { arriving.gain[k][lane] } else { chosen.gain[k][lane] };
                chosen.start[k][lane] = if takes { arriving.start[k][lane] } else { chosen.start[k][lane] };
                chosen.to_light[k][lane] = if takes { arriving.to_light[k][lane] } else { chosen.to_light[k][lane] };
            }
        }
    }
    for lane in 0..LANES {
        let factor = if weight[lane] > 0.0 { total[lane] / weight[lane] } else { 0.0 };
        for c in 0..3 {
            chosen.gain[c][lane] = (chosen.gain[c][lane] * factor).min(STRONGEST);
        }
    }
    chosen
}

/// What arrives from a light that scattered rays may meet as well, asked with the density `asked`.
#[inline(always)]
fn weighted(
    here: &Shading,
    scatterer: &Scatterer,
    to_light: [[f32; LANES]; 3],
    inverse_length: &[f32; LANES],
    radiance: &[[f32; LANES]; 3],
    asked: &[f32; LANES],
    far: f32,
) -> Arriving {
    let response = scatterer.respond(&to_light, inverse_length);
    let mut gain = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        // The balance heuristic over the density: 1 / (asked + met).
        let both = asked[lane] + response.density[lane];
        let factor = if asked[lane] > 0.0 { 1.0 / both } else { 0.0 };
        for c in 0..3 {
            let sent = here.throughput[c][lane] * response.value[c][lane];
            gain[c][lane] = (sent * (radiance[c][lane] * factor)).min(STRONGEST);
        }
    }
    Arriving { gain, start: response.start, to_light, far: [far; LANES] }
}

/// Adds what arrives to the lanes whose shadow ray is free; returns the rays traced.
#[inline(always)]
fn add_unless_hidden(context: &Context, here: &Shading, arriving: &Arriving, gain: &mut [[f32; LANES]; 3]) -> u64 {
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
    context.engine.occluded(&lit, &mut rays, here.coherence);
    for lane in 0..LANES {
        let free = (lit.0[lane] != 0) & (rays.far[lane] >= 0.0);
        for c in 0..3 {
            gain[c][lane] += if free { arriving.gain[c][lane] } else { 0.0 };
        }
    }
    count
}

/// Lanes of a packet that hit nothing.
#[inline(always)]
pub(super) fn missed(triangles: &[u32; LANES], valid: &Lanes<i32>) -> [bool; LANES] {
    let mut out = [false; LANES];
    for lane in 0..LANES {
        out[lane] = (triangles[lane] == NO_TRIANGLE) & (valid.0[lane] != 0);
    }
    out
}
