//! Nodes: composition in f64, and invalid hierarchies.

use serde_json::json;

use super::support::{File, assert_contains, triangle};
use holo_scene::Transform;

/// The reference implementation: the product of 4 x 4 matrices, row-major.
type Matrix = [[f64; 4]; 4];

fn times(a: Matrix, b: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn translation([x, y, z]: [f64; 3]) -> Matrix {
    [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]
}

fn scale([x, y, z]: [f64; 3]) -> Matrix {
    [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0], [0.0, 0.0, 0.0, 1.0]]
}

/// Rotation about an axis by Rodrigues' formula, and the same rotation as a quaternion.
fn rotation(axis: [f64; 3], angle: f64) -> (Matrix, [f64; 4]) {
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = axis.map(|a| a / length);
    let (s, c) = angle.sin_cos();
    let d = 1.0 - c;
    let matrix = [
        [c + x * x * d, x * y * d - z * s, x * z * d + y * s, 0.0],
        [y * x * d + z * s, c + y * y * d, y * z * d - x * s, 0.0],
        [z * x * d - y * s, z * y * d + x * s, c + z * z * d, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let (s, c) = (angle / 2.0).sin_cos();
    (matrix, [x * s, y * s, z * s, c])
}

#[track_caller]
fn assert_close(transform: &Transform, expected: Matrix, tolerance: f64) {
    for (i, row) in expected.iter().take(3).enumerate() {
        for (j, expected) in row.iter().enumerate() {
            let is = if j < 3 { transform.columns[j][i] } else { transform.translation[i] };
            let close = (is - expected).abs() <= tolerance * expected.abs().max(1.0);
            assert!(close, "row {i} column {j}: {is} instead of {expected}");
        }
    }
}

#[test]
fn hierarchies_compose_in_f64() {
    let (turn, quaternion) = rotation([1.0, 2.0, -0.5], 0.7);
    let (tilt, tilted) = rotation([0.0, 0.3, 1.0], -2.1);
    let mut file = triangle();
    // Far away: in f32 the millimeters would be lost. Mirrored and non-uniform scale below it, then a matrix.
    let matrix = times(translation([0.001, 0.002, 0.003]), times(tilt, scale([1.0, 1.0, -3.0])));
    let columns: Vec<f64> = (0..16).map(|k| matrix[k % 4][k / 4]).collect();
    // The quaternion is three times too long: it must be normalized.
    let longer = quaternion.map(|q| 3.0 * q);
    file.json["nodes"] = json!([
        { "mesh": 0, "matrix": columns },
        { "children": [2], "translation": [1e6, -2e6, 3e6], "rotation": longer },
        { "children": [0, 3], "scale": [-2.0, 0.5, 7.0], "translation": [0.1, 0.2, 0.3] },
        { "mesh": 0, "rotation": tilted, "scale": [1e-3, 1e-3, 1e-3] },
    ]);
    file.json["scenes"] = json!([{ "nodes": [1] }]);
    file.json["scene"] = json!(0);
    let scene = file.load().unwrap().scene;
    let outer = times(translation([1e6, -2e6, 3e6]), turn);
    let middle = times(outer, times(translation([0.1, 0.2, 0.3]), scale([-2.0, 0.5, 7.0])));
    assert_eq!(scene.instances.len(), 2);
    // Instances are in the order of the nodes in the file, not of the traversal.
    assert_close(&scene.instances[0].transform, times(middle, matrix), 1e-14);
    assert_close(&scene.instances[1].transform, times(middle, times(tilt, scale([1e-3; 3]))), 1e-14);
    assert!(scene.instances[0].transform.determinant() > 0.0, "mirrored twice");
    assert!(scene.instances[1].transform.determinant() < 0.0, "mirrored once");
    // Both refer to the one mesh.
    assert_eq!(scene.meshes.len(), 1);
}

#[test]
fn a_tiny_baseline_survives_far_from_the_origin() {
    let mut file = triangle();
    file.json["nodes"] = json!([{ "mesh": 0, "translation": [1_000_000.000_01, 0.0, 0.0] }]);
    assert_eq!(file.load().unwrap().scene.instances[0].transform.translation[0], 1_000_000.000_01);
}

#[test]
fn deep_chains_do_not_overflow_the_stack() {
    let depth = 100_000;
    let mut file = triangle();
    let mut nodes: Vec<_> =
        (0..depth).map(|k| json!({ "children": [k + 1], "translation": [1.0, 0.0, 0.0] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    file.json["nodes"] = nodes.into();
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    let scene = file.load().unwrap().scene;
    assert_eq!(scene.instances[0].transform.translation, [f64::from(depth), 0.0, 0.0]);
}

#[test]
fn invalid_hierarchies_are_errors() {
    let with_nodes = |nodes: serde_json::Value| {
        let mut file = triangle();
        file.json["nodes"] = nodes;
        file
    };
    let error = |nodes| with_nodes(nodes).error();
    assert_contains(&error(json!([{ "children": [0] }])), &["nodes[0]", "cycle"]);
    assert_contains(
        &error(json!([{ "children": [1] }, { "children": [2] }, { "children": [0] }])),
        &["nodes[", "cycle"],
    );
    assert_contains(&error(json!([{}, { "children": [2] }, { "children": [1] }])), &["cycle"]);
    assert_contains(
        &error(json!([{ "children": [2] }, { "children": [2] }, {}])),
        &["nodes[2]", "nodes[0]", "nodes[1]", "parent"],
    );
    assert_contains(&error(json!([{ "children": [1, 1] }, {}])), &["nodes[1]", "parent"]);
    assert_contains(&error(json!([{ "children": [7] }])), &["nodes[0].children[0]", "nodes[7]"]);
    assert_contains(&error(json!([{ "children": [-1] }])), &["nodes[0].children[0]"]);
    assert_contains(&error(json!([{ "children": {} }])), &["nodes[0].children", "array"]);
    assert_contains(&error(json!([{ "mesh": 3 }])), &["nodes[0].mesh", "meshes[3]"]);
    assert_contains(&error(json!([{ "rotation": [0, 0, 1] }])), &["nodes[0].rotation", "3 numbers instead of 4"]);
    assert_contains(&error(json!([{ "scale": [1, "x", 1] }])), &["nodes[0].scale[1]", "number"]);
    assert_contains(&error(json!([{ "matrix": vec![1.0; 16] }])), &["nodes[0].matrix", "last row"]);
    assert_contains(
        &error(json!([{ "translation": [1e200, 0, 0], "scale": [1e200, 1, 1], "children": [1] },
        { "scale": [1e200, 1, 1] }])),
        &["nodes[1]", "overflow"],
    );
    assert_contains(&error(json!([3])), &["nodes[0]", "object"]);
    let mut file = with_nodes(json!([{ "children": [1] }, {}]));
    file.json["scenes"] = json!([{}]);
    file.json["scene"] = json!(1);
    assert_contains(&file.error(), &["scene", "scenes[1]"]);
}

#[test]
fn huge_and_tiny_quaternions_are_normalized() {
    for factor in [1e200, 1e-200] {
        let mut file = triangle();
        file.json["nodes"] = json!([{ "mesh": 0, "rotation": [0.0, 0.0, factor, factor] }]);
        let transform = file.load().unwrap().scene.instances[0].transform;
        assert_close(&transform, rotation([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2).0, 1e-15);
    }
}

#[test]
fn the_default_scene_is_loaded() {
    let mut file = triangle();
    file.json["nodes"] = json!([{ "mesh": 0, "name": "a" }, { "mesh": 0, "name": "b" }]);
    let names = |file: &File| -> Vec<String> {
        file.load().unwrap().scene.instances.into_iter().map(|instance| instance.name).collect()
    };
    assert_eq!(names(&file), ["a", "b"], "without scenes all roots are shown");
    file.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
    assert_eq!(names(&file), ["a"]);
    file.json["scene"] = json!(1);
    assert_eq!(names(&file), ["b"]);
    assert_contains(&file.load().unwrap().warnings.join("\n"), &["scenes[1]", "left out"]);
    file.json["scenes"] = json!([{}]);
    file.json["scene"] = json!(0);
    assert!(names(&file).is_empty());
}

#[test]
fn a_matrix_overrides_trs_with_a_warning() {
    let mut file = triangle();
    file.json["nodes"] =
        json!([{ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1], "translation": [1, 1, 1] }]);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.scene.instances[0].transform.translation, [5.0, 0.0, 0.0]);
    assert_contains(&loaded.warnings.join("\n"), &["nodes[0]", "matrix"]);
}

/// UniGLTF writes such files: the scene lists a node that is the child of one outside of the scene.
#[test]
fn a_root_that_is_a_child_is_drawn_once() {
    let mut file = triangle();
    file.json["nodes"] = json!([
        { "mesh": 0, "children": [1], "translation": [0, 5, 0], "name": "outside" },
        { "mesh": 0, "translation": [1, 0, 0], "children": [2] },
        { "mesh": 0, "translation": [0, 0, 1] },
    ]);
    let places = |file: &File| {
        let loaded = file.load().unwrap();
        let instances = loaded.scene.instances.iter().map(|i| (i.name.clone(), i.transform.translation));
        (instances.collect::<Vec<_>>(), loaded.warnings.join("\n"))
    };
    // The parent is not drawn, but its transform counts, as in Blender.
    file.json["scenes"] = json!([{ "nodes": [1] }]);
    let (instances, warnings) = places(&file);
    assert_eq!(instances, [(String::new(), [1.0, 5.0, 0.0]), (String::new(), [1.0, 5.0, 1.0])]);
    assert_contains(&warnings, &["nodes[1]", "root of the scene", "drawn once"]);
    // Root and descendant of another root.
    file.json["scenes"] = json!([{ "nodes": [0, 2, 1] }]);
    let (instances, _) = places(&file);
    assert_eq!(
        instances.iter().map(|(_, p)| *p).collect::<Vec<_>>(),
        [[0.0, 5.0, 0.0], [1.0, 5.0, 0.0], [1.0, 5.0, 1.0]]
    );
    // A parent that changes nothing needs no warning.
    file.json["nodes"][0]["translation"] = json!([0, 0, 0]);
    file.json["scenes"] = json!([{ "nodes": [1] }]);
    let (instances, warnings) = places(&file);
    assert_eq!((instances[0].1, warnings.as_str()), ([1.0, 0.0, 0.0], ""));
    file.json["scenes"] = json!([{ "nodes": [1, 1] }]);
    let (instances, warnings) = places(&file);
    assert_eq!(instances.len(), 2);
    assert_contains(&warnings, &["scenes[0]", "twice"]);
}

#[test]
fn hidden_nodes_are_not_drawn() {
    let mut file = triangle();
    let hidden = |visible: bool| json!({ "KHR_node_visibility": { "visible": visible } });
    file.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1 } }]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    file.json["nodes"] = json!([
        { "mesh": 0, "name": "shown", "extensions": hidden(true) },
        { "mesh": 0, "extensions": hidden(false), "children": [2, 3, 4] },
        // Below a hidden node nothing is visible.
        { "mesh": 0, "extensions": hidden(true) },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "camera": 0 },
    ]);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.warnings, [""; 0]);
    let scene = loaded.scene;
    assert_eq!(scene.instances.iter().map(|i| i.name.as_str()).collect::<Vec<_>>(), ["shown"]);
    // Cameras are not affected.
    assert_eq!((scene.lights.len(), scene.cameras.len()), (0, 1));
    file.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(1);
    assert_contains(&file.error(), &["nodes[0].extensions.KHR_node_visibility.visible"]);
}

#[test]
fn a_rotation_of_length_zero_is_none() {
    let mut file = triangle();
    file.json["nodes"] = json!([{ "mesh": 0, "rotation": [0, 0, 0, 0], "translation": [1, 2, 3], "scale": [2, 3, 4] }]);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.scene.instances[0].transform.point([1.0, 1.0, 1.0]), [3.0, 5.0, 7.0]);
    assert_contains(&loaded.warnings.join("\n"), &["nodes[0]", "rotation of length zero"]);
}
