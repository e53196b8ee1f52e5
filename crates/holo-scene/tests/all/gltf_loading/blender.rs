//! What users of Blender meet: missing cameras, units of lights, glass without a volume.

use holo_scene::gltf::{LightUnits, LoadOptions, Loaded, load_slice_with};
use serde_json::{Value, json};

use super::support::{File, assert_contains, triangle};

const GENERATOR: &str = "Khronos glTF Blender I/O v4.5.48";

fn load(file: &File, change: impl FnOnce(&mut LoadOptions)) -> Loaded {
    let mut options = LoadOptions::default();
    change(&mut options);
    load_slice_with(&file.glb(), &options).unwrap()
}

#[test]
fn cameras_and_lights_must_be_exported() {
    let mut file = triangle();
    let (camera, light) = ("Include > Cameras", "Include > Punctual Lights");
    assert!(file.load().unwrap().warnings.is_empty(), "not from Blender");
    file.json["asset"]["generator"] = json!(GENERATOR);
    assert_contains(&file.load().unwrap().warnings.join("\n"), &["no camera and no light", camera, light]);
    let mut lit = lights(json!([point(3.0)]));
    lit.json["cameras"] = json!([]);
    lit.json["nodes"][1] = json!({});
    let warnings = lit.load().unwrap().warnings.join("\n");
    assert_contains(&warnings, &["no camera:", camera]);
    assert!(!warnings.contains(light), "{warnings}");
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1 } }]);
    file.push("nodes", json!({ "camera": 0 }));
    assert_contains(&file.load().unwrap().warnings.join("\n"), &["no light:", light, "area lights"]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [point(3.0)] } });
    file.push("nodes", json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    assert_eq!(file.load().unwrap().warnings, [""; 0]);
}

#[test]
fn the_summary_names_thin_glass_and_guesses_the_unit_of_lights() {
    let lights_of = |file: &File| file.load().unwrap().summary.light_units;
    assert_eq!(lights_of(&triangle()), None);
    let standard = lights(json!([point(candela(1000.0))]));
    assert_eq!(lights_of(&standard), Some(LightUnits::Blender));
    assert_eq!(lights_of(&lights(json!([point(3.21)]))), Some(LightUnits::Gltf));
    // What the file has, whichever unit it is loaded with.
    let loaded = load(&standard, |options| options.light_units = LightUnits::Blender);
    assert_eq!(loaded.summary.light_units, Some(LightUnits::Blender));
    let thin = |solid| load(&glass(), |options| options.solid_glass = solid).summary;
    assert_eq!(thin(false).thin_glass, [(0, "glass".to_owned())]);
    assert_contains(&thin(false).to_string(), &["thin glass:", "0 'glass'", "no refraction"]);
    // The pane of a single triangle stays thin.
    assert_eq!(thin(true).thin_glass.len(), 1);
}

/// A file of Blender with a camera and these lights, each with a node.
fn lights(lights: Value) -> File {
    let mut file = triangle();
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1 } }]);
    file.push("nodes", json!({ "camera": 0 }));
    file.json["asset"]["generator"] = json!(GENERATOR);
    for k in 0..lights.as_array().unwrap().len() {
        file.push("nodes", json!({ "extensions": { "KHR_lights_punctual": { "light": k } } }));
    }
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    file
}

fn point(intensity: f64) -> Value {
    json!({ "type": "point", "intensity": intensity })
}

fn sun(intensity: f64) -> Value {
    json!({ "type": "directional", "intensity": intensity })
}

/// The candela that Blender's exporter writes for a lamp of so many watts, in single precision as there.
fn candela(watts: f64) -> f64 {
    f64::from((watts * 683.0 / (4.0 * std::f64::consts::PI)) as f32)
}

#[test]
fn lights_in_standard_units_are_recognized() {
    let standard = [
        json!([point(candela(1000.0))]),
        json!([point(candela(0.25)), sun(683.0), point(0.0)]),
        json!([sun(683.0 * 3.5), { "type": "spot", "intensity": candela(60.0) }]),
        // Not round, but far above what other modes write.
        json!([point(12_345.678), sun(2_049.17)]),
    ];
    for lights in standard.map(lights) {
        let loaded = lights.load().unwrap();
        assert_contains(&loaded.warnings.join("\n"), &["candela and lux", "683", "Unitless"]);
        let auto = load(&lights, |options| options.light_units = LightUnits::Auto);
        assert_eq!(auto.warnings, [""; 0]);
        for (light, in_blender) in loaded.scene.lights.iter().zip(&auto.scene.lights) {
            assert_eq!(light.intensity.map(|c| c / 683.0), in_blender.intensity);
        }
    }
    // Unitless, raw, another program, and one light of several that does not fit.
    let unitless = json!([point(1000.0 / (4.0 * std::f64::consts::PI)), sun(3.0)]);
    let mixed = json!([point(candela(1000.0)), point(3.0)]);
    let mut other = lights(json!([point(candela(1000.0))]));
    other.json["asset"]["generator"] = json!("three.js");
    for file in [lights(unitless), lights(json!([point(1000.0), sun(1.0)])), lights(mixed), other] {
        let loaded = file.load().unwrap();
        assert_eq!(loaded.warnings, [""; 0]);
        assert_eq!(load(&file, |options| options.light_units = LightUnits::Auto), loaded);
        // On request in any case.
        let blender = load(&file, |options| options.light_units = LightUnits::Blender);
        assert_eq!(blender.scene.lights[0].intensity, loaded.scene.lights[0].intensity.map(|c| c / 683.0));
    }
}

/// Two bodies of the same glass: a closed one and a single triangle.
fn glass() -> File {
    let mut file = triangle();
    let positions = file.floats(&[[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let indices = file.indices_u16(&[0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]);
    file.push(
        "materials",
        json!({ "name": "glass", "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } } }),
    );
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.show(json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": 0 }));
    file
}

#[test]
fn closed_bodies_of_thin_glass() {
    let mut file = glass();
    let loaded = file.load().unwrap();
    assert_contains(
        &loaded.warnings.join("\n"),
        &["materials[0] 'glass'", "thin pane", "soap bubble", "`solid-glass`", "thickness"],
    );
    assert_eq!(loaded.scene.materials.len(), 1);
    let solid = load(&file, |options| options.solid_glass = true);
    assert_eq!(solid.warnings, [""; 0]);
    let volumes: Vec<bool> =
        solid.scene.meshes.iter().map(|mesh| solid.scene.materials[mesh.material].volume.is_some()).collect();
    assert_eq!(volumes, [false, true], "the pane stays a pane");
    // An open mesh, or one with a volume, needs no advice.
    file.json["materials"][0]["extensions"]["KHR_materials_volume"] = json!({ "thicknessFactor": 1 });
    assert_eq!(file.load().unwrap().warnings, [""; 0]);
    let mut open = glass();
    open.json["accessors"][2]["count"] = json!(9);
    assert_eq!(open.load().unwrap().warnings, [""; 0]);
}
