//! AOVs: the layers of one tile, computed packet by packet from the first hits of sixteen exact rays through the
//! centers of the pixels.
//!
//! The engine finds the triangle in f32; [`crate::accel::refine`] computes depth and the normal of the triangle in f64.
//! Every layer is computed from these values before it is rounded to f32. [`crate::film::layers`] defines the layers.

use ndarray::ArrayViewMut5;

use super::Context;
use crate::accel::refine::Refined;
use crate::accel::{ExactRays, NO_TRIANGLE, RayHits};
use crate::camera::tile::Tile;
use crate::film::layers::{Layer, LayerSet, Layers};
use crate::geometry::InstanceData;
use crate::material::SurfaceInteraction;
use crate::simd::LANES;

/// Layers that need vertex normals or textures.
const SURFACE_LAYERS: LayerSet = LayerSet::of(&[Layer::ShadingNormal, Layer::Albedo]);

/// The outputs of a tile, per layer.
pub(crate) type AovTile<'a> = Layers<ArrayViewMut5<'a, f32>>;

/// The first hits of sixteen chief rays.
pub(crate) struct PrimaryHits<'a> {
    pub packet: &'a RayHits,
    pub rays: &'a ExactRays,
    pub refined: &'a Refined,
    /// Read only for layers that [`needs_interaction`]; `None` if no ray hits.
    pub interaction: Option<&'a SurfaceInteraction>,
}

/// The layers of one tile during rendering, in packet order: scalar layers and vector layers. Reused from tile to tile.
#[derive(Default)]
pub(crate) struct TileAovs {
    layers: LayerSet,
    scalars: [Vec<[[f32; LANES]; 1]>; Layer::COUNT],
    vectors: [Vec<[[f32; LANES]; 3]>; Layer::COUNT],
}

/// Whether these layers need a [`SurfaceInteraction`].
pub(crate) fn needs_interaction(layers: LayerSet) -> bool {
    !layers.intersection(SURFACE_LAYERS).is_empty()
}

impl TileAovs {
    /// Clears the values for another tile with these layers.
    pub fn begin(&mut self, layers: LayerSet) {
        self.layers = layers;
        self.scalars.iter_mut().for_each(Vec::clear);
        self.vectors.iter_mut().for_each(Vec::clear);
    }

    /// Appends the values of the next packet.
    #[inline(always)]
    pub fn push(&mut self, context: &Context, hits: &PrimaryHits) {
        for k in 0..Layer::COUNT {
            let layer = Layer::ALL[k];
            if !self.layers.contains(layer) {
                continue;
            }
            match layer {
                Layer::Depth => self.scalars[k].push([depth(hits)]),
                Layer::RayLength => self.scalars[k].push([ray_length(hits)]),
                Layer::Disparity => self.scalars[k].push([disparity(context, hits)]),
                Layer::ObjectId => self.scalars[k].push([object_id(context, hits)]),
                Layer::MaterialId => self.scalars[k].push([material_id(context, hits)]),
                Layer::HitMask => self.scalars[k].push([hit_mask(hits)]),
                Layer::Reflective => self.scalars[k].push([reflective(context, hits)]),
                Layer::GeometricNormal => self.vectors[k].push(geometric_normal(context, hits)),
                Layer::ShadingNormal => self.vectors[k].push(shading_normal(context, hits)),
                Layer::Albedo => self.vectors[k].push(albedo(hits)),
            }
        }
    }

    /// Writes the values to the outputs of the tile.
    #[inline(always)]
    pub fn write(&self, tile: &Tile, out: &mut AovTile) {
        for (layer, field) in out.iter_mut() {
            let k = layer as usize;
            if layer.channels() == 1 {
                tile.write(&self.scalars[k], 1.0, field);
            } else {
                tile.write(&self.vectors[k], 1.0, field);
            }
        }
    }
}

#[inline(always)]
fn depth(hits: &PrimaryHits) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        out[lane] = hits.refined.depth[lane] as f32;
    }
    out
}

/// Rays start in the plane z = 0 and have the direction (x, y, -1), one unit of depth.
#[inline(always)]
fn ray_length(hits: &PrimaryHits) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y] = [hits.rays.direction_x[lane], hits.rays.direction_y[lane]];
        out[lane] = (hits.refined.depth[lane] * (x * x + y * y + 1.0).sqrt()) as f32;
    }
    out
}

#[inline(always)]
fn disparity(context: &Context, hits: &PrimaryHits) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        out[lane] = context.camera.disparity_px(hits.refined.depth[lane]) as f32;
    }
    out
}

#[inline(always)]
fn hit_mask(hits: &PrimaryHits) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        out[lane] = if hits.packet.hits.triangle[lane] == NO_TRIANGLE { 0.0 } else { 1.0 };
    }
    out
}

/// A value of the instances that are hit; 0 for a miss.
#[inline(always)]
fn of_instances(context: &Context, hits: &PrimaryHits, value: impl Fn(&InstanceData) -> f32) -> [f32; LANES] {
    let geometry = &context.scene.geometry;
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let hit = hits.packet.hit(lane);
        if hit.triangle != NO_TRIANGLE {
            out[lane] = value(geometry.instance(geometry.instance_index(hit)));
        }
    }
    out
}

#[inline(always)]
fn object_id(context: &Context, hits: &PrimaryHits) -> [f32; LANES] {
    of_instances(context, hits, |instance| (instance.object + 1) as f32)
}

#[inline(always)]
fn material_id(context: &Context, hits: &PrimaryHits) -> [f32; LANES] {
    of_instances(context, hits, |instance| (instance.material + 1) as f32)
}

#[inline(always)]
fn reflective(context: &Context, hits: &PrimaryHits) -> [f32; LANES] {
    of_instances(context, hits, |instance| f32::from(context.scene.appearance.reflective(instance.material)))
}

#[inline(always)]
fn geometric_normal(context: &Context, hits: &PrimaryHits) -> [[f32; LANES]; 3] {
    let mut normal = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        // 0 for a miss.
        let found = &hits.refined.normal;
        let [x, y, z] = [found[0][lane], found[1][lane], found[2][lane]];
        let towards = x * hits.rays.direction_x[lane] + y * hits.rays.direction_y[lane] - z;
        let side = if towards > 0.0 { -1.0 } else { 1.0 };
        normal[0][lane] = x * side;
        normal[1][lane] = y * side;
        normal[2][lane] = z * side;
    }
    unit_in_world(context, &normal)
}

#[inline(always)]
fn shading_normal(context: &Context, hits: &PrimaryHits) -> [[f32; LANES]; 3] {
    let mut normal = [[0.0; LANES]; 3];
    if let Some(interaction) = hits.interaction {
        for lane in 0..LANES {
            for axis in 0..3 {
                let found = f64::from(interaction.shading_normal[axis][lane]);
                normal[axis][lane] = if interaction.hit[lane] { found } else { 0.0 };
            }
        }
    }
    unit_in_world(context, &normal)
}

#[inline(always)]
fn albedo(hits: &PrimaryHits) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    if let Some(interaction) = hits.interaction {
        for lane in 0..LANES {
            for c in 0..3 {
                out[c][lane] = if interaction.hit[lane] { interaction.base_color[c][lane] } else { 0.0 };
            }
        }
    }
    out
}

/// Camera to world coordinates, normalized; 0 stays 0.
#[inline(always)]
fn unit_in_world(context: &Context, normal: &[[f64; LANES]; 3]) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    let [right, up, back] = &context.scene.to_world;
    for lane in 0..LANES {
        let [x, y, z] = [normal[0][lane], normal[1][lane], normal[2][lane]];
        let mut world = [0.0; 3];
        let mut squared = 0.0;
        for axis in 0..3 {
            world[axis] = right[axis] * x + up[axis] * y + back[axis] * z;
            squared += world[axis] * world[axis];
        }
        let inverse = if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 };
        for axis in 0..3 {
            out[axis][lane] = (world[axis] * inverse) as f32;
        }
    }
    out
}
