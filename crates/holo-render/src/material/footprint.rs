//! Footprints: the part of a surface that a sample of a pixel stands for.
//!
//! The samples of a pixel are stratified: of 4^m successive ones, each lies in a cell of its own of 2^m x 2^m. The mean
//! of a texture around a sample, over a part as large as its cell, has little of the noise of fine texture. Over all places
//! of the samples every texel has the same weight, whatever the shape of the filter, so that seeds, views and frames have
//! different errors, which their mean has not; a filter around the centers of cells, where no place is by chance, weighs
//! texels between 0.56 and 2.25, the same ones always. This holds for what enters the radiance linearly (base color, emission), as long as the rest
//! (light, what hides the surface) does not vary with it within the cell. The error vanishes with the size of the cell,
//! which shrinks with the root of the number of samples. Cells that reach beyond the
//! triangle that a ray hits have no footprint: the rest of such a cell sees something else, and the texels around those
//! of a triangle may belong to other surfaces.
//!
//! A sample of a plenoptic camera stands for a cell of its pixel on the sensor and for a cell of its microlens, each with a
//! spot on the surface. Their sum is taken for a parallelogram of the same mean and the same variances: it is exact
//! where one of the two spots is much larger, which is that of the microlens in unfocused cameras, and that of the pixel in
//! focused ones.
//!
//! Sources: H. Igehy, "Tracing Ray Differentials" (1999), for the extent of a cell on the plane of a surface.

use crate::accel::refine::Refined;
use crate::accel::{Cells, ExactRays, RayDifferentials, SpotDifferentials};
use crate::geometry::{Geometry, Hit};
use crate::material::texture::{AROUND_HITS, TextureFootprint, TextureFootprints};
use crate::simd::LANES;
use glam::Vec3;

/// How far the filter around a hit anywhere in a cell reaches from the middle of the cell, in its sides: half a side, and
/// one interpolated texel, which is sqrt([`AROUND_HITS`] / 3) of a side wide.
const REACH_AROUND_HITS: f32 = 0.5 + TEXEL;
const TEXEL: f32 = 0.775;
const _: () = assert!(3.0 * TEXEL * TEXEL >= AROUND_HITS);

/// The footprints of sixteen camera rays on the surfaces that they hit.
#[derive(Clone, Copy)]
pub(crate) struct Footprints {
    /// The two sides of the footprint on the plane of the surface, m.
    sides: [[[f32; LANES]; 3]; 2],
    /// From the hit point to the middle of the footprint, in sides.
    to_center: [[f32; LANES]; 2],
}

/// A triangle with texture coordinates.
#[derive(Clone, Copy)]
pub(crate) struct TextureTriangle {
    /// The gradients of the barycentrics of the second and third corner on the plane of the triangle, 1/m.
    barycentrics: [[f32; 3]; 2],
    /// The texture coordinates of these corners less those of the first.
    edges: [[f32; 2]; 2],
}

/// Sixteen of them.
pub(crate) struct TextureTriangles {
    barycentrics: [[[f32; LANES]; 3]; 2],
    edges: [[[f32; LANES]; 2]; 2],
}

impl Footprints {
    #[inline(always)]
    pub fn new(cells: &Cells, rays: &ExactRays, refined: &Refined) -> Self {
        match cells {
            Cells::Squares(cells) => Self::of_squares(cells, rays, refined),
            Cells::Spots(cells) => Self::of_spots(cells, rays, refined),
        }
    }

    /// Those of cells of a pixel and of its microlens.
    #[inline(always)]
    fn of_spots(cells: &SpotDifferentials, rays: &ExactRays, refined: &Refined) -> Self {
        let mut out = Self { sides: [[[0.0; LANES]; 3]; 2], to_center: [[0.0; LANES]; 2] };
        for lane in 0..LANES {
            let [x, y, z] = &refined.normal;
            let normal = [x[lane] as f32, y[lane] as f32, z[lane] as f32];
            let direction = [rays.direction_x[lane] as f32, rays.direction_y[lane] as f32, -1.0];
            let towards = normal[0] * direction[0] + normal[1] * direction[1] - normal[2];
            let depth = refined.depth[lane] as f32;
            // In the plane z = -depth.
            let width = cells.on_sensor[0][lane] + depth * cells.on_sensor[1][lane];
            let factor = cells.on_lens[0][lane] + depth * cells.on_lens[1][lane];
            let xx = factor * factor * cells.lens_part[0][lane];
            let yy = factor * factor * cells.lens_part[1][lane];
            let xy = factor * factor * cells.lens_part[2][lane];
            // Cholesky's decomposition: the sides (a, b) and (0, c) of a parallelogram with these variances.
            let a = (xx + width * width).sqrt();
            let b = if a > 0.0 { xy / a } else { 0.0 };
            let c = (yy + width * width - b * b).max(0.0).sqrt();
            let mut center = [0.0; 2];
            for axis in 0..2 {
                center[axis] = cells.to_center[0][axis][lane] + depth * cells.to_center[1][axis][lane];
            }
            let along_first = if a > 0.0 { center[0] / a } else { 0.0 };
            let along_second = if c > 0.0 { (center[1] - along_first * b) / c } else { 0.0 };
            out.to_center[0][lane] = along_first;
            out.to_center[1][lane] = along_second;
            for (side, [across, up]) in [[a, b], [0.0, c]].into_iter().enumerate() {
                // From there along the ray to the plane of the surface.
                let along = -(normal[0] * across + normal[1] * up) / towards;
                out.sides[side][0][lane] = across + direction[0] * along;
                out.sides[side][1][lane] = up + direction[1] * along;
                out.sides[side][2][lane] = direction[2] * along;
            }
        }
        out
    }

    #[inline(always)]
    fn of_squares(cells: &RayDifferentials, rays: &ExactRays, refined: &Refined) -> Self {
        let mut out = Self { sides: [[[0.0; LANES]; 3]; 2], to_center: cells.to_center };
        for lane in 0..LANES {
            let [x, y, z] = &refined.normal;
            let normal = [x[lane] as f32, y[lane] as f32, z[lane] as f32];
            let direction = [rays.direction_x[lane] as f32, rays.direction_y[lane] as f32, -1.0];
            let towards = normal[0] * direction[0] + normal[1] * direction[1] - normal[2];
            // Where a ray passes the plane z = -depth, its distance from that of the next cell.
            let step = cells.origin_step + refined.depth[lane] as f32 * cells.direction_step;
            for side in 0..2 {
                let step = if side == 0 { step } else { -step };
                // From there along the ray to the plane of the surface.
                let along = -normal[side] / towards;
                for axis in 0..3 {
                    let across = if axis == side { 1.0 } else { 0.0 };
                    out.sides[side][axis][lane] = step * (across + direction[axis] * along);
                }
            }
        }
        out
    }

    /// The footprint of a lane in texture coordinates, around the barycentrics `hit`; `None` if its filter reaches beyond the
    /// triangle.
    #[inline(always)]
    pub(super) fn on_texture(
        &self,
        lane: usize,
        triangle: &TextureTriangle,
        hit: [f32; 2],
    ) -> Option<TextureFootprint> {
        let (footprint, is_inside) = self.of(lane, triangle, hit);
        is_inside.then_some(footprint)
    }

    /// Those of all lanes; `hits` are the barycentrics.
    #[inline(always)]
    pub(super) fn on_textures(&self, triangles: &TextureTriangles, hits: [&[f32; LANES]; 2]) -> TextureFootprints {
        let mut out = TextureFootprints::NONE;
        for lane in 0..LANES {
            let (one, is_inside) = self.of(lane, &triangles.of(lane), [hits[0][lane], hits[1][lane]]);
            for side in 0..2 {
                for k in 0..2 {
                    out.sides[side][k][lane] = one.sides[side][k];
                }
            }
            out.is_centered[lane] = one.is_centered;
            out.is_inside[lane] = is_inside;
        }
        out
    }

    /// The footprint of a lane, and whether its filter lies in the triangle. Without branches.
    #[inline(always)]
    fn of(&self, lane: usize, triangle: &TextureTriangle, hit: [f32; 2]) -> (TextureFootprint, bool) {
        let is_centered = (self.to_center[0][lane] == 0.0) & (self.to_center[1][lane] == 0.0);
        let reach_of_cell = if is_centered { 0.5 } else { REACH_AROUND_HITS };
        let mut out = TextureFootprint { sides: [[0.0; 2]; 2], is_centered };
        let mut center = [1.0 - hit[0] - hit[1], hit[0], hit[1]];
        let mut reach = [0.0; 3];
        for side in 0..2 {
            let [b, c] = triangle.change(&self.sides[side], lane);
            let change = [-b - c, b, c];
            for corner in 0..3 {
                center[corner] += change[corner] * self.to_center[side][lane];
                reach[corner] += change[corner].abs() * reach_of_cell;
            }
            for k in 0..2 {
                out.sides[side][k] = triangle.edges[0][k] * b + triangle.edges[1][k] * c;
            }
        }
        (out, (center[0] >= reach[0]) & (center[1] >= reach[1]) & (center[2] >= reach[2]))
    }
}

impl TextureTriangles {
    /// Sixteen times one triangle.
    #[inline(always)]
    pub fn splat(one: &TextureTriangle) -> Self {
        let mut out = Self { barycentrics: [[[0.0; LANES]; 3]; 2], edges: [[[0.0; LANES]; 2]; 2] };
        for k in 0..2 {
            for axis in 0..3 {
                out.barycentrics[k][axis] = [one.barycentrics[k][axis]; LANES];
            }
            for axis in 0..2 {
                out.edges[k][axis] = [one.edges[k][axis]; LANES];
            }
        }
        out
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, one: &TextureTriangle) {
        for k in 0..2 {
            for axis in 0..3 {
                self.barycentrics[k][axis][lane] = one.barycentrics[k][axis];
            }
            for axis in 0..2 {
                self.edges[k][axis][lane] = one.edges[k][axis];
            }
        }
    }

    #[inline(always)]
    fn of(&self, lane: usize) -> TextureTriangle {
        let mut out = TextureTriangle { barycentrics: [[0.0; 3]; 2], edges: [[0.0; 2]; 2] };
        for k in 0..2 {
            for axis in 0..3 {
                out.barycentrics[k][axis] = self.barycentrics[k][axis][lane];
            }
            for axis in 0..2 {
                out.edges[k][axis] = self.edges[k][axis][lane];
            }
        }
        out
    }
}

impl TextureTriangle {
    /// The triangle whose corners have these texture coordinates.
    #[inline(always)]
    pub fn new(geometry: &Geometry, triangle: Hit, coordinates: &[[f32; 2]; 3]) -> Self {
        let [a, b, c] = geometry.corners(triangle).map(Vec3::from);
        let (to_b, to_c) = (b - a, c - a);
        let normal = to_b.cross(to_c);
        let inverse = 1.0 / normal.length_squared();
        let barycentrics = [(to_c.cross(normal) * inverse).to_array(), (normal.cross(to_b) * inverse).to_array()];
        let [a, b, c] = coordinates;
        Self { barycentrics, edges: [[b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]] }
    }

    /// What the barycentrics of the second and third corner change by along one lane of `way`.
    #[inline(always)]
    fn change(&self, way: &[[f32; LANES]; 3], lane: usize) -> [f32; 2] {
        let mut out = [0.0; 2];
        for k in 0..2 {
            for axis in 0..3 {
                out[k] += self.barycentrics[k][axis] * way[axis][lane];
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Instancing;
    use holo_scene::{Instance, Material, Mesh, Scene, Transform};

    /// The footprint on a plane, seen by rays of a pinhole and by parallel rays, is the difference between the points where
    /// the rays through neighboring cells hit the plane. Texture coordinates are x and y there.
    #[test]
    fn footprints_are_differences_of_hit_points() {
        let place = |[x, y]: [f64; 2]| [x, y, -3.0 + 0.4 * x - 0.7 * y];
        let corners = [[-0.3, -0.2], [0.9, 0.1], [0.2, 0.8]];
        let positions = corners.map(|corner| place(corner).map(|x| x as f32)).to_vec();
        let texture_coordinates = corners.map(|corner| corner.map(|x| x as f32));
        let scene = Scene {
            meshes: vec![Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() }],
            instances: vec![Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY }],
            materials: vec![Material::default()],
            ..Scene::default()
        };
        let geometry = Geometry::build(&scene, &Transform::IDENTITY, Instancing::Never).expect("geometry");
        let triangle = TextureTriangle::new(&geometry, Hit::flattened(0), &texture_coordinates);
        // Where the ray from (x, y) in the direction (a, b, -1) hits the plane: its depth.
        let depth = |[x, y]: [f64; 2], [a, b]: [f64; 2]| (3.0 - 0.4 * x + 0.7 * y) / (1.0 + 0.4 * a - 0.7 * b);
        let hit = |origin: [f64; 2], direction: [f64; 2]| {
            let z = depth(origin, direction);
            [origin[0] + z * direction[0], origin[1] + z * direction[1]]
        };
        let length = (1.0 + 0.4f64.powi(2) + 0.7f64.powi(2)).sqrt();
        for (of_origin, of_direction) in [(0.0, 1e-4), (2e-4, 0.0)] {
            let (origin, direction) = ([0.05, -0.02], [0.03, 0.06]);
            let rays = ExactRays {
                origin_x: [origin[0]; LANES],
                origin_y: [origin[1]; LANES],
                direction_x: [direction[0]; LANES],
                direction_y: [direction[1]; LANES],
            };
            let normal = [-0.4, 0.7, 1.0].map(|x| [x / length; LANES]);
            let refined = Refined { depth: [depth(origin, direction); LANES], normal };
            let cells = RayDifferentials {
                origin_step: of_origin as f32,
                direction_step: of_direction as f32,
                to_center: [[0.5; LANES], [-0.25; LANES]],
            };
            let footprints = Footprints::new(&Cells::Squares(cells), &rays, &refined);
            let footprint = footprints.on_texture(5, &triangle, [0.3, 0.3]).expect("one inside the triangle");
            assert!(!footprint.is_centered);
            assert!(footprints.on_texture(5, &triangle, [0.9999, 0.0]).is_none(), "beyond the second corner");
            // Columns go to the right, rows down.
            let next = |columns: f64, rows: f64| {
                let at = |by: f64| [origin[0] + columns * by, origin[1] - rows * by];
                let to = |by: f64| [direction[0] + columns * by, direction[1] - rows * by];
                let [x, y] = hit(at(of_origin), to(of_direction));
                let [x0, y0] = hit(origin, direction);
                [x - x0, y - y0]
            };
            for (found, expected) in [(footprint.sides[0], next(1.0, 0.0)), (footprint.sides[1], next(0.0, 1.0))] {
                let size = expected[0].hypot(expected[1]);
                for k in 0..2 {
                    assert!((f64::from(found[k]) - expected[k]).abs() < 1e-3 * size, "{found:?}, {expected:?}");
                }
            }
        }
    }

    /// The spot of a sample of a plenoptic camera has the variances of the sum of a square on the sensor and of a part of a
    /// microlens, each as large as its rays are apart at the depth of the surface, and lies around its middle ray.
    #[test]
    fn spots_have_the_variances_of_both_parts() {
        let rays = ExactRays {
            origin_x: [0.0; LANES],
            origin_y: [0.0; LANES],
            direction_x: [0.0; LANES],
            direction_y: [0.0; LANES],
        };
        let refined = Refined { depth: [2.0; LANES], normal: [[0.0; LANES], [0.0; LANES], [1.0; LANES]] };
        let cells = Cells::Spots(SpotDifferentials {
            on_sensor: [[3e-3; LANES], [-1e-3; LANES]],
            on_lens: [[-0.5; LANES], [1.25; LANES]],
            lens_part: [[9e-6; LANES], [4e-6; LANES], [-2e-6; LANES]],
            to_center: [[[1e-4; LANES], [0.0; LANES]], [[0.0; LANES], [-2e-4; LANES]]],
        });
        let footprints = Footprints::new(&cells, &rays, &refined);
        let side = |k: usize| footprints.sides[k].map(|axis| f64::from(axis[3]));
        let (first, second) = (side(0), side(1));
        // 3e-3 - 2 * 1e-3 on the sensor, -0.5 + 2 * 1.25 = 2 on the lens.
        let of = |a: usize, b: usize| first[a] * first[b] + second[a] * second[b];
        for (found, expected) in
            [(of(0, 0), 1e-6 + 36e-6), (of(1, 1), 1e-6 + 16e-6), (of(0, 1), -8e-6), (of(2, 2), 0.0)]
        {
            assert!((found - expected).abs() < 1e-11, "{found} {expected}");
        }
        let [along, up] = [0, 1].map(|k| f64::from(footprints.to_center[k][3]));
        for (axis, expected) in [1e-4, -4e-4].into_iter().enumerate() {
            let found = along * first[axis] + up * second[axis];
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}
