//! Multiple importance sampling: the weights of light that both light sampling and BSDF sampling can find, by the
//! balance heuristic (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995).

use super::Context;
use super::light_sampling::candidates;
use super::paths::PathPacket;
use super::vertex::Shading;
use crate::accel::{NO_TRIANGLE, RayHits, Rays};
use crate::simd::{LANES, Lanes};
use holo_scene::MAX_RADIANCE;

/// The weighted radiance that rays receive if they miss the scene: of the constant sky, the environment map and the
/// discs of directional lights. `pdf` is the BSDF-sampling pdf of their directions. Lanes that are `shared`
/// receive only the discs.
#[inline(always)]
fn environment_radiance(
    context: &Context,
    direction: &[[f32; LANES]; 3],
    pdf: &[f32; LANES],
    shared: &[bool; LANES],
) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for c in 0..3 {
        for lane in 0..LANES {
            out[c][lane] = if shared[lane] { 0.0 } else { context.scene.sky[c] };
        }
    }
    if let Some(environment) = context.scene.environment {
        let radiance = environment.radiance(direction);
        let light_pdf = environment.pdf(direction);
        for lane in 0..LANES {
            let weight = balance(pdf[lane], light_pdf[lane]);
            for c in 0..3 {
                out[c][lane] += if shared[lane] { 0.0 } else { radiance[c][lane] * weight };
            }
        }
    }
    if context.scene.has_discs {
        for light in context.scene.lights {
            for lane in 0..LANES {
                let seen = light.disc_shows(direction, lane);
                let weight = balance(pdf[lane], light.pdf());
                let radiance = light.disc_radiance().map(|channel| channel * weight);
                for c in 0..3 {
                    out[c][lane] += if seen { radiance[c] } else { 0.0 };
                }
            }
        }
    }
    out
}

/// Adds the radiance that rays receive if they miss the scene; see [`environment_radiance`]. Rays of the camera see the
/// backdrop, if there is one.
#[inline(always)]
pub(super) fn add_environment(
    context: &Context,
    rays: &Rays,
    (misses, shared, sees_backdrop): (&[bool; LANES], &[bool; LANES], bool),
    paths: &PathPacket,
    contribution: &mut [[f32; LANES]; 3],
) {
    let backdrop = context.scene.backdrop.filter(|_| sees_backdrop);
    if !misses.contains(&true) || (backdrop.is_none() && !context.scene.has_light_at_infinity()) {
        return;
    }
    let radiance = match backdrop {
        Some(backdrop) => backdrop.map(|channel| [channel; LANES]),
        None => environment_radiance(context, &rays.direction, &paths.bsdf_pdf, shared),
    };
    for lane in 0..LANES {
        for c in 0..3 {
            let found = (paths.throughput[c][lane] * radiance[c][lane]).min(MAX_RADIANCE);
            contribution[c][lane] += if misses[lane] { found } else { 0.0 };
        }
    }
}

/// The weight of emission that rays find by BSDF sampling.
#[inline(always)]
pub(super) fn emission_weight(context: &Context, here: &Shading) -> [f32; LANES] {
    let mut out = [1.0; LANES];
    let Some(emitters) = context.scene.emitters else { return out };
    let mut instance = [0; LANES];
    let [mut squared, mut cosine] = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        instance[lane] = context.scene.geometry.instance_index(here.interaction.triangle[lane]);
        let mut along = 0.0;
        for axis in 0..3 {
            let back = here.packet.rays.origin[axis][lane] - here.interaction.position[axis][lane];
            squared[lane] += back * back;
            along += back * here.interaction.geometric_normal[axis][lane];
        }
        cosine[lane] = here.interaction.side[lane] * along / squared[lane].sqrt();
    }
    let light_pdf = emitters.pdf(&instance, &squared, &cosine);
    // The weight of the vertex that scattered the ray. Camera rays have an infinite pdf, so their weight is 1.
    let (_, weight) = candidates(here.vertex.saturating_sub(1), false);
    for lane in 0..LANES {
        out[lane] = balance(here.paths.bsdf_pdf[lane], light_pdf[lane] * weight);
    }
    out
}

/// The weight of a technique with the pdf `own` if the other technique has the pdf `other`.
#[inline(always)]
pub(super) fn balance(own: f32, other: f32) -> f32 {
    // An infinite `own` gives 1.
    if other > 0.0 { 1.0 / (1.0 + other / own) } else { 1.0 }
}

/// Valid lanes whose rays miss the scene.
#[inline(always)]
pub(super) fn misses(packet: &RayHits, valid: &Lanes<i32>) -> [bool; LANES] {
    let mut out = [false; LANES];
    for lane in 0..LANES {
        out[lane] = (valid.0[lane] != 0) & (packet.hits.triangle[lane] == NO_TRIANGLE);
    }
    out
}
