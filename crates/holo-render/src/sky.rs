//! A constant sky: background for rays that leave the scene, and a light that the scene may hide.
//!
//! Every surface point tests one direction of the sky per sample, drawn with the cosine of its normal. Taken pixel by
//! pixel these rays run all over the place; but the pixels of one tile start close together, so they are collected,
//! ordered by direction and traced in packets of neighbouring directions. The order changes nothing in the result.

use crate::accel::{Engine, LANES, Lanes, Rays};
use crate::sampling;

/// Directions are ordered by their cell in a square octahedral map of this many cells a side.
const CELLS: usize = 64;

/// Sky rays of one tile, one per pixel at most.
#[derive(Default)]
pub(crate) struct SkyRays {
    origins: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
    /// What the pixel gains if the sky is seen.
    gains: Vec<[f32; 3]>,
    /// Which pixel of the tile.
    pixels: Vec<u32>,
    order: Vec<u32>,
}

impl SkyRays {
    /// Asks for the sky over a surface point, with the random numbers `u` and `v`.
    #[inline(always)]
    pub fn push(&mut self, pixel: u32, origin: [f32; 3], normals: [[f32; 3]; 2], gain: [f32; 3], [u, v]: [f32; 2]) {
        let [geometric, shading] = normals;
        let local = sampling::cosine_hemisphere(u, v);
        let [x, y] = sampling::frame(shading);
        let direction: [f32; 3] = std::array::from_fn(|k| x[k] * local[0] + y[k] * local[1] + shading[k] * local[2]);
        // Under the triangle itself there is no sky, whatever the interpolated normal says.
        if crate::light::dot(direction, geometric) <= 0.0 {
            return;
        }
        self.origins.push(origin);
        self.directions.push(direction);
        self.gains.push(gain);
        self.pixels.push(pixel);
    }

    /// Traces what was collected, adds the gains of the pixels that see the sky, and forgets the rays.
    /// Returns how many rays were traced.
    #[inline(always)]
    pub fn flush(&mut self, engine: &dyn Engine, mut add: impl FnMut(u32, [f32; 3])) -> u64 {
        self.sort_by_direction();
        let mut rays = Rays::EMPTY;
        for chunk in self.order.chunks(LANES) {
            let mut valid = Lanes([0; LANES]);
            for (lane, &k) in chunk.iter().enumerate() {
                let k = k as usize;
                for axis in 0..3 {
                    rays.origin[axis][lane] = self.origins[k][axis];
                    rays.direction[axis][lane] = self.directions[k][axis];
                }
                valid.0[lane] = -1;
            }
            rays.near = [0.0; LANES];
            rays.far = [f32::INFINITY; LANES];
            engine.occluded(&valid, &mut rays);
            for (lane, &k) in chunk.iter().enumerate() {
                if rays.far[lane] > 0.0 {
                    add(self.pixels[k as usize], self.gains[k as usize]);
                }
            }
        }
        let count = self.pixels.len() as u64;
        self.origins.clear();
        self.directions.clear();
        self.gains.clear();
        self.pixels.clear();
        count
    }

    /// A counting sort: stable, and linear in the number of rays.
    #[inline(always)]
    fn sort_by_direction(&mut self) {
        let mut starts = vec![0u32; CELLS * CELLS + 1];
        let cells: Vec<u32> = self.directions.iter().map(|&d| cell(d)).collect();
        for &c in &cells {
            starts[c as usize + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        self.order.clear();
        self.order.resize(cells.len(), 0);
        for (k, &c) in cells.iter().enumerate() {
            let place = &mut starts[c as usize];
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
        for index in 0..4096 {
            let [a, b, u, v] = sampling::sample(1, index);
            let normal = sampling::cosine_hemisphere(a, b);
            rays.push(index, [0.0; 3], [normal, normal], [1.0; 3], [u, v]);
        }
        rays.sort_by_direction();
        let mut sorted = rays.order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(k, &o)| o == k as u32), "every ray once");
        let step = |order: &[u32]| {
            let d = |k: u32| rays.directions[k as usize];
            order.windows(2).map(|w| 1.0 - crate::light::dot(d(w[0]), d(w[1]))).sum::<f32>() / order.len() as f32
        };
        let unsorted: Vec<u32> = (0..rays.order.len() as u32).collect();
        assert!(step(&rays.order) < 0.05 * step(&unsorted), "{} {}", step(&rays.order), step(&unsorted));
    }
}
