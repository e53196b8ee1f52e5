//! Paths: light that is scattered up to `max_bounces` times on its way to the pixel.
//!
//! **What it computes.** The radiance along every camera ray, by the rendering equation with at most `max_bounces`
//! scattering events (Mitsuba's `max_depth` - 1, Cycles' `max_bounces` + 1). One event is direct light; [`super::direct`]
//! is this integrator with one.
//!
//! **How.** Every event asks for the light that arrives straight from a light (next-event estimation), then draws one
//! direction in which the path goes on. Punctual lights can only be found the first way. The constant sky is only found
//! the second way, which draws it perfectly. Surroundings with a map and emissive surfaces are found both ways, weighted
//! by the balance heuristic (Veach and Guibas, 1995). The first event asks every punctual light, later ones ask one,
//! drawn by what it would give without its shadow.
//!
//! **Roulette.** From the third event on a path survives with the probability of its throughput (5 to 95 %) and counts
//! for as much more; unbiased, and it can be switched off.
//!
//! **In which order.** A tile's paths advance together, one event at a time: its camera rays first, in packets of
//! neighbouring views, then all rays that the first event scattered, sorted by direction ([`crate::paths`]), and so on.
//! Rays after the last event only need to know whether they reach the sky, unless something in the scene glows.
//!
//! **Samples.** One sample goes through the pixel's centre; more are spread over the pixel (a box filter), see
//! [`Context::points`].

use ndarray::ArrayViewMut5;

use super::adaptive::Samples;
use super::depth::{Truth, TruthTile, count};
use super::shade::{self, Shading};
use super::{Context, RayCounts, lights};
use crate::accel::{Coherence, LANES, RayHits, Rays};
use crate::dispatch::Kernel;
use crate::light::STRONGEST;
use crate::paths::Paths;
use crate::refine;
use crate::surface::Surfaces;
use crate::tile::Tile;

/// Neighbouring lanes on different triangles, of 15, from which on rays are taken for incoherent (measured).
const MANY_CHANGES: u32 = 11;

/// Samples of a tile whose scattered rays are sorted together: the more, the closer neighbours are.
const TOGETHER: u32 = 4;

/// From so many rays on, those of the first event are taken for coherent (measured).
const DENSE: usize = 16_384;

/// The integrator over one tile; with one sample it can note the ground truth on its way.
pub(crate) struct PathTile<'a, 'b> {
    pub context: &'a Context<'a>,
    pub tile: &'a Tile,
    pub color: ArrayViewMut5<'b, f32>,
    pub truth: Option<TruthTile<'b>>,
}

impl Kernel for PathTile<'_, '_> {
    type Output = RayCounts;

    #[inline(always)]
    fn run(mut self) -> RayCounts {
        let context = self.context;
        let mut work = Work {
            context,
            counts: RayCounts::default(),
            color: vec![[[0.0f32; LANES]; 3]; self.tile.packet_count()],
            sequences: Vec::with_capacity(self.tile.packet_count()),
            events: Vec::with_capacity(self.tile.packet_count()),
            samples: Samples::new(context, self.tile.packet_count()),
            now: Paths::default(),
            next: Paths::default(),
        };
        for block in self.tile.blocks() {
            let pixels = context.tables.pixels(block);
            work.sequences.push(context.sequences(&pixels));
            work.events.push(context.event_sequences(&pixels));
        }
        let mut truth = self.truth.is_some().then(Truth::default);
        for first in (0..context.samples).step_by(TOGETHER as usize) {
            let end = context.samples.min(first + TOGETHER);
            for sample in first..end {
                if context.stop.requested() {
                    return work.counts;
                }
                work.camera_rays(self.tile, sample, truth.as_mut());
            }
            for event in 1..=context.max_bounces {
                std::mem::swap(&mut work.now, &mut work.next);
                if work.now.len() == 0 {
                    break;
                }
                work.scattered_rays(event);
                work.now.clear();
            }
            work.samples.add(end - first, &work.color);
            if !work.samples.any_wanted() {
                break;
            }
        }
        work.samples.average(&mut work.color);
        self.tile.scatter(&work.color, 1.0, &mut self.color);
        if let (Some(truth), Some(out)) = (&truth, &mut self.truth) {
            truth.scatter(self.tile, out);
        }
        work.counts
    }
}

/// A tile at work.
struct Work<'a> {
    context: &'a Context<'a>,
    counts: RayCounts,
    /// Sums over the samples.
    color: Vec<[[f32; LANES]; 3]>,
    /// The pixels' random sequences for places within them.
    sequences: Vec<[u32; LANES]>,
    /// The pixels' random sequences for everything that happens on the way of their light.
    events: Vec<[u32; LANES]>,
    samples: Samples,
    /// Rays that the last event scattered.
    now: Paths,
    /// Rays that this event scatters.
    next: Paths,
}

impl Work<'_> {
    /// One ray through every pixel of the tile, and the first event where it ends.
    #[inline(always)]
    fn camera_rays(&mut self, tile: &Tile, sample: u32, mut truth: Option<&mut Truth>) {
        let context = self.context;
        let mut packet = RayHits::EMPTY;
        for (index, block) in tile.blocks().enumerate() {
            if !self.samples.wanted(index) {
                continue;
            }
            let pixels = context.tables.pixels(block);
            let points =
                if context.samples > 1 { Some(context.points(&pixels, &self.sequences[index], sample)) } else { None };
            let rays = context.tables.fill(&pixels, points.as_ref(), &mut packet);
            context.engine.intersect(&pixels.valid, &mut packet, Coherence::Coherent);
            self.counts.primary += count(&pixels.valid);
            let refined = refine::refine(context.geometry, &packet, &rays);
            if let Some(truth) = &mut truth {
                truth.push(context, &refined.depth);
            }
            let sum = &mut self.color[index];
            let missed = lights::missed(&packet.hits.triangle, &pixels.valid);
            add_escaping(context, &packet.rays, &missed, &[[1.0; LANES]; 3], &NO_CHOICE, sum);
            let found = Surfaces::primary(context.appearance, context.geometry, &packet, &rays, &refined);
            let Some(surfaces) = found else { continue };
            let mut pixel = [0; LANES];
            let mut hit = surfaces.hit;
            for lane in 0..LANES {
                pixel[lane] = (index * LANES + lane) as u32;
                hit[lane] &= pixels.valid.0[lane] != 0;
            }
            let shading = Shading {
                packet: &packet,
                surfaces: &surfaces,
                hit,
                sequences: &self.events[index],
                sample: [sample; LANES],
                event: 0,
                pixel: &pixel,
                throughput: [[1.0; LANES]; 3],
                density: &NO_CHOICE,
                goes_on: [true; LANES],
                coherence: coherence(&packet.hits.triangle),
            };
            self.counts.shadow += shade::shade(context, shading, sum, &mut self.next);
        }
    }

    /// The rays that the event number `event` scattered, and the next event where they end.
    #[inline(always)]
    fn scattered_rays(&mut self, event: u32) {
        let context = self.context;
        self.now.sort_by_direction();
        // The first event's rays start close together, and if there are many, neighbours in direction are close as well.
        // Later ones start all over the scene, unless the views of a block go the same way.
        let dense = event == 1 && self.now.len() >= DENSE;
        let coherence = if dense || context.shared_noise { Coherence::Coherent } else { Coherence::Incoherent };
        let mut packet = RayHits::EMPTY;
        // What is hit does not matter any more unless it glows.
        let sky_alone = event == context.max_bounces && !context.has_glow;
        for index in 0..self.now.len().div_ceil(LANES) {
            packet.reset();
            let paths = self.now.packet(index, &mut packet.rays);
            self.counts.other += count(&paths.valid);
            let mut gain = [[0.0; LANES]; 3];
            let mut missed = [false; LANES];
            if sky_alone {
                context.engine.occluded(&paths.valid, &mut packet.rays, coherence);
                for lane in 0..LANES {
                    missed[lane] = (paths.valid.0[lane] != 0) & (packet.rays.far[lane] >= 0.0);
                }
            } else {
                context.engine.intersect(&paths.valid, &mut packet, coherence);
                missed = lights::missed(&packet.hits.triangle, &paths.valid);
            }
            add_escaping(context, &packet.rays, &missed, &paths.throughput, &paths.density, &mut gain);
            let found = if sky_alone {
                None
            } else {
                Surfaces::secondary(context.appearance, context.geometry, &packet, &paths.valid)
            };
            if let Some(surfaces) = found {
                let mut sequences = [0; LANES];
                let mut hit = surfaces.hit;
                for lane in 0..LANES {
                    let pixel = paths.pixel[lane] as usize;
                    sequences[lane] = self.events[pixel / LANES][pixel % LANES];
                    hit[lane] &= paths.valid.0[lane] != 0;
                }
                let shading = Shading {
                    packet: &packet,
                    surfaces: &surfaces,
                    hit,
                    sequences: &sequences,
                    sample: paths.sample,
                    event,
                    pixel: &paths.pixel,
                    throughput: paths.throughput,
                    density: &paths.density,
                    goes_on: paths.goes_on,
                    coherence: if context.shared_noise { Coherence::Coherent } else { Coherence::Incoherent },
                };
                self.counts.shadow += shade::shade(context, shading, &mut gain, &mut self.next);
            }
            for lane in 0..LANES {
                if paths.valid.0[lane] != 0 {
                    let pixel = paths.pixel[lane] as usize;
                    let sum = &mut self.color[pixel / LANES];
                    for c in 0..3 {
                        sum[c][pixel % LANES] += gain[c][lane];
                    }
                }
            }
        }
    }
}

/// The density of directions that nothing else could have had.
const NO_CHOICE: [f32; LANES] = [f32::INFINITY; LANES];

/// Adds what rays that leave the scene find there.
#[inline(always)]
fn add_escaping(
    context: &Context,
    rays: &Rays,
    missed: &[bool; LANES],
    throughput: &[[f32; LANES]; 3],
    density: &[f32; LANES],
    gain: &mut [[f32; LANES]; 3],
) {
    if !missed.contains(&true) || !context.shines_from_beyond() {
        return;
    }
    let radiance = lights::beyond(context, &rays.direction, density);
    for lane in 0..LANES {
        for c in 0..3 {
            let found = (throughput[c][lane] * radiance[c][lane]).min(STRONGEST);
            gain[c][lane] += if missed[lane] { found } else { 0.0 };
        }
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
