//! The BSDFs of sixteen surface interactions: Lambert's law for diffuse materials, [`crate::material::bsdf`] for
//! packets with glossy ones, and [`crate::material::bsdf::layered`] for lanes with layers.
//!
//! The result of a lane does not depend on its neighbors: Lambertian lanes use the same operations whether or not the
//! packet contains glossy surfaces.

use std::f32::consts::FRAC_1_PI;

use super::Context;
use super::vertex::Shading;
use crate::material::SurfaceInteraction;
use crate::material::bsdf::layered::LayeredView;
use crate::material::bsdf::{Bsdf, Lobes};
use crate::material::shading_normal::{MIN_COSINE, reflecting};
use crate::material::{Lane, MaterialFlags};
use crate::sampling::{self, Points};
use crate::simd::{LANES, at};

/// The BSDFs of sixteen surface interactions.
pub(crate) struct Scatterer<'a> {
    interaction: &'a SurfaceInteraction,
    glossy: Option<Glossy>,
}

/// The state of glossy lanes.
struct Glossy {
    bsdf: Bsdf,
    lanes: [bool; LANES],
    /// The axes of the shading frame: x, y, and z on the side of the viewer.
    axes: [[[f32; LANES]; 3]; 3],
    /// The direction to the viewer in the shading frame, and the lobes for it.
    out: [[f32; LANES]; 3],
    lobes: Lobes,
    /// The lanes with layers; not allocated without any.
    layered: Vec<(usize, LayeredView)>,
}

/// The BSDFs evaluated for given directions to the light.
pub(crate) struct Response {
    /// BSDF * |cosine|.
    pub value: [[f32; LANES]; 3],
    /// The pdf with which [`Scatterer::scatter`] samples the direction.
    pub bsdf_pdf: [f32; LANES],
    /// The start of a shadow ray in that direction.
    pub start: [[f32; LANES]; 3],
}

/// Sampled directions of sixteen paths.
pub(crate) struct Scattered {
    pub start: [[f32; LANES]; 3],
    pub direction: [[f32; LANES]; 3],
    /// BSDF * |cosine| / pdf; 0 if the path ends.
    pub weight: [[f32; LANES]; 3],
    /// Infinite for a delta lobe.
    pub bsdf_pdf: [f32; LANES],
    /// Whether the scattering is specular: by metal, glass or a smooth coat.
    pub is_specular: [bool; LANES],
    /// Whether the direction is transmitted through the surface.
    pub transmitted: [bool; LANES],
}

impl<'a> Scatterer<'a> {
    #[inline(always)]
    pub fn new(context: &Context, here: &Shading<'a>) -> Self {
        let interaction = here.interaction;
        let glossy =
            if interaction.any_flags.has(MaterialFlags::GLOSSY) { Some(Glossy::new(context, here)) } else { None };
        Self { interaction, glossy }
    }

    #[inline(always)]
    pub fn is_glossy(&self) -> bool {
        self.glossy.is_some()
    }

    /// Evaluates the BSDFs for the directions `to_light`, whose lengths are 1/`inverse_length`.
    #[inline(always)]
    pub fn respond(&self, to_light: &[[f32; LANES]; 3], inverse_length: &[f32; LANES]) -> Response {
        let interaction = self.interaction;
        let mut above = [0.0; LANES];
        let mut out = Response { value: [[0.0; LANES]; 3], bsdf_pdf: [0.0; LANES], start: interaction.start };
        for lane in 0..LANES {
            let mut cosine = 0.0;
            for axis in 0..3 {
                cosine += interaction.shading_normal[axis][lane] * to_light[axis][lane];
                above[lane] += interaction.geometric_normal[axis][lane] * to_light[axis][lane];
            }
            cosine *= inverse_length[lane];
            let reaches = (above[lane] > 0.0) & (cosine > 0.0);
            let share = if reaches { cosine * FRAC_1_PI } else { 0.0 };
            out.bsdf_pdf[lane] = share;
            for c in 0..3 {
                out.value[c][lane] = interaction.base_color[c][lane] * share;
            }
        }
        let Some(glossy) = &self.glossy else { return out };
        let into = glossy.to_local(to_light, inverse_length);
        let mut evaluated = glossy.bsdf.evaluate_lobes(&glossy.lobes, &glossy.out, &into);
        for (lane, view) in &glossy.layered {
            let (value, pdf) = view.evaluate(at(&into, *lane));
            for c in 0..3 {
                evaluated.value[c][*lane] = value[c];
            }
            evaluated.pdf[*lane] = pdf;
        }
        for lane in 0..LANES {
            let chosen = glossy.lanes[lane];
            // Light from opposite sides of the triangle and of the interpolated normal would leak.
            let agrees = above[lane] * into[2][lane] > 0.0;
            for c in 0..3 {
                let value = if agrees { evaluated.value[c][lane] } else { 0.0 };
                out.value[c][lane] = if chosen { value } else { out.value[c][lane] };
            }
            out.bsdf_pdf[lane] = if chosen { evaluated.pdf[lane] } else { out.bsdf_pdf[lane] };
            let behind = chosen & (above[lane] < 0.0);
            for axis in 0..3 {
                out.start[axis][lane] = start(interaction, axis, lane, behind);
            }
        }
        out
    }

    /// Samples directions: `choice` selects the lobe of a glossy surface, `numbers` the direction.
    #[inline(always)]
    pub fn scatter(&self, here: &Shading, with_pdf: bool, numbers: &Points, choice: &[f32; LANES]) -> Scattered {
        let interaction = self.interaction;
        let local = sampling::cosine_hemisphere(numbers);
        let mut out = Scattered {
            start: interaction.start,
            direction: [[0.0; LANES]; 3],
            weight: [[0.0; LANES]; 3],
            bsdf_pdf: [0.0; LANES],
            is_specular: [false; LANES],
            transmitted: [false; LANES],
        };
        for lane in 0..LANES {
            let normal = at(&interaction.shading_normal, lane);
            let [x, y] = sampling::frame(normal);
            let mut above = 0.0;
            for axis in 0..3 {
                let d = x[axis] * local[0][lane] + y[axis] * local[1][lane] + normal[axis] * local[2][lane];
                out.direction[axis][lane] = d;
                above += d * interaction.geometric_normal[axis][lane];
            }
            // Directions below the triangle itself are rejected, whatever the interpolated normal.
            let leaves = here.hit[lane] & (above > 0.0);
            for c in 0..3 {
                out.weight[c][lane] = if leaves { interaction.base_color[c][lane] } else { 0.0 };
            }
        }
        if with_pdf {
            for lane in 0..LANES {
                out.bsdf_pdf[lane] = local[2][lane] * FRAC_1_PI;
            }
        }
        let Some(glossy) = &self.glossy else { return out };
        let mut sampled = glossy.bsdf.sample_lobes(&glossy.lobes, &glossy.out, choice, numbers);
        for (lane, view) in &glossy.layered {
            let one = view.sample(choice[*lane], at(&local, *lane));
            for k in 0..3 {
                sampled.into[k][*lane] = one.into[k];
                sampled.weight[k][*lane] = one.weight[k];
            }
            sampled.pdf[*lane] = one.pdf;
            sampled.transmitted[*lane] = one.transmitted;
        }
        let direction = glossy.to_camera(&sampled.into);
        for lane in 0..LANES {
            let chosen = glossy.lanes[lane];
            let mut above = 0.0;
            for axis in 0..3 {
                above += direction[axis][lane] * interaction.geometric_normal[axis][lane];
            }
            let agrees = here.hit[lane] & if sampled.transmitted[lane] { above < 0.0 } else { above > 0.0 };
            for c in 0..3 {
                let weight = if agrees { sampled.weight[c][lane] } else { 0.0 };
                out.weight[c][lane] = if chosen { weight } else { out.weight[c][lane] };
            }
            for axis in 0..3 {
                out.direction[axis][lane] = if chosen { direction[axis][lane] } else { out.direction[axis][lane] };
                out.start[axis][lane] = start(interaction, axis, lane, chosen & sampled.transmitted[lane]);
            }
            out.bsdf_pdf[lane] = if chosen { sampled.pdf[lane] } else { out.bsdf_pdf[lane] };
            let polished = sampled.pdf[lane] == f32::INFINITY;
            let solid = glossy.bsdf.metallic[lane].max(glossy.bsdf.transmission[lane]) >= 0.5;
            out.is_specular[lane] = chosen & (polished | solid);
            out.transmitted[lane] = chosen & sampled.transmitted[lane];
        }
        out
    }
}

/// The start of a ray on the side of the viewer, or behind the surface.
#[inline(always)]
fn start(interaction: &SurfaceInteraction, axis: usize, lane: usize, behind: bool) -> f32 {
    let (position, start) = (interaction.position[axis][lane], interaction.start[axis][lane]);
    if behind { position + (position - start) } else { start }
}

impl Glossy {
    #[inline(always)]
    fn new(context: &Context, here: &Shading) -> Self {
        let interaction = here.interaction;
        let zero = [[0.0; LANES]; 3];
        let mut out = Self {
            bsdf: context.scene.appearance.scattering(
                context.scene.geometry,
                here.packet,
                interaction,
                &here.paths.media,
                context.policy.multiple_scattering,
            ),
            lanes: [false; LANES],
            axes: [zero; 3],
            out: zero,
            lobes: Lobes::LAMBERTIAN,
            layered: Vec::new(),
        };
        let direction = &here.packet.rays.direction;
        for lane in 0..LANES {
            out.lanes[lane] = interaction.flags[lane].has(MaterialFlags::GLOSSY);
            let [x, y, z] = at(direction, lane);
            let inverse = -1.0 / (x * x + y * y + z * z).sqrt();
            let viewer = [x * inverse, y * inverse, z * inverse];
            let mut normal = at(&interaction.shading_normal, lane);
            let cosine = normal[0] * viewer[0] + normal[1] * viewer[1] + normal[2] * viewer[2];
            let lift = (MIN_COSINE - cosine).max(0.0);
            let mut squared = 0.0;
            for axis in 0..3 {
                normal[axis] += viewer[axis] * lift;
                squared += normal[axis] * normal[axis];
            }
            let unit = 1.0 / squared.sqrt();
            for axis in 0..3 {
                normal[axis] *= if lift > 0.0 { unit } else { 1.0 };
            }
            let normal = reflecting(normal, viewer, at(&interaction.geometric_normal, lane));
            let [x, y] = sampling::frame(normal);
            for axis in 0..3 {
                out.axes[0][axis][lane] = x[axis];
                out.axes[1][axis][lane] = y[axis];
                out.axes[2][axis][lane] = normal[axis];
                out.out[0][lane] += x[axis] * viewer[axis];
                out.out[1][lane] += y[axis] * viewer[axis];
                out.out[2][lane] += normal[axis] * viewer[axis];
            }
            out.out[2][lane] = out.out[2][lane].max(0.5 * MIN_COSINE);
        }
        if interaction.any_flags.has(MaterialFlags::LAYERED) {
            out.add_layers(context, here);
        }
        out.lobes = out.bsdf.lobes(&out.out);
        out
    }

    /// Prepares the lanes with layers, whose frames may be turned to the axes of their roughness.
    #[inline(never)]
    fn add_layers(&mut self, context: &Context, here: &Shading) {
        for lane in 0..LANES {
            if !here.hit[lane] || !here.interaction.flags[lane].has(MaterialFlags::LAYERED) {
                continue;
            }
            let mut axes: [[f32; 3]; 3] = std::array::from_fn(|k| at(&self.axes[k], lane));
            let local = at(&self.out, lane);
            let viewer = std::array::from_fn(|k| axes[0][k] * local[0] + axes[1][k] * local[1] + axes[2][k] * local[2]);
            let lane_here = Lane {
                geometry: context.scene.geometry,
                packet: here.packet,
                interaction: here.interaction,
                lane,
                media: here.paths.media[lane],
                axes,
                viewer,
                channels: std::array::from_fn(|c| here.paths.throughput[c][lane] > 0.0),
            };
            let Some((layered, turned)) = context.scene.appearance.layered(&self.bsdf, &lane_here) else { continue };
            axes = turned;
            for k in 0..3 {
                let along = axes[k][0] * viewer[0] + axes[k][1] * viewer[1] + axes[k][2] * viewer[2];
                self.out[k][lane] = if k == 2 { local[2] } else { along };
                for axis in 0..3 {
                    self.axes[k][axis][lane] = axes[k][axis];
                }
            }
            self.layered.push((lane, LayeredView::new(layered, at(&self.out, lane))));
        }
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
