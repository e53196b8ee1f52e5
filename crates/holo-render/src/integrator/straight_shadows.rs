//! Shadow rays that go straight through smooth glass.
//!
//! Light that glass refracts onto a surface is a caustic: only scattered rays can find it, rarely, and those of point
//! lights never. With [`Request::transparent_shadows`](crate::Request::transparent_shadows) shadow rays pass smooth
//! panes and bodies of glass as if these did not bend light: attenuated by the Fresnel transmittance and the base color
//! of every surface, and by what the bodies absorb. Scattered rays from a rough surface that are refracted by smooth
//! glass then find no light that shadow rays have found.
//!
//! For panes this is exact. For bodies it is an approximation: the shadow of a lens has no bright spot, and its energy is
//! that of light that passes straight. Rough glass, opacity below 1 and layers over glass are as without it.

use holo_scene::MAX_RADIANCE;

use super::Context;
use super::light_sampling::Contribution;
use super::vertex::{Shading, media_towards};
use crate::accel::{Coherence, NO_TRIANGLE, RayHits};
use crate::material::media::{self, MediaStack, Medium};
use crate::material::{HitPoints, MaterialFlags, SurfaceInteraction};
use crate::sampling;
use crate::simd::{LANES, Lanes, at, count};

/// A shadow ray ends at this surface, which counts as opaque.
const MAX_SURFACES: usize = 32;

/// Attenuates the contribution of the lanes `lit` by what lies between the surface and the light. Returns the number of
/// rays.
#[inline(never)]
pub(super) fn attenuate(
    context: &Context,
    here: &Shading,
    mut lit: Lanes<i32>,
    contribution: &mut Contribution,
) -> u64 {
    let mut rays = 0;
    let mut packet = RayHits::EMPTY;
    packet.rays.origin = contribution.start;
    packet.rays.direction = contribution.to_light;
    let mut left = contribution.far;
    let mut media = media_towards(here, &contribution.to_light);
    let mut passed = [false; LANES];
    for surface in 0..=MAX_SURFACES {
        let active = count(&lit);
        if active == 0 {
            break;
        }
        rays += active;
        packet.reset();
        packet.rays.far = left;
        if context.scene.has_alpha {
            packet.rays.id = sampling::ray_numbers(here.sequences, &here.paths.index, here.vertex);
        }
        let coherence = if surface == 0 { here.coherence } else { Coherence::Incoherent };
        context.scene.engine.intersect(&lit, &mut packet, coherence);
        absorb(context, &lit, &packet, &media, contribution);
        for lane in 0..LANES {
            let is_free = packet.hits.triangle[lane] == NO_TRIANGLE;
            lit.0[lane] = if is_free { 0 } else { lit.0[lane] };
            // A lane that is not traced has no surface.
            packet.hits.triangle[lane] = if lit.0[lane] == 0 { NO_TRIANGLE } else { packet.hits.triangle[lane] };
        }
        let points = HitPoints::secondary(context.scene.geometry, &packet);
        let found = SurfaceInteraction::new(context.scene.appearance, context.scene.geometry, &packet, &points);
        let Some(interaction) = found else { break };
        let through = transmittance(context, &packet, &interaction, &media);
        let numbers = context.scene.appearance.media(context.scene.geometry, &interaction);
        for lane in 0..LANES {
            if lit.0[lane] == 0 {
                continue;
            }
            let mut sum = 0.0;
            for c in 0..3 {
                let factor = if surface == MAX_SURFACES { 0.0 } else { through[c][lane] };
                contribution.value[c][lane] *= factor;
                sum += contribution.value[c][lane];
            }
            lit.0[lane] = if sum > 0.0 { -1 } else { 0 };
            passed[lane] = true;
            media[lane] = match (numbers[lane], interaction.side[lane] < 0.0) {
                (0, _) => media[lane],
                (number, true) => media[lane].left(number),
                (number, false) => media[lane].entered(number),
            };
            left[lane] -= packet.rays.far[lane];
            for axis in 0..3 {
                let position = interaction.position[axis][lane];
                packet.rays.origin[axis][lane] = position + (position - interaction.start[axis][lane]);
            }
        }
    }
    // Scattered rays do not find this light, so its weight is that of light sampling alone.
    for lane in 0..LANES {
        let factor = if passed[lane] { contribution.over_weight[lane] } else { 1.0 };
        for c in 0..3 {
            contribution.value[c][lane] = (contribution.value[c][lane] * factor).min(MAX_RADIANCE);
        }
    }
    rays
}

/// Attenuates by the media on the way to the next surface, or to the light if it is at a finite distance.
#[inline(always)]
fn absorb(
    context: &Context,
    lit: &Lanes<i32>,
    packet: &RayHits,
    media: &[MediaStack; LANES],
    contribution: &mut Contribution,
) {
    if !context.scene.has_media {
        return;
    }
    let mut crossed = [Medium::AIR; LANES];
    let mut length = [0.0; LANES];
    for lane in (0..LANES).filter(|&lane| lit.0[lane] != 0) {
        crossed[lane] = context.scene.appearance.medium(media[lane].top());
        let [x, y, z] = at(&packet.rays.direction, lane);
        let way = (x * x + y * y + z * z).sqrt() * packet.rays.far[lane];
        length[lane] = if way.is_finite() { way } else { 0.0 };
    }
    let remains = media::transmittance(&crossed, &length);
    for c in 0..3 {
        for lane in 0..LANES {
            contribution.value[c][lane] *= remains[c][lane];
        }
    }
}

/// What sixteen surfaces let pass straight: 0 unless they are smooth glass.
#[inline(always)]
fn transmittance(
    context: &Context,
    packet: &RayHits,
    interaction: &SurfaceInteraction,
    media: &[MediaStack; LANES],
) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    if !interaction.any_flags.has(MaterialFlags::GLOSSY) {
        return out;
    }
    let scene = &context.scene;
    let bsdf = scene.appearance.scattering(scene.geometry, packet, interaction, media, false);
    let mut cosine = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y, z] = at(&packet.rays.direction, lane);
        let mut along = 0.0;
        for axis in 0..3 {
            along += interaction.shading_normal[axis][lane] * packet.rays.direction[axis][lane];
        }
        cosine[lane] = along.abs() / (x * x + y * y + z * z).sqrt();
    }
    let passes = bsdf.straight_transmittance(&cosine);
    for lane in 0..LANES {
        let is_glass = interaction.hit[lane] & interaction.flags[lane].has(MaterialFlags::GLOSSY);
        for c in 0..3 {
            out[c][lane] = if is_glass { passes[c][lane] } else { 0.0 };
        }
    }
    out
}
