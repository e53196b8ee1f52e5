//! The extensions for layers and rare lobes: KHR_materials_clearcoat, _sheen, _anisotropy, _iridescence, _dispersion
//! and _diffuse_transmission.

use super::super::extensions::{ANISOTROPY, CLEARCOAT, DIFFUSE_TRANSMISSION, DISPERSION, IRIDESCENCE, SHEEN};
use super::super::json::{Object, bad};
use super::numbers::{MAX_IOR, Shares, normal_map, texture_use};
use crate::Error;
use crate::{Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, Sheen};

/// Reads the extensions of a material.
pub(super) fn read(
    material: &Object<'_>,
    texture_count: usize,
    shares: &mut Shares,
    read: &mut Material,
) -> Result<(), Error> {
    let texture = |object: &Object<'_>, key: &str| texture_use(object, key, texture_count);
    if let Some(extension) = material.extension(CLEARCOAT)? {
        read.clearcoat = Some(Clearcoat {
            factor: shares.one(&extension, "clearcoatFactor")?.unwrap_or(0.0),
            texture: texture(&extension, "clearcoatTexture")?,
            roughness: shares.one(&extension, "clearcoatRoughnessFactor")?.unwrap_or(0.0),
            roughness_texture: texture(&extension, "clearcoatRoughnessTexture")?,
            normal_map: normal_map(&extension, "clearcoatNormalTexture", texture_count)?,
        });
    }
    if let Some(extension) = material.extension(SHEEN)? {
        read.sheen = Some(Sheen {
            color: shares.all(&extension, "sheenColorFactor")?.unwrap_or([0.0; 3]),
            color_texture: texture(&extension, "sheenColorTexture")?,
            roughness: shares.one(&extension, "sheenRoughnessFactor")?.unwrap_or(0.0),
            roughness_texture: texture(&extension, "sheenRoughnessTexture")?,
        });
    }
    if let Some(extension) = material.extension(ANISOTROPY)? {
        read.anisotropy = Some(Anisotropy {
            strength: shares.one(&extension, "anisotropyStrength")?.unwrap_or(0.0),
            rotation_rad: extension.within("anisotropyRotation", f32::MIN..=f32::MAX)?.unwrap_or(0.0),
            texture: texture(&extension, "anisotropyTexture")?,
        });
    }
    if let Some(extension) = material.extension(IRIDESCENCE)? {
        let defaults = Iridescence::default();
        let thickness = |key: &str| extension.within(key, 0.0..=f32::MAX);
        read.iridescence = Some(Iridescence {
            factor: shares.one(&extension, "iridescenceFactor")?.unwrap_or(defaults.factor),
            texture: texture(&extension, "iridescenceTexture")?,
            ior: film_index(&extension)?.unwrap_or(defaults.ior),
            thickness_nm: [
                thickness("iridescenceThicknessMinimum")?.unwrap_or(defaults.thickness_nm[0]),
                thickness("iridescenceThicknessMaximum")?.unwrap_or(defaults.thickness_nm[1]),
            ],
            thickness_texture: texture(&extension, "iridescenceThicknessTexture")?,
        });
    }
    if let Some(extension) = material.extension(DISPERSION)? {
        read.dispersion = extension.within("dispersion", 0.0..=f32::MAX)?.unwrap_or(0.0);
    }
    if let Some(extension) = material.extension(DIFFUSE_TRANSMISSION)? {
        read.diffuse_transmission = Some(DiffuseTransmission {
            factor: shares.one(&extension, "diffuseTransmissionFactor")?.unwrap_or(0.0),
            texture: texture(&extension, "diffuseTransmissionTexture")?,
            color: shares.all(&extension, "diffuseTransmissionColorFactor")?.unwrap_or([1.0; 3]),
            color_texture: texture(&extension, "diffuseTransmissionColorTexture")?,
        });
    }
    Ok(())
}

/// The index of refraction of a film, at least 1; above [`MAX_IOR`] it is that.
fn film_index(extension: &Object<'_>) -> Result<Option<f32>, Error> {
    match extension.number("iridescenceIor")? {
        Some(ior) if ior < 1.0 => Err(bad(extension.at("iridescenceIor"), format!("is {ior}; it must be at least 1"))),
        ior => Ok(ior.map(|ior| (ior as f32).min(MAX_IOR))),
    }
}
