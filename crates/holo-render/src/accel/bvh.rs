//! The built-in engine: an eight-wide compressed BVH in pure Rust (obvhs) with the watertight triangle test of
//! [`super::triangle`] and distances in f64.
//!
//! The tree only proposes triangles. Three measures keep the rounding of its arithmetic out of the result:
//! - Bounding boxes are enlarged by more than the rounding error.
//! - The scene is scaled to about 2^40 (by a power of two, which is exact), because the tree ignores hits nearer than
//!   1e-4.
//! - The distance of a hit is computed from the plane of the triangle in f64. On sliver triangles the distance of an
//!   f32 test has an error that is much larger than the offset of shadow rays from their surface.

use std::sync::Arc;
use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};

use super::triangle::{ShearedRay, TriangleHit};
use super::{Coherence, Engine, NO_TRIANGLE, RayHits, Rays};
use crate::geometry::{Geometry, Hit};
use crate::simd::{LANES, Lanes, at};

/// The BVH engine.
pub(crate) struct Bvh {
    /// `None` for a scene without triangles: obvhs has no empty tree.
    tree: Option<CwBvh>,
    /// Corners in the order of the leaves, so that a leaf reads contiguous memory.
    corners: Vec<[[f32; 3]; 3]>,
    geometry: Arc<Geometry>,
    /// Positions in the tree are positions in the scene times this power of two.
    scale: f32,
}

/// The enlargement of bounding boxes, relative to the largest coordinate: 16 units of f32 rounding.
const BOX_MARGIN: f32 = 16.0 / 16_777_216.0;

/// The largest coordinate in the tree lies below two to this power: far above the threshold of the tree, and small
/// enough that products of two coordinates do not overflow f32.
const TREE_EXPONENT: i32 = 40;

impl Bvh {
    pub fn build(geometry: &Arc<Geometry>) -> Self {
        let count = geometry.triangles().len();
        if count == 0 {
            return Self { tree: None, corners: Vec::new(), geometry: Arc::clone(geometry), scale: 1.0 };
        }
        let largest = geometry.positions().iter().flatten().fold(0.0f32, |m, x| m.max(x.abs()));
        let scale = power_of_two((TREE_EXPONENT - exponent(largest)).clamp(-126, 126));
        // Errors also grow with the coordinates of the ray, so the largest coordinate of the scene determines the
        // margin.
        let margin = Vec3A::splat(largest * scale * BOX_MARGIN);
        let boxes: Vec<Aabb> = (0..count)
            .map(|k| {
                let bounds = Aabb::from_points(&geometry.corners(Hit::flattened(k)).map(|p| Vec3A::from(p) * scale));
                Aabb::new(bounds.min - margin, bounds.max + margin)
            })
            .collect();
        let tree = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let corners = tree.primitive_indices.iter().map(|&k| geometry.corners(Hit::flattened(k as usize))).collect();
        Self { tree: Some(tree), corners, geometry: Arc::clone(geometry), scale }
    }

    /// A ray in scene coordinates and in tree coordinates.
    fn prepare(&self, rays: &Rays, lane: usize) -> TreeRay {
        let origin = at(&rays.origin, lane);
        // `+ 0.0` turns -0 into 0. The box test of the tree treats -0 inconsistently.
        let direction = at(&rays.direction, lane).map(|x| x + 0.0);
        let largest = direction.iter().fold(0.0f32, |m, x| m.max(x.abs()));
        let stretch = power_of_two(-exponent(largest).clamp(-126, 126));
        // origin + t direction, times `scale`: the same point at t * scale / stretch along the stretched direction.
        let to_tree = self.scale / stretch;
        TreeRay {
            sheared: ShearedRay::new(origin, direction),
            exact: [origin.map(f64::from), direction.map(f64::from)],
            near: rays.near[lane],
            far: rays.far[lane],
            ray: Ray::new(
                Vec3A::from(origin) * self.scale,
                Vec3A::from(direction) * stretch,
                0.0,
                rays.far[lane] * to_tree,
            ),
            to_tree,
        }
    }

    /// The hit of the ray on the triangle of a leaf, if within (near, far).
    #[inline(always)]
    fn intersect_leaf(&self, ray: &TreeRay, leaf: usize, triangle: u32) -> Option<TriangleHit> {
        let hit = ray.sheared.intersect(&self.corners[leaf])?;
        let plane = self.geometry.plane(Hit::flattened(triangle as usize));
        let [o, d] = &ray.exact;
        let n = &plane.normal;
        let exact =
            (plane.offset - (n[0] * o[0] + n[1] * o[1] + n[2] * o[2])) / (n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
        // The plane of an edge-on triangle gives no distance; the f32 distance is used then.
        let t = if exact.is_finite() { exact as f32 } else { hit.t };
        (t > ray.near && t < ray.far).then_some(TriangleHit { t, ..hit })
    }
}

/// A ray in scene coordinates and in tree coordinates.
struct TreeRay {
    sheared: ShearedRay,
    /// Origin and direction.
    exact: [[f64; 3]; 2],
    near: f32,
    far: f32,
    ray: Ray,
    /// Ray parameters in the tree over those in the scene.
    to_tree: f32,
}

impl Engine for Bvh {
    fn intersect(&self, valid: &Lanes<i32>, packet: &mut RayHits, _: Coherence) {
        for lane in (0..LANES).filter(|&lane| valid.0[lane] != 0) {
            packet.hits.triangle[lane] = NO_TRIANGLE;
            let Some(tree) = &self.tree else { continue };
            let ray = self.prepare(&packet.rays, lane);
            let mut nearest: Option<(TriangleHit, u32)> = None;
            tree.ray_traverse(ray.ray, &mut RayHit::none(), |_, leaf| {
                let triangle = tree.primitive_indices[leaf];
                let Some(hit) = self.intersect_leaf(&ray, leaf, triangle) else { return f32::INFINITY };
                // Of two triangles at the same distance the one with the lower index wins, for any tree.
                if nearest.is_none_or(|(best, k)| hit.t < best.t || (hit.t == best.t && triangle < k)) {
                    nearest = Some((hit, triangle));
                }
                // The next larger value, so that the tree does not skip another triangle at the same distance.
                (hit.t * ray.to_tree).next_up()
            });
            if let Some((hit, triangle)) = nearest {
                packet.rays.far[lane] = hit.t;
                packet.hits.u[lane] = hit.u;
                packet.hits.v[lane] = hit.v;
                packet.hits.triangle[lane] = triangle;
                packet.hits.geometry[lane] = 0;
            }
        }
    }

    fn occluded(&self, valid: &Lanes<i32>, rays: &mut Rays, _: Coherence) {
        let Some(tree) = &self.tree else { return };
        for lane in (0..LANES).filter(|&lane| valid.0[lane] != 0) {
            let ray = self.prepare(rays, lane);
            let clear = tree.ray_traverse_miss(ray.ray, |_, leaf| {
                match self.intersect_leaf(&ray, leaf, tree.primitive_indices[leaf]) {
                    Some(_) => 0.0,
                    None => f32::INFINITY,
                }
            });
            if !clear {
                rays.far[lane] = f32::NEG_INFINITY;
            }
        }
    }

    fn name(&self) -> &str {
        "bvh"
    }
}

/// The power of two just above a positive number; 0 for 0.
fn exponent(x: f32) -> i32 {
    if x > 0.0 { x.log2().floor() as i32 + 1 } else { 0 }
}

/// Two to a power between -126 and 127, exactly.
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}
