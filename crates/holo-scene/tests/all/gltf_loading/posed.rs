//! Morph targets and skins in the pose of the file.

use holo_scene::gltf::{Limits, load_slice};
use serde_json::json;

use super::support::{File, TRIANGLE, assert_contains, triangle};

#[track_caller]
fn assert_close(is: &[[f32; 3]], expected: &[[f64; 3]]) {
    assert_eq!(is.len(), expected.len());
    for (is, expected) in is.iter().zip(expected) {
        assert!(
            is.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6),
            "{is:?} instead of {expected:?}"
        );
    }
}

/// A triangle with two morph targets: one lifts the first vertex, the other moves all along x and turns the normals.
fn morphed() -> File {
    let mut file = triangle();
    let normals = file.floats(&[[0.0_f32, 0.0, 1.0]; 3]);
    let lift = file.floats(&[[0.0_f32, 0.0, 2.0], [0.0; 3], [0.0; 3]]);
    let shift = file.floats(&[[4.0_f32, 0.0, 0.0]; 3]);
    let turn = file.floats(&[[2.0_f32, 0.0, 0.0]; 3]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["NORMAL"] = json!(normals);
    primitive["targets"] = json!([{ "POSITION": lift }, { "POSITION": shift, "NORMAL": turn }]);
    file
}

#[test]
fn morph_targets() {
    let mut file = morphed();
    // Without weights nothing moves, and nothing is said about it.
    let loaded = file.load().unwrap();
    assert_eq!((&loaded.scene.meshes[0].positions[..], loaded.warnings), (&TRIANGLE[..], vec![]));
    file.json["meshes"][0]["weights"] = json!([0.5, 0.25]);
    let mesh = file.load().unwrap().scene.meshes.remove(0);
    assert_close(&mesh.positions, &[[1.0, 0.0, 1.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    let (sine, cosine) = (0.5 / 1.25_f64.sqrt(), 1.0 / 1.25_f64.sqrt());
    assert_close(&mesh.normals, &[[sine, 0.0, cosine]; 3]);
    // Fewer weights than targets: the rest is 0.
    file.json["meshes"][0]["weights"] = json!([0.5]);
    assert_eq!(file.load().unwrap().scene.meshes[0].positions[0], [0.0, 0.0, 1.0]);
}

#[test]
fn nodes_with_other_weights_are_other_meshes() {
    let mut file = morphed();
    file.json["meshes"][0]["weights"] = json!([1, 0]);
    file.json["nodes"] = json!([
        { "mesh": 0, "name": "own" },
        { "mesh": 0, "name": "still", "weights": [0, 0] },
        { "mesh": 0, "name": "same" },
        { "mesh": 0, "name": "shifted", "weights": [0, 1] },
        { "mesh": 0, "name": "shifted too", "weights": [0, 1] },
    ]);
    let scene = file.load().unwrap().scene;
    let first = |k: usize| scene.meshes[scene.instances[k].mesh].positions[0];
    assert_eq!(
        [0, 1, 2, 3, 4].map(first),
        [[0.0, 0.0, 2.0], [0.0; 3], [0.0, 0.0, 2.0], [4.0, 0.0, 0.0], [4.0, 0.0, 0.0]]
    );
    assert_eq!(scene.meshes.len(), 3);
}

#[test]
fn invalid_morph_targets_are_errors() {
    let mut file = morphed();
    file.json["meshes"][0]["weights"] = json!([1, 1]);
    let two = file.floats(&[[0.0_f32; 3]; 2]);
    file.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(two);
    assert_contains(&file.error(), &["targets[0].POSITION", "2 elements", "3"]);
    let huge = file.floats(&[[f32::MAX; 3]; 3]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": huge }, { "POSITION": huge }]);
    assert_contains(&file.error(), &["element 0", "moved by morph targets"]);
    file.json["meshes"][0]["weights"] = json!([1, "x"]);
    assert_contains(&file.error(), &["meshes[0].weights[1]", "number"]);
    // Every target reads all vertices.
    file.json["meshes"][0]["weights"] = json!([0.1, 0.1]);
    let limits = |max_vertices| Limits { max_vertices, ..Limits::default() };
    assert!(load_slice(&file.glb(), &limits(9)).is_ok());
    assert_contains(&load_slice(&file.glb(), &limits(8)).unwrap_err().to_string(), &["limit", "8 vertices"]);
}

/// Three vertices: one follows the first joint, one the second, one half of each. The first joint stands at x = 10, the
/// second two above it, turned by a quarter about z.
fn skinned() -> File {
    let mut file = File::new();
    let positions = file.floats(&[[0.0_f32, 0.0, 0.0], [0.0, 3.0, 0.0], [1.0, 2.0, 0.0]]);
    let normals = file.floats(&[[1.0_f32, 0.0, 0.0]; 3]);
    let joints = file.accessor(&[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0], 5121, "VEC4", 3);
    let weights = file.floats(&[[1.0_f32, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]]);
    // Bound where both stand upright above the origin: the second one at y = 2.
    let mut bytes: Vec<u8> = Vec::new();
    for lowered in [0.0_f32, -2.0] {
        let columns = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, lowered, 0.0, 1.0];
        bytes.extend(columns.iter().flat_map(|x: &f32| x.to_le_bytes()));
    }
    let matrices = file.accessor(&bytes, 5126, "MAT4", 2);
    file.push(
        "meshes",
        json!({ "primitives": [{ "attributes":
        { "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights } }] }),
    );
    file.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": matrices }]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    file.json["nodes"] = json!([
        // The transform of this node has no effect.
        { "mesh": 0, "skin": 0, "translation": [100, 100, 100], "scale": [9, 9, 9] },
        { "translation": [10, 0, 0], "children": [2] },
        { "translation": [0, 2, 0], "rotation": [0, 0, half, half] },
    ]);
    file
}

/// Vertices in the world, of the only instance.
fn world(file: &File) -> Vec<[f32; 3]> {
    let scene = file.load().unwrap().scene;
    let [instance] = &scene.instances[..] else { panic!("{} instances", scene.instances.len()) };
    let positions = scene.meshes[instance.mesh].positions.iter();
    positions.map(|p| instance.transform.point(p.map(f64::from)).map(|x| x as f32)).collect()
}

#[test]
fn skins() {
    let mut file = skinned();
    assert_eq!(file.load().unwrap().warnings, [""; 0]);
    // The second vertex is 1 above the second joint, now 1 to its left; the third is 1 to its right, now 1 above.
    let expected = [[10.0, 0.0, 0.0], [9.0, 2.0, 0.0], [(11.0 + 10.0) / 2.0, (2.0 + 3.0) / 2.0, 0.0]];
    assert_close(&world(&file), &expected);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert_close(&file.load().unwrap().scene.meshes[0].normals, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [half, half, 0.0]]);
    // Joints need not be in the scene, and without inverse bind matrices they are identities.
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    assert_close(&world(&file), &expected);
    file.json["skins"] = json!([{ "joints": [1, 2] }]);
    assert_close(&world(&file)[1..2], &[[7.0, 2.0, 0.0]]);
}

#[test]
fn weights_need_not_sum_to_one() {
    let mut file = skinned();
    let weights = file.accessor(&[200, 0, 0, 0, 100, 0, 0, 0, 7, 7, 0, 0], 5121, "VEC4", 3);
    file.json["accessors"][weights]["normalized"] = json!(true);
    let expected = world(&file);
    file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    assert_eq!(world(&file), expected);
    // Without any weight a vertex follows its first joint; a joint with weight 0 may be wrong.
    let joints = file.accessor(&[0, 0, 0, 99, 1, 0, 0, 0, 0, 1, 0, 0], 5121, "VEC4", 3);
    let weights = file.floats(&[[1.0_f32, 0.0, 0.0, 0.0], [0.0; 4], [0.5, 0.5, 0.0, 0.0]]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    assert_eq!(world(&file), expected);
}

/// Five joints: four in the first set, one in the second, which has all the weight.
#[test]
fn two_sets_of_joints() {
    let mut file = skinned();
    let zero = file.floats(&[[0.0_f32; 4]; 3]);
    let first = file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"].clone();
    let weights = file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"].clone();
    let expected = world(&file);
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["WEIGHTS_0"] = json!(zero);
    attributes["JOINTS_1"] = first;
    attributes["WEIGHTS_1"] = weights;
    assert_eq!(world(&file), expected);
}

#[test]
fn skins_share_or_part_meshes() {
    let mut file = skinned();
    file.push("skins", json!({ "joints": [2, 1] }));
    file.json["nodes"] = json!([
        { "mesh": 0, "skin": 0 }, { "children": [2] }, { "translation": [0, 2, 0] },
        { "mesh": 0, "skin": 0 }, { "mesh": 0, "skin": 1 }, { "mesh": 0 },
    ]);
    let scene = file.load().unwrap().scene;
    let meshes: Vec<usize> = scene.instances.iter().map(|instance| instance.mesh).collect();
    assert_eq!((meshes, scene.meshes.len()), (vec![1, 1, 2, 0], 3));
    // Copies count: a small file must not need much memory.
    let limits = |max_vertices| Limits { max_vertices, ..Limits::default() };
    assert!(load_slice(&file.glb(), &limits(3 + 6 + 6)).is_ok());
    assert_contains(&load_slice(&file.glb(), &limits(14)).unwrap_err().to_string(), &["limit"]);
}

#[test]
fn mirrored_skins_keep_their_outside() {
    let mut file = skinned();
    file.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let mesh = file.load().unwrap().scene.meshes.remove(0);
    assert_eq!(mesh.triangles, [[0, 2, 1]]);
    assert_close(&mesh.normals[..1], &[[-1.0, 0.0, 0.0]]);
}

#[test]
fn precision_far_from_the_origin() {
    let mut file = skinned();
    file.json["nodes"][1]["translation"] = json!([1e7, 0, 0.125]);
    let scene = file.load().unwrap().scene;
    assert_eq!(scene.instances[0].transform.translation, [1e7, 0.0, 0.125]);
    assert_eq!(scene.meshes[0].positions[0], [0.0; 3]);
}

#[test]
fn invalid_skins_are_errors() {
    let error = |change: &dyn Fn(&mut File)| {
        let mut file = skinned();
        change(&mut file);
        file.error()
    };
    assert_contains(&error(&|file| file.json["skins"][0]["joints"] = json!([1])), &["joint 1", "1 joints"]);
    assert_contains(&error(&|file| file.json["skins"][0]["joints"] = json!([])), &["skins[0].joints", "0 joints"]);
    assert_contains(
        &error(&|file| file.json["skins"][0]["joints"] = json!([1, 9])),
        &["skins[0].joints[1]", "nodes[9]"],
    );
    assert_contains(&error(&|file| file.json["nodes"][0]["skin"] = json!(3)), &["nodes[0].skin", "skins[3]"]);
    assert_contains(
        &error(&|file| file.json["skins"][0]["joints"] = json!([1, 2, 1])),
        &["inverseBindMatrices", "2 matrices for 3 joints"],
    );
    assert_contains(&error(&|file| file.json["accessors"][4]["componentType"] = json!(5125)), &["MAT4 of floats"]);
    // Without data, all matrices are zero; a small file must not allocate millions of them.
    let zeros = json!({ "componentType": 5126, "count": 4_000_000_000_u32, "type": "MAT4" });
    assert_contains(&error(&|file| file.json["accessors"][4] = zeros.clone()), &["number 0 is not affine"]);
    let attributes = |file: &mut File, key: &str, value| {
        file.json["meshes"][0]["primitives"][0]["attributes"][key] = value;
    };
    assert_contains(&error(&|file| attributes(file, "JOINTS_0", json!(0))), &["JOINTS_0", "VEC4"]);
    assert_contains(&error(&|file| attributes(file, "JOINTS_1", json!(2))), &["WEIGHTS_1", "missing"]);
}

/// The node has a skin, the primitive no joints: loaded with the transform of the node.
#[test]
fn a_primitive_without_joints_follows_its_node() {
    let mut file = triangle();
    file.json["skins"] = json!([{ "joints": [0] }]);
    file.json["nodes"] = json!([{ "mesh": 0, "skin": 0, "translation": [0, 7, 0] }]);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.scene.instances[0].transform.translation, [0.0, 7.0, 0.0]);
    assert_contains(&loaded.warnings.join("\n"), &["meshes[0].primitives[0]", "no joints"]);
}
