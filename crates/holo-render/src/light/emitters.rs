//! Triangles that glow as lights: one is chosen by its power, then a point on it uniformly by area.
//!
//! A triangle weighs its area times the luminance of its material's mean emission, twice where both sides glow. So the
//! density per area is one number for all triangles of a material, and what a ray meets by chance is looked up by its
//! part. The texture of the emission counts with its mean over the whole image: the proportions decide about noise only,
//! as long as nothing that glows weighs 0.
//!
//! Why twice: a point of the scene sees one side of a triangle, and of a one-sided triangle it sees the dark one half of
//! the time. This is power, too.
//!
//! Sources: Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., 12.6 (power) and 6.5 (area to solid angle);
//! Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
//!
//! Accuracy: the shares of the triangles are multiples of 2^-40 (sums in f64). The 24 bits of the number that chooses
//! would leave each of a million triangles 17 steps; the low 8 bits of both coordinates of the point, which shift it by
//! less than 2^-16 of the triangle, serve as 16 further ones. A triangle with less than 2^-41 of all power may never be
//! chosen.

#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::geometry::{Geometry, Hit};
use crate::sampling::Points;
use crate::simd::{LANES, at};
use holo_core::color::srgb8_to_linear_table;
use holo_scene::{Material, Texture};

/// All power, in steps.
const STEPS: u64 = 1 << 40;

/// The triangles of a scene that glow.
pub(crate) struct Emitters {
    glowing: Vec<Glowing>,
    /// Where the share of every one of them begins on the scale of steps, in the order of the scene: neighbours stay
    /// neighbours, so that well-spread numbers choose well-spread triangles.
    starts: Vec<u64>,
    /// Density per area, seen from the front and from the back, of every part of the geometry.
    densities: Vec<[f32; 2]>,
}

/// A triangle, ready to be drawn from: one line of the cache.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Glowing {
    corner: [f32; 3],
    /// From the first corner to the others.
    edges: [[f32; 3]; 2],
    /// Unit normal of the front.
    normal: [f32; 3],
    /// Of its part.
    densities: [f32; 2],
    triangle: u32,
}

/// Sixteen points on emitters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmitterSample {
    pub triangle: [u32; LANES],
    /// Weight of the second corner: the point is (1 - u - v) a + u b + v c, as in a hit.
    pub u: [f32; LANES],
    /// Weight of the third corner.
    pub v: [f32; LANES],
    /// From where it is looked at to the point: not of unit length.
    pub to_light: [[f32; LANES]; 3],
    /// The density of its direction, per steradian; 0 where the triangle is seen edge-on or from its dark side.
    pub pdf: [f32; LANES],
}

impl Emitters {
    /// The emitters of a valid scene; `None` if nothing glows.
    pub fn build(geometry: &Geometry, materials: &[Material], textures: &[Texture]) -> Option<Self> {
        let mut means = vec![None; textures.len()];
        let strengths: Vec<f64> = materials.iter().map(|material| strength(material, textures, &mut means)).collect();
        let mut glowing = Vec::new();
        let mut sums = Vec::new();
        let mut densities = Vec::new();
        let mut total = 0.0;
        for triangle in 0..geometry.flattened_count() {
            let part = geometry.part_index(Hit::flattened(triangle));
            let material = geometry.part(part).material as usize;
            if densities.len() <= part as usize {
                densities.resize(part as usize + 1, [0.0; 2]);
            }
            if strengths[material] == 0.0 {
                continue;
            }
            // The corners as the engines see them, in f64: on what a ray can hit the density is exact.
            let [a, b, c] = geometry.corners(Hit::flattened(triangle)).map(|p| Vec3::from(p).as_dvec3());
            let normal = (b - a).cross(c - a);
            let area = 0.5 * normal.length();
            let both = materials[material].double_sided;
            let weight = area * strengths[material] * if both { 2.0 } else { 1.0 };
            // A triangle without area.
            if weight == 0.0 {
                continue;
            }
            total += weight;
            sums.push(total);
            glowing.push(Glowing {
                corner: a.as_vec3().to_array(),
                edges: [(b - a).as_vec3().to_array(), (c - a).as_vec3().to_array()],
                normal: (normal / (2.0 * area)).as_vec3().to_array(),
                densities: [0.0; 2],
                triangle: triangle as u32,
            });
        }
        if glowing.is_empty() || !total.is_finite() {
            return None;
        }
        for (part, density) in densities.iter_mut().enumerate() {
            let material = geometry.part(part as u32).material as usize;
            let both = materials[material].double_sided;
            let front = strengths[material] / total * if both { 2.0 } else { 1.0 };
            // A light of less than 1e-38 m^2 must not become an infinite density.
            let front = front.min(f64::from(f32::MAX)) as f32;
            *density = [front, if both { front } else { 0.0 }];
        }
        for emitter in &mut glowing {
            emitter.densities = densities[geometry.part_index(Hit::flattened(emitter.triangle as usize)) as usize];
        }
        let mut starts = vec![0];
        starts.extend(sums[..sums.len() - 1].iter().map(|sum| (sum / total * STEPS as f64) as u64));
        Some(Self { glowing, starts, densities })
    }

    /// Draws a point a lane, as seen from `from`: `choice` (0 to 1) picks the triangle, `point` the place on it.
    #[inline(always)]
    pub fn sample(&self, from: &[[f32; LANES]; 3], choice: &[f32; LANES], point: &Points) -> EmitterSample {
        let chosen = self.search(choice, point);
        let mut out = EmitterSample {
            triangle: [0; LANES],
            u: [0.0; LANES],
            v: [0.0; LANES],
            to_light: [[0.0; LANES]; 3],
            pdf: [0.0; LANES],
        };
        let mut corner = [[0.0; LANES]; 3];
        let mut edges = [[[0.0; LANES]; 3]; 2];
        let mut normal = [[0.0; LANES]; 3];
        let mut densities = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let emitter = &self.glowing[chosen[lane] as usize];
            for axis in 0..3 {
                corner[axis][lane] = emitter.corner[axis];
                edges[0][axis][lane] = emitter.edges[0][axis];
                edges[1][axis][lane] = emitter.edges[1][axis];
                normal[axis][lane] = emitter.normal[axis];
            }
            densities[0][lane] = emitter.densities[0];
            densities[1][lane] = emitter.densities[1];
            out.triangle[lane] = emitter.triangle;
        }
        for lane in 0..LANES {
            // The square is folded along its diagonal by shifting, not by mirroring: what was near stays near.
            let (x, y) = (point[0][lane], point[1][lane]);
            let above = y > x;
            let half = 0.5 * if above { x } else { y };
            out.u[lane] = if above { half } else { x - half };
            out.v[lane] = if above { y - half } else { half };
        }
        for axis in 0..3 {
            for lane in 0..LANES {
                let along = out.u[lane] * edges[0][axis][lane] + out.v[lane] * edges[1][axis][lane];
                out.to_light[axis][lane] = (corner[axis][lane] - from[axis][lane]) + along;
            }
        }
        for lane in 0..LANES {
            let [x, y, z] = at(&out.to_light, lane);
            let squared = x * x + y * y + z * z;
            let [a, b, c] = at(&normal, lane);
            let cosine = -(a * x + b * y + c * z) / squared.sqrt();
            let density = if cosine > 0.0 { densities[0][lane] } else { densities[1][lane] };
            out.pdf[lane] = per_steradian(density, squared, cosine);
        }
        out
    }

    /// The density, per steradian, with which [`Self::sample`] draws directions that meet an emitter: by the part of the
    /// geometry that it belongs to, the squared distance in m^2, and the cosine between the normal of its front (the
    /// triangle's own, not an interpolated one) and the direction back, below 0 for its back. 0 where nothing glows.
    #[inline(always)]
    pub fn pdf(&self, part: &[u32; LANES], distance_squared: &[f32; LANES], cosine: &[f32; LANES]) -> [f32; LANES] {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            let [front, back] = match self.densities.get(part[lane] as usize) {
                Some(densities) => *densities,
                None => [0.0; 2],
            };
            out[lane] = if cosine[lane] > 0.0 { front } else { back };
        }
        for lane in 0..LANES {
            out[lane] = per_steradian(out[lane], distance_squared[lane], cosine[lane]);
        }
        out
    }

    /// Which emitter each lane takes.
    #[inline(always)]
    fn search(&self, choice: &[f32; LANES], point: &Points) -> [u32; LANES] {
        let mut wanted = [0; LANES];
        for lane in 0..LANES {
            let step = ((choice[lane] * 16_777_216.0) as u32).min(0xFF_FFFF);
            let low_x = (point[0][lane] * 16_777_216.0) as u32 & 0xFF;
            let low_y = (point[1][lane] * 16_777_216.0) as u32 & 0xFF;
            wanted[lane] = u64::from(step) << 16 | u64::from(low_x << 8 | low_y);
        }
        let mut found = [0; LANES];
        let mut size = self.starts.len();
        while size > 1 {
            let half = size / 2;
            for lane in 0..LANES {
                // As a product: a branch would be mispredicted every other time.
                let beyond = self.starts[found[lane] as usize + half] <= wanted[lane];
                found[lane] += half as u32 * u32::from(beyond);
            }
            size -= half;
        }
        found
    }
}

/// A density per area of an emitter as one per solid angle at `squared` m^2 from it.
#[inline(always)]
fn per_steradian(density: f32, squared: f32, cosine: f32) -> f32 {
    let pdf = density * squared / cosine.abs();
    // Edge-on, and from a point of the emitter itself, where the cosine is no number.
    if pdf < f32::INFINITY { pdf } else { 0.0 }
}

/// Luminance of the mean emission of one side.
fn strength(material: &Material, textures: &[Texture], means: &mut [Option<[f64; 3]>]) -> f64 {
    if material.emission == [0.0; 3] {
        return 0.0;
    }
    let texel = match material.emission_texture {
        Some(used) => *means[used.texture].get_or_insert_with(|| mean_texel(&textures[used.texture])),
        None => [1.0; 3],
    };
    let emission: [f64; 3] = std::array::from_fn(|c| f64::from(material.emission[c]) * texel[c]);
    0.2126 * emission[0] + 0.7152 * emission[1] + 0.0722 * emission[2]
}

/// The mean of an sRGB texture in linear light.
fn mean_texel(texture: &Texture) -> [f64; 3] {
    let table = srgb8_to_linear_table();
    let mut sum = [0.0; 3];
    for texel in &texture.texels {
        for c in 0..3 {
            sum[c] += f64::from(table[texel[c] as usize]);
        }
    }
    sum.map(|x| x / texture.texels.len() as f64)
}
