//! `--json` and `--quiet`: what programs read, and silence.

use crate::common;
use crate::common::{Bench, DEFAULT_FILES};
use serde_json::Value;

/// The keys of an object, sorted.
fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

#[test]
fn one_object_with_every_promised_key() {
    let bench = Bench::new();
    let outcome = bench.render("out", "--json --threads 2 --spp 3");
    // Parsing the whole of it shows that nothing stands before or after the object.
    let report: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(
        keys(&report),
        [
            "backend",
            "disparity_px",
            "files",
            "integrator",
            "peak_rss_bytes",
            "rays",
            "rig",
            "samples",
            "seconds",
            "statistics",
            "threads",
            "warnings"
        ]
    );
    assert_eq!(keys(&report["seconds"]), ["build", "load", "render", "total", "write"]);
    let seconds = |name: &str| report["seconds"][name].as_f64().unwrap();
    let parts: f64 = ["load", "build", "render", "write"].map(seconds).iter().sum();
    assert!(seconds("render") > 0.0 && parts <= seconds("total") + 1e-9, "{report}");

    assert_eq!(keys(&report["rays"]), ["other", "primary", "shadow"]);
    assert_eq!(report["samples"], 12 * 8 * 5 * 4 * 3);
    assert!(report["rays"]["primary"].as_u64() >= report["samples"].as_u64(), "{report}");
    assert!(report["rays"]["shadow"].as_u64() > Some(0) && report["rays"]["other"].is_u64());

    let backend = report["backend"].as_str().unwrap();
    assert!(backend == "bvh" || backend.starts_with("embree 4."), "{backend}");
    assert_eq!(report["threads"], 2);
    if cfg!(target_os = "linux") {
        assert!(report["peak_rss_bytes"].as_u64() > Some(1 << 20));
    }
    assert_eq!(report["integrator"]["name"], "path");
    assert!(!report["integrator"]["why"].as_str().unwrap().is_empty());

    let rig = &report["rig"];
    assert_eq!(keys(rig), ["baseline_m", "focal_length_mm", "focus_distance_m", "lenses", "sensor_size_mm", "views"]);
    assert_eq!(rig["views"], serde_json::json!({"columns": 5, "rows": 4}));
    assert_eq!(rig["lenses"], serde_json::json!({"columns": 12, "rows": 8}));
    assert_eq!(rig["sensor_size_mm"], 36.0);
    assert!(rig["baseline_m"]["x"].as_f64() > Some(0.0) && rig["baseline_m"]["x"] == rig["baseline_m"]["y"]);
    assert!((0.9..2.1).contains(&rig["focus_distance_m"].as_f64().unwrap()));

    let range = |end: &str| report["disparity_px"][end].as_f64().unwrap();
    assert!(range("min") < 0.0 && range("max") > 0.0, "the focus lies between the quads: {report}");
    let mut files: Vec<&str> = report["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    files.sort_unstable();
    assert_eq!(files, DEFAULT_FILES);
}

#[test]
fn a_focus_at_infinity_is_still_json() {
    let bench = Bench::new();
    let outcome = bench.render("out", "--json --focus-m inf");
    let report: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(report["rig"]["focus_distance_m"], "inf");
    assert_eq!(report["disparity_px"]["min"], 0.0, "infinity does not move");
}

#[test]
fn without_json_nothing_is_on_standard_output() {
    let bench = Bench::new();
    let outcome = bench.render("out", "");
    assert_eq!(outcome.stdout, "");
    assert!(outcome.stderr.contains("9 files to out"), "{outcome:?}");
    assert!(!outcome.stderr.contains('\x1b') && !outcome.stderr.contains('\r'), "no bar where no terminal is");
}

#[test]
fn quiet_is_silent() {
    let bench = Bench::new();
    // A scene without camera and light, a sensor with a rest: all that is otherwise remarked upon.
    let mut scene = common::tiny_scene();
    scene.cameras.clear();
    scene.lights.clear();
    std::fs::write(bench.path("bare.glb"), holo_scene::gltf::to_glb(&scene).unwrap()).unwrap();
    let arguments = "render bare.glb --out out --sensor 61x33 --views 5x4";
    let loud = bench.run(arguments);
    assert!(loud.stderr.contains("note:") && loud.stderr.contains("warning:"), "{loud:?}");
    let quiet = bench.run(&format!("{arguments} --quiet"));
    assert_eq!((quiet.code, quiet.stdout.as_str(), quiet.stderr.as_str()), (Some(0), "", ""));
    let outcome = bench.render("out", "--quiet --json --overwrite");
    assert_eq!(outcome.stderr, "");
    assert!(serde_json::from_str::<Value>(&outcome.stdout).unwrap().is_object());
}

#[test]
fn an_output_that_nobody_reads_is_no_panic() {
    let bench = Bench::new();
    if !std::path::Path::new("/dev/full").exists() {
        eprintln!("not run: needs /dev/full");
        return;
    }
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = bench.command("scene");
    command.stdout(full());
    let outcome = common::outcome(command);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("standard output"), "{outcome:?}");
    // Standard error is where complaints go: it alone cannot fail a run.
    let mut command = bench.command(&format!("render {} --out out {}", common::SCENE, common::SMALL));
    command.stderr(full());
    assert_eq!(common::outcome(command).code, Some(0));
    // `holo info x | head -0`: the reader is gone before the first line.
    let mut child = bench.command("info tiny.glb").stdout(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
