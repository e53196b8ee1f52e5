//! Refinement of depth to f64: the intersection of the exact ray with the plane of the hit triangle.
//!
//! An engine decides in f32 *which* triangle is hit. The intersection of the exact ray with the plane of that triangle
//! is then computed in f64 from f64 positions. Rays have a z component of -1, so the ray parameter is planar depth.

use crate::accel::{ExactRays, NO_TRIANGLE, RayHits};
use crate::geometry::Geometry;
use crate::simd::LANES;

/// The maximum relative difference between the refined depth and that of the engine. If it is larger, the ray grazes
/// the plane, its intersection with the plane is ill-conditioned, and the depth of the engine is kept.
const MAX_RELATIVE_CORRECTION: f64 = 1e-3;

/// The refined hits of sixteen rays.
pub(crate) struct Refined {
    /// Planar depth, m; +infinity where nothing is hit.
    pub depth: [f64; LANES],
    /// The unit normals of the triangles in camera coordinates; 0 where nothing is hit.
    pub normal: [[f64; LANES]; 3],
}

/// Refines the hits of `packet`, whose exact rays are `rays`.
///
/// # Accuracy
/// A relative error of about 1e-15 * (distance of the triangle / distance along its normal): below 1e-10 unless the ray
/// is grazing.
#[inline(always)]
pub(crate) fn refine(geometry: &Geometry, packet: &RayHits, rays: &ExactRays) -> Refined {
    let triangles = &packet.hits.triangle;
    let mut normal = [[0.0; LANES]; 3];
    let mut offset = [0.0; LANES];
    let first = packet.hit(0);
    let one_placement = !geometry.is_instanced() || packet.hits.instance.iter().all(|&k| k == first.placement);
    if triangles.iter().all(|&k| k == first.triangle) && one_placement {
        // Most packets hit a single triangle, whose plane is read once.
        if first.triangle != NO_TRIANGLE {
            let plane = geometry.plane(first);
            for axis in 0..3 {
                normal[axis] = [plane.normal[axis]; LANES];
            }
            offset = [plane.offset; LANES];
        }
    } else {
        for lane in 0..LANES {
            if triangles[lane] != NO_TRIANGLE {
                let plane = geometry.plane(packet.hit(lane));
                for axis in 0..3 {
                    normal[axis][lane] = plane.normal[axis];
                }
                offset[lane] = plane.offset;
            }
        }
    }
    let mut depth = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y, z] = [normal[0][lane], normal[1][lane], normal[2][lane]];
        let towards = x * rays.direction_x[lane] + y * rays.direction_y[lane] - z;
        let away = offset[lane] - (x * rays.origin_x[lane] + y * rays.origin_y[lane]);
        let exact = away / towards;
        // Infinite without a hit; the comparison fails for it, and for a plane that gives NaN.
        let found = f64::from(packet.rays.far[lane]);
        depth[lane] = if (exact - found).abs() <= MAX_RELATIVE_CORRECTION * found { exact } else { found };
    }
    Refined { depth, normal }
}

#[cfg(test)]
mod tests;
