//! `--transforms`: cameras anywhere, in the files of NeRF and nerfstudio.

use crate::common;
use crate::common::Bench;
use holo_io::{Limits, read_pfm_gray};
use holo_scene::{Camera, CameraProjection, Instance, Light, LightKind, Material, Mesh, Scene, Transform};
use serde_json::{Value, json};

/// A plane y = x / 4 in the world of glTF, lit from above.
fn plane() -> Scene {
    let mesh = Mesh {
        positions: vec![[-8.0, -2.0, -8.0], [-8.0, -2.0, 8.0], [8.0, 2.0, 8.0], [8.0, 2.0, -8.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let kind = LightKind::Directional { direction: [0.0, -1.0, 0.0], angular_diameter_rad: 0.0 };
    let projection = CameraProjection::Perspective { vertical_angle_rad: 0.7, aspect_ratio: None };
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance { name: "plane".into(), mesh: 0, transform: Transform::IDENTITY }],
        materials: vec![Material::default()],
        lights: vec![Light { name: "sun".into(), intensity: [3.0; 3], kind }],
        cameras: vec![Camera { name: "c".into(), pose: Transform::from_translation([0.0, 0.0, 4.0]), projection }],
        ..Scene::default()
    }
}

/// Seventeen cameras on a sphere of 3 m around the origin, above the plane, that look at it; in a world with Z up. Two
/// have sizes and focal lengths of their own.
fn seventeen() -> Value {
    let frame = |k: usize| {
        let around = 2.4 * k as f64;
        let up = 0.75 + 0.2 * ((k % 5) as f64 / 4.0);
        let flat = (1.0 - up * up).sqrt();
        let eye = [3.0 * flat * around.cos(), 3.0 * flat * around.sin(), 3.0 * up];
        let Transform { columns: [x, y, z], translation } = Transform::look_at(eye, [0.1, 0.0, 0.2], [0.0, 0.0, 1.0]);
        let row = |i: usize| json!([x[i], y[i], z[i], translation[i]]);
        let mut frame = json!({ "file_path": format!("./train/r_{k}.png"),
            "transform_matrix": [row(0), row(1), row(2), [0, 0, 0, 1]] });
        if k % 8 == 3 {
            (frame["w"], frame["h"], frame["fl_x"]) = (json!(20), json!(32), json!(31.25));
        }
        frame
    };
    json!({ "w": 24, "h": 16, "camera_angle_x": 0.7, "frames": (0..17).map(frame).collect::<Vec<_>>() })
}

fn numbers(row: &Value) -> Vec<f64> {
    row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// The depth of every pixel of every camera leads, with the numbers of the file that is written, to the plane; and a point
/// of it back to the center of the pixel.
#[test]
fn seventeen_cameras_see_the_plane_where_it_is() {
    let bench = Bench::new();
    std::fs::write(bench.path("plane.glb"), holo_scene::gltf::to_glb(&plane()).unwrap()).unwrap();
    std::fs::write(bench.path("in.json"), seventeen().to_string()).unwrap();
    let line =
        "render plane.glb --transforms in.json --out o --layers depth,ray-length,color --spp 1 --integrator direct";
    let outcome = bench.run(&format!("{line} --json"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("17 cameras") && outcome.stdout.contains("\"cameras\":17"), "{outcome:?}");
    let written: Value = serde_json::from_slice(&std::fs::read(bench.path("o/transforms.json")).unwrap()).unwrap();
    let frames = written["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 17);
    for (k, frame) in frames.iter().enumerate() {
        let (w, h) = (frame["w"].as_u64().unwrap() as usize, frame["h"].as_u64().unwrap() as usize);
        assert_eq!((w, h), if k % 8 == 3 { (20, 32) } else { (24, 16) });
        let image = holo_io::read_png(bench.path(format!("o/images/r_{k}.png")), &Limits::default()).unwrap();
        assert_eq!((image.size().columns, image.size().rows), (w, h));
        let [focal, cx, cy] = ["fl_x", "cx", "cy"].map(|key| frame[key].as_f64().unwrap());
        let rows: Vec<Vec<f64>> = frame["transform_matrix"].as_array().unwrap().iter().map(numbers).collect();
        let depth = read_pfm_gray(bench.path(format!("o/depth/r_{k}.pfm")), &Limits::default()).unwrap();
        assert_eq!(depth.dim(), (h, w));
        for ((v, u), &depth_m) in depth.indexed_iter() {
            let local = [(u as f64 + 0.5 - cx) / focal, -(v as f64 + 0.5 - cy) / focal, -1.0];
            let world = |z: f64| [0, 1, 2].map(|i| rows[i][3] + z * (0..3).map(|j| rows[i][j] * local[j]).sum::<f64>());
            // The plane in the world of Blender: z = x / 4.
            let off = |p: [f64; 3]| p[2] - p[0] / 4.0;
            let (near, far) = (off(world(0.0)), off(world(1.0)));
            let exact = near / (near - far);
            assert!((f64::from(depth_m) / exact - 1.0).abs() < 1e-6, "camera {k}, pixel {v} {u}: {depth_m} {exact}");
            let point = world(exact);
            let from = [0, 1, 2].map(|i| point[i] - rows[i][3]);
            let seen = [0, 1, 2].map(|j| (0..3).map(|i| rows[i][j] * from[i]).sum::<f64>());
            let [column, row] = [cx - focal * seen[0] / seen[2], cy + focal * seen[1] / seen[2]];
            assert!((column - u as f64 - 0.5).abs() < 1e-9 && (row - v as f64 - 0.5).abs() < 1e-9);
        }
    }
    // What was written is what was read, and gives the same images.
    let again = bench.run(&line.replace("in.json", "o/transforms.json").replace("--out o", "--out p"));
    assert_eq!(again.code, Some(0), "{again:?}");
    for name in ["images/r_3.png", "depth/r_16.pfm", "transforms.json"] {
        assert!(
            std::fs::read(bench.path(format!("o/{name}"))).unwrap()
                == std::fs::read(bench.path(format!("p/{name}"))).unwrap(),
            "{name}"
        );
    }
    let outcome = bench.run("verify o");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn wrong_use_is_said() {
    let bench = Bench::new();
    let file = |change: &dyn Fn(&mut Value)| {
        let mut value = seventeen();
        change(&mut value);
        std::fs::write(bench.path("in.json"), value.to_string()).unwrap();
    };
    let fails = |more: &str, part: &str| {
        let outcome = bench.run(&format!("render tiny.glb --transforms in.json --out o {more}"));
        assert!(matches!(outcome.code, Some(1 | 2)) && outcome.stderr.contains(part), "no '{part}': {outcome:?}");
        assert!(!bench.path("o").exists());
    };
    fails("", "in.json");
    file(&|_| {});
    fails("--views 3 --lenses 9x9", "--lenses");
    fails("--views 3 --focal-mm 20", "--focal-mm");
    fails("--write el", "give --views for a light field at every pose");
    fails("--denoise views", "give --views for a light field at every pose");
    fails("--layers disparity", "disparity");
    file(&|value| value["frames"][2]["transform_matrix"][0][0] = json!(3));
    fails("", "r_2");
    file(&|value| {
        value.as_object_mut().unwrap().remove("w");
        value["fl_x"] = json!(30);
    });
    fails("", "--lenses=WIDTHxHEIGHT");
    // From the angle of view nothing follows without a size.
    file(&|value| drop(value.as_object_mut().unwrap().remove("w")));
    fails("", "--lenses=WIDTHxHEIGHT");
    file(&|value| value["k1"] = json!(0.1));
    fails("", "distortion");
}

/// A sensor has the pixels of an image of pinholes, and of all views of a light field; another size than the file's is refused.
#[test]
fn a_sensor_of_the_size_of_the_file_is_accepted() {
    let bench = Bench::new();
    std::fs::write(bench.path("plane.glb"), holo_scene::gltf::to_glb(&plane()).unwrap()).unwrap();
    let mut value = seventeen();
    value["frames"].as_array_mut().unwrap().truncate(2);
    std::fs::write(bench.path("in.json"), value.to_string()).unwrap();
    let line = "render plane.glb --transforms in.json --integrator depth --layers depth --quiet";
    for (more, sensor) in [("", "24x16"), ("--views 2", "48x32")] {
        let outcome = bench.run(&format!("{line} {more} --sensor {sensor} --out {sensor}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let outcome = bench.run(&format!("{line} {more} --sensor 60x40 --out other"));
        assert!(outcome.code == Some(2) && outcome.stderr.contains("24x16 pixels"), "{outcome:?}");
        assert!(outcome.stderr.contains("--sensor") && !bench.path("other").exists(), "{outcome:?}");
    }
}

/// What `--json` lists is what is there, where it is: also for one pose, whose folder has its name.
#[test]
fn reports_list_the_files_of_all_poses() {
    let bench = Bench::new();
    std::fs::write(bench.path("plane.glb"), holo_scene::gltf::to_glb(&plane()).unwrap()).unwrap();
    for count in [1, 2] {
        let mut value = seventeen();
        value["frames"].as_array_mut().unwrap().truncate(count);
        std::fs::write(bench.path("in.json"), value.to_string()).unwrap();
        let line =
            "render plane.glb --transforms in.json --views 2 --spp 1 --integrator direct --write el,depth --json";
        let outcome = bench.run(&format!("{line} --out {count}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let report: Value = serde_json::from_str(outcome.stdout.lines().last().unwrap()).unwrap();
        let there: Vec<String> =
            bench.list(&count.to_string()).into_iter().filter(|name| !name.ends_with('/')).collect();
        assert_eq!(common::names(&report["files"]), there);
        assert!(there.contains(&"r_0/scene_el.png".to_owned()) && there.contains(&"transforms.json".to_owned()));
        assert!(count > 1 || outcome.stderr.contains(" files to 1/r_0 ("), "{outcome:?}");
    }
}

/// Placed cameras are read again, and see what is in their middle.
#[test]
fn placed_cameras_look_at_their_target() {
    let bench = Bench::new();
    std::fs::write(bench.path("plane.glb"), holo_scene::gltf::to_glb(&plane()).unwrap()).unwrap();
    for (kind, count, cameras) in [("plane", "5x3", 15), ("cylinder", "6", 6), ("sphere", "9", 9)] {
        let line = format!(
            "array {kind} --count {count} --radius-m 2 --target-m 0,0,0 --size 21x15 --angle-deg 30 --spacing-m 0.1,0.2"
        );
        let outcome = bench.run(&format!("{line} --elevation-deg 30,80 --out {kind}.json"));
        assert!(outcome.code == Some(0) && outcome.stderr.contains(&format!("({cameras} cameras)")), "{outcome:?}");
        let outcome = bench.run(&format!(
            "render plane.glb --transforms {kind}.json --out {kind} --integrator depth --layers ray-length --quiet"
        ));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let files =
            bench.list(kind).into_iter().filter(|name| name.starts_with("ray_length/") && name.ends_with(".pfm"));
        assert_eq!(files.count(), cameras);
        if kind == "sphere" {
            for k in 0..cameras {
                let file = bench.path(format!("sphere/ray_length/camera_{k:04}.pfm"));
                let length = read_pfm_gray(file, &Limits::default()).unwrap()[[7, 10]];
                assert!((length - 2.0).abs() < 1e-5, "camera {k}: {length}");
            }
        }
    }
    for (line, part) in [
        ("array plane --count 0", "cameras"),
        ("array sphere --count 3x3", "one number"),
        ("array cylinder --count 3 --span-deg 400", "turn"),
        ("array plane --count 3 --angle-deg 180", "180"),
        ("array plane --count 3 --target-m 1,2", "X,Y,Z"),
    ] {
        let outcome = bench.run(line);
        assert!(outcome.code == Some(2) && outcome.stderr.contains(part), "{line}: {outcome:?}");
    }
}
