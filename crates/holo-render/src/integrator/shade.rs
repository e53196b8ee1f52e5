//! What happens where sixteen rays end: light that arrives there straight from the lights, and rays that go on.

use super::Context;
use super::depth::count;
use crate::accel::{Coherence, LANES, Lanes, RayHits, Rays, at};
use crate::light::{Arrivals, PreparedLight, STRONGEST};
use crate::paths::{self, Path, Paths};
use crate::sampling::{self, Draw, Purpose};
use crate::surface::Surfaces;

/// Up to this many lights the first event asks every one.
const ALL_LIGHTS: usize = 8;

/// From this event on (counted from 0) paths are subject to roulette.
const ROULETTE_FROM: u32 = 2;

/// Sixteen points where rays ended, and what they carry.
pub(crate) struct Shading<'a> {
    #[allow(dead_code)] // until materials other than Lambert's are looked up
    pub packet: &'a RayHits,
    pub surfaces: &'a Surfaces,
    pub valid: &'a Lanes<i32>,
    pub sequences: &'a [u32; LANES],
    pub sample: u32,
    /// Which scattering event this is, from 0.
    pub event: u32,
    /// Which pixels of the tile.
    pub pixel: &'a [u32; LANES],
    pub throughput: &'a [[f32; LANES]; 3],
    pub coherence: Coherence,
}

/// Adds what arrives from lights to `gain`, and the rays that go on to `next`. Returns the shadow rays traced.
#[inline(always)]
pub(crate) fn shade(context: &Context, here: &Shading, gain: &mut [[f32; LANES]; 3], next: &mut Paths) -> u64 {
    let mut shadow_rays = 0;
    if here.event == 0 && context.lights.len() <= ALL_LIGHTS {
        for light in context.lights {
            shadow_rays += add_light(context, light, here, gain);
        }
    } else if !context.lights.is_empty() {
        shadow_rays += add_one_light(context, here, gain);
    }
    if context.scatters_on(here.event) {
        scatter(context, here, next);
    }
    shadow_rays
}

/// What arrives from one light before its shadow: radiance towards the viewer in three channels, 0 where it cannot reach.
#[inline(always)]
fn unshadowed(light: &PreparedLight, arrivals: &Arrivals, here: &Shading) -> [[f32; LANES]; 3] {
    let surfaces = here.surfaces;
    let power = light.power();
    let mut out = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let [mut cosine, mut above] = [0.0; 2];
        for axis in 0..3 {
            cosine += surfaces.shading_normal[axis][lane] * arrivals.to_light[axis][lane];
            above += surfaces.geometric_normal[axis][lane] * arrivals.to_light[axis][lane];
        }
        let irradiance = arrivals.attenuation[lane] * (cosine * arrivals.inverse_length[lane]);
        let reaches = surfaces.hit[lane] & (here.valid.0[lane] != 0) & (above > 0.0) & (irradiance > 0.0);
        let received = if reaches { irradiance * std::f32::consts::FRAC_1_PI } else { 0.0 };
        for c in 0..3 {
            let reflected = here.throughput[c][lane] * surfaces.base_color[c][lane];
            out[c][lane] = (reflected * power[c] * received).min(STRONGEST);
        }
    }
    out
}

/// Adds one light to the lanes that it reaches; returns the shadow rays traced.
#[inline(always)]
fn add_light(context: &Context, light: &PreparedLight, here: &Shading, gain: &mut [[f32; LANES]; 3]) -> u64 {
    let arrivals = light.arrivals(&here.surfaces.start);
    let arriving = unshadowed(light, &arrivals, here);
    let far = [light.shadow_reach(); LANES];
    add_unless_hidden(context, here, &arrivals.to_light, far, &arriving, gain)
}

/// Adds one light, drawn for every lane by what each light would give without its shadow; returns the shadow rays.
#[inline(always)]
fn add_one_light(context: &Context, here: &Shading, gain: &mut [[f32; LANES]; 3]) -> u64 {
    let [mut number, _] = sampling::points(here.sequences, here.sample, Purpose::event(here.event, Draw::Light));
    let mut to_light = [[0.0; LANES]; 3];
    let mut far = [0.0; LANES];
    let mut chosen = [[0.0; LANES]; 3];
    let [mut total, mut weight] = [[0.0; LANES]; 2];
    for light in context.lights {
        let arrivals = light.arrivals(&here.surfaces.start);
        let arriving = unshadowed(light, &arrivals, here);
        for lane in 0..LANES {
            // A reservoir of one: the light takes the place with its share of what was seen so far, and what is left of
            // the random number within that share is used again.
            let gives = arriving[0][lane] + arriving[1][lane] + arriving[2][lane];
            total[lane] += gives;
            let share = if total[lane] > 0.0 { gives / total[lane] } else { 0.0 };
            let takes = number[lane] < share;
            number[lane] = if takes { number[lane] / share } else { (number[lane] - share) / (1.0 - share) };
            number[lane] = if number[lane] >= 0.0 { number[lane].min(ONE_MINUS) } else { 0.0 };
            weight[lane] = if takes { gives } else { weight[lane] };
            far[lane] = if takes { light.shadow_reach() } else { far[lane] };
            for axis in 0..3 {
                to_light[axis][lane] = if takes { arrivals.to_light[axis][lane] } else { to_light[axis][lane] };
                chosen[axis][lane] = if takes { arriving[axis][lane] } else { chosen[axis][lane] };
            }
        }
    }
    for lane in 0..LANES {
        let factor = if weight[lane] > 0.0 { total[lane] / weight[lane] } else { 0.0 };
        for c in 0..3 {
            chosen[c][lane] = (chosen[c][lane] * factor).min(STRONGEST);
        }
    }
    add_unless_hidden(context, here, &to_light, far, &chosen, gain)
}

/// The largest f32 below 1.
const ONE_MINUS: f32 = 1.0 - f32::EPSILON / 2.0;

/// Adds `arriving` to the lanes whose shadow ray along `to_light` is free up to `far`; returns the rays traced.
#[inline(always)]
fn add_unless_hidden(
    context: &Context,
    here: &Shading,
    to_light: &[[f32; LANES]; 3],
    far: [f32; LANES],
    arriving: &[[f32; LANES]; 3],
    gain: &mut [[f32; LANES]; 3],
) -> u64 {
    let mut lit = Lanes([0; LANES]);
    for lane in 0..LANES {
        lit.0[lane] = -i32::from(arriving[0][lane] + arriving[1][lane] + arriving[2][lane] > 0.0);
    }
    let count = count(&lit);
    if count == 0 {
        return 0;
    }
    let mut rays = Rays { origin: here.surfaces.start, direction: *to_light, far, ..Rays::EMPTY };
    context.engine.occluded(&lit, &mut rays, here.coherence);
    for lane in 0..LANES {
        let seen = if rays.far[lane] < 0.0 { 0.0 } else { 1.0 };
        for c in 0..3 {
            gain[c][lane] += arriving[c][lane] * seen;
        }
    }
    count
}

/// Draws a direction for every lane and lets the path go on that way.
#[inline(always)]
fn scatter(context: &Context, here: &Shading, next: &mut Paths) {
    let surfaces = here.surfaces;
    let numbers = sampling::points(here.sequences, here.sample, Purpose::event(here.event, Draw::Direction));
    let local = sampling::cosine_hemisphere(&numbers);
    let mut direction = [[0.0; LANES]; 3];
    let mut throughput = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let normal = at(&surfaces.shading_normal, lane);
        let [x, y] = sampling::frame(normal);
        let mut above = 0.0;
        for axis in 0..3 {
            let d = x[axis] * local[0][lane] + y[axis] * local[1][lane] + normal[axis] * local[2][lane];
            direction[axis][lane] = d;
            above += d * surfaces.geometric_normal[axis][lane];
        }
        // Under the triangle itself there is nothing to see, whatever the interpolated normal says.
        let leaves = surfaces.hit[lane] & (here.valid.0[lane] != 0) & (above > 0.0);
        for c in 0..3 {
            let carried = here.throughput[c][lane] * surfaces.base_color[c][lane];
            throughput[c][lane] = if leaves { carried } else { 0.0 };
        }
    }
    if context.roulette && here.event >= ROULETTE_FROM {
        roulette(here, &mut throughput);
    }
    let mut cells = [0; LANES];
    for lane in 0..LANES {
        cells[lane] = paths::cell(at(&direction, lane));
    }
    for lane in 0..LANES {
        let throughput = at(&throughput, lane);
        if throughput[0] + throughput[1] + throughput[2] > 0.0 {
            let path = Path {
                origin: at(&surfaces.start, lane),
                density: 0.0,
                direction: at(&direction, lane),
                pixel: here.pixel[lane],
                throughput,
                goes_on: true,
            };
            next.push(path, cells[lane]);
        }
    }
}

/// Ends weak paths at random and makes up for them in those that survive.
#[inline(always)]
fn roulette(here: &Shading, throughput: &mut [[f32; LANES]; 3]) {
    let [_, number] = sampling::points(here.sequences, here.sample, Purpose::event(here.event, Draw::Choice));
    for lane in 0..LANES {
        let strongest = throughput[0][lane].max(throughput[1][lane]).max(throughput[2][lane]);
        let survival = strongest.clamp(0.05, 0.95);
        let factor = if number[lane] < survival { 1.0 / survival } else { 0.0 };
        for c in 0..3 {
            throughput[c][lane] *= factor;
        }
    }
}
