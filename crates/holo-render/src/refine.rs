//! Depth to f64: the ray of a hit against the plane of the triangle that it hit.
//!
//! An engine decides in f32 *which* triangle is hit; where the exact ray meets that triangle's plane is computed anew in
//! f64 from f64 positions. With rays whose z component is -1 the ray parameter is planar depth.

use crate::accel::{LANES, NO_TRIANGLE, RayHits};
use crate::geometry::{Geometry, Plane};
use crate::primary::ExactRays;

/// A refined depth may leave the engine's by this much, relatively; beyond it the ray grazes the plane, the plane says
/// nothing about the triangle any more, and the engine's depth stays.
const LARGEST_CORRECTION: f64 = 1e-3;

/// Planar depth (m) of every lane's hit; +infinity where nothing is hit.
///
/// # Accuracy
/// About 1e-15 * (distance of the triangle / distance along the normal), so 1e-12 unless the ray grazes.
#[inline(always)]
pub(crate) fn depths(geometry: &Geometry, packet: &RayHits, rays: &ExactRays) -> [f64; LANES] {
    let triangles = &packet.hits.triangle;
    let planes = geometry.planes();
    let mut depth = [f64::INFINITY; LANES];
    let first = triangles[0];
    if triangles.iter().all(|&k| k == first) {
        // Most packets hit one triangle: its plane is a constant of the loop.
        if first != NO_TRIANGLE {
            let plane = planes[first as usize];
            for lane in 0..LANES {
                depth[lane] = refine(&plane, rays, lane, packet.rays.far[lane]);
            }
        }
        return depth;
    }
    let mut normal = [[0.0; LANES]; 3];
    let mut offset = [0.0; LANES];
    for lane in 0..LANES {
        if triangles[lane] != NO_TRIANGLE {
            let plane = &planes[triangles[lane] as usize];
            for axis in 0..3 {
                normal[axis][lane] = plane.normal[axis];
            }
            offset[lane] = plane.offset;
        }
    }
    for lane in 0..LANES {
        let plane = Plane { normal: [normal[0][lane], normal[1][lane], normal[2][lane]], offset: offset[lane] };
        // A lane without hit has a zero plane and an infinite `far`: both give +infinity.
        depth[lane] = refine(&plane, rays, lane, packet.rays.far[lane]);
    }
    depth
}

#[inline(always)]
fn refine(plane: &Plane, rays: &ExactRays, lane: usize, found: f32) -> f64 {
    let [x, y, z] = plane.normal;
    let towards = x * rays.direction_x[lane] + y * rays.direction_y[lane] - z;
    let away = plane.offset - (x * rays.origin_x[lane] + y * rays.origin_y[lane]);
    let exact = away / towards;
    let found = f64::from(found);
    // Written so that NaN and infinity fail the comparison.
    if (exact - found).abs() <= LARGEST_CORRECTION * found { exact } else { found }
}
