//! Direct light at a path vertex (next-event estimation).
//!
//! Punctual lights can only be sampled. Emissive surfaces, the environment map and the discs of distant lights are found
//! both by light sampling and by BSDF sampling, weighted by the balance heuristic ([`super::mis`]). The constant sky is
//! only found by BSDF sampling.

use holo_scene::MAX_RADIANCE;

use super::Context;
use super::light_sampling::{Contribution, LightSample, LightSelection, Role};
use super::resampling::Reservoir;
use super::reuse::{FoundLight, Step};
use super::scatterer::{Response, Scatterer};
use super::straight_shadows;
use super::vertex::{Shading, media_towards};
use crate::accel::Rays;
use crate::material::media::{self, Medium};
use crate::sampling;
use crate::simd::{LANES, Lanes, count};

/// Adds the direct light at a path vertex to `radiance`; returns the number of shadow rays.
///
/// A single loop over all light samples: the called functions are large and are compiled into the kernel once.
#[inline(always)]
pub(super) fn add(
    context: &Context,
    here: &Shading,
    step: &Step,
    scatterer: &Scatterer,
    radiance: &mut [[f32; LANES]; 3],
) -> u64 {
    let mut shadow_rays = 0;
    let selection = LightSelection::new(context, here, matches!(step, Step::Gathers(_)));
    let numbers = selection.numbers(context, here);
    let mut reservoir = Reservoir::new(numbers[0]);
    let is_absorbed = context.scene.has_media
        && !context.policy.transparent_shadows
        && !(media::are_air(&here.paths.media) && media::are_air(&here.media_behind));
    for k in 0..selection.count() {
        let (light, found) = match (selection.role(k), step) {
            (Role::Found(lane), Step::Gathers(shared)) => {
                if !shared.is_lit(lane) {
                    continue;
                }
                let (light, found) = FoundLight::new(context, here, shared, lane);
                (light, Some(found))
            }
            _ => (selection.sample(context, here, k), None),
        };
        let response = scatterer.respond(&light.to_light, &light.inverse_length);
        if let Some(found) = found {
            shadow_rays += found.add(context, here, &light, &response, radiance);
            continue;
        }
        let mut contribution = unoccluded(here, &response, &light);
        if is_absorbed {
            absorb(context, here, &light, &mut contribution);
        }
        if let Role::Candidate { group, first, last } = selection.role(k) {
            if first {
                reservoir = Reservoir::new(numbers[group]);
            }
            reservoir.offer(&contribution);
            if !last {
                continue;
            }
            contribution = reservoir.selected();
        }
        shadow_rays += add_visible(context, here, &contribution, radiance);
    }
    shadow_rays
}

/// The unoccluded contribution of a light sample: throughput x BSDF x cosine x light / pdf.
#[inline(always)]
fn unoccluded(here: &Shading, response: &Response, light: &LightSample) -> Contribution {
    let mut value = [[0.0; LANES]; 3];
    let mut over_weight = [1.0; LANES];
    for lane in 0..LANES {
        let pdf = light.pdf[lane];
        // The balance heuristic over the light-sampling pdf: 1 / (light pdf + BSDF pdf).
        let balanced = 1.0 / (pdf + response.bsdf_pdf[lane]);
        let factor = if pdf == f32::INFINITY { 1.0 } else { balanced };
        let factor = if pdf > 0.0 { factor } else { 0.0 };
        let is_shared = (pdf > 0.0) & (pdf < f32::INFINITY);
        over_weight[lane] = if is_shared { 1.0 + response.bsdf_pdf[lane] / pdf } else { 1.0 };
        for c in 0..3 {
            let sent = here.paths.throughput[c][lane] * response.value[c][lane];
            value[c][lane] = (sent * (light.strength[c][lane] * factor)).min(MAX_RADIANCE);
        }
    }
    Contribution { value, start: response.start, to_light: light.to_light, far: light.far, over_weight }
}

/// Attenuates a contribution by the medium between the surface and the light. Bodies of glass stop shadow rays, so the
/// light is in the same medium; from infinitely far away none arrives inside a closed body.
#[inline(always)]
fn absorb(context: &Context, here: &Shading, light: &LightSample, contribution: &mut Contribution) {
    let media = media_towards(here, &light.to_light);
    if media::are_air(&media) {
        return;
    }
    let mut crossed = [Medium::AIR; LANES];
    let mut length = [0.0; LANES];
    for lane in 0..LANES {
        crossed[lane] = context.scene.appearance.medium(media[lane].top());
        length[lane] = if light.far[lane].is_finite() { 1.0 / light.inverse_length[lane] } else { 0.0 };
        length[lane] = if light.inverse_length[lane] > 0.0 { length[lane] } else { 0.0 };
    }
    let left = media::transmittance(&crossed, &length);
    for c in 0..3 {
        for lane in 0..LANES {
            contribution.value[c][lane] *= left[c][lane];
        }
    }
}

/// Adds the contribution to the lanes whose shadow ray is not occluded; returns the number of shadow rays.
#[inline(always)]
fn add_visible(
    context: &Context,
    here: &Shading,
    contribution: &Contribution,
    radiance: &mut [[f32; LANES]; 3],
) -> u64 {
    let mut lit = Lanes([0; LANES]);
    for lane in 0..LANES {
        let any = contribution.value[0][lane] + contribution.value[1][lane] + contribution.value[2][lane] > 0.0;
        lit.0[lane] = -i32::from(any & here.hit[lane]);
    }
    let count = count(&lit);
    if count == 0 {
        return 0;
    }
    if context.policy.transparent_shadows {
        let mut arriving = *contribution;
        let rays = straight_shadows::attenuate(context, here, lit, &mut arriving);
        for lane in 0..LANES {
            for c in 0..3 {
                radiance[c][lane] += if lit.0[lane] != 0 { arriving.value[c][lane] } else { 0.0 };
            }
        }
        return rays;
    }
    let mut rays =
        Rays { origin: contribution.start, direction: contribution.to_light, far: contribution.far, ..Rays::EMPTY };
    if context.scene.has_alpha {
        rays.id = sampling::ray_numbers(here.sequences, &here.paths.index, here.vertex);
    }
    context.scene.engine.occluded(&lit, &mut rays, here.coherence);
    for lane in 0..LANES {
        let free = (lit.0[lane] != 0) & (rays.far[lane] >= 0.0);
        for c in 0..3 {
            radiance[c][lane] += if free { contribution.value[c][lane] } else { 0.0 };
        }
    }
    count
}
