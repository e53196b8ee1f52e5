//! `holo dataset`: what is done stays done, whatever happens; parts make the whole; what is wrong is said.

use crate::common;
use std::process::Stdio;
use std::time::Duration;

use crate::common::{Bench, CAMERA, Outcome, SCENE};
use serde_json::Value;

/// Four jobs of a moment each: one scene, four view counts.
const SMALL: &str = "dataset --scenes none --glb tiny.glb --views 2,3,4x2,5 --sensor 60x40 --spp 2 --sky 0.2,0.3,0.4";

fn made(bench: &Bench, out: &str, more: &str) -> Outcome {
    let outcome = bench.run(&format!("{SMALL} --out {out} {more}"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    outcome
}

/// What the jobs came to: "made", "kept", "failed" in their order.
fn states(outcome: &Outcome) -> Vec<String> {
    let lines = outcome.stdout.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter_map(|line| Some(line.get("status")?.as_str()?.to_owned())).collect()
}

#[test]
fn a_dataset_has_the_folders_of_the_paper_and_tells_what_it_is() {
    let bench = Bench::new();
    let outcome = made(&bench, "set", "");
    assert!(outcome.stderr.contains("[ 1/4] tiny 2x2: ") && outcome.stderr.contains("4 made"), "{outcome:?}");
    let list = bench.list("set");
    let folders: Vec<&str> = list.iter().map(String::as_str).filter(|name| name.ends_with('/')).collect();
    assert_eq!(folders, ["tiny/", "tiny/2x2/", "tiny/3x3/", "tiny/4x2/", "tiny/5x5/"]);
    for file in common::DEFAULT_FILES {
        assert!(list.contains(&format!("tiny/4x2/{file}")), "{file}");
    }
    let index = holo_io::dataset::DatasetIndex::read(bench.path("set")).unwrap();
    assert_eq!(index.cameras.len(), 4);
    assert_eq!(index.options["spp"], "2");
    let page = std::fs::read_to_string(bench.path("set/DATASET.md")).unwrap();
    for part in ["| `tiny` |", "| `4x2` | 4x2 | 15x20 | 60x40 |", "CC0", "--spp=2"] {
        assert!(page.contains(part), "no '{part}' in {page}");
    }
    for option in ["--sensor-mm", "--projection"] {
        assert!(!page.contains(option), "`holo dataset` has no {option}");
    }
    let outcome = bench.run("verify set");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stdout.contains("4 folders with 32 files"), "{outcome:?}");
}

/// A preset sets the settings and the number of views of a dataset. An option of the command line replaces its own.
#[test]
fn a_preset_makes_a_dataset_like_those_of_a_benchmark() {
    let bench = Bench::new();
    let run = |more: &str| {
        let outcome = bench.run(&format!("dataset --scenes none --glb tiny.glb --spp 1 --preset hci --quiet {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
    };
    run("--out set --lenses 24x20");
    let list = bench.list("set/tiny/9x9");
    for file in
        ["scene_disparity.pfm", "scene_depth.pfm", "scene_hit_mask.png", "hci/input_Cam080.png", "masks/plane.png"]
    {
        assert!(list.contains(&file.to_owned()), "{file}: {list:?}");
    }
    assert!(!list.contains(&"scene_5d.mat".to_owned()), "a preset says what is written");
    let index = holo_io::dataset::DatasetIndex::read(bench.path("set")).unwrap();
    assert_eq!((index.options["disparity"].as_str(), index.options["lenses"].as_str()), ("-1.5,1.5", "24x20"));
    let manifest = std::fs::read_to_string(bench.path("set/tiny/9x9/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    assert!(manifest["settings"]["preset"]["hci"].is_object(), "{manifest}");
    // One of the render has the same pixels.
    let outcome = bench.run("render tiny.glb --spp 1 --preset hci --lenses 24x20 --out one --quiet");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    for file in ["scene_disparity.pfm", "hci/input_Cam040.png"] {
        let read = |folder: &str| std::fs::read(bench.path(format!("{folder}/{file}"))).unwrap();
        assert!(read("one") == read("set/tiny/9x9"), "{file}");
    }
    // Whoever gives views or a sensor wants those.
    run("--out other --views 2,3 --sensor 60x40");
    let folders = bench.list("other");
    assert!(folders.contains(&"tiny/2x2/".to_owned()) && folders.contains(&"tiny/3x3/".to_owned()), "{folders:?}");
    assert!(!folders.contains(&"tiny/9x9/".to_owned()), "{folders:?}");
}

#[test]
fn what_is_done_is_kept_and_a_changed_setting_redoes_what_it_touches() {
    let bench = Bench::new();
    assert_eq!(states(&made(&bench, "set", "--json --quiet")), ["made"; 4]);
    let first = bench.bytes("set");
    assert_eq!(states(&made(&bench, "set", "--json --quiet --threads 1")), ["kept"; 4], "threads decide nothing");
    assert!(bench.bytes("set") == first);
    // One view count more.
    let more = SMALL.replace("2,3,4x2,5", "2,3,6,4x2,5");
    let outcome = bench.run(&format!("{more} --out set --json --quiet"));
    assert_eq!(states(&outcome), ["kept", "kept", "made", "kept", "kept"], "{outcome:?}");
    // A file that is gone, a file that is damaged.
    std::fs::remove_file(bench.path("set/tiny/2x2/scene_el.png")).unwrap();
    std::fs::write(bench.path("set/tiny/5x5/scene_depth.pfm"), b"Pf\n1 1\n-1\n0000").unwrap();
    assert_eq!(states(&made(&bench, "set", "--json --quiet")), ["made", "kept", "kept", "made"]);
    std::fs::remove_dir_all(bench.path("set/tiny/6x6")).unwrap();
    assert!(bench.bytes("set") == first);
    // Other settings: all of it, and nothing of the old files stays.
    assert_eq!(states(&made(&bench, "set", "--json --quiet --write el,depth")), ["made"; 4]);
    assert!(!bench.list("set").iter().any(|name| name.contains("scene_5d.mat") || name.contains(".old")));
    assert_eq!(states(&made(&bench, "set", "--json --quiet --write el,depth --seed 1")), ["made"; 4]);
    // Another scene of the same name.
    std::fs::copy(bench.path(SCENE), bench.path("other.glb")).unwrap();
    let glb = holo_scene::gltf::to_glb(&holo_scene::gallery::scene("plaster").unwrap()).unwrap();
    std::fs::write(bench.path(SCENE), glb).unwrap();
    assert_eq!(states(&made(&bench, "set", "--json --quiet --write el,depth --seed 1")), ["made"; 4]);
}

/// The catalog of finished folders, and the same as archives for training.
#[test]
fn a_dataset_is_described_and_packed() {
    let bench = Bench::new();
    made(&bench, "set", "--quiet --layers depth,disparity,visibility --denoise views");
    let table = std::fs::read_to_string(bench.path("set/light_fields.csv")).unwrap();
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let (names, first) = (lines.next().unwrap(), lines.next().unwrap());
    let value = |name: &str| first[names.iter().position(|own| *own == name).unwrap()];
    assert_eq!((lines.count(), value("folder"), value("view_columns")), (3, "tiny/2x2", "2"));
    for part in ["seen_by_all_views", "error_median", "mean_red", "deviation_blue", "depth_median_m"] {
        let number: f64 = value(part).parse().unwrap();
        assert!(number > 0.0, "{part}: {number}");
    }
    let again = made(&bench, "set", "--layers depth,disparity,visibility --denoise views");
    let median = format!("{:.2} %", 100.0 * value("error_median").parse::<f64>().unwrap());
    assert!(again.stderr.contains(&median), "{median}: {again:?}");
    let visibility = holo_io::read_pfm(bench.path("set/tiny/5x5/scene_visibility.pfm"), &Default::default()).unwrap();
    assert!(visibility.values.iter().all(|part| (0.04..=1.0).contains(part)));
    let train = std::fs::read_to_string(bench.path("set/train.txt")).unwrap();
    assert_eq!(train, "tiny/2x2\ntiny/3x3\ntiny/4x2\ntiny/5x5\n");
    // Each view count has a sheet, until a dataset without it.
    assert!(bench.path("set/contact_sheet_4x2.png").is_file());
    let outcome = bench.run(&format!("{} --out set --quiet", SMALL.replace("4x2,", "")));
    assert_eq!((outcome.code, bench.path("set/contact_sheet_4x2.png").exists()), (Some(0), false), "{outcome:?}");

    // Another dataset in the same folder: nothing of the catalog before is left, and what is missing is said.
    made(&bench, "set", "--quiet --shard 1/4");
    assert!(!bench.list("set").iter().any(|name| name.contains("croissant") || name.contains("contact_sheet")));
    let outcome = bench.run("pack set --out early --fields el.png");
    assert!(outcome.stderr.contains("note: 3 of 4 light fields are finished"), "{outcome:?}");
    made(&bench, "set", "--quiet");
    let outcome = bench.run("pack set --out archives --fields el.png,disparity.pfm");
    assert_eq!((outcome.code, bench.list("archives")), (Some(0), vec!["train-000000.tar".to_owned()]), "{outcome:?}");
    assert!(outcome.stderr.contains("train-000000.tar: 4 light fields"), "{outcome:?}");
    let outcome = bench.run("pack set --out archives");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("exists already"), "{outcome:?}");
    let outcome = bench.run("pack nothing --out other");
    assert_eq!((outcome.code, bench.path("other").exists()), (Some(2), false), "{outcome:?}");
}

#[test]
fn plenoptic_cameras_make_datasets_of_raw_images() {
    let bench = Bench::new();
    std::fs::write(bench.path("small.toml"), CAMERA).unwrap();
    std::fs::copy(bench.path(SCENE), bench.path("other.glb")).unwrap();
    let scenes = "dataset --scenes none --glb tiny.glb,other.glb --spp 2 --sky 0.2,0.3,0.4 --layers depth";
    let run = |more: &str| {
        let outcome = bench.run(&format!("{scenes} --json {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome
    };
    let outcome = run("--camera-file small.toml --out set");
    assert_eq!(states(&outcome), ["made"; 2]);
    assert!(outcome.stderr.contains("[ 1/2] tiny small: "), "{outcome:?}");
    let line: Value = serde_json::from_str(outcome.stdout.lines().next().unwrap()).unwrap();
    assert_eq!((line["camera"].as_str(), line.get("views")), (Some("small"), None));
    let list = bench.list("set");
    for file in
        ["camera.toml", "raw.exr", "raw_linear.png", "raw_depth.pfm", "white.png", "centers.csv", "manifest.json"]
    {
        assert!(list.contains(&format!("other/small/{file}")), "{file}");
    }
    assert!(list.contains(&"contact_sheet_small.png".to_owned()));
    let table = std::fs::read_to_string(bench.path("set/light_fields.csv")).unwrap();
    assert!(table.starts_with("folder,scene,split,camera,sensor_columns,sensor_rows,depth_min_m,"), "{table}");
    assert!(table.lines().nth(2).unwrap().starts_with("other/small,other,train,small,60,45,"), "{table}");
    let page = std::fs::read_to_string(bench.path("set/DATASET.md")).unwrap();
    assert!(page.contains("--camera-file tiny/small/camera.toml"), "{page}");
    let verified = bench.run("verify set");
    assert!(verified.code == Some(0) && verified.stdout.contains("2 folders with "), "{verified:?}");
    assert!(bench.run("info set").stdout.contains("folder of 2 datasets"));
    let packed = bench.run("pack set --out archives --fields raw.exr,camera.toml");
    assert!(packed.stderr.contains("train-000000.tar: 2 "), "{packed:?}");

    // The same, from the camera of a folder, and in parts.
    assert_eq!(states(&run("--camera-file set/tiny/small/camera.toml --out set --quiet")), ["kept"; 2]);
    for part in ["2/2", "1/2"] {
        run(&format!("--camera-file small.toml --out parts --quiet --shard {part}"));
    }
    assert!(bench.bytes("set") == bench.bytes("parts"));
    // Another camera of the same name; another dataset, without the contact sheet of the first.
    assert_eq!(states(&run("--camera-file small.toml --f-number 8 --out set --quiet")), ["made"; 2]);
    run("--views 3 --sensor 60x40 --out set --quiet");
    let list = bench.list("set");
    assert!(
        !list.contains(&"contact_sheet_small.png".to_owned()) && list.contains(&"tiny/3x3/".to_owned()),
        "{list:?}"
    );
    let verified = bench.run("verify set");
    assert!(verified.stdout.contains("small: note: not part of this dataset"), "{verified:?}");
}

#[test]
fn poses_are_scenes_of_a_dataset() {
    let bench = Bench::new();
    let frame = |name: &str, x: f64| {
        let rows = [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        serde_json::json!({ "file_path": format!("{name}.png"), "transform_matrix": rows })
    };
    let file =
        serde_json::json!({ "fl_x": 14.0, "w": 12, "h": 8, "frames": [frame("left", -0.1), frame("right", 0.1)] });
    std::fs::create_dir(bench.path("etc")).unwrap();
    std::fs::write(bench.path("etc/poses.json"), file.to_string()).unwrap();
    std::fs::write(bench.path("small.toml"), CAMERA).unwrap();
    let scenes = "dataset --scenes none --glb tiny.glb --spp 2 --sky 0.2,0.3,0.4";
    let rig = format!("{scenes} --views 3,4x2 --transforms etc/poses.json --transforms-up y");
    let outcome = bench.run(&format!("{rig} --out set --json"));
    assert_eq!((outcome.code, states(&outcome)), (Some(0), vec!["made".to_owned(); 4]), "{outcome:?}");
    let list = bench.list("set");
    for folder in ["tiny_left/3x3/", "tiny_left/4x2/", "tiny_right/3x3/", "tiny_right/4x2/"] {
        assert!(list.contains(&folder.to_owned()), "{folder}: {list:?}");
    }
    let train = std::fs::read_to_string(bench.path("set/train.txt")).unwrap();
    assert_eq!(train, "tiny_left/3x3\ntiny_left/4x2\ntiny_right/3x3\ntiny_right/4x2\n");
    let page = std::fs::read_to_string(bench.path("set/DATASET.md")).unwrap();
    for part in ["--glb tiny.glb \\", "--transforms transforms.json --transforms-up y", "from 2 poses"] {
        assert!(page.contains(part), "no '{part}' in {page}");
    }
    assert_eq!(bench.run("verify set").code, Some(0));
    // The same from the copy of the poses, and from a file of options.
    let copy = rig.replace("etc/poses.json", "set/transforms.json");
    assert_eq!(states(&bench.run(&format!("{copy} --out set --json --quiet"))), ["kept"; 4]);
    let options = "transforms = \"poses.json\"\ntransforms-up = \"y\"\nviews = [3, \"4x2\"]\n";
    std::fs::write(bench.path("etc/set.toml"), options).unwrap();
    let outcome = bench.run(&format!("{scenes} --config etc/set.toml --out set --json --quiet"));
    assert_eq!(states(&outcome), ["kept"; 4], "{outcome:?}");
    // A plenoptic camera at the same poses.
    let raw =
        format!("{scenes} --camera-file small.toml --transforms etc/poses.json --transforms-up y --out raw --quiet");
    assert_eq!(bench.run(&raw).code, Some(0));
    assert!(bench.list("raw").contains(&"tiny_right/small/raw.exr".to_owned()));
    for (more, part) in [("--sensor 60x40", "--sensor"), ("--camera-file small.toml", "--camera-file")] {
        let outcome = bench.run(&format!("{rig} --out other {more}"));
        assert!(outcome.code == Some(2) && outcome.stderr.contains(part), "{more}: {outcome:?}");
    }
    assert!(!bench.path("other").exists());
    // Without poses views may have a size, too.
    let outcome = bench.run(&format!("{scenes} --lenses 12x8 --views 2,3 --out sized --quiet"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    for views in ["2x2", "3x3"] {
        let disparity = bench.path(format!("sized/tiny/{views}/scene_disparity.pfm"));
        assert_eq!(holo_io::read_pfm(disparity, &holo_io::Limits::default()).unwrap().values.dim(), (8, 12, 1));
    }
}

#[test]
fn what_is_to_be_known_is_said_once() {
    let bench = Bench::new();
    let mut blind = common::tiny_scene();
    blind.cameras.clear();
    std::fs::write(bench.path("blind.glb"), holo_scene::gltf::to_glb(&blind).unwrap()).unwrap();
    let run = |out: &str, more: &str| {
        let mut command = bench.command(&format!("{SMALL} --glb blind.glb --out {out} {more}"));
        command.env("HOLO_EMBREE_LIB", "/nonexistent/libembree4.so");
        let outcome = common::outcome(command);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome
    };
    let outcome = run("set", "");
    // Eight jobs: two scenes, of which one has no camera; four view counts, of which 3 x 3 leaves a row of 40.
    for once in ["built-in BVH", "blind: warning: no camera", "note: 3 x 3 views leave 0 columns and 1 rows"] {
        assert_eq!(outcome.stderr.matches(once).count(), 1, "'{once}' in {outcome:?}");
    }
    assert_eq!(run("set", "--quiet").stderr, "");
    // Of what is done already there is nothing to say but what draws it.
    let again = run("set", "");
    assert!(again.stderr.contains("built-in BVH") && !again.stderr.contains("blind: warning"), "{again:?}");
}

#[test]
fn shards_make_the_whole() {
    let bench = Bench::new();
    made(&bench, "whole", "--quiet");
    for part in [2, 3, 1] {
        made(&bench, "shards", &format!("--quiet --shard {part}/3"));
    }
    assert!(bench.bytes("whole") == bench.bytes("shards"));
    assert_eq!(bench.run("verify shards").code, Some(0));
}

#[test]
fn a_run_that_is_killed_goes_on_to_the_same_bytes() {
    let bench = Bench::new();
    made(&bench, "undisturbed", "--quiet");
    let expected = bench.bytes("undisturbed");
    // How long a run takes, about: other work on the machine changes it by times.
    let mut seconds = made(&bench, "timed", "--quiet").took.as_secs_f64();
    let (mut state, mut unfinished) = (1_u64, 0);
    for number in 0..50 {
        let mut command = bench.command(&format!("{SMALL} --out killed --quiet"));
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        std::thread::sleep(Duration::from_secs_f64(seconds * (state >> 11) as f64 / (1_u64 << 53) as f64));
        child.kill().unwrap();
        child.wait().unwrap();
        let begun = bench.path("killed").is_dir();
        let whole = begun && bench.bytes("killed") == expected;
        unfinished += usize::from(begun && !whole);
        // Too late to disturb anything, or too early.
        seconds *= if whole { 0.8 } else { 1.02 };
        if number % 5 == 4 {
            made(&bench, "killed", "--quiet");
            assert!(bench.bytes("killed") == expected, "after {number} kills");
        }
        // What is whole cannot be disturbed any more.
        if whole || number % 5 == 4 {
            std::fs::remove_dir_all(bench.path("killed")).unwrap();
        }
    }
    println!("50 kills, {unfinished} in the middle");
    assert!(unfinished >= 10, "{unfinished}: most kills came too early or too late to show anything");
}

#[test]
fn a_job_that_fails_does_not_stop_the_others() {
    let bench = Bench::new();
    std::fs::write(bench.path("broken.glb"), b"glTF and nothing more").unwrap();
    let outcome = bench.run(&format!("{} --out set --json", SMALL.replace("tiny.glb", "broken.glb,tiny.glb")));
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert_eq!(states(&outcome), ["failed", "failed", "failed", "failed", "made", "made", "made", "made"]);
    assert!(outcome.stderr.contains("4 of 8 jobs failed") && outcome.stderr.contains("broken.glb"), "{outcome:?}");
    let verified = bench.run("verify set");
    assert_eq!(verified.code, Some(1));
    assert!(verified.stderr.contains("4 of 8 folders"), "{verified:?}");
    assert!(verified.stdout.contains("broken/2x2: "), "{verified:?}");
}

#[test]
fn verify_finds_what_is_missing_damaged_or_of_another_dataset() {
    let bench = Bench::new();
    made(&bench, "set", "--quiet");
    made(&bench, "other", "--quiet --seed 5");
    let check = |part: &str| {
        let outcome = bench.run("verify set");
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stdout.contains(part) && outcome.stdout.starts_with("tiny/3x3: "), "{outcome:?}");
    };
    let whole = std::fs::read(bench.path("set/tiny/3x3/scene_vpi.png")).unwrap();
    std::fs::write(bench.path("set/tiny/3x3/scene_vpi.png"), &whole[..whole.len() - 1]).unwrap();
    check("scene_vpi.png");
    std::fs::remove_dir_all(bench.path("set/tiny/3x3")).unwrap();
    check("cannot open set/tiny/3x3");
    std::fs::rename(bench.path("other/tiny/3x3"), bench.path("set/tiny/3x3")).unwrap();
    check("--seed=5");
}

#[test]
fn wrong_use_is_said_before_anything_is_made() {
    let bench = Bench::new();
    std::fs::write(bench.path("bad.toml"), "scens = [\"garden\"]\n").unwrap();
    for (arguments, part) in [
        ("dataset", "--out"),
        ("dataset --out set --scenes teapot", "no scene 'teapot'"),
        ("dataset --out set --scenes garden,garden", "two scenes have the name 'garden'"),
        ("dataset --out set --scenes none", "--glb"),
        ("dataset --out set --views 20,20x20", "twice"),
        ("dataset --out set --splits 0", "COLUMNSxROWS"),
        ("dataset --out set --sensor 10x10 --scenes garden", "too small"),
        ("dataset --out set --shard 4/3", "part 2 of 3"),
        ("dataset --out set --config bad.toml", "'--scenes'"),
        ("dataset --out set --integrator depth --write el", "--integrator depth renders no color"),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(part), "{arguments}: {outcome:?}");
        assert!(!bench.path("set").exists(), "{arguments}");
    }
    let outcome = bench.run("dataset --out set --scenes none --glb missing.glb");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("missing.glb"), "{outcome:?}");
}

#[test]
fn a_file_of_options_is_the_same_as_the_command_line() {
    let bench = Bench::new();
    made(&bench, "by_line", "--quiet");
    std::fs::create_dir(bench.path("etc")).unwrap();
    std::fs::write(
        bench.path("etc/set.toml"),
        "out = \"../by_file\"\nscenes = \"none\"\nglb = \"../tiny.glb\"\nsplits = [2, 3, \"4x2\", 5]\nsensor = \"60x40\"\n\
         spp = 2\nsky = [0.2, 0.3, 0.4]\nquiet = true\n",
    )
    .unwrap();
    let outcome = bench.run("dataset --config etc/set.toml");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
    assert!(bench.bytes("by_line") == bench.bytes("by_file"));
}
