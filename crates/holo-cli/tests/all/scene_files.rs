//! Scenes as users export them: without a camera, without light, with glass and lights of Blender, and what a render
//! says about them.

use crate::common;
use crate::common::{Bench, DEFAULT_FILES, SCENE, SMALL};
use holo_io::{ColorEncoding, Compression, Manifest, ManifestValue, write_png};
use holo_scene::gltf::to_glb;
use holo_scene::{CameraProjection, Material, Mesh, Scene};

fn write(bench: &Bench, name: &str, scene: &Scene) {
    std::fs::write(bench.path(name), to_glb(scene).unwrap()).unwrap();
}

/// The text of an option in the manifest of a folder.
fn option(bench: &Bench, folder: &str, name: &str) -> Option<ManifestValue> {
    let manifest = Manifest::read(bench.path(folder).join("manifest.json")).unwrap();
    let Some(ManifestValue::Table(options)) = manifest.settings.get("options") else { panic!("no options") };
    options.get(name).cloned()
}

#[test]
fn a_scene_without_light_gets_a_soft_sky() {
    let bench = Bench::new();
    write(&bench, "dark.glb", &Scene { lights: vec![], ..common::tiny_scene() });
    let outcome = bench.run(&format!("render dark.glb --out dark {SMALL} --spp 1"));
    assert_eq!((outcome.code, bench.list("dark").len()), (Some(0), DEFAULT_FILES.len()), "{outcome:?}");
    let lines = outcome.stderr.lines().filter(|line| line.contains("no light sources")).count();
    assert!(lines == 1 && outcome.stderr.contains("soft sky"), "{outcome:?}");
    let manifest = Manifest::read(bench.path("dark/manifest.json")).unwrap();
    assert_eq!(manifest.settings["automatic-sky"].as_text(), Some("on"));
    assert_eq!(option(&bench, "dark", "sky"), Some("auto".into()));
    // The sky lights all channels alike.
    let image = common::read_u8(bench.path("dark/scene_el.png"));
    assert!(image.iter().any(|&code| code > 100));
    // Light in the scene, or a sky, even a black one: nothing is added.
    for (scene, out, sky) in [(SCENE, "lit", ""), ("dark.glb", "black", "--sky 0"), ("dark.glb", "gray", "--sky 1")] {
        let outcome = bench.run(&format!("render {scene} --out {out} {SMALL} --spp 1 {sky}"));
        assert!(outcome.code == Some(0) && !outcome.stderr.contains("soft sky"), "{outcome:?}");
        let manifest = Manifest::read(bench.path(out).join("manifest.json")).unwrap();
        assert!(!manifest.settings.contains_key("automatic-sky"));
    }
    let outcome = bench.run("dataset --out set --glb dark.glb --views 2,3 --sensor 60x40 --spp 1");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert_eq!(outcome.stderr.matches("soft sky").count(), 1, "once for all numbers of views: {outcome:?}");
    assert!(outcome.stderr.contains("dark: note:") && bench.path("set/dark/3x3/scene_el.png").is_file());
}

#[test]
fn a_panorama_can_be_a_png() {
    let bench = Bench::new();
    // sRGB 188 is 0.503 linear.
    let sky = ndarray::Array3::from_elem((4, 8, 3), 188_u8);
    write_png(bench.path("sky.png"), sky.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    write(&bench, "dark.glb", &Scene { lights: vec![], ..common::tiny_scene() });
    let outcome = bench.run(&format!("render dark.glb --out out {SMALL} --spp 1 --sky sky.png --write exr,el"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert_eq!(option(&bench, "out", "sky"), Some("map".into()));
    // The camera sees the sky at the rim.
    let central = holo_io::read_exr_rgb(bench.path("out/scene_central.exr"), &holo_io::Limits::default()).unwrap();
    assert!((central[[0, 0, 0]] - 0.5029).abs() < 1e-3, "{}", central[[0, 0, 0]]);
    std::fs::write(bench.path("bad.jpg"), "no image").unwrap();
    let outcome = bench.run(&format!("render {SCENE} --out refused {SMALL} --sky bad.jpg"));
    assert!(outcome.code == Some(1) && outcome.stderr.contains("bad.jpg: environment"), "{outcome:?}");
}

#[test]
fn how_the_file_is_read_is_an_option_and_part_of_the_manifest() {
    let bench = Bench::new();
    let mut scene = common::tiny_scene();
    // A tetrahedron of glass without a volume, in front of everything.
    scene.materials.push(Material { name: "glass".into(), transmission: 1.0, roughness: 0.0, ..Material::default() });
    scene.meshes.push(Mesh {
        name: "body".into(),
        positions: vec![[-0.2, -0.2, -0.9], [0.3, -0.2, -0.9], [0.0, 0.3, -0.9], [0.0, 0.0, -0.6]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        material: 1,
        ..Mesh::default()
    });
    let mut body = scene.instances[0].clone();
    (body.mesh, body.transform) = (1, holo_scene::Transform::IDENTITY);
    scene.instances.push(body.clone());
    scene.instances.push(body);
    write(&bench, "glass.glb", &scene);
    let render = |out: &str, more: &str| {
        let outcome = bench.run(&format!("render glass.glb --out {out} {SMALL} --spp 1 --exposure 0 {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        (outcome.stderr, std::fs::read(bench.path(out).join("scene_el.png")).unwrap())
    };
    let (warnings, thin) = render("thin", "");
    assert!(warnings.contains("soap bubble") && warnings.contains("--solid-glass"), "{warnings}");
    let (warnings, solid) = render("solid", "--solid-glass");
    assert!(!warnings.contains("soap bubble") && thin != solid, "{warnings}");
    let (_, dim) = render("dim", "--light-units blender");
    assert!(dim != thin);
    assert_eq!(option(&bench, "dim", "light-units"), Some("blender".into()));
    assert_eq!(option(&bench, "thin", "solid-glass"), Some(false.into()));
    // Another way to read the file is another image.
    let outcome = bench.run(&format!("render glass.glb --out thin {SMALL} --spp 1 --exposure 0 --solid-glass"));
    assert!(outcome.code == Some(2) && outcome.stderr.contains("--solid-glass has changed"), "{outcome:?}");
    let outcome = bench.run(&format!("render glass.glb --out none {SMALL} --material-variant red"));
    assert!(outcome.code == Some(1) && outcome.stderr.contains("no material variant 'red'"), "{outcome:?}");
    let text = bench.run(&format!("info glass.glb {SMALL}")).stdout;
    for part in ["thin glass:          1 'glass'", "light units:         glTF", "coincident faces:    4 pairs"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!bench.run(&format!("info glass.glb {SMALL} --solid-glass")).stdout.contains("thin glass"));
}

#[test]
fn a_file_without_a_camera_is_seen_whole() {
    let bench = Bench::new();
    write(&bench, "bare.glb", &Scene { cameras: vec![], lights: vec![], ..common::tiny_scene() });
    let outcome = bench
        .run("render bare.glb --out out --lenses 24x20 --views 5 --spp 1 --ground-truth all --layers hit-mask,depth");
    assert!(outcome.code == Some(0) && outcome.stderr.contains("no camera in the scene"), "{outcome:?}");
    let manifest = Manifest::read(bench.path("out/manifest.json")).unwrap();
    for view in manifest.files.keys().filter(|name| name.starts_with("hit-mask/")) {
        let mask = holo_io::read_pfm(bench.path("out").join(view), &holo_io::Limits::default()).unwrap().values;
        let (rows, columns, _) = mask.dim();
        let rim = |v: usize, u: usize| v == 0 || u == 0 || v + 1 == rows || u + 1 == columns;
        let inside = mask.indexed_iter().filter(|&((v, u, _), &hit)| hit > 0.0 && !rim(v, u)).count();
        let at_rim = mask.indexed_iter().filter(|&((v, u, _), &hit)| hit > 0.0 && rim(v, u)).count();
        // The margin of 5 % is half a pixel of 24 on either side.
        assert!(inside > 50 && at_rim <= 2, "{view}: {inside} {at_rim}");
    }
}

#[test]
fn a_portrait_camera_keeps_its_larger_angle() {
    let bench = Bench::new();
    let mut scene = common::tiny_scene();
    scene.cameras[0].projection = CameraProjection::Perspective { vertical_angle_rad: 0.7, aspect_ratio: Some(0.5625) };
    write(&bench, "portrait.glb", &scene);
    let outcome = bench.run("render portrait.glb --out out --lenses 30x20 --views 3 --spp 1");
    let note =
        "note: camera 'front': the camera sees 23.2 x 40.1 degrees (width / height 0.562), the image 40.1 x 27.4";
    assert!(outcome.code == Some(0) && outcome.stderr.contains(note), "{outcome:?}");
    assert!(!bench.render("same", "").stderr.contains("the camera sees"), "the same aspect ratio");
}

#[test]
fn what_is_probably_not_wanted_is_a_warning() {
    let bench = Bench::new();
    let mut scene = common::tiny_scene();
    scene.instances.iter_mut().for_each(|instance| instance.transform.translation[2] = 5.0);
    write(&bench, "behind.glb", &scene);
    let outcome = bench.run(&format!("render behind.glb --out behind {SMALL} --spp 1 --json"));
    assert!(outcome.code == Some(0) && outcome.stderr.contains("warning: nothing is hit"), "{outcome:?}");
    let report: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(report["warnings"][0].as_str().unwrap().contains("nothing is hit"), "{report}");
    let outcome = bench.render("close", "--baseline-m 1e-6");
    assert!(
        outcome.stderr.contains("the views hardly differ") && outcome.stderr.contains("--disparity"),
        "{outcome:?}"
    );
    // Also where no depth is written.
    let outcome = bench.run(&format!("render behind.glb --out color {SMALL} --spp 1 --write el --layers albedo"));
    assert!(outcome.stderr.contains("nothing is hit"), "{outcome:?}");
}

#[test]
fn disparities_decide_focus_and_baseline() {
    let bench = Bench::new();
    // Odd numbers of views: the central view does not move with the baseline.
    let line = format!("render {SCENE} --lenses 48x32 --views 5x3 --spp 1 --layers depth,disparity");
    let outcome = bench.run(&format!("{line} --out out --disparity -0.75,1.5"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let limits = holo_io::Limits::default();
    let read = |name: &str| holo_io::read_pfm(bench.path("out").join(name), &limits).unwrap().values;
    let (depth, disparity) = (read("scene_depth.pfm"), read("scene_disparity.pfm"));
    let hits = depth.iter().zip(&disparity).filter(|(z, _)| z.is_finite()).map(|(_, &d)| d);
    let (low, high) = hits.fold((f32::MAX, f32::MIN), |(low, high), d| (low.min(d), high.max(d)));
    // Depths are f32: 6e-8 times k/Z, some ten px.
    assert!((low + 0.75).abs() < 1e-5 && (high - 1.5).abs() < 1e-5, "{low} {high}");
    assert_eq!(option(&bench, "out", "disparity"), Some(ManifestValue::List(vec![(-0.75).into(), 1.5.into()])));
    for (more, part) in [
        ("--disparity 1,-1", "the smaller first"),
        ("--disparity -1,1 --focus-m 2", "cannot be used with"),
        ("--disparity -1,1 --baseline-m 0.1", "cannot be used with"),
        ("--disparity -1,1 --projection orthographic", "perspective views"),
    ] {
        let outcome = bench.run(&format!("{line} --out refused {more}"));
        assert!(outcome.code == Some(2) && outcome.stderr.contains(part), "{more}: {outcome:?}");
    }
}
