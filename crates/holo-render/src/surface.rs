//! What the integrators need to know where a packet's rays hit: position, normals, albedo.

use crate::accel::{LANES, NO_TRIANGLE, RayHits};
use crate::geometry::Geometry;
use crate::light::dot;
use crate::primary::ExactRays;
use crate::scene::{Material, Texture};
use crate::srgb;
use crate::texture;

/// Materials with their textures: what a surface looks up.
pub(crate) struct Appearance {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    srgb: &'static [f32; 256],
}

/// Sixteen surface points in camera coordinates. Lanes without a hit hold zeros.
pub(crate) struct Surfaces {
    pub hit: [bool; LANES],
    pub position: [[f32; LANES]; 3],
    /// Unit normal of the triangle on the side that the ray came from.
    pub geometric_normal: [[f32; LANES]; 3],
    /// Interpolated unit normal, turned to the same side together with the geometric one.
    pub shading_normal: [[f32; LANES]; 3],
    /// Lambertian reflectance, linear RGB.
    pub albedo: [[f32; LANES]; 3],
    /// How far a secondary ray must start off the surface so as not to meet it again, m.
    pub offset: [f32; LANES],
}

/// An f32 position is off by at most 2^-24 of the largest coordinate involved; a few such errors add up between the
/// refined point, the engine's rounded vertices and its own arithmetic. Eight of them keep clear of the surface.
const OFFSET_PER_COORDINATE: f32 = 8.0 / 16_777_216.0;

impl Appearance {
    pub fn new(materials: &[Material], textures: &[Texture]) -> Self {
        Self { materials: materials.to_vec(), textures: textures.to_vec(), srgb: srgb::decoding_table() }
    }

    /// The surfaces that `packet` hit; `depth` is refined.
    #[inline(always)]
    pub fn surfaces(&self, geometry: &Geometry, packet: &RayHits, rays: &ExactRays, depth: &[f64; LANES]) -> Surfaces {
        let zero = [[0.0; LANES]; 3];
        let mut out = Surfaces {
            hit: [false; LANES],
            position: zero,
            geometric_normal: zero,
            shading_normal: zero,
            albedo: zero,
            offset: [0.0; LANES],
        };
        for lane in 0..LANES {
            let z = if depth[lane].is_finite() { depth[lane] } else { 0.0 };
            out.position[0][lane] = (rays.origin_x[lane] + z * rays.direction_x[lane]) as f32;
            out.position[1][lane] = (rays.origin_y[lane] + z * rays.direction_y[lane]) as f32;
            out.position[2][lane] = -z as f32;
        }
        for lane in 0..LANES {
            let triangle = packet.hits.triangle[lane];
            if triangle == NO_TRIANGLE {
                continue;
            }
            let triangle = triangle as usize;
            out.hit[lane] = true;
            let part = geometry.part(triangle);
            let [_, v, w] = weights(packet, lane);
            let material = &self.materials[part.material as usize];
            let mut albedo = [material.base_color[0], material.base_color[1], material.base_color[2]];
            if let Some(used) = material.base_color_texture {
                let coordinates =
                    if part.textured { mix(geometry.texture_coordinates_of(triangle), v, w) } else { [0.0; 2] };
                let color = texture::sample(&self.textures[used.texture], self.srgb, coordinates);
                albedo = std::array::from_fn(|c| albedo[c] * color[c]);
            }
            if part.colored {
                let color = mix(geometry.colors_of(triangle), v, w);
                albedo = std::array::from_fn(|c| albedo[c] * color[c]);
            }
            let normal = geometry.planes()[triangle].normal;
            let geometric = unit(normal.map(|x| x as f32)).unwrap_or_else(|| {
                // Below the range of f32: normalise in f64.
                glam::DVec3::from(normal).normalize_or_zero().as_vec3().to_array()
            });
            let shading = if part.smooth {
                unit(mix(geometry.normals_of(triangle), v, w)).unwrap_or(geometric)
            } else {
                geometric
            };
            let direction = packet.rays.direction.map(|axis| axis[lane]);
            let side = if dot(geometric, direction) > 0.0 { -1.0 } else { 1.0 };
            let largest = (0..3).fold(part.extent, |m, axis| m.max(out.position[axis][lane].abs()));
            out.offset[lane] = largest * OFFSET_PER_COORDINATE;
            for axis in 0..3 {
                out.geometric_normal[axis][lane] = geometric[axis] * side;
                out.shading_normal[axis][lane] = shading[axis] * side;
                out.albedo[axis][lane] = albedo[axis];
            }
        }
        out
    }
}

impl Surfaces {
    /// One lane of a vector field.
    #[inline(always)]
    pub fn at(field: &[[f32; LANES]; 3], lane: usize) -> [f32; 3] {
        [field[0][lane], field[1][lane], field[2][lane]]
    }

    /// Where a secondary ray of this lane starts.
    #[inline(always)]
    pub fn start(&self, lane: usize) -> [f32; 3] {
        std::array::from_fn(|k| self.position[k][lane] + self.geometric_normal[k][lane] * self.offset[lane])
    }
}

#[inline(always)]
fn weights(packet: &RayHits, lane: usize) -> [f32; 3] {
    let (v, w) = (packet.hits.u[lane], packet.hits.v[lane]);
    [1.0 - v - w, v, w]
}

/// The value between three corners; the second and third have the weights `v` and `w`.
#[inline(always)]
fn mix<const N: usize>([a, b, c]: [[f32; N]; 3], v: f32, w: f32) -> [f32; N] {
    std::array::from_fn(|k| a[k] * (1.0 - v - w) + b[k] * v + c[k] * w)
}

/// `v` at unit length, or `None` where its square is too small or too large for f32.
#[inline(always)]
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let squared = dot(v, v);
    (squared > 1e-30 && squared < 1e30).then(|| {
        let inverse = 1.0 / squared.sqrt();
        v.map(|x| x * inverse)
    })
}
