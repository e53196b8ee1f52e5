//! `holo export` of raw images and boards, and of what readers of saliency take.

use crate::common::{Bench, SCENE, camera_bench, ok, read_u8, refused, shifted_camera};
use holo_core::DynImage;
use holo_io::{LightFieldReader, Limits, MatArray, ReadOptions};

/// A raw image that was rendered for no program becomes the bytes of a render for it.
#[test]
fn raw_images_become_what_a_render_for_a_program_writes() {
    let bench = camera_bench();
    // LFToolbox and PlenoptiCam take square grids too, the others do not.
    let tools = "plenopticam,libpleno,pip,raytrix,plenpy";
    let hexagonal = shifted_camera().replace("square", "hex-rows");
    std::fs::write(bench.path("hexagonal.toml"), hexagonal).unwrap();
    let render = format!("render {SCENE} --camera-file hexagonal.toml --spp 1 --sky 1,1,1 --quiet");
    ok(bench.run(&format!("{render} --out with --for {tools}")));
    ok(bench.run(&format!("{render} --out without")));
    for tool in tools.split(',') {
        ok(bench.run(&format!("export without --for {tool} --out {tool}")));
        let files = |folder: &str| -> Vec<String> {
            bench.list(folder).into_iter().filter(|name| !name.ends_with('/')).collect()
        };
        let own: Vec<String> = files("with").into_iter().filter(|name| name.starts_with(&format!("{tool}/"))).collect();
        assert!(own.len() >= 3, "{own:?}");
        for name in &own {
            let [ours, theirs] = [format!("{tool}/{name}"), format!("with/{name}")];
            assert!(std::fs::read(bench.path(&ours)).unwrap() == std::fs::read(bench.path(&theirs)).unwrap(), "{ours}");
        }
        assert_eq!(files(tool).len(), own.len() + 1);
    }
    // Without vignetting: light that came through is shown, and nothing where it hardly comes.
    let white = holo_io::read_exr(bench.path("without/white.exr"), &Limits::default()).unwrap().channels.remove(0).1;
    let raw = holo_io::read_exr_rgb(bench.path("without/raw.exr"), &Limits::default()).unwrap();
    let most = |lights: &[f32]| lights.iter().copied().fold(0.0, f32::max);
    let brightest = [most(white.as_slice().unwrap()), most(raw.as_slice().unwrap())];
    let mut shown = 0;
    for ((row, column, c), code) in read_u8(bench.path("raytrix/raytrix/raw.png")).indexed_iter() {
        let (share, light) = (white[[row, column]] / brightest[0], raw[[row, column, c]] / brightest[1]);
        let is_bright = share > 0.0201 && light > 0.1 * share;
        assert!(
            if share < 0.0199 { *code == 0 } else { !is_bright || *code > 0 },
            "{row} {column}: {code} {share} {light}"
        );
        shown += usize::from(is_bright);
    }
    assert!(shown > raw.len() / 10, "{shown}");
    ok(bench.run(&format!("render {SCENE} --camera-file small.toml --spp 1 --out square --quiet")));
    refused(&bench, "export square --for pip --out none", "hexagonal");
    refused(&bench, "export without --for compote --out none", "holo target");
    refused(&bench, "export without --for plenpy --views 3 --out none", "raw images");
    ok(bench.run(&format!("render {SCENE} --out lf --views 3 --lenses 16x12 --spp 1 --quiet")));
    refused(&bench, "export lf --for plenpy --out none", "camera.toml");
    assert!(!bench.path("none").exists());
}

/// COMPOTE gets every board, its corners and its place; a corner that its pose and `scene.js` place is where the truth says.
#[test]
fn boards_are_exported_for_compote() {
    let bench = camera_bench();
    let pose = |x: f64, angle: f64| {
        format!("[[pose]]\nposition_m = [{x}, -0.0003, -0.35]\nrotation_deg = [{angle}, 0.0, 0.0]\n")
    };
    std::fs::write(bench.path("poses.toml"), pose(0.0005, 20.0) + &pose(-0.0004, -15.0)).unwrap();
    ok(bench.run(
        "target --camera-file small.toml --checkerboard 5x3 --square-mm 0.6 --poses poses.toml --spp 1 --out boards",
    ));
    ok(bench.run("export boards --for compote --out out"));
    let json = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(bench.path("out").join(name)).unwrap()).unwrap()
    };
    let images = json("images.js");
    let paths = |key: &str| -> Vec<String> {
        images[key].as_array().unwrap().iter().map(|image| image["path"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(paths("checkerboards"), ["frame_00.png", "frame_01.png"]);
    assert_eq!(paths("whites").len(), 3);
    paths("whites").iter().for_each(|white| assert_eq!(read_u8(bench.path("out").join(white)).dim(), (90, 120, 3)));
    for frame in 0..2 {
        let raw = holo_io::read_linear(bench.path(format!("boards/frame_{frame:02}.exr")), &Limits::default()).unwrap();
        let codes = read_u8(bench.path(format!("out/frame_{frame:02}.png")));
        for ((v, u, _), code) in codes.indexed_iter() {
            assert!((f32::from(*code) - (255.0 * raw[[v, u, 0]]).min(255.0)).abs() <= 0.5 + 1e-3);
        }
    }
    let rows: Vec<Vec<f64>> = std::fs::read_to_string(bench.path("boards/corners.csv"))
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    let (features, poses, scene) = (json("features.js"), json("poses.js"), json("scene.js"));
    let features = features["features"].as_array().unwrap();
    let visible: Vec<_> = rows.iter().filter(|row| row[11] == 1.0).collect();
    assert!(visible.len() > 30 && features.len() == visible.len());
    assert_eq!(poses["poses"].as_array().unwrap().len(), 2);
    let square = scene["checkerboards"][0]["lph"].as_f64().unwrap();
    for (feature, row) in features.iter().zip(visible) {
        assert_eq!([&feature["u"], &feature["v"]].map(|x| x.as_f64().unwrap()), [row[2], row[3]]);
        let frame = row[6] as usize;
        assert_eq!(feature["frame"], frame);
        // Clusters count from the lower right; x runs left, y up. p = R^T (b - t), seen along +z.
        let cluster = feature["cluster"].as_u64().unwrap();
        let on_board = [square * (cluster % 5) as f64, square * (cluster / 5) as f64, 0.0];
        let pose = &poses["poses"][frame]["pose"];
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let from: [f64; 3] = std::array::from_fn(|k| on_board[k] - number(&pose["translation"][0][k]));
        let point: [f64; 3] = std::array::from_fn(|k| (0..3).map(|a| number(&pose["rotation"][k][a]) * from[a]).sum());
        let truth = [-1e3 * row[7], 1e3 * row[8], -1e3 * row[9]];
        assert!((0..3).all(|k| (point[k] - truth[k]).abs() < 1e-9), "{point:?} {truth:?}");
    }
}

/// Focal stacks are those of `holo refocus`, masks show the chosen objects alone.
#[test]
fn saliency_has_focal_stacks_and_masks_of_objects() {
    let bench = Bench::new();
    let render = format!("render {SCENE} --views 5 --lenses 16x12 --disparity -1,1 --spp 1 --quiet");
    ok(bench.run(&format!("{render} --out lf --layers depth,disparity,object-id")));
    ok(bench.run(&format!("{render} --out plain")));
    refused(&bench, "export plain --for lfsd --objects x --out out", "object-id");
    let map = |name: &str| holo_io::read_pfm_gray(bench.path("lf").join(name), &Limits::default()).unwrap();
    let ids = map("scene_object_id.pfm");
    // Its part of the view.
    let first = format!("object-1 ({:.0} %)", ids.mapv(|id| f32::from(u8::from(id == 1.0))).mean().unwrap() * 100.0);
    refused(&bench, "export lf --for lfsd --out out", &first);
    refused(&bench, "export lf --for lfsd --objects no* --out out", &first);
    refused(&bench, "export lf --for hci --objects x --out out", "lfsd");
    assert!(!bench.path("out").exists());
    ok(bench.run("export lf --for lfsd --objects object-2 --out out"));
    let field =
        match LightFieldReader::open(bench.path("lf"), &ReadOptions::default()).unwrap().read().unwrap().light_field {
            holo_core::DynLightField::U8(field) => field,
            other => panic!("{:?}", other.kind()),
        };
    let (disparity, depth) = (map("scene_disparity.pfm"), map("scene_depth.pfm"));
    let mask = read_u8(bench.path("out/train_masks/lf.png"));
    let seen: std::collections::BTreeSet<u8> = mask.iter().copied().collect();
    assert_eq!(seen, [0, 255].into());
    assert!(ids.indexed_iter().all(|((v, u), id)| (mask[[v, u, 0]] == 255) == (*id == 2.0)));
    assert_eq!(read_u8(bench.path("out/data/original_GT/lf.PNG")), mask);
    assert_eq!(read_u8(bench.path("out/data/original_data/lf.PNG")), field.to_elemental_grid().unwrap());
    let hit = disparity.iter().zip(&depth).filter(|(_, z)| z.is_finite()).map(|(px, _)| *px);
    let [far, near] = hit.fold([f32::MAX, f32::MIN], |[far, near], px| [far.min(px), near.max(px)]);
    let codes = read_u8(bench.path("out/train_depths/lf.png"));
    for ((v, u), px) in disparity.indexed_iter() {
        let expected = (255.0 * (px - far) / (near - far)).clamp(0.0, 255.0);
        assert!((f32::from(codes[[v, u, 0]]) - expected).abs() < 0.51);
    }
    let stack =
        match holo_io::read_mat_variable(bench.path("out/train_focals/lf.mat"), "img", &Limits::default()).unwrap() {
            MatArray::U8(stack) => stack,
            _ => panic!("no integers"),
        };
    assert_eq!(stack.shape(), [12, 16, 36]);
    for (slice, px) in [(0, near), (11, far)] {
        ok(bench.run(&format!("refocus lf --disparity={px} --out sharp.png")));
        let DynImage::U8(sharp) = holo_io::read_png(bench.path("sharp.png"), &Limits::default()).unwrap() else {
            panic!()
        };
        for ((v, u, c), code) in sharp.indexed_iter() {
            assert_eq!(stack[[v, u, 3 * slice + c]], *code, "{slice} {v} {u}");
        }
    }
    // Begins and ends as a JPEG; LFSOD's own loader reads it (`cargo xtask consumers`).
    let bytes = std::fs::read(bench.path("out/train_images/lf.jpg")).unwrap();
    assert!(bytes.starts_with(&[0xff, 0xd8]) && bytes.ends_with(&[0xff, 0xd9]));
    ok(bench.run("export lf --for lfsd --objects object-* --group test --out other"));
    assert!(bench.path("other/test_focals/lf.mat").is_file());
}
