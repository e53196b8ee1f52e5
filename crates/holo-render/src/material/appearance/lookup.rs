//! Evaluation of normals and base colors at the sixteen hits of a packet.
//!
//! The camera rays of a packet mostly hit a single instance, and hits of scattered rays are sorted by instance: its material
//! is then read once, and its texture is sampled by all lanes together. Otherwise (foliage, the last hits of one instance
//! beside the first of the next) the lanes are evaluated one by one. Both ways give bitwise identical results.

use super::{Appearance, SurfacePoint, TextureLookup, texture_triangle};
use crate::accel::RayHits;
use crate::geometry::{Geometry, Hit, InstanceData};
use crate::material::MaterialFlags;
use crate::material::SurfaceInteraction;
use crate::material::footprint::{Footprints, TextureTriangles};
use crate::material::texture::{self, FootprintFilters, Pyramid};
use crate::simd::LANES;

/// The hits of a packet on the triangles of a geometry.
#[derive(Clone, Copy)]
pub(crate) struct PacketHits<'a> {
    pub geometry: &'a Geometry,
    pub packet: &'a RayHits,
    /// The footprints of camera rays, if textures are filtered.
    pub footprints: Option<&'a Footprints>,
}

/// Vertex normals of sixteen triangles.
struct Normals {
    smooth: [bool; LANES],
    any: bool,
    corners: [[[f32; LANES]; 3]; 3],
}

impl Normals {
    #[inline(always)]
    fn set(&mut self, lane: usize, normals: &[[f32; 3]; 3]) {
        for corner in 0..3 {
            for axis in 0..3 {
                self.corners[corner][axis][lane] = normals[corner][axis];
            }
        }
        self.smooth[lane] = true;
        self.any = true;
    }

    /// Interpolates the shading normals, on the side from which the rays came.
    #[inline(always)]
    fn interpolate(&self, packet: &RayHits, out: &mut SurfaceInteraction) {
        for lane in 0..LANES {
            let (b, c) = (packet.hits.u[lane], packet.hits.v[lane]);
            let a = 1.0 - b - c;
            let mut normal = [0.0; 3];
            for axis in 0..3 {
                let [x, y, z] = [&self.corners[0][axis], &self.corners[1][axis], &self.corners[2][axis]];
                normal[axis] = x[lane] * a + y[lane] * b + z[lane] * c;
            }
            let squared = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
            let unit = out.side[lane] / squared.sqrt();
            // If the interpolated normal vanishes, the normal of the triangle is used.
            let usable = self.smooth[lane] & (squared > 1e-12);
            for axis in 0..3 {
                let flat = out.geometric_normal[axis][lane];
                out.shading_normal[axis][lane] = if usable { normal[axis] * unit } else { flat };
            }
        }
    }
}

impl Appearance {
    /// Sets triangles, flags, base colors and shading normals of `out`; returns the error bounds
    /// [`Geometry::extent`] of the triangles.
    #[inline(always)]
    pub fn fill_interaction(
        &self,
        hits: &PacketHits,
        triangles: &[Hit; LANES],
        out: &mut SurfaceInteraction,
    ) -> [f32; LANES] {
        let &PacketHits { geometry, packet, .. } = hits;
        let mut normals = Normals { smooth: [false; LANES], any: false, corners: [[[0.0f32; LANES]; 3]; 3] };
        out.triangle = *triangles;
        match common_instance(geometry, triangles) {
            Some((instance, one_triangle)) => {
                let instance = geometry.instance(instance);
                self.fill_from_one_instance(hits, instance, one_triangle, out, &mut normals);
            }
            None => self.fill_lane_by_lane(hits, out, &mut normals),
        }
        let mut extent = [0.0; LANES];
        for lane in 0..LANES {
            extent[lane] = geometry.extent(triangles[lane]);
        }
        out.shading_normal = out.geometric_normal;
        if normals.any {
            normals.interpolate(packet, out);
        }
        if out.any_flags.has(MaterialFlags::NORMAL_MAP) {
            for lane in 0..LANES {
                self.apply_normal_map(geometry, packet, lane, out);
            }
        }
        extent
    }

    /// The packet hits a single instance, and possibly a single triangle.
    #[inline(always)]
    fn fill_from_one_instance(
        &self,
        hits: &PacketHits,
        instance: &InstanceData,
        one_triangle: bool,
        out: &mut SurfaceInteraction,
        normals: &mut Normals,
    ) {
        let &PacketHits { geometry, packet, footprints } = hits;
        let material = &self.materials[instance.material as usize];
        out.flags = [material.flags; LANES];
        out.any_flags = material.flags;
        for c in 0..3 {
            out.base_color[c] = [material.base_color[c]; LANES];
        }
        if let Some(lookup) = &material.base_color_texture {
            let coordinates = coordinates(geometry, packet, instance, lookup, one_triangle, &out.triangle);
            let mut texels = texture::sample_sixteen(&self.textures[lookup.texture], self.srgb, &coordinates);
            if footprints.is_some() && material.is_filtered() && instance.textured[lookup.set] {
                self.filter_sixteen(hits, lookup, &coordinates, (&out.triangle, one_triangle), &mut texels);
            }
            for c in 0..3 {
                for lane in 0..LANES {
                    out.base_color[c][lane] *= texels[c][lane];
                }
            }
        }
        if instance.colored {
            for lane in 0..LANES {
                let point = SurfacePoint::new(geometry, out.triangle[lane], [packet.hits.u[lane], packet.hits.v[lane]]);
                let color = point.vertex_color();
                for c in 0..3 {
                    out.base_color[c][lane] *= color[c];
                }
            }
        }
        if instance.smooth {
            if one_triangle {
                let of_all = geometry.normals_of(out.triangle[0]);
                for lane in 0..LANES {
                    normals.set(lane, &of_all);
                }
            } else {
                for lane in 0..LANES {
                    normals.set(lane, &geometry.normals_of(out.triangle[lane]));
                }
            }
        }
    }

    /// Replaces texels by their means over footprints, where these are wide.
    #[inline(always)]
    fn filter_sixteen(
        &self,
        hits: &PacketHits,
        lookup: &TextureLookup,
        coordinates: &[[f32; LANES]; 2],
        (triangles, one_triangle): (&[Hit; LANES], bool),
        texels: &mut [[f32; LANES]; 3],
    ) {
        let &PacketHits { geometry, packet, footprints: Some(footprints) } = hits else { return };
        let mut last = texture_triangle(lookup, geometry, triangles[0]);
        let mut of_lanes = TextureTriangles::splat(&last);
        if !one_triangle {
            for lane in 1..LANES {
                if triangles[lane] != triangles[lane - 1] {
                    last = texture_triangle(lookup, geometry, triangles[lane]);
                }
                of_lanes.set(lane, &last);
            }
        }
        let texture = &self.textures[lookup.texture];
        let on_texture = footprints.on_textures(&of_lanes, [&packet.hits.u, &packet.hits.v]);
        let filters = FootprintFilters::new(&on_texture, [texture.width, texture.height]);
        let mut any = false;
        for lane in 0..LANES {
            any |= filters.is_wide[lane];
        }
        if any {
            let pyramid = self.pyramids[lookup.texture].get_or_init(|| Pyramid::new(texture, self.srgb));
            pyramid.sample_sixteen(texture, self.srgb, coordinates, &filters, texels);
        }
    }

    #[inline(always)]
    fn fill_lane_by_lane(&self, hits: &PacketHits, out: &mut SurfaceInteraction, normals: &mut Normals) {
        let &PacketHits { geometry, packet, footprints } = hits;
        for lane in 0..LANES {
            let point = SurfacePoint::new(geometry, out.triangle[lane], [packet.hits.u[lane], packet.hits.v[lane]]);
            let material = &self.materials[point.instance.material as usize];
            out.flags[lane] = material.flags;
            out.any_flags = out.any_flags.union(material.flags);
            let color = self.base_color(material, &point, footprints.map(|all| (all, lane)));
            for c in 0..3 {
                out.base_color[c][lane] = color[c];
            }
            if point.instance.smooth {
                normals.set(lane, &geometry.normals_of(point.triangle));
            }
        }
    }
}

/// The common instance of all triangles, if there is one, and whether they are a single triangle.
#[inline(always)]
fn common_instance(geometry: &Geometry, triangles: &[Hit; LANES]) -> Option<(u32, bool)> {
    let first = triangles[0];
    let instance = geometry.instance_index(first);
    let mut differ = false;
    for lane in 1..LANES {
        differ |= (triangles[lane].triangle != first.triangle) | (triangles[lane].placement != first.placement);
    }
    if !differ {
        return Some((instance, true));
    }
    for lane in 1..LANES {
        if geometry.instance_index(triangles[lane]) != instance {
            return None;
        }
    }
    Some((instance, false))
}

/// Texture coordinates of sixteen points on one instance.
#[inline(always)]
fn coordinates(
    geometry: &Geometry,
    packet: &RayHits,
    instance: &InstanceData,
    lookup: &TextureLookup,
    one_triangle: bool,
    triangles: &[Hit; LANES],
) -> [[f32; LANES]; 2] {
    let mut corners = [[[0.0; LANES]; 2]; 3];
    if instance.textured[lookup.set] {
        let mut of_lane = geometry.texture_coordinates_of(triangles[0], lookup.set);
        for lane in 0..LANES {
            if !one_triangle {
                of_lane = geometry.texture_coordinates_of(triangles[lane], lookup.set);
            }
            for corner in 0..3 {
                for axis in 0..2 {
                    corners[corner][axis][lane] = of_lane[corner][axis];
                }
            }
        }
    }
    let mut out = [[0.0; LANES]; 2];
    for axis in 0..2 {
        for lane in 0..LANES {
            let (b, c) = (packet.hits.u[lane], packet.hits.v[lane]);
            let a = 1.0 - b - c;
            out[axis][lane] = corners[0][axis][lane] * a + corners[1][axis][lane] * b + corners[2][axis][lane] * c;
        }
    }
    if lookup.map.is_some() {
        for lane in 0..LANES {
            [out[0][lane], out[1][lane]] = lookup.apply([out[0][lane], out[1][lane]]);
        }
    }
    out
}
