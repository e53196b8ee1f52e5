//! Where rays meet the scene: sixteen points with their normals and base colours.
//!
//! The engine says which triangle a ray hits. Where the ray meets that triangle's plane is computed in f64, for camera
//! rays ([`crate::accel::refine`]) and for scattered ones alike, so that a new ray starts on the surface and not beside it.

use crate::accel::refine::Refined;
use crate::accel::{ExactRays, NO_TRIANGLE, RayHits};
use crate::geometry::{Geometry, Hit};
use crate::material::{Appearance, Kinds};
use crate::simd::{LANES, at};

/// Sixteen surface points in camera coordinates. What lanes without a hit hold means nothing.
pub(crate) struct Surfaces {
    pub hit: [bool; LANES],
    pub position: [[f32; LANES]; 3],
    /// Where rays on the side of the arriving one start: the hit, moved off the surface so that they do not meet it again, and back
    /// along the arriving ray so that they do not start behind another one.
    pub start: [[f32; LANES]; 3],
    /// Unit normal of the triangle on the side that the ray came from.
    pub geometric_normal: [[f32; LANES]; 3],
    /// Interpolated unit normal, turned to the same side together with the geometric one.
    pub shading_normal: [[f32; LANES]; 3],
    /// 1 where the ray came to the front, -1 where to the back.
    pub side: [f32; LANES],
    /// The triangles; of lanes without a hit that of another lane.
    pub triangle: [Hit; LANES],
    /// What their materials have.
    pub kinds: [Kinds; LANES],
    /// What any of them has.
    pub any: Kinds,
    /// Base colour: factor, texture and vertex colours, linear RGB.
    pub base_color: [[f32; LANES]; 3],
}

/// Sixteen points where rays end, and the triangles' unit normals there.
pub(crate) struct HitPoints {
    position: [[f32; LANES]; 3],
    normal: [[f64; LANES]; 3],
    /// Normal times direction: below 0 on the front.
    towards: [f64; LANES],
}

/// An f32 position is off by at most 2^-24 of the largest coordinate involved; a few such errors add up between the
/// refined point, the engine's rounded vertices and its own arithmetic. Eight of them keep clear of the surface. Where two walls
/// meet that is not enough: a hit on the one within rounding of the other could start behind that, and see what lies outside (of ten
/// million samples of a closed room one to five did). Where the ray came from lies before both, so as much is gone back along it.
const OFFSET_PER_COORDINATE: f32 = 8.0 / 16_777_216.0;

/// A scattered ray's refined length may leave the engine's by this much, relatively; as for camera rays.
const LARGEST_CORRECTION: f64 = 1e-3;

impl HitPoints {
    /// Nowhere.
    pub const NONE: Self = Self { position: [[0.0; LANES]; 3], normal: [[0.0; LANES]; 3], towards: [0.0; LANES] };

    /// Where the camera's rays end.
    #[inline(always)]
    pub fn primary(rays: &ExactRays, refined: &Refined) -> Self {
        let mut points = Self { normal: refined.normal, ..Self::NONE };
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

    /// Where rays from anywhere end.
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
            let length = if (exact - found).abs() <= LARGEST_CORRECTION * found { exact } else { found };
            for axis in 0..3 {
                let position = f64::from(origin[axis][lane]) + length * f64::from(direction[axis][lane]);
                points.position[axis][lane] = position as f32;
            }
            points.towards[lane] = towards;
        }
        points
    }
}

impl Surfaces {
    /// The surfaces that `packet` hit, or `None` if it hit nothing. (Lanes that are not valid have no hit.)
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
            kinds: [Kinds::default(); LANES],
            any: Kinds::default(),
            base_color: zero,
        };
        // Lanes without a hit look at a triangle of another lane: loops without branches, results that nobody reads.
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
        let extent = appearance.look_up(geometry, packet, &triangles, &mut out);
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
