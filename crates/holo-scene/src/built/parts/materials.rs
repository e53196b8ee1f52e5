//! Materials.

use crate::{Alpha, Material, NormalMap, TextureInfo, TextureTransform, Volume};

/// A Lambertian material: paper, plaster, felt.
pub(crate) fn diffuse([r, g, b]: [f32; 3]) -> Material {
    Material { base_color: [r, g, b, 1.0], ..Material::default() }
}

/// A dielectric coat over diffuse: lacquer, glaze, polished stone.
pub(crate) fn glossy(color: [f32; 3], roughness: f32) -> Material {
    Material { roughness, specular: 1.0, ..diffuse(color) }
}

/// A metal with its color at normal incidence.
pub(crate) fn metal(color: [f32; 3], roughness: f32) -> Material {
    Material { metallic: 1.0, roughness, specular: 1.0, ..diffuse(color) }
}

pub(crate) const SILVER: [f32; 3] = [0.95, 0.93, 0.89];
pub(crate) const STEEL: [f32; 3] = [0.56, 0.57, 0.58];
pub(crate) const BRASS: [f32; 3] = [0.89, 0.70, 0.38];
pub(crate) const COPPER: [f32; 3] = [0.93, 0.60, 0.47];

/// A body of clear glass.
pub(crate) fn clear_glass() -> Material {
    body_of_glass(f32::INFINITY, [1.0; 3])
}

/// A body of glass whose transmittance is `color` after `distance` meters.
pub(crate) fn body_of_glass(distance: f32, color: [f32; 3]) -> Material {
    let volume = Some(Volume { attenuation_distance_m: distance, attenuation_color: color });
    Material { transmission: 1.0, roughness: 0.0, specular: 1.0, ior: 1.5, volume, ..diffuse([1.0; 3]) }
}

/// Adds a base color texture.
pub(crate) fn textured(texture: usize, material: Material) -> Material {
    Material { base_color_texture: Some(TextureInfo::new(texture)), ..material }
}

/// Adds a base color texture, scaled by `scale` repetitions.
pub(crate) fn repeated(texture: usize, scale: [f32; 2], material: Material) -> Material {
    Material { base_color_texture: Some(times(texture, scale)), ..material }
}

/// Adds a normal map, scaled by repetitions.
pub(crate) fn normal_mapped(texture: usize, times_across: [f32; 2], strength: f32, material: Material) -> Material {
    Material { normal_map: Some(NormalMap { texture: times(texture, times_across), scale: strength }), ..material }
}

/// Adds a metallic-roughness texture.
pub(crate) fn roughness_mapped(texture: usize, scale: [f32; 2], material: Material) -> Material {
    Material { metallic_roughness_texture: Some(times(texture, scale)), ..material }
}

/// Adds a base color texture with holes where its alpha is below one half.
pub(crate) fn alpha_masked(texture: usize, scale: [f32; 2], material: Material) -> Material {
    Material { alpha: Alpha::Mask(0.5), ..repeated(texture, scale, material) }
}

fn times(texture: usize, scale: [f32; 2]) -> TextureInfo {
    TextureInfo { transform: TextureTransform { scale, ..TextureTransform::IDENTITY }, ..TextureInfo::new(texture) }
}
