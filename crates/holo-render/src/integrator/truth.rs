//! Layers of one tile, packet by packet: what sixteen exact rays through the pixels' centres see first.
//!
//! The engine finds the triangle in f32, [`crate::accel::refine`] gives the depth and the triangle's normal in f64; every layer
//! is computed from those before it is rounded to f32. What the layers mean is told in [`crate::film::layers`].

use ndarray::ArrayViewMut5;

use super::Context;
use crate::accel::refine::Refined;
use crate::accel::{ExactRays, NO_TRIANGLE, RayHits};
use crate::camera::tile::Tile;
use crate::film::layers::{Layer, LayerSet, Layers};
use crate::material::Surfaces;
use crate::simd::LANES;

/// Layers that need more than the triangle: the vertices' normals, the material's textures.
const OF_SURFACES: LayerSet = LayerSet::of(&[Layer::ShadingNormal, Layer::Albedo]);

/// Where a tile's layers go.
pub(crate) type TruthTile<'a> = Layers<ArrayViewMut5<'a, f32>>;

/// What sixteen rays see.
pub(crate) struct Seen<'a> {
    pub packet: &'a RayHits,
    pub rays: &'a ExactRays,
    pub refined: &'a Refined,
    /// Read only by layers that [`needs_surfaces`]; `None` also where nothing is hit.
    pub surfaces: Option<&'a Surfaces>,
}

/// The layers of one tile while it is worked on. Each has its packets in the one of the two lists that fits it. A thread keeps its
/// memory from tile to tile.
#[derive(Default)]
pub(crate) struct Truth {
    layers: LayerSet,
    numbers: [Vec<[[f32; LANES]; 1]>; Layer::COUNT],
    vectors: [Vec<[[f32; LANES]; 3]>; Layer::COUNT],
}

/// Whether surfaces must be looked up for these layers.
pub(crate) fn needs_surfaces(layers: LayerSet) -> bool {
    !layers.intersection(OF_SURFACES).is_empty()
}

impl Truth {
    /// Makes it ready for another tile of these layers.
    pub fn begin(&mut self, layers: LayerSet) {
        self.layers = layers;
        self.numbers.iter_mut().for_each(Vec::clear);
        self.vectors.iter_mut().for_each(Vec::clear);
    }

    /// Takes what the next packet sees.
    #[inline(always)]
    pub fn push(&mut self, context: &Context, seen: &Seen) {
        for k in 0..Layer::COUNT {
            let layer = Layer::ALL[k];
            if !self.layers.contains(layer) {
                continue;
            }
            match layer {
                Layer::Depth => self.numbers[k].push([depth(seen)]),
                Layer::RayLength => self.numbers[k].push([ray_length(seen)]),
                Layer::Disparity => self.numbers[k].push([disparity(context, seen)]),
                Layer::ObjectId => self.numbers[k].push([object_id(context, seen)]),
                Layer::MaterialId => self.numbers[k].push([material_id(context, seen)]),
                Layer::HitMask => self.numbers[k].push([hit_mask(seen)]),
                Layer::GeometricNormal => self.vectors[k].push(geometric_normal(context, seen)),
                Layer::ShadingNormal => self.vectors[k].push(shading_normal(context, seen)),
                Layer::Albedo => self.vectors[k].push(albedo(seen)),
            }
        }
    }

    /// Writes the tile.
    #[inline(always)]
    pub fn write(&self, tile: &Tile, out: &mut TruthTile) {
        for (layer, field) in out.iter_mut() {
            let k = layer as usize;
            if layer.channels() == 1 {
                tile.write(&self.numbers[k], 1.0, field);
            } else {
                tile.write(&self.vectors[k], 1.0, field);
            }
        }
    }
}

#[inline(always)]
fn depth(seen: &Seen) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        out[lane] = seen.refined.depth[lane] as f32;
    }
    out
}

/// Rays start in the plane z = 0 and go one unit of depth along their direction (x, y, -1).
#[inline(always)]
fn ray_length(seen: &Seen) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y] = [seen.rays.direction_x[lane], seen.rays.direction_y[lane]];
        out[lane] = (seen.refined.depth[lane] * (x * x + y * y + 1.0).sqrt()) as f32;
    }
    out
}

#[inline(always)]
fn disparity(context: &Context, seen: &Seen) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        out[lane] = context.camera.disparity().from_depth_m(seen.refined.depth[lane]) as f32;
    }
    out
}

#[inline(always)]
fn hit_mask(seen: &Seen) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        out[lane] = if seen.packet.hits.triangle[lane] == NO_TRIANGLE { 0.0 } else { 1.0 };
    }
    out
}

#[inline(always)]
fn object_id(context: &Context, seen: &Seen) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let hit = seen.packet.hit(lane);
        if hit.triangle != NO_TRIANGLE {
            out[lane] = (context.scene.geometry.part(context.scene.geometry.part_index(hit)).object + 1) as f32;
        }
    }
    out
}

#[inline(always)]
fn material_id(context: &Context, seen: &Seen) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let hit = seen.packet.hit(lane);
        if hit.triangle != NO_TRIANGLE {
            let part = context.scene.geometry.part_index(hit);
            out[lane] = (context.scene.geometry.part(part).material + 1) as f32;
        }
    }
    out
}

#[inline(always)]
fn geometric_normal(context: &Context, seen: &Seen) -> [[f32; LANES]; 3] {
    let mut normal = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        // 0 where nothing is hit.
        let found = &seen.refined.normal;
        let [x, y, z] = [found[0][lane], found[1][lane], found[2][lane]];
        let towards = x * seen.rays.direction_x[lane] + y * seen.rays.direction_y[lane] - z;
        let side = if towards > 0.0 { -1.0 } else { 1.0 };
        normal[0][lane] = x * side;
        normal[1][lane] = y * side;
        normal[2][lane] = z * side;
    }
    unit_in_world(context, &normal)
}

#[inline(always)]
fn shading_normal(context: &Context, seen: &Seen) -> [[f32; LANES]; 3] {
    let mut normal = [[0.0; LANES]; 3];
    if let Some(surfaces) = seen.surfaces {
        for lane in 0..LANES {
            for axis in 0..3 {
                let found = f64::from(surfaces.shading_normal[axis][lane]);
                normal[axis][lane] = if surfaces.hit[lane] { found } else { 0.0 };
            }
        }
    }
    unit_in_world(context, &normal)
}

#[inline(always)]
fn albedo(seen: &Seen) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    if let Some(surfaces) = seen.surfaces {
        for lane in 0..LANES {
            for c in 0..3 {
                out[c][lane] = if surfaces.hit[lane] { surfaces.base_color[c][lane] } else { 0.0 };
            }
        }
    }
    out
}

/// Camera to world coordinates, at unit length; 0 stays 0.
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
