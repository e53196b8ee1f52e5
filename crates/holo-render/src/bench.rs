//! Measurements for `holo-bench`: the parts of a render one by one, next to the bare engine on the same rays.
//!
//! Behind the feature `bench` and not part of the stable interface. Every function works through all rays of a rig, tile
//! by tile on the renderer's threads, and says how long that took.

use std::hint::black_box;
use std::time::Instant;

use holo_core::Rig;
use rayon::prelude::*;

use crate::accel::{LANES, Lanes, NO_TRIANGLE, RayHits};
use crate::dispatch::{self, Kernel};
use crate::integrator::depth::{CENTRE, count};
use crate::primary::RigTables;
use crate::render::Renderer;
use crate::tile::{Tile, Tiling};

/// Rays, how many of them hit, and the time they took.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    /// Valid rays.
    pub rays: u64,
    /// Those that hit something.
    pub hits: u64,
    /// Wall-clock seconds; for the bare measurements the engine's own time, averaged over the threads.
    pub seconds: f64,
}

/// What is done with the rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Packets of 16 are made first; only the engine's calls are timed.
    BarePackets,
    /// The same rays in the same order one at a time; only the engine's calls are timed.
    BareSingle,
    /// Rays are made, traced, and triangle and weights of every one are kept.
    Visibility,
}

/// Traces all primary rays of `rig` through the pixels' centres.
#[must_use]
pub fn trace(renderer: &Renderer, rig: &Rig, work: Work) -> Traced {
    let split = rig.split();
    let (lenses, views) = (split.lenses(), split.views());
    let tiling = Tiling::new([lenses.rows, lenses.columns, views.rows, views.columns]);
    let tables = RigTables::new(rig);
    let tiles = tiling.tiles();
    let start = Instant::now();
    let (rays, hits, engine_seconds) = renderer.install(|| {
        let mut kept: Vec<Vec<Kept>> = Vec::new();
        let traced = tiles
            .par_iter()
            .map(|tile| dispatch::run(TraceTile { renderer, tables: &tables, tile, work }))
            .fold(Vec::new, |mut all: Vec<(Vec<Kept>, [u64; 2], f64)>, one| {
                all.push(one);
                all
            })
            .reduce(Vec::new, |mut a, b| {
                a.extend(b);
                a
            });
        let mut sums = (0, 0, 0.0);
        for (hits, [rays, hit], seconds) in traced {
            kept.push(hits);
            sums = (sums.0 + rays, sums.1 + hit, sums.2 + seconds);
        }
        black_box(&kept);
        sums
    });
    let seconds = match work {
        Work::Visibility => start.elapsed().as_secs_f64(),
        Work::BarePackets | Work::BareSingle => engine_seconds / renderer.threads() as f64,
    };
    Traced { rays, hits, seconds }
}

/// Triangle and weights of a packet.
struct Kept {
    _triangle: [u32; LANES],
    _u: [f32; LANES],
    _v: [f32; LANES],
}

struct TraceTile<'a> {
    renderer: &'a Renderer,
    tables: &'a RigTables,
    tile: &'a Tile,
    work: Work,
}

impl Kernel for TraceTile<'_> {
    type Output = (Vec<Kept>, [u64; 2], f64);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let engine = self.renderer.engine();
        let packets = self.tile.packet_count();
        let hit = |packet: &RayHits, valid: &Lanes<i32>| {
            (0..LANES).filter(|&k| valid.0[k] != 0 && packet.hits.triangle[k] != NO_TRIANGLE).count() as u64
        };
        let (mut rays, mut hits) = (0, 0);
        if self.work == Work::Visibility {
            let mut kept = Vec::with_capacity(packets);
            let mut packet = RayHits::EMPTY;
            for index in 0..packets {
                let pixels = self.tile.pixels(index);
                self.tables.fill(&pixels, [&CENTRE, &CENTRE], &mut packet);
                engine.intersect(&pixels.valid, &mut packet);
                rays += count(&pixels.valid);
                hits += hit(&packet, &pixels.valid);
                kept.push(Kept { _triangle: packet.hits.triangle, _u: packet.hits.u, _v: packet.hits.v });
            }
            return (kept, [rays, hits], 0.0);
        }
        let mut buffer: Vec<(Lanes<i32>, RayHits)> = (0..packets)
            .map(|index| {
                let pixels = self.tile.pixels(index);
                let mut packet = RayHits::EMPTY;
                self.tables.fill(&pixels, [&CENTRE, &CENTRE], &mut packet);
                (pixels.valid, packet)
            })
            .collect();
        let start = Instant::now();
        for (valid, packet) in &mut buffer {
            if self.work == Work::BarePackets {
                engine.intersect(valid, packet);
            } else {
                engine.intersect_singly(valid, packet);
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        for (valid, packet) in &buffer {
            rays += count(valid);
            hits += hit(packet, valid);
        }
        (Vec::new(), [rays, hits], seconds)
    }
}
