//! Path tracing with next-event estimation.
//!
//! **Estimator.** The radiance along every camera ray by the rendering equation (Kajiya, 1986) with at most
//! `max_bounces` bounces (Mitsuba's `max_depth` - 1, Cycles' `max_bounces` + 1). A path vertex is a hit of the path on
//! a surface; a bounce is a scattering at a vertex. One bounce is direct light: [`super::direct`] is this integrator
//! with `max_bounces` = 1.
//!
//! **Sampling.** Every path vertex samples the lights (next-event estimation) and the BSDF, which gives the direction
//! of the next path segment. Punctual lights are only found by light sampling. The constant sky is only found by BSDF
//! sampling. The environment map and emissive surfaces are found by both, weighted by the balance heuristic (Veach and
//! Guibas, 1995). The first vertex samples all punctual lights if there are at most eight; otherwise, and at later
//! vertices, one is selected by resampled importance sampling.
//!
//! **Russian roulette.** From the third vertex on, a path with a throughput below 1/8 survives with a probability of 8
//! times its throughput (at least 5 %), and its throughput is divided by that probability. This is unbiased and can be
//! switched off.
//!
//! **Order.** The paths of a tile advance together, one vertex at a time: first the camera rays in packets of
//! neighboring views, then all rays that were scattered at the first vertex, traced in the order of their directions and
//! shaded in the order of the surfaces that they hit ([`super::paths`]), and so on. Rays after the last bounce are only
//! tested for occlusion, unless surfaces emit.
//!
//! **Samples.** A single sample goes through the center of the pixel; more are distributed over the pixel (box filter),
//! see [`crate::Sampling`].

use std::ops::Range;

use ndarray::ArrayViewMut5;

use super::paths::{self, Order, PathPacket, Paths, Scattered};
use super::reuse::{self, SharedLight, Step};
use super::shade;
use super::unseen::Unseen;
use super::vertex::Shading;
use super::{Context, RayCounts, mis};
use crate::accel::refine;
use crate::accel::{CAMERA_RAY, Coherence, NO_TRIANGLE, RayHits};
use crate::camera::tile::Tile;
use crate::camera::{CameraRays, PixelPacket};
use crate::film::adaptive::Samples;
use crate::film::guides::{self, Guides, Movement};
use crate::film::inverse_depth::{self, InverseDepths};
use crate::film::tint;
use crate::material::media::MediaStack;
use crate::material::{HitPoints, SurfaceInteraction};
use crate::sampling::{self, RANKS, Runs, SamplesPerPixel};
use crate::simd::Kernel;
use crate::simd::{LANES, at, count};

/// The number of [changes](paths::changes) of scattered rays, as a running mean over the packets before, above which they are
/// traced as incoherent (tuned for speed): towards walls and floors
/// coherent packets take 0.9 of the time, towards foliage incoherent ones do.
const SCATTERED_CHANGES: f32 = 5.5;

/// The weight of the packet before in that mean.
const LAST_CHANGES: f32 = 1.0 / 16.0;

/// The number of samples per pixel whose scattered rays are sorted together.
const SAMPLES_PER_PASS: u32 = 4;

/// The approximate number of rays that are sorted together, for one bounce and for more (tuned for speed): more rays
/// are more coherent after sorting, until they do not fit into the cache.
const SORTED_RAYS: [usize; 2] = [8192, 32_768];

/// With less than one sample per pixel a tile is at most this many times as large, because all of its pixels are in memory.
const MOST_SPREAD: u32 = 8;

/// The size of a tile, in pixels, for this many samples per pixel and bounces.
pub(crate) fn tile_pixels(samples: SamplesPerPixel, bounces: u32) -> usize {
    let spread = samples.pixels().min(MOST_SPREAD) as usize;
    SORTED_RAYS[usize::from(bounces > 1)] * spread / samples.of_traced().clamp(1, SAMPLES_PER_PASS) as usize
}

/// The integrator over one tile.
pub(crate) struct PathTile<'a, 'b> {
    pub context: &'a Context<'a>,
    pub tile: &'a Tile,
    pub color: ArrayViewMut5<'b, f32>,
    /// The guides of the pixels, if the context wants them.
    pub guides: Option<ArrayViewMut5<'b, f32>>,
    /// The statistics of the inverse depth, if the context wants them.
    pub inverse_depths: Option<ArrayViewMut5<'b, f32>>,
    pub round: &'a Round,
    /// The packets of the tile that may take part; all if empty.
    pub wanted: &'a [bool],
    pub scratch: &'a mut Scratch,
}

/// A round of samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Round {
    /// The numbers of its samples.
    pub samples: Range<u32>,
    /// The [ranks](sampling::rank) of the packets that take part.
    pub ranks: Range<u32>,
}

impl Round {
    /// All samples of some packets, in one round.
    pub fn whole(samples: SamplesPerPixel) -> Self {
        Self { samples: 0..samples.of_traced(), ranks: 0..samples.ranks() }
    }

    /// Whether no round was before it.
    pub fn is_first(&self) -> bool {
        self.samples.start == 0 && self.ranks.start == 0
    }
}

/// The state of the paths of a tile. Reused from tile to tile.
#[derive(Default)]
pub(crate) struct Scratch {
    /// The sums over the samples, in packet order.
    color: Vec<[[f32; LANES]; 3]>,
    /// The runs of the pixels in the random sequences.
    runs: Vec<Runs>,
    samples: Samples,
    guides: Guides,
    unseen: Unseen,
    inverse_depths: InverseDepths,
    shared: SharedLight,
    /// Rays that were scattered at the previous vertex.
    now: Paths,
    /// Rays that are scattered at the current vertex.
    next: Scattered,
}

impl Kernel for PathTile<'_, '_> {
    type Output = RayCounts;

    #[inline(always)]
    fn run(mut self) -> RayCounts {
        let context = self.context;
        self.scratch.begin(context, self.tile, self.round, self.wanted);
        let mut tile_paths = TilePaths { context, counts: RayCounts::default(), scratch: self.scratch };
        let round = self.round.samples.clone();
        for first in round.clone().step_by(SAMPLES_PER_PASS as usize) {
            let end = round.end.min(first + SAMPLES_PER_PASS);
            if context.stop.requested() {
                return tile_paths.counts;
            }
            let leaves_out = first == 0 && self.round.is_first() && context.guides.is_some();
            let sees = if leaves_out { Sees::Some } else { Sees::Samples };
            for vertex in 0..=context.policy.max_bounces {
                tile_paths.trace(self.tile, Stage { vertex, gathers: false, sees }, [first, end]);
                if tile_paths.scratch.next.is_empty() {
                    break;
                }
            }
            if leaves_out && tile_paths.scratch.unseen.fill(&mut tile_paths.scratch.guides) {
                tile_paths.trace(self.tile, Stage { vertex: 0, gathers: false, sees: Sees::Rest }, [0, 1]);
            }
            if context.policy.reuse {
                let sees = Sees::Samples;
                tile_paths.trace(self.tile, Stage { vertex: 0, gathers: true, sees }, [first, end]);
            }
            tile_paths.scratch.samples.add(end - first, &tile_paths.scratch.color);
            if !tile_paths.scratch.samples.any_wanted() {
                break;
            }
        }
        let scratch = tile_paths.scratch;
        if !self.round.is_first() {
            let counts = tile_paths.counts;
            self.merge();
            return counts;
        }
        if let Some(out) = &mut self.guides {
            let color = scratch.color.iter().enumerate();
            let packet = |(k, color)| scratch.guides.packet(k, color, scratch.samples.count(k));
            self.tile.write(&color.map(packet).collect::<Vec<_>>(), 1.0, out);
        }
        if let Some(out) = &mut self.inverse_depths {
            // With guides the light of a pixel is compared with that of others: means, as color.
            let factor = |k: usize| 1.0 / scratch.samples.count(k).max(1) as f32;
            let packet = |k: usize| match &context.guides {
                Some(_) => inverse_depth::scaled(scratch.inverse_depths.packet(k), factor(k)),
                None => scratch.inverse_depths.packet(k),
            };
            let packets: Vec<_> = (0..self.tile.packet_count()).map(packet).collect();
            self.tile.write(&packets, 1.0, out);
        }
        let scale = scratch.samples.average(&mut scratch.color, round.end);
        self.tile.write(&scratch.color, scale, &mut self.color);
        tile_paths.counts
    }
}

impl PathTile<'_, '_> {
    /// Adds the samples of a later round to the means over those before it.
    #[inline(always)]
    fn merge(&mut self) {
        let scratch = &mut *self.scratch;
        let mut color = self.tile.read::<3>(&self.color);
        let Some(guides) = &mut self.guides else { return };
        let mut all = self.tile.read::<{ guides::CHANNELS }>(guides);
        let mut statistics = self.inverse_depths.as_mut().map(|out| {
            let packets = self.tile.read::<{ inverse_depth::CHANNELS }>(out);
            (out, packets)
        });
        for k in (0..color.len()).filter(|&k| scratch.samples.count(k) > 0) {
            let added = scratch.samples.count(k);
            // Lanes without a pixel have no samples.
            let before = all[k][guides::SAMPLES].iter().fold(0.0f32, |high, &count| high.max(count));
            let one = scratch.guides.packet(k, &scratch.color[k], added);
            if let Some((_, packets)) = &mut statistics {
                let part = before / (before + added as f32);
                let [old, new] = [(packets[k], part), (scratch.inverse_depths.packet(k), (1.0 - part) / added as f32)]
                    .map(|(values, factor)| inverse_depth::scaled(values, factor));
                packets[k] = if before > 0.0 { inverse_depth::merged_packets(&old, &new) } else { new };
            }
            guides::merge((&mut color[k], &mut all[k]), (&scratch.color[k], &one), [before, added as f32]);
        }
        self.tile.write(&all, 1.0, guides);
        if let Some((out, packets)) = statistics {
            self.tile.write(&packets, 1.0, out);
        }
        self.tile.write(&color, 1.0, &mut self.color);
    }
}

impl Scratch {
    /// Resets the state for another tile.
    #[inline(always)]
    fn begin(&mut self, context: &Context, tile: &Tile, round: &Round, wanted: &[bool]) {
        self.color.clear();
        self.color.resize(tile.packet_count(), [[0.0; LANES]; 3]);
        self.runs.clear();
        self.samples.begin(context.policy.target_error);
        if context.guides.is_some() {
            self.guides.begin(round.samples.len() as u32, tile.packet_count());
        }
        self.unseen.begin(&context.guides);
        if context.inverse_depths {
            self.inverse_depths.begin(tile.packet_count());
        }
        self.next.clear();
        for (k, pixels) in context.camera.packets(tile).enumerate() {
            let has_all = round.ranks == (0..RANKS);
            let rank = if has_all { 0 } else { pixels.rank(context.sampler.seed) };
            let has_samples = round.ranks.contains(&rank) && (wanted.is_empty() || wanted[k]);
            self.samples.push(&pixels.valid, has_samples);
            if !has_all && context.guides.is_some() {
                self.unseen.push(&pixels, rank, has_samples);
            }
            self.runs.push(context.sampler.runs(&pixels.ids));
        }
    }
}

/// A tile during path tracing.
struct TilePaths<'a> {
    context: &'a Context<'a>,
    counts: RayCounts,
    scratch: &'a mut Scratch,
}

/// A pass over packets of rays: to one vertex of the paths, or, at the end, once more to the first vertex to gather the
/// light that its packets share.
#[derive(Clone, Copy)]
struct Stage {
    vertex: u32,
    gathers: bool,
    sees: Sees,
}

/// Which packets are traced to a first vertex.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sees {
    /// Those that take part.
    Samples,
    /// Also some others, for the guides.
    Some,
    /// The others that turned out to be needed, but those that take part no more.
    Rest,
}

/// Sixteen traced rays.
struct Traced {
    paths: PathPacket,
    sequences: [u32; LANES],
    points: HitPoints,
    coherence: Coherence,
}

impl TilePaths<'_> {
    /// Traces all rays of a stage - the camera rays of the samples from `first` to `end`, or the rays that were scattered
    /// at the previous vertex - and shades their hits.
    ///
    /// A single loop shades both: the called functions are large and are compiled into the kernel once.
    #[inline(always)]
    fn trace(&mut self, tile: &Tile, stage: Stage, [first, end]: [u32; 2]) {
        let (context, vertex) = (self.context, stage.vertex);
        let per_sample = self.scratch.color.len();
        let packets = match vertex {
            0 => per_sample * (end - first) as usize,
            _ => {
                self.scratch.now.sort_to_trace(&mut self.scratch.next, context.scene.geometry);
                let count =
                    if self.only_light_counts(vertex) { self.scratch.now.len() } else { self.trace_scattered(vertex) };
                count.div_ceil(LANES)
            }
        };
        let mut pixel_packets = context.camera.packets(tile);
        let mut packet = RayHits::EMPTY;
        if context.policy.reuse && vertex == 0 && !stage.gathers {
            self.scratch.shared.begin(packets, per_sample);
        }
        for k in 0..packets {
            packet.reset();
            let traced = if vertex == 0 {
                let index = k % per_sample;
                if index == 0 {
                    pixel_packets = context.camera.packets(tile);
                }
                let Some(pixels) = pixel_packets.next() else { return };
                let sample = first + (k / per_sample) as u32;
                let is_left_out = stage.gathers && !self.scratch.shared.is_active(k);
                let takes_part = stage.sees != Sees::Rest && self.scratch.samples.wanted(index);
                let sees = match stage.sees {
                    Sees::Samples => false,
                    Sees::Some => sample == 0 && self.scratch.unseen.is_traced(index),
                    Sees::Rest => self.scratch.unseen.is_missing(index),
                };
                if is_left_out || !(takes_part || sees) {
                    continue;
                }
                let traced = self.camera_rays(&pixels, index, sample, stage.gathers, &mut packet);
                if !takes_part {
                    continue;
                }
                self.counts.primary += if stage.gathers { 0 } else { count(&traced.paths.valid) };
                traced
            } else {
                self.scattered_rays(k, vertex, &mut packet)
            };
            self.shade(stage, k, &packet, traced);
        }
    }

    /// Shades packet number `k` of a stage, whose rays were traced.
    #[inline(always)]
    fn shade(&mut self, stage: Stage, k: usize, packet: &RayHits, mut traced: Traced) {
        let (context, vertex) = (self.context, stage.vertex);
        let mut contribution = [[0.0; LANES]; 3];
        let misses = mis::misses(packet, &traced.paths.valid);
        let is_second = context.policy.reuse && vertex == 1;
        let places = if is_second { self.scratch.shared.take_back(&mut traced.paths) } else { None };
        let mut is_shared = [false; LANES];
        if let Some(places) = &places {
            let direction = &packet.rays.direction;
            is_shared = self.scratch.shared.environment(&context.scene, places, &misses, direction);
        }
        let escaped = (&misses, &is_shared, vertex == 0);
        mis::add_environment(context, &packet.rays, escaped, &traced.paths, &mut contribution);
        let found = SurfaceInteraction::new(context.scene.appearance, context.scene.geometry, packet, &traced.points);
        if vertex == 0 && !stage.gathers && matches!(context.guides, Some(Movement::Disparity(..))) {
            let packet = traced.paths.pixel[0] as usize / LANES;
            self.scratch.guides.add_tint(packet, &tint::of(found.as_ref()));
        }
        if let Some(interaction) = &found {
            let mut hit = interaction.hit;
            for lane in 0..LANES {
                hit[lane] &= traced.paths.valid.0[lane] != 0;
            }
            let mut shading = Shading {
                packet,
                interaction,
                footprints: traced.points.footprints.as_ref(),
                hit,
                sequences: &traced.sequences,
                vertex,
                media_behind: [MediaStack::AIR; LANES],
                paths: &mut traced.paths,
                coherence: traced.coherence,
            };
            let mut step = Step::Alone;
            if let Some(places) = &places {
                step = Step::Finds { shared: &mut self.scratch.shared, places };
            }
            let goes_on = shade::arrive(context, &mut shading, step, &mut contribution);
            let mut step = Step::Alone;
            if stage.gathers {
                // Emission and the environment were added before.
                contribution = [[0.0; LANES]; 3];
                step = self.scratch.shared.gathers(k);
            } else if context.policy.reuse && vertex == 0 {
                if reuse::pays(context.policy.max_bounces, &shading, &shading.paths.valid) {
                    step = self.scratch.shared.scatters(k, shading.paths.pixel[0]);
                }
            } else if let Some(places) = &places
                && goes_on
            {
                // So far these have received nothing for their own pixels.
                self.scratch.shared.surfaces(&context.scene, places, &mut shading);
            }
            if goes_on {
                let next = &mut self.scratch.next;
                self.counts.shadow += shade::reflect(context, &shading, step, &mut contribution, next);
            }
        }
        add(self.scratch, context, vertex, &traced.paths, &contribution);
    }

    /// One camera ray through every pixel of a packet; `again` if it was traced before.
    #[inline(always)]
    fn camera_rays(
        &mut self,
        pixels: &PixelPacket,
        index: usize,
        sample: u32,
        again: bool,
        packet: &mut RayHits,
    ) -> Traced {
        let context = self.context;
        let runs = self.scratch.runs[index];
        let indices = runs.first.map(|first| first + sample);
        let CameraRays { exact, weight, valid, cells } = pixels.sample(&context.sampler, sample, packet);
        packet.rays.id = [CAMERA_RAY; LANES];
        if context.scene.has_alpha {
            let numbers = sampling::ray_numbers(&runs.sequence, &indices, 0);
            packet.rays.id = numbers.map(|number| number | CAMERA_RAY);
        }
        if let Some(moved) = context.moved {
            moved.move_rays(&mut packet.rays);
        }
        context.scene.engine.intersect(&valid, packet, Coherence::Coherent);
        let refined = refine::refine(context.scene.geometry, packet, &exact);
        if let Some(Movement::Disparity(map, _)) = &context.guides
            && !again
        {
            let mut disparity = [0.0; LANES];
            for lane in 0..LANES {
                disparity[lane] = map.from_depth_m(refined.depth[lane]) as f32;
            }
            self.scratch.guides.add_disparity(index, &disparity);
        }
        if context.inverse_depths {
            self.scratch.inverse_depths.add(index, &valid, &weight, &refined.depth);
        }
        let mut paths = PathPacket {
            valid,
            bsdf_pdf: [f32::INFINITY; LANES],
            pixel: [0; LANES],
            throughput: [weight; 3],
            index: indices,
            may_scatter: [true; LANES],
            media: [MediaStack::AIR; LANES],
        };
        for lane in 0..LANES {
            paths.pixel[lane] = (index * LANES + lane) as u32;
        }
        let coherence = paths::coherence(packet);
        Traced {
            paths,
            sequences: runs.sequence,
            points: match context.moved {
                None => HitPoints::primary(&exact, &refined, cells.as_ref()),
                Some(_) => HitPoints::secondary(context.scene.geometry, packet),
            },
            coherence,
        }
    }

    /// Whether rays to this vertex bring only the light behind the scene: after the last bounce, if no surface emits.
    #[inline(always)]
    fn only_light_counts(&self, vertex: u32) -> bool {
        vertex == self.context.policy.max_bounces && !self.context.scene.has_emission
    }

    /// Traces the rays that were scattered at the previous vertex; returns the number of those that bring something.
    #[inline(always)]
    fn trace_scattered(&mut self, vertex: u32) -> usize {
        let context = self.context;
        let (geometry, engine) = (context.scene.geometry, context.scene.engine);
        let misses_count = context.scene.has_light_at_infinity();
        let mut packet = RayHits::EMPTY;
        let mut mean_changes = 0.0;
        for k in 0..self.scratch.now.len().div_ceil(LANES) {
            packet.reset();
            let rays = self.scratch.now.rays(k, &mut packet.rays);
            self.counts.secondary += count(&rays.valid);
            if context.scene.has_alpha {
                packet.rays.id = sampling::ray_numbers(&self.sequences(&rays.pixel), &rays.index, vertex);
            }
            // Neighbors in direction hit neighboring surfaces: the packets before tell how much apart.
            let is_coherent = mean_changes <= SCATTERED_CHANGES;
            let coherence = if is_coherent { Coherence::Coherent } else { Coherence::Incoherent };
            engine.intersect(&rays.valid, &mut packet, coherence);
            mean_changes += (paths::changes(&packet) as f32 - mean_changes) * LAST_CHANGES;
            self.scratch.now.record(k, &packet, geometry, misses_count);
        }
        self.scratch.now.sort_to_shade()
    }

    /// The random sequences of paths.
    #[inline(always)]
    fn sequences(&self, pixel: &[u32; LANES]) -> [u32; LANES] {
        let mut sequences = [0; LANES];
        for lane in 0..LANES {
            let pixel = pixel[lane] as usize;
            let packet = if self.context.policy.reuse {
                self.scratch.shared.packet_of_tile(pixel / LANES)
            } else {
                pixel / LANES
            };
            sequences[lane] = self.scratch.runs[packet].sequence[pixel % LANES];
        }
        sequences
    }

    /// Packet number `k` of the rays that were scattered at the previous vertex and bring something. Those that bring only the
    /// light behind the scene are traced here, and valid if nothing hides it.
    #[inline(always)]
    fn scattered_rays(&mut self, k: usize, vertex: u32, packet: &mut RayHits) -> Traced {
        let context = self.context;
        let only_light_counts = self.only_light_counts(vertex);
        let order = if only_light_counts { Order::Traced } else { Order::Shaded };
        let mut paths = self.scratch.now.packet(k, order, packet);
        let sequences = self.sequences(&paths.pixel);
        if only_light_counts {
            self.counts.secondary += count(&paths.valid);
            packet.rays.near = [0.0; LANES];
            if context.scene.has_alpha {
                packet.rays.id = sampling::ray_numbers(&sequences, &paths.index, vertex);
            }
            context.scene.engine.occluded(&paths.valid, &mut packet.rays, Coherence::Incoherent);
            for lane in 0..LANES {
                paths.valid.0[lane] &= -i32::from(packet.rays.far[lane] >= 0.0);
            }
        }
        let mut points = HitPoints::NONE;
        if packet.hits.triangle.iter().any(|&triangle| triangle != NO_TRIANGLE) {
            points = HitPoints::secondary(context.scene.geometry, packet);
        }
        Traced { paths, sequences, points, coherence: Coherence::Incoherent }
    }
}

/// Adds the contributions of a packet to its pixels, or to the sums of shared light.
#[inline(always)]
fn add(scratch: &mut Scratch, context: &Context, vertex: u32, paths: &PathPacket, contribution: &[[f32; LANES]; 3]) {
    let guides = &mut scratch.guides;
    if vertex == 0 {
        let sum = &mut scratch.color[paths.pixel[0] as usize / LANES];
        for c in 0..3 {
            for lane in 0..LANES {
                sum[c][lane] += contribution[c][lane];
            }
        }
        if context.guides.is_some() && guides.is_second(paths.index[0]) {
            for lane in 0..LANES {
                guides.add_second(paths.pixel[0] as usize / LANES, lane, at(contribution, lane));
            }
        }
        return;
    }
    let limit = context.policy.indirect_limit;
    for lane in 0..LANES {
        if paths.valid.0[lane] != 0 {
            let strongest = contribution[0][lane].max(contribution[1][lane]).max(contribution[2][lane]);
            let scale = if strongest > limit { limit / strongest } else { 1.0 };
            let pixel = paths.pixel[lane] as usize;
            if context.policy.reuse
                && let Some(sum) = scratch.shared.sum(pixel / LANES)
            {
                // Without a limit: reuse needs that.
                for c in 0..3 {
                    sum[c][pixel % LANES] += contribution[c][lane];
                }
                continue;
            }
            let sum = &mut scratch.color[pixel / LANES];
            for c in 0..3 {
                sum[c][pixel % LANES] += contribution[c][lane] * scale;
            }
            if context.guides.is_some() && guides.is_second(paths.index[lane]) {
                let added = at(contribution, lane).map(|value| value * scale);
                guides.add_second(pixel / LANES, pixel % LANES, added);
            }
        }
    }
}
