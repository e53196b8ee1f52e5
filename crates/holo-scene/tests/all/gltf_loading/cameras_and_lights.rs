//! Cameras and lights.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};

use holo_scene::{CameraProjection, LightKind, Scene};
use serde_json::{Value, json};

use super::support::{File, assert_contains};

fn with_light(light: Value, node: Value) -> File {
    let mut file = File::new();
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    file.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let mut node = node;
    node["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    file.push("nodes", node);
    file
}

fn with_camera(camera: Value, node: Value) -> File {
    let mut file = File::new();
    file.push("cameras", camera);
    let mut node = node;
    node["camera"] = json!(0);
    file.push("nodes", node);
    file
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15)
}

#[test]
fn perspective_cameras() {
    let lens =
        |perspective: Value| with_camera(json!({ "type": "perspective", "perspective": perspective }), json!({}));
    let only = |scene: Scene| scene.cameras[0].projection;
    let scene = lens(json!({ "yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5 })).load().unwrap().scene;
    assert_eq!(only(scene), CameraProjection::Perspective { vertical_angle_rad: 0.7, aspect_ratio: Some(1.5) });
    let scene = lens(json!({ "yfov": 0.7, "znear": 0.1, "zfar": 100 })).load().unwrap().scene;
    assert_eq!(only(scene), CameraProjection::Perspective { vertical_angle_rad: 0.7, aspect_ratio: None });
    for yfov in [json!(0), json!(-1), json!(3.2), json!("wide")] {
        assert_contains(&lens(json!({ "yfov": yfov })).error(), &["cameras[0].perspective.yfov"]);
    }
    assert_contains(&lens(json!({})).error(), &["cameras[0].perspective.yfov", "missing"]);
    assert_contains(&lens(json!({ "yfov": 1, "aspectRatio": 0 })).error(), &["aspectRatio"]);
    assert_contains(&with_camera(json!({ "type": "fisheye" }), json!({})).error(), &["cameras[0].type"]);
    assert_contains(
        &with_camera(json!({ "type": "perspective" }), json!({})).error(),
        &["cameras[0].perspective", "missing"],
    );
}

#[test]
fn orthographic_cameras() {
    let camera =
        json!({ "type": "orthographic", "orthographic": { "xmag": 2.0, "ymag": 1.5, "znear": 0, "zfar": 10 } });
    let scene = with_camera(camera, json!({})).load().unwrap().scene;
    assert_eq!(scene.cameras[0].projection, CameraProjection::Orthographic { half_width_m: 2.0, half_height_m: 1.5 });
    let camera =
        json!({ "type": "orthographic", "orthographic": { "xmag": 0.0, "ymag": 1.5, "znear": 0, "zfar": 10 } });
    assert_contains(&with_camera(camera, json!({})).error(), &["cameras[0].orthographic.xmag"]);
}

#[test]
fn camera_poses_lose_scale_shear_and_mirroring() {
    let camera = json!({ "type": "perspective", "name": "own", "perspective": { "yfov": 1.0, "znear": 0.1 } });
    // A quarter turn about y: the camera looks along -x.
    let turn = [0.0, SQRT_2 / 2.0, 0.0, SQRT_2 / 2.0];
    let file = with_camera(camera.clone(), json!({ "translation": [1, 2, 3], "rotation": turn, "scale": [2, 3, 4] }));
    let scene = file.load().unwrap().scene;
    let pose = scene.cameras[0].pose;
    assert!(
        near(pose.vector([0.0, 0.0, -1.0]), [-1.0, 0.0, 0.0]) && near(pose.vector([0.0, 1.0, 0.0]), [0.0, 1.0, 0.0])
    );
    assert_eq!(pose.translation, [1.0, 2.0, 3.0]);
    assert_eq!(scene.cameras[0].name, "own");
    // Mirrored left to right: the viewing direction is the same, and the image is not mirrored.
    let file = with_camera(camera.clone(), json!({ "name": "node", "rotation": turn, "scale": [-1, 1, 1] }));
    let scene = file.load().unwrap().scene;
    let pose = scene.cameras[0].pose;
    assert!(near(pose.vector([0.0, 0.0, -1.0]), [-1.0, 0.0, 0.0]) && pose.determinant() > 0.0);
    assert_eq!(scene.cameras[0].name, "node");
    // Sheared: the viewing direction is kept, up is made orthogonal to it.
    let sheared = json!({ "matrix": [1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1] });
    let pose = with_camera(camera.clone(), sheared).load().unwrap().scene.cameras[0].pose;
    assert!(near(pose.columns[1], [0.0, 1.0, 0.0]) && near(pose.columns[2], [0.0, 0.0, 1.0]));
    let loaded = with_camera(camera, json!({ "scale": [0, 0, 0] })).load().unwrap();
    assert!(loaded.scene.cameras.is_empty());
    assert_contains(&loaded.warnings.join("\n"), &["nodes[0]", "camera"]);
}

#[test]
fn cameras_come_in_node_order() {
    let mut file = File::new();
    for name in ["a", "b"] {
        file.push(
            "cameras",
            json!({ "type": "perspective", "name": name, "perspective": { "yfov": 1.0, "znear": 0.1 } }),
        );
    }
    file.json["nodes"] = json!([{ "camera": 1 }, { "children": [0], "camera": 0 }]);
    let loaded = file.load().unwrap();
    assert_eq!(loaded.summary.cameras, ["b", "a"]);
    assert_contains(&loaded.summary.to_string(), &["0 'b', 1 'a'"]);
}

#[test]
fn light_directions_follow_their_nodes() {
    let sun = json!({ "type": "directional", "color": [1.0, 0.5, 0.25], "intensity": 4.0, "name": "sun" });
    // A quarter turn about x: -z becomes ... y; scale must not change it.
    let turn = [SQRT_2 / 2.0, 0.0, 0.0, SQRT_2 / 2.0];
    let scene = with_light(sun, json!({ "rotation": turn, "scale": [5, 5, 5] })).load().unwrap().scene;
    assert_eq!((scene.lights[0].name.as_str(), scene.lights[0].intensity), ("sun", [4.0, 2.0, 1.0]));
    let LightKind::Directional { direction, .. } = scene.lights[0].kind else { panic!("{:?}", scene.lights[0]) };
    assert!(near(direction, [0.0, 1.0, 0.0]), "{direction:?}");

    let bulb = json!({ "type": "point", "range": 7.5 });
    let scene = with_light(bulb, json!({ "translation": [1, 2, 3], "name": "node" })).load().unwrap().scene;
    assert_eq!((scene.lights[0].name.as_str(), scene.lights[0].intensity), ("node", [1.0; 3]));
    assert_eq!(scene.lights[0].kind, LightKind::Point { position: [1.0, 2.0, 3.0], range: Some(7.5) });

    // Exporters write 0 for a range without an end.
    let endless = with_light(json!({ "type": "point", "range": 0 }), json!({})).load().unwrap().scene;
    assert_eq!(endless.lights[0].kind, LightKind::Point { position: [0.0; 3], range: None });

    let spot = json!({ "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.5 } });
    let scene = with_light(spot, json!({ "translation": [1, 2, 3], "scale": [-1, 1, 1] })).load().unwrap().scene;
    let expected = LightKind::Spot {
        position: [1.0, 2.0, 3.0],
        direction: [0.0, 0.0, -1.0],
        range: None,
        inner_angle_rad: 0.1,
        outer_angle_rad: 0.5,
    };
    assert_eq!(scene.lights[0].kind, expected);
    // Defaults, and a right angle rounded to f32.
    let scene = with_light(json!({ "type": "spot", "spot": {} }), json!({})).load().unwrap().scene;
    assert!(matches!(scene.lights[0].kind, LightKind::Spot { inner_angle_rad: 0.0, outer_angle_rad: FRAC_PI_4, .. }));
    let wide = json!({ "type": "spot", "spot": { "outerConeAngle": 1.570_796_370_506_286_6 } });
    let scene = with_light(wide, json!({})).load().unwrap().scene;
    assert!(matches!(scene.lights[0].kind, LightKind::Spot { outer_angle_rad: FRAC_PI_2, .. }));
}

#[test]
fn directional_lights_with_an_angular_diameter() {
    let angle = |light: Value| match with_light(light, json!({})).load().unwrap().scene.lights[0].kind {
        LightKind::Directional { angular_diameter_rad, .. } => angular_diameter_rad,
        other => panic!("{other:?}"),
    };
    let sun = |extras: Value| json!({ "type": "directional", "extras": extras });
    assert_eq!(angle(sun(json!({ "angular_diameter_rad": 0.0093, "other": "x" }))), 0.0093);
    // Extras may have any type.
    for extras in [json!({}), json!("x"), json!(null), json!([0.1])] {
        assert_eq!(angle(sun(extras)), 0.0);
    }
    let at = "extensions.KHR_lights_punctual.lights[0].extras.angular_diameter_rad";
    for wrong in [json!(-0.1), json!(3.15), json!("wide"), json!(null)] {
        assert_contains(&with_light(sun(json!({ "angular_diameter_rad": wrong })), json!({})).error(), &[at]);
    }
    // Other lights have no angular diameter.
    let bulb = json!({ "type": "point", "extras": { "angular_diameter_rad": 9 } });
    assert!(with_light(bulb, json!({})).load().is_ok());
}

#[test]
fn invalid_lights_are_errors() {
    let error = |light: Value| with_light(light, json!({})).error();
    assert_contains(&error(json!({ "type": "area" })), &["lights[0].type", "area"]);
    assert_contains(&error(json!({})), &["extensions.KHR_lights_punctual.lights[0].type", "missing"]);
    assert_contains(&error(json!({ "type": "point", "range": -1 })), &["lights[0].range"]);
    assert_contains(&error(json!({ "type": "point", "intensity": -1 })), &["lights[0]", "negative"]);
    assert_contains(
        &error(json!({ "type": "point", "intensity": 1e308, "color": [1e10, 1, 1] })),
        &["lights[0]", "finite"],
    );
    assert_contains(&error(json!({ "type": "point", "color": [1, 1] })), &["lights[0].color"]);
    for (inner, outer) in [(0.5, 0.4), (-0.1, 0.4), (0.0, 2.0), (0.0, 0.0)] {
        let spot = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
        assert_contains(&error(json!({ "type": "spot", "spot": spot })), &["lights[0].spot", "angles"]);
    }
    let mut file = with_light(json!({ "type": "point" }), json!({}));
    file.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = json!(1);
    assert_contains(&file.error(), &["nodes[0].extensions.KHR_lights_punctual.light"]);
    let squashed = with_light(json!({ "type": "directional" }), json!({ "scale": [1, 1, 0] })).load().unwrap();
    assert!(squashed.scene.lights.is_empty());
    assert_contains(&squashed.warnings.join("\n"), &["nodes[0]", "light"]);
}
