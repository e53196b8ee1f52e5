//! `--transforms`: cameras anywhere, in the files of NeRF and nerfstudio.

use crate::common;
use crate::common::{Bench, ok};
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

pub fn numbers(row: &Value) -> Vec<f64> {
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

/// Squares before a wall.
pub fn boxes() -> Scene {
    let mut scene = plane();
    scene.meshes[0].positions = vec![[-8.0, -8.0, -0.6], [8.0, -8.0, -0.6], [8.0, 8.0, -0.6], [-8.0, 8.0, -0.6]];
    let half = 0.08_f32;
    let mut mesh = Mesh::default();
    for (k, [x, y]) in [[-0.5, -0.2], [0.1, 0.3], [0.45, -0.3], [-0.2, 0.15]].into_iter().enumerate() {
        let z = 0.4 + 0.2 * k as f32;
        let first = mesh.positions.len() as u32;
        for corner in [[-half, -half], [half, -half], [half, half], [-half, half]] {
            mesh.positions.push([x + corner[0], y + corner[1], z]);
        }
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    scene.meshes.push(mesh);
    scene.instances.push(Instance { name: "boxes".into(), mesh: 1, transform: Transform::IDENTITY });
    scene.lights[0].kind = LightKind::Directional { direction: [0.0, -0.6, -0.8], angular_diameter_rad: 0.0 };
    scene
}

pub fn image(bench: &Bench, name: &str) -> ndarray::Array3<f64> {
    holo_io::read_linear(bench.path(name), &Limits::default()).unwrap().mapv(f64::from)
}

/// The root of the mean of the squared differences where both are numbers, without `border` pixels.
pub fn deviation(a: &ndarray::Array3<f64>, b: &ndarray::Array3<f64>, border: usize) -> f64 {
    assert_eq!(a.dim(), b.dim());
    let (rows, columns, _) = a.dim();
    let inside = |(v, u, _): (usize, usize, usize)| {
        (border..rows - border).contains(&v) && (border..columns - border).contains(&u)
    };
    let errors: Vec<f64> = a.indexed_iter().filter(|(at, _)| inside(*at)).map(|(at, x)| (x - b[at]).powi(2)).collect();
    (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
}

/// Cameras that stand as the views of a rig do give its refocused image, straight and tilted: another way through other files.
#[test]
fn an_array_that_stands_as_a_rig_refocuses_as_it_does() {
    let bench = Bench::new();
    std::fs::write(bench.path("boxes.glb"), holo_scene::gltf::to_glb(&boxes()).unwrap()).unwrap();
    ok(bench.run("render boxes.glb --out rig --views 5 --lenses 48x32 --baseline-m 0.02 --focus-m inf --spp 64 --exposure 0 --write el --bit-depth 16"));
    // The focal length of the scene's camera, which the angle across 32 rows defines.
    let focal = 16.0 / 0.35_f64.tan();
    let frame = |k: usize| {
        let (row, column) = ((k / 5) as f64 - 2.0, (k % 5) as f64 - 2.0);
        json!({ "file_path": format!("images/{k}.png"), "fl_x": focal, "w": 48, "h": 32, "transform_matrix":
            [[1, 0, 0, 0.02 * column], [0, 1, 0, -0.02 * row], [0, 0, 1, 4], [0, 0, 0, 1]] })
    };
    let file = json!({ "frames": (0..25).map(frame).collect::<Vec<_>>() });
    std::fs::write(bench.path("in.json"), file.to_string()).unwrap();
    ok(bench.run("render boxes.glb --out array --transforms in.json --transforms-up y --spp 64 --exposure 0 --bit-depth 16 --layers depth"));
    for (k, more) in ["--distance-m 3.4", "--distance-m 4 --tilt-deg 30,-40", "--distance-m 3 --aperture disc:2.1"]
        .iter()
        .enumerate()
    {
        ok(bench.run(&format!("refocus rig {more} --out rig_{k}.pfm")));
        let more = more.replace("disc:2.1", "disc:0.042");
        ok(bench.run(&format!("refocus array {more} --transforms-up y --out array_{k}.pfm")));
        let (rig, array) = (image(&bench, &format!("rig_{k}.pfm")), image(&bench, &format!("array_{k}.pfm")));
        // Samples differ: two renders of 64 samples, 25 or 5 views on average.
        let error = deviation(&rig, &array, 4);
        assert!(error < 6e-3, "{more}: {error}");
        let blurred = deviation(&rig, &image(&bench, "array/images/12.png"), 4);
        assert!(k == 2 || blurred > 2.0 * error, "{more}: {blurred} {error}");
    }
    // A PNG has the bits of the images.
    ok(bench.run("refocus array --distance-m 3 --transforms-up y --out deep.png"));
    let info = holo_io::read_png_info(bench.path("deep.png")).unwrap();
    assert_eq!((info.bits, info.channels), (16, 3));
    // By the depth of the view itself everything is sharp; on a plane near the cameras nothing is.
    ok(bench.run(
        "refocus array --all-in-focus array/depth/12.pfm --aperture disc:0.041 --transforms-up y --out sharp.pfm",
    ));
    let sharp = deviation(&image(&bench, "sharp.pfm"), &image(&bench, "array/images/12.png"), 4);
    ok(bench.run("refocus array --distance-m 2 --aperture disc:0.041 --transforms-up y --out near.pfm"));
    let near = deviation(&image(&bench, "near.pfm"), &image(&bench, "array/images/12.png"), 4);
    // Some cameras see what lies behind an edge, and blur it.
    assert!(1.5 * sharp < near, "{sharp} {near}");
}

/// A view between cameras on a sphere is nearer to the image that is rendered there than that of the nearest camera, by far; Python
/// makes the same (`test_light_field.py`).
#[test]
fn a_view_between_the_cameras_is_that_of_the_scene() {
    let bench = Bench::new();
    std::fs::write(bench.path("boxes.glb"), holo_scene::gltf::to_glb(&boxes()).unwrap()).unwrap();
    ok(bench.run("array sphere --count 40 --radius-m 3 --target 0,0,0.5 --elevation-deg 40,80 --size 60x40 --fov-deg 50 --out in.json"));
    ok(bench.run("render boxes.glb --out array --transforms in.json --spp 64 --exposure 0 --layers depth"));
    let (eye, target) = ([0.6, 2.2, 2.2], [0.0, 0.0, 0.5]);
    let Transform { columns: [x, y, z], translation } = Transform::look_at(eye, target, [0.0, 1.0, 0.0]);
    let row = |i: usize| json!([x[i], y[i], z[i], translation[i]]);
    let focal = 30.0 / 25.0_f64.to_radians().tan();
    let file = json!({ "fl_x": focal, "w": 60, "h": 40, "frames": [
        { "file_path": "images/truth.png", "transform_matrix": [row(0), row(1), row(2), [0, 0, 0, 1]] } ] });
    std::fs::write(bench.path("truth.json"), file.to_string()).unwrap();
    ok(bench.run("render boxes.glb --out truth --transforms truth.json --transforms-up y --spp 64 --exposure 0"));
    ok(bench.run("synthesize array --eye 0.6,2.2,2.2 --target 0,0,0.5 --out made.png"));
    ok(bench.run("refocus array --eye 0.6,2.2,2.2 --target 0,0,0.5 --distance-m 3 --out blended.png"));
    let truth = image(&bench, "truth/images/truth.png");
    let (made, blended) =
        (deviation(&image(&bench, "made.png"), &truth, 2), deviation(&image(&bench, "blended.png"), &truth, 2));
    assert!(made < 0.03 && made * 2.5 < blended, "{made} {blended}");
    assert!(bench.path("made_holes.png").exists());
}

#[test]
fn arrays_refuse_what_they_cannot_do() {
    let bench = Bench::new();
    ok(bench.run("array plane --count 3 --size 12x8 --out in.json"));
    ok(bench.run("render tiny.glb --out array --transforms in.json --spp 1 --layers shading-normal"));
    bench.render("out", "");
    for (arguments, part) in [
        ("refocus array --disparity 0 --out x.png", "--distance-m"),
        ("refocus array --stack 0,1,3 --out x.png", "--distance-m"),
        ("refocus array --distance-m inf --tilt-deg 1,0 --out x.png", "finite"),
        ("refocus array --distance-m 1 --tilt-deg 90,0 --out x.png", "between -90 and 90"),
        ("refocus out --disparity 0 --tilt-deg 1,0 --out x.png", "--distance-m"),
        ("refocus array --distance-m 1 --aperture disc:1e-9 --eye 9,9,9 --out x.png", "no camera lies within"),
        ("refocus array --distance-m 1 --eye 0,0,1 --target 0,0,1 --out x.png", "stands where it looks"),
        ("refocus out --distance-m 1 --eye 0,0,1 --out x.png", "no transforms.json"),
        ("synthesize array --at 1,0 --out x.png", "--eye"),
        ("synthesize array --eye 0,0,1 --out x.png", "has no depth"),
        ("synthesize array --eye 0,0,1 --disparity estimate --out x.png", "grids of views"),
        ("synthesize array --out x.png", "--at"),
        ("synthesize out --at 1,1 --eye 0,0,1 --out x.png", "cannot be used with"),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(part), "{arguments}: {outcome:?}");
    }
    // Other commands say what it is.
    let outcome = bench.run("info array");
    assert!(outcome.code == Some(0) && outcome.stdout.contains("images of 3 cameras anywhere"), "{outcome:?}");
    for arguments in ["view array --out x.html", "extract array --view 0,0 --out x.png"] {
        let outcome = bench.run(arguments);
        let is_said = outcome.stderr.contains("images of 3 cameras anywhere, which are no grid of views");
        assert!(outcome.code == Some(1) && is_said, "{arguments}: {outcome:?}");
    }
    std::fs::write(bench.path("array/images/camera_0001.png"), "no image").unwrap();
    let outcome = bench.run("refocus array --distance-m 1 --out x.png");
    assert!(outcome.code == Some(1) && outcome.stderr.contains("camera_0001.png"), "{outcome:?}");
    assert!(!bench.list("").iter().any(|name| name.starts_with("x.")), "nothing was written");
}

/// Cameras that see nothing in common are refused, with numbers.
#[test]
fn cameras_that_look_away_from_each_other_are_refused() {
    let bench = Bench::new();
    ok(bench.run("array plane --count 2x1 --size 12x8 --out in.json"));
    let mut file: Value = serde_json::from_str(&std::fs::read_to_string(bench.path("in.json")).unwrap()).unwrap();
    for row in file["frames"][1]["transform_matrix"].as_array_mut().unwrap().iter_mut().take(3) {
        for column in [0, 2] {
            row[column] = (-row[column].as_f64().unwrap()).into();
        }
    }
    std::fs::write(bench.path("in.json"), file.to_string()).unwrap();
    ok(bench.run("render tiny.glb --out array --transforms in.json --spp 1 --layers depth"));
    for (arguments, part) in [
        (
            "refocus array --distance-m 1 --out x.png",
            "2 cameras within the aperture do not see the same surface: 1 of them",
        ),
        (
            "correspond array --from camera_0000 --to camera_0001 --out x.npy",
            "camera_0001 sees none of the 96 pixels of camera_0000",
        ),
        (
            "depth array --depths-m 0.5,4 --out x.pfm",
            "the 1 other cameras in its plane see nothing of what camera 'camera_0000' does",
        ),
        (
            "synthesize array --eye 0,50,0 --target 0,99,0 --up 0,0,1 --out x.png",
            "2 cameras that are nearest to the view",
        ),
    ] {
        let outcome = bench.run(arguments);
        assert!(outcome.code == Some(2) && outcome.stderr.contains(part), "{arguments}: {outcome:?}");
    }
    assert!(!bench.list("").iter().any(|name| name.starts_with("x.")), "nothing was written");
}

/// Cameras of a real array: the file says how each deviates, and images follow it.
#[test]
fn deviations_are_in_the_file_and_in_the_images() {
    let bench = Bench::new();
    let place = "array plane --count 4x2 --size 24x16 --radius-m 1 --seed 5";
    ok(bench.run(&format!("{place} --out exact.json")));
    ok(bench.run(&format!("{place} --jitter-position-m 0.01 --jitter-rotation-deg 1 --jitter-focal 0.02 --jitter-gain 0.2 --jitter-color 0.1 --jitter-time-s 0.5 --out in.json")));
    ok(bench.run(&format!("{place} --jitter-position-m 0.01 --out moved.json")));
    let read = |name: &str| holo_io::CameraArray::read(bench.path(name), holo_io::WorldUp::Z, None).unwrap().cameras;
    let (exact, all, moved) = (read("exact.json"), read("in.json"), read("moved.json"));
    for k in 0..8 {
        assert!(exact[k].gain == [1.0; 3] && exact[k].time_s == 0.0 && moved[k].focal_px == exact[k].focal_px);
        // One kind of jitter does not change another.
        assert_eq!(all[k].axes_and_position[3], moved[k].axes_and_position[3]);
        let away =
            (0..3).map(|i| (moved[k].axes_and_position[3][i] - exact[k].axes_and_position[3][i]).powi(2)).sum::<f64>();
        assert!(away > 0.0 && away.sqrt() < 0.06 && all[k].focal_px != exact[k].focal_px);
        assert!(all[k].gain != [1.0; 3] && (0.0..0.5).contains(&all[k].time_s));
    }
    let outcome = bench.run(&format!("{place} --jitter-gain -1 --out x.json"));
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    // Two cameras at one place: the gain multiplies the light, and the other time is that of the animation.
    ok(bench.run("scene pendulum --out pendulum.glb"));
    let frame = |name: &str, more: &[(&str, Value)]| {
        let mut frame = json!({ "file_path": format!("images/{name}.png"), "fl_x": 30.0, "w": 24, "h": 16, "transform_matrix":
            [[1, 0, 0, 0], [0, 1, 0, 0.3], [0, 0, 1, 1.2], [0, 0, 0, 1]] });
        more.iter().for_each(|(key, value)| frame[*key] = value.clone());
        frame
    };
    let file = json!({ "frames": [
        frame("plain", &[]), frame("bright", &[("gain", json!([2.0, 1.0, 0.5]))]), frame("late", &[("time_s", json!(0.25))]) ] });
    std::fs::write(bench.path("poses.json"), file.to_string()).unwrap();
    let line = "render pendulum.glb --transforms poses.json --transforms-up y --layers depth,color --integrator direct --spp 1 --fps 12";
    ok(bench.run(&format!("{line} --frame 3 --out three")));
    ok(bench.run(&format!("{line} --frame 6 --out six")));
    let light = |folder: &str, name: &str| image(&bench, &format!("{folder}/color/{name}.pfm"));
    let (plain, bright) = (light("three", "plain"), light("three", "bright"));
    for ((_, _, channel), (light, gained)) in plain.indexed_iter().map(|(at, x)| (at, (x, bright[at]))) {
        assert!((gained - light * [2.0, 1.0, 0.5][channel]).abs() < 1e-6 * light.abs().max(1e-3));
    }
    assert!(light("three", "late") == light("six", "plain") && light("three", "plain") != light("six", "plain"));
    let written = read_transforms(&bench, "three/transforms.json");
    assert_eq!((written[1].gain, written[2].time_s), ([2.0, 1.0, 0.5], 0.25));
    // A light field at a pose has no gain of its own.
    let outcome =
        bench.run("render pendulum.glb --transforms poses.json --transforms-up y --views 3 --spp 1 --out views");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("camera 'bright' has a gain"), "{outcome:?}");
}

fn read_transforms(bench: &Bench, name: &str) -> Vec<holo_io::ArrayCamera> {
    holo_io::CameraArray::read(bench.path(name), holo_io::WorldUp::Y, None).unwrap().cameras
}

/// The share of pixels that are off by as much as 0.07; without a border.
fn bad_pixels(found: &ndarray::Array2<f32>, truth: &ndarray::Array2<f32>) -> f64 {
    let (rows, columns) = truth.dim();
    let inside = |&((row, column), _): &((usize, usize), &f32)| {
        (8..rows - 8).contains(&row) && (8..columns - 8).contains(&column)
    };
    let bad: Vec<bool> =
        truth.indexed_iter().filter(inside).map(|(at, truth)| (found[at] - truth).abs() > 0.07).collect();
    bad.iter().filter(|&&is_bad| is_bad).count() as f64 / bad.len() as f64
}

/// Depth from cameras that are turned and have other focal lengths is nearly as good as that from a rig at the same places.
#[test]
fn depth_is_estimated_from_cameras_in_a_plane() {
    let bench = Bench::new();
    ok(bench.run("scene tiles --out tiles.glb"));
    let scene = holo_scene::gltf::load(&bench.path("tiles.glb"), &holo_scene::gltf::Limits::default()).unwrap().scene;
    let pose = scene.cameras[0].pose;
    ok(bench.run("render tiles.glb --views 7 --lenses 108x72 --spp 8 --integrator direct --baseline-m 0.013 --focus-m 0.68 --write el,disparity --out rig"));
    ok(bench.run("depth rig --effort fast --range=-0.9,0.9 --out rig.pfm"));
    let read = |file: &str| read_pfm_gray(bench.path(file), &Limits::default()).unwrap();
    let rig = bad_pixels(&read("rig.pfm"), &read("rig/scene_disparity.pfm"));
    let mut bad = vec![rig];
    for turn in [0.0, 0.02] {
        let frame = |k: usize| {
            let (down, right) = ((k / 7) as f64 - 3.0, (k % 7) as f64 - 3.0);
            // Turned about two axes, by another angle each.
            let (a, b) = (turn * (2.4 * k as f64).sin(), turn * (1.7 * k as f64).cos());
            let turned = Transform::look_at([0.0; 3], [b, a, -1.0], [0.0, 1.0, 0.0]).columns;
            let world = |v: [f64; 3]| -> [f64; 3] {
                std::array::from_fn(|i| (0..3).map(|j| pose.columns[j][i] * v[j]).sum::<f64>())
            };
            let [x, y, z] = turned.map(world);
            let offset = world([0.013 * right, -0.013 * down, 0.0]);
            let row = |i: usize| json!([x[i], y[i], z[i], pose.translation[i] + offset[i]]);
            json!({ "file_path": format!("images/{k}.png"), "w": 108, "h": 72, "fl_x": 150.0 * (1.0 + turn * (3.1 * k as f64).sin()),
                "transform_matrix": [row(0), row(1), row(2), [0, 0, 0, 1]] })
        };
        let file = json!({ "frames": (0..49).map(frame).collect::<Vec<_>>() });
        std::fs::write(bench.path("in.json"), file.to_string()).unwrap();
        ok(bench.run(
            "render tiles.glb --transforms in.json --transforms-up y --out array --spp 8 --integrator direct --layers depth --overwrite",
        ));
        ok(bench.run("depth array --effort fast --depths-m 0.52,1.1 --camera 24 --out array.pfm"));
        let focal_m = 150.0 * (1.0 + turn * (3.1 * 24.0_f64).sin()) * 0.013;
        let disparity = |depth_m: ndarray::Array2<f32>| depth_m.mapv(|z| (focal_m / f64::from(z)) as f32);
        bad.push(bad_pixels(&disparity(read("array.pfm")), &disparity(read("array/depth/24.pfm"))));
    }
    println!("{bad:?}");
    assert!(bad[0] < 0.3 && bad[1..].iter().all(|&bad| bad < rig + 0.05), "{bad:?}");
    // Cameras on a sphere stand in no plane with each other.
    ok(bench.run("array sphere --count 6 --radius-m 1.5 --size 24x18 --out around.json"));
    ok(bench.run("render tiles.glb --transforms around.json --out around --spp 1"));
    let outcome = bench.run("depth around --depths-m 0.8,4 --out d.pfm");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("no other camera stands in the plane"), "{outcome:?}");
}
