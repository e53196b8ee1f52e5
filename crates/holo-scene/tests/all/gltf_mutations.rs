//! Mutated files: bit flips, truncations, splices and edited JSON. Nothing may panic, not even inside the panic guard
//! of the loader; nothing may hang; and whatever loads must validate.
//!
//! The test runs in its own process, because it counts panics in a hook. 2,000 files, 100,000 with `HOLO_THOROUGH=1`.

use crate::gltf_loading::support;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use holo_scene::gltf::{Limits, LoadOptions, is_guarding, load_slice, load_slice_with, to_glb};
use holo_scene::{
    Alpha, Camera, CameraProjection, Filter, Instance, Light, LightKind, Material, Mesh, NormalMap, Scene, Texture,
    TextureInfo, TextureTransform, Transform, Volume, Wrap,
};
use serde_json::{Value, json};

/// The numbers of panics that the panic guard caught, and of other panics.
static CAUGHT: AtomicU64 = AtomicU64::new(0);
static ESCAPED: AtomicU64 = AtomicU64::new(0);

/// A random number generator with a stable sequence (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Materials that use every feature of the loader.
fn surfaces() -> Value {
    json!([
        { "name": "a", "pbrMetallicRoughness": {
            "metallicFactor": 0, "baseColorTexture": { "index": 0, "texCoord": 0 } } },
        { "name": "b", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
          "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 1], "baseColorTexture": { "index": 1 },
            "roughnessFactor": 0.5, "metallicRoughnessTexture": { "index": 0, "texCoord": 3 } },
          "normalTexture": { "index": 1, "scale": 0.5, "texCoord": 3 }, "occlusionTexture": { "index": 1 },
          "emissiveFactor": [0, 0.5, 1], "emissiveTexture": { "index": 0,
            "extensions": { "KHR_texture_transform": { "offset": [0.5, 0.25], "rotation": 0.75, "scale": [2, 3] } } },
          "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 5 }, "KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": { "index": 0 }, "specularColorFactor": [1, 0.5, 1.5],
            "specularColorTexture": { "index": 1 } } } },
        { "name": "c", "alphaMode": "BLEND", "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
          "extensions": { "KHR_materials_ior": { "ior": 1.33 }, "KHR_materials_transmission": {
            "transmissionFactor": 0.9, "transmissionTexture": { "index": 0,
              "extensions": { "KHR_texture_transform": { "texCoord": 1 } } } },
            "KHR_materials_volume": { "thicknessFactor": 1, "thicknessTexture": { "index": 1 },
              "attenuationDistance": 0.5, "attenuationColor": [0.9, 0.5, 0] } } },
        { "name": "d", "extensions": { "KHR_materials_unlit": {}, "KHR_materials_pbrSpecularGlossiness": {
            "specularFactor": [0.5, 0.25, 1], "glossinessFactor": 0.5, "diffuseTexture": { "index": 2 },
            "specularGlossinessTexture": { "index": 1, "texCoord": 1 } } } },
    ])
}

/// A file that uses every feature of the loader.
fn everything() -> support::File {
    let mut file = support::File::new();
    let positions = file.floats(&[[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5]]);
    let normals = file.floats(&[[0.0_f32, 0.0, 1.0]; 4]);
    let coordinates = file.accessor(&[0, 0, 255, 0, 0, 255, 255, 255], 5121, "VEC2", 4);
    file.json["accessors"][coordinates]["normalized"] = json!(true);
    let colors = file.accessor(&[200; 16], 5121, "VEC4", 4);
    file.json["accessors"][colors]["normalized"] = json!(true);
    let second = file.floats(&[[0.5_f32, 0.0], [0.0, 0.5], [1.0, 0.25], [0.25, 1.0]]);
    let indices = file.indices_u16(&[0, 1, 2, 2, 1, 3]);
    let bytes = file.accessor(&[0, 1, 2, 3, 0, 0, 0, 0], 5121, "SCALAR", 4);
    let sparse_indices = file.view(&[1, 3]);
    let values: Vec<u8> = [0.5_f32; 6].iter().flat_map(|x| x.to_le_bytes()).collect();
    let sparse_values = file.view(&values);
    let sparse = json!({ "componentType": 5126, "count": 4, "type": "VEC3", "bufferView": 0, "sparse": { "count": 2,
        "indices": { "bufferView": sparse_indices, "componentType": 5121 },
        "values": { "bufferView": sparse_values } } });
    let sparse = file.push("accessors", sparse);
    let interleaved: Vec<u8> = [0.25_f32; 20].iter().flat_map(|x| x.to_le_bytes()).collect();
    let interleaved = file.view(&interleaved);
    file.json["bufferViews"][interleaved]["byteStride"] = json!(20);
    let accessor = json!({ "componentType": 5126, "count": 4, "type": "VEC3", "bufferView": interleaved });
    let strided = file.push("accessors", accessor);
    let png = support::png(2, 2, &[[1, 2, 3, 255], [200, 100, 50, 255], [0; 4], [255; 4]]);
    let png = file.view(&png);
    let mut jpeg = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(9, 9, image::Rgb([9, 99, 199])).write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
    let jpeg = file.view(&jpeg.into_inner());
    file.json["images"] = json!([{ "bufferView": png }, { "bufferView": jpeg, "mimeType": "image/jpeg" }]);
    file.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648, "magFilter": 9729 }]);
    file.json["textures"] = json!([{ "source": 0, "sampler": 0 }, { "source": 1, "name": "t" }]);
    file.json["materials"] = surfaces();
    file.json["meshes"] = json!([
        { "name": "m", "primitives": [
            { "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": coordinates, "TEXCOORD_1": second,
                "COLOR_0": colors },
              "indices": indices, "material": 0 },
            { "attributes": { "POSITION": sparse, "TEXCOORD_3": coordinates }, "mode": 5, "material": 1 },
            { "attributes": { "POSITION": positions, "TEXCOORD_1": second }, "material": 2, "indices": indices } ] },
        { "primitives": [{ "attributes": { "POSITION": strided }, "indices": bytes, "mode": 6 }] },
    ]);
    posed(&mut file);
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_specular"]);
    file.json["extensionsRequired"] = json!(["KHR_lights_punctual", "KHR_materials_volume", "KHR_texture_transform"]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "color": [1, 0.5, 0.25], "intensity": 3,
          "extras": { "angular_diameter_rad": 0.0093 } },
        { "type": "spot", "range": 5, "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.4 } } ] } });
    file.json["cameras"] = json!([
        { "type": "perspective", "perspective": { "yfov": 0.6, "aspectRatio": 1.5, "znear": 0.1, "zfar": 100 } },
        { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 2, "znear": 0, "zfar": 10 } },
    ]);
    file.json["extensions"]["KHR_materials_variants"] = json!({ "variants": [{ "name": "day" }, { "name": "night" }] });
    let instancing = file.json["instancing"].take();
    file.json["nodes"] = json!([
        { "children": [1, 2], "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8], "scale": [1, -2, 1] },
        { "mesh": 0, "name": "n", "children": [3], "skin": 0, "weights": [0.25] },
        { "mesh": 1, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": instancing },
            "KHR_node_visibility": { "visible": true } }, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1] },
        { "camera": 0, "extensions": { "KHR_lights_punctual": { "light": 1 } } },
        { "camera": 1, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
    ]);
    animated(&mut file);
    file.json["scenes"] = json!([{ "nodes": [0, 4] }]);
    file.json["scene"] = json!(0);
    file
}

/// Adds animations with all interpolations, of nodes and by a pointer.
fn animated(file: &mut support::File) {
    let times = file.floats(&[[0.0_f32], [1.0]]);
    let places = file.floats(&[[0.0_f32, 1.0, 2.0], [1.0, 0.0, 3.0]]);
    let turns = file.accessor(&[0, 0, 0, 127, 0, 90, 0, 90], 5120, "VEC4", 2);
    file.json["accessors"][turns]["normalized"] = json!(true);
    let splines = file.floats(&[[0.0_f32], [0.25], [1.0], [0.5], [0.75], [0.0]]);
    let channel =
        |sampler: usize, path: &str| json!({ "sampler": sampler, "target": { "node": sampler / 2, "path": path } });
    let pointer = json!({ "path": "pointer",
        "extensions": { "KHR_animation_pointer": { "pointer": "/cameras/0/perspective/yfov" } } });
    file.json["animations"] = json!([{
        "name": "all", "channels": [channel(0, "translation"), channel(1, "rotation"), channel(2, "weights"),
            { "sampler": 3, "target": pointer }],
        "samplers": [{ "input": times, "output": places, "interpolation": "STEP" }, { "input": times, "output": turns },
            { "input": times, "output": splines, "interpolation": "CUBICSPLINE" },
            { "input": times, "output": times }] }]);
}

/// Adds what moves and repeats meshes, and images of other formats.
fn posed(file: &mut support::File) {
    let joints = file.accessor(&[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0], 5121, "VEC4", 4);
    let weights = file.floats(&[[0.5_f32, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0; 4], [0.25, 0.5, 0.0, 0.0]]);
    let identity = [[1.0_f32, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let matrices = file.floats(&[identity, identity].concat());
    file.json["accessors"][matrices]["type"] = json!("MAT4");
    file.json["accessors"][matrices]["count"] = json!(2);
    let rotations = file.accessor(&[0, 0, 0, 127, 0, 90, 0, 90], 5120, "VEC4", 2);
    file.json["accessors"][rotations]["normalized"] = json!(true);
    let places = file.floats(&[[1.0_f32, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    let mut webp = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(2, 2, image::Rgb([9, 99, 199])).write_to(&mut webp, image::ImageFormat::WebP).unwrap();
    let webp = file.view(&webp.into_inner());
    file.push("images", json!({ "bufferView": webp }));
    file.push("textures", json!({ "source": 0, "sampler": 0, "extensions": { "EXT_texture_webp": { "source": 2 } } }));
    let first = &mut file.json["meshes"][0]["primitives"][0];
    first["attributes"]["JOINTS_0"] = json!(joints);
    first["attributes"]["WEIGHTS_0"] = json!(weights);
    first["targets"] =
        json!([{ "POSITION": first["attributes"]["POSITION"], "NORMAL": first["attributes"]["NORMAL"] }]);
    first["extensions"] = json!({ "KHR_materials_variants": { "mappings": [{ "material": 3, "variants": [0, 1] }] } });
    file.json["meshes"][0]["weights"] = json!([0.5]);
    file.json["skins"] = json!([{ "joints": [0, 3], "inverseBindMatrices": matrices, "skeleton": 0 }]);
    file.json["instancing"] = json!({ "TRANSLATION": places, "ROTATION": rotations, "SCALE": places });
}

/// A small scene written by `to_glb`.
fn written() -> Vec<u8> {
    let mesh = Mesh {
        name: "quad".into(),
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        texture_coordinates: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        second_texture_coordinates: vec![[0.5, 0.0], [0.0, 0.5], [1.0, 1.0], [0.0, 1.0]],
        colors: vec![[1.0, 0.5, 0.25, 1.0]; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let texels = (0..16).map(|k| [k * 16, 255 - k, 7, 255]).collect();
    let texture = Texture {
        name: "t".into(),
        width: 4,
        height: 4,
        texels,
        wrap_u: Wrap::Mirror,
        wrap_v: Wrap::Clamp,
        filter: Filter::Nearest,
    };
    let transform = TextureTransform { offset: [0.1, 0.2], rotation_rad: 0.3, scale: [4.0, 5.0] };
    let moved = TextureInfo { texture: 0, set: 1, transform };
    let material = Material {
        base_color_texture: Some(TextureInfo::new(0)),
        metallic: 0.25,
        roughness: 0.5,
        normal_map: Some(NormalMap { texture: moved, scale: 0.7 }),
        emission: [7.0, 0.1, 0.0],
        alpha: Alpha::Mask(0.3),
        ior: 1.6,
        transmission: 0.5,
        transmission_texture: Some(moved),
        volume: Some(Volume { attenuation_distance_m: 0.1, attenuation_color: [0.9, 0.8, 0.7] }),
        unlit: true,
        ..Material::default()
    };
    let pose = Transform::look_at([1.0, 2.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0]);
    let scene = Scene {
        meshes: vec![mesh],
        instances: vec![Instance { name: "i".into(), mesh: 0, transform: pose }],
        materials: vec![material],
        textures: vec![texture],
        lights: vec![Light {
            name: "l".into(),
            intensity: [1.0, 2.0, 3.0],
            kind: LightKind::Directional { direction: [0.0, -0.6, -0.8], angular_diameter_rad: 0.01 },
        }],
        cameras: vec![Camera {
            name: "c".into(),
            pose,
            projection: CameraProjection::Perspective { vertical_angle_rad: 0.8, aspect_ratio: Some(1.5) },
        }],
        environment: None,
    };
    to_glb(&scene).unwrap()
}

/// The files to be mutated. The last one is JSON with a data URI.
fn originals() -> Vec<Vec<u8>> {
    let file = everything();
    let mut text = file.json.clone();
    let uri = format!("data:application/octet-stream;base64,{}", support::base64(&file.binary));
    text["buffers"][0]["uri"] = json!(uri);
    vec![file.glb(), written(), text.to_string().into_bytes()]
}

/// Values that are common causes of errors in readers.
fn awkward(random: &mut Random) -> Value {
    let values = [
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(7),
        json!(255),
        json!(65_535),
        json!(4_294_967_295_u32),
        json!(4_294_967_296_u64),
        json!(u64::MAX),
        json!(i64::MIN),
        json!(1e308),
        json!(-1e308),
        json!(1e-320),
        json!(0.5),
        json!(2.0),
        json!(1e19),
        json!(""),
        json!("x"),
        json!("VEC3"),
        json!("SCALAR"),
        json!("MAT4"),
        json!("data:,"),
        json!("data:;base64,AAAA"),
        json!("../x"),
        json!([]),
        json!([0]),
        json!([1, 1, 1]),
        json!({}),
        json!({ "index": 0 }),
        json!(5120),
        json!(5121),
        json!(5123),
        json!(5125),
        json!(5126),
        json!(12),
        json!(1 << 20),
    ];
    values[random.below(values.len())].clone()
}

/// The number of nodes of a JSON value, including itself.
fn places(value: &Value) -> usize {
    1 + match value {
        Value::Object(map) => map.values().map(places).sum(),
        Value::Array(list) => list.iter().map(places).sum(),
        _ => 0,
    }
}

/// Node number `k`. All nodes are equally likely to be edited, so that most edits are deep in the tree.
fn place(value: &mut Value, k: usize) -> &mut Value {
    if k == 0 {
        return value;
    }
    let children: Vec<&mut Value> = match value {
        Value::Object(map) => map.values_mut().collect(),
        Value::Array(list) => list.iter_mut().collect(),
        _ => Vec::new(),
    };
    let mut k = k - 1;
    for child in children {
        let inside = places(child);
        if k < inside {
            return place(child, k);
        }
        k -= inside;
    }
    panic!("there are fewer places");
}

fn any_place<'v>(value: &'v mut Value, random: &mut Random) -> &'v mut Value {
    let k = random.below(places(value));
    place(value, k)
}

fn edit_json(json: &mut Value, random: &mut Random) {
    let replacement = match random.below(3) {
        // A value from elsewhere in the same file.
        0 => any_place(&mut json.clone(), random).clone(),
        _ => awkward(random),
    };
    let choice = random.below(7);
    let place = any_place(json, random);
    match (choice, place) {
        (0, Value::Object(map)) if !map.is_empty() => {
            let key = map.keys().nth(random.below(map.len())).cloned().unwrap();
            map.remove(&key);
        }
        (1, Value::Array(list)) => list.insert(random.below(list.len() + 1), replacement),
        (2, Value::Array(list)) if !list.is_empty() => drop(list.swap_remove(random.below(list.len()))),
        // Off-by-one numbers.
        (3, Value::Number(number)) if number.is_u64() => {
            let near = number.as_u64().unwrap().wrapping_add(random.below(5) as u64).wrapping_sub(2);
            *number = near.into();
        }
        // A number for a number passes the checks of types.
        (4 | 5, place @ Value::Number(_)) => {
            let numbers = std::iter::repeat_with(|| awkward(random));
            *place = numbers.take(100).find(Value::is_number).unwrap_or(replacement);
        }
        (_, place) => *place = replacement,
    }
}

/// Splits a binary container into chunks; `None` for other files.
fn parts(bytes: &[u8]) -> Option<(Value, Vec<u8>)> {
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes(b.try_into().unwrap()) as usize);
    bytes.starts_with(b"glTF").then_some(())?;
    let length = word(12)?;
    Some((serde_json::from_slice(bytes.get(20..20 + length)?).ok()?, bytes.get(28 + length..)?.to_vec()))
}

fn mutate(original: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = original.to_vec();
    match random.below(10) {
        0 => bytes.truncate(random.below(bytes.len())),
        1 => {
            for _ in 0..1 + random.below(16) {
                let k = random.below(bytes.len());
                bytes[k] ^= 1 << random.below(8);
            }
        }
        2 => {
            let (from, to) = (random.below(bytes.len()), random.below(bytes.len()));
            let length = random.below(64).min(bytes.len() - from).min(bytes.len() - to);
            bytes.copy_within(from..from + length, to);
        }
        3 => {
            let k = random.below(bytes.len());
            let length = random.below(64).min(bytes.len() - k);
            let piece: Vec<u8> = bytes.drain(k..k + length).collect();
            if random.below(2) == 0 {
                let k = random.below(bytes.len());
                bytes.splice(k..k, piece);
            }
        }
        _ => {
            let (mut json, mut binary) = match parts(original) {
                Some(parts) => parts,
                None => (serde_json::from_slice(original).unwrap(), Vec::new()),
            };
            // Mostly one edit, which passes the most checks; sometimes more.
            for _ in 0..[1, 1, 1, 0, 2, 4][random.below(6)] {
                edit_json(&mut json, random);
            }
            for _ in 0..if binary.is_empty() { 0 } else { [0, 0, 1, 3][random.below(4)] } {
                let k = random.below(binary.len());
                binary[k] = [0x7F, 0xFF, 0, binary[k] ^ 1 << random.below(8)][random.below(4)];
            }
            let text = json.to_string();
            bytes =
                if original.starts_with(b"glTF") { support::glb(text.as_bytes(), &binary) } else { text.into_bytes() };
        }
    }
    bytes
}

#[test]
fn damaged_files_neither_panic_nor_hang() {
    let is_thorough = std::env::var_os("HOLO_THOROUGH").is_some_and(|value| value == "1");
    let count = if is_thorough { 100_000_u64 } else { 2000 };
    std::panic::set_hook(Box::new(|info| {
        if is_guarding() {
            CAUGHT.fetch_add(1, Ordering::Relaxed);
        } else {
            ESCAPED.fetch_add(1, Ordering::Relaxed);
        }
        eprintln!("{info}");
    }));
    let originals = originals();
    let load = |bytes: &[u8], limits: &Limits, time_s: Option<f64>| {
        let mut options = LoadOptions::default();
        (options.limits, options.time_s) = (*limits, time_s);
        load_slice_with(bytes, &options)
    };
    for original in &originals {
        for time_s in [None, Some(0.4)] {
            let loaded = load(original, &Limits::default(), time_s);
            assert!(loaded.is_ok(), "the files are sound before they are damaged: {loaded:?}");
        }
    }
    // Small limits, as for untrusted files; the default ones allow gigabytes.
    let limits =
        Limits { max_triangles: 1 << 16, max_vertices: 1 << 16, max_texture_pixels: 1 << 20, ..Limits::default() };
    let (mut loaded, mut rewritten, mut slowest) = (0_u64, 0_u64, Duration::ZERO);
    for seed in 0..count {
        let mut random = Random(seed);
        let original = &originals[random.below(originals.len())];
        let bytes = mutate(original, &mut random);
        let start = Instant::now();
        let limits = if seed % 2 == 0 { &limits } else { &LARGE };
        // Half of them at a time of their animations.
        let time_s = (seed % 4 < 2).then_some(0.4);
        let outcome = std::panic::catch_unwind(|| load(&bytes, limits, time_s));
        slowest = slowest.max(start.elapsed());
        match outcome {
            Err(_) => panic!("file {seed} panicked"),
            Ok(Err(error)) => assert!(!error.to_string().is_empty()),
            Ok(Ok(file)) => {
                loaded += 1;
                file.scene.validate().unwrap_or_else(|error| panic!("file {seed} loaded, but {error}"));
                // A loaded scene can be written, except for meshes without triangles, and the round trip is exact.
                if let Ok(bytes) = to_glb(&file.scene) {
                    let again = load_slice(&bytes, &Limits::default()).unwrap();
                    assert_eq!(again.scene, file.scene, "file {seed}");
                    rewritten += 1;
                }
            }
        }
        assert_eq!(CAUGHT.load(Ordering::Relaxed), 0, "file {seed} needed the last net");
    }
    let assert_rejected = count - loaded;
    println!("{count} damaged files: {assert_rejected} refused, {loaded} loaded, {rewritten} of them written again");
    println!("panics caught by the last net: 0, slowest file: {slowest:?}");
    assert_eq!((CAUGHT.load(Ordering::Relaxed), ESCAPED.load(Ordering::Relaxed)), (0, 0));
    assert!(loaded > count / 50 && loaded < count, "the damage is neither nothing nor everything");
    assert!(slowest < Duration::from_secs(10), "a file took {slowest:?}");
}

/// Limits as for trusted files, but with less memory.
const LARGE: Limits = Limits {
    max_triangles: 1 << 24,
    max_vertices: 1 << 24,
    max_instances: 1 << 22,
    max_texture_pixels: 1 << 26,
    max_bytes: 16 << 30,
};

/// Renews the seeds of the fuzzer: `cargo test -p holo-scene --test all write_the_corpus -- --ignored`.
#[test]
#[ignore = "writes fuzz/corpus/gltf"]
fn write_the_corpus() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/gltf");
    let folder = std::env::var("HOLO_CORPUS").unwrap_or_else(|_| folder.to_owned());
    std::fs::create_dir_all(&folder).unwrap();
    let [everything, written, _] = originals().try_into().unwrap();
    let triangle = support::triangle();
    let mut data_uri = triangle.json.clone();
    data_uri["buffers"][0]["uri"] = format!("data:;base64,{}", support::base64(&triangle.binary)).into();
    let files = [
        ("everything.glb", everything),
        ("written.glb", written),
        ("data_uri.gltf", data_uri.to_string().into_bytes()),
        ("triangle.glb", triangle.glb()),
        ("empty.glb", support::File::new().glb()),
    ];
    for (name, bytes) in files {
        println!("{name}: {} bytes", bytes.len());
        std::fs::write(std::path::Path::new(&folder).join(name), bytes).unwrap();
    }
}
