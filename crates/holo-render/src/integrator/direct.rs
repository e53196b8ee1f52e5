//! One bounce: what reaches the pixel from Lambertian surfaces lit by punctual lights and the sky.
//!
//! Radiance of a hit = albedo/pi * sum over lights of (irradiance * cosine * visibility) + albedo * (share of the sky,
//! weighted by the cosine, that is seen) * sky; of a miss = sky. Shadows are hard. The sky's share is estimated with one
//! cosine-distributed ray a sample (unbiased); everything else is exact for each ray.
//!
//! One sample goes through the pixel's centre; more are spread over the pixel (a box filter), see [`Context::points`].

use ndarray::ArrayViewMut5;

use super::depth::{Truth, TruthTile, count};
use super::{Context, RayCounts};
use crate::accel::{Coherence, LANES, Lanes, NO_TRIANGLE, RayHits, Rays};
use crate::dispatch::Kernel;
use crate::light::{PreparedLight, STRONGEST};
use crate::refine;
use crate::sampling::{self, Purpose};
use crate::sky::SkyRays;
use crate::surface::Surfaces;
use crate::tile::Tile;

/// Neighbouring lanes on different triangles, of 15, from which on rays are taken for incoherent (measured).
const MANY_CHANGES: u32 = 11;

/// The integrator over one tile; with one sample it can note the ground truth on its way.
pub(crate) struct DirectTile<'a, 'b> {
    pub context: &'a Context<'a>,
    pub tile: &'a Tile,
    pub color: ArrayViewMut5<'b, f32>,
    pub truth: Option<TruthTile<'b>>,
}

impl Kernel for DirectTile<'_, '_> {
    type Output = RayCounts;

    #[inline(always)]
    fn run(mut self) -> RayCounts {
        let context = self.context;
        let mut counts = RayCounts::default();
        let mut color = vec![[[0.0f32; LANES]; 3]; self.tile.packet_count()];
        let mut truth = self.truth.is_some().then(Truth::default);
        let mut sky_rays = SkyRays::default();
        let mut packet = RayHits::EMPTY;
        let has_sky = context.sky.iter().any(|&c| c > 0.0);
        for sample in 0..context.samples {
            if context.stop.requested() {
                return counts;
            }
            for (index, (sum, block)) in color.iter_mut().zip(self.tile.blocks()).enumerate() {
                let pixels = context.tables.pixels(block);
                let sequences = context.sequences(&pixels);
                let points = if context.samples > 1 { Some(context.points(&pixels, &sequences, sample)) } else { None };
                let rays = context.tables.fill(&pixels, points.as_ref(), &mut packet);
                context.engine.intersect(&pixels.valid, &mut packet);
                counts.primary += count(&pixels.valid);
                let refined = refine::refine(context.geometry, &packet, &rays);
                if let Some(truth) = &mut truth {
                    truth.push(context, &refined.depth);
                }
                for lane in 0..LANES {
                    let missed = if packet.hits.triangle[lane] == NO_TRIANGLE { 1.0 } else { 0.0 };
                    for c in 0..3 {
                        sum[c][lane] += context.sky[c] * missed;
                    }
                }
                let Some(surfaces) = context.appearance.surfaces(context.geometry, &packet, &rays, &refined) else {
                    continue;
                };
                let coherence = coherence(&packet.hits.triangle);
                for light in context.lights {
                    counts.shadow += add_light(context, light, &surfaces, &pixels.valid, coherence, sum);
                }
                if has_sky {
                    let numbers = sampling::points(&sequences, sample, Purpose::Sky);
                    let first = (index * LANES) as u32;
                    sky_rays.push(first, &surfaces, &pixels.valid, context.sky, &numbers);
                }
            }
            counts.shadow += sky_rays.flush(context.engine, |pixel, gain| {
                let (index, lane) = (pixel as usize / LANES, pixel as usize % LANES);
                for c in 0..3 {
                    color[index][c][lane] += gain[c];
                }
            });
        }
        self.tile.scatter(&color, 1.0 / context.samples as f32, &mut self.color);
        if let (Some(truth), Some(out)) = (&truth, &mut self.truth) {
            truth.scatter(self.tile, out);
        }
        counts
    }
}

/// Rays from points on many different triangles (grass, leaves) go separate ways through the tree even towards one
/// light: walking it together then costs more than one ray after the other.
#[inline(always)]
fn coherence(triangles: &[u32; LANES]) -> Coherence {
    let mut changes = 0;
    for lane in 1..LANES {
        changes += u32::from(triangles[lane] != triangles[lane - 1]);
    }
    if changes > MANY_CHANGES { Coherence::Incoherent } else { Coherence::Coherent }
}

/// Adds one light to the lanes that it reaches; returns the shadow rays traced.
#[inline(always)]
fn add_light(
    context: &Context,
    light: &PreparedLight,
    surfaces: &Surfaces,
    valid: &Lanes<i32>,
    coherence: Coherence,
    sum: &mut [[f32; LANES]; 3],
) -> u64 {
    let arrivals = light.arrivals(&surfaces.start);
    let mut lit = Lanes([0; LANES]);
    let mut received = [0.0; LANES];
    for lane in 0..LANES {
        let [mut cosine, mut above] = [0.0; 2];
        for axis in 0..3 {
            cosine += surfaces.shading_normal[axis][lane] * arrivals.to_light[axis][lane];
            above += surfaces.geometric_normal[axis][lane] * arrivals.to_light[axis][lane];
        }
        let irradiance = arrivals.attenuation[lane] * cosine;
        let reaches = surfaces.hit[lane] & (valid.0[lane] != 0) & (above > 0.0) & (irradiance > 0.0);
        lit.0[lane] = -i32::from(reaches);
        received[lane] = if reaches { irradiance * std::f32::consts::FRAC_1_PI } else { 0.0 };
    }
    let count = count(&lit);
    if count == 0 {
        return 0;
    }
    let mut rays = Rays { origin: surfaces.start, direction: arrivals.to_light, ..Rays::EMPTY };
    rays.far = [light.shadow_reach(); LANES];
    context.engine.occluded(&lit, &mut rays, coherence);
    let power = light.power();
    for lane in 0..LANES {
        let seen = if rays.far[lane] < 0.0 { 0.0 } else { received[lane] };
        for c in 0..3 {
            sum[c][lane] += (surfaces.albedo[c][lane] * power[c] * seen).min(STRONGEST);
        }
    }
    count
}
