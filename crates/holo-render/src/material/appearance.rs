//! What surfaces look like where they are hit: normals and colours from the vertices and textures of a mesh.
//!
//! Every surface is asked for its base colour and its normal. What only some materials have - gloss, glass, glow - is
//! looked up where a packet meets such a material ([`Kinds`]), so that scenes without it do not pay for it.

mod emission;
mod look_up;
mod scattering;

use crate::accel::RayHits;
use crate::geometry::{Geometry, Hit, Part};
use crate::material::Surfaces;
use crate::material::texture;
use holo_core::color::srgb8_to_linear_table;
use holo_scene::{Alpha, NormalMap, Texture, TextureTransform, TextureUse};

/// Materials with their textures, prepared for looking up.
pub(crate) struct Appearance {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    srgb: &'static [f32; 256],
    /// Codes as shares of 1: what textures hold that are no colours.
    linear: [f32; 256],
}

/// What a material has beyond a base colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Kinds(u8);

impl Kinds {
    /// Metal, glass or varnish.
    pub const GLOSSY: Self = Self(1);
    /// Emission.
    pub const GLOWS: Self = Self(2);
    /// The base colour as it is.
    pub const UNLIT: Self = Self(4);
    /// A normal map.
    pub const RELIEF: Self = Self(8);
    /// A volume of glass.
    pub const FILLED: Self = Self(16);
    /// Alpha that says something.
    pub const HOLES: Self = Self(32);

    #[inline(always)]
    pub const fn has(self, kind: Self) -> bool {
        self.0 & kind.0 != 0
    }

    #[inline(always)]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// A material as surfaces look it up.
struct Material {
    kinds: Kinds,
    base_color: [f32; 4],
    base_color_texture: Option<Lookup>,
    relief: Option<(Lookup, f32)>,
    alpha: Alpha,
    emission: emission::Emission,
    scattering: scattering::Scattering,
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

/// A place on a triangle of some part.
#[derive(Clone, Copy)]
struct Place<'a> {
    geometry: &'a Geometry,
    part: &'a Part,
    triangle: Hit,
    /// How much of each corner there is.
    weights: [f32; 3],
}

impl<'a> Place<'a> {
    #[inline(always)]
    fn new(geometry: &'a Geometry, triangle: Hit, [v, w]: [f32; 2]) -> Self {
        let part = geometry.part(geometry.part_index(triangle));
        Self { geometry, part, triangle, weights: [1.0 - v - w, v, w] }
    }

    #[inline(always)]
    fn coordinates(&self, lookup: &Lookup) -> [f32; 2] {
        if !self.part.textured[lookup.set] {
            return lookup.apply([0.0; 2]);
        }
        lookup.apply(mix(&self.geometry.texture_coordinates_of(self.triangle, lookup.set), self.weights))
    }

    #[inline(always)]
    fn vertex_color(&self) -> [f32; 4] {
        mix(&self.geometry.colors_of(self.triangle), self.weights)
    }
}

impl Appearance {
    pub fn new(materials: &[holo_scene::Material], textures: &[Texture]) -> Self {
        let mut linear = [0.0; 256];
        linear.iter_mut().enumerate().for_each(|(code, value)| *value = code as f32 / 255.0);
        Self {
            materials: materials.iter().map(Material::new).collect(),
            textures: textures.to_vec(),
            srgb: srgb8_to_linear_table(),
            linear,
        }
    }

    /// What any of the materials has.
    pub fn kinds(&self) -> Kinds {
        self.materials.iter().fold(Kinds::default(), |all, material| all.and(material.kinds))
    }

    /// Whether no surface needs light to be seen.
    pub fn is_all_unlit(&self) -> bool {
        self.materials.iter().all(|material| material.kinds.has(Kinds::UNLIT))
    }

    #[inline(always)]
    fn base_color(&self, material: &Material, place: &Place) -> [f32; 3] {
        let [mut r, mut g, mut b, _] = material.base_color;
        if let Some(lookup) = &material.base_color_texture {
            let [x, y, z] = self.color(lookup, place);
            (r, g, b) = (r * x, g * y, b * z);
        }
        if place.part.colored {
            let [x, y, z, _] = place.vertex_color();
            (r, g, b) = (r * x, g * y, b * z);
        }
        [r, g, b]
    }

    /// The share of rays that meet the surface of a triangle where they cross it at the weights `place`; 0 in the holes
    /// of a mask.
    #[inline(always)]
    pub fn opacity(&self, geometry: &Geometry, triangle: Hit, place: [f32; 2]) -> f32 {
        let part = geometry.part(geometry.part_index(triangle));
        let material = &self.materials[part.material as usize];
        if !material.kinds.has(Kinds::HOLES) {
            return 1.0;
        }
        let place = Place::new(geometry, triangle, place);
        let mut alpha = material.base_color[3];
        if let Some(lookup) = &material.base_color_texture {
            alpha *= texture::sample_alpha(&self.textures[lookup.texture], place.coordinates(lookup));
        }
        if place.part.colored {
            alpha *= place.vertex_color()[3];
        }
        match material.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            Alpha::Blend => alpha,
        }
    }

    /// A texture as a colour, linear RGB.
    #[inline(always)]
    fn color(&self, lookup: &Lookup, place: &Place) -> [f32; 3] {
        texture::sample(&self.textures[lookup.texture], self.srgb, place.coordinates(lookup))
    }

    /// A texture as numbers.
    #[inline(always)]
    fn numbers(&self, lookup: &Lookup, place: &Place) -> [f32; 3] {
        texture::sample(&self.textures[lookup.texture], &self.linear, place.coordinates(lookup))
    }

    /// Turns the shading normal of one lane as its normal map says.
    ///
    /// The map's axes are the directions on the triangle in which u and -v grow, made perpendicular to the normal; they
    /// are the triangle's own and not smoothed over its neighbours (a mesh's tangents are not read).
    #[inline(always)]
    fn bend(&self, geometry: &Geometry, packet: &RayHits, lane: usize, out: &mut Surfaces) {
        let place = Place::new(geometry, out.triangle[lane], [packet.hits.u[lane], packet.hits.v[lane]]);
        let material = &self.materials[place.part.material as usize];
        let Some((lookup, scale)) = &material.relief else { return };
        if !place.part.textured[lookup.set] {
            return;
        }
        let [a, b, c] = geometry.texture_coordinates_of(place.triangle, lookup.set);
        let [(u1, v1), (u2, v2)] = [(b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1])];
        let area = u1 * v2 - u2 * v1;
        if area == 0.0 {
            return;
        }
        let corners = geometry.corners(place.triangle);
        // The map lies on its front; the shading normal may be turned to the back.
        let side = out.side[lane];
        let mut normal = [0.0; 3];
        let mut tangent = [0.0; 3];
        let mut along = 0.0;
        for axis in 0..3 {
            let (first, second) = (corners[1][axis] - corners[0][axis], corners[2][axis] - corners[0][axis]);
            normal[axis] = out.shading_normal[axis][lane] * side;
            tangent[axis] = (first * v2 - second * v1) * area.signum();
            along += tangent[axis] * normal[axis];
        }
        let mut squared = 0.0f32;
        for axis in 0..3 {
            tangent[axis] -= normal[axis] * along;
            squared += tangent[axis] * tangent[axis];
        }
        let unit = 1.0 / squared.sqrt();
        if !unit.is_finite() {
            return;
        }
        for axis in 0..3 {
            tangent[axis] *= unit;
        }
        // Upward in the image, against v: on the left of u unless the coordinates are mirrored.
        let turn = -area.signum();
        let bitangent = [
            (normal[1] * tangent[2] - normal[2] * tangent[1]) * turn,
            (normal[2] * tangent[0] - normal[0] * tangent[2]) * turn,
            (normal[0] * tangent[1] - normal[1] * tangent[0]) * turn,
        ];
        let [r, g, b] = self.numbers(lookup, &place);
        let (x, y, z) = ((2.0 * r - 1.0) * scale, (2.0 * g - 1.0) * scale, 2.0 * b - 1.0);
        let mut bent = [0.0; 3];
        let mut squared = 0.0f32;
        for axis in 0..3 {
            bent[axis] = tangent[axis] * x + bitangent[axis] * y + normal[axis] * z;
            squared += bent[axis] * bent[axis];
        }
        let unit = side / squared.sqrt();
        if unit.is_finite() {
            for axis in 0..3 {
                out.shading_normal[axis][lane] = bent[axis] * unit;
            }
        }
    }
}

impl Material {
    fn new(material: &holo_scene::Material) -> Self {
        let relief = material.normal_map.map(|NormalMap { texture, scale }| (Lookup::new(texture), scale));
        let emission = emission::Emission::new(material);
        let scattering = scattering::Scattering::new(material);
        let kinds = [
            (Kinds::GLOSSY, scattering.is_glossy() && !material.unlit),
            (Kinds::GLOWS, emission.glows() && !material.unlit),
            (Kinds::UNLIT, material.unlit),
            (Kinds::RELIEF, relief.is_some()),
            (Kinds::FILLED, scattering.is_filled() && !material.unlit),
            (Kinds::HOLES, material.alpha != Alpha::Opaque),
        ];
        Self {
            kinds: kinds.iter().filter(|(_, has)| *has).fold(Kinds::default(), |all, (kind, _)| all.and(*kind)),
            base_color: material.base_color,
            base_color_texture: material.base_color_texture.map(Lookup::new),
            relief,
            alpha: material.alpha,
            emission,
            scattering,
        }
    }
}

#[inline(always)]
fn mix<const N: usize>(corners: &[[f32; N]; 3], [a, b, c]: [f32; 3]) -> [f32; N] {
    let mut out = [0.0; N];
    for k in 0..N {
        out[k] = corners[0][k] * a + corners[1][k] * b + corners[2][k] * c;
    }
    out
}
