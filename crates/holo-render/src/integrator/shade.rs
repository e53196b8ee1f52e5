//! Shading of a path vertex: absorption, emission, direct light, and the scattered rays.

use super::Context;
use super::paths::{self, Path, PathHit, SampleState, Scattered};
use super::reuse::Step;
use super::scatterer::Scatterer;
use super::vertex::Shading;
use super::{direct_light, mis};
use crate::material::MaterialFlags;
use crate::material::media::{self, MediaStack, Medium};
use crate::sampling::{Draw, Purpose};
use crate::simd::{LANES, at};
use holo_scene::MAX_RADIANCE;

/// The first path vertex (counted from 0) with Russian roulette.
const ROULETTE_FIRST_VERTEX: u32 = 2;

/// The survival probability is the throughput times this factor, so that paths with a throughput above 1/8 always
/// survive. The factor trades speed for error; 1 would be the usual choice.
const ROULETTE_SCALE: f32 = 8.0;

/// The minimum survival probability.
const ROULETTE_MIN_SURVIVAL: f32 = 0.05;

/// What rays bring to the vertices: attenuates their throughput by the media that they have crossed, and adds emission to
/// `contribution`. Returns whether any path goes on.
#[inline(always)]
pub(crate) fn arrive(context: &Context, here: &mut Shading, step: Step, contribution: &mut [[f32; LANES]; 3]) -> bool {
    if context.scene.has_media {
        pass_media(context, here);
    }
    if here.interaction.any_flags.has(MaterialFlags::EMISSIVE.union(MaterialFlags::UNLIT)) {
        add_emission(context, here, step, contribution);
    }
    let mut any = false;
    for lane in 0..LANES {
        here.hit[lane] &= here.paths.may_scatter[lane];
        any |= here.hit[lane];
    }
    for c in 0..3 {
        for lane in 0..LANES {
            let carried = here.paths.throughput[c][lane];
            here.paths.throughput[c][lane] = if here.hit[lane] { carried } else { 0.0 };
        }
    }
    here.vertex < context.policy.max_bounces && any
}

/// What the vertices reflect: adds direct light to `contribution`, and the scattered rays to `next`. Returns the
/// number of shadow rays.
#[inline(always)]
pub(crate) fn reflect(
    context: &Context,
    here: &Shading,
    step: Step,
    contribution: &mut [[f32; LANES]; 3],
    next: &mut Scattered,
) -> u64 {
    let scatterer = Scatterer::new(context, here);
    let mut shadow_rays = 0;
    if !matches!(step, Step::Scatters { .. }) {
        shadow_rays = direct_light::add(context, here, &step, &scatterer, contribution);
    }
    if !matches!(step, Step::Gathers(_)) && context.continues_after(here.vertex) {
        scatter(context, here, step, &scatterer, next);
    }
    shadow_rays
}

/// Attenuates the throughput by the media that the rays have crossed, and finds those behind the surfaces.
#[inline(always)]
fn pass_media(context: &Context, here: &mut Shading) {
    let has_bodies = here.interaction.any_flags.has(MaterialFlags::VOLUME);
    if !has_bodies && media::are_air(&here.paths.media) {
        // Those behind the surfaces are as they begin.
        return;
    }
    let appearance = context.scene.appearance;
    let numbers = appearance.media(context.scene.geometry, here.interaction);
    let mut crossed = [Medium::AIR; LANES];
    let mut length = [0.0; LANES];
    for lane in 0..LANES {
        let (number, media) = (numbers[lane], here.paths.media[lane]);
        let leaves = here.interaction.side[lane] < 0.0;
        // A path that leaves a body without having entered one began inside it: a camera in glass.
        let inside = if (media == MediaStack::AIR) & leaves { number } else { media.top() };
        crossed[lane] = appearance.medium(inside);
        here.media_behind[lane] = match (number, leaves) {
            (0, _) => media,
            (_, true) => media.left(number),
            (_, false) => media.entered(number),
        };
        let mut squared = 0.0;
        for axis in 0..3 {
            let step = here.interaction.position[axis][lane] - here.packet.rays.origin[axis][lane];
            squared += step * step;
        }
        length[lane] = squared.sqrt();
    }
    let left = media::transmittance(&crossed, &length);
    for c in 0..3 {
        for lane in 0..LANES {
            here.paths.throughput[c][lane] *= left[c][lane];
        }
    }
}

/// Adds the emission of the surfaces. Paths end at unlit surfaces.
#[inline(always)]
fn add_emission(context: &Context, here: &mut Shading, step: Step, contribution: &mut [[f32; LANES]; 3]) {
    let interaction = here.interaction;
    let hits = &here.packet.hits;
    let emitted = context.scene.appearance.emission(
        context.scene.geometry,
        &interaction.triangle,
        here.footprints,
        [&hits.u, &hits.v],
        &interaction.side,
        &here.hit,
    );
    let weight = mis::emission_weight(context, here);
    let mut is_shared = [false; LANES];
    if let Step::Finds { shared, places } = step {
        is_shared = shared.emission(&context.scene, places, interaction, &here.hit, &emitted);
    }
    for lane in 0..LANES {
        let unlit = here.hit[lane] & interaction.flags[lane].has(MaterialFlags::UNLIT);
        for c in 0..3 {
            let shown = if unlit { interaction.base_color[c][lane] } else { emitted[c][lane] * weight[lane] };
            let added = (shown * here.paths.throughput[c][lane]).min(MAX_RADIANCE);
            contribution[c][lane] += if is_shared[lane] { 0.0 } else { added };
        }
        here.hit[lane] &= !unlit;
    }
}

/// Samples the BSDF of every lane and adds the scattered rays to `next`.
#[inline(always)]
fn scatter(context: &Context, here: &Shading, mut step: Step, scatterer: &Scatterer, next: &mut Scattered) {
    let purpose = |draw| Purpose::at_vertex(here.vertex, draw);
    let numbers = context.sampler.points(here.sequences, &here.paths.index, purpose(Draw::Direction));
    let uses_roulette = context.policy.roulette && here.vertex >= ROULETTE_FIRST_VERTEX;
    let [choice, survival] = if uses_roulette || scatterer.is_glossy() {
        context.sampler.points(here.sequences, &here.paths.index, purpose(Draw::Choice))
    } else {
        [[0.0; LANES]; 2]
    };
    let scattered = scatterer.scatter(here, context.scene.needs_bsdf_pdf(), &numbers, &choice);
    let mut throughput = [[0.0; LANES]; 3];
    for c in 0..3 {
        for lane in 0..LANES {
            throughput[c][lane] = (here.paths.throughput[c][lane] * scattered.weight[c][lane]).min(MAX_RADIANCE);
        }
    }
    if uses_roulette {
        roulette(&survival, &mut throughput);
    }
    let mut bsdf_pdf = scattered.bsdf_pdf;
    if context.policy.transparent_shadows {
        for lane in 0..LANES {
            // Shadow rays have found what lies in this direction behind smooth glass; a pdf of 0 gives it no weight.
            let is_straight = scattered.transmitted[lane] & (bsdf_pdf[lane] == f32::INFINITY);
            let has_been_lit = here.paths.bsdf_pdf[lane] < f32::INFINITY;
            bsdf_pdf[lane] = if is_straight & has_been_lit { 0.0 } else { bsdf_pdf[lane] };
        }
    }
    let mut cells = [0; LANES];
    for lane in 0..LANES {
        cells[lane] = paths::cell(at(&scattered.direction, lane));
    }
    for lane in 0..LANES {
        let mut throughput = at(&throughput, lane);
        if throughput[0] + throughput[1] + throughput[2] > 0.0 {
            let media = if scattered.transmitted[lane] { here.media_behind[lane] } else { here.paths.media[lane] };
            let mut pixel = here.paths.pixel[lane];
            if let Step::Scatters { shared, target } = &mut step
                && bsdf_pdf[lane] < f32::INFINITY
            {
                for c in 0..3 {
                    shared.throughput[c][lane] = throughput[c];
                }
                (throughput, pixel) = ([1.0; 3], *target * LANES as u32 + lane as u32);
            }
            let path = Path {
                origin: at(&scattered.start, lane),
                bsdf_pdf: bsdf_pdf[lane],
                direction: at(&scattered.direction, lane),
                pixel,
                throughput,
                sample: SampleState::new(here.paths.index[lane], context.policy.indirect | scattered.is_specular[lane]),
                hit: PathHit::NONE,
            };
            next.push(path, cells[lane], context.scene.has_media.then_some(media));
        }
    }
}

/// Russian roulette: terminates paths of low throughput at random, and divides the throughput of the others by their
/// survival probability.
#[inline(always)]
fn roulette(number: &[f32; LANES], throughput: &mut [[f32; LANES]; 3]) {
    for lane in 0..LANES {
        let strongest = throughput[0][lane].max(throughput[1][lane]).max(throughput[2][lane]);
        let survival = (strongest * ROULETTE_SCALE).clamp(ROULETTE_MIN_SURVIVAL, 1.0);
        let factor = if number[lane] < survival { 1.0 / survival } else { 0.0 };
        for c in 0..3 {
            throughput[c][lane] *= factor;
        }
    }
}
