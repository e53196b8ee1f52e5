//! What surfaces look like where they are hit: normals and base colours from the vertices and textures of a mesh.

use crate::accel::{LANES, RayHits};
use crate::geometry::Geometry;
use crate::scene::{self, Texture, TextureTransform, TextureUse};
use crate::srgb;
use crate::surface::Surfaces;
use crate::texture;

/// Materials with their textures, prepared for looking up.
pub(crate) struct Appearance {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    srgb: &'static [f32; 256],
}

/// A material as surfaces look it up.
struct Material {
    base_color: [f32; 3],
    base_color_texture: Option<Lookup>,
}

/// A texture with the map of its coordinates: u' = a u + b v + c, v' = d u + e v + f.
#[derive(Clone, Copy)]
struct Lookup {
    texture: usize,
    set: usize,
    map: Option<[f32; 6]>,
}

impl Lookup {
    fn new(used: TextureUse) -> Self {
        let TextureTransform { offset: [x, y], rotation_rad, scale: [width, height] } = used.transform;
        let (sin, cos) = f64::from(rotation_rad).sin_cos();
        let (width, height) = (f64::from(width), f64::from(height));
        // Source: KHR_texture_transform, translation * rotation * scale.
        let map = [cos * width, sin * height, f64::from(x), -sin * width, cos * height, f64::from(y)].map(|x| x as f32);
        let map = (used.transform != TextureTransform::IDENTITY).then_some(map);
        Self { texture: used.texture, set: used.set, map }
    }

    #[inline(always)]
    fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        match &self.map {
            None => [u, v],
            Some([a, b, c, d, e, f]) => [a * u + b * v + c, d * u + e * v + f],
        }
    }
}

impl Appearance {
    pub fn new(materials: &[scene::Material], textures: &[Texture]) -> Self {
        let prepare = |material: &scene::Material| {
            let [r, g, b, _] = material.base_color;
            Material { base_color: [r, g, b], base_color_texture: material.base_color_texture.map(Lookup::new) }
        };
        Self {
            materials: materials.iter().map(prepare).collect(),
            textures: textures.to_vec(),
            srgb: srgb::decoding_table(),
        }
    }

    /// Fills in material, base colour and shading normal; returns the largest coordinates of the meshes hit.
    ///
    /// Lane by lane: rays that are scattered, and those among leaves, hit a mesh of their own each.
    #[inline(always)]
    pub fn look_up(
        &self,
        geometry: &Geometry,
        packet: &RayHits,
        triangles: &[u32; LANES],
        out: &mut Surfaces,
    ) -> [f32; LANES] {
        let mut extent = [0.0; LANES];
        let mut smooth = [false; LANES];
        let mut any_smooth = false;
        let mut corners = [[[0.0f32; LANES]; 3]; 3];
        for lane in 0..LANES {
            let triangle = triangles[lane] as usize;
            let part = geometry.part(geometry.part_index(triangle));
            let material = &self.materials[part.material as usize];
            let weights = weights(packet, lane);
            extent[lane] = part.extent;
            out.material[lane] = part.material;
            let mut color = material.base_color;
            if let Some(lookup) = &material.base_color_texture {
                let coordinates = if part.textured[lookup.set] {
                    mix(&geometry.texture_coordinates_of(triangle, lookup.set), weights)
                } else {
                    [0.0; 2]
                };
                let texel = texture::sample(&self.textures[lookup.texture], self.srgb, lookup.apply(coordinates));
                for c in 0..3 {
                    color[c] *= texel[c];
                }
            }
            if part.colored {
                let factor = mix(&geometry.colors_of(triangle), weights);
                for c in 0..3 {
                    color[c] *= factor[c];
                }
            }
            for c in 0..3 {
                out.base_color[c][lane] = color[c];
            }
            if part.smooth {
                let normals = geometry.normals_of(triangle);
                for corner in 0..3 {
                    for axis in 0..3 {
                        corners[corner][axis][lane] = normals[corner][axis];
                    }
                }
                smooth[lane] = true;
                any_smooth = true;
            }
        }
        out.shading_normal = out.geometric_normal;
        if any_smooth {
            for lane in 0..LANES {
                let [a, b, c] = weights(packet, lane);
                let mut normal = [0.0; 3];
                for axis in 0..3 {
                    normal[axis] = corners[0][axis][lane] * a + corners[1][axis][lane] * b + corners[2][axis][lane] * c;
                }
                let squared = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
                let unit = out.side[lane] / squared.sqrt();
                // Where the three cancel out the triangle's own normal stays.
                let usable = smooth[lane] & (squared > 1e-12);
                for axis in 0..3 {
                    let flat = out.geometric_normal[axis][lane];
                    out.shading_normal[axis][lane] = if usable { normal[axis] * unit } else { flat };
                }
            }
        }
        extent
    }
}

/// How much of each corner there is where lane `lane` hits its triangle.
#[inline(always)]
fn weights(packet: &RayHits, lane: usize) -> [f32; 3] {
    let (v, w) = (packet.hits.u[lane], packet.hits.v[lane]);
    [1.0 - v - w, v, w]
}

#[inline(always)]
fn mix<const N: usize>(corners: &[[f32; N]; 3], [a, b, c]: [f32; 3]) -> [f32; N] {
    let mut out = [0.0; N];
    for k in 0..N {
        out[k] = corners[0][k] * a + corners[1][k] * b + corners[2][k] * c;
    }
    out
}
