//! Commands for plenoptic cameras: what they write, what they refuse, and what they never delete.

use std::collections::BTreeMap;

use crate::common::{SCENE, camera_bench, refused, shifted_camera, succeeds};
use holo_core::DynImage;
use holo_io::{Limits, Manifest};

#[test]
fn raw_images_are_rendered_decoded_and_kept() {
    let bench = camera_bench();
    let render = format!("render {SCENE} --camera-file small.toml --spp 2 --sky 1,1,1 --out raw");
    let said = succeeds(&bench, &format!("{render} --layers depth,blur,coverage --for lftoolbox,plenopticam"));
    assert!(said.contains("angle of view") && said.contains("% of the pixels lit"), "{said}");
    let files = bench.list("raw");
    for name in [
        "camera.toml",
        "centers.csv",
        "lftoolbox/decode.m",
        "lftoolbox/raw.grid.json",
        "lftoolbox/raw.png",
        "lftoolbox/white.png",
        "manifest.json",
        "plenopticam/calibration.json",
        "plenopticam/raw.tiff",
        "plenopticam/white.tiff",
        "raw.exr",
        "raw_blur.pfm",
        "raw_coverage.pfm",
        "raw_depth.pfm",
        "raw_linear.png",
        "white.exr",
        "white.png",
    ] {
        assert!(files.contains(&name.to_owned()), "no {name} in {files:?}");
    }
    // White images of other programs: 1 is the brightest pixel.
    let white = holo_io::read_exr(bench.path("raw/white.exr"), &Limits::default()).unwrap().channels.remove(0).1;
    let brightest = white.iter().copied().fold(0.0, f32::max);
    let DynImage::U16(codes) = holo_io::read_png(bench.path("raw/lftoolbox/white.png"), &Limits::default()).unwrap()
    else {
        panic!("16 bits");
    };
    for (code, light) in codes.iter().zip(&white) {
        assert!((f32::from(*code) - 65535.0 * light / brightest).abs() < 1.0, "{code} {light} of {brightest}");
    }
    succeeds(&bench, "verify raw");
    let before = bench.bytes("raw");
    // The raw image stays where it is decoded, and so does another image.
    refused(&bench, "decode raw/raw.exr --camera-file small.toml --out raw", "another image");
    refused(&bench, "decode raw/raw.exr --camera-file small.toml --out raw --overwrite", "choose another --out");
    refused(&bench, "target --camera-file small.toml --square-mm 10 --out raw", "another image");
    refused(&bench, "white --camera-file small.toml --out raw", "another image");
    assert_eq!(bench.bytes("raw"), before);
    succeeds(&bench, &format!("decode raw/raw.exr --camera-file raw/camera.toml --scene {SCENE} --out views"));
    for command in
        ["verify views", "info views", "depth views --out estimate.pfm", "refocus views --disparity 0 --out sharp.png"]
    {
        succeeds(&bench, command);
    }
    let views = bench.bytes("views");
    // The same again, and with another number of views only on request.
    succeeds(&bench, &format!("decode raw/raw.exr --camera-file raw/camera.toml --scene {SCENE} --out views"));
    assert_eq!(bench.bytes("views"), views);
    let fewer = format!("decode raw/raw.exr --camera-file raw/camera.toml --scene {SCENE} --views 3 --out views");
    refused(&bench, &fewer, "another image");
    succeeds(&bench, &format!("{fewer} --overwrite"));
    succeeds(&bench, "verify views");
}

/// A camera file that is wrong about the array is corrected by a white image: views are those of the true camera.
#[test]
fn white_images_calibrate_cameras() {
    let bench = camera_bench();
    let truth = shifted_camera().replace("[120, 90]", "[600, 450]").replace("gap_um", "rotation_deg = 0.35\ngap_um");
    let nominal = truth.replace("rotation_deg = 0.35", "").replace("71.2", "71.0").replace("[7.0, -4.0]", "[0.0, 0.0]");
    for (name, text) in [("truth.toml", &truth), ("nominal.toml", &nominal)] {
        std::fs::write(bench.path(name), text).unwrap();
    }
    succeeds(&bench, "white --camera-file truth.toml --out whites");
    let said = succeeds(
        &bench,
        "calibrate whites/white.exr whites/white.png --camera-file nominal.toml --out found.toml --image centers.png",
    );
    assert!(said.contains("a square grid") && said.contains("turned by 0.35"), "{said}");
    succeeds(&bench, &format!("render {SCENE} --camera-file truth.toml --spp 1 --sky 1,1,1 --out raw"));
    let [mixed, clean, true_views] = ["nominal", "found", "truth"].map(|camera| {
        let line = format!("decode raw --white whites/white.exr --camera-file {camera}.toml --out views_{camera}");
        succeeds(&bench, &line)
    });
    assert!(mixed.contains("warning") && !clean.contains("warning") && !true_views.contains("warning"), "{clean}");
    let [found, truth] = ["found", "truth"]
        .map(|name| holo_io::CameraFile::read(bench.path(format!("{name}.toml"))).unwrap().camera.array().clone());
    assert!((found.pitch_m / truth.pitch_m - 1.0).abs() < 1e-5, "{found:?}");
    assert!((found.rotation_rad - truth.rotation_rad).abs() < 1e-5, "{found:?}");
    assert_eq!(crate::common::read_u8(bench.path("centers.png")).dim().2, 3);
    // Nothing but the pixels is known.
    succeeds(&bench, "calibrate whites/white.png --pixel-um 5 --out unknown.toml");
    assert!(std::fs::read_to_string(bench.path("unknown.toml")).unwrap().contains("approximate = true"));
    refused(&bench, "calibrate whites/white.png --out no.toml", "--camera-file");
    refused(&bench, "calibrate whites/white.png --pixel-um 0 --out no.toml", "--pixel-um");
    let no_white = bench.run("calibrate raw/raw_linear.png --camera-file small.toml --out no.toml");
    assert!(no_white.code != Some(0) && no_white.stderr.contains("white image"), "{no_white:?}");
    let missing = bench.run("calibrate no.png --pixel-um 5 --out no.toml");
    assert!(missing.code == Some(1) && missing.stderr.contains("no.png"), "{missing:?}");
    assert!(!bench.path("no.toml").exists());
}

/// The true camera has no error on its own boards, thin or of glass; a wrong one has that of its mistake.
#[test]
fn calibrations_are_scored() {
    let bench = camera_bench();
    let thin = shifted_camera().replace("[120, 90]", "[300, 240]");
    let focal = thin.lines().find(|line| line.starts_with("focal_mm")).unwrap().to_owned();
    let f_number = thin.lines().find(|line| line.starts_with("f_number")).unwrap().to_owned();
    let exit = thin.lines().find(|line| line.starts_with("exit_pupil_mm")).unwrap_or("#").to_owned();
    let glass = thin.replace(&focal, "prescription = \"double-gauss\"").replace(&f_number, "").replace(&exit, "#");
    let glass = glass.replace("[main_lens]", "[main_lens]\nscale_to_focal_mm = 40.0\nclose_to_f_number = 5.6");
    // Far from the focus, where several microlenses see a corner.
    let poses = "[[pose]]\nposition_m = [0.0, 0.0, -0.4]\n[[pose]]\nposition_m = [0.02, 0.0, -3.0]\nrotation_deg = [20.0, 0.0, 0.0]\n";
    std::fs::write(bench.path("poses.toml"), poses).unwrap();
    for (name, text) in [("thin", &thin), ("glass", &glass)] {
        std::fs::write(bench.path(format!("{name}.toml")), text).unwrap();
        let board = format!(
            "target --camera-file {name}.toml --checkerboard 3x2 --square-mm 5 --poses poses.toml --spp 1 --out {name}"
        );
        succeeds(&bench, &board);
        let score = |result: &str| -> serde_json::Value {
            let line = format!("eval-calibration {result} --truth {name} --json");
            serde_json::from_str(&bench.run(&line).stdout).unwrap()
        };
        let own = score(&format!("{name}.toml"));
        let number = |score: &serde_json::Value, key: &str, k: usize| score[key][k].as_f64().unwrap();
        assert!(own["corners"].as_u64().unwrap() > 20 && own["depths"].as_u64().unwrap() > 5, "{own}");
        assert!(number(&own, "reprojection_px", 1) < 1e-6 && number(&own, "centers_um", 1) < 1e-6, "{name}: {own}");
        assert!(own["depth_rms"].as_f64().unwrap() < 1e-6, "{name}: {own}");
        // A gap that is 1 % larger moves pixels apart and depths along.
        let text = std::fs::read_to_string(bench.path(format!("{name}/camera.toml"))).unwrap();
        let gap = text.lines().find(|line| line.starts_with("gap_um")).unwrap();
        let wrong: f64 = gap.split('=').nth(1).unwrap().trim().parse::<f64>().unwrap() * 1.01;
        std::fs::write(bench.path("wrong.toml"), text.replace(gap, &format!("gap_um = {wrong}"))).unwrap();
        let wrong = score("wrong.toml");
        assert!(number(&wrong, "reprojection_px", 0) > 0.01 && number(&wrong, "centers_px", 0) > 0.001, "{wrong}");
        assert!((number(&wrong, "gap_mm", 0) / number(&wrong, "gap_mm", 1) - 1.01).abs() < 1e-9, "{wrong}");
    }
    // The grid of micro-images alone, as other programs find it: moved by 3 and 4 tenths of a pixel.
    let thin = holo_io::CameraFile::read(bench.path("thin/camera.toml")).unwrap().camera;
    let mut grid = holo_io::interop::LensletGridModel::new(&thin).unwrap();
    (grid.h_offset, grid.v_offset) = (grid.h_offset + 0.3, grid.v_offset - 0.4);
    std::fs::write(bench.path("found.grid.json"), grid.to_json()).unwrap();
    let score: serde_json::Value =
        serde_json::from_str(&bench.run("eval-calibration found.grid.json --truth thin --json").stdout).unwrap();
    assert!(score["microlenses"].as_u64().unwrap() > 100, "{score}");
    for k in [0, 1] {
        assert!((score["centers_px"][k].as_f64().unwrap() - 0.5).abs() < 1e-6, "{score}");
    }
    let other = bench.run("eval-calibration lytro-illum --truth thin");
    assert!(other.code == Some(2) && other.stderr.contains("7728"), "{other:?}");
    let missing = bench.run("eval-calibration thin.toml --truth nowhere");
    assert!(missing.code == Some(1) && missing.stderr.contains("nowhere"), "{missing:?}");
    std::fs::write(bench.path("thin/corners.csv"), "k,l\n1,2\n").unwrap();
    let broken = bench.run("eval-calibration thin.toml --truth thin");
    assert!(broken.code == Some(1) && broken.stderr.contains("line 2"), "{broken:?}");
}

/// Rows of pixels, each with every layer, become the same files as the whole.
#[test]
fn parts_of_a_raw_image_become_the_whole() {
    let bench = camera_bench();
    let render = format!("render {SCENE} --camera-file small.toml --spp 2 --sky 1,1,1 --layers all --for lftoolbox");
    succeeds(&bench, &format!("{render} --out whole"));
    for part in 1..=3 {
        succeeds(&bench, &format!("{render} --shard {part}/3 --out part{part}"));
    }
    refused(&bench, "merge merged part1 part3", "2/3 missing");
    refused(&bench, &format!("{render} --shard 2/3 --out part1"), "another part");
    succeeds(&bench, "merge merged part2 part1 part3");
    assert_eq!(bench.bytes("merged"), bench.bytes("whole"));
    succeeds(&bench, "verify merged");

    // A part of another image.
    succeeds(&bench, &format!("{render} --seed 1 --shard 2/3 --out part2 --overwrite"));
    let outcome = bench.run("merge other part1 part2 part3");
    assert!(outcome.code == Some(1) && outcome.stderr.contains("parts of different images"), "{outcome:?}");
    assert!(!bench.path("other").exists());
}

/// Reconstruction and the estimate of its error: the map of the error, the numbers of the manifest, and parts that become
/// the whole.
#[test]
fn raw_images_are_denoised() {
    let bench = camera_bench();
    let render =
        format!("render {SCENE} --camera-file small.toml --spp 2 --sky 1,1,1 --denoise views --layers error,depth");
    succeeds(&bench, &format!("{render} --out whole"));
    let files = bench.list("whole");
    assert!(files.contains(&"raw_error.pfm".to_owned()) && files.contains(&"raw_depth.pfm".to_owned()), "{files:?}");
    succeeds(&bench, "verify whole");
    for part in 1..=2 {
        succeeds(&bench, &format!("{render} --shard {part}/2 --out part{part}"));
    }
    succeeds(&bench, "merge merged part1 part2");
    assert_eq!(bench.bytes("merged"), bench.bytes("whole"));
    // Another image than that of the plain samples.
    refused(
        &bench,
        &format!("render {SCENE} --camera-file small.toml --spp 2 --sky 1,1,1 --out whole"),
        "another image",
    );
}

/// Frames of an animation as raw images: a folder each, with the exposure of the first, in any parts.
#[test]
fn a_plenoptic_camera_films() {
    let bench = camera_bench();
    succeeds(&bench, "scene pendulum");
    let render = "render pendulum.glb --camera-file small.toml --spp 2 --write raw,raw-png --quiet";
    succeeds(&bench, &format!("{render} --frame 4-6 --out film"));
    for part in ["2/2", "1/2"] {
        succeeds(&bench, &format!("{render} --frame 4-6 --shard {part} --out parts"));
    }
    assert!(bench.bytes("film") == bench.bytes("parts"), "parts differ from the whole");
    let manifest = |frame: u32| Manifest::read(bench.path(format!("film/frame_{frame:04}/manifest.json"))).unwrap();
    let ev = manifest(4).exposure_ev.unwrap();
    assert_eq!((manifest(6).exposure_ev, manifest(6).settings["frame"].clone()), (Some(ev), 6_u32.into()));
    // One frame alone is exposed for itself, and otherwise the same.
    let raw = |folder: &str| std::fs::read(bench.path(format!("{folder}/raw_linear.png"))).unwrap();
    succeeds(&bench, &format!("{render} --frame 4 --out alone"));
    assert!(raw("alone") == raw("film/frame_0004") && raw("alone") != raw("film/frame_0006"));
    succeeds(&bench, &format!("{render} --frame 6 --exposure {ev} --out later"));
    assert!(raw("later") == raw("film/frame_0006"));
}

#[test]
fn impossible_requests_are_refused() {
    let bench = camera_bench();
    let render = |more: &str| format!("render {SCENE} --camera-file small.toml --out out {more}");
    refused(&bench, &render("--ground-truth all"), "`holo decode` adds those of the central view");
    refused(&bench, &render("--write el"), "raw-png");
    refused(&bench, &render("--layers visibility"), "--layers visibility");
    refused(&bench, &render("--integrator depth --layers error"), "error");
    refused(&bench, &render("--integrator depth --for lftoolbox"), "--for lftoolbox");
    refused(&bench, &render("--for matlab"), "lftoolbox, plenopticam");
    refused(&bench, &format!("render {SCENE} --out out --for lftoolbox"), "--camera-file");
    refused(&bench, &render("--shard 91/91"), "90 rows");
    let outcome = bench.run(&format!("render {SCENE} --camera-file lytro-ilum --out out"));
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("did you mean lytro-illum"), "{outcome:?}");
    // Micro-images between the light-sensitive squares of huge pixels.
    let dark = shifted_camera()
        .replace("size_px = [120, 90]", "size_px = [1, 1]\nfill = 0.01")
        .replace("f_number = 5.8", "f_number = 500.0");
    let dark = dark.replace("[7.0, -4.0]", "[35.0, 35.0]");
    std::fs::write(bench.path("dark.toml"), dark).unwrap();
    for command in [
        format!("render {SCENE} --camera-file dark.toml --out out"),
        "white --camera-file dark.toml --out out".into(),
        "target --camera-file dark.toml --square-mm 10 --out out".into(),
    ] {
        refused(&bench, &command, "no light reaches the sensor");
    }
    assert!(!bench.path("out").exists());
}

/// Corners against a projection through thin lenses, from the centers of the micro-images.
#[test]
fn corners_are_where_thin_lenses_image_them() {
    let bench = camera_bench();
    let poses = "[[pose]]\nposition_m = [0.0005, -0.0003, -0.35]\nrotation_deg = [20.0, 0.0, 0.0]\n";
    std::fs::write(bench.path("poses.toml"), poses).unwrap();
    succeeds(
        &bench,
        "target --camera-file small.toml --checkerboard 5x3 --square-mm 0.6 --poses poses.toml --spp 1 --out target",
    );
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = std::fs::read_to_string(bench.path("target").join(name)).unwrap();
        text.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect()
    };
    let centers: BTreeMap<[i64; 2], [f64; 2]> =
        rows("centers.csv").iter().map(|row| ([row[0] as i64, row[1] as i64], [row[2], row[3]])).collect();
    let (f, gap, pixel) = (0.04, 400e-6, 5e-6);
    let distance = 1.0 / (1.0 / f - 1.0 / 0.8);
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let mut seen = [false; 15];
    let corners = rows("corners.csv");
    for row in &corners {
        let cluster = row[5] as usize;
        let [x, y] = [(cluster % 5) as f64 - 2.0, 1.0 - (cluster / 5) as f64].map(|x| 0.0006 * x);
        let point = [0.0005 + x, -0.0003 + cos * y, -0.35 + sin * y];
        for k in 0..3 {
            assert!((row[7 + k] - point[k]).abs() < 1e-15, "{row:?} {point:?}");
        }
        // The image of the main lens, and of that through the microlens.
        let behind = 1.0 / (1.0 / f + 1.0 / point[2]);
        let image = [point[0], point[1]].map(|x| x * behind / -point[2]);
        let virtual_depth = (behind - distance) / gap;
        let [u, v] = centers[&[row[0] as i64, row[1] as i64]];
        let place = [(u + 0.5 - 60.0) * pixel, (45.0 - v - 0.5) * pixel];
        let lens = place.map(|x| x / (1.0 + gap / distance));
        let at = [0, 1].map(|k| lens[k] + (image[k] - lens[k]) / virtual_depth);
        let expected = [at[0] / pixel + 60.0 - 0.5, 45.0 - at[1] / pixel - 0.5];
        assert!((row[2] - expected[0]).abs() < 1e-9 && (row[3] - expected[1]).abs() < 1e-9, "{row:?} {expected:?}");
        seen[cluster] = true;
        assert_eq!((row[6], row[10], row[11]), (0.0, 0.0, 1.0));
    }
    assert!(seen.iter().all(|&seen| seen), "{seen:?} of {} lines", corners.len());
}
