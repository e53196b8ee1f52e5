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

use super::depth::{Truth, TruthTile, count};
use super::shade::{self, Shading};
use super::{Context, RayCounts};
use crate::accel::{Coherence, LANES, NO_TRIANGLE, RayHits};
use crate::dispatch::Kernel;
use crate::paths::Paths;
use crate::refine;
use crate::surface::Surfaces;
use crate::tile::Tile;

/// Neighbouring lanes on different triangles, of 15, from which on rays are taken for incoherent (measured).
const MANY_CHANGES: u32 = 11;

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
            now: Paths::default(),
            next: Paths::default(),
        };
        for block in self.tile.blocks() {
            work.sequences.push(context.sequences(&context.tables.pixels(block)));
        }
        let mut truth = self.truth.is_some().then(Truth::default);
        for sample in 0..context.samples {
            if context.stop.requested() {
                return work.counts;
            }
            work.camera_rays(self.tile, sample, truth.as_mut());
            for event in 1..=context.max_bounces {
                std::mem::swap(&mut work.now, &mut work.next);
                if work.now.len() == 0 {
                    break;
                }
                work.scattered_rays(event, sample);
                work.now.clear();
            }
        }
        self.tile.scatter(&work.color, 1.0 / context.samples as f32, &mut self.color);
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
    /// The pixels' random sequences.
    sequences: Vec<[u32; LANES]>,
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
            for lane in 0..LANES {
                let missed = if packet.hits.triangle[lane] == NO_TRIANGLE { 1.0 } else { 0.0 };
                for c in 0..3 {
                    sum[c][lane] += context.sky[c] * missed;
                }
            }
            let found = Surfaces::primary(context.appearance, context.geometry, &packet, &rays, &refined);
            let Some(surfaces) = found else { continue };
            let mut pixel = [0; LANES];
            for lane in 0..LANES {
                pixel[lane] = (index * LANES + lane) as u32;
            }
            let shading = Shading {
                packet: &packet,
                surfaces: &surfaces,
                valid: &pixels.valid,
                sequences: &self.sequences[index],
                sample,
                event: 0,
                pixel: &pixel,
                throughput: &[[1.0; LANES]; 3],
                coherence: coherence(&packet.hits.triangle),
            };
            self.counts.shadow += shade::shade(context, &shading, sum, &mut self.next);
        }
    }

    /// The rays that the event number `event` scattered, and the next event where they end.
    #[inline(always)]
    fn scattered_rays(&mut self, event: u32, sample: u32) {
        let context = self.context;
        self.now.sort_by_direction();
        let mut packet = RayHits::EMPTY;
        let last = event == context.max_bounces;
        for index in 0..self.now.len().div_ceil(LANES) {
            packet.reset();
            let paths = self.now.packet(index, &mut packet.rays);
            let mut gain = [[0.0; LANES]; 3];
            if last {
                // Neighbours in direction still start all over the tile.
                context.engine.occluded(&paths.valid, &mut packet.rays, Coherence::Incoherent);
                for lane in 0..LANES {
                    let escaped = if packet.rays.far[lane] > 0.0 { 1.0 } else { 0.0 };
                    for c in 0..3 {
                        gain[c][lane] = paths.throughput[c][lane] * context.sky[c] * escaped;
                    }
                }
                self.counts.other += count(&paths.valid);
            } else {
                context.engine.intersect(&paths.valid, &mut packet, Coherence::Incoherent);
                self.counts.other += count(&paths.valid);
                for lane in 0..LANES {
                    let escaped = if packet.hits.triangle[lane] == NO_TRIANGLE { 1.0 } else { 0.0 };
                    for c in 0..3 {
                        gain[c][lane] = paths.throughput[c][lane] * context.sky[c] * escaped;
                    }
                }
                let found = Surfaces::secondary(context.appearance, context.geometry, &packet, &paths.valid);
                if let Some(surfaces) = found {
                    let mut sequences = [0; LANES];
                    for lane in 0..LANES {
                        let pixel = paths.pixel[lane] as usize;
                        sequences[lane] = self.sequences[pixel / LANES][pixel % LANES];
                    }
                    let shading = Shading {
                        packet: &packet,
                        surfaces: &surfaces,
                        valid: &paths.valid,
                        sequences: &sequences,
                        sample,
                        event,
                        pixel: &paths.pixel,
                        throughput: &paths.throughput,
                        coherence: Coherence::Incoherent,
                    };
                    self.counts.shadow += shade::shade(context, &shading, &mut gain, &mut self.next);
                }
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
