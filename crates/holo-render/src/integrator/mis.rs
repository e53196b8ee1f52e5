//! Multiple importance sampling: what light counts for where both light sampling and BSDF sampling can find it (balance heuristic;
//! Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995).

use super::Context;
use super::light_sampling::candidates;
use super::shade::Shading;
use crate::accel::{NO_TRIANGLE, RayHits};
use crate::simd::{LANES, Lanes};

/// What escaping rays find: the constant sky, the environment map, the discs of distant lights. `pdf` is the BSDF-sampling pdf of
/// their directions.
#[inline(always)]
pub(super) fn environment_radiance(
    context: &Context,
    direction: &[[f32; LANES]; 3],
    pdf: &[f32; LANES],
) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for c in 0..3 {
        out[c] = [context.scene.sky[c]; LANES];
    }
    if let Some(surroundings) = context.scene.surroundings {
        let radiance = surroundings.radiance(direction);
        let light_pdf = surroundings.pdf(direction);
        for lane in 0..LANES {
            let weight = balance(pdf[lane], light_pdf[lane]);
            for c in 0..3 {
                out[c][lane] += radiance[c][lane] * weight;
            }
        }
    }
    if context.scene.has_discs {
        for light in context.scene.lights {
            for lane in 0..LANES {
                let seen = (pdf[lane] == f32::INFINITY) & light.disc_shows(direction, lane);
                let radiance = light.disc_radiance();
                for c in 0..3 {
                    out[c][lane] += if seen { radiance[c] } else { 0.0 };
                }
            }
        }
    }
    out
}

/// What emission counts for where rays hit it by BSDF sampling.
#[inline(always)]
pub(super) fn emission_weight(context: &Context, here: &Shading) -> [f32; LANES] {
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
    let light_pdf = emitters.pdf(&part, &squared, &cosine);
    // By the vertex that scattered the ray hither. Camera rays have an infinite pdf: nothing else sampled for them.
    let (_, weight) = candidates(here.event.saturating_sub(1));
    for lane in 0..LANES {
        out[lane] = balance(here.paths.density[lane], light_pdf[lane] * weight);
    }
    out
}

/// The weight of a technique with the pdf `own` where the other has `other`.
#[inline(always)]
fn balance(own: f32, other: f32) -> f32 {
    // An infinite pdf of its own gives 1.
    if other > 0.0 { 1.0 / (1.0 + other / own) } else { 1.0 }
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
