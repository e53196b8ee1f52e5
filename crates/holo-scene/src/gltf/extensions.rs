//! The glTF extensions of a file, and the warnings and errors for those that are not supported.

use std::collections::BTreeSet;

use serde_json::Value;

use super::json::{Object, unsupported};
use super::uri::shorten;
use super::warnings::Warnings;
use crate::Error;

pub(super) const LIGHTS: &str = "KHR_lights_punctual";
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
pub(super) const IOR: &str = "KHR_materials_ior";
pub(super) const SPECULAR: &str = "KHR_materials_specular";
pub(super) const TRANSMISSION: &str = "KHR_materials_transmission";
pub(super) const UNLIT: &str = "KHR_materials_unlit";
pub(super) const VOLUME: &str = "KHR_materials_volume";
pub(super) const CLEARCOAT: &str = "KHR_materials_clearcoat";
pub(super) const SHEEN: &str = "KHR_materials_sheen";
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";
pub(super) const IRIDESCENCE: &str = "KHR_materials_iridescence";
pub(super) const DISPERSION: &str = "KHR_materials_dispersion";
pub(super) const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";
pub(super) const NODE_VISIBILITY: &str = "KHR_node_visibility";
pub(super) const ANIMATION_POINTER: &str = "KHR_animation_pointer";
pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
pub(super) const VARIANTS: &str = "KHR_materials_variants";
pub(super) const TEXTURE_WEBP: &str = "EXT_texture_webp";
pub(super) const TEXTURE_BASISU: &str = "KHR_texture_basisu";
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const MESHOPT: &str = "EXT_meshopt_compression";
pub(super) const MESHOPT_KHR: &str = "KHR_meshopt_compression";
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// What removes the compression of a file; part of the messages about compressed data that cannot be read.
pub(super) const DECOMPRESS: &str = "npx @gltf-transform/cli copy in.glb out.glb";

/// The supported extensions.
pub(super) const HANDLED: &[&str] = &[
    LIGHTS,
    EMISSIVE_STRENGTH,
    IOR,
    SPECULAR,
    TRANSMISSION,
    UNLIT,
    VOLUME,
    CLEARCOAT,
    SHEEN,
    ANISOTROPY,
    IRIDESCENCE,
    DISPERSION,
    DIFFUSE_TRANSMISSION,
    TEXTURE_TRANSFORM,
    MESHOPT,
    MESHOPT_KHR,
    QUANTIZATION,
    #[cfg(feature = "draco")]
    DRACO,
    INSTANCING,
    NODE_VISIBILITY,
    ANIMATION_POINTER,
    SPECULAR_GLOSSINESS,
    VARIANTS,
    TEXTURE_WEBP,
    TEXTURE_BASISU,
];

/// The extensions of a file, sorted, each once.
pub(super) struct Extensions {
    pub(super) used: Vec<String>,
    pub(super) required: Vec<String>,
}

/// Lists the extensions; adds warnings for used extensions that are not supported.
///
/// # Errors
/// A required extension that is not supported.
pub(super) fn check(file: &Value, root: &Object<'_>, warnings: &mut Warnings) -> Result<Extensions, Error> {
    let names = |key: &str| -> Result<BTreeSet<String>, Error> {
        let list = root.list(key)?.iter().enumerate();
        let name = |(k, value): (usize, &Value)| {
            let text = value.as_str().map(str::to_owned);
            text.ok_or_else(|| super::json::bad(format!("{key}[{k}]"), "must be a string"))
        };
        list.map(name).collect()
    };
    let required = names("extensionsRequired")?;
    let mut used = names("extensionsUsed")?;
    used.extend(required.iter().cloned());
    // Some files do not declare the extensions that they use.
    find(file, &mut used);

    let unhandled = |names: &BTreeSet<String>| -> Vec<String> {
        names.iter().filter(|name| !HANDLED.contains(&name.as_str())).map(|name| shorten(name)).collect()
    };
    let missing = unhandled(&required);
    if !missing.is_empty() {
        // Alone, it is one of this build.
        let cure = if missing == [DRACO] { DECOMPRESS } else { "export the file again without it" };
        let what = format!("the required extension {} ({cure})", missing.join(", "));
        return Err(unsupported("extensionsRequired", what));
    }
    let (materials, others): (Vec<_>, Vec<_>) =
        unhandled(&used).into_iter().partition(|name| name.contains("_materials_") || name.contains("_texture_"));
    let mut warn = |names: Vec<String>, text: &str| {
        if !names.is_empty() {
            warnings.note(&format!("{}: {text}", names.join(", ")), String::new);
        }
    };
    warn(materials, "used but not modeled: surfaces are drawn without");
    warn(others, "used but not handled: ignored");
    Ok(Extensions { used: used.into_iter().collect(), required: required.into_iter().collect() })
}

/// Collects the keys of every `extensions` object. The JSON parser limits the depth, so recursion is safe.
pub(super) fn find(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Array(list) => list.iter().for_each(|value| find(value, names)),
        Value::Object(map) => {
            for (key, value) in map.iter().filter(|(key, _)| *key != "extras") {
                if let (true, Value::Object(extensions)) = (key == "extensions", value) {
                    names.extend(extensions.keys().filter(|name| !names.contains(*name)).cloned().collect::<Vec<_>>());
                }
                find(value, names);
            }
        }
        _ => {}
    }
}
