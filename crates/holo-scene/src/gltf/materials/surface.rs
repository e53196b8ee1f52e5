//! One material of a file: metallic-roughness, and the extensions for specular reflection, transmission, volumes and
//! emission.
//!
//! Sources: the glTF 2.0 specification, sections 3.9 and 5.19; KHR_materials_emissive_strength, _ior, _specular,
//! _transmission, _unlit, _volume; KHR_texture_transform. A number out of range is an error, except for values that
//! exporters are known to write: see [`Shares`], [`emission`], [`index_of_refraction`] and [`volume`].

use super::super::extensions::{EMISSIVE_STRENGTH, IOR, SPECULAR, TRANSMISSION, UNLIT, VOLUME};
use super::super::json::{Object, bad};
use super::super::warnings::Warnings;
use super::numbers::{MAX_IOR, Shares, normal_map, texture_use};
use crate::Error;
use crate::MAX_RADIANCE;
use crate::{Alpha, Material, Volume};

/// The default material of the specification: rough white metal that does not emit on the back.
pub(super) fn standard(name: &str) -> Material {
    Material {
        name: name.to_owned(),
        metallic: 1.0,
        roughness: 1.0,
        double_sided: false,
        specular: 1.0,
        ..Material::default()
    }
}

/// Reads a material; textures and texture coordinate sets have the numbers of the file.
pub(super) fn read(
    material: &Object<'_>,
    name: &str,
    texture_count: usize,
    place: impl Fn() -> String,
    warnings: &mut Warnings,
) -> Result<Material, Error> {
    let texture = |object: &Object<'_>, key: &str| texture_use(object, key, texture_count);
    let mut read = standard(name);
    let mut shares = Shares::default();
    if let Some(surface) = material.object("pbrMetallicRoughness")? {
        set(&mut read.base_color, shares.all(&surface, "baseColorFactor")?);
        read.base_color_texture = texture(&surface, "baseColorTexture")?;
        set(&mut read.metallic, shares.one(&surface, "metallicFactor")?);
        set(&mut read.roughness, shares.one(&surface, "roughnessFactor")?);
        read.metallic_roughness_texture = texture(&surface, "metallicRoughnessTexture")?;
    }
    read.normal_map = normal_map(material, "normalTexture", texture_count)?;
    read.emission = emission(material, &place, warnings)?;
    read.emission_texture = texture(material, "emissiveTexture")?;
    read.alpha = match material.string("alphaMode")? {
        None | Some("OPAQUE") => Alpha::Opaque,
        Some("MASK") => Alpha::Mask(material.within("alphaCutoff", 0.0..=f32::MAX)?.unwrap_or(0.5)),
        Some("BLEND") => Alpha::Blend,
        Some(_) => return Err(bad(material.at("alphaMode"), "must be OPAQUE, MASK or BLEND")),
    };
    set(&mut read.double_sided, material.boolean("doubleSided")?);
    if let Some(specular) = material.extension(SPECULAR)? {
        set(&mut read.specular, shares.one(&specular, "specularFactor")?);
        read.specular_texture = texture(&specular, "specularTexture")?;
        set(&mut read.specular_color, specular.all_within("specularColorFactor", 0.0..=MAX_RADIANCE)?);
        read.specular_color_texture = texture(&specular, "specularColorTexture")?;
    }
    set(&mut read.ior, index_of_refraction(material, &place, warnings)?);
    if let Some(transmission) = material.extension(TRANSMISSION)? {
        set(&mut read.transmission, shares.one(&transmission, "transmissionFactor")?);
        read.transmission_texture = texture(&transmission, "transmissionTexture")?;
    }
    read.volume = volume(material, &mut shares, &place, warnings)?;
    super::layers::read(material, texture_count, &mut shares, &mut read)?;
    shares.note(&place, warnings);
    read.unlit = material.extension(UNLIT)?.is_some();
    Ok(read)
}

/// Sets a field if the file has a value for it.
fn set<T>(field: &mut T, said: Option<T>) {
    if let Some(said) = said {
        *field = said;
    }
}

/// Emissive factor times strength, multiplied in f64. glTF wants factors up to 1, but exporters write more.
fn emission(material: &Object<'_>, place: impl Fn() -> String, warnings: &mut Warnings) -> Result<[f32; 3], Error> {
    let within = material.all_within::<3>("emissiveFactor", 0.0..=MAX_RADIANCE)?;
    if within.is_some_and(|factor| factor.iter().any(|&c| c > 1.0)) {
        warnings.note("its emissiveFactor is above the 1 that glTF allows: used as it is", place);
    }
    let factor = material.numbers::<3>("emissiveFactor")?.unwrap_or_default();
    let Some(extension) = material.extension(EMISSIVE_STRENGTH)? else { return Ok(factor.map(|c| c as f32)) };
    extension.within("emissiveStrength", 0.0..=f32::MAX)?;
    let strength = extension.number("emissiveStrength")?.unwrap_or(1.0);
    let emission = factor.map(|c| c * strength);
    if emission.iter().any(|&c| c > f64::from(MAX_RADIANCE)) {
        let what = format!("is {strength}; times emissiveFactor it must not exceed {MAX_RADIANCE:e}");
        return Err(bad(extension.at("emissiveStrength"), what));
    }
    Ok(emission.map(|c| c as f32))
}

/// 0 means infinity in a file; that and anything above [`MAX_IOR`] is clamped, with a warning.
fn index_of_refraction(
    material: &Object<'_>,
    place: impl Fn() -> String,
    warnings: &mut Warnings,
) -> Result<Option<f32>, Error> {
    let Some(extension) = material.extension(IOR)? else { return Ok(None) };
    let ior = match extension.number("ior")? {
        Some(0.0) => f64::INFINITY,
        Some(ior) if ior < 1.0 => {
            return Err(bad(extension.at("ior"), format!("is {ior}; it must be at least 1, or 0 for infinity")));
        }
        Some(ior) => ior,
        None => return Ok(None),
    };
    if ior > f64::from(MAX_IOR) {
        warnings.note("an index of refraction of 0 (infinity) or above 1000 is drawn as 1000", place);
    }
    Ok(Some((ior as f32).min(MAX_IOR)))
}

/// The volume that the surface encloses; `None` for thin walls.
fn volume(
    material: &Object<'_>,
    shares: &mut Shares,
    place: impl Fn() -> String,
    warnings: &mut Warnings,
) -> Result<Option<Volume>, Error> {
    let Some(extension) = material.extension(VOLUME)? else { return Ok(None) };
    let distance = match extension.number("attenuationDistance")? {
        // 0 is not allowed, but some exporters write it for "none".
        None | Some(0.0) => f32::INFINITY,
        // From the smallest f32 on; values above the largest become infinity, which is allowed here.
        Some(distance) if distance >= f64::from(f32::from_bits(1)) => distance as f32,
        Some(distance) => {
            return Err(bad(extension.at("attenuationDistance"), format!("is {distance}; it must be above 0")));
        }
    };
    // Black is clamped to the smallest normal f32, whose logarithm is finite.
    let color = shares.all::<3>(&extension, "attenuationColor")?.unwrap_or([1.0; 3]);
    let attenuation_color = color.map(|c| c.max(f32::MIN_POSITIVE));
    // The renderer traces rays through the body, so only matters whether the thickness is above 0.
    if extension.within("thicknessFactor", 0.0..=f32::MAX)?.unwrap_or(0.0) == 0.0 {
        return Ok(None);
    }
    if extension.has("thicknessTexture") {
        warnings.note("thickness textures are ignored: rays find the thickness of a body themselves", place);
    }
    Ok(Some(Volume { attenuation_distance_m: distance, attenuation_color }))
}
