//! What the integrators need to know where a packet's rays hit: position, normals, albedo.

use crate::accel::{LANES, NO_TRIANGLE, RayHits};
use crate::geometry::{Geometry, Part};
use crate::primary::ExactRays;
use crate::refine::Refined;
use crate::scene::{Material, Texture};
use crate::srgb;
use crate::texture;

/// Materials with their textures: what a surface looks up.
pub(crate) struct Appearance {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    srgb: &'static [f32; 256],
}

/// Sixteen surface points in camera coordinates. What lanes without a hit hold means nothing.
pub(crate) struct Surfaces {
    pub hit: [bool; LANES],
    /// Where secondary rays start: the hit, moved off the surface so that they do not meet it again.
    pub start: [[f32; LANES]; 3],
    /// Unit normal of the triangle on the side that the ray came from.
    pub geometric_normal: [[f32; LANES]; 3],
    /// Interpolated unit normal, turned to the same side together with the geometric one.
    pub shading_normal: [[f32; LANES]; 3],
    /// Lambertian reflectance, linear RGB.
    pub albedo: [[f32; LANES]; 3],
}

/// An f32 position is off by at most 2^-24 of the largest coordinate involved; a few such errors add up between the
/// refined point, the engine's rounded vertices and its own arithmetic. Eight of them keep clear of the surface.
const OFFSET_PER_COORDINATE: f32 = 8.0 / 16_777_216.0;

impl Appearance {
    pub fn new(materials: &[Material], textures: &[Texture]) -> Self {
        Self { materials: materials.to_vec(), textures: textures.to_vec(), srgb: srgb::decoding_table() }
    }

    /// The surfaces that `packet` hit, or `None` if it hit nothing.
    #[inline(always)]
    pub fn surfaces(
        &self,
        geometry: &Geometry,
        packet: &RayHits,
        rays: &ExactRays,
        refined: &Refined,
    ) -> Option<Surfaces> {
        let triangles = &packet.hits.triangle;
        let some = *triangles.iter().find(|&&k| k != NO_TRIANGLE)?;
        let zero = [[0.0; LANES]; 3];
        let mut out =
            Surfaces { hit: [false; LANES], start: zero, geometric_normal: zero, shading_normal: zero, albedo: zero };
        // Lanes without a hit look at a triangle of another lane: loops without branches, results that nobody reads.
        let mut group = Group { triangles: [some; LANES], packet };
        for lane in 0..LANES {
            out.hit[lane] = triangles[lane] != NO_TRIANGLE;
            group.triangles[lane] = if out.hit[lane] { triangles[lane] } else { some };
        }
        let mut position = zero;
        for lane in 0..LANES {
            let z = refined.depth[lane];
            position[0][lane] = (rays.origin_x[lane] + z * rays.direction_x[lane]) as f32;
            position[1][lane] = (rays.origin_y[lane] + z * rays.direction_y[lane]) as f32;
            position[2][lane] = -z as f32;
        }
        let mut side = [0.0; LANES];
        for lane in 0..LANES {
            let [x, y, z] = [refined.normal[0][lane], refined.normal[1][lane], refined.normal[2][lane]];
            // In f64, where the square of no normal of a sensible triangle leaves the range.
            let inverse = 1.0 / (x * x + y * y + z * z).sqrt();
            let towards = x * rays.direction_x[lane] + y * rays.direction_y[lane] - z;
            side[lane] = if towards > 0.0 { -1.0 } else { 1.0 };
            let unit = if inverse.is_finite() { f64::from(side[lane]) * inverse } else { 0.0 };
            out.geometric_normal[0][lane] = (x * unit) as f32;
            out.geometric_normal[1][lane] = (y * unit) as f32;
            out.geometric_normal[2][lane] = (z * unit) as f32;
        }

        // Neighbouring rays mostly hit one mesh; what its triangles have in common is looked up once.
        let mut parts = [0; LANES];
        for lane in 0..LANES {
            parts[lane] = geometry.part_index(group.triangles[lane] as usize);
        }
        let mut extent = [0.0; LANES];
        let mut done = [false; LANES];
        while let Some(first) = done.iter().position(|&d| !d) {
            let part = geometry.part(parts[first]);
            let mut here = [false; LANES];
            for lane in 0..LANES {
                here[lane] = parts[lane] == parts[first];
            }
            let albedo = self.albedo(geometry, part, &group.only(&here, first));
            let normal = if part.smooth {
                smooth_normals(geometry, &group.only(&here, first), &side, &out.geometric_normal)
            } else {
                out.geometric_normal
            };
            for lane in 0..LANES {
                if here[lane] {
                    for axis in 0..3 {
                        out.albedo[axis][lane] = albedo[axis][lane];
                        out.shading_normal[axis][lane] = normal[axis][lane];
                    }
                    extent[lane] = part.extent;
                }
                done[lane] |= here[lane];
            }
        }
        for lane in 0..LANES {
            let [x, y, z] = [position[0][lane], position[1][lane], position[2][lane]];
            let offset = extent[lane].max(x.abs()).max(y.abs()).max(z.abs()) * OFFSET_PER_COORDINATE;
            for axis in 0..3 {
                out.start[axis][lane] = position[axis][lane] + out.geometric_normal[axis][lane] * offset;
            }
        }
        Some(out)
    }

    /// Base colour of triangles of one part: factor, texture, vertex colours.
    #[inline(always)]
    fn albedo(&self, geometry: &Geometry, part: &Part, group: &Group) -> [[f32; LANES]; 3] {
        let material = &self.materials[part.material as usize];
        let [r, g, b, _] = material.base_color;
        let mut albedo = [[r; LANES], [g; LANES], [b; LANES]];
        if let Some(used) = material.base_color_texture {
            let texture = &self.textures[used.texture];
            let coordinates = if part.textured {
                group.mix(|triangle| geometry.texture_coordinates_of(triangle))
            } else {
                [[0.0; LANES]; 2]
            };
            for lane in 0..LANES {
                let color = texture::sample(texture, self.srgb, [coordinates[0][lane], coordinates[1][lane]]);
                for c in 0..3 {
                    albedo[c][lane] *= color[c];
                }
            }
        }
        if part.colored {
            let colors = group.mix(|triangle| geometry.colors_of(triangle));
            for c in 0..3 {
                for lane in 0..LANES {
                    albedo[c][lane] *= colors[c][lane];
                }
            }
        }
        albedo
    }
}

/// Interpolated normals at unit length on the side of the ray; the geometric ones where they cancel out.
#[inline(always)]
fn smooth_normals(
    geometry: &Geometry,
    group: &Group,
    side: &[f32; LANES],
    geometric: &[[f32; LANES]; 3],
) -> [[f32; LANES]; 3] {
    let mut normal = group.mix(|triangle| geometry.normals_of(triangle));
    for lane in 0..LANES {
        let [x, y, z] = [normal[0][lane], normal[1][lane], normal[2][lane]];
        let squared = x * x + y * y + z * z;
        let unit = side[lane] / squared.sqrt();
        for axis in 0..3 {
            normal[axis][lane] = if squared > 1e-12 { normal[axis][lane] * unit } else { geometric[axis][lane] };
        }
    }
    normal
}

/// The triangles of sixteen lanes and where on them the rays hit.
struct Group<'a> {
    triangles: [u32; LANES],
    packet: &'a RayHits,
}

impl Group<'_> {
    /// The same with every other lane looking at the triangle of lane `first`.
    #[inline(always)]
    fn only(&self, here: &[bool; LANES], first: usize) -> Self {
        let some = self.triangles[first];
        let mut triangles = [some; LANES];
        for lane in 0..LANES {
            triangles[lane] = if here[lane] { self.triangles[lane] } else { some };
        }
        Self { triangles, packet: self.packet }
    }

    /// A value of the three corners of every lane's triangle, weighted by where the ray hit.
    #[inline(always)]
    fn mix<const N: usize>(&self, corners: impl Fn(usize) -> [[f32; N]; 3]) -> [[f32; LANES]; N] {
        let mut values = [[[0.0; LANES]; 3]; N];
        for lane in 0..LANES {
            let read = corners(self.triangles[lane] as usize);
            for corner in 0..3 {
                for k in 0..N {
                    values[k][corner][lane] = read[corner][k];
                }
            }
        }
        let mut out = [[0.0; LANES]; N];
        for k in 0..N {
            for lane in 0..LANES {
                let (v, w) = (self.packet.hits.u[lane], self.packet.hits.v[lane]);
                out[k][lane] = values[k][0][lane] * (1.0 - v - w) + values[k][1][lane] * v + values[k][2][lane] * w;
            }
        }
        out
    }
}
