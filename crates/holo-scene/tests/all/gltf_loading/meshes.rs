//! Primitives and accessors.

use holo_scene::Mesh;
use holo_scene::gltf::{Limits, load_slice};
use serde_json::json;

use super::support::{File, TRIANGLE, assert_contains, triangle};

fn only_mesh(file: &File) -> Mesh {
    let scene = file.load().unwrap().scene;
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 1));
    scene.meshes.into_iter().next().unwrap()
}

const FIVE: [[f32; 3]; 5] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.5, 2.0, 0.25]];

#[test]
fn plain_triangles() {
    let mut file = File::new();
    let positions = file.floats(&[FIVE[0], FIVE[1], FIVE[2], FIVE[2], FIVE[1], FIVE[3]]);
    file.show(json!({ "attributes": { "POSITION": positions } }));
    let mesh = only_mesh(&file);
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.positions.len(), 6);
    assert!(mesh.normals.is_empty() && mesh.texture_coordinates.is_empty() && mesh.colors.is_empty());
}

#[test]
fn strips_and_fans_keep_the_front_side() {
    let mut file = File::new();
    let positions = file.floats(&FIVE);
    file.show(json!({ "attributes": { "POSITION": positions }, "mode": 5 }));
    assert_eq!(only_mesh(&file).triangles, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(6);
    assert_eq!(only_mesh(&file).triangles, [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    // Indexed as well.
    let indices = file.indices_u16(&[4, 3, 2, 1]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert_eq!(only_mesh(&file).triangles, [[3, 2, 4], [2, 1, 4]]);
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
    assert_eq!(only_mesh(&file).triangles, [[4, 3, 2], [3, 1, 2]]);
    // A strip of a flat quad: both triangles face the same way.
    let area = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|k| FIVE[k as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut file = File::new();
    let positions = file.floats(&FIVE[..4]);
    file.show(json!({ "attributes": { "POSITION": positions }, "mode": 5 }));
    assert!(only_mesh(&file).triangles.into_iter().all(|triangle| area(triangle) > 0.0));
}

#[test]
fn indices_of_every_width() {
    let expected = [[4, 1, 2], [0, 3, 2]];
    let indices: [u32; 6] = [4, 1, 2, 0, 3, 2];
    let wide = |width: usize| -> Vec<u8> { indices.iter().flat_map(|k| k.to_le_bytes()[..width].to_vec()).collect() };
    for (width, code) in [(1, 5121), (2, 5123), (4, 5125)] {
        let mut file = File::new();
        let positions = file.floats(&FIVE);
        let indices = file.accessor(&wide(width), code, "SCALAR", 6);
        file.show(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
        assert_eq!(only_mesh(&file).triangles, expected, "{width} bytes");
    }
    // Index types that glTF does not have.
    for code in [5120, 5122, 5126, 5124, 0] {
        let mut file = File::new();
        let positions = file.floats(&FIVE);
        let indices = file.accessor(&wide(4), code, "SCALAR", 6);
        file.show(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
        assert_contains(&file.error(), &["accessors[1]"]);
    }
}

#[test]
fn indices_out_of_range_are_named() {
    let mut file = File::new();
    let positions = file.floats(&TRIANGLE);
    let indices = file.indices_u16(&[0, 1, 3]);
    file.show(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    assert_contains(&file.error(), &["accessors[1]", "vertex 3", "meshes[0].primitives[0]", "3 vertices"]);
}

#[test]
fn interleaved_attributes_and_offsets() {
    let mut file = File::new();
    let mut bytes = vec![9_u8; 8];
    for (k, position) in TRIANGLE.iter().enumerate() {
        bytes.extend(position.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0.0_f32, 0.6, 0.8].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([k as u8 * 51, 255, 0, 0]);
    }
    let view = file.view(&bytes);
    file.json["bufferViews"][view]["byteStride"] = json!(28);
    let at = |offset: usize| json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 3, "type": "VEC3" });
    let positions = file.push("accessors", at(8));
    let normals = file.push("accessors", at(20));
    let coordinates = json!({
        "bufferView": view, "byteOffset": 32, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"
    });
    let coordinates = file.push("accessors", coordinates);
    file.show(json!({ "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": coordinates } }));
    let mesh = only_mesh(&file);
    assert_eq!(mesh.positions, TRIANGLE);
    assert_eq!(mesh.normals, [[0.0, 0.6, 0.8]; 3]);
    for ([u, v], expected) in mesh.texture_coordinates.iter().zip([0.0, 0.2, 0.4]) {
        assert!((u - expected).abs() < 1e-7 && *v == 1.0, "{u} {v}");
    }
    // One byte further, the last element ends outside the view.
    file.json["accessors"][positions]["byteOffset"] = json!(26);
    assert_contains(&file.error(), &["accessors[0]", "bufferViews[0]"]);
    file.json["bufferViews"][view]["byteStride"] = json!(8);
    assert_contains(&file.error(), &["byteStride", "12 bytes"]);
}

#[test]
fn colors_of_every_type() {
    let shorts: Vec<u8> = [0_u16, 65535, 13107].repeat(3).iter().flat_map(|x| x.to_le_bytes()).collect();
    let cases: [(Vec<u8>, u32, &str, [f32; 4]); 4] = [
        ([0_u8, 255, 51].repeat(3), 5121, "VEC3", [0.0, 1.0, 0.2, 1.0]),
        ([0_u8, 255, 51, 102].repeat(3), 5121, "VEC4", [0.0, 1.0, 0.2, 0.4]),
        (shorts, 5123, "VEC3", [0.0, 1.0, 0.2, 1.0]),
        (
            [0.25_f32, 2.0, -1.0, 0.5].repeat(3).iter().flat_map(|x| x.to_le_bytes()).collect(),
            5126,
            "VEC4",
            [0.25, 1.0, 0.0, 0.5],
        ),
    ];
    for (bytes, component, shape, expected) in cases {
        let mut file = triangle();
        let colors = file.accessor(&bytes, component, shape, 3);
        file.json["accessors"][colors]["normalized"] = json!(component != 5126);
        file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        for color in only_mesh(&file).colors {
            for (is, should) in color.iter().zip(expected) {
                assert!((is - should).abs() < 1e-7, "{color:?} instead of {expected:?}");
            }
        }
        if component != 5126 {
            file.json["accessors"][colors]["normalized"] = json!(false);
            assert_contains(&file.error(), &["accessors[1]", "normalized"]);
        }
    }
}

#[test]
fn sparse_accessors() {
    let mut file = triangle();
    let indices = file.view(&[0, 2]);
    let values: Vec<u8> =
        [[7.0_f32, 8.0, 9.0], [0.0, 2.0, 0.0]].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let values = file.view(&values);
    file.json["accessors"][0]["sparse"] = json!({ "count": 2,
        "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values } });
    assert_eq!(only_mesh(&file).positions, [[7.0, 8.0, 9.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    // Over zeros.
    file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(only_mesh(&file).positions, [[7.0, 8.0, 9.0], [0.0; 3], [0.0, 2.0, 0.0]]);
    let offset = file.json["bufferViews"][indices]["byteOffset"].as_u64().unwrap() as usize;
    let mut broken = |bytes: [u8; 2]| {
        file.binary[offset..offset + 2].copy_from_slice(&bytes);
        file.error()
    };
    assert_contains(&broken([2, 0]), &["accessors[0].sparse.indices", "increase"]);
    assert_contains(&broken([1, 1]), &["accessors[0].sparse.indices", "increase"]);
    assert_contains(&broken([0, 3]), &["accessors[0].sparse.indices", "below the count 3"]);
    file.binary[offset..offset + 2].copy_from_slice(&[0, 2]);
    let sparse = |key: &str, value: serde_json::Value| {
        let mut broken = File { json: file.json.clone(), binary: file.binary.clone() };
        broken.json["accessors"][0]["sparse"][key] = value;
        broken.error()
    };
    assert_contains(&sparse("count", json!(0)), &["accessors[0].sparse.count"]);
    assert_contains(&sparse("count", json!(4)), &["accessors[0].sparse.count"]);
    assert_contains(&sparse("count", json!(3)), &["accessors[0].sparse"]);
    assert_contains(&sparse("values", json!({ "bufferView": 99 })), &["accessors[0].sparse.values.bufferView"]);
    assert_contains(&sparse("indices", json!({ "bufferView": indices, "componentType": 5126 })), &["componentType"]);
    assert_contains(
        &sparse("indices", json!({ "bufferView": indices, "componentType": 5121, "byteOffset": u64::MAX })),
        &["sparse.indices"],
    );
}

#[test]
fn an_accessor_without_data_is_zeros() {
    let mut file = triangle();
    let zeros = file.push("accessors", json!({ "componentType": 5126, "count": 3, "type": "VEC2" }));
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(zeros);
    let indices = file.push("accessors", json!({ "componentType": 5125, "count": 6, "type": "SCALAR" }));
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let mesh = only_mesh(&file);
    assert_eq!(mesh.texture_coordinates, [[0.0; 2]; 3]);
    assert_eq!(mesh.triangles, [[0; 3]; 2]);
}

#[test]
fn normals_are_unit_vectors() {
    let mut file = triangle();
    let normals = file.floats(&[[0.0_f32, 0.0, 3.0], [0.0, 0.0, 0.0], [1e-30, 0.0, 0.0]]);
    let broken = file.floats(&[[0.0_f32, f32::NAN, 1.0], [f32::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let loaded = file.load().unwrap();
    // Long and short normals are normalized; zero becomes the normal of the face.
    assert_eq!(loaded.scene.meshes[0].normals, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    assert_contains(&loaded.warnings.join("\n"), &["meshes[0].primitives[0]", "normals that are zero or not finite"]);
    // That of a face in any position: (1, 2, 2) / 3 is perpendicular to (2, -2, 1) and (2, 1, -2), in this order.
    let mut other = triangle();
    let turned = other.floats(&[[5.0_f32, 6.0, 7.0], [7.0, 4.0, 8.0], [7.0, 7.0, 5.0]]);
    let zeros = other.floats(&[[0.0_f32; 3]; 3]);
    other.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": turned, "NORMAL": zeros });
    for normal in &other.load().unwrap().scene.meshes[0].normals {
        assert!(
            normal.iter().zip([1.0, 2.0, 2.0]).all(|(x, expected)| (3.0 * x - expected).abs() < 1e-6),
            "{normal:?}"
        );
    }
    // So do normals that are no numbers.
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(broken);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.scene.meshes[0].normals, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
    assert_contains(&loaded.warnings.join("\n"), &["meshes[0].primitives[0]", "normals that are zero or not finite"]);
}

#[test]
fn not_a_number_is_an_error() {
    for (attribute, bad) in [("POSITION", f32::NAN), ("POSITION", f32::INFINITY)] {
        let mut file = triangle();
        let mut values = TRIANGLE;
        values[1][2] = bad;
        let accessor = file.floats(&values);
        file.json["meshes"][0]["primitives"][0]["attributes"][attribute] = json!(accessor);
        assert_contains(&file.error(), &["accessors[1]", "element 1", attribute, "meshes[0].primitives[0]"]);
    }
    for attribute in ["TEXCOORD_0", "COLOR_0"] {
        let mut file = triangle();
        let accessor =
            if attribute == "COLOR_0" { file.floats(&[[f32::NAN; 3]; 3]) } else { file.floats(&[[f32::NAN; 2]; 3]) };
        file.json["meshes"][0]["primitives"][0]["attributes"][attribute] = json!(accessor);
        assert_contains(&file.error(), &["accessors[1]", "element 0"]);
    }
}

#[test]
fn absurd_counts_and_short_buffers_are_errors() {
    for count in
        [json!(4_000_000_000_u32), json!(u64::MAX), json!(1e19), json!(0), json!(-3), json!(1.5), json!("3"), json!(4)]
    {
        let mut file = triangle();
        file.json["accessors"][0]["count"] = count;
        assert_contains(&file.error(), &["accessors[0]"]);
        // Without a buffer view only the limit bounds the memory.
        file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        if file.json["accessors"][0]["count"] != json!(4) {
            file.error();
        }
    }
    let field = |path: &str, value: serde_json::Value| {
        let mut file = triangle();
        *file.json.pointer_mut(path).unwrap() = value;
        file.error()
    };
    assert_contains(&field("/bufferViews/0/byteLength", json!(35)), &["accessors[0]", "35 bytes"]);
    assert_contains(&field("/bufferViews/0/byteLength", json!(37)), &["bufferViews[0]", "37"]);
    assert_contains(&field("/bufferViews/0/byteOffset", json!(4)), &["bufferViews[0]"]);
    assert_contains(&field("/bufferViews/0/byteOffset", json!(u64::MAX)), &["bufferViews[0]"]);
    assert_contains(&field("/bufferViews/0/buffer", json!(1)), &["bufferViews[0].buffer", "buffers[1]"]);
    assert_contains(&field("/buffers/0/byteLength", json!(40)), &["buffers[0].byteLength", "40", "36"]);
    assert_contains(&field("/accessors/0/bufferView", json!(1)), &["accessors[0].bufferView"]);
    assert_contains(&field("/accessors/0/type", json!("VEC2")), &["accessors[0]", "VEC3"]);
    assert_contains(&field("/accessors/0/type", json!("VEC5")), &["accessors[0].type"]);
    assert_contains(&field("/accessors/0/componentType", json!(5125)), &["accessors[0]", "VEC3 of floats"]);
    assert_contains(
        &field("/meshes/0/primitives/0/attributes/POSITION", json!(5)),
        &["attributes.POSITION", "accessors[5]"],
    );
    assert_contains(&field("/meshes/0/primitives/0/attributes", json!([])), &["attributes", "object"]);
}

#[test]
fn limits_are_checked_before_allocation() {
    // 1000 primitives over one accessor: a small file with a large scene.
    let mut file = File::new();
    let positions = file.push("accessors", json!({ "componentType": 5126, "count": 3_000_000, "type": "VEC3" }));
    let primitive = json!({ "attributes": { "POSITION": positions } });
    file.push("meshes", json!({ "primitives": vec![primitive; 1000] }));
    assert_contains(&file.error(), &["meshes[0].primitives[", "limit"]);
    // One triangle with many instances.
    let mut file = triangle();
    file.json["nodes"] = json!(vec![json!({ "mesh": 0 }); 10]);
    let limits =
        |max_triangles: u64, max_instances: usize| Limits { max_triangles, max_instances, ..Limits::default() };
    assert!(load_slice(&file.glb(), &limits(10, 10)).is_ok());
    assert_contains(&load_slice(&file.glb(), &limits(9, 10)).unwrap_err().to_string(), &["nodes[9]", "limit"]);
    assert_contains(&load_slice(&file.glb(), &limits(10, 9)).unwrap_err().to_string(), &["nodes[9]", "limit"]);
    let small = Limits { max_bytes: 100, ..Limits::default() };
    assert_contains(&load_slice(&file.glb(), &small).unwrap_err().to_string(), &["limit of 100"]);
}

#[test]
fn attributes_of_different_lengths_are_errors() {
    let mut file = triangle();
    let normals = file.floats(&[[0.0_f32, 0.0, 1.0]; 2]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert_contains(&file.error(), &["meshes[0].primitives[0].attributes", "NORMAL", "2", "3"]);
}

#[test]
fn primitives_share_meshes_between_nodes() {
    let mut file = triangle();
    let lines = json!({ "attributes": { "POSITION": 0 }, "mode": 1 });
    let pointless = json!({ "attributes": {} });
    let second = json!({ "attributes": { "POSITION": 0 }, "material": 0 });
    file.push("materials", json!({ "name": "m" }));
    file.json["meshes"][0]["primitives"].as_array_mut().unwrap().extend([lines, pointless, second]);
    file.json["meshes"][0]["name"] = json!("pair");
    file.push("nodes", json!({ "mesh": 0, "translation": [1, 0, 0] }));
    let loaded = file.load().unwrap();
    let scene = &loaded.scene;
    assert_eq!(scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect::<Vec<_>>(), ["pair[0]", "pair[3]"]);
    assert_eq!(scene.instances.iter().map(|instance| instance.mesh).collect::<Vec<_>>(), [0, 1, 0, 1]);
    // The primitive without a material has a default material after those of the file.
    assert_eq!(scene.meshes.iter().map(|mesh| mesh.material).collect::<Vec<_>>(), [1, 0]);
    assert_eq!(scene.materials.len(), 2);
    assert_contains(&loaded.warnings.join("\n"), &["points and lines", "without positions"]);
    assert_eq!((loaded.summary.meshes, loaded.summary.instances, loaded.summary.triangles), (2, 4, 4));
}

#[test]
fn incomplete_triangles_cause_a_warning() {
    let mut file = File::new();
    let positions = file.floats(&FIVE);
    file.show(json!({ "attributes": { "POSITION": positions } }));
    let loaded = file.load().unwrap();
    assert_eq!(loaded.scene.meshes[0].triangles, [[0, 1, 2]]);
    assert_contains(&loaded.warnings.join("\n"), &["whole triangles"]);
    let mut file = File::new();
    let positions = file.floats(&FIVE[..2]);
    file.show(json!({ "attributes": { "POSITION": positions }, "mode": 5 }));
    assert!(file.load().unwrap().scene.meshes[0].triangles.is_empty());
}

#[test]
fn quantized_positions_by_hand() {
    let shorts = |values: [i32; 9]| values.iter().flat_map(|&x| (x as i16).to_le_bytes()).collect::<Vec<u8>>();
    let bytes = |values: [i32; 9]| values.map(|x| x as u8).to_vec();
    let signed = [-128, -127, 127, 1, 0, -1, 64, 32, -64];
    let large = [-32768, -32767, 32767, 1, 0, -1, 16384, 12345, -12345];
    let cases: [(Vec<u8>, u32, bool, [f64; 9]); 8] = [
        (bytes(signed), 5120, false, signed.map(f64::from)),
        (bytes(signed), 5120, true, signed.map(|x| (f64::from(x) / 127.0).max(-1.0))),
        (bytes(signed), 5121, false, signed.map(|x| f64::from(x as u8))),
        (bytes(signed), 5121, true, signed.map(|x| f64::from(x as u8) / 255.0)),
        (shorts(large), 5122, false, large.map(f64::from)),
        (shorts(large), 5122, true, large.map(|x| (f64::from(x) / 32767.0).max(-1.0))),
        (shorts(large), 5123, false, large.map(|x| f64::from(x as u16))),
        (shorts(large), 5123, true, large.map(|x| f64::from(x as u16) / 65535.0)),
    ];
    for (bytes, component, normalized, expected) in cases {
        let mut file = File::new();
        let positions = file.accessor(&bytes, component, "VEC3", 3);
        file.json["accessors"][positions]["normalized"] = json!(normalized);
        file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        file.show(json!({ "attributes": { "POSITION": positions } }));
        let loaded = file.load().unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!(loaded.scene.meshes[0].positions.as_flattened(), expected.map(|x| x as f32), "{component}");
    }
}

/// Each element at a multiple of four bytes, as the specification wants it.
#[test]
fn quantized_normals_and_coordinates_with_strides() {
    let mut file = triangle();
    let view = file.view(&[0, 0, 127, 9, 0, 129, 0, 9, 128, 0, 0, 9]);
    file.json["bufferViews"][view]["byteStride"] = json!(4);
    let normals = json!({ "bufferView": view, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3" });
    let normals = file.push("accessors", normals);
    // Six bytes an element, of which the first two are not used: the end of the last one is that of the view.
    let view = file.view(&[9, 9, 0, 0, 0xFF, 0x7F, 9, 9, 2, 0, 0, 0x80, 9, 9, 0xFF, 0xFF, 1, 0]);
    file.json["bufferViews"][view]["byteStride"] = json!(6);
    let coordinates = json!({ "bufferView": view, "byteOffset": 2, "componentType": 5122, "count": 3, "type": "VEC2" });
    let coordinates = file.push("accessors", coordinates);
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    let mesh = only_mesh(&file);
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]);
    assert_eq!(mesh.texture_coordinates, [[0.0, 32767.0], [2.0, -32768.0], [-1.0, 1.0]]);
    file.json["accessors"][coordinates]["normalized"] = json!(true);
    assert_eq!(
        only_mesh(&file).texture_coordinates,
        [[0.0, 1.0], [2.0 / 32767.0, -1.0], [-1.0 / 32767.0, 1.0 / 32767.0]]
    );
    // Integers that are no directions, and types that no vertex has.
    let wrong = |accessor: usize, key: &str, value: serde_json::Value| {
        let mut file = File { json: file.json.clone(), binary: file.binary.clone() };
        file.json["accessors"][accessor][key] = value;
        file.error()
    };
    assert_contains(&wrong(normals, "normalized", json!(false)), &["accessors[1]", "normalized signed"]);
    assert_contains(&wrong(normals, "componentType", json!(5121)), &["accessors[1]", "normalized signed"]);
    assert_contains(&wrong(coordinates, "componentType", json!(5125)), &["accessors[2]", "VEC2"]);
    assert_contains(&wrong(coordinates, "type", json!("VEC3")), &["accessors[2]", "VEC2"]);
}

#[test]
fn animations_cause_a_warning() {
    let mut file = triangle();
    // Invalid, but ignored features are not validated.
    file.json["skins"] = json!([{ "joints": [] }]);
    file.json["animations"] = json!([{ "channels": [{ "sampler": 9 }] }]);
    let warnings = file.load().unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert_contains(&warnings[0], &["animations are ignored"]);
}
