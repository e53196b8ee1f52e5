//! Sixteen surfaces as they scatter light: Lambert's law where that is all, [`crate::material::bsdf`] where a packet meets more.
//!
//! A lane's result does not depend on its neighbours: Lambertian lanes are computed by the same few operations whether
//! the packet meets glossy surfaces or not.

use std::f32::consts::FRAC_1_PI;

use super::Context;
use super::shade::Shading;
use crate::material::Kinds;
use crate::material::Surfaces;
use crate::material::bsdf::Bsdf;
use crate::sampling::{self, Points};
use crate::simd::{LANES, at};

/// Viewers look at a glossy surface from at least this cosine above its shading normal's plane; a normal that is turned
/// away further (at the rim of smooth-shaded meshes) is bent towards them.
const SMALLEST_COSINE: f32 = 1e-3;

/// Sixteen surfaces and what they do with light.
pub(crate) struct Scatterer<'a> {
    surfaces: &'a Surfaces,
    glossy: Option<Glossy>,
}

/// What glossy lanes need beyond Lambert's law.
struct Glossy {
    bsdf: Bsdf,
    lanes: [bool; LANES],
    /// Axes of the shading frame: x, y, and z on the viewer's side.
    axes: [[[f32; LANES]; 3]; 3],
    /// Towards the viewer, in that frame.
    out: [[f32; LANES]; 3],
}

/// What sixteen surfaces send to the viewer of light from given directions.
pub(crate) struct Response {
    /// f * |cosine|.
    pub value: [[f32; LANES]; 3],
    /// Density with which [`Scatterer::scatter`] draws the direction.
    pub density: [f32; LANES],
    /// Where a shadow ray in that direction starts.
    pub start: [[f32; LANES]; 3],
}

/// Directions in which sixteen paths go on.
pub(crate) struct Scattered {
    pub start: [[f32; LANES]; 3],
    pub direction: [[f32; LANES]; 3],
    /// f * |cosine| / density; 0 where the path ends.
    pub weight: [[f32; LANES]; 3],
    /// Infinite where there was no choice.
    pub density: [f32; LANES],
    /// Scattered by metal, glass or a polished surface.
    pub sharp: [bool; LANES],
}

impl<'a> Scatterer<'a> {
    #[inline(always)]
    pub fn new(context: &Context, here: &'a Shading) -> Self {
        let surfaces = here.surfaces;
        let glossy = if surfaces.any.has(Kinds::GLOSSY) { Some(Glossy::new(context, here)) } else { None };
        Self { surfaces, glossy }
    }

    #[inline(always)]
    pub fn is_glossy(&self) -> bool {
        self.glossy.is_some()
    }

    /// The response to light from directions `to_light`, whose lengths are 1/`inverse_length`.
    #[inline(always)]
    pub fn respond(&self, to_light: &[[f32; LANES]; 3], inverse_length: &[f32; LANES]) -> Response {
        let surfaces = self.surfaces;
        let mut above = [0.0; LANES];
        let mut out = Response { value: [[0.0; LANES]; 3], density: [0.0; LANES], start: surfaces.start };
        for lane in 0..LANES {
            let mut cosine = 0.0;
            for axis in 0..3 {
                cosine += surfaces.shading_normal[axis][lane] * to_light[axis][lane];
                above[lane] += surfaces.geometric_normal[axis][lane] * to_light[axis][lane];
            }
            cosine *= inverse_length[lane];
            let reaches = (above[lane] > 0.0) & (cosine > 0.0);
            let share = if reaches { cosine * FRAC_1_PI } else { 0.0 };
            out.density[lane] = share;
            for c in 0..3 {
                out.value[c][lane] = surfaces.base_color[c][lane] * share;
            }
        }
        let Some(glossy) = &self.glossy else { return out };
        let into = glossy.to_local(to_light, inverse_length);
        let evaluated = glossy.bsdf.evaluate(&glossy.out, &into);
        for lane in 0..LANES {
            let chosen = glossy.lanes[lane];
            // Light from one side of the triangle and the other side of the interpolated normal would leak.
            let agrees = above[lane] * into[2][lane] > 0.0;
            for c in 0..3 {
                let value = if agrees { evaluated.value[c][lane] } else { 0.0 };
                out.value[c][lane] = if chosen { value } else { out.value[c][lane] };
            }
            out.density[lane] = if chosen { evaluated.pdf[lane] } else { out.density[lane] };
            let behind = chosen & (above[lane] < 0.0);
            for axis in 0..3 {
                out.start[axis][lane] = start(surfaces, axis, lane, behind);
            }
        }
        out
    }

    /// Draws directions by `numbers`, and by `choice` which part of a glossy surface scatters.
    #[inline(always)]
    pub fn scatter(&self, here: &Shading, with_density: bool, numbers: &Points, choice: &[f32; LANES]) -> Scattered {
        let surfaces = self.surfaces;
        let local = sampling::cosine_hemisphere(numbers);
        let mut out = Scattered {
            start: surfaces.start,
            direction: [[0.0; LANES]; 3],
            weight: [[0.0; LANES]; 3],
            density: [0.0; LANES],
            sharp: [false; LANES],
        };
        for lane in 0..LANES {
            let normal = at(&surfaces.shading_normal, lane);
            let [x, y] = sampling::frame(normal);
            let mut above = 0.0;
            for axis in 0..3 {
                let d = x[axis] * local[0][lane] + y[axis] * local[1][lane] + normal[axis] * local[2][lane];
                out.direction[axis][lane] = d;
                above += d * surfaces.geometric_normal[axis][lane];
            }
            // Under the triangle itself there is nothing to see, whatever the interpolated normal says.
            let leaves = here.hit[lane] & (above > 0.0);
            for c in 0..3 {
                out.weight[c][lane] = if leaves { surfaces.base_color[c][lane] } else { 0.0 };
            }
        }
        if with_density {
            for lane in 0..LANES {
                out.density[lane] = local[2][lane] * FRAC_1_PI;
            }
        }
        let Some(glossy) = &self.glossy else { return out };
        let sampled = glossy.bsdf.sample(&glossy.out, choice, numbers);
        let direction = glossy.to_camera(&sampled.into);
        for lane in 0..LANES {
            let chosen = glossy.lanes[lane];
            let mut above = 0.0;
            for axis in 0..3 {
                above += direction[axis][lane] * surfaces.geometric_normal[axis][lane];
            }
            let agrees = here.hit[lane] & if sampled.transmitted[lane] { above < 0.0 } else { above > 0.0 };
            for c in 0..3 {
                let weight = if agrees { sampled.weight[c][lane] } else { 0.0 };
                out.weight[c][lane] = if chosen { weight } else { out.weight[c][lane] };
            }
            for axis in 0..3 {
                out.direction[axis][lane] = if chosen { direction[axis][lane] } else { out.direction[axis][lane] };
                out.start[axis][lane] = start(surfaces, axis, lane, chosen & sampled.transmitted[lane]);
            }
            out.density[lane] = if chosen { sampled.pdf[lane] } else { out.density[lane] };
            let polished = sampled.pdf[lane] == f32::INFINITY;
            let solid = glossy.bsdf.metallic[lane].max(glossy.bsdf.transmission[lane]) >= 0.5;
            out.sharp[lane] = chosen & (polished | solid);
        }
        out
    }
}

/// Where a ray starts that leaves to the viewer's side or behind.
#[inline(always)]
fn start(surfaces: &Surfaces, axis: usize, lane: usize, behind: bool) -> f32 {
    let (position, start) = (surfaces.position[axis][lane], surfaces.start[axis][lane]);
    if behind { position + (position - start) } else { start }
}

impl Glossy {
    #[inline(always)]
    fn new(context: &Context, here: &Shading) -> Self {
        let surfaces = here.surfaces;
        let zero = [[0.0; LANES]; 3];
        let mut out = Self {
            bsdf: context.scene.appearance.scattering(context.scene.geometry, here.packet, surfaces),
            lanes: [false; LANES],
            axes: [zero; 3],
            out: zero,
        };
        let direction = &here.packet.rays.direction;
        for lane in 0..LANES {
            out.lanes[lane] = surfaces.kinds[lane].has(Kinds::GLOSSY);
            let [x, y, z] = at(direction, lane);
            let inverse = -1.0 / (x * x + y * y + z * z).sqrt();
            let viewer = [x * inverse, y * inverse, z * inverse];
            let mut normal = at(&surfaces.shading_normal, lane);
            let cosine = normal[0] * viewer[0] + normal[1] * viewer[1] + normal[2] * viewer[2];
            let lift = (SMALLEST_COSINE - cosine).max(0.0);
            let mut squared = 0.0;
            for axis in 0..3 {
                normal[axis] += viewer[axis] * lift;
                squared += normal[axis] * normal[axis];
            }
            let unit = 1.0 / squared.sqrt();
            for axis in 0..3 {
                normal[axis] *= if lift > 0.0 { unit } else { 1.0 };
            }
            let [x, y] = sampling::frame(normal);
            for axis in 0..3 {
                out.axes[0][axis][lane] = x[axis];
                out.axes[1][axis][lane] = y[axis];
                out.axes[2][axis][lane] = normal[axis];
                out.out[0][lane] += x[axis] * viewer[axis];
                out.out[1][lane] += y[axis] * viewer[axis];
                out.out[2][lane] += normal[axis] * viewer[axis];
            }
            out.out[2][lane] = out.out[2][lane].max(0.5 * SMALLEST_COSINE);
        }
        out
    }

    #[inline(always)]
    fn to_local(&self, direction: &[[f32; LANES]; 3], inverse_length: &[f32; LANES]) -> [[f32; LANES]; 3] {
        let mut out = [[0.0; LANES]; 3];
        for k in 0..3 {
            for lane in 0..LANES {
                let mut sum = 0.0;
                for axis in 0..3 {
                    sum += self.axes[k][axis][lane] * direction[axis][lane];
                }
                out[k][lane] = sum * inverse_length[lane];
            }
        }
        out
    }

    #[inline(always)]
    fn to_camera(&self, local: &[[f32; LANES]; 3]) -> [[f32; LANES]; 3] {
        let mut out = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for lane in 0..LANES {
                for k in 0..3 {
                    out[axis][lane] += self.axes[k][axis][lane] * local[k][lane];
                }
            }
        }
        out
    }
}
