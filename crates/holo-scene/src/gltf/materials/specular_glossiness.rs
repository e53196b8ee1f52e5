//! `KHR_materials_pbrSpecularGlossiness`: diffuse color, reflectance at normal incidence, and glossiness.
//!
//! The diffuse color becomes the base color of a dielectric, and the specular color its reflectance: with the index 1.5,
//! whose reflectance is 0.04, a `specular_color` of 25 times the color gives exactly that color at normal incidence.
//! Roughness is 1 - glossiness, also in the texture, which is computed from the alpha of `specularGlossinessTexture`.
//!
//! The extension dims the diffuse color by 1 - max(specular); the renderer dims it by what its coat reflects, so that
//! both agree for weak reflections only. Source: the archived specification of the extension.

use super::super::json::Object;
use super::super::textures::Derived;
use super::super::warnings::Warnings;
use super::numbers::{Shares, texture_use};
use crate::{Error, Material};

/// 1 / 0.04, the inverse of the reflectance of the index 1.5.
const INVERSE_REFLECTANCE: f32 = 25.0;

const APPROXIMATION: &str =
    "specular-glossiness is drawn as a dielectric with that reflectance; its diffuse part differs slightly";

/// Changes a material to that of the extension. Returns the texture of its roughness if there is one; it has the
/// coordinates of [`Material::specular_color_texture`].
pub(super) fn read(
    extension: &Object<'_>,
    texture_count: usize,
    material: &mut Material,
    place: impl Fn() -> String,
    warnings: &mut Warnings,
) -> Result<Option<Derived>, Error> {
    let mut shares = Shares::default();
    material.base_color = shares.all(extension, "diffuseFactor")?.unwrap_or([1.0; 4]);
    material.base_color_texture = texture_use(extension, "diffuseTexture", texture_count)?;
    material.metallic = 0.0;
    material.ior = 1.5;
    material.specular = 1.0;
    material.specular_texture = None;
    let specular = shares.all::<3>(extension, "specularFactor")?.unwrap_or([1.0; 3]);
    material.specular_color = specular.map(|c| c * INVERSE_REFLECTANCE);
    material.specular_color_texture = texture_use(extension, "specularGlossinessTexture", texture_count)?;
    let glossiness = shares.one(extension, "glossinessFactor")?.unwrap_or(1.0);
    shares.note(&place, warnings);
    warnings.note(APPROXIMATION, place);
    material.metallic_roughness_texture = None;
    let Some(texture) = material.specular_color_texture else {
        material.roughness = 1.0 - glossiness;
        return Ok(None);
    };
    material.roughness = 1.0;
    Ok(Some(Derived { source: texture.texture, glossiness }))
}
