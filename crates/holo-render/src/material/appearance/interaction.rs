//! Surface interactions of the hits of a packet: normals, base colors and the starts of new rays.

use super::{Appearance, PacketHits};
use crate::accel::{NO_TRIANGLE, RayHits};
use crate::geometry::Geometry;
use crate::material::MaterialFlags;
use crate::material::surface::{HitPoints, SurfaceInteraction};
use crate::simd::{LANES, at};

/// The offset of new rays, relative to the largest coordinate. An f32 position has an error of at most 2^-24 of the
/// largest coordinate, and a few such errors add up between the refined point, the rounded vertices and the arithmetic
/// of the engine; eight of them avoid self-intersection. Where two walls meet this is not enough: the offset of a hit
/// on one wall may place the start behind the other. The start is therefore also moved back along the incident ray by
/// the same distance.
const OFFSET_PER_COORDINATE: f32 = 8.0 / 16_777_216.0;

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
