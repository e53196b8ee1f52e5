//! `EXT_mesh_gpu_instancing` and `KHR_materials_variants`.

use holo_scene::gltf::{Limits, LoadOptions, load_slice, load_slice_with};
use serde_json::{Value, json};

use super::support::{File, assert_contains, triangle};

fn instanced(attributes: Value) -> Value {
    json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } })
}

/// A triangle at two places below a node that doubles all lengths.
fn two() -> File {
    let mut file = triangle();
    let translation = file.floats(&[[1.0_f32, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    let scale = file.floats(&[[1.0_f32, 1.0, 1.0], [3.0, 1.0, 1.0]]);
    file.json["nodes"][0]["translation"] = json!([0, 0, 10]);
    file.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    file.json["nodes"][0]["name"] = json!("teapots");
    file.json["nodes"][0]["extensions"] = instanced(json!({ "TRANSLATION": translation, "SCALE": scale }));
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    file
}

#[test]
fn a_mesh_at_many_places() {
    let mut file = two();
    // A quarter turn about y, as bytes: x becomes -z.
    let bytes: Vec<u8> = [[0_i8, 0, 0, 127], [0, 90, 0, 90]].iter().flatten().map(|x| x.cast_unsigned()).collect();
    let rotation = file.accessor(&bytes, 5120, "VEC4", 2);
    file.json["accessors"][rotation]["normalized"] = json!(true);
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] = json!(rotation);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.warnings, [""; 0]);
    let scene = loaded.scene;
    assert_eq!((scene.meshes.len(), scene.instances.len(), scene.triangle_count()), (1, 2, 2));
    let [first, second] = &scene.instances[..] else { panic!() };
    assert_eq!((first.name.as_str(), second.name.as_str()), ("teapots", "teapots"));
    assert_eq!(first.transform.point([1.0, 1.0, 1.0]), [4.0, 2.0, 12.0]);
    let turned = second.transform.point([1.0, 0.0, 0.0]);
    for (is, expected) in turned.into_iter().zip([0.0, 4.0, 10.0 - 6.0]) {
        assert!((is - expected).abs() < 1e-12, "{turned:?}");
    }
}

#[test]
fn instances_count() {
    let limits = |max_instances, max_triangles| Limits { max_instances, max_triangles, ..Limits::default() };
    assert!(load_slice(&two().glb(), &limits(2, 2)).is_ok());
    for limits in [limits(1, 2), limits(2, 1)] {
        assert_contains(&load_slice(&two().glb(), &limits).unwrap_err().to_string(), &["nodes[0]", "limit"]);
    }
    // A small file with four thousand million instances.
    let mut file = two();
    let zeros = file.push("accessors", json!({ "componentType": 5126, "count": 4_000_000_000_u32, "type": "VEC3" }));
    file.json["nodes"][0]["extensions"] = instanced(json!({ "TRANSLATION": zeros }));
    assert_contains(&file.error(), &["nodes[0]", "limit"]);
}

#[test]
fn invalid_instancing_is_an_error() {
    let mut file = two();
    let one = file.floats(&[[1.0_f32, 1.0, 1.0]]);
    let positions = file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"].clone();
    let mut error = |attributes: Value| {
        file.json["nodes"][0]["extensions"] = instanced(attributes);
        file.error()
    };
    assert_contains(&error(json!({ "TRANSLATION": positions, "SCALE": one })), &["nodes[0]", "[2, 1]"]);
    assert_contains(&error(json!({ "ROTATION": positions })), &["VEC4", "ROTATION"]);
    assert_contains(&error(json!({ "TRANSLATION": 99 })), &["TRANSLATION", "accessors[99]"]);
    // Without a transform the mesh is shown once.
    let mut file = two();
    file.json["nodes"][0]["extensions"] = instanced(json!({}));
    assert_eq!(file.load().unwrap().scene.instances.len(), 1);
    let broken = file.floats(&[[f32::NAN, 0.0, 0.0]]);
    file.json["nodes"][0]["extensions"] = instanced(json!({ "TRANSLATION": broken }));
    assert_contains(&file.error(), &["nodes[0]", "instance 0", "not finite"]);
}

#[test]
fn material_variants() {
    let mut file = triangle();
    for name in ["red", "green", "blue"] {
        file.push("materials", json!({ "name": name }));
    }
    file.json["extensionsRequired"] = json!(["KHR_materials_variants"]);
    file.json["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "day" }, { "name": "night" }, { "name": "dusk" }] } });
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants": { "mappings": [
        { "material": 1, "variants": [0] }, { "material": 2, "variants": [1] }] } });
    let material = |name: Option<&str>| {
        let mut options = LoadOptions::default();
        options.material_variant = name.map(str::to_owned);
        load_slice_with(&file.glb(), &options).map(|loaded| {
            let scene = loaded.scene;
            scene.materials[scene.meshes[0].material].name.clone()
        })
    };
    assert_eq!(material(None).unwrap(), "red");
    assert_eq!(material(Some("day")).unwrap(), "green");
    assert_eq!(material(Some("night")).unwrap(), "blue");
    // A variant without a mapping for the primitive.
    assert_eq!(material(Some("dusk")).unwrap(), "red");
    assert_contains(&material(Some("noon")).unwrap_err().to_string(), &["'noon'", "'day', 'night', 'dusk'"]);
    let loaded = file.load().unwrap();
    assert_eq!(
        (loaded.warnings, &loaded.summary.variants[..]),
        (vec![], &["day", "night", "dusk"].map(String::from)[..])
    );
    assert_contains(&loaded.summary.to_string(), &["material variants:   day, night, dusk"]);
}
