//! One bounce: what reaches the pixel from Lambertian surfaces lit by punctual lights and the sky.
//!
//! Radiance of a hit = albedo/pi * sum over lights of (irradiance * cosine * visibility) + albedo * (share of the sky,
//! weighted by the cosine, that is seen) * sky; of a miss = sky. Shadows are hard. The sky's share is estimated with one
//! cosine-distributed ray a sample (unbiased); everything else is exact for each ray.
//!
//! One sample goes through the pixel's centre; more are spread over the pixel (a box filter).

use ndarray::ArrayViewMut5;

use super::depth::{CENTRE, Truth, TruthTile, count};
use super::{Context, RayCounts};
use crate::accel::{LANES, Lanes, RayHits, Rays};
use crate::dispatch::Kernel;
use crate::light::{PreparedLight, dot};
use crate::primary::Pixels;
use crate::refine;
use crate::sampling;
use crate::sky::SkyRays;
use crate::surface::Surfaces;
use crate::tile::Tile;

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
            if (context.cancelled)() {
                return counts;
            }
            for (index, sum) in color.iter_mut().enumerate() {
                let pixels = self.tile.pixels(index);
                let numbers = Numbers::draw(context, &pixels, sample, has_sky);
                let rays = context.tables.fill(&pixels, [&numbers.x, &numbers.y], &mut packet);
                context.engine.intersect(&pixels.valid, &mut packet);
                counts.primary += count(&pixels.valid);
                let depth = refine::depths(context.geometry, &packet, &rays);
                if let Some(truth) = &mut truth {
                    truth.push(context, &depth);
                }
                let surfaces = context.appearance.surfaces(context.geometry, &packet, &rays, &depth);
                for light in context.lights {
                    counts.shadow += add_light(context, light, &surfaces, &pixels.valid, sum);
                }
                if has_sky {
                    for lane in 0..LANES {
                        if pixels.valid.0[lane] == 0 {
                        } else if surfaces.hit[lane] {
                            let normals =
                                [&surfaces.geometric_normal, &surfaces.shading_normal].map(|n| Surfaces::at(n, lane));
                            let gain = std::array::from_fn(|c| surfaces.albedo[c][lane] * context.sky[c]);
                            let numbers = [numbers.u[lane], numbers.v[lane]];
                            sky_rays.push((index * LANES + lane) as u32, surfaces.start(lane), normals, gain, numbers);
                        } else {
                            for c in 0..3 {
                                sum[c][lane] += context.sky[c];
                            }
                        }
                    }
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

/// The random numbers of a packet: a place in the pixel and a direction of the sky.
struct Numbers {
    x: [f32; LANES],
    y: [f32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
}

impl Numbers {
    #[inline(always)]
    fn draw(context: &Context, pixels: &Pixels, sample: u32, has_sky: bool) -> Self {
        let mut numbers = Self { x: CENTRE, y: CENTRE, u: [0.0; LANES], v: [0.0; LANES] };
        if context.samples == 1 && !has_sky {
            return numbers;
        }
        for lane in 0..LANES {
            let lens = pixels.v[lane] * context.columns[0] + pixels.u[lane];
            let view = pixels.t[lane] * context.columns[1] + pixels.s[lane];
            let [x, y, u, v] = sampling::sample(sampling::sequence(context.seed, lens, view), sample);
            if context.samples > 1 {
                numbers.x[lane] = x;
                numbers.y[lane] = y;
            }
            numbers.u[lane] = u;
            numbers.v[lane] = v;
        }
        numbers
    }
}

/// Adds one light to the lanes that it reaches; returns the shadow rays traced.
#[inline(always)]
fn add_light(
    context: &Context,
    light: &PreparedLight,
    surfaces: &Surfaces,
    valid: &Lanes<i32>,
    sum: &mut [[f32; LANES]; 3],
) -> u64 {
    let mut rays = Rays::EMPTY;
    let mut lit = Lanes([0; LANES]);
    let mut received = [0.0; LANES];
    rays.far = [light.shadow_reach(); LANES];
    for lane in 0..LANES {
        let start = surfaces.start(lane);
        let arrival = light.arrival(start);
        let cosine = dot(Surfaces::at(&surfaces.shading_normal, lane), arrival.to_light);
        let above = dot(Surfaces::at(&surfaces.geometric_normal, lane), arrival.to_light);
        let irradiance = arrival.attenuation * cosine / arrival.length;
        let reaches = surfaces.hit[lane] && valid.0[lane] != 0 && above > 0.0 && irradiance > 0.0;
        lit.0[lane] = if reaches { -1 } else { 0 };
        received[lane] = if reaches { irradiance * std::f32::consts::FRAC_1_PI } else { 0.0 };
        for axis in 0..3 {
            rays.origin[axis][lane] = start[axis];
            rays.direction[axis][lane] = arrival.to_light[axis];
        }
    }
    let count = count(&lit);
    if count == 0 {
        return 0;
    }
    context.engine.occluded(&lit, &mut rays);
    let power = light.power();
    for lane in 0..LANES {
        let seen = if rays.far[lane] < 0.0 { 0.0 } else { received[lane] };
        for c in 0..3 {
            sum[c][lane] += surfaces.albedo[c][lane] * power[c] * seen;
        }
    }
    count
}
