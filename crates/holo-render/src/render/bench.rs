//! Measurements for `holo-bench`: the stages of a render, and the ray tracing backend alone on the same rays.
//!
//! Behind the feature `bench` and not part of the stable interface. Every function processes all rays of a rig, tile by
//! tile on the threads of the renderer, and returns the time.

use std::hint::black_box;
use std::time::Instant;

use holo_core::Rig;
use ndarray::Array3;
use rayon::prelude::*;

use crate::World;
use crate::accel::{Backend, Coherence, NO_TRIANGLE, RayHits};
use crate::camera::RaySource;
use crate::camera::rig::RigRays;
use crate::camera::tile::{Selection, Tile, Tiling};
use crate::error::Error;
use crate::film::reconstruct::Reconstruction;
use crate::geometry::Instancing;
use crate::render::{Renderer, Request};
use crate::simd::count;
use crate::simd::{self, Kernel};
use crate::simd::{LANES, Lanes};

use holo_scene::{Scene, Transform};

/// The storage of repeated meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Copied for every instance.
    Flattened,
    /// Stored once where possible.
    Instanced,
    /// As in a render.
    Chosen,
}

/// A renderer with Embree and this storage of repeated meshes.
///
/// # Errors
/// As [`Renderer::new`].
pub fn renderer(scene: &Scene, pose: &Transform, storage: Storage) -> Result<Renderer, Error> {
    let instancing = match storage {
        Storage::Flattened => Instancing::Never,
        Storage::Instanced => Instancing::Always,
        Storage::Chosen => Instancing::Automatic,
    };
    World::with_instancing(scene, Backend::Embree, None, instancing)?.at(pose)
}

/// The result of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    /// The number of valid rays.
    pub rays: u64,
    /// Wall-clock seconds; for the bare measurements the time inside the engine, averaged over the threads.
    pub seconds: f64,
}

/// The color and the guides of a request before their reconstruction across views, as elemental image arrays with 3 and
/// 3 channels.
///
/// # Errors
/// As [`Renderer::render`].
pub fn samples(renderer: &Renderer, request: &Request) -> Result<[Array3<f32>; 2], Error> {
    crate::render::samples(renderer, request)
}

/// Reconstructs color in place. `shape` counts lens rows and columns, view rows and columns; `error` receives the estimated
/// relative error.
pub fn reconstruct(
    renderer: &Renderer,
    shape: [usize; 4],
    color: &mut [f32],
    guides: &[f32],
    error: Option<&mut [f32]>,
) {
    let movement = [1.0; 2];
    let rows = 0..shape[0];
    let all = Reconstruction { shape, color, guides, movement, filters: true, replaces: true, rows, error };
    renderer.install(|| all.run(|| true));
}

/// The measured work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Packets of 16 rays are generated first; only the queries of the engine are timed.
    BarePackets,
    /// The same rays in the same order with one query per ray; only the queries are timed.
    BareSingle,
    /// Rays are generated and traced, and triangle and barycentrics of each are stored.
    Visibility,
}

/// Traces all primary rays of `rig` through the centers of the pixels.
#[must_use]
pub fn trace(renderer: &Renderer, rig: &Rig, work: Work) -> Traced {
    let selection = Selection::whole(rig.shape());
    let tiling = Tiling::new(selection.counts());
    let source = RaySource::Rig(RigRays::new(rig, &tiling, &selection));
    let tiles = tiling.tiles();
    // Allocated and touched in advance, so that only rays are measured.
    let mut kept: Vec<Vec<Kept>> = renderer.install(|| {
        let count = |tile: &Tile| if work == Work::Visibility { tile.packet_count() } else { 0 };
        tiles.par_iter().map(|tile| vec![Kept::EMPTY; count(tile)]).collect()
    });
    let start = Instant::now();
    let (rays, engine_seconds) = renderer.install(|| {
        tiles
            .par_iter()
            .zip(&mut kept)
            .map(|(tile, kept)| simd::run(TraceTile { renderer, source: &source, tile, work, kept }))
            .reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
    });
    let seconds = match work {
        Work::Visibility => start.elapsed().as_secs_f64(),
        Work::BarePackets | Work::BareSingle => engine_seconds / renderer.threads() as f64,
    };
    black_box(&kept);
    Traced { rays, seconds }
}

/// Triangle and barycentrics of a packet.
#[derive(Clone, Copy)]
struct Kept {
    triangle: [u32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
}

impl Kept {
    /// Not zeros, so that the memory is really allocated.
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
    /// Rays, and seconds inside the engine (for bare work only).
    type Output = (u64, f64);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let engine = self.renderer.engine();
        let mut rays = 0;
        if self.work == Work::Visibility {
            let mut packet = RayHits::EMPTY;
            for (pixels, kept) in self.source.packets(self.tile).zip(self.kept) {
                pixels.chief(&mut packet);
                engine.intersect(&pixels.valid, &mut packet, Coherence::Coherent);
                rays += count(&pixels.valid);
                kept.triangle = packet.hits.triangle;
                kept.u = packet.hits.u;
                kept.v = packet.hits.v;
            }
            return (rays, 0.0);
        }
        let mut buffer: Vec<(Lanes<i32>, RayHits)> = self
            .source
            .packets(self.tile)
            .map(|pixels| {
                let mut packet = RayHits::EMPTY;
                pixels.chief(&mut packet);
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
        black_box(&buffer);
        (buffer.iter().map(|(valid, _)| count(valid)).sum(), seconds)
    }
}
