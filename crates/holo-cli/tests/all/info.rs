//! `holo info` on every kind of file it knows, and on others.

use crate::common;
use crate::common::{Bench, SMALL};

fn info(bench: &Bench, arguments: &str) -> String {
    let outcome = bench.run(&format!("info {arguments}"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(!outcome.stdout.is_empty());
    outcome.stdout
}

/// Asserts that a text has all of these parts.
fn has(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no '{part}' in:\n{text}");
    }
}

#[test]
fn a_scene_and_the_rig_that_it_would_get() {
    let bench = Bench::new();
    let text = info(&bench, &format!("tiny.glb {SMALL}"));
    has(&text, &["8 in the world", "camera 'front'", "5 x 4 views of 12 x 8 px (raw image 60 x 32)", "disparity"]);
    has(&text, &["depth in the central view", "of 96 pixels see nothing"]);
    // The same options give the same rig when it is rendered.
    let rendered = bench.render("out", "").stderr;
    let rig = |text: &str| text.lines().find(|line| line.starts_with("rig:")).map(str::to_string).unwrap();
    assert_eq!(rig(&text), rig(&rendered));
    // Without options: the paper's sensor with 100 x 100 views.
    has(&info(&bench, "tiny.glb"), &["100 x 100 views of 79 x 53 px (raw image 7900 x 5300)"]);
    has(&info(&bench, "tiny.glb --focus-m inf"), &["focus at infinity"]);
}

#[test]
fn gltf_as_json() {
    let bench = Bench::new();
    let glb = std::fs::read(bench.path(common::SCENE)).unwrap();
    // The first chunk of a .glb is its JSON, the second its buffer; here the buffer becomes a file of its own.
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut json: serde_json::Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    json["buffers"][0]["uri"] = "data.bin".into();
    std::fs::write(bench.path("data.bin"), &glb[20 + length + 8..]).unwrap();
    std::fs::write(bench.path("scene.gltf"), json.to_string()).unwrap();
    assert_eq!(info(&bench, &format!("scene.gltf {SMALL}")), info(&bench, &format!("tiny.glb {SMALL}")));
}

#[test]
fn images_and_maps() {
    let bench = Bench::new();
    bench.render("out", "");
    bench.render("fine", "--bit-depth 16 --write el");
    let beside = "5 x 4 views of 12 x 8 px";
    has(
        &info(&bench, "out/scene_el.png"),
        &["PNG image, 60 x 32 pixels, 3 channels of 8 bits", "elemental images", beside],
    );
    has(&info(&bench, "out/scene_vpi.png"), &["PNG image, 60 x 32 pixels", "a grid of views", beside]);
    has(&info(&bench, "fine/scene_el.png"), &["3 channels of 16 bits"]);
    has(&info(&bench, "out/scene_disparity.png"), &["PNG image, 12 x 8 pixels, 1 channel of 8 bits"]);
    has(
        &info(&bench, "out/scene_depth.pfm"),
        &["PFM float image, 12 x 8 pixels", "finite values from", "infinite, 0 NaN"],
    );
    std::fs::copy(bench.path("out/scene_el.png"), bench.path("alone.png")).unwrap();
    assert_eq!(info(&bench, "alone.png"), "PNG image, 60 x 32 pixels, 3 channels of 8 bits\n");
}

#[test]
fn parameters_and_manifest() {
    let bench = Bench::new();
    bench.render("out", "");
    let rig = ["5 x 4 views of 12 x 8 px (raw image 60 x 32)", "sensor 36 mm", "px between adjacent views"];
    has(&info(&bench, "out/parameters.cfg"), &[&["camera parameters of 'tiny'"][..], &rig].concat());
    let text = info(&bench, "out/manifest.json");
    has(&text, &[&["holo ", "engine ", "exposure ", "scene_el.png", "parameters.cfg"][..], &rig].concat());
    for line in text.lines().filter(|line| line.contains(" bytes  ")) {
        let (bytes, name) = line.trim().split_once(" bytes  ").unwrap();
        let found = std::fs::metadata(bench.path("out").join(name)).unwrap().len();
        assert_eq!(bytes.parse::<u64>().unwrap(), found, "{name}");
    }
}

#[test]
fn other_files_are_named_as_such() {
    let bench = Bench::new();
    std::fs::write(bench.path("notes.txt"), "hello").unwrap();
    std::fs::write(bench.path("empty"), "").unwrap();
    std::fs::write(bench.path("other.json"), "{\"a\": 1}").unwrap();
    std::fs::write(bench.path("noise.glb"), [7; 300]).unwrap();
    for name in ["notes.txt", "empty", "other.json", "noise.glb"] {
        let outcome = bench.run(&format!("info {name}"));
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(1), ""), "{outcome:?}");
        has(&outcome.stderr, &[name, "not a file that holo knows", ".glb", "manifest.json"]);
    }
    let outcome = bench.run("info .");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    has(&outcome.stderr, &["folder", "manifest.json"]);
    let outcome = bench.run("info missing.png");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    has(&outcome.stderr, &["cannot read missing.png"]);
}

#[test]
fn damaged_files_are_errors() {
    let bench = Bench::new();
    bench.render("out", "");
    for name in ["out/scene_el.png", "out/scene_depth.pfm", "out/parameters.cfg", "out/manifest.json", "tiny.glb"] {
        let bytes = std::fs::read(bench.path(name)).unwrap();
        for keep in [bytes.len() / 2, 20] {
            std::fs::write(bench.path("cut"), &bytes[..keep]).unwrap();
            let outcome = bench.run("info cut");
            // A PNG's header may be whole where its pixels are not, and only the header is looked at.
            let allowed: &[i32] = if name.ends_with(".png") { &[0, 1] } else { &[1] };
            assert!(allowed.contains(&outcome.code.unwrap()), "{name} cut to {keep}: {outcome:?}");
            assert!(outcome.code == Some(0) || outcome.stderr.contains("cut"), "{name}: {outcome:?}");
            assert!(!outcome.stderr.contains("panicked"), "{name}: {outcome:?}");
        }
    }
}
