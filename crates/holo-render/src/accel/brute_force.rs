//! The reference engine: tests every ray against every triangle in f64.

use std::sync::Arc;

use glam::DVec3;

use super::{Coherence, Engine, NO_TRIANGLE, RayHits, Rays};
use crate::geometry::{self, Geometry};
use crate::simd::{LANES, Lanes};

/// The reference engine, for tests.
pub(crate) struct BruteForce {
    geometry: Arc<Geometry>,
}

struct Hit {
    t: f64,
    u: f64,
    v: f64,
    triangle: u32,
}

impl BruteForce {
    pub fn build(geometry: &Arc<Geometry>) -> Self {
        Self { geometry: Arc::clone(geometry) }
    }

    /// The nearest hit of one ray; of two hits at the same distance, the triangle with the lower index.
    fn nearest(&self, rays: &Rays, lane: usize) -> Option<Hit> {
        let [origin, direction] =
            [&rays.origin, &rays.direction].map(|x| DVec3::from(x.map(|axis| f64::from(axis[lane]))));
        let (near, far) = (f64::from(rays.near[lane]), f64::from(rays.far[lane]));
        let mut best: Option<Hit> = None;
        for triangle in 0..self.geometry.triangles().len() {
            let [a, b, c] =
                self.geometry.corners(geometry::Hit::flattened(triangle)).map(|p| DVec3::from(p.map(f64::from)));
            // Moeller and Trumbore (1997), both sides.
            let (e1, e2) = (b - a, c - a);
            let p = direction.cross(e2);
            let determinant = e1.dot(p);
            if determinant == 0.0 {
                continue;
            }
            let s = origin - a;
            let q = s.cross(e1);
            let (u, v, t) = (s.dot(p) / determinant, direction.dot(q) / determinant, e2.dot(q) / determinant);
            let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
            if inside && t > near && t < best.as_ref().map_or(far, |h| h.t) {
                best = Some(Hit { t, u, v, triangle: triangle as u32 });
            }
        }
        best
    }
}

impl Engine for BruteForce {
    fn intersect(&self, valid: &Lanes<i32>, packet: &mut RayHits, _: Coherence) {
        for lane in (0..LANES).filter(|&lane| valid.0[lane] != 0) {
            packet.hits.triangle[lane] = NO_TRIANGLE;
            if let Some(hit) = self.nearest(&packet.rays, lane) {
                packet.rays.far[lane] = hit.t as f32;
                packet.hits.u[lane] = hit.u as f32;
                packet.hits.v[lane] = hit.v as f32;
                packet.hits.triangle[lane] = hit.triangle;
                packet.hits.geometry[lane] = 0;
            }
        }
    }

    fn occluded(&self, valid: &Lanes<i32>, rays: &mut Rays, _: Coherence) {
        for lane in (0..LANES).filter(|&lane| valid.0[lane] != 0) {
            if self.nearest(rays, lane).is_some() {
                rays.far[lane] = f32::NEG_INFINITY;
            }
        }
    }

    fn name(&self) -> &str {
        "brute force f64"
    }
}
