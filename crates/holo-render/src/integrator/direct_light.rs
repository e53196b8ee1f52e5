//! Direct light at a path vertex (next-event estimation).
//!
//! Punctual lights can only be sampled. Emissive surfaces and the environment map are sampled as well as hit by scattered rays,
//! weighted by the balance heuristic ([`super::mis`]). The constant sky is only hit. The discs of distant lights are sampled by
//! everything that is not perfectly smooth, and hit by what is.

use holo_scene::MAX_RADIANCE;

use super::Context;
use super::light_sampling::{LightSample, LightSelection, Role};
use super::resampling::Reservoir;
use super::scatterer::Scatterer;
use super::shade::Shading;
use crate::accel::Rays;
use crate::simd::{LANES, Lanes, count};

/// What light adds to the pixels if nothing stands in its way.
#[derive(Clone, Copy)]
pub(super) struct Contribution {
    pub value: [[f32; LANES]; 3],
    pub start: [[f32; LANES]; 3],
    pub to_light: [[f32; LANES]; 3],
    pub far: [f32; LANES],
}

/// Adds the direct light from everything that emits to `radiance`; returns the shadow rays traced.
///
/// One loop over all light samples: what it calls is large, and compiled into the kernel once.
#[inline(always)]
pub(super) fn add(context: &Context, here: &Shading, scatterer: &Scatterer, radiance: &mut [[f32; LANES]; 3]) -> u64 {
    let mut shadow_rays = 0;
    let selection = LightSelection::new(context, here);
    let numbers = selection.numbers(context, here);
    let mut reservoir = Reservoir::new(numbers[0]);
    for k in 0..selection.count() {
        let light = selection.sample(context, here, k);
        let mut contribution = unoccluded(here, scatterer, &light);
        if let Role::Candidate { group, first, last } = selection.role(k) {
            if first {
                reservoir = Reservoir::new(numbers[group]);
            }
            reservoir.offer(&contribution);
            if !last {
                continue;
            }
            contribution = reservoir.chosen();
        }
        shadow_rays += add_visible(context, here, &contribution, radiance);
    }
    shadow_rays
}

/// What a light sample contributes without its shadow: throughput x BSDF x cosine x light, over the pdf.
#[inline(always)]
fn unoccluded(here: &Shading, scatterer: &Scatterer, light: &LightSample) -> Contribution {
    let response = scatterer.respond(&light.to_light, &light.inverse_length);
    let mut value = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let pdf = light.pdf[lane];
        // The balance heuristic over the light-sampling pdf: 1 / (light pdf + BSDF pdf).
        let balanced = 1.0 / (pdf + response.density[lane]);
        let factor = if pdf == f32::INFINITY { 1.0 } else { balanced };
        let factor = if pdf > 0.0 { factor } else { 0.0 };
        for c in 0..3 {
            let sent = here.paths.throughput[c][lane] * response.value[c][lane];
            value[c][lane] = (sent * (light.strength[c][lane] * factor)).min(MAX_RADIANCE);
        }
    }
    Contribution { value, start: response.start, to_light: light.to_light, far: light.far }
}

/// Adds the contribution to the lanes whose shadow ray is free; returns the rays traced.
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
    let mut rays =
        Rays { origin: contribution.start, direction: contribution.to_light, far: contribution.far, ..Rays::EMPTY };
    context.scene.engine.occluded(&lit, &mut rays, here.coherence);
    for lane in 0..LANES {
        let free = (lit.0[lane] != 0) & (rays.far[lane] >= 0.0);
        for c in 0..3 {
            radiance[c][lane] += if free { contribution.value[c][lane] } else { 0.0 };
        }
    }
    count
}
