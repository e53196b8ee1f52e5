//! Containers, and which external files a file may refer to.

use std::fs;

use holo_scene::gltf::{Limits, load, load_slice};
use serde_json::{Value, json};

use super::support::{File, TRIANGLE, assert_contains, base64, glb, png, triangle};

/// A `.gltf` whose buffer is at `uri`.
fn external(uri: &str) -> Value {
    let mut json = triangle().json;
    json["buffers"][0]["uri"] = json!(uri);
    json
}

fn error_of(bytes: &[u8]) -> String {
    load_slice(bytes, &Limits::default()).unwrap_err().to_string()
}

#[test]
fn json_with_data_uris() {
    let binary = triangle().binary;
    for uri in [
        format!("data:application/octet-stream;base64,{}", base64(&binary)),
        format!("data:application/gltf-buffer;base64,{}", base64(&binary).trim_end_matches('=')),
    ] {
        let loaded = load_slice(external(&uri).to_string().as_bytes(), &Limits::default()).unwrap();
        assert_eq!(loaded.scene.meshes[0].positions, TRIANGLE);
    }
    assert_contains(&error_of(external("data:;base64,****").to_string().as_bytes()), &["buffers[0].uri", "base64"]);
    assert_contains(
        &error_of(external("data:;base64,AAAA").to_string().as_bytes()),
        &["buffers[0].byteLength", "36", "3"],
    );
    // With the byte order mark that some editors write.
    let text = format!("\u{feff}{}", external(&format!("data:;base64,{}", base64(&binary))));
    assert!(load_slice(text.as_bytes(), &Limits::default()).is_ok());
}

#[test]
fn external_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("sub dir")).unwrap();
    fs::write(at("sub dir/a b.bin"), triangle().binary).unwrap();
    fs::write(at("tex \u{e9}.png"), png(1, 1, &[[1, 2, 3, 4]])).unwrap();
    let mut json = external("sub%20dir/a%20b.bin");
    json["images"] = json!([{ "uri": "./tex%20%C3%A9.png" }]);
    json["textures"] = json!([{ "source": 0 }]);
    fs::write(at("scene.gltf"), json.to_string()).unwrap();
    let loaded = load(&at("scene.gltf"), &Limits::default()).unwrap();
    assert_eq!(loaded.scene.meshes[0].positions, TRIANGLE);
    assert_eq!(loaded.scene.textures[0].texels, [[1, 2, 3, 4]]);

    // The limit applies to the bytes of all files together.
    let size = json.to_string().len() as u64;
    let small = Limits { max_bytes: size + 30, ..Limits::default() };
    assert_contains(&load(&at("scene.gltf"), &small).unwrap_err().to_string(), &["a b.bin", "limit"]);
    // A short file.
    fs::write(at("sub dir/a b.bin"), &triangle().binary[..35]).unwrap();
    assert_contains(
        &load(&at("scene.gltf"), &Limits::default()).unwrap_err().to_string(),
        &["buffers[0].byteLength", "35"],
    );
    fs::remove_file(at("sub dir/a b.bin")).unwrap();
    assert_contains(&load(&at("scene.gltf"), &Limits::default()).unwrap_err().to_string(), &["cannot read", "a b.bin"]);
    assert_contains(&load(&at("none.glb"), &Limits::default()).unwrap_err().to_string(), &["cannot read", "none.glb"]);
    assert_contains(&load(folder.path(), &Limits::default()).unwrap_err().to_string(), &["not a file"]);
}

#[test]
fn nothing_outside_the_folder_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).unwrap();
    fs::write(folder.path().join("secret.bin"), triangle().binary).unwrap();
    let absolute = folder.path().join("secret.bin").display().to_string();
    let upward = ["../secret.bin", "%2E%2E/secret.bin", "..%2Fsecret.bin", "x/../../secret.bin", "..\\secret.bin"];
    for uri in upward.into_iter().chain([absolute.as_str()]) {
        fs::write(inner.join("scene.gltf"), external(uri).to_string()).unwrap();
        let message = load(&inner.join("scene.gltf"), &Limits::default()).unwrap_err().to_string();
        assert_contains(&message, &["buffers[0].uri", "folder of the glTF file"]);
    }
    for uri in ["http://example.org/x.bin", "file:///etc/passwd", "C:\\x.bin"] {
        fs::write(inner.join("scene.gltf"), external(uri).to_string()).unwrap();
        let message = load(&inner.join("scene.gltf"), &Limits::default()).unwrap_err().to_string();
        assert_contains(&message, &["buffers[0].uri", "not supported"]);
    }
    // A scene loaded from memory has no folder.
    assert_contains(&error_of(external("x.bin").to_string().as_bytes()), &["buffers[0].uri", "x.bin", "path"]);
}

#[test]
fn invalid_containers_are_errors() {
    let whole = triangle().glb();
    for length in 0..whole.len() {
        error_of(&whole[..length]);
    }
    assert_contains(&error_of(b""), &["empty"]);
    assert_contains(&error_of(b"\x01\x02\x03\x04"), &["neither"]);
    assert_contains(&error_of(b"{ \"asset\": "), &["glTF JSON"]);
    assert_contains(&error_of(b"{}"), &["asset", "missing"]);
    assert_contains(&error_of(&whole[..whole.len() - 1]), &["cut short"]);
    let mut version = whole.clone();
    version[4] = 3;
    assert_contains(&error_of(&version), &["version 3"]);
    let mut chunk = whole.clone();
    chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_contains(&error_of(&chunk), &["chunk 0", "beyond"]);
    let mut kind = whole.clone();
    kind[16] = b'X';
    assert_contains(&error_of(&kind), &["chunk 0", "not JSON"]);
    assert_contains(&error_of(&glb(b"\xff\xfe", &[])), &["glTF JSON"]);
    assert_contains(&error_of(&glb(b"[1]", &[])), &["not an object"]);
    assert_contains(&error_of(&glb("[".repeat(100_000).as_bytes(), &[])), &["glTF JSON", "recursion"]);
    assert_contains(&error_of(&glb(br#"{"asset":{"version":"1.0"}}"#, &[])), &["asset.version", "version 1"]);
    assert_contains(&error_of(&glb(br#"{"asset":{"version":"2.1","minVersion":"2.1"}}"#, &[])), &["asset.minVersion"]);
    assert_contains(&error_of(&glb(br#"{"asset":{"version":"2.0"},"nodes":{}}"#, &[])), &["nodes", "array"]);
    assert_contains(
        &error_of(&glb(br#"{"asset":{"version":"2.0"},"nodes":[{"translation":[1e999,0,0]}]}"#, &[])),
        &["JSON"],
    );
    // Bytes after the end and chunks of other types are ignored.
    let mut longer = whole.clone();
    longer.extend_from_slice(b"garbage");
    assert!(load_slice(&longer, &Limits::default()).is_ok());
    let mut chunks = whole;
    chunks.extend_from_slice(&[4, 0, 0, 0, b'A', b'C', b'M', b'E', 1, 2, 3, 4]);
    let total = (chunks.len() as u32).to_le_bytes();
    chunks[8..12].copy_from_slice(&total);
    assert!(load_slice(&chunks, &Limits::default()).is_ok());
    // A buffer without uri in a file without binary chunk.
    assert_contains(&error_of(triangle().json.to_string().as_bytes()), &["buffers[0]", "binary chunk"]);
}

/// Some writers do not pad their chunks: the next one follows at once, or at the next multiple of four all the same.
#[test]
fn chunks_of_any_length() {
    let mut text = triangle().json.to_string().into_bytes();
    while text.len() % 4 != 1 {
        text.push(b' ');
    }
    let binary = triangle().binary;
    for gap in [0, 3] {
        let mut bytes = Vec::from(*b"glTF\x02\0\0\0");
        let total = 12 + 8 + text.len() + gap + 8 + binary.len();
        for word in [total, text.len()] {
            bytes.extend_from_slice(&(word as u32).to_le_bytes());
        }
        bytes.extend_from_slice(b"JSON");
        bytes.extend_from_slice(&text);
        bytes.resize(bytes.len() + gap, 0);
        bytes.extend_from_slice(&(binary.len() as u32).to_le_bytes());
        bytes.extend_from_slice(b"BIN\0");
        bytes.extend_from_slice(&binary);
        let loaded = load_slice(&bytes, &Limits::default()).unwrap();
        assert_eq!(loaded.scene.meshes[0].positions, TRIANGLE, "{gap} bytes of padding");
    }
}

#[test]
fn an_empty_scene_loads() {
    let loaded = File::new().load().unwrap();
    assert_eq!(loaded.scene, holo_scene::Scene::default());
    assert!(loaded.warnings.is_empty());
    assert_eq!(loaded.summary.triangles, 0);
    assert_contains(&loaded.summary.to_string(), &["generator:           unknown", "cameras:             none"]);
}

/// Every message has two lines: what the file is, and what to do.
#[test]
fn other_formats_are_named_with_a_cure() {
    let mut stl = vec![b' '; 84 + 100];
    stl[80..84].copy_from_slice(&2_u32.to_le_bytes());
    let mut old = triangle().glb();
    old[4] = 1;
    let zip = |name: &str| {
        let mut bytes = b"PK\x03\x04".to_vec();
        bytes.resize(26, 0);
        bytes.extend_from_slice(&[name.len() as u8, 0, 0, 0]);
        bytes.extend_from_slice(name.as_bytes());
        bytes.extend_from_slice(b"content");
        bytes
    };
    let export = "File > Export > glTF 2.0";
    let cases: Vec<(Vec<u8>, &str, &str)> = vec![
        (b"BLENDER-v405RENDH".to_vec(), "Blender file", export),
        (b"\x28\xB5\x2F\xFD\x00\x58".to_vec(), "Zstandard, probably a Blender file", export),
        (b"\x1F\x8B\x08\x00".to_vec(), "gzip", "Blender"),
        (b"PXR-USDC\0\x08".to_vec(), "USD file", export),
        (b"#usda 1.0\n".to_vec(), "USD file", export),
        (zip("Teapot.usdc"), "USD package (.usdz)", export),
        (zip("scene.gltf"), "ZIP archive", "Unpack"),
        (b"Kaydara FBX Binary  \0\x1A\0".to_vec(), "FBX", export),
        (b"; FBX 7.4.0 project file\n".to_vec(), "FBX file in text form", "binary FBX"),
        (b"<?xml version=\"1.0\"?>\n<COLLADA version=\"1.4.1\">".to_vec(), "COLLADA", "4.5 or older"),
        (b"<?xml version=\"1.0\"?>\n<X3D>".to_vec(), "X3D", "Blender"),
        (b"solid cube\n facet normal 0 0 1\n".to_vec(), "STL", export),
        (stl, "STL", export),
        (b"ply\nformat ascii 1.0\n".to_vec(), "PLY", export),
        (b"# Blender 4.5\nmtllib cube.mtl\no Cube\nv 1 1 -1\n".to_vec(), "Wavefront OBJ", export),
        (b"v 1.0 2.0 3.0\nv 4 5 6\nf 1 2 3\n".to_vec(), "Wavefront OBJ", export),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n".to_vec(), "Git LFS", "git lfs pull"),
        (b"\n<!DOCTYPE html><html></html>".to_vec(), "HTML page", "Download"),
        (png(1, 1, &[[0; 4]]), "an image (png)", ".glb"),
        (old, "glTF version 1", "npx gltf-pipeline"),
        (br#"{"asset":{"version":"1.0"},"meshes":{}}"#.to_vec(), "glTF version 1", "npx gltf-pipeline"),
        (br#"{"asset":{"version":1.0},"meshes":[]}"#.to_vec(), "glTF version 1", "npx gltf-pipeline"),
        (br#"{"meshes":{"cube":{}}}"#.to_vec(), "glTF version 1", "npx gltf-pipeline"),
    ];
    for (bytes, kind, cure) in cases {
        let message = error_of(&bytes);
        assert_contains(&message, &[kind, cure]);
        assert_eq!(message.lines().count(), 2, "{message}");
    }
    // Text of another kind, and a word that only starts like a statement of OBJ.
    for text in ["hello world", "v one two three", "vertex 1 2 3", "o", "MZ"] {
        assert_contains(&error_of(text.as_bytes()), &["is neither binary glTF"]);
    }
}
