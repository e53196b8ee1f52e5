//! Normals and base colours of the sixteen places that a packet hit.
//!
//! Camera rays mostly meet one mesh together: its material is read once, and its texture by all lanes side by side. Rays
//! that were scattered, and those among leaves, hit a mesh of their own each and are looked up lane by lane. Both ways
//! give the same bits.

use super::{Appearance, Kinds, Lookup, Place};
use crate::accel::RayHits;
use crate::geometry::{Geometry, Hit, Part};
use crate::material::Surfaces;
use crate::material::texture;
use crate::simd::LANES;

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

    /// The shading normals, on the side from which the rays came.
    #[inline(always)]
    fn interpolate(&self, packet: &RayHits, out: &mut Surfaces) {
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
            // Where the three cancel out the triangle's own normal stays.
            let usable = self.smooth[lane] & (squared > 1e-12);
            for axis in 0..3 {
                let flat = out.geometric_normal[axis][lane];
                out.shading_normal[axis][lane] = if usable { normal[axis] * unit } else { flat };
            }
        }
    }
}

impl Appearance {
    /// Fills in triangle, kinds, base colour and shading normal; returns the largest coordinates of the meshes hit.
    #[inline(always)]
    pub fn look_up(
        &self,
        geometry: &Geometry,
        packet: &RayHits,
        triangles: &[Hit; LANES],
        out: &mut Surfaces,
    ) -> [f32; LANES] {
        let mut normals = Normals { smooth: [false; LANES], any: false, corners: [[[0.0f32; LANES]; 3]; 3] };
        out.triangle = *triangles;
        let extent = match together(geometry, triangles) {
            Some((part, one_triangle)) => {
                let part = geometry.part(part);
                self.look_up_together(geometry, packet, part, one_triangle, out, &mut normals);
                [part.extent; LANES]
            }
            None => self.look_up_each(geometry, packet, out, &mut normals),
        };
        out.shading_normal = out.geometric_normal;
        if normals.any {
            normals.interpolate(packet, out);
        }
        if out.any.has(Kinds::RELIEF) {
            for lane in 0..LANES {
                self.bend(geometry, packet, lane, out);
            }
        }
        extent
    }

    /// All lanes on one mesh, or even one triangle.
    #[inline(always)]
    fn look_up_together(
        &self,
        geometry: &Geometry,
        packet: &RayHits,
        part: &Part,
        one_triangle: bool,
        out: &mut Surfaces,
        normals: &mut Normals,
    ) {
        let material = &self.materials[part.material as usize];
        out.kinds = [material.kinds; LANES];
        out.any = material.kinds;
        for c in 0..3 {
            out.base_color[c] = [material.base_color[c]; LANES];
        }
        if let Some(lookup) = &material.base_color_texture {
            let coordinates = coordinates(geometry, packet, part, lookup, one_triangle, &out.triangle);
            let texels = texture::sample_sixteen(&self.textures[lookup.texture], self.srgb, &coordinates);
            for c in 0..3 {
                for lane in 0..LANES {
                    out.base_color[c][lane] *= texels[c][lane];
                }
            }
        }
        if part.colored {
            for lane in 0..LANES {
                let place = Place::new(geometry, out.triangle[lane], [packet.hits.u[lane], packet.hits.v[lane]]);
                let color = place.vertex_color();
                for c in 0..3 {
                    out.base_color[c][lane] *= color[c];
                }
            }
        }
        if part.smooth {
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

    #[inline(always)]
    fn look_up_each(
        &self,
        geometry: &Geometry,
        packet: &RayHits,
        out: &mut Surfaces,
        normals: &mut Normals,
    ) -> [f32; LANES] {
        let mut extent = [0.0; LANES];
        for lane in 0..LANES {
            let place = Place::new(geometry, out.triangle[lane], [packet.hits.u[lane], packet.hits.v[lane]]);
            let material = &self.materials[place.part.material as usize];
            extent[lane] = place.part.extent;
            out.kinds[lane] = material.kinds;
            out.any = out.any.and(material.kinds);
            let color = self.base_color(material, &place);
            for c in 0..3 {
                out.base_color[c][lane] = color[c];
            }
            if place.part.smooth {
                normals.set(lane, &geometry.normals_of(place.triangle));
            }
        }
        extent
    }
}

/// The part that all triangles belong to, if it is one, and whether they are even one triangle.
#[inline(always)]
fn together(geometry: &Geometry, triangles: &[Hit; LANES]) -> Option<(u32, bool)> {
    let first = triangles[0];
    let part = geometry.part_index(first);
    let mut differ = false;
    for lane in 1..LANES {
        differ |= (triangles[lane].triangle != first.triangle) | (triangles[lane].instance != first.instance);
    }
    if !differ {
        return Some((part, true));
    }
    for lane in 1..LANES {
        if geometry.part_index(triangles[lane]) != part {
            return None;
        }
    }
    Some((part, false))
}

/// Texture coordinates of sixteen places on one part.
#[inline(always)]
fn coordinates(
    geometry: &Geometry,
    packet: &RayHits,
    part: &Part,
    lookup: &Lookup,
    one_triangle: bool,
    triangles: &[Hit; LANES],
) -> [[f32; LANES]; 2] {
    let mut corners = [[[0.0; LANES]; 2]; 3];
    if part.textured[lookup.set] {
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
