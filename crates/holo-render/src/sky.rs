//! A constant sky: background for rays that leave the scene, and a light that the scene may hide.
//!
//! Every surface point tests one direction of the sky per sample, drawn with the cosine of its normal. Taken pixel by
//! pixel these rays run all over the place; but the pixels of one tile start close together, so they are collected,
//! ordered by direction and traced in packets of neighbouring directions. The order changes nothing in the result.

use crate::accel::{Coherence, Engine, LANES, Lanes, Rays, at};
use crate::sampling;
use crate::surface::Surfaces;

/// Directions are ordered by their cell in a square octahedral map of this many cells a side.
const CELLS: usize = 64;

/// Sky rays of one tile, one per pixel at most.
#[derive(Default)]
pub(crate) struct SkyRays {
    rays: Vec<SkyRay>,
    cells: Vec<u32>,
    order: Vec<u32>,
    starts: Vec<u32>,
}

/// A ray towards the sky and what the pixel gains if it gets there.
#[derive(Clone, Copy)]
struct SkyRay {
    origin: [f32; 3],
    direction: [f32; 3],
    gain: [f32; 3],
    /// Which pixel of the tile.
    pixel: u32,
}

impl SkyRays {
    /// Asks for the sky over the surfaces of the valid lanes; the pixel of lane k is `first_pixel` + k.
    #[inline(always)]
    pub fn push(
        &mut self,
        first_pixel: u32,
        surfaces: &Surfaces,
        valid: &Lanes<i32>,
        sky: [f32; 3],
        numbers: &sampling::Points,
    ) {
        let local = sampling::cosine_hemisphere(numbers);
        let (geometric, shading) = (&surfaces.geometric_normal, &surfaces.shading_normal);
        let mut direction = [[0.0; LANES]; 3];
        let mut cosine = [0.0; LANES];
        for lane in 0..LANES {
            let normal = at(shading, lane);
            let [x, y] = sampling::frame(normal);
            for axis in 0..3 {
                let d = x[axis] * local[0][lane] + y[axis] * local[1][lane] + normal[axis] * local[2][lane];
                direction[axis][lane] = d;
                cosine[lane] += d * geometric[axis][lane];
            }
        }
        let mut gain = [[0.0; LANES]; 3];
        for c in 0..3 {
            for lane in 0..LANES {
                gain[c][lane] = surfaces.albedo[c][lane] * sky[c];
            }
        }
        let mut cells = [0; LANES];
        for lane in 0..LANES {
            cells[lane] = cell(at(&direction, lane));
        }
        for lane in 0..LANES {
            // Under the triangle itself there is no sky, whatever the interpolated normal says.
            if surfaces.hit[lane] && valid.0[lane] != 0 && cosine[lane] > 0.0 {
                self.rays.push(SkyRay {
                    origin: at(&surfaces.start, lane),
                    direction: at(&direction, lane),
                    gain: at(&gain, lane),
                    pixel: first_pixel + lane as u32,
                });
                self.cells.push(cells[lane]);
            }
        }
    }

    /// Traces what was collected, adds the gains of the pixels that see the sky, and forgets the rays.
    /// Returns how many rays were traced.
    #[inline(always)]
    pub fn flush(&mut self, engine: &dyn Engine, mut add: impl FnMut(u32, [f32; 3])) -> u64 {
        self.sort_by_direction();
        let mut packet = Rays::EMPTY;
        for chunk in self.order.chunks(LANES) {
            let mut valid = Lanes([0; LANES]);
            for (lane, &k) in chunk.iter().enumerate() {
                let ray = &self.rays[k as usize];
                for axis in 0..3 {
                    packet.origin[axis][lane] = ray.origin[axis];
                    packet.direction[axis][lane] = ray.direction[axis];
                }
                valid.0[lane] = -1;
            }
            packet.near = [0.0; LANES];
            packet.far = [f32::INFINITY; LANES];
            // Neighbours in direction still start all over the tile.
            engine.occluded(&valid, &mut packet, Coherence::Incoherent);
            for (lane, &k) in chunk.iter().enumerate() {
                if packet.far[lane] > 0.0 {
                    let ray = &self.rays[k as usize];
                    add(ray.pixel, ray.gain);
                }
            }
        }
        let count = self.rays.len() as u64;
        self.rays.clear();
        self.cells.clear();
        count
    }

    /// A counting sort: stable, and linear in the number of rays.
    #[inline(always)]
    fn sort_by_direction(&mut self) {
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
fn cell(d: [f32; 3]) -> u32 {
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

    #[test]
    fn the_order_is_a_permutation_of_neighbours() {
        let mut rays = SkyRays::default();
        let up = [[0.0; LANES], [0.6; LANES], [0.8; LANES]];
        let surfaces = Surfaces {
            hit: [true; LANES],
            start: [[0.0; LANES]; 3],
            geometric_normal: up,
            shading_normal: up,
            albedo: [[1.0; LANES]; 3],
        };
        for index in 0..256 {
            let numbers =
                sampling::points(&std::array::from_fn(|lane| index * 16 + lane as u32), 0, sampling::Purpose::Sky);
            rays.push(index * 16, &surfaces, &Lanes([-1; LANES]), [1.0; 3], &numbers);
        }
        rays.sort_by_direction();
        let mut sorted = rays.order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(k, &o)| o == k as u32), "every ray once");
        let step = |order: &[u32]| {
            let d = |k: u32| rays.rays[k as usize].direction;
            order.windows(2).map(|w| 1.0 - crate::light::dot(d(w[0]), d(w[1]))).sum::<f32>() / order.len() as f32
        };
        let unsorted: Vec<u32> = (0..rays.order.len() as u32).collect();
        assert!(step(&rays.order) < 0.05 * step(&unsorted), "{} {}", step(&rays.order), step(&unsorted));
    }
}
