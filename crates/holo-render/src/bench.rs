//! Measurements for `holo-bench`: the parts of a render one by one, next to the bare engine on the same rays.
//!
//! Behind the feature `bench` and not part of the stable interface. Every function works through all rays of a rig, tile
//! by tile on the renderer's threads, and says how long that took.

use std::hint::black_box;
use std::time::Instant;

use holo_core::Rig;
use rayon::prelude::*;

use crate::accel::{Backend, Coherence, NO_TRIANGLE, RayHits};
use crate::camera::RaySource;
use crate::camera::rig::RigRays;
use crate::camera::tile::{Selection, Tile, Tiling};
use crate::error::Error;
use crate::geometry::Instancing;
use crate::render::Renderer;
use crate::simd::count;
use crate::simd::{self, Kernel};
use crate::simd::{LANES, Lanes};

use holo_scene::{Scene, Transform};

/// How meshes that stand in many places are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Copied to every place.
    Flattened,
    /// Kept once wherever that is possible.
    Instanced,
    /// As a render chooses.
    Chosen,
}

/// A renderer with Embree that stores repeated meshes as told.
///
/// # Errors
/// As [`Renderer::new`].
pub fn renderer(scene: &Scene, pose: &Transform, storage: Storage) -> Result<Renderer, Error> {
    let instancing = match storage {
        Storage::Flattened => Instancing::Never,
        Storage::Instanced => Instancing::WherePossible,
        Storage::Chosen => Instancing::WhereItPays,
    };
    Renderer::with_instancing(scene, pose, Backend::Embree, 0, instancing)
}

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
    let selection = Selection::whole(rig.shape());
    let tiling = Tiling::new(selection.counts());
    let source = RaySource::Rig(RigRays::new(rig, &tiling, &selection, 4));
    let tiles = tiling.tiles();
    // Made and touched beforehand, as a caller who renders again and again would have it: what is measured is rays.
    let mut kept: Vec<Vec<Kept>> = renderer.install(|| {
        let count = |tile: &Tile| if work == Work::Visibility { tile.packet_count() } else { 0 };
        tiles.par_iter().map(|tile| vec![Kept::EMPTY; count(tile)]).collect()
    });
    let start = Instant::now();
    let (rays, hits, engine_seconds) = renderer.install(|| {
        tiles
            .par_iter()
            .zip(&mut kept)
            .map(|(tile, kept)| simd::run(TraceTile { renderer, source: &source, tile, work, kept }))
            .reduce(|| (0, 0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2))
    });
    let seconds = match work {
        Work::Visibility => start.elapsed().as_secs_f64(),
        Work::BarePackets | Work::BareSingle => engine_seconds / renderer.threads() as f64,
    };
    black_box(&kept);
    Traced { rays, hits, seconds }
}

/// Triangle and weights of a packet.
#[derive(Clone, Copy)]
struct Kept {
    triangle: [u32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
}

impl Kept {
    /// Not zeros, which the system would only promise.
    const EMPTY: Self = Self { triangle: [NO_TRIANGLE; LANES], u: [0.0; LANES], v: [0.0; LANES] };
}

struct TraceTile<'a> {
    renderer: &'a Renderer,
    source: &'a RaySource,
    tile: &'a Tile,
    work: Work,
    kept: &'a mut [Kept],
}

impl Kernel for TraceTile<'_> {
    /// Rays, hits, seconds inside the engine (bare work alone).
    type Output = (u64, u64, f64);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let engine = self.renderer.engine();
        let (mut rays, mut hits) = (0, 0);
        if self.work == Work::Visibility {
            let mut packet = RayHits::EMPTY;
            for (pixels, kept) in self.source.packets(self.tile).zip(self.kept) {
                self.source.chief(&pixels, &mut packet);
                engine.intersect(&pixels.valid, &mut packet, Coherence::Coherent);
                rays += count(&pixels.valid);
                kept.triangle = packet.hits.triangle;
                kept.u = packet.hits.u;
                kept.v = packet.hits.v;
                for lane in 0..LANES {
                    hits += u64::from((pixels.valid.0[lane] != 0) & (packet.hits.triangle[lane] != NO_TRIANGLE));
                }
            }
            return (rays, hits, 0.0);
        }
        let mut buffer: Vec<(Lanes<i32>, RayHits)> = self
            .source
            .packets(self.tile)
            .map(|pixels| {
                let mut packet = RayHits::EMPTY;
                self.source.chief(&pixels, &mut packet);
                (pixels.valid, packet)
            })
            .collect();
        let start = Instant::now();
        for (valid, packet) in &mut buffer {
            if self.work == Work::BarePackets {
                engine.intersect(valid, packet, Coherence::Coherent);
            } else {
                engine.intersect_singly(valid, packet);
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        for (valid, packet) in &buffer {
            rays += count(valid);
            hits += (0..LANES).filter(|&k| valid.0[k] != 0 && packet.hits.triangle[k] != NO_TRIANGLE).count() as u64;
        }
        (rays, hits, seconds)
    }
}
