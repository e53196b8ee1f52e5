//! Rays that surfaces scattered, of one tile, waiting to be traced together.
//!
//! Taken pixel by pixel scattered rays run all over the place; but the pixels of one tile start close together, so the
//! rays are collected, ordered by direction and traced in packets of neighbouring directions. The order of a
//! pixel's own rays depends on nothing but those rays.

use crate::accel::Rays;
use crate::simd::{LANES, Lanes};

/// Directions are ordered by their cell in a square octahedral map of this many cells a side.
const CELLS: usize = 64;

/// A ray that carries what its pixel gains per radiance that it finds.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(crate) struct Path {
    pub origin: [f32; 3],
    /// Density with which the direction was drawn, per solid angle; infinite where it was the only one.
    pub density: f32,
    pub direction: [f32; 3],
    /// Which pixel of the tile.
    pub pixel: u32,
    pub throughput: [f32; 3],
    /// Which sample of the pixel.
    pub sample: Sample,
}

/// Number of a sample, and whether the surface that the ray finds may scatter light on to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sample(u32);

impl Sample {
    #[inline(always)]
    pub fn new(number: u32, goes_on: bool) -> Self {
        Self(number << 1 | u32::from(goes_on))
    }

    #[inline(always)]
    pub fn number(self) -> u32 {
        self.0 >> 1
    }

    #[inline(always)]
    pub fn goes_on(self) -> bool {
        self.0 & 1 != 0
    }
}

/// Scattered rays of one tile, one per sample at most.
#[derive(Default)]
pub(crate) struct Paths {
    paths: Vec<Path>,
    cells: Vec<u32>,
    order: Vec<u32>,
    starts: Vec<u32>,
}

/// Up to sixteen paths side by side.
pub(crate) struct PathPacket {
    pub valid: Lanes<i32>,
    pub density: [f32; LANES],
    pub pixel: [u32; LANES],
    pub throughput: [[f32; LANES]; 3],
    pub sample: [u32; LANES],
    pub goes_on: [bool; LANES],
}

impl Paths {
    /// Adds a ray whose direction lies in `cell` (see [`cell`]).
    #[inline(always)]
    pub fn push(&mut self, path: Path, cell: u32) {
        self.paths.push(path);
        self.cells.push(cell);
    }

    pub fn len(&self) -> usize {
        self.paths.len()
    }

    pub fn clear(&mut self) {
        self.paths.clear();
        self.cells.clear();
    }

    /// The packet number `index` of the sorted rays; the rays themselves go to `rays`.
    #[inline(always)]
    pub fn packet(&self, index: usize, rays: &mut Rays) -> PathPacket {
        let mut packet = PathPacket {
            valid: Lanes([0; LANES]),
            density: [0.0; LANES],
            pixel: [0; LANES],
            throughput: [[0.0; LANES]; 3],
            sample: [0; LANES],
            goes_on: [false; LANES],
        };
        let first = index * LANES;
        for lane in 0..LANES {
            // Lanes beyond the end repeat the last path and are not valid.
            let k = (first + lane).min(self.order.len() - 1);
            let path = &self.paths[self.order[k] as usize];
            for axis in 0..3 {
                rays.origin[axis][lane] = path.origin[axis];
                rays.direction[axis][lane] = path.direction[axis];
                packet.throughput[axis][lane] = path.throughput[axis];
            }
            packet.density[lane] = path.density;
            packet.pixel[lane] = path.pixel;
            packet.sample[lane] = path.sample.number();
            packet.goes_on[lane] = path.sample.goes_on();
            packet.valid.0[lane] = -i32::from(first + lane < self.order.len());
        }
        rays.near = [0.0; LANES];
        rays.far = [f32::INFINITY; LANES];
        packet
    }

    /// A counting sort: stable, and linear in the number of rays.
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
            let place = &mut self.starts[c as usize];
            self.order[*place as usize] = k as u32;
            *place += 1;
        }
    }
}

/// The cell of a unit direction: octahedral map, cells counted along a Z curve so that neighbours in the order are
/// neighbours on the sphere.
#[inline(always)]
pub(crate) fn cell(d: [f32; 3]) -> u32 {
    let inverse = 1.0 / (d[0].abs() + d[1].abs() + d[2].abs());
    let (x, y) = (d[0] * inverse, d[1] * inverse);
    let (x, y) = if d[2] >= 0.0 { (x, y) } else { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) };
    let index = |t: f32| (((t + 1.0) * 0.5 * CELLS as f32) as u32).min(CELLS as u32 - 1);
    spread(index(x)) | spread(index(y)) << 1
}

/// The bits of `x` (up to 8) with gaps between them.
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
    fn the_order_is_a_permutation_of_neighbours() {
        let mut paths = Paths::default();
        for index in 0..256 {
            let sequences = std::array::from_fn(|lane| index * 16 + lane as u32);
            let directions = sampling::cosine_hemisphere(&sampling::points(&sequences, 0, sampling::Purpose::PIXEL));
            for lane in 0..LANES {
                let direction = crate::simd::at(&directions, lane);
                let pixel = index * 16 + lane as u32;
                let (origin, throughput) = ([0.0; 3], [1.0; 3]);
                let path = Path { origin, density: 1.0, direction, pixel, throughput, sample: Sample::new(0, true) };
                paths.push(path, cell(direction));
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
