//! Compressed and quantized files against the file that they were made from; `tests/data/compressed/README.md` says how.

use crate::gltf_loading::support;
use std::path::{Path, PathBuf};

use holo_scene::gltf::{Limits, load, load_slice};
use holo_scene::{Error, Scene};
use serde_json::{Value, json};

#[cfg(feature = "draco")]
mod draco;

use crate::gltf_loading::support::assert_contains;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join("data").join("compressed").join(name)
}

/// A file as JSON and binary chunk.
fn open(name: &str) -> support::File {
    let bytes = std::fs::read(path(name)).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let (text, rest) = bytes[20..].split_at(length);
    support::File { json: serde_json::from_slice(text).unwrap(), binary: rest[8..].to_vec() }
}

/// A corner of a triangle in the world: position, normal, transformed texture coordinates, color.
#[derive(Clone, Copy)]
struct Corner {
    position: [f64; 3],
    normal: [f64; 3],
    coordinates: [f64; 2],
    color: [f32; 4],
}

/// The triangles of all instances.
fn triangles(scene: &Scene) -> Vec<[Corner; 3]> {
    let mut triangles = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let transform = scene.materials[mesh.material].base_color_texture.unwrap().transform;
        assert_eq!(transform.rotation_rad, 0.0);
        let columns = instance.transform.normal_columns();
        let corner = |k: u32| {
            let k = k as usize;
            let n = mesh.normals[k].map(f64::from);
            let n: [f64; 3] = std::array::from_fn(|row| (0..3).map(|column| columns[column][row] * n[column]).sum());
            let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
            let [u, v] = mesh.texture_coordinates[k];
            let ([a, b], [c, d]) = (transform.scale, transform.offset);
            Corner {
                position: instance.transform.point(mesh.positions[k].map(f64::from)),
                normal: n.map(|x| x / length),
                coordinates: [f64::from(u * a + c), f64::from(v * b + d)],
                color: mesh.colors[k],
            }
        };
        triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(corner)));
    }
    triangles
}

fn distance<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// How far the corners of two triangles may be apart.
#[derive(Clone, Copy)]
struct Bounds {
    position: f64,
    normal: f64,
    coordinates: f64,
    color: f32,
}

/// Half a step of `bits` bits over the largest extent of the torus in every coordinate, with a tenth for rounding.
fn half_step(bits: i32) -> f64 {
    0.55 * 2.8 / f64::from((1 << bits) - 1) * 3.0_f64.sqrt()
}

fn is_close(a: &[Corner; 3], b: &[Corner; 3], bounds: Bounds) -> bool {
    a.iter().zip(b).all(|(a, b)| {
        distance(a.position, b.position) <= bounds.position
            && distance(a.normal, b.normal) <= bounds.normal
            && distance(a.coordinates, b.coordinates) <= bounds.coordinates
            && a.color.iter().zip(b.color).all(|(a, b)| (a - b).abs() <= bounds.color)
    })
}

/// Asserts that each triangle of a file is one of the original, with the same front side, and that there is no other.
#[track_caller]
fn check(name: &str, bounds: Bounds) {
    let loaded = load(&path(name), &Limits::default()).unwrap();
    let source = triangles(&load(&path("source.glb"), &Limits::default()).unwrap().scene);
    let mut found = vec![false; source.len()];
    let these = triangles(&loaded.scene);
    assert_eq!((these.len(), source.len()), (1152, 1152));
    for [a, b, c] in these {
        let is_match = |other: &[Corner; 3]| {
            [[a, b, c], [b, c, a], [c, a, b]].iter().any(|triangle| is_close(triangle, other, bounds))
        };
        let place = source.iter().position(is_match);
        let place =
            place.unwrap_or_else(|| panic!("{name}: none is near {:?}", [a, b, c].map(|corner| corner.position)));
        assert!(!std::mem::replace(&mut found[place], true), "{name}: triangle {place} is there twice");
    }
    // The texture is read through the same buffer views.
    assert_eq!(loaded.scene.textures[0].width, 1);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

#[test]
fn quantized_files() {
    // Positions of 14 bits, normals of 10, coordinates of 12.
    check("quantized.glb", Bounds { position: half_step(14), normal: 0.0025, coordinates: 2e-4, color: 1e-6 });
    // Positions, coordinates and normals of 8 bits, interleaved.
    check("quantized_normalized.glb", Bounds { position: half_step(8), normal: 0.008, coordinates: 3e-3, color: 1e-6 });
}

#[test]
fn meshopt_files() {
    let bounds = Bounds { position: half_step(14), normal: 0.008, coordinates: 2e-4, color: 1e-6 };
    check("meshopt_fallback.glb", bounds);
    // Normals through the filter OCTAHEDRAL, which has eight bits here.
    check("meshopt_ext.glb", Bounds { normal: 0.02, ..bounds });
    // Everything but colors through the filter EXPONENTIAL.
    check("meshopt_float.glb", Bounds { position: half_step(13), ..bounds });
    // Version 1 of attributes, and the filter COLOR.
    check("meshopt_khr.glb", Bounds { normal: 0.02, color: 2.5 / 255.0, ..bounds });
    check("meshopt_khr_interleaved.glb", bounds);
}

/// The encoder may begin a triangle at another corner.
fn with_sorted_corners(mut scene: Scene) -> Scene {
    for triangle in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.triangles) {
        let first = (0..3).min_by_key(|&k| triangle[k]).unwrap();
        triangle.rotate_left(first);
    }
    scene
}

#[test]
fn meshopt_is_as_its_uncompressed_copy() {
    let compressed = load(&path("meshopt_fallback.glb"), &Limits::default()).unwrap().scene;
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(path("pack_cf.fallback.bin"), folder.path().join("pack_cf.fallback.bin")).unwrap();
    let mut file = open("meshopt_fallback.glb");
    for view in file.json["bufferViews"].as_array_mut().unwrap() {
        view.as_object_mut().unwrap().remove("extensions");
    }
    std::fs::write(folder.path().join("plain.glb"), file.glb()).unwrap();
    let plain = load(&folder.path().join("plain.glb"), &Limits::default()).unwrap().scene;
    assert!(with_sorted_corners(compressed.clone()) == with_sorted_corners(plain));
    // The copy is not read where there is compressed data.
    let mut file = open("meshopt_fallback.glb");
    file.json["buffers"][1]["uri"] = json!("not there.bin");
    assert!(file.load().unwrap().scene == compressed);
    file.json["buffers"][1].as_object_mut().unwrap().remove("uri");
    assert!(file.load().unwrap().scene == compressed);
    file.json["buffers"][1].as_object_mut().unwrap().remove("extensions");
    assert!(file.load().unwrap().scene == compressed);
    // A buffer view without compression needs it.
    let views = file.json["bufferViews"].as_array_mut().unwrap();
    views.iter_mut().find(|view| view["buffer"] == 1).unwrap().as_object_mut().unwrap().remove("extensions");
    assert_contains(&file.error(), &["buffers[1].uri", "missing"]);
}

/// The error after a change of the extension object of the compressed buffer view `view`.
fn meshopt_error(view: usize, key: &str, value: Value) -> String {
    let mut file = open("meshopt_ext.glb");
    let views = file.json["bufferViews"].as_array_mut().unwrap();
    let compressed = views.iter_mut().filter(|view| view["extensions"].is_object()).nth(view).unwrap();
    let extension = &mut compressed["extensions"]["EXT_meshopt_compression"];
    if value.is_null() {
        extension.as_object_mut().unwrap().remove(key);
    } else {
        extension[key] = value;
    }
    file.error()
}

#[test]
fn damaged_meshopt_data_is_an_error() {
    for key in ["buffer", "byteLength", "byteStride", "count", "mode"] {
        assert_contains(&meshopt_error(0, key, Value::Null), &["EXT_meshopt_compression", key, "missing"]);
    }
    // View 0 is of triangles, 1 of normals with a filter.
    assert_contains(&meshopt_error(0, "mode", json!("CORNERS")), &["mode", "gltf-transform"]);
    assert_contains(&meshopt_error(1, "filter", json!("NEW")), &["filter", "gltf-transform"]);
    assert_contains(&meshopt_error(0, "mode", json!("ATTRIBUTES")), &["byteStride", "2"]);
    assert_contains(&meshopt_error(0, "filter", json!("OCTAHEDRAL")), &["byteStride", "Octahedral"]);
    assert_contains(&meshopt_error(0, "mode", json!("INDICES")), &["bufferViews", "damaged"]);
    assert_contains(&meshopt_error(1, "filter", json!("QUATERNION")), &["byteStride"]);
    assert_contains(&meshopt_error(1, "byteStride", json!(8)), &["byteLength", "8 bytes"]);
    assert_contains(&meshopt_error(1, "byteStride", json!(0)), &["byteStride"]);
    assert_contains(&meshopt_error(1, "count", json!(324)), &["byteLength", "324"]);
    assert_contains(&meshopt_error(0, "count", json!(1727)), &["count", "threes"]);
    assert_contains(&meshopt_error(1, "byteOffset", json!(u64::MAX)), &["buffers[0]"]);
    assert_contains(&meshopt_error(1, "byteLength", json!(20)), &["damaged"]);
    assert_contains(&meshopt_error(1, "byteLength", json!(1 << 20)), &["needs 1048576 bytes"]);
    // The last byte of the table of triangles must be 0.
    let mut file = open("meshopt_ext.glb");
    let views = file.json["bufferViews"].as_array().unwrap();
    let compressed = views.iter().find(|view| view["extensions"].is_object()).unwrap();
    let extension = &compressed["extensions"]["EXT_meshopt_compression"];
    let end = extension["byteOffset"].as_u64().unwrap_or(0) + extension["byteLength"].as_u64().unwrap();
    file.binary[end as usize - 1] = 1;
    assert_contains(&file.error(), &["EXT_meshopt_compression", "damaged", "table"]);
}

#[test]
fn decompressed_bytes_are_limited() {
    let bytes = std::fs::read(path("meshopt_ext.glb")).unwrap();
    let limits = |max_bytes: usize| Limits { max_bytes: max_bytes as u64, ..Limits::default() };
    assert!(load_slice(&bytes, &limits(12_000)).is_ok());
    // The file itself is smaller.
    let error = load_slice(&bytes, &limits(bytes.len())).unwrap_err();
    assert!(matches!(error, Error::BadFile { .. }));
    assert_contains(&error.to_string(), &["bufferViews", "decompresses", "limit of 7664"]);
}

#[cfg(not(feature = "draco"))]
#[test]
fn without_the_feature_the_error_names_the_cure() {
    let mut file = open("draco_edgebreaker.glb");
    let cure = ["KHR_draco_mesh_compression", "npx @gltf-transform/cli copy in.glb out.glb"];
    assert_contains(&file.error(), &cure);
    file.json["extensionsRequired"] = json!([]);
    assert_contains(&file.error(), &cure);
}
