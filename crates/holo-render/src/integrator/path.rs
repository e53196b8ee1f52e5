//! Paths: light that is scattered up to `max_bounces` times on its way to the pixel.
//!
//! **What it computes.** The radiance along every camera ray, by the rendering equation with at most `max_bounces`
//! scattering events (Mitsuba's `max_depth` - 1, Cycles' `max_bounces` + 1). One event is direct light; [`super::direct`]
//! is this integrator with one.
//!
//! **How.** Every event asks for the light that arrives straight from a light (next-event estimation), then draws one
//! direction in which the path goes on. Punctual lights can only be found the first way. The constant sky is only found
//! the second way, which draws it perfectly. Surroundings with a map and emissive surfaces are found both ways, weighted
//! by the balance heuristic (Veach and Guibas, 1995). The first event asks every punctual light if there
//! are eight at most; of more, and later, one is asked, drawn by what it would give without its shadow.
//!
//! **Roulette.** From the third event on a path that carries less than an eighth survives with 8 times its throughput as
//! the probability (5 % at least) and counts for as much more; unbiased, and it can be switched off.
//!
//! **In which order.** A tile's paths advance together, one event at a time: its camera rays first, in packets of
//! neighbouring views, then all rays that the first event scattered, sorted by direction ([`super::paths`]), and so on.
//! Rays after the last event only need to know whether they reach the sky, unless something in the scene glows.
//!
//! **Samples.** One sample goes through the pixel's centre; more are spread over the pixel (a box filter), see
//! [`crate::Sampling`].

use ndarray::ArrayViewMut5;

use super::paths::{PathPacket, Paths};
use super::shade::{self, Shading};
use super::{Context, RayCounts, mis};
use crate::accel::refine;
use crate::accel::{Coherence, RayHits, Rays};
use crate::camera::tile::Tile;
use crate::camera::{CameraRays, PixelPacket};
use crate::film::adaptive::Samples;
use crate::material::{HitPoints, Surfaces};
use crate::simd::Kernel;
use crate::simd::LANES;
use crate::simd::count;
use holo_scene::MAX_RADIANCE;

/// Neighbouring lanes on different triangles, of 15, from which on rays are taken for incoherent (measured).
const MANY_CHANGES: u32 = 11;

/// Samples of a tile whose scattered rays are sorted together.
const TOGETHER: u32 = 4;

/// About so many samples are sorted together, for one event and for more: the more, the closer neighbours are, until they
/// leave the cache (measured). Rays that only look for the sky gain less by it.
const SORTED: [usize; 2] = [8192, 32_768];

/// The size of tiles that suits so many samples a pixel and bounces.
pub(crate) fn tile_pixels(samples: u32, bounces: u32) -> usize {
    SORTED[usize::from(bounces > 1)] / samples.clamp(1, TOGETHER) as usize
}

/// From so many rays on, those of the first event are taken for coherent (measured).
const DENSE: usize = 16_384;

/// The integrator over one tile.
pub(crate) struct PathTile<'a, 'b> {
    pub context: &'a Context<'a>,
    pub tile: &'a Tile,
    pub color: ArrayViewMut5<'b, f32>,
    pub scratch: &'a mut Scratch,
}

/// What a tile's paths are held in while they are followed. A thread keeps its memory from tile to tile.
#[derive(Default)]
pub(crate) struct Scratch {
    /// Sums over the samples.
    color: Vec<[[f32; LANES]; 3]>,
    /// The pixels' random sequences.
    sequences: Vec<[u32; LANES]>,
    samples: Samples,
    /// Rays that the last event scattered.
    now: Paths,
    /// Rays that this event scatters.
    next: Paths,
}

impl Kernel for PathTile<'_, '_> {
    type Output = RayCounts;

    #[inline(always)]
    fn run(mut self) -> RayCounts {
        let context = self.context;
        self.scratch.begin(context, self.tile);
        let mut work = Work { context, counts: RayCounts::default(), scratch: self.scratch };
        for first in (0..context.sampler.samples).step_by(TOGETHER as usize) {
            let end = context.sampler.samples.min(first + TOGETHER);
            if context.stop.requested() {
                return work.counts;
            }
            for event in 0..=context.policy.max_bounces {
                work.trace(self.tile, event, [first, end]);
                let scratch = &mut *work.scratch;
                scratch.now.clear();
                std::mem::swap(&mut scratch.now, &mut scratch.next);
                if scratch.now.len() == 0 {
                    break;
                }
            }
            work.scratch.samples.add(end - first, &work.scratch.color);
            if !work.scratch.samples.any_wanted() {
                break;
            }
        }
        let scratch = work.scratch;
        let scale = scratch.samples.average(&mut scratch.color, context.sampler.samples);
        self.tile.write(&scratch.color, scale, &mut self.color);
        work.counts
    }
}

impl Scratch {
    /// Makes it ready for another tile.
    #[inline(always)]
    fn begin(&mut self, context: &Context, tile: &Tile) {
        self.color.clear();
        self.color.resize(tile.packet_count(), [[0.0; LANES]; 3]);
        self.sequences.clear();
        self.samples.begin(context.policy.target_error);
        self.now.clear();
        self.next.clear();
        for pixels in context.camera.packets(tile) {
            self.samples.push(&pixels.valid);
            self.sequences.push(context.sampler.sequences(&pixels.numbers));
        }
    }
}

/// A tile at work.
struct Work<'a> {
    context: &'a Context<'a>,
    counts: RayCounts,
    scratch: &'a mut Scratch,
}

/// Sixteen rays that were traced.
struct Traced {
    paths: PathPacket,
    sequences: [u32; LANES],
    points: HitPoints,
    coherence: Coherence,
}

impl Work<'_> {
    /// All rays of one event: those of the camera for the samples from `first` to `end`, or those that the event before
    /// scattered; and the next event where they end.
    ///
    /// One loop for both: what it calls is large, and compiled into the kernel once.
    #[inline(always)]
    fn trace(&mut self, tile: &Tile, event: u32, [first, end]: [u32; 2]) {
        let context = self.context;
        self.scratch.now.sort_by_direction();
        // What scattered rays hit after the last event does not matter any more unless it glows.
        let sky_alone = event == context.policy.max_bounces && !context.scene.has_glow;
        // The first event's rays start close together, and if there are many, neighbours in direction are close as well.
        // Later ones start all over the scene.
        let dense = !sky_alone && event == 1 && self.scratch.now.len() >= DENSE;
        let coherence = if dense { Coherence::Coherent } else { Coherence::Incoherent };
        let per_sample = self.scratch.color.len();
        let packets =
            if event == 0 { per_sample * (end - first) as usize } else { self.scratch.now.len().div_ceil(LANES) };
        let mut blocks = context.camera.packets(tile);
        let mut packet = RayHits::EMPTY;
        for k in 0..packets {
            packet.reset();
            let mut traced = if event == 0 {
                let index = k % per_sample;
                if index == 0 {
                    blocks = context.camera.packets(tile);
                }
                let Some(pixels) = blocks.next() else { return };
                if !self.scratch.samples.wanted(index) {
                    continue;
                }
                let sample = first + (k / per_sample) as u32;
                self.camera_rays(&pixels, index, sample, &mut packet)
            } else {
                self.scattered_rays(k, coherence, sky_alone, &mut packet)
            };
            let mut gain = [[0.0; LANES]; 3];
            let missed = mis::missed(&packet, &traced.paths.valid, sky_alone);
            add_escaping(context, &packet.rays, &missed, &traced.paths, &mut gain);
            let found = Surfaces::new(context.scene.appearance, context.scene.geometry, &packet, &traced.points);
            if let Some(surfaces) = &found {
                let mut hit = surfaces.hit;
                for lane in 0..LANES {
                    hit[lane] &= traced.paths.valid.0[lane] != 0;
                }
                let mut shading = Shading {
                    packet: &packet,
                    surfaces,
                    hit,
                    sequences: &traced.sequences,
                    event,
                    paths: &mut traced.paths,
                    coherence: traced.coherence,
                };
                self.counts.shadow += shade::shade(context, &mut shading, &mut gain, &mut self.scratch.next);
            }
            self.add(event, &traced.paths, &gain);
        }
    }

    /// One ray through every pixel of a packet.
    #[inline(always)]
    fn camera_rays(&mut self, pixels: &PixelPacket, index: usize, sample: u32, packet: &mut RayHits) -> Traced {
        let context = self.context;
        let sequences = self.scratch.sequences[index];
        let CameraRays { exact, weight } = context.camera.sample(pixels, &context.sampler, sample, packet);
        context.scene.engine.intersect(&pixels.valid, packet, Coherence::Coherent);
        self.counts.primary += count(&pixels.valid);
        let refined = refine::refine(context.scene.geometry, packet, &exact);
        let mut paths = PathPacket {
            valid: pixels.valid,
            density: [f32::INFINITY; LANES],
            pixel: [0; LANES],
            throughput: [weight; 3],
            sample: [sample; LANES],
            goes_on: [true; LANES],
        };
        for lane in 0..LANES {
            paths.pixel[lane] = (index * LANES + lane) as u32;
        }
        let coherence = coherence(packet);
        Traced { paths, sequences, points: HitPoints::primary(&exact, &refined), coherence }
    }

    /// The packet number `k` of the rays that the event before scattered. `sky_alone`: all that counts is which leave the
    /// scene.
    #[inline(always)]
    fn scattered_rays(&mut self, k: usize, coherence: Coherence, sky_alone: bool, packet: &mut RayHits) -> Traced {
        let context = self.context;
        let paths = self.scratch.now.packet(k, &mut packet.rays);
        self.counts.other += count(&paths.valid);
        if sky_alone {
            context.scene.engine.occluded(&paths.valid, &mut packet.rays, coherence);
        } else {
            context.scene.engine.intersect(&paths.valid, packet, coherence);
        }
        let mut sequences = [0; LANES];
        for lane in 0..LANES {
            let pixel = paths.pixel[lane] as usize;
            sequences[lane] = self.scratch.sequences[pixel / LANES][pixel % LANES];
        }
        let points = if sky_alone { HitPoints::NONE } else { HitPoints::secondary(context.scene.geometry, packet) };
        Traced { paths, sequences, points, coherence: Coherence::Incoherent }
    }

    /// Adds what a packet found to its pixels.
    #[inline(always)]
    fn add(&mut self, event: u32, paths: &PathPacket, gain: &[[f32; LANES]; 3]) {
        if event == 0 {
            let sum = &mut self.scratch.color[paths.pixel[0] as usize / LANES];
            for c in 0..3 {
                for lane in 0..LANES {
                    sum[c][lane] += gain[c][lane];
                }
            }
            return;
        }
        for lane in 0..LANES {
            if paths.valid.0[lane] != 0 {
                let pixel = paths.pixel[lane] as usize;
                let sum = &mut self.scratch.color[pixel / LANES];
                for c in 0..3 {
                    sum[c][pixel % LANES] += gain[c][lane];
                }
            }
        }
    }
}

/// Adds what rays that leave the scene find there.
#[inline(always)]
fn add_escaping(
    context: &Context,
    rays: &Rays,
    missed: &[bool; LANES],
    paths: &PathPacket,
    gain: &mut [[f32; LANES]; 3],
) {
    if !missed.contains(&true) || !context.scene.shines_from_beyond() {
        return;
    }
    let radiance = mis::environment_radiance(context, &rays.direction, &paths.density);
    for lane in 0..LANES {
        for c in 0..3 {
            let found = (paths.throughput[c][lane] * radiance[c][lane]).min(MAX_RADIANCE);
            gain[c][lane] += if missed[lane] { found } else { 0.0 };
        }
    }
}

/// Rays from points on many different triangles (grass, leaves) go separate ways through the tree even towards one
/// light: walking it together then costs more than one ray after the other.
#[inline(always)]
fn coherence(packet: &RayHits) -> Coherence {
    let (triangle, instance) = (&packet.hits.triangle, &packet.hits.instance);
    let mut changes = 0;
    for lane in 1..LANES {
        changes += u32::from((triangle[lane] != triangle[lane - 1]) | (instance[lane] != instance[lane - 1]));
    }
    if changes > MANY_CHANGES { Coherence::Incoherent } else { Coherence::Coherent }
}
