//! Appearance: material parameters, textures and vertex attributes at hit points.
//!
//! Base color and normal are evaluated for every hit. Features that only some materials have (glossy lobes,
//! transmission, emission) are evaluated only for packets that contain such a material ([`MaterialFlags`]).

mod emission;
mod interaction;
mod layers;
mod lookup;
mod normal_map;
mod scattering;

pub(crate) use layers::Lane;
pub(crate) use lookup::PacketHits;

use std::collections::BTreeMap;
use std::sync::OnceLock;

use crate::geometry::{Geometry, Hit, InstanceData};
use crate::material::flags::MaterialFlags;
use crate::material::footprint::{Footprints, TextureTriangle};
use crate::material::media::{Medium, MediumId};
use crate::material::texture::{self, FootprintFilter, Pyramid, TextureFootprint};
use holo_core::color::srgb8_to_linear_table;
use holo_scene::{Alpha, NormalMap, Texture, TextureInfo, TextureTransform};

/// Materials and textures, prepared for evaluation.
pub(crate) struct Appearance {
    materials: Vec<Material>,
    /// Air, and the media of the materials, each once.
    media: Vec<Medium>,
    textures: Vec<Texture>,
    /// Those of the textures, built when a footprint first needs them.
    pyramids: Vec<OnceLock<Pyramid>>,
    srgb: &'static [f32; 256],
    /// The values of 8-bit codes of textures without color, 0 to 1.
    linear: [f32; 256],
}

/// A material, prepared for evaluation.
struct Material {
    flags: MaterialFlags,
    base_color: [f32; 4],
    base_color_texture: Option<TextureLookup>,
    normal_map: Option<NormalMapLookup>,
    alpha: Alpha,
    emission: emission::Emission,
    scattering: scattering::Scattering,
    /// Those of few materials; on the heap, so that others stay small.
    layers: Option<Box<layers::Layers>>,
    /// 1: mirrors light, 2: lets it pass.
    reflective: u8,
}

/// A texture with its coordinate transform: u' = a u + b v + c, v' = d u + e v + f.
#[derive(Clone, Copy)]
struct TextureLookup {
    texture: usize,
    set: usize,
    map: Option<[f32; 6]>,
}

impl TextureLookup {
    fn new(used: TextureInfo) -> Self {
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

/// A normal map with its scale.
type NormalMapLookup = (TextureLookup, f32);

/// The footprint of one of the sixteen.
type LaneFootprint<'a> = (&'a Footprints, usize);

/// A point on a triangle.
#[derive(Clone, Copy)]
struct SurfacePoint<'a> {
    geometry: &'a Geometry,
    instance: &'a InstanceData,
    triangle: Hit,
    /// The barycentrics of the three corners.
    barycentrics: [f32; 3],
}

impl<'a> SurfacePoint<'a> {
    #[inline(always)]
    fn new(geometry: &'a Geometry, triangle: Hit, [v, w]: [f32; 2]) -> Self {
        let instance = geometry.instance(geometry.instance_index(triangle));
        Self { geometry, instance, triangle, barycentrics: [1.0 - v - w, v, w] }
    }

    #[inline(always)]
    fn coordinates(&self, lookup: &TextureLookup) -> [f32; 2] {
        if !self.instance.textured[lookup.set] {
            return lookup.apply([0.0; 2]);
        }
        lookup.apply(mix(&self.geometry.texture_coordinates_of(self.triangle, lookup.set), self.barycentrics))
    }

    #[inline(always)]
    fn vertex_color(&self) -> [f32; 4] {
        mix(&self.geometry.colors_of(self.triangle), self.barycentrics)
    }
}

impl Appearance {
    pub fn new(materials: &[holo_scene::Material], textures: &[Texture]) -> Self {
        let mut linear = [0.0; 256];
        linear.iter_mut().enumerate().for_each(|(code, value)| *value = code as f32 / 255.0);
        let is_dispersive = |material: &holo_scene::Material| material.volume.is_some() && material.dispersion > 0.0;
        let any_dispersive = materials.iter().any(is_dispersive);
        let mut materials: Vec<Material> =
            materials.iter().map(|material| Material::new(material, any_dispersive)).collect();
        let media = number_media(&mut materials);
        let pyramids = textures.iter().map(|_| OnceLock::new()).collect();
        Self { materials, media, textures: textures.to_vec(), pyramids, srgb: srgb8_to_linear_table(), linear }
    }

    /// Whether there are textures.
    pub fn has_textures(&self) -> bool {
        !self.textures.is_empty()
    }

    /// The features of all materials together.
    pub fn flags(&self) -> MaterialFlags {
        self.materials.iter().fold(MaterialFlags::default(), |all, material| all.union(material.flags))
    }

    /// The number of different media in bodies of glass.
    pub fn media_count(&self) -> usize {
        self.media.len() - 1
    }

    /// 1 if a material mirrors light, 2 if it lets it pass, else 0.
    pub fn reflective(&self, material: u32) -> u8 {
        self.materials[material as usize].reflective
    }

    /// Whether all materials are unlit.
    pub fn is_all_unlit(&self) -> bool {
        self.materials.iter().all(|material| material.flags.has(MaterialFlags::UNLIT))
    }

    #[inline(always)]
    fn base_color(&self, material: &Material, point: &SurfacePoint, footprint: Option<LaneFootprint>) -> [f32; 3] {
        let [mut r, mut g, mut b, _] = material.base_color;
        if let Some(lookup) = &material.base_color_texture {
            let [x, y, z] = self.mean_color(material, lookup, point, footprint);
            (r, g, b) = (r * x, g * y, b * z);
        }
        if point.instance.colored {
            let [x, y, z, _] = point.vertex_color();
            (r, g, b) = (r * x, g * y, b * z);
        }
        [r, g, b]
    }

    /// The opacity of a triangle at the barycentrics `point`: the probability that it stops a ray; 0 in the holes of a
    /// mask.
    #[inline(always)]
    pub fn opacity(&self, geometry: &Geometry, triangle: Hit, point: [f32; 2]) -> f32 {
        let instance = geometry.instance(geometry.instance_index(triangle));
        let material = &self.materials[instance.material as usize];
        if !material.flags.has(MaterialFlags::ALPHA) {
            return 1.0;
        }
        let point = SurfacePoint::new(geometry, triangle, point);
        let mut alpha = material.base_color[3];
        if let Some(lookup) = &material.base_color_texture {
            alpha *= texture::sample_alpha(&self.textures[lookup.texture], point.coordinates(lookup));
        }
        if point.instance.colored {
            alpha *= point.vertex_color()[3];
        }
        match material.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            Alpha::Blend => alpha,
        }
    }

    /// Whether the material of a triangle has two sides.
    pub fn is_double_sided(&self, geometry: &Geometry, triangle: Hit) -> bool {
        let instance = geometry.instance(geometry.instance_index(triangle));
        self.materials[instance.material as usize].emission.both_sides
    }

    /// Samples a color texture, linear RGB.
    #[inline(always)]
    fn color(&self, lookup: &TextureLookup, point: &SurfacePoint) -> [f32; 3] {
        let texture = &self.textures[lookup.texture];
        texture::sample(texture, self.srgb, point.coordinates(lookup), texture.filter)
    }

    /// The mean of a color texture over a footprint, or its value at the point, linear RGB.
    #[inline(always)]
    fn mean_color(
        &self,
        material: &Material,
        lookup: &TextureLookup,
        point: &SurfacePoint,
        footprint: Option<LaneFootprint>,
    ) -> [f32; 3] {
        if let Some((footprints, lane)) = footprint
            && material.is_filtered()
            && point.instance.textured[lookup.set]
        {
            let triangle = texture_triangle(lookup, point.geometry, point.triangle);
            let [_, b, c] = point.barycentrics;
            if let Some(on_texture) = footprints.on_texture(lane, &triangle, [b, c])
                && let Some(color) = self.filtered(lookup, point.coordinates(lookup), &on_texture)
            {
                return color;
            }
        }
        self.color(lookup, point)
    }

    /// The mean of a color texture over a footprint at `coordinates`; `None` if it is not wider than the interpolation of
    /// adjacent texels.
    #[inline(always)]
    fn filtered(&self, lookup: &TextureLookup, [u, v]: [f32; 2], footprint: &TextureFootprint) -> Option<[f32; 3]> {
        let texture = &self.textures[lookup.texture];
        let filter = FootprintFilter::new(footprint, [texture.width, texture.height])?;
        let pyramid = self.pyramids[lookup.texture].get_or_init(|| Pyramid::new(texture, self.srgb));
        Some(pyramid.sample(texture, self.srgb, [u, v], &filter))
    }

    /// Samples a texture without color: linear values, 0 to 1.
    #[inline(always)]
    fn linear_texel(&self, lookup: &TextureLookup, point: &SurfacePoint) -> [f32; 3] {
        let texture = &self.textures[lookup.texture];
        texture::sample(texture, &self.linear, point.coordinates(lookup), texture.filter)
    }
}

/// A triangle in the transformed texture coordinates of `lookup`.
#[inline(always)]
fn texture_triangle(lookup: &TextureLookup, geometry: &Geometry, triangle: Hit) -> TextureTriangle {
    let mut corners = geometry.texture_coordinates_of(triangle, lookup.set);
    for corner in &mut corners {
        *corner = lookup.apply(*corner);
    }
    TextureTriangle::new(geometry, triangle, &corners)
}

/// Numbers the media of the materials. Those beyond the largest number count as air; the renderer refuses them.
fn number_media(materials: &mut [Material]) -> Vec<Medium> {
    let mut media = vec![Medium::AIR];
    let mut known = BTreeMap::new();
    for material in materials {
        let Some(medium) = material.scattering.medium() else { continue };
        let [r, g, b] = medium.absorption.map(f32::to_bits);
        let number = *known.entry([medium.ior.to_bits(), medium.dispersion.to_bits(), r, g, b]).or_insert_with(|| {
            media.push(medium);
            media.len() - 1
        });
        material.scattering.medium = MediumId::try_from(number).unwrap_or(0);
    }
    media
}

impl Material {
    /// Whether its color textures are filtered. Alpha selects the points of a texture that are seen, so that the mean
    /// over all would be wrong.
    #[inline(always)]
    fn is_filtered(&self) -> bool {
        !self.flags.has(MaterialFlags::ALPHA)
    }

    /// `any_dispersive`: whether any body of glass of the scene has dispersion.
    fn new(material: &holo_scene::Material, any_dispersive: bool) -> Self {
        let normal_map = material.normal_map.map(|NormalMap { texture, scale }| (TextureLookup::new(texture), scale));
        let emission = emission::Emission::new(material);
        let scattering = scattering::Scattering::new(material);
        let layers = layers::Layers::new(material, any_dispersive && scattering.medium().is_some());
        let flags = [
            (MaterialFlags::GLOSSY, (scattering.is_glossy() || layers.is_some()) && !material.unlit),
            (MaterialFlags::LAYERED, layers.is_some() && !material.unlit),
            (MaterialFlags::EMISSIVE, emission.is_emissive() && !material.unlit),
            (MaterialFlags::UNLIT, material.unlit),
            (MaterialFlags::NORMAL_MAP, normal_map.is_some()),
            (MaterialFlags::VOLUME, scattering.medium().is_some() && !material.unlit),
            (MaterialFlags::ALPHA, material.alpha != Alpha::Opaque),
            (MaterialFlags::BLEND, material.alpha == Alpha::Blend),
        ];
        Self {
            flags: flags
                .iter()
                .filter(|(_, has)| *has)
                .fold(MaterialFlags::default(), |all, (flag, _)| all.union(*flag)),
            base_color: material.base_color,
            base_color_texture: material.base_color_texture.map(TextureLookup::new),
            normal_map,
            alpha: material.alpha,
            emission,
            scattering,
            layers,
            reflective: u8::from(material.is_reflective()) + u8::from(material.is_transparent()),
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
