//! Animations: the scene at a time.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

use holo_scene::gltf::{LoadOptions, Loaded, load_slice_with};
use holo_scene::{CameraProjection, Error, LightKind, Scene};
use serde_json::{Value, json};

use super::support::{File, assert_contains, triangle};

fn options(time_s: f64) -> LoadOptions {
    let mut options = LoadOptions::default();
    options.time_s = Some(time_s);
    options
}

impl File {
    fn loaded_at(&self, time_s: f64) -> Result<Loaded, Error> {
        load_slice_with(&self.glb(), &options(time_s))
    }

    fn at(&self, time_s: f64) -> Scene {
        let loaded = self.loaded_at(time_s).unwrap();
        assert_eq!(loaded.warnings, [""; 0]);
        loaded.scene
    }

    fn error_at(&self, time_s: f64) -> String {
        self.loaded_at(time_s).unwrap_err().to_string()
    }

    /// Adds an animation of one channel; returns its index.
    fn animate(&mut self, target: Value, input: usize, output: usize, interpolation: &str) -> usize {
        self.push(
            "animations",
            json!({ "channels": [{ "sampler": 0, "target": target }],
                "samplers": [{ "input": input, "output": output, "interpolation": interpolation }] }),
        )
    }

    /// A property anywhere in the file, linear between 0 s and 2 s.
    fn animate_pointer<const N: usize>(&mut self, pointer: &str, keys: [[f32; N]; 2]) {
        let (input, output) = (self.floats(&[[0.0_f32], [2.0]]), self.floats(&keys));
        let target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } });
        self.animate(target, input, output, "LINEAR");
    }
}

fn of_node(node: usize, path: &str) -> Value {
    json!({ "node": node, "path": path })
}

#[track_caller]
fn assert_near<const N: usize>(is: [f64; N], expected: [f64; N]) {
    assert!(is.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-7), "{is:?} instead of {expected:?}");
}

/// Mesh, camera and light below a node that moves.
#[test]
fn whatever_hangs_on_a_node_moves_with_it() {
    let mut file = triangle();
    file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }));
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    file.json["nodes"] = json!([
        { "children": [1, 2], "scale": [2, 2, 2] },
        { "mesh": 0, "translation": [0, 1, 0] },
        { "camera": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
    ]);
    let (times, places) = (file.floats(&[[1.0_f32], [3.0]]), file.floats(&[[0.0_f32, 0.0, 0.0], [4.0, 0.0, -8.0]]));
    file.animate(of_node(0, "translation"), times, places, "LINEAR");
    for (time_s, [x, y, z]) in
        [(0.0, [0.0; 3]), (1.0, [0.0; 3]), (1.5, [1.0, 0.0, -2.0]), (3.0, [4.0, 0.0, -8.0]), (9.0, [4.0, 0.0, -8.0])]
    {
        let scene = file.at(time_s);
        assert_eq!(scene.instances[0].transform.translation, [x, y + 2.0, z], "{time_s} s");
        assert_eq!(scene.cameras[0].pose.translation, [x, y, z]);
        assert!(matches!(scene.lights[0].kind, LightKind::Point { position, .. } if position == [x, y, z]));
    }
    // Without a time nothing moves.
    let loaded = file.load().unwrap();
    assert_eq!(loaded.scene.instances[0].transform.translation, [0.0, 2.0, 0.0]);
    assert_contains(&loaded.warnings[0], &["animations are ignored"]);
}

#[test]
fn rotations_of_normalized_integers() {
    let mut file = triangle();
    let times = file.floats(&[[0.0_f32], [1.0]]);
    let half = (FRAC_1_SQRT_2 * 32767.0).round() as i16;
    // A quarter turn about z, with the sign that would go the long way.
    let bytes: Vec<u8> = [0, 0, 0, 32767, 0, 0, -half, -half].iter().flat_map(|x: &i16| x.to_le_bytes()).collect();
    let turns = file.accessor(&bytes, 5122, "VEC4", 2);
    file.json["accessors"][turns]["normalized"] = json!(true);
    file.animate(of_node(0, "rotation"), times, turns, "LINEAR");
    let x_axis = |time_s: f64| file.at(time_s).instances[0].transform.columns[0];
    for time_s in [0.0, 0.25, 0.5, 1.0_f64] {
        let (sine, cosine) = (2.0 * FRAC_PI_4 * time_s).sin_cos();
        let is = x_axis(time_s);
        assert!((is[0] - cosine).abs() < 1e-4 && (is[1] - sine).abs() < 1e-4, "{time_s}: {is:?}");
        assert!((is.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12, "a rotation");
    }
}

#[test]
fn weights_step_and_splines() {
    let mut file = triangle();
    let targets = [[[0.0_f32, 0.0, 2.0]; 3], [[4.0, 0.0, 0.0]; 3]].map(|target| file.floats(&target));
    file.json["meshes"][0]["primitives"][0]["targets"] = json!(targets.map(|target| json!({ "POSITION": target })));
    let (times, weights) = (file.floats(&[[0.0_f32], [1.0]]), file.floats(&[[0.0_f32], [1.0], [0.5], [0.0]]));
    let animation = file.animate(of_node(0, "weights"), times, weights, "LINEAR");
    let first = |file: &File, time_s: f64| file.at(time_s).meshes[0].positions[0].map(f64::from);
    assert_near(first(&file, 0.0), [4.0, 0.0, 0.0]);
    assert_near(first(&file, 0.5), [2.0, 0.0, 0.5]);
    file.json["animations"][animation]["samplers"][0]["interpolation"] = json!("STEP");
    assert_near(first(&file, 0.99), [4.0, 0.0, 0.0]);
    assert_near(first(&file, 1.0), [0.0, 0.0, 1.0]);
    // In-tangents, values and out-tangents of both weights, key after key: w = t^2 and 1.
    let spline = [[0.0, 0.0], [0.0, 1.0], [0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
    let output = file.floats(&spline.as_flattened().iter().map(|&x| [x as f32]).collect::<Vec<_>>());
    file.json["animations"][animation]["samplers"][0] =
        json!({ "input": times, "output": output, "interpolation": "CUBICSPLINE" });
    assert_near(first(&file, 0.5), [4.0, 0.0, 0.5]);
}

#[test]
fn other_properties_by_pointer() {
    let mut file = triangle();
    file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }));
    file.push("materials", json!({ "name": "without factors" }));
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_animation_pointer"]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    file.json["nodes"] = json!([
        { "mesh": 0 }, { "camera": 0 }, { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "mesh": 0, "extensions": { "KHR_node_visibility": { "visible": true } } },
    ]);
    file.animate_pointer("/cameras/0/perspective/yfov", [[0.5], [0.7]]);
    file.animate_pointer("/extensions/KHR_lights_punctual/lights/0/color", [[1.0, 1.0, 1.0], [0.0, 0.5, 1.0]]);
    file.animate_pointer("/extensions/KHR_lights_punctual/lights/0/intensity", [[10.0], [30.0]]);
    file.animate_pointer("/materials/0/pbrMetallicRoughness/baseColorFactor", [[1.0; 4], [0.0, 0.0, 1.0, 1.0]]);
    file.animate_pointer("/nodes/0/translation", [[0.0; 3], [2.0, 0.0, 0.0]]);
    file.animate_pointer("/nodes/3/extensions/KHR_node_visibility/visible", [[1.0], [0.0]]);
    let scene = file.at(1.0);
    let CameraProjection::Perspective { vertical_angle_rad, .. } = scene.cameras[0].projection else { panic!() };
    assert!((vertical_angle_rad - 0.6).abs() < 1e-7);
    assert_near(scene.lights[0].intensity, [10.0, 15.0, 20.0]);
    assert_eq!(scene.materials[0].base_color, [0.5, 0.5, 1.0, 1.0]);
    assert_eq!(scene.instances[0].transform.translation, [1.0, 0.0, 0.0]);
    assert_eq!(scene.instances.len(), 1, "hidden at half time");
    assert_eq!(file.at(0.5).instances.len(), 2);
    // Nothing there: said, and nothing else happens.
    file.animate_pointer("/materials/7/alphaCutoff", [[0.0], [1.0]]);
    assert_contains(&file.loaded_at(0.0).unwrap().warnings[0], &["animations[6]", "does not have"]);
    for wrong in ["materials/0", "", "/a/a/a/a/a/a/a/a/a/a/a/a/a/a/a/a/a"] {
        file.json["animations"][6]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
            json!(wrong);
        assert_contains(&file.error_at(0.0), &["animations[6]", "no pointer"]);
    }
}

/// All are played, or one; where two change the same property, the first.
#[test]
fn several_animations() {
    let mut file = triangle();
    let times = file.floats(&[[0.0_f32], [1.0]]);
    let mut outputs = [[1.0_f32, 0.0, 0.0], [0.0, 5.0, 0.0]].map(|end| file.floats(&[[0.0; 3], end])).into_iter();
    let mut place = |file: &mut File, name: &str| {
        let animation = file.animate(of_node(0, "translation"), times, outputs.next().unwrap(), "LINEAR");
        file.json["animations"][animation]["name"] = json!(name);
    };
    place(&mut file, "walk");
    place(&mut file, "0");
    let size = file.floats(&[[1.0_f32; 3], [3.0; 3]]);
    file.animate(of_node(0, "scale"), times, size, "LINEAR");
    let loaded = file.loaded_at(1.0).unwrap();
    assert_contains(&loaded.warnings[0], &["animations[1].channels[0].target", "first is played"]);
    let transform = loaded.scene.instances[0].transform;
    assert_eq!((transform.translation, transform.columns[0]), ([1.0, 0.0, 0.0], [3.0, 0.0, 0.0]));
    let played = |name: &str| {
        let mut options = options(1.0);
        options.animation = Some(name.into());
        load_slice_with(&file.glb(), &options)
    };
    for (name, translation) in [("walk", [1.0, 0.0, 0.0]), ("0", [0.0, 5.0, 0.0]), ("1", [0.0, 5.0, 0.0])] {
        let loaded = played(name).unwrap();
        assert_eq!((loaded.scene.instances[0].transform.translation, loaded.warnings), (translation, vec![]), "{name}");
    }
    assert_contains(&played("run").unwrap_err().to_string(), &["no animation 'run'", "'walk'"]);
    assert!(played("3").is_err());
}

#[test]
fn the_summary_lists_animations() {
    let mut file = triangle();
    assert!(!file.load().unwrap().summary.to_string().contains("animations"));
    let (times, output) = (file.floats(&[[0.0_f32], [1.5]]), file.floats(&[[0.0_f32; 3]; 2]));
    file.json["accessors"][times]["max"] = json!([1.5]);
    let animation = file.animate(of_node(0, "scale"), times, output, "LINEAR");
    file.json["animations"][animation]["name"] = json!("grow");
    let summary = file.load().unwrap().summary;
    assert_eq!((summary.animations[0].name.as_str(), summary.animations[0].seconds), ("grow", 1.5));
    assert_contains(&summary.to_string(), &["animations:          0 'grow' (1.5 s)"]);
}

#[test]
fn files_without_animations() {
    let file = triangle();
    let loaded = file.loaded_at(3.0).unwrap();
    assert_contains(&loaded.warnings[0], &["no animations"]);
    assert_eq!(loaded.scene, file.load().unwrap().scene);
}

#[test]
fn invalid_animations_are_errors() {
    let animated = || {
        let mut file = triangle();
        let (times, places) = (file.floats(&[[0.0_f32], [1.0]]), file.floats(&[[0.0_f32; 3]; 2]));
        file.animate(of_node(0, "translation"), times, places, "LINEAR");
        (file, times, places)
    };
    let (file, ..) = animated();
    for time_s in [f64::NAN, f64::INFINITY] {
        assert_contains(&file.error_at(time_s), &["time", "finite"]);
    }
    let wrong = |change: &dyn Fn(&mut File, usize, usize)| {
        let (mut file, times, places) = animated();
        change(&mut file, times, places);
        file.error_at(0.5)
    };
    let sampler = |key: &'static str, value: Value| {
        wrong(&move |file, _, _| file.json["animations"][0]["samplers"][0][key] = value.clone())
    };
    let target = |key: &'static str, value: Value| {
        wrong(&move |file, _, _| file.json["animations"][0]["channels"][0]["target"][key] = value.clone())
    };
    assert_contains(&sampler("interpolation", json!("BEZIER")), &["interpolation", "BEZIER"]);
    assert_contains(&sampler("interpolation", json!("CUBICSPLINE")), &["output", "2 values for 2 times"]);
    assert_contains(&sampler("input", json!(99)), &["samplers[0].input", "99"]);
    assert_contains(&target("path", json!("color")), &["target.path", "color"]);
    assert_contains(&target("path", json!("rotation")), &["accessors", "shape"]);
    assert_contains(&target("path", json!("pointer")), &["KHR_animation_pointer", "missing"]);
    assert_contains(&target("node", json!(5)), &["target.node", "5"]);
    let count = wrong(&|file, times, _| file.json["accessors"][times]["count"] = json!(1));
    assert_contains(&count, &["output", "2 values for 1 times"]);
    let backwards = wrong(&|file, _, _| {
        let times = file.floats(&[[1.0_f32], [1.0]]);
        file.json["animations"][0]["samplers"][0]["input"] = json!(times);
    });
    assert_contains(&backwards, &["time 1", "does not increase"]);
    let nan = wrong(&|file, _, _| {
        let places = file.floats(&[[0.0_f32; 3], [0.0, f32::NAN, 0.0]]);
        file.json["animations"][0]["samplers"][0]["output"] = json!(places);
    });
    assert_contains(&nan, &["component 4", "NaN"]);
    // Without data an accessor is zeros, of any number.
    let (mut file, ..) = animated();
    let zeros = file.push("accessors", json!({ "componentType": 5126, "count": 300_000_000, "type": "VEC3" }));
    file.json["animations"][0]["samplers"][0]["output"] = json!(zeros);
    file.json["animations"][0]["channels"][0]["target"]["path"] = json!("translation");
    assert_contains(&file.error_at(0.5), &["output", "values for 2 times"]);
    let zeros = file.push("accessors", json!({ "componentType": 5126, "count": 300_000_000, "type": "SCALAR" }));
    file.json["animations"][0]["samplers"][0]["output"] = json!(zeros);
    file.json["animations"][0]["channels"][0]["target"]["path"] = json!("weights");
    assert_contains(&file.error_at(0.5), &["exceed the limit"]);
    // A channel without a node is to be ignored.
    let (mut file, ..) = animated();
    file.json["animations"][0]["channels"][0]["target"] = json!({ "path": "translation" });
    assert_eq!(file.loaded_at(0.5).unwrap().warnings, [""; 0]);
}
