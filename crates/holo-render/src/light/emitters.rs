//! Emissive triangles as light sources: a triangle is selected by its power, then a point on it uniformly by area.
//!
//! The weight of a triangle is its area times the luminance of the mean emission of its material, doubled if both sides
//! emit. The pdf per area is therefore the same for all triangles of an instance, and the pdf of a ray that hits an
//! emissive triangle by BSDF sampling is looked up by instance. An emission texture contributes its mean over the whole
//! image. The weights affect only the noise, as long as no emissive triangle has weight 0.
//!
//! Two-sided emission counts twice because a point of the scene faces the dark side of a one-sided triangle half of the
//! time; it is also proportional to power.
//!
//! Sources: Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., 12.6 (power) and 6.5 (area to solid angle);
//! Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
//!
//! # Accuracy
//! The selection probabilities are multiples of 2^-40 (with sums in f64). A random number has only 24 bits, so the low
//! 8 bits of both coordinates of the point, which move it by less than 2^-16 of the triangle, provide 16 more. A
//! triangle with less than 2^-41 of the total power may never be selected.

#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::geometry::{Geometry, Hit};
use crate::sampling::Points;
use crate::simd::{LANES, at};
use holo_core::color::srgb8_to_linear_table;
use holo_scene::{Material, Texture};

/// The total power in steps of the probability.
const STEPS: u64 = 1 << 40;

/// The emissive triangles of a scene.
pub(crate) struct Emitters {
    emissive: Vec<EmissiveTriangle>,
    /// The start of the probability interval of each triangle, in steps. In the order of the scene, so that stratified
    /// numbers select stratified triangles.
    starts: Vec<u64>,
    guide: Guide,
    /// What the materials emit.
    emissions: Vec<MaterialEmission>,
    /// The pdf per area, seen from the front and from the back, of every instance of the geometry.
    area_pdfs: Vec<[f32; 2]>,
}

/// Where to search the triangle of a step: a table of equal intervals of steps (the cutpoint method of Chen and Asau, "On
/// Generating Random Variates from an Empirical Distribution", 1974). Unlike an alias table it keeps the order of the
/// triangles.
struct Guide {
    /// The triangle of the first step of every interval, and the last triangle.
    first: Vec<u32>,
    /// The binary logarithm of the length of an interval.
    shift: u32,
}

impl Guide {
    /// At least twice as many intervals as triangles, as far as [`MAX_INTERVAL_BITS`] allows: then an interval has one or
    /// two triangles, unless their powers differ widely.
    fn new(starts: &[u64]) -> Self {
        let bits = ((2 * starts.len()).next_power_of_two().ilog2()).min(MAX_INTERVAL_BITS);
        let shift = STEPS.ilog2() - bits;
        let triangle_at = |step: u64| starts.partition_point(|&start| start <= step) as u32 - 1;
        let mut first: Vec<u32> = (0..1u64 << bits).map(|interval| triangle_at(interval << shift)).collect();
        first.push(starts.len() as u32 - 1);
        Self { first, shift }
    }
}

/// 4 MB of memory.
const MAX_INTERVAL_BITS: u32 = 20;

/// An emissive triangle, prepared for sampling: one cache line.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct EmissiveTriangle {
    corner: [f32; 3],
    /// From the first corner to the others.
    edges: [[f32; 3]; 2],
    /// Unit normal of the front.
    normal: [f32; 3],
    /// The pdf per area of its instance, front and back.
    area_pdfs: [f32; 2],
    triangle: u32,
    material: u32,
}

/// The emission of a material.
#[derive(Clone, Copy)]
struct MaterialEmission {
    /// Radiance, linear RGB, without a texture.
    radiance: [f32; 3],
    textured: bool,
}

/// Sixteen points on emissive triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmitterSample {
    pub triangle: [u32; LANES],
    /// The barycentric of the second corner: the point is (1 - u - v) a + u b + v c, as in a hit.
    pub u: [f32; LANES],
    /// The barycentric of the third corner.
    pub v: [f32; LANES],
    /// The vector from the shaded point to the light sample, not normalized.
    pub to_light: [[f32; LANES]; 3],
    /// The pdf of its direction, per steradian; 0 if the triangle is seen edge-on or from its dark side.
    pub pdf: [f32; LANES],
    /// The emitted radiance, linear RGB, of materials without a texture.
    pub radiance: [[f32; LANES]; 3],
    /// Whether the emission of any of the triangles has a texture.
    pub any_textured: bool,
}

impl Emitters {
    /// The emissive triangles of a valid scene; `None` if nothing emits.
    pub fn build(geometry: &Geometry, materials: &[Material], textures: &[Texture]) -> Option<Self> {
        let mut means = vec![None; textures.len()];
        let luminances: Vec<f64> =
            materials.iter().map(|material| mean_luminance(material, textures, &mut means)).collect();
        let mut emissive = Vec::new();
        let mut sums = Vec::new();
        let mut area_pdfs = Vec::new();
        let mut total = 0.0;
        for triangle in 0..geometry.flattened_count() {
            let instance = geometry.instance_index(Hit::flattened(triangle));
            let material = geometry.instance(instance).material as usize;
            if area_pdfs.len() <= instance as usize {
                area_pdfs.resize(instance as usize + 1, [0.0; 2]);
            }
            if luminances[material] == 0.0 {
                continue;
            }
            // The corners as the engines have them, in f64, so that the pdf is exact for the triangles that rays hit.
            let [a, b, c] = geometry.corners(Hit::flattened(triangle)).map(|p| Vec3::from(p).as_dvec3());
            let normal = (b - a).cross(c - a);
            let area = 0.5 * normal.length();
            let both = materials[material].double_sided;
            let weight = area * luminances[material] * if both { 2.0 } else { 1.0 };
            // A degenerate triangle.
            if weight == 0.0 {
                continue;
            }
            total += weight;
            sums.push(total);
            emissive.push(EmissiveTriangle {
                corner: a.as_vec3().to_array(),
                edges: [(b - a).as_vec3().to_array(), (c - a).as_vec3().to_array()],
                normal: (normal / (2.0 * area)).as_vec3().to_array(),
                area_pdfs: [0.0; 2],
                triangle: triangle as u32,
                material: material as u32,
            });
        }
        if emissive.is_empty() || !total.is_finite() {
            return None;
        }
        for (instance, area_pdf) in area_pdfs.iter_mut().enumerate() {
            let material = geometry.instance(instance as u32).material as usize;
            let both = materials[material].double_sided;
            let front = luminances[material] / total * if both { 2.0 } else { 1.0 };
            // A light of less than 1e-38 m^2 must not have an infinite pdf.
            let front = front.min(f64::from(f32::MAX)) as f32;
            *area_pdf = [front, if both { front } else { 0.0 }];
        }
        for emitter in &mut emissive {
            emitter.area_pdfs = area_pdfs[geometry.instance_index(Hit::flattened(emitter.triangle as usize)) as usize];
        }
        let mut starts = vec![0];
        starts.extend(sums[..sums.len() - 1].iter().map(|sum| (sum / total * STEPS as f64) as u64));
        let guide = Guide::new(&starts);
        let emission = |material: &Material| MaterialEmission {
            // Unlit surfaces are lit by nothing and light nothing.
            radiance: if material.unlit { [0.0; 3] } else { material.emission },
            textured: material.emission_texture.is_some(),
        };
        Some(Self { emissive, starts, guide, emissions: materials.iter().map(emission).collect(), area_pdfs })
    }

    /// Samples one point per lane, as seen from `from`: `choice` (0 to 1) selects the triangle, `point` the point on
    /// it.
    #[inline(always)]
    pub fn sample(&self, from: &[[f32; LANES]; 3], choice: &[f32; LANES], point: &Points) -> EmitterSample {
        let chosen = self.search(choice, point);
        let mut out = EmitterSample {
            triangle: [0; LANES],
            u: [0.0; LANES],
            v: [0.0; LANES],
            to_light: [[0.0; LANES]; 3],
            pdf: [0.0; LANES],
            radiance: [[0.0; LANES]; 3],
            any_textured: false,
        };
        let mut corner = [[0.0; LANES]; 3];
        let mut edges = [[[0.0; LANES]; 3]; 2];
        let mut normal = [[0.0; LANES]; 3];
        let mut area_pdfs = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let emitter = &self.emissive[chosen[lane] as usize];
            for axis in 0..3 {
                corner[axis][lane] = emitter.corner[axis];
                edges[0][axis][lane] = emitter.edges[0][axis];
                edges[1][axis][lane] = emitter.edges[1][axis];
                normal[axis][lane] = emitter.normal[axis];
            }
            area_pdfs[0][lane] = emitter.area_pdfs[0];
            area_pdfs[1][lane] = emitter.area_pdfs[1];
            out.triangle[lane] = emitter.triangle;
            let emission = &self.emissions[emitter.material as usize];
            for c in 0..3 {
                out.radiance[c][lane] = emission.radiance[c];
            }
            out.any_textured |= emission.textured;
        }
        for lane in 0..LANES {
            // The square is folded along its diagonal by shifting, not by mirroring, which preserves stratification.
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
            let area_pdf = if cosine > 0.0 { area_pdfs[0][lane] } else { area_pdfs[1][lane] };
            out.pdf[lane] = solid_angle_pdf(area_pdf, squared, cosine);
        }
        out
    }

    /// The pdf, per steradian, with which [`Self::sample`] samples a direction that hits an emissive triangle: given
    /// its instance, the squared distance in m^2, and the cosine between the geometric normal of its front and the
    /// direction back (negative for the back). 0 without emission.
    #[inline(always)]
    pub fn pdf(&self, instance: &[u32; LANES], distance_squared: &[f32; LANES], cosine: &[f32; LANES]) -> [f32; LANES] {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            let [front, back] = match self.area_pdfs.get(instance[lane] as usize) {
                Some(area_pdfs) => *area_pdfs,
                None => [0.0; 2],
            };
            out[lane] = if cosine[lane] > 0.0 { front } else { back };
        }
        for lane in 0..LANES {
            out[lane] = solid_angle_pdf(out[lane], distance_squared[lane], cosine[lane]);
        }
        out
    }

    /// Selects an emissive triangle per lane.
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
        // The number of triangles after `found` that may be the one.
        let mut more = [0; LANES];
        let mut any = 0;
        for lane in 0..LANES {
            let interval = (wanted[lane] >> self.guide.shift) as usize;
            found[lane] = self.guide.first[interval];
            more[lane] = self.guide.first[interval + 1] - found[lane];
            any |= more[lane];
        }
        while any > 0 {
            any = 0;
            for lane in 0..LANES {
                let half = more[lane].div_ceil(2);
                // As a product: a branch would be mispredicted half of the time.
                let beyond = u32::from(self.starts[(found[lane] + half) as usize] <= wanted[lane]);
                found[lane] += half * beyond;
                more[lane] = (more[lane] - half) * beyond + (half.max(1) - 1) * (1 - beyond);
                any |= more[lane];
            }
        }
        found
    }
}

/// Converts a pdf per area to a pdf per solid angle at the squared distance `squared`, m^2.
#[inline(always)]
fn solid_angle_pdf(area_pdf: f32, squared: f32, cosine: f32) -> f32 {
    let pdf = area_pdf * squared / cosine.abs();
    // 0 for edge-on triangles, and for a point of the triangle itself, where the cosine is NaN.
    if pdf < f32::INFINITY { pdf } else { 0.0 }
}

/// The luminance of the mean emission of one side.
fn mean_luminance(material: &Material, textures: &[Texture], means: &mut [Option<[f64; 3]>]) -> f64 {
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
