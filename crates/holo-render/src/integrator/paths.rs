//! The scattered rays of one tile, sorted by direction.
//!
//! Scattered rays are incoherent in pixel order. But the pixels of one tile start close together, so the rays are
//! collected, sorted by direction and traced in packets of similar directions. The order of the rays of a pixel depends
//! only on those rays.

use crate::accel::Rays;
use crate::material::media::MediaStack;
use crate::simd::{LANES, Lanes};

/// The number of cells per side of the square octahedral map by which directions are sorted.
const CELLS: usize = 64;

/// A scattered ray with the state of its path.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
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

/// The scattered rays of one tile: at most one per sample.
#[derive(Default)]
pub(crate) struct Paths {
    paths: Vec<Path>,
    /// The media around each path; empty if the scene has no bodies of glass.
    media: Vec<MediaStack>,
    cells: Vec<u32>,
    order: Vec<u32>,
    starts: Vec<u32>,
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
    /// Adds a ray whose direction lies in `cell` (see [`cell`]); with its media if the scene has any.
    #[inline(always)]
    pub fn push(&mut self, path: Path, cell: u32, media: Option<MediaStack>) {
        self.paths.push(path);
        self.media.extend(media);
        self.cells.push(cell);
    }

    pub fn len(&self) -> usize {
        self.paths.len()
    }

    pub fn clear(&mut self) {
        self.paths.clear();
        self.media.clear();
        self.cells.clear();
    }

    /// Packet number `index` of the sorted rays; writes the rays themselves to `rays`.
    #[inline(always)]
    pub fn packet(&self, index: usize, rays: &mut Rays) -> PathPacket {
        let mut packet = PathPacket {
            valid: Lanes([0; LANES]),
            bsdf_pdf: [0.0; LANES],
            pixel: [0; LANES],
            throughput: [[0.0; LANES]; 3],
            index: [0; LANES],
            may_scatter: [false; LANES],
            media: [MediaStack::AIR; LANES],
        };
        let first = index * LANES;
        for lane in 0..LANES {
            // Lanes beyond the end repeat the last path and are invalid.
            let k = (first + lane).min(self.order.len() - 1);
            let path = &self.paths[self.order[k] as usize];
            for axis in 0..3 {
                rays.origin[axis][lane] = path.origin[axis];
                rays.direction[axis][lane] = path.direction[axis];
                packet.throughput[axis][lane] = path.throughput[axis];
            }
            packet.bsdf_pdf[lane] = path.bsdf_pdf;
            packet.pixel[lane] = path.pixel;
            packet.index[lane] = path.sample.index();
            packet.may_scatter[lane] = path.sample.may_scatter();
            packet.media[lane] = self.media.get(self.order[k] as usize).copied().unwrap_or_default();
            packet.valid.0[lane] = -i32::from(first + lane < self.order.len());
        }
        rays.near = [0.0; LANES];
        rays.far = [f32::INFINITY; LANES];
        packet
    }

    /// Sorts the rays by direction: a counting sort, stable and linear in the number of rays.
    #[inline(always)]
    pub fn sort_by_direction(&mut self) {
        self.starts.clear();
        self.starts.resize(CELLS * CELLS + 1, 0);
        for &c in &self.cells {
            self.starts[c as usize + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.order.clear();
        self.order.resize(self.cells.len(), 0);
        for (k, &c) in self.cells.iter().enumerate() {
            let slot = &mut self.starts[c as usize];
            self.order[*slot as usize] = k as u32;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling;

    #[test]
    fn the_order_is_a_permutation_of_neighbors() {
        let mut paths = Paths::default();
        for index in 0..256 {
            let sequences = std::array::from_fn(|lane| index * 16 + lane as u32);
            let directions = sampling::cosine_hemisphere(&sampling::points(&sequences, 0, sampling::Purpose::PIXEL));
            for lane in 0..LANES {
                let direction = crate::simd::at(&directions, lane);
                let pixel = index * 16 + lane as u32;
                let (origin, throughput) = ([0.0; 3], [1.0; 3]);
                let path =
                    Path { origin, bsdf_pdf: 1.0, direction, pixel, throughput, sample: SampleState::new(0, true) };
                paths.push(path, cell(direction), None);
            }
        }
        paths.sort_by_direction();
        let mut sorted = paths.order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(k, &o)| o == k as u32), "every ray once");
        let step = |order: &[u32]| {
            let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let d = |k: u32| paths.paths[k as usize].direction;
            order.windows(2).map(|w| 1.0 - dot(d(w[0]), d(w[1]))).sum::<f32>() / order.len() as f32
        };
        let unsorted: Vec<u32> = (0..paths.order.len() as u32).collect();
        assert!(step(&paths.order) < 0.05 * step(&unsorted), "{} {}", step(&paths.order), step(&unsorted));
    }
}
