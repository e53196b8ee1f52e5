//! Surface interactions: sixteen hit points with their normals and base colors.
//!
//! The engine determines which triangle a ray hits. The intersection with the plane of that triangle is computed in
//! f64, both for camera rays ([`crate::accel::refine`]) and for scattered rays, so that new rays start on the surface.

use crate::accel::refine::Refined;
use crate::accel::{Cells, ExactRays, NO_TRIANGLE, RayHits};
use crate::geometry::{Geometry, Hit};
use crate::material::{Footprints, MaterialFlags};
use crate::simd::LANES;

/// Sixteen surface interactions in camera coordinates. The values of lanes without a hit are unspecified.
pub(crate) struct SurfaceInteraction {
    pub hit: [bool; LANES],
    pub position: [[f32; LANES]; 3],
    /// The start of new rays on the side of the incident ray: the hit point, offset from the surface to avoid
    /// self-intersection, and back along the incident ray so that it is not behind another surface.
    pub start: [[f32; LANES]; 3],
    /// The unit normal of the triangle on the side of the incident ray.
    pub geometric_normal: [[f32; LANES]; 3],
    /// The shading normal: interpolated, unit length, flipped together with the geometric normal.
    pub shading_normal: [[f32; LANES]; 3],
    /// 1 if the ray hit the front, -1 if it hit the back.
    pub side: [f32; LANES],
    /// The triangles; lanes without a hit repeat the triangle of another lane.
    pub triangle: [Hit; LANES],
    /// The features of the materials.
    pub flags: [MaterialFlags; LANES],
    /// The features of all lanes together.
    pub any_flags: MaterialFlags,
    /// Base color: factor, texture and vertex colors, linear RGB.
    pub base_color: [[f32; LANES]; 3],
}

/// The hit points of sixteen rays, and the unit normals of the triangles.
pub(crate) struct HitPoints {
    pub(super) position: [[f32; LANES]; 3],
    pub(super) normal: [[f64; LANES]; 3],
    /// Normal times direction: negative if the ray hit the front.
    pub(super) towards: [f64; LANES],
    /// The footprints of the rays, for filtered textures.
    pub footprints: Option<Footprints>,
}

/// The maximum relative difference between the refined length of a scattered ray and that of the engine; as for camera
/// rays.
const MAX_RELATIVE_CORRECTION: f64 = 1e-3;

impl HitPoints {
    /// No hits.
    pub const NONE: Self =
        Self { position: [[0.0; LANES]; 3], normal: [[0.0; LANES]; 3], towards: [0.0; LANES], footprints: None };

    /// The hit points of camera rays, with the footprints of `cells` of their pixels.
    #[inline(always)]
    pub fn primary(rays: &ExactRays, refined: &Refined, cells: Option<&Cells>) -> Self {
        let footprints = cells.map(|cells| Footprints::new(cells, rays, refined));
        let mut points = Self { normal: refined.normal, footprints, ..Self::NONE };
        for lane in 0..LANES {
            let z = refined.depth[lane];
            points.position[0][lane] = (rays.origin_x[lane] + z * rays.direction_x[lane]) as f32;
            points.position[1][lane] = (rays.origin_y[lane] + z * rays.direction_y[lane]) as f32;
            points.position[2][lane] = -z as f32;
            let [x, y, z] = [refined.normal[0][lane], refined.normal[1][lane], refined.normal[2][lane]];
            points.towards[lane] = x * rays.direction_x[lane] + y * rays.direction_y[lane] - z;
        }
        points
    }

    /// The hit points of scattered rays.
    #[inline(always)]
    pub fn secondary(geometry: &Geometry, packet: &RayHits) -> Self {
        let mut points = Self::NONE;
        let mut offset = [0.0; LANES];
        for lane in 0..LANES {
            if packet.hits.triangle[lane] != NO_TRIANGLE {
                let plane = geometry.plane(packet.hit(lane));
                for axis in 0..3 {
                    points.normal[axis][lane] = plane.normal[axis];
                }
                offset[lane] = plane.offset;
            }
        }
        let (origin, direction) = (&packet.rays.origin, &packet.rays.direction);
        for lane in 0..LANES {
            let [mut towards, mut away] = [0.0, offset[lane]];
            for axis in 0..3 {
                towards += points.normal[axis][lane] * f64::from(direction[axis][lane]);
                away -= points.normal[axis][lane] * f64::from(origin[axis][lane]);
            }
            let (exact, found) = (away / towards, f64::from(packet.rays.far[lane]));
            let length = if (exact - found).abs() <= MAX_RELATIVE_CORRECTION * found { exact } else { found };
            for axis in 0..3 {
                let position = f64::from(origin[axis][lane]) + length * f64::from(direction[axis][lane]);
                points.position[axis][lane] = position as f32;
            }
            points.towards[lane] = towards;
        }
        points
    }
}
