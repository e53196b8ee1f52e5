//! Surface interactions: sixteen hit points with their normals and base colors.
//!
//! The engine determines which triangle a ray hits. The intersection with the plane of that triangle is computed in
//! f64, both for camera rays ([`crate::accel::refine`]) and for scattered rays, so that new rays start on the surface.

use crate::accel::refine::Refined;
use crate::accel::{Cells, ExactRays, NO_TRIANGLE, RayHits};
use crate::geometry::{Geometry, Hit};
use crate::material::{Appearance, Footprints, MaterialFlags, PacketHits};
use crate::simd::{LANES, at};

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
    position: [[f32; LANES]; 3],
    normal: [[f64; LANES]; 3],
    /// Normal times direction: negative if the ray hit the front.
    towards: [f64; LANES],
    /// The footprints of the rays, for filtered textures.
    pub footprints: Option<Footprints>,
}

/// The offset of new rays, relative to the largest coordinate. An f32 position has an error of at most 2^-24 of the
/// largest coordinate, and a few such errors add up between the refined point, the rounded vertices and the arithmetic
/// of the engine; eight of them avoid self-intersection. Where two walls meet this is not enough: the offset of a hit
/// on one wall may place the start behind the other. The start is therefore also moved back along the incident ray by
/// the same distance.
const OFFSET_PER_COORDINATE: f32 = 8.0 / 16_777_216.0;

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

impl SurfaceInteraction {
    /// The surface interactions of the hits of `packet`, or `None` without any hit. (Invalid lanes have no hit.)
    #[inline(always)]
    pub fn new(appearance: &Appearance, geometry: &Geometry, packet: &RayHits, points: &HitPoints) -> Option<Self> {
        let some = packet.hit(packet.hits.triangle.iter().position(|&k| k != NO_TRIANGLE)?);
        let zero = [[0.0; LANES]; 3];
        let mut out = Self {
            hit: [false; LANES],
            position: points.position,
            start: zero,
            geometric_normal: zero,
            shading_normal: zero,
            side: [1.0; LANES],
            triangle: [some; LANES],
            flags: [MaterialFlags::default(); LANES],
            any_flags: MaterialFlags::default(),
            base_color: zero,
        };
        // Lanes without a hit read the triangle of another lane: branch-free loops with unused results.
        let mut triangles = [some; LANES];
        for lane in 0..LANES {
            out.hit[lane] = packet.hits.triangle[lane] != NO_TRIANGLE;
            triangles[lane] = if out.hit[lane] { packet.hit(lane) } else { some };
        }
        for lane in 0..LANES {
            out.side[lane] = if points.towards[lane] > 0.0 { -1.0 } else { 1.0 };
            for axis in 0..3 {
                out.geometric_normal[axis][lane] = points.normal[axis][lane] as f32 * out.side[lane];
            }
        }
        let hits = PacketHits { geometry, packet, footprints: points.footprints.as_ref() };
        let extent = appearance.fill_interaction(&hits, &triangles, &mut out);
        for lane in 0..LANES {
            let [x, y, z] = at(&out.position, lane);
            let offset = extent[lane].max(x.abs()).max(y.abs()).max(z.abs()) * OFFSET_PER_COORDINATE;
            let direction = at(&packet.rays.direction, lane);
            let [x, y, z] = direction;
            let back = offset / (x * x + y * y + z * z).sqrt();
            for axis in 0..3 {
                let off = out.geometric_normal[axis][lane] * offset - direction[axis] * back;
                out.start[axis][lane] = out.position[axis][lane] + off;
            }
        }
        Some(out)
    }
}
