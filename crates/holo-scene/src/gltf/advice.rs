//! What users of Blender meet: exports without cameras and lights, glass without a volume, and lights in candela beside
//! emission in Blender's own unit.

mod closed;

use std::f64::consts::PI;

use super::extensions::LIGHTS;
use super::json::Object;
use super::options::{LightUnits, LoadOptions};
use super::uri::shorten;
use super::warnings::Warnings;
use crate::{Error, Material, Scene, Volume};

/// Lumens of a watt in Blender's exporter with the lighting mode "Standard"; without it, its numbers are the watts.
const LUMENS_PER_WATT: f64 = 683.0;
/// The relative error of numbers that were single precision in Blender, with some room.
const SINGLE_PRECISION: f64 = 2e-6;
/// Candela of a lamp, and lux of a sun, that only the mode "Standard" makes of usual strengths: those of 92 W and of
/// 0.1 W/m2 there would be 63 kW and 68 W/m2 without it.
const STANDARD_CANDELA: f64 = 5000.0;
const STANDARD_LUX: f64 = 68.0;

/// Applies the options about lights and glass to a scene, and adds the warnings. Returns the unit that the lights of the
/// file seem to have, if there are any.
pub(super) fn apply(
    root: &Object<'_>,
    scene: &mut Scene,
    options: &LoadOptions,
    warnings: &mut Warnings,
) -> Result<Option<LightUnits>, Error> {
    let from_blender = is_from_blender(root)?;
    if from_blender {
        not_exported(scene, warnings);
    }
    let units = light_units(root, scene, options.light_units, from_blender, warnings)?;
    glass(scene, options.solid_glass, warnings);
    Ok(units)
}

fn is_from_blender(root: &Object<'_>) -> Result<bool, Error> {
    let Some(asset) = root.object("asset")? else { return Ok(false) };
    Ok(asset.string("generator")?.is_some_and(|generator| generator.contains("Blender")))
}

/// Warns of what Blender's exporter omits unless it is told otherwise: cameras and lights.
fn not_exported(scene: &Scene, warnings: &mut Warnings) {
    let text = match (scene.cameras.is_empty(), scene.lights.is_empty()) {
        (true, true) => {
            "the file has no camera and no light: \
             in Blender's export dialog tick Include > Cameras and Include > Punctual Lights"
        }
        (true, false) => "the file has no camera: in Blender's export dialog tick Include > Cameras",
        (false, true) => {
            "the file has no light: if the scene has any, tick Include > Punctual Lights in Blender's export dialog; \
             area lights and the world are never exported"
        }
        (false, false) => return,
    };
    warnings.note(text, String::new);
}

fn light_units(
    root: &Object<'_>,
    scene: &mut Scene,
    units: LightUnits,
    from_blender: bool,
    warnings: &mut Warnings,
) -> Result<Option<LightUnits>, Error> {
    if scene.lights.is_empty() {
        return Ok(None);
    }
    let standard = from_blender && all_look_standard(root)?;
    if units == LightUnits::Blender || units == LightUnits::Auto && standard {
        for light in &mut scene.lights {
            light.intensity = light.intensity.map(|c| c / LUMENS_PER_WATT);
        }
    } else if standard {
        let text = "the lights seem to be exported with Blender's Lighting Mode: Standard, in candela and lux: \
            683 times as bright as in Blender beside emission and sky; \
            export with Lighting Mode: Unitless, or load with `light-units blender`";
        warnings.note(text, String::new);
    }
    Ok(Some(if standard { LightUnits::Blender } else { LightUnits::Gltf }))
}

/// Whether all lights of a file look like those of Blender's lighting mode "Standard", which a file does not tell.
///
/// That mode makes of W watts 683 W / (4 pi) candela, and of a sun of S W/m2 683 S lux. People type round numbers, so
/// that W or S has at most three digits; or the number is far above those of the other modes.
fn all_look_standard(root: &Object<'_>) -> Result<bool, Error> {
    let Some(extension) = root.extension(LIGHTS)? else { return Ok(false) };
    let mut any = false;
    for light in extension.objects("lights")? {
        let intensity = light.number("intensity")?.unwrap_or(1.0);
        if intensity == 0.0 {
            continue;
        }
        let (strength, large) = match light.string("type")? {
            Some("directional") => (intensity / LUMENS_PER_WATT, STANDARD_LUX),
            _ => (intensity * 4.0 * PI / LUMENS_PER_WATT, STANDARD_CANDELA),
        };
        if !is_round(strength) && intensity < large {
            return Ok(false);
        }
        any = true;
    }
    Ok(any)
}

/// Whether a number has at most three digits, within single precision.
fn is_round(x: f64) -> bool {
    if !(x > 0.0 && x.is_finite()) {
        return false;
    }
    // Three digits before the point.
    let scaled = x / 10_f64.powi(x.log10().floor() as i32 - 2);
    (scaled - scaled.round()).abs() <= scaled * SINGLE_PRECISION
}

/// Whether a material is a pane without refraction.
pub(super) fn is_thin_glass(material: &Material) -> bool {
    material.transmission > 0.0 && material.volume.is_none()
}

/// Closed bodies with transmission but without a volume become solid, or cause a warning.
fn glass(scene: &mut Scene, solid: bool, warnings: &mut Warnings) {
    let is_thin = |k: usize, scene: &Scene| scene.materials.get(k).is_some_and(is_thin_glass);
    // For each material its solid copy.
    let mut copies = std::collections::BTreeMap::new();
    for k in 0..scene.meshes.len() {
        let material = scene.meshes[k].material;
        if !is_thin(material, scene) || !closed::is_closed(&scene.meshes[k]) {
            continue;
        }
        if solid {
            let copy = *copies.entry(material).or_insert_with(|| {
                let mut copy = scene.materials[material].clone();
                copy.volume = Some(Volume { attenuation_distance_m: f32::INFINITY, attenuation_color: [1.0; 3] });
                scene.materials.push(copy);
                scene.materials.len() - 1
            });
            scene.meshes[k].material = copy;
        } else {
            let name = shorten(&scene.materials[material].name);
            let text = "transmission without a volume on a closed body: drawn as a thin pane, like a soap bubble; \
                `solid-glass` treats closed bodies as solid, or give the material a thickness (KHR_materials_volume)";
            warnings.note(text, || format!("materials[{material}] '{name}'"));
        }
    }
}
