//! The engine that is always there: an eight-wide compressed BVH in pure Rust (obvhs) with the watertight triangle test
//! of [`super::triangle`].

use std::sync::Arc;
use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};

use super::triangle::{ShearedRay, TriangleHit};
use super::{Coherence, Engine, LANES, Lanes, NO_TRIANGLE, RayHits, Rays};
use crate::geometry::Geometry;

/// How much boxes grow, over the largest coordinate: 16 roundings of f32.
const BOX_MARGIN: f32 = 16.0 / 16_777_216.0;

/// The pure-Rust engine.
pub(crate) struct Bvh {
    /// `None` for a scene without triangles: obvhs has no empty tree.
    tree: Option<CwBvh>,
    /// Corners in the order of the tree's leaves, so that a leaf reads neighbours.
    corners: Vec<[[f32; 3]; 3]>,
}

impl Bvh {
    pub fn build(geometry: &Arc<Geometry>) -> Self {
        let count = geometry.triangles().len();
        if count == 0 {
            return Self { tree: None, corners: Vec::new() };
        }
        // The tree's box test rounds either way; boxes that are larger than any such error make it conservative, and the
        // triangle test decides. Errors grow with the coordinates of the ray as well, so the whole scene sets the margin.
        let largest = geometry.positions().iter().flatten().fold(0.0f32, |m, x| m.max(x.abs()));
        let margin = Vec3A::splat(largest * BOX_MARGIN);
        let boxes: Vec<Aabb> = (0..count)
            .map(|k| {
                let bounds = Aabb::from_points(&geometry.corners(k).map(Vec3A::from));
                Aabb::new(bounds.min - margin, bounds.max + margin)
            })
            .collect();
        let tree = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let corners = tree.primitive_indices.iter().map(|&k| geometry.corners(k as usize)).collect();
        Self { tree: Some(tree), corners }
    }

    fn ray(rays: &Rays, lane: usize) -> (Ray, ShearedRay) {
        let origin = rays.origin.map(|axis| axis[lane]);
        // `+ 0.0` turns -0 into 0, which the tree's box test would take for a negative number in one place and for a
        // positive one in another.
        let direction = rays.direction.map(|axis| axis[lane] + 0.0);
        let ray = Ray::new(origin.into(), direction.into(), rays.near[lane], rays.far[lane]);
        (ray, ShearedRay::new(origin, direction))
    }
}

impl Engine for Bvh {
    fn intersect(&self, valid: &Lanes<i32>, packet: &mut RayHits) {
        for lane in (0..LANES).filter(|&lane| valid.0[lane] != 0) {
            packet.hits.triangle[lane] = NO_TRIANGLE;
            let Some(tree) = &self.tree else { continue };
            let (ray, sheared) = Self::ray(&packet.rays, lane);
            let mut nearest: Option<(TriangleHit, u32)> = None;
            tree.ray_traverse(ray, &mut RayHit::none(), |ray, leaf| {
                let triangle = tree.primitive_indices[leaf];
                // Two triangles at the same distance: the one that comes first in the scene wins, in any tree.
                let far = ray.tmax.next_up();
                let Some(hit) = sheared.intersect(&self.corners[leaf], ray.tmin, far) else { return f32::INFINITY };
                if nearest.is_none_or(|(best, k)| hit.t < best.t || (hit.t == best.t && triangle < k))
                    && hit.t < packet.rays.far[lane]
                {
                    nearest = Some((hit, triangle));
                }
                hit.t
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
            let (ray, sheared) = Self::ray(rays, lane);
            let clear = tree.ray_traverse_miss(ray, |ray, leaf| {
                sheared.intersect(&self.corners[leaf], ray.tmin, ray.tmax).map_or(f32::INFINITY, |hit| hit.t)
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
