//! `KHR_materials_pbrSpecularGlossiness`.

use holo_scene::{Material, TextureInfo};
use serde_json::{Value, json};

use super::support::{File, assert_contains, png, triangle};

/// A triangle with a material of the extension and a texture of three texels.
fn with(extension: Value) -> File {
    let mut file = triangle();
    let view = file.view(&png(3, 1, &[[10, 20, 30, 255], [40, 50, 60, 0], [70, 80, 90, 128]]));
    file.push("images", json!({ "bufferView": view }));
    file.push("textures", json!({ "source": 0 }));
    let coordinates = file.floats(&[[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.push(
        "materials",
        json!({
        // The fallback for loaders without the extension.
        "pbrMetallicRoughness": { "metallicFactor": 0.9, "metallicRoughnessTexture": { "index": 0 } },
        "extensions": { "KHR_materials_pbrSpecularGlossiness": extension } }),
    );
    file.json["extensionsRequired"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    file
}

#[test]
fn factors() {
    let file = with(json!({ "diffuseFactor": [0.1, 0.2, 0.3, 0.4], "specularFactor": [0.04, 0.5, 1],
        "glossinessFactor": 0.75 }));
    let loaded = file.load().unwrap();
    let expected = Material {
        base_color: [0.1, 0.2, 0.3, 0.4],
        metallic: 0.0,
        roughness: 0.25,
        specular: 1.0,
        // Times the reflectance 0.04 of the index 1.5: that of the file.
        specular_color: [0.04 * 25.0, 12.5, 25.0],
        double_sided: false,
        ..Material::default()
    };
    assert_eq!(loaded.scene.materials, [expected]);
    assert_contains(&loaded.warnings.join("\n"), &["materials[0]", "specular-glossiness", "diffuse part differs"]);
    // The defaults: white, mirror-like.
    let material = with(json!({})).load().unwrap().scene.materials.remove(0);
    assert_eq!((material.base_color, material.specular_color, material.roughness), ([1.0; 4], [25.0; 3], 0.0));
    let clamped = with(json!({ "glossinessFactor": 2 })).load().unwrap();
    assert_eq!(clamped.scene.materials[0].roughness, 0.0);
    assert_contains(&clamped.warnings.join("\n"), &["materials[0]", "clamped"]);
}

#[test]
fn the_roughness_texture_is_computed() {
    let file = with(json!({ "diffuseTexture": { "index": 0 }, "glossinessFactor": 0.5,
        "specularGlossinessTexture": { "index": 0, "texCoord": 0 } }));
    let scene = file.load().unwrap().scene;
    assert_eq!(scene.textures.len(), 2);
    assert_eq!(scene.textures[0].texels[1], [40, 50, 60, 0]);
    // 1 - 0.5 * alpha, in the green channel: 127.5, 255, 191 of 255.
    assert_eq!(scene.textures[1].texels.iter().map(|texel| texel[1]).collect::<Vec<_>>(), [128, 255, 191]);
    let material = &scene.materials[0];
    assert_eq!(material.base_color_texture, Some(TextureInfo::new(0)));
    assert_eq!(material.specular_color_texture, Some(TextureInfo::new(0)));
    assert_eq!(material.metallic_roughness_texture, Some(TextureInfo::new(1)));
    assert_eq!((material.metallic, material.roughness), (0.0, 1.0));
}

#[test]
fn materials_share_computed_textures() {
    let mut file = with(json!({ "specularGlossinessTexture": { "index": 0 } }));
    let material = file.json["materials"][0].clone();
    file.push("materials", material.clone());
    file.push("materials", material);
    file.json["materials"][2]["extensions"]["KHR_materials_pbrSpecularGlossiness"]["glossinessFactor"] = json!(0.25);
    let scene = file.load().unwrap().scene;
    let roughness: Vec<_> =
        scene.materials.iter().map(|m| m.metallic_roughness_texture.map(|used| used.texture)).collect();
    assert_eq!((scene.textures.len(), roughness), (3, vec![Some(1), Some(1), Some(2)]));
}

#[test]
fn without_its_image_the_factor_stays() {
    let mut file = with(json!({ "specularGlossinessTexture": { "index": 0 }, "glossinessFactor": 0.75 }));
    file.json["images"][0] = json!({ "uri": "missing.png" });
    let loaded = file.load().unwrap();
    let material = &loaded.scene.materials[0];
    assert_eq!((material.roughness, material.metallic_roughness_texture), (0.25, None));
    assert_eq!(loaded.warnings.len(), 2, "{:?}", loaded.warnings);
}
