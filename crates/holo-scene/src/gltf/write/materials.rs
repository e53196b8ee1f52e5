//! Materials in glTF. Values equal to the defaults of the specification are omitted.

use serde_json::{Map, Value, json};

use super::super::extensions::{
    ANISOTROPY, CLEARCOAT, DIFFUSE_TRANSMISSION, DISPERSION, EMISSIVE_STRENGTH, IOR, IRIDESCENCE, SHEEN, SPECULAR,
    TEXTURE_TRANSFORM, TRANSMISSION, UNLIT, VOLUME,
};
use super::named;
use crate::{Alpha, Material, NormalMap, TextureInfo, TextureTransform};

/// The thickness of volumes, m. glTF requires a value for renderers that do not trace rays through the body.
const SOME_THICKNESS_M: f64 = 1.0;

/// A material; the loader gives an equal one.
pub(super) fn material(material: &Material) -> Value {
    let mut surface = json!({
        "baseColorFactor": material.base_color.map(f64::from),
        "metallicFactor": f64::from(material.metallic),
        "roughnessFactor": f64::from(material.roughness),
    });
    add_texture(&mut surface, "baseColorTexture", material.base_color_texture);
    add_texture(&mut surface, "metallicRoughnessTexture", material.metallic_roughness_texture);
    let mut value = json!({ "pbrMetallicRoughness": surface });
    if material.double_sided {
        add(&mut value, "doubleSided", true);
    }
    add_normal_map(&mut value, "normalTexture", material.normal_map);
    let (factor, strength) = split_emission(material.emission);
    if material.emission != [0.0; 3] {
        add(&mut value, "emissiveFactor", factor.to_vec());
    }
    add_texture(&mut value, "emissiveTexture", material.emission_texture);
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Mask(cutoff) => {
            add(&mut value, "alphaMode", "MASK");
            add(&mut value, "alphaCutoff", f64::from(cutoff));
        }
        Alpha::Blend => add(&mut value, "alphaMode", "BLEND"),
    }
    let extensions = extensions(material, strength);
    if !extensions.is_empty() {
        add(&mut value, "extensions", extensions);
    }
    named(&material.name, value)
}

/// The extensions of a material.
fn extensions(material: &Material, strength: f64) -> Map<String, Value> {
    let mut all = Map::new();
    let mut extension = |name: &str, value: Value| {
        if value.as_object().is_some_and(|fields| !fields.is_empty()) {
            all.insert(name.into(), value);
        }
    };
    let mut specular = json!({});
    if material.specular != 1.0 {
        add(&mut specular, "specularFactor", f64::from(material.specular));
    }
    if material.specular_color != [1.0; 3] {
        add(&mut specular, "specularColorFactor", material.specular_color.map(f64::from).to_vec());
    }
    add_texture(&mut specular, "specularTexture", material.specular_texture);
    add_texture(&mut specular, "specularColorTexture", material.specular_color_texture);
    extension(SPECULAR, specular);

    let mut transmission = json!({});
    if material.transmission != 0.0 {
        add(&mut transmission, "transmissionFactor", f64::from(material.transmission));
    }
    add_texture(&mut transmission, "transmissionTexture", material.transmission_texture);
    extension(TRANSMISSION, transmission);

    if let Some(volume) = &material.volume {
        let color = volume.attenuation_color.map(f64::from);
        let mut value = json!({ "thicknessFactor": SOME_THICKNESS_M, "attenuationColor": color });
        if volume.attenuation_distance_m.is_finite() {
            add(&mut value, "attenuationDistance", f64::from(volume.attenuation_distance_m));
        }
        extension(VOLUME, value);
    }
    if material.ior != 1.5 {
        extension(IOR, json!({ "ior": f64::from(material.ior) }));
    }
    if strength != 1.0 {
        extension(EMISSIVE_STRENGTH, json!({ "emissiveStrength": strength }));
    }
    add_layers(material, &mut all);
    if material.unlit {
        all.insert(UNLIT.into(), json!({}));
    }
    all
}

/// The extensions for layers and rare lobes, with all their factors.
fn add_layers(material: &Material, all: &mut Map<String, Value>) {
    let color = |color: [f32; 3]| color.map(f64::from).to_vec();
    if let Some(coat) = material.clearcoat {
        let mut value = json!({
            "clearcoatFactor": f64::from(coat.factor),
            "clearcoatRoughnessFactor": f64::from(coat.roughness),
        });
        add_texture(&mut value, "clearcoatTexture", coat.texture);
        add_texture(&mut value, "clearcoatRoughnessTexture", coat.roughness_texture);
        add_normal_map(&mut value, "clearcoatNormalTexture", coat.normal_map);
        all.insert(CLEARCOAT.into(), value);
    }
    if let Some(sheen) = material.sheen {
        let roughness = f64::from(sheen.roughness);
        let mut value = json!({ "sheenColorFactor": color(sheen.color), "sheenRoughnessFactor": roughness });
        add_texture(&mut value, "sheenColorTexture", sheen.color_texture);
        add_texture(&mut value, "sheenRoughnessTexture", sheen.roughness_texture);
        all.insert(SHEEN.into(), value);
    }
    if let Some(anisotropy) = material.anisotropy {
        let (strength, rotation) = (f64::from(anisotropy.strength), f64::from(anisotropy.rotation_rad));
        let mut value = json!({ "anisotropyStrength": strength, "anisotropyRotation": rotation });
        add_texture(&mut value, "anisotropyTexture", anisotropy.texture);
        all.insert(ANISOTROPY.into(), value);
    }
    if let Some(film) = material.iridescence {
        let [least, most] = film.thickness_nm.map(f64::from);
        let mut value = json!({
            "iridescenceFactor": f64::from(film.factor),
            "iridescenceIor": f64::from(film.ior),
            "iridescenceThicknessMinimum": least,
            "iridescenceThicknessMaximum": most,
        });
        add_texture(&mut value, "iridescenceTexture", film.texture);
        add_texture(&mut value, "iridescenceThicknessTexture", film.thickness_texture);
        all.insert(IRIDESCENCE.into(), value);
    }
    if material.dispersion != 0.0 {
        all.insert(DISPERSION.into(), json!({ "dispersion": f64::from(material.dispersion) }));
    }
    if let Some(through) = material.diffuse_transmission {
        let mut value = json!({
            "diffuseTransmissionFactor": f64::from(through.factor),
            "diffuseTransmissionColorFactor": color(through.color),
        });
        add_texture(&mut value, "diffuseTransmissionTexture", through.texture);
        add_texture(&mut value, "diffuseTransmissionColorTexture", through.color_texture);
        all.insert(DIFFUSE_TRANSMISSION.into(), value);
    }
}

/// Splits an emission into a factor within 0..1, as required by glTF, and a power of two, by which division and
/// multiplication are exact.
fn split_emission(emission: [f32; 3]) -> ([f64; 3], f64) {
    let emission = emission.map(f64::from);
    let largest = emission.iter().fold(0.0_f64, |largest, &c| largest.max(c));
    let mut strength = 1.0_f64;
    while strength < largest {
        strength *= 2.0;
    }
    (emission.map(|c| c / strength), strength)
}

fn texture_use(used: TextureInfo) -> Value {
    let mut info = json!({ "index": used.texture });
    if used.set != 0 {
        add(&mut info, "texCoord", used.set);
    }
    let TextureTransform { offset, rotation_rad, scale } = used.transform;
    if used.transform != TextureTransform::IDENTITY {
        let (offset, scale) = (offset.map(f64::from), scale.map(f64::from));
        let transform = json!({ "offset": offset, "rotation": f64::from(rotation_rad), "scale": scale });
        add(&mut info, "extensions", json!({ TEXTURE_TRANSFORM: transform }));
    }
    info
}

fn add_normal_map(object: &mut Value, key: &str, map: Option<NormalMap>) {
    if let Some(map) = map {
        let mut info = texture_use(map.texture);
        add(&mut info, "scale", f64::from(map.scale));
        add(object, key, info);
    }
}

fn add_texture(object: &mut Value, key: &str, used: Option<TextureInfo>) {
    if let Some(used) = used {
        add(object, key, texture_use(used));
    }
}

fn add(object: &mut Value, key: &str, value: impl Into<Value>) {
    if let Value::Object(map) = object {
        map.insert(key.into(), value.into());
    }
}
