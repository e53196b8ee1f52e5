//! Draco-compressed primitives.

use holo_scene::gltf::{Limits, load_slice};
use serde_json::{Value, json};

use super::{Bounds, check, half_step, open, path};
use crate::gltf_loading::support::{File, assert_contains};

const FILES: [&str; 3] = ["draco_edgebreaker.glb", "draco_valence.glb", "draco_sequential.glb"];

#[test]
fn draco_files() {
    // Positions of 14 bits, normals of 10, coordinates of 12, colors of 8.
    let bounds = Bounds { position: half_step(14), normal: 0.005, coordinates: 2.5e-4, color: 1e-6 };
    FILES.iter().for_each(|name| check(name, bounds));
}

/// A file of the wild: two primitives with one Draco buffer view each.
#[test]
fn a_whisk() {
    let text = std::fs::read(path("kenney_whisk_draco.gltf")).unwrap();
    let mut json: Value = serde_json::from_slice(&text).unwrap();
    // Its scene lists a node that is a child of another one.
    json["nodes"][0].as_object_mut().unwrap().remove("children");
    let loaded = load_slice(json.to_string().as_bytes(), &Limits::default()).unwrap();
    let meshes = &loaded.scene.meshes;
    let sizes: Vec<_> = meshes.iter().map(|mesh| (mesh.positions.len(), mesh.triangles.len())).collect();
    assert_eq!(sizes, [(134, 134), (34, 16)]);
    for (mesh, accessor) in meshes.iter().zip([1, 5]) {
        assert_eq!(mesh.texture_coordinates.len(), mesh.positions.len());
        for axis in 0..3 {
            let values = mesh.positions.iter().map(|position| f64::from(position[axis]));
            let bound = |key: &str| json["accessors"][accessor][key][axis].as_f64().unwrap();
            assert!((values.clone().fold(f64::MAX, f64::min) - bound("min")).abs() < 3e-4);
            assert!((values.fold(f64::MIN, f64::max) - bound("max")).abs() < 3e-4);
        }
    }
}

fn error(change: impl FnOnce(&mut Value)) -> String {
    let mut file = open("draco_sequential.glb");
    change(&mut file.json);
    file.error()
}

/// The only primitive. Its accessors: 0 indices, 1 positions, 2 normals, 3 texture coordinates, 4 colors.
fn primitive(json: &mut Value) -> &mut Value {
    &mut json["meshes"][0]["primitives"][0]
}

#[test]
fn counts_must_be_those_of_the_data() {
    let count = |accessor: usize, count: u64| error(|json| json["accessors"][accessor]["count"] = json!(count));
    assert_contains(&count(0, 1725), &["KHR_draco_mesh_compression", "575 triangles", "gltf-transform"]);
    assert_contains(&count(0, 1731), &["576 triangles", "577"]);
    assert_contains(&count(2, 324), &["NORMAL", "324"]);
    for vertices in [324, 326] {
        let message = error(|json| (1..5).for_each(|k| json["accessors"][k]["count"] = json!(vertices)));
        assert_contains(&message, &["KHR_draco_mesh_compression", &vertices.to_string()]);
    }
}

#[test]
fn attributes_must_be_those_of_the_data() {
    let data = |key: &str, value: Value| {
        error(|json| primitive(json)["extensions"]["KHR_draco_mesh_compression"][key] = value)
    };
    let ids = json!({ "POSITION": 0, "NORMAL": 99, "TEXCOORD_0": 2, "COLOR_0": 3 });
    assert_contains(&data("attributes", ids), &["no attribute 99", "accessors[2]"]);
    assert_contains(&data("attributes", json!({ "POSITION": -1 })), &["attributes.POSITION", "integer"]);
    assert_contains(&data("attributes", json!({ "POSITION": 1_u64 << 32 })), &["attributes.POSITION", "32 bits"]);
    assert_contains(&data("bufferView", json!(7)), &["bufferView", "7"]);
    // Colors as VEC3, positions as integers.
    assert_contains(&error(|json| json["accessors"][4]["type"] = json!("VEC3")), &["type of accessors[4]"]);
    assert_contains(&error(|json| json["accessors"][1]["componentType"] = json!(5122)), &["type of accessors[1]"]);
    let fan = error(|json| primitive(json)["mode"] = json!(6));
    assert_contains(&fan, &["KHR_draco_mesh_compression", "triangles"]);
    let no_indices = error(|json| drop(primitive(json).as_object_mut().unwrap().remove("indices")));
    assert_contains(&no_indices, &["KHR_draco_mesh_compression", "indices"]);
}

/// The numbers of indices of a strip and of triangles are not related; the data always contains triangles.
#[test]
fn strips_are_triangles_in_the_data() {
    let mut file = open("draco_sequential.glb");
    let expected = file.load().unwrap().scene;
    primitive(&mut file.json)["mode"] = json!(5);
    assert!(file.load().unwrap().scene == expected);
    file.json["accessors"][0]["count"] = json!(577);
    assert_contains(&file.error(), &["KHR_draco_mesh_compression", "575 triangles"]);
}

#[test]
fn an_attribute_beside_the_data_is_read_from_its_accessor() {
    let mut file = open("draco_sequential.glb");
    let colors = file.accessor(&[51; 4 * 325], 5121, "VEC4", 325);
    file.json["accessors"][colors]["normalized"] = json!(true);
    primitive(&mut file.json)["attributes"]["COLOR_0"] = json!(colors);
    let extension = &mut primitive(&mut file.json)["extensions"]["KHR_draco_mesh_compression"];
    extension["attributes"].as_object_mut().unwrap().remove("COLOR_0");
    let scene = file.load().unwrap().scene;
    assert!(scene.meshes[0].colors.as_flattened().iter().all(|x| (x - 0.2).abs() < 1e-7));
}

#[test]
fn damaged_data_is_an_error() {
    for name in FILES {
        let whole = open(name);
        let mut errors = 0;
        for k in 0..whole.binary.len() {
            let mut file = File { json: whole.json.clone(), binary: whole.binary.clone() };
            file.binary[k] ^= 1 << (k % 8);
            match file.load() {
                Ok(loaded) => loaded.scene.validate().unwrap(),
                Err(error) => {
                    errors += 1;
                    assert!(!error.to_string().contains("please report"), "{name}, byte {k}: {error}");
                }
            }
        }
        assert!(errors > 100, "{name}: {errors}");
    }
}
