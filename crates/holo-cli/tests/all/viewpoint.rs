//! Where the camera stands: `--eye`, `--target`, `--up`, `--fov-deg`, `--fit-object`, for every kind of camera.

use crate::common::{Bench, CAMERA, SCENE, read_u8};
use holo_io::{Limits, read_pfm};
use holo_scene::{Instance, Material, Mesh, Scene, Transform};

/// A square of 2 m in the plane z = 0, and a small one in front of it, without a camera.
fn squares() -> Scene {
    let square = |half: f32| Mesh {
        positions: vec![[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let instance = |name: &str, mesh, z| Instance {
        name: name.into(),
        mesh,
        transform: Transform::from_translation([0.0, 0.0, z]),
    };
    Scene {
        meshes: vec![square(1.0), square(0.1)],
        instances: vec![instance("wall", 0, 0.0), instance("plate", 1, 0.5)],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("squares.glb"), holo_scene::gltf::to_glb(&squares()).unwrap()).unwrap();
    bench
}

/// The depth of the middle and of a corner of the central view.
fn depths(bench: &Bench, name: &str, options: &str) -> [f32; 2] {
    let line =
        format!("render squares.glb --views 3 --lenses 33x33 --integrator depth --write depth {options} --out {name}");
    let outcome = bench.run(&line);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let depth = read_pfm(bench.path(name).join("scene_depth.pfm"), &Limits::default()).unwrap().values;
    [depth[[16, 16, 0]], depth[[0, 0, 0]]]
}

/// Planar depth is the distance from the plane of the camera, whatever the angle of view.
#[test]
fn depth_is_that_of_the_place_of_the_camera() {
    let bench = bench();
    for (name, options, expected) in [
        ("front", "--eye 0,0,2.5 --target 0,0,0 --fov-deg 40", [2.0, 2.5]),
        ("behind", "--eye 0,0,-3 --target 0,0,0 --fov-deg 20", [3.0, 3.0]),
        // The middle of the scene is (0, 0, 0.25).
        ("middle", "--eye 0,0,4.25 --fov-deg 20", [3.75, 4.25]),
        // The plate is 0.1 m to each side, and the image 1.05 times as wide.
        ("fit", "--fit-object plate --eye 0,0,9 --fov-deg 90", [0.105, 0.605]),
        ("wide", "--eye 0,0,2.5 --target 0,0,0 --fov-deg 100", [2.0, f32::INFINITY]),
    ] {
        let found = depths(&bench, name, options);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(found == expected || (found - expected).abs() < 1e-6, "{name}: {found} instead of {expected}");
        }
    }
}

/// A ground is seen below what was there, which stays where it was; it does not move the camera of a scene without one.
#[test]
fn a_ground_lies_below_the_scene() {
    let bench = bench();
    let render = |name: &str, options: &str| {
        let line = format!(
            "render squares.glb --views 3 --lenses 45x30 --integrator depth --write depth {options} --out {name}"
        );
        let outcome = bench.run(&line);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        read_pfm(bench.path(name).join("scene_depth.pfm"), &Limits::default()).unwrap().values
    };
    let hits = |depth: &ndarray::Array3<f32>| depth.iter().filter(|depth| depth.is_finite()).count();
    let (alone, grounded) = (render("alone", "--eye 3,1.5,4"), render("grounded", "--eye 3,1.5,4 --ground"));
    assert!(hits(&grounded) > hits(&alone) + 200, "{} {}", hits(&alone), hits(&grounded));
    // The middle of the scene, which the camera looks at, is lower by half the distance of the ground.
    assert!(alone.iter().zip(&grounded).all(|(a, b)| (a - b).abs() < 1e-3 || !a.is_finite()));
    let whole = render("whole", "--ground");
    assert!(whole.iter().copied().fold(f32::INFINITY, f32::min) < 6.0, "as near as without a ground");
}

/// A raw image from the place of a rig: a plenoptic camera has the same pose.
#[test]
fn plenoptic_cameras_stand_there_too() {
    let bench = bench();
    std::fs::write(bench.path("small.toml"), CAMERA).unwrap();
    let line = "render squares.glb --camera-file small.toml --integrator depth --layers depth --spp 1 --sky 1";
    for (name, eye) in [("near", "0,0,1.5"), ("far", "0,0,2.5")] {
        let outcome = bench.run(&format!("{line} --eye {eye} --target 0,0,0 --out {name}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
    }
    let depth = |name: &str| {
        let file = bench.list(name).into_iter().find(|file| file.contains("depth")).expect("a layer of depth");
        read_pfm(bench.path(name).join(file), &Limits::default()).unwrap().values
    };
    let (near, far) = (depth("near"), depth("far"));
    let middle = [near.dim().0 / 2, near.dim().1 / 2, 0];
    assert!((far[middle] - near[middle] - 1.0).abs() < 1e-5, "{} {}", near[middle], far[middle]);
}

#[test]
fn contradictions_are_refused() {
    let bench = bench();
    std::fs::write(bench.path("small.toml"), CAMERA).unwrap();
    let rig = "--views 3 --lenses 8x8";
    for (options, said) in [
        (format!("{rig} --eye 0,3,0 --target 0,0,0"), "--up"),
        (format!("{rig} --eye 1,2,3 --target 1,2,3"), "--eye"),
        (format!("{rig} --fit-object table"), "it has 'plate', 'wall'"),
        (format!("{rig} --fit-object wall --target 0,0,0"), "--fit-object"),
        (format!("{rig} --fov-deg 30 --focal-mm 50"), "--fov-deg"),
        (format!("{rig} --eye 1,2"), "X,Y,Z"),
        (format!("{rig} --fov-deg 180"), "below 180"),
        ("--camera-file small.toml --fov-deg 30".into(), "--fov-deg"),
    ] {
        let outcome = bench.run(&format!("render squares.glb {options} --out refused"));
        assert_eq!(outcome.code, Some(2), "{options}: {outcome:?}");
        assert!(outcome.stderr.contains(said), "{options}: {}", outcome.stderr);
        assert!(!bench.path("refused").exists());
    }
    // Of a scene with a camera the rest stays.
    let outcome = bench.run(&format!("render {SCENE} {rig} --spp 1 --fov-deg 30 --out angle"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

/// The backdrop is what the camera sees where the mask is black, and lights nothing.
#[test]
fn the_mask_says_where_the_backdrop_is() {
    let bench = bench();
    let render = |name: &str, options: &str| {
        let line = format!(
            "render squares.glb --views 3 --lenses 45x30 --eye 0.8,0.2,4 --target 0.8,0,0 --sky 0.5 --spp 1 --exposure 0 \
             {options} --out {name}"
        );
        let outcome = bench.run(&line);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        read_u8(bench.path(name).join("scene_el.png"))
    };
    let (plain, green) = (render("plain", ""), render("green", "--backdrop 0,0.25,0"));
    let mask = read_u8(bench.path("green/scene_hit_mask.png"));
    let depth = read_pfm(bench.path("green/scene_depth.pfm"), &Limits::default()).unwrap().values;
    assert_eq!(mask.dim(), (30, 45, 1));
    assert!(mask.iter().zip(&depth).all(|(code, depth)| *code == if depth.is_finite() { 255 } else { 0 }));
    let misses = mask.iter().filter(|code| **code == 0).count();
    assert!((100..1000).contains(&misses), "{misses}");
    // Linear 0.25 is code 137 of sRGB.
    for ((row, column, _), code) in mask.indexed_iter() {
        let at = |image: &ndarray::Array3<u8>| [0, 1, 2].map(|c| image[[3 * row + 1, 3 * column + 1, c]]);
        let expected = if *code == 0 { [0, 137, 0] } else { at(&plain) };
        assert_eq!(at(&green), expected, "{row} {column}");
    }
    // Scores leave out what is not hit, and say so.
    let line = "eval green/scene_disparity.pfm green/scene_disparity.pfm --border 0 --json";
    let (masked, all) = (bench.run(line), bench.run(&format!("{line} --mask none")));
    assert!(masked.stderr.contains("scene_hit_mask.png") && !all.stderr.contains("scene_hit_mask.png"), "{masked:?}");
    let compared = |outcome: &crate::common::Outcome| {
        let scores: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
        scores["compared"].as_u64().unwrap() as usize
    };
    assert_eq!((compared(&masked), compared(&all)), (mask.len() - misses, mask.len()));
}

/// `holo render` warns before it renders, and `holo info` shows the same warning.
#[test]
fn views_that_hardly_differ_are_found_before_they_are_rendered() {
    let bench = bench();
    let info = bench.run("info squares.glb --views 9 --lenses 33x33");
    assert!(info.stdout.contains("the views hardly differ") && info.stdout.contains("--disparity=-1,1"), "{info:?}");
    let rendered = bench.run("render squares.glb --views 9 --lenses 33x33 --spp 1 --out few");
    let (warning, done) =
        (rendered.stderr.find("the views hardly differ"), rendered.stderr.find("rendered 9 x 9 views"));
    assert!(warning.is_some() && warning < done, "{rendered:?}");
}
