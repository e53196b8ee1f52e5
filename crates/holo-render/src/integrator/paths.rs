//! The scattered rays of one tile, sorted twice: by direction before they are traced, and by the surface that they have
//! hit before they are shaded.
//!
//! Scattered rays are incoherent as they come. But the pixels of one tile start close together, so the rays are
//! collected, sorted by direction and traced in packets of similar directions. The rays of such a packet hit different
//! surfaces, and a packet costs what its costliest lane needs. So the hits are collected too, sorted, and shaded in packets
//! that mostly lie on one surface. Rays that have missed the scene come first, or are left out if no light is behind it.
//! The order of the rays of a pixel depends only on those rays.

use crate::accel::{Coherence, NO_TRIANGLE, RayHits, Rays};
use crate::geometry::{FLATTENED, Geometry};
use crate::material::media::MediaStack;
use crate::simd::{LANES, Lanes};

/// The number of cells per side of the square octahedral map by which directions are sorted.
const CELLS: usize = 64;

/// The number of bins by which traced rays are sorted: the first holds those that have hit nothing, the others have an
/// instance each, or several where there are more instances.
const BINS: usize = 1024;

/// In place of a bin: rays that bring nothing, which are not sorted.
const NOTHING: u32 = u32::MAX;

/// A scattered ray with the state of its path: one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Path {
    pub origin: [f32; 3],
    /// The BSDF-sampling pdf of the direction, per solid angle; infinite for a delta lobe.
    pub bsdf_pdf: f32,
    pub direction: [f32; 3],
    /// Index of the pixel in the tile.
    pub pixel: u32,
    pub throughput: [f32; 3],
    /// The index of the sample in its random sequence, with a flag.
    pub sample: SampleState,
    /// What the ray has hit.
    pub hit: PathHit,
}

const _: () = assert!(size_of::<Path>() == 64);

/// The hit of a scattered ray, without its placement.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct PathHit {
    /// The ray parameter.
    far: f32,
    /// The barycentrics.
    u: f32,
    v: f32,
    triangle: u32,
}

impl PathHit {
    /// Nothing, or not traced yet.
    pub const NONE: Self = Self { far: f32::INFINITY, u: 0.0, v: 0.0, triangle: NO_TRIANGLE };
}

/// The index of a sample in its random sequence, below 2^31, and whether the path may be scattered again at the next vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleState(u32);

impl SampleState {
    #[inline(always)]
    pub fn new(index: u32, may_scatter: bool) -> Self {
        Self(index << 1 | u32::from(may_scatter))
    }

    #[inline(always)]
    pub fn index(self) -> u32 {
        self.0 >> 1
    }

    #[inline(always)]
    pub fn may_scatter(self) -> bool {
        self.0 & 1 != 0
    }
}

/// The rays of one tile that are scattered at one vertex, in the order in which they are: at most one per sample.
#[derive(Default)]
pub(crate) struct Scattered {
    paths: Vec<Path>,
    /// The media around each path; empty if the scene has no bodies of glass.
    media: Vec<MediaStack>,
    /// The cells of the directions.
    cells: Vec<u32>,
}

impl Scattered {
    /// Adds a ray whose direction lies in `cell` (see [`cell`]); with its media if the scene has any.
    #[inline(always)]
    pub fn push(&mut self, path: Path, cell: u32, media: Option<MediaStack>) {
        self.paths.push(path);
        self.media.extend(media);
        self.cells.push(cell);
    }

    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    pub fn clear(&mut self) {
        self.paths.clear();
        self.media.clear();
        self.cells.clear();
    }
}

/// The scattered rays of one tile in the order in which they are traced, which is that of memory: their state is larger
/// than the inner caches, and is read and written twice.
#[derive(Default)]
pub(crate) struct Paths {
    paths: Vec<Path>,
    /// The media around each path; empty if the scene has no bodies of glass.
    media: Vec<MediaStack>,
    /// The placement that each path has hit; empty if the geometry has none.
    placements: Vec<u32>,
    /// The bins of the paths.
    bins: Vec<u32>,
    /// Numbers of scattered rays or paths in the order of the last sort.
    order: Vec<u32>,
    /// Scratch of the sorts.
    starts: Vec<u32>,
}

/// The order in which packets of paths are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// That in which they are traced.
    Traced,
    /// That in which they are shaded, without those that bring nothing.
    Shaded,
}

/// Sixteen rays of paths before they are traced.
pub(crate) struct PathRays {
    pub valid: Lanes<i32>,
    pub pixel: [u32; LANES],
    /// The index of the sample in its random sequence.
    pub index: [u32; LANES],
}

/// Up to sixteen paths.
pub(crate) struct PathPacket {
    pub valid: Lanes<i32>,
    pub bsdf_pdf: [f32; LANES],
    pub pixel: [u32; LANES],
    pub throughput: [[f32; LANES]; 3],
    /// The index of the sample in its random sequence.
    pub index: [u32; LANES],
    pub may_scatter: [bool; LANES],
    pub media: [MediaStack; LANES],
}

impl Paths {
    /// Takes over all scattered rays, sorted by direction, to be traced.
    #[inline(always)]
    pub fn sort_to_trace(&mut self, scattered: &mut Scattered, geometry: &Geometry) {
        counting_sort(&scattered.cells, CELLS * CELLS, &mut self.starts, &mut self.order);
        self.paths.clear();
        self.paths.extend(self.order.iter().map(|&k| scattered.paths[k as usize]));
        self.media.clear();
        if !scattered.media.is_empty() {
            self.media.extend(self.order.iter().map(|&k| scattered.media[k as usize]));
        }
        self.placements.clear();
        if geometry.is_instanced() {
            self.placements.resize(self.paths.len(), FLATTENED);
        }
        self.bins.clear();
        scattered.clear();
    }

    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Writes packet number `index` in the order of tracing to `rays`.
    #[inline(always)]
    pub fn rays(&self, index: usize, rays: &mut Rays) -> PathRays {
        let mut out = PathRays { valid: Lanes([0; LANES]), pixel: [0; LANES], index: [0; LANES] };
        let first = index * LANES;
        for lane in 0..LANES {
            // Lanes beyond the end repeat the last path and are invalid.
            let path = &self.paths[(first + lane).min(self.paths.len() - 1)];
            for axis in 0..3 {
                rays.origin[axis][lane] = path.origin[axis];
                rays.direction[axis][lane] = path.direction[axis];
            }
            out.pixel[lane] = path.pixel;
            out.index[lane] = path.sample.index();
            out.valid.0[lane] = -i32::from(first + lane < self.paths.len());
        }
        rays.near = [0.0; LANES];
        rays.far = [f32::INFINITY; LANES];
        out
    }

    /// Records what packet number `index` has hit; packets are recorded in order. Rays that have hit nothing bring light if
    /// `misses_count`.
    #[inline(always)]
    pub fn record(&mut self, index: usize, packet: &RayHits, geometry: &Geometry, misses_count: bool) {
        let hits = &packet.hits;
        let first = index * LANES;
        for lane in 0..LANES.min(self.paths.len() - first) {
            let k = first + lane;
            let (far, triangle) = (packet.rays.far[lane], hits.triangle[lane]);
            self.paths[k].hit = PathHit { far, u: hits.u[lane], v: hits.v[lane], triangle };
            let mut bin = if misses_count { 0 } else { NOTHING };
            if triangle != NO_TRIANGLE {
                if geometry.is_instanced() {
                    self.placements[k] = hits.instance[lane];
                }
                bin = 1 + geometry.instance_group(packet.hit(lane), BINS as u32 - 1);
            }
            self.bins.push(bin);
        }
    }

    /// Sorts the rays that bring something by what they have hit, to be shaded. Returns their number.
    #[inline(always)]
    pub fn sort_to_shade(&mut self) -> usize {
        counting_sort(&self.bins, BINS, &mut self.starts, &mut self.order);
        self.order.len()
    }

    /// Packet number `index` in an order; writes its rays and their hits to `packet`.
    #[inline(always)]
    pub fn packet(&self, index: usize, order: Order, packet: &mut RayHits) -> PathPacket {
        let mut out = PathPacket {
            valid: Lanes([0; LANES]),
            bsdf_pdf: [0.0; LANES],
            pixel: [0; LANES],
            throughput: [[0.0; LANES]; 3],
            index: [0; LANES],
            may_scatter: [false; LANES],
            media: [MediaStack::AIR; LANES],
        };
        let first = index * LANES;
        let count = if order == Order::Shaded { self.order.len() } else { self.paths.len() };
        for lane in 0..LANES {
            // Lanes beyond the end repeat the last path, are invalid and have no hit.
            let is_valid = first + lane < count;
            let place = (first + lane).min(count - 1);
            let k = if order == Order::Shaded { self.order[place] as usize } else { place };
            let path = &self.paths[k];
            for axis in 0..3 {
                packet.rays.origin[axis][lane] = path.origin[axis];
                packet.rays.direction[axis][lane] = path.direction[axis];
                out.throughput[axis][lane] = path.throughput[axis];
            }
            packet.rays.far[lane] = path.hit.far;
            packet.hits.u[lane] = path.hit.u;
            packet.hits.v[lane] = path.hit.v;
            packet.hits.triangle[lane] = if is_valid { path.hit.triangle } else { NO_TRIANGLE };
            packet.hits.instance[lane] = self.placements.get(k).copied().unwrap_or(FLATTENED);
            out.bsdf_pdf[lane] = path.bsdf_pdf;
            out.pixel[lane] = path.pixel;
            out.index[lane] = path.sample.index();
            out.may_scatter[lane] = path.sample.may_scatter();
            out.media[lane] = self.media.get(k).copied().unwrap_or_default();
            out.valid.0[lane] = -i32::from(is_valid);
        }
        out
    }
}

/// Sets `order` to the numbers of the keys below `values`, sorted by key: a counting sort, which is stable and linear in the
/// number of keys. Other keys are left out. `starts` is scratch.
#[inline(always)]
fn counting_sort(keys: &[u32], values: usize, starts: &mut Vec<u32>, order: &mut Vec<u32>) {
    starts.clear();
    starts.resize(values + 1, 0);
    for &key in keys {
        if (key as usize) < values {
            starts[key as usize + 1] += 1;
        }
    }
    let mut sum = 0;
    for start in &mut *starts {
        sum += *start;
        *start = sum;
    }
    order.clear();
    order.resize(sum as usize, 0);
    for (k, &key) in keys.iter().enumerate() {
        if (key as usize) < values {
            let slot = &mut starts[key as usize];
            order[*slot as usize] = k as u32;
            *slot += 1;
        }
    }
}

/// The cell of a unit direction: octahedral map, cells numbered along a Z-order curve, so that neighbors in the order
/// are neighbors on the sphere.
#[inline(always)]
pub(crate) fn cell(d: [f32; 3]) -> u32 {
    let inverse = 1.0 / (d[0].abs() + d[1].abs() + d[2].abs());
    let (x, y) = (d[0] * inverse, d[1] * inverse);
    let (x, y) = if d[2] >= 0.0 { (x, y) } else { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) };
    let index = |t: f32| (((t + 1.0) * 0.5 * CELLS as f32) as u32).min(CELLS as u32 - 1);
    spread(index(x)) | spread(index(y)) << 1
}

/// The bits of `x` (up to 8), interleaved with zeros.
#[inline(always)]
fn spread(x: u32) -> u32 {
    let x = (x | x << 4) & 0x0F0F;
    let x = (x | x << 2) & 0x3333;
    (x | x << 1) & 0x5555
}

/// The number of neighboring lanes (of 15) on different triangles above which shadow rays are traced as incoherent (tuned
/// for speed).
const INCOHERENT_CHANGES: u32 = 11;

/// The coherence of shadow rays. Rays from many different triangles (grass, leaves) traverse different parts of the
/// tree, even towards one light; tracing them as a packet is then slower than one ray at a time.
#[inline(always)]
pub(super) fn coherence(packet: &RayHits) -> Coherence {
    if changes(packet) > INCOHERENT_CHANGES { Coherence::Incoherent } else { Coherence::Coherent }
}

/// The number of neighboring lanes, of 15, that have hit different triangles.
#[inline(always)]
pub(super) fn changes(packet: &RayHits) -> u32 {
    let (triangle, instance) = (&packet.hits.triangle, &packet.hits.instance);
    let mut changes = 0;
    for lane in 1..LANES {
        changes += u32::from((triangle[lane] != triangle[lane - 1]) | (instance[lane] != instance[lane - 1]));
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::tests::{instanced_soup, soup};
    use crate::material::media::MediumId;
    use crate::sampling;
    use crate::simd::at;

    #[test]
    fn the_order_is_a_permutation_of_neighbors() {
        let (mut scattered, mut paths) = (Scattered::default(), Paths::default());
        for index in 0..256 {
            let sequences = std::array::from_fn(|lane| index * 16 + lane as u32);
            let directions = sampling::cosine_hemisphere(&sampling::points(&sequences, 0, sampling::Purpose::PIXEL));
            for lane in 0..LANES {
                let direction = at(&directions, lane);
                let pixel = index * 16 + lane as u32;
                let (origin, throughput) = ([0.0; 3], [1.0; 3]);
                let (sample, hit) = (SampleState::new(0, true), PathHit::NONE);
                let path = Path { origin, bsdf_pdf: 1.0, direction, pixel, throughput, sample, hit };
                scattered.push(path, cell(direction), None);
            }
        }
        let unsorted = scattered.paths.clone();
        paths.sort_to_trace(&mut scattered, &soup(4, 1));
        assert!(scattered.is_empty());
        let mut pixels: Vec<u32> = paths.paths.iter().map(|path| path.pixel).collect();
        pixels.sort_unstable();
        assert!(pixels.into_iter().eq(0..4096), "every ray once");
        let step = |paths: &[Path]| {
            let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let steps = paths.windows(2).map(|w| 1.0 - dot(w[0].direction, w[1].direction));
            steps.sum::<f32>() / paths.len() as f32
        };
        assert!(step(&paths.paths) < 0.05 * step(&unsorted), "{} {}", step(&paths.paths), step(&unsorted));
    }

    fn medium(pixel: u32) -> MediaStack {
        MediaStack::AIR.entered(pixel as MediumId)
    }

    /// Rays along two axes that hit triangle `hit(k)` of `geometry`, if any; every ray has the pixel of its number.
    fn recorded(
        geometry: &Geometry,
        count: u32,
        misses_count: bool,
        hit: impl Fn(u32) -> Option<crate::geometry::Hit>,
    ) -> Paths {
        let (mut scattered, mut paths) = (Scattered::default(), Paths::default());
        for pixel in 0..count {
            let direction = if pixel % 3 == 0 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
            let (sample, throughput) = (SampleState::new(pixel, true), [1.0; 3]);
            let path =
                Path { origin: [0.0; 3], bsdf_pdf: 1.0, direction, pixel, throughput, sample, hit: PathHit::NONE };
            scattered.push(path, cell(direction), Some(medium(pixel)));
        }
        paths.sort_to_trace(&mut scattered, geometry);
        for k in 0..paths.len().div_ceil(LANES) {
            let mut packet = RayHits::EMPTY;
            let rays = paths.rays(k, &mut packet.rays);
            for lane in (0..LANES).filter(|&lane| rays.valid.0[lane] != 0) {
                if let Some(found) = hit(rays.pixel[lane]) {
                    packet.rays.far[lane] = 1.0;
                    packet.hits.triangle[lane] = found.triangle;
                    packet.hits.instance[lane] = found.placement;
                    packet.hits.u[lane] = rays.pixel[lane] as f32;
                }
            }
            paths.record(k, &packet, geometry, misses_count);
        }
        paths
    }

    /// All rays that bring something are shaded once, with their own hits, in the order of instances; those of one instance
    /// in the order in which they were traced.
    #[test]
    fn hits_are_shaded_by_instance_and_misses_first() {
        for geometry in [soup(40, 3), instanced_soup(40, 3)] {
            let triangles = geometry.triangles().len() as u32;
            let placements = geometry.placements().len() as u32;
            let hit = |k: u32| {
                let placement = if placements > 0 { k % placements } else { FLATTENED };
                (k % 4 != 1).then_some(crate::geometry::Hit { triangle: k * 7 % triangles, placement })
            };
            for misses_count in [true, false] {
                let mut paths = recorded(&geometry, 1003, misses_count, hit);
                let shaded = paths.sort_to_shade();
                let mut seen = Vec::new();
                for k in 0..shaded.div_ceil(LANES) {
                    let mut packet = RayHits::EMPTY;
                    let found = paths.packet(k, Order::Shaded, &mut packet);
                    for lane in 0..LANES {
                        let pixel = found.pixel[lane];
                        if found.valid.0[lane] == 0 {
                            assert_eq!(packet.hits.triangle[lane], NO_TRIANGLE);
                            continue;
                        }
                        assert_eq!((found.index[lane], found.media[lane]), (pixel, medium(pixel)));
                        let bin = hit(pixel).map(|hit| {
                            assert_eq!(packet.hit(lane), hit);
                            assert!(packet.hits.u[lane] == pixel as f32 && packet.rays.far[lane] == 1.0);
                            geometry.instance_index(hit)
                        });
                        seen.push((bin, cell(at(&packet.rays.direction, lane)), pixel));
                    }
                }
                assert!(seen.is_sorted(), "by instance, direction, pixel");
                // Before they are sorted, all are in the order in which they were traced.
                let mut packet = RayHits::EMPTY;
                let traced = (0..1003_usize.div_ceil(LANES)).flat_map(|k| {
                    let found = paths.packet(k, Order::Traced, &mut packet);
                    (0..LANES).filter(move |&lane| found.valid.0[lane] != 0).map(move |lane| found.pixel[lane])
                });
                assert!(traced.eq(paths.paths.iter().map(|path| path.pixel)));
                let expected = (0..1003).filter(|&k| misses_count || hit(k).is_some()).count();
                assert_eq!((seen.len(), shaded), (expected, expected), "every ray once");
            }
        }
    }
}
