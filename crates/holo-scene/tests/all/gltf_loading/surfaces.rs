//! Material parameters: defaults, values and errors of metallic-roughness and of every extension.

use holo_scene::{
    Alpha, Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, NormalMap, Sheen, TextureInfo,
    TextureTransform, Volume,
};
use serde_json::{Value, json};

use super::support::{File, assert_contains, png, triangle};

/// A triangle with a material, and four textures of one texel.
fn with(material: Value) -> File {
    let mut file = triangle();
    let view = file.view(&png(1, 1, &[[1, 2, 3, 4]]));
    file.push("images", json!({ "bufferView": view }));
    for name in ["a", "b", "c", "d"] {
        file.push("textures", json!({ "source": 0, "name": name }));
    }
    file.push("materials", material);
    let coordinates = file.floats(&[[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    file
}

/// The material as it is loaded, and every warning.
#[track_caller]
fn load(material: Value) -> (Material, String) {
    let loaded = with(material).load().unwrap();
    (loaded.scene.materials[0].clone(), loaded.warnings.join("\n"))
}

/// The material as it is loaded, without a warning.
#[track_caller]
fn load_without_warnings(material: Value) -> Material {
    let (material, warnings) = load(material);
    assert_eq!(warnings, "");
    material
}

#[track_caller]
fn assert_rejected(material: Value, words: &[&str]) {
    assert_contains(&with(material).error(), words);
}

fn extension(name: &str, value: Value) -> Value {
    json!({ "extensions": { name: value } })
}

/// The default material of the specification.
fn standard() -> Material {
    Material { metallic: 1.0, roughness: 1.0, specular: 1.0, double_sided: false, ..Material::default() }
}

#[test]
fn the_default_material_is_rough_white_metal() {
    assert_eq!(load_without_warnings(json!({})), standard());
    // Empty objects have the same defaults, except for the one that is a flag.
    let names = ["emissive_strength", "ior", "specular", "transmission", "volume"];
    for name in names {
        assert_eq!(load_without_warnings(extension(&format!("KHR_materials_{name}"), json!({}))), standard(), "{name}");
    }
    assert_eq!(load_without_warnings(json!({ "pbrMetallicRoughness": {} })), standard());
    // A primitive without a material gets the same.
    let loaded = triangle().load().unwrap();
    assert_eq!(loaded.scene.materials, [Material { name: "default".into(), ..standard() }]);
    assert_eq!(loaded.warnings, [""; 0]);
}

#[test]
fn metallic_roughness() {
    let material = load_without_warnings(json!({ "name": "m", "doubleSided": true, "pbrMetallicRoughness": {
        "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "baseColorTexture": { "index": 1 }, "metallicFactor": 0.25,
        "roughnessFactor": 0.75, "metallicRoughnessTexture": { "index": 2 } } }));
    let expected = Material {
        name: "m".into(),
        base_color: [0.1, 0.2, 0.3, 0.4],
        // Two more are not referenced: all four are kept.
        base_color_texture: Some(TextureInfo::new(1)),
        metallic: 0.25,
        roughness: 0.75,
        metallic_roughness_texture: Some(TextureInfo::new(2)),
        double_sided: true,
        ..standard()
    };
    assert_eq!(material, expected);
    let surface = |key: &str, value: Value| json!({ "pbrMetallicRoughness": { key: value } });
    // Clamped, as in other loaders.
    let out_of_range = [
        ("roughnessFactor", json!(2), Material { roughness: 1.0, ..standard() }),
        ("metallicFactor", json!(-0.1), Material { metallic: 0.0, ..standard() }),
        ("baseColorFactor", json!([0.5, 3, -1, 1]), Material { base_color: [0.5, 1.0, 0.0, 1.0], ..standard() }),
    ];
    for (key, value, expected) in out_of_range {
        let (material, warnings) = load(surface(key, value));
        assert_eq!(material, expected);
        assert_contains(&warnings, &["materials[0]", "clamped"]);
    }
    // Rounded in single precision.
    assert_eq!(load_without_warnings(surface("roughnessFactor", json!(1.000_000_1))), standard());
    assert_rejected(
        surface("metallicFactor", json!("1")),
        &["materials[0].pbrMetallicRoughness.metallicFactor", "number"],
    );
    assert_rejected(surface("baseColorFactor", json!([0, 0, 1])), &["baseColorFactor", "3 numbers instead of 4"]);
    assert_rejected(surface("metallicRoughnessTexture", json!({})), &["metallicRoughnessTexture.index", "missing"]);
    assert_rejected(
        surface("metallicRoughnessTexture", json!({ "index": 4 })),
        &["metallicRoughnessTexture.index", "[4]"],
    );
    assert_rejected(json!({ "doubleSided": 1 }), &["materials[0].doubleSided"]);
}

#[test]
fn normal_maps_and_occlusion() {
    let map = |scale: f32| Some(NormalMap { texture: TextureInfo::new(3), scale });
    assert_eq!(load_without_warnings(json!({ "normalTexture": { "index": 3 } })).normal_map, map(1.0));
    assert_eq!(load_without_warnings(json!({ "normalTexture": { "index": 3, "scale": -2.5 } })).normal_map, map(-2.5));
    assert_rejected(json!({ "normalTexture": { "index": 3, "scale": 1e39 } }), &["materials[0].normalTexture.scale"]);
    assert_rejected(json!({ "normalTexture": {} }), &["materials[0].normalTexture.index", "missing"]);
    // Occlusion textures are ignored without a warning; the image may be missing.
    let mut file = with(json!({ "occlusionTexture": { "index": 0 } }));
    file.push("images", json!({ "uri": "missing.png" }));
    file.json["textures"][0]["source"] = json!(1);
    let loaded = file.load().unwrap();
    assert_eq!((loaded.scene.textures.len(), loaded.warnings), (3, vec![]));
    assert_eq!(loaded.scene.materials[0], standard());
}

#[test]
fn emission() {
    let strong =
        |strength: Value| extension("KHR_materials_emissive_strength", json!({ "emissiveStrength": strength }));
    let mut material = json!({ "emissiveFactor": [0.3, 0.5, 1], "emissiveTexture": { "index": 2 } });
    let loaded = load_without_warnings(material.clone());
    assert_eq!(loaded.emission, [0.3, 0.5, 1.0]);
    assert_eq!(loaded.emission_texture, Some(TextureInfo::new(2)));
    material["extensions"] = strong(json!(50))["extensions"].clone();
    // Rounded once, after the product: 50 * 0.3 in single precision is one bit more than 15.
    assert_eq!(load_without_warnings(material.clone()).emission, [15.0, 25.0, 50.0]);
    assert_eq!(load_without_warnings(strong(json!(30))).emission, [0.0; 3]);
    // Above the range of glTF, but exporters write it.
    let (bright, warnings) = load(json!({ "emissiveFactor": [0, 2.5, 0] }));
    assert_eq!(bright.emission, [0.0, 2.5, 0.0]);
    assert_contains(&warnings, &["materials[0]", "emissiveFactor is above"]);
    assert_rejected(json!({ "emissiveFactor": [0, -1, 0] }), &["materials[0].emissiveFactor", "-1"]);
    assert_rejected(json!({ "emissiveFactor": [0, 1e31, 0] }), &["materials[0].emissiveFactor"]);
    let at = "materials[0].extensions.KHR_materials_emissive_strength.emissiveStrength";
    assert_rejected(strong(json!(-1)), &[at, "-1"]);
    assert_rejected(strong(json!(1e39)), &[at]);
    material["extensions"] = strong(json!(2e30))["extensions"].clone();
    assert_rejected(material, &[at, "emissiveFactor", "1e30"]);
}

#[test]
fn alpha() {
    let alpha = |material: Value| load_without_warnings(material).alpha;
    assert_eq!(alpha(json!({ "alphaMode": "OPAQUE", "alphaCutoff": 0.1 })), Alpha::Opaque);
    assert_eq!(alpha(json!({ "alphaMode": "BLEND" })), Alpha::Blend);
    assert_eq!(alpha(json!({ "alphaMode": "MASK" })), Alpha::Mask(0.5));
    assert_eq!(alpha(json!({ "alphaMode": "MASK", "alphaCutoff": 1.25 })), Alpha::Mask(1.25));
    assert_rejected(json!({ "alphaMode": "MASK", "alphaCutoff": -0.5 }), &["materials[0].alphaCutoff", "-0.5"]);
    assert_rejected(json!({ "alphaMode": "MASK", "alphaCutoff": 1e300 }), &["materials[0].alphaCutoff"]);
    assert_rejected(json!({ "alphaMode": "mask" }), &["materials[0].alphaMode", "MASK"]);
}

#[test]
fn specular() {
    let specular = |value: Value| extension("KHR_materials_specular", value);
    let material =
        load_without_warnings(specular(json!({ "specularFactor": 0.25, "specularColorFactor": [0, 0.5, 2.5],
        "specularTexture": { "index": 1 }, "specularColorTexture": { "index": 3 } })));
    let expected = Material {
        specular: 0.25,
        specular_color: [0.0, 0.5, 2.5],
        specular_texture: Some(TextureInfo::new(1)),
        specular_color_texture: Some(TextureInfo::new(3)),
        ..standard()
    };
    assert_eq!(material, expected);
    let at = |key: &str| format!("materials[0].extensions.KHR_materials_specular.{key}");
    let (clamped, warnings) = load(specular(json!({ "specularFactor": 1.5 })));
    assert_eq!(clamped.specular, 1.0);
    assert_contains(&warnings, &["materials[0]", "clamped"]);
    assert_rejected(specular(json!({ "specularColorFactor": [1, -1, 1] })), &[&at("specularColorFactor"), "-1"]);
    assert_rejected(specular(json!({ "specularColorTexture": { "index": 9 } })), &[&at("specularColorTexture.index")]);
    assert_rejected(specular(json!(1)), &["materials[0].extensions.KHR_materials_specular", "object"]);
}

#[test]
fn index_of_refraction() {
    let ior = |value: Value| extension("KHR_materials_ior", json!({ "ior": value }));
    assert_eq!(load_without_warnings(ior(json!(1.33))).ior, 1.33);
    assert_eq!(load_without_warnings(ior(json!(1))).ior, 1.0);
    // 0 means infinity in the specification.
    for value in [json!(0), json!(0.0), json!(1001), json!(1e300)] {
        let (material, warnings) = load(ior(value));
        assert_eq!(material.ior, 1000.0);
        assert_contains(&warnings, &["materials[0]", "index of refraction", "1000"]);
    }
    for value in [json!(0.99), json!(-1), json!("glass")] {
        assert_rejected(ior(value), &["materials[0].extensions.KHR_materials_ior.ior"]);
    }
}

#[test]
fn transmission_and_unlit() {
    let transmission = |value: Value| extension("KHR_materials_transmission", value);
    let glass = load_without_warnings(transmission(
        json!({ "transmissionFactor": 0.75, "transmissionTexture": { "index": 1 } }),
    ));
    let transmission_texture = Some(TextureInfo::new(1));
    assert_eq!(glass, Material { transmission: 0.75, transmission_texture, ..standard() });
    let (clamped, warnings) = load(transmission(json!({ "transmissionFactor": 1.01 })));
    assert_eq!(clamped.transmission, 1.0);
    assert_contains(&warnings, &["materials[0]", "clamped"]);
    assert_eq!(
        load_without_warnings(extension("KHR_materials_unlit", json!({}))),
        Material { unlit: true, ..standard() }
    );
    assert_rejected(extension("KHR_materials_unlit", json!(true)), &["materials[0].extensions.KHR_materials_unlit"]);
}

#[test]
fn volume() {
    let volume = |value: Value| extension("KHR_materials_volume", value);
    let clear = Volume { attenuation_distance_m: f32::INFINITY, attenuation_color: [1.0; 3] };
    assert_eq!(load_without_warnings(volume(json!({ "thicknessFactor": 0.01 }))).volume, Some(clear));
    // A thickness of 0 is a thin wall, whatever the other values.
    let thin = json!({ "thicknessFactor": 0, "attenuationDistance": 2, "thicknessTexture": { "index": 0 } });
    assert_eq!(load_without_warnings(volume(thin)).volume, None);
    assert_eq!(load_without_warnings(volume(json!({ "attenuationColor": [1, 0.5, 0.5] }))).volume, None);
    let tinted = json!({ "thicknessFactor": 3, "attenuationDistance": 0.25, "attenuationColor": [1, 0.5, 0] });
    let attenuation_color = [1.0, 0.5, f32::MIN_POSITIVE];
    let expected = Volume { attenuation_distance_m: 0.25, attenuation_color };
    assert_eq!(load_without_warnings(volume(tinted)).volume, Some(expected));
    // Above the range of f32, and 0 in the meaning of "no absorption".
    for distance in [json!(1e300), json!(0)] {
        let far = volume(json!({ "thicknessFactor": 1, "attenuationDistance": distance }));
        assert_eq!(load_without_warnings(far).volume, Some(clear));
    }
    let (material, warnings) = load(volume(json!({ "thicknessFactor": 1, "thicknessTexture": { "index": 0 } })));
    assert_eq!(material.volume, Some(clear));
    assert_contains(&warnings, &["materials[0]", "thickness textures are ignored"]);
    let at = |key: &str| format!("materials[0].extensions.KHR_materials_volume.{key}");
    assert_rejected(volume(json!({ "thicknessFactor": -1 })), &[&at("thicknessFactor")]);
    assert_rejected(volume(json!({ "attenuationDistance": -1 })), &[&at("attenuationDistance"), "above 0"]);
    assert_rejected(volume(json!({ "attenuationDistance": 1e-60 })), &[&at("attenuationDistance"), "above 0"]);
    assert_contains(&load(volume(json!({ "attenuationColor": [1, 1, 1.1] }))).1, &["materials[0]", "clamped"]);
}

#[test]
fn texture_transforms() {
    let moved = |value: Value| {
        let texture = json!({ "index": 2, "texCoord": 0, "extensions": { "KHR_texture_transform": value } });
        json!({ "emissiveTexture": texture })
    };
    let transform = load_without_warnings(moved(json!({ "offset": [0.5, -1], "rotation": 0.75, "scale": [2, -3] })));
    let expected = TextureTransform { offset: [0.5, -1.0], rotation_rad: 0.75, scale: [2.0, -3.0] };
    let expected = TextureInfo { texture: 2, set: 0, transform: expected };
    assert_eq!(transform.emission_texture, Some(expected));
    assert_eq!(load_without_warnings(moved(json!({}))).emission_texture, Some(TextureInfo::new(2)));
    // `texCoord` of the extension overrides that of the texture info.
    let (material, warnings) = load(moved(json!({ "texCoord": 1 })));
    assert_eq!(material.emission_texture, Some(TextureInfo { set: 1, ..TextureInfo::new(2) }));
    assert_contains(&warnings, &["no coordinates"]);
    let at = |key: &str| format!("materials[0].emissiveTexture.extensions.KHR_texture_transform.{key}");
    assert_rejected(moved(json!({ "offset": [0, 1e39] })), &[&at("offset")]);
    assert_rejected(moved(json!({ "rotation": "left" })), &[&at("rotation")]);
    assert_rejected(moved(json!({ "scale": [1] })), &[&at("scale"), "1 numbers instead of 2"]);
    assert_rejected(moved(json!({ "texCoord": -1 })), &[&at("texCoord")]);
}

/// Blender marks extensions that change the image as required; all of them are supported.
#[test]
fn supported_extensions_may_be_required() {
    let names = ["emissive_strength", "ior", "specular", "transmission", "unlit", "volume", "clearcoat", "sheen"];
    let rare = ["anisotropy", "iridescence", "dispersion", "diffuse_transmission"];
    let mut names: Vec<String> = names.iter().chain(&rare).map(|name| format!("KHR_materials_{name}")).collect();
    names.push("KHR_texture_transform".into());
    let mut file = triangle();
    file.json["extensionsUsed"] = json!(names);
    file.json["extensionsRequired"] = json!(names);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.warnings, [""; 0]);
    names.sort();
    assert_eq!(loaded.summary.extensions_required, names);
    let unknown = ["volume_scatter", "subsurface"];
    for name in unknown.map(|name| format!("KHR_materials_{name}")) {
        let mut file = with(extension(&name, json!({})));
        file.json["extensionsUsed"] = json!([name]);
        let loaded = file.load().unwrap();
        assert_eq!(loaded.warnings.len(), 1);
        assert_contains(&loaded.warnings[0], &[&name, "drawn without"]);
        file.json["extensionsRequired"] = json!([name]);
        assert_contains(&file.error(), &["extensionsRequired", &name]);
    }
}

/// The factors, textures and defaults of the layers.
#[test]
fn layers_are_read() {
    let material = load_without_warnings(json!({ "extensions": {
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.5, "clearcoatTexture": { "index": 0 }, "clearcoatRoughnessFactor": 0.25,
            "clearcoatRoughnessTexture": { "index": 1 }, "clearcoatNormalTexture": { "index": 2, "scale": 0.5 },
        },
        "KHR_materials_sheen": {
            "sheenColorFactor": [0.1, 0.2, 0.3], "sheenColorTexture": { "index": 1 }, "sheenRoughnessFactor": 0.7,
            "sheenRoughnessTexture": { "index": 3 },
        },
        "KHR_materials_anisotropy": {
            "anisotropyStrength": 0.6, "anisotropyRotation": -4.5, "anisotropyTexture": { "index": 3 },
        },
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.9, "iridescenceTexture": { "index": 0 }, "iridescenceIor": 1.8,
            "iridescenceThicknessMinimum": 250, "iridescenceThicknessMaximum": 150,
            "iridescenceThicknessTexture": { "index": 1 },
        },
        "KHR_materials_dispersion": { "dispersion": 0.75 },
        "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": 0.4, "diffuseTransmissionTexture": { "index": 2 },
            "diffuseTransmissionColorFactor": [0.9, 0.8, 0.7], "diffuseTransmissionColorTexture": { "index": 3 },
        },
    }}));
    let texture = |k: usize| Some(TextureInfo::new(k));
    let clearcoat = Clearcoat {
        factor: 0.5,
        texture: texture(0),
        roughness: 0.25,
        roughness_texture: texture(1),
        normal_map: Some(NormalMap { texture: TextureInfo::new(2), scale: 0.5 }),
    };
    assert_eq!(material.clearcoat, Some(clearcoat));
    let (color, color_texture) = ([0.1, 0.2, 0.3], texture(1));
    let sheen = Sheen { color, color_texture, roughness: 0.7, roughness_texture: texture(3) };
    assert_eq!(material.sheen, Some(sheen));
    let anisotropy = Anisotropy { strength: 0.6, rotation_rad: -4.5, texture: texture(3) };
    assert_eq!(material.anisotropy, Some(anisotropy));
    let iridescence = Iridescence {
        factor: 0.9,
        texture: texture(0),
        ior: 1.8,
        thickness_nm: [250.0, 150.0],
        thickness_texture: texture(1),
    };
    assert_eq!(material.iridescence, Some(iridescence));
    assert_eq!(material.dispersion, 0.75);
    let color_texture = texture(3);
    let through = DiffuseTransmission { factor: 0.4, texture: texture(2), color: [0.9, 0.8, 0.7], color_texture };
    assert_eq!(material.diffuse_transmission, Some(through));

    let names = ["clearcoat", "sheen", "anisotropy", "iridescence", "dispersion", "diffuse_transmission"];
    let empty: serde_json::Map<_, _> = names.iter().map(|name| (format!("KHR_materials_{name}"), json!({}))).collect();
    let material = load_without_warnings(json!({ "extensions": empty }));
    assert_eq!(material.clearcoat, Some(Clearcoat::default()));
    assert_eq!(material.sheen, Some(Sheen::default()));
    assert_eq!(material.anisotropy, Some(Anisotropy::default()));
    assert_eq!(material.iridescence, Some(Iridescence::default()));
    assert_eq!(material.diffuse_transmission, Some(DiffuseTransmission::default()));
    assert_eq!(material.dispersion, 0.0);
}

#[test]
fn layers_out_of_range_are_clamped_or_rejected() {
    let one = |name: &str, key: &str, value: f64| extension(&format!("KHR_materials_{name}"), json!({ key: value }));
    let (material, warnings) = load(one("clearcoat", "clearcoatFactor", 1.5));
    assert_eq!(material.clearcoat.map(|coat| coat.factor), Some(1.0));
    assert_contains(&warnings, &["clamped"]);
    assert_rejected(one("iridescence", "iridescenceIor", 0.9), &["iridescenceIor", "at least 1"]);
    assert_rejected(one("iridescence", "iridescenceThicknessMaximum", -1.0), &["iridescenceThicknessMaximum"]);
    assert_rejected(one("dispersion", "dispersion", -0.1), &["dispersion"]);
    assert_rejected(one("anisotropy", "anisotropyRotation", 1e300), &["anisotropyRotation"]);
}

/// Tangents of the file are read where a normal map needs them, and computed where it has none.
#[test]
fn tangents_are_read_or_computed() {
    let map = json!({ "normalTexture": { "index": 0 } });
    let mut file = with(map.clone());
    let normals = file.floats(&[[0.0_f32, 0.0, 1.0]; 3]);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normals);
    let computed = file.load().unwrap().scene.meshes[0].tangents.clone();
    assert_eq!(computed.len(), 3);
    assert!(computed.iter().all(|tangent| tangent[3].abs() == 1.0));
    let tangents = file.floats(&[[0.0_f32, 2.0, 0.0, -1.0]; 3]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(tangents);
    assert_eq!(file.load().unwrap().scene.meshes[0].tangents, [[0.0, 1.0, 0.0, -1.0]; 3]);
    file.json["materials"][0] = json!({});
    assert!(file.load().unwrap().scene.meshes[0].tangents.is_empty(), "nothing needs them");
    file.json["materials"][0] = map;
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = Value::Null;
    file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    assert!(file.load().unwrap().scene.meshes[0].tangents.is_empty(), "without normals they mean nothing");
}
