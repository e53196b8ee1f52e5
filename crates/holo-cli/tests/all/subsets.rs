//! `--subset`: some of the views of a rig.

use crate::common::{Bench, run};

const SMALL: &str = "render tiny.glb --lenses 18x12 --views 5x4 --spp 2 --exposure 0.5 --sky 0.2,0.3,0.4";

/// The files of views in `folder/hci`.
fn views(bench: &Bench, folder: &str) -> Vec<String> {
    let files = bench.list(&format!("{folder}/hci")).into_iter();
    files.filter(|name| name.starts_with("input_Cam")).collect()
}

#[test]
fn a_subset_has_the_bytes_of_the_whole() {
    let bench = Bench::new();
    run(&bench, &format!("{SMALL} --out whole --write hci --reuse off"));
    assert_eq!(views(&bench, "whole").len(), 20);
    for (subset, expected) in [
        // The central view of 5 x 4 is column 2, row 2.
        ("cross", vec![2, 7, 10, 11, 12, 13, 14, 17]),
        ("star", vec![0, 2, 4, 6, 7, 8, 10, 11, 12, 13, 14, 16, 17, 18]),
        ("4,3;0,0;4,3", vec![0, 19]),
    ] {
        let out = format!("s{}", expected.len());
        run(&bench, &format!("{SMALL} --out {out} --subset {subset}"));
        let names: Vec<String> = expected.iter().map(|k| format!("input_Cam{k:03}.png")).collect();
        assert_eq!(views(&bench, &out), names, "{subset}");
        let read = |folder: &str, name: &str| std::fs::read(bench.path(format!("{folder}/{name}"))).unwrap();
        for name in names.iter().map(|name| format!("hci/{name}")) {
            assert!(read(&out, &name) == read("whole", &name), "{subset}: {name}");
        }
        assert_eq!(read(&out, "parameters.cfg"), read("whole", "parameters.cfg"));
        run(&bench, &format!("verify {out}"));
    }
    // One row of views is an ordinary rig.
    run(&bench, &format!("{SMALL} --out row --write vpi,el,hci").replace("5x4", "7x1"));
    assert_eq!(views(&bench, "row").len(), 7);
    run(&bench, "extract row --view 6,0 --out view.png");
}

/// What needs all views says so, and names the first that is missing.
#[test]
fn tools_for_whole_grids_refuse_a_subset() {
    let bench = Bench::new();
    run(&bench, &format!("{SMALL} --out s --subset cross"));
    for line in [
        "refocus s/hci --distance-m 1 --out r.png",
        "extract s/hci --view 0,0 --out v.png",
        "view s/hci --out v.html",
        "animate s/hci --out a.png",
        "quilt s/hci --tiles 2x2 --out q.png",
        "remap s/hci e_el.png",
        "epi s/hci --row 2,2 --out e.png",
    ] {
        let outcome = bench.run(line);
        assert_eq!(outcome.code, Some(1), "{line}: {outcome:?}");
        let words = ["input_Cam000.png", "row 0, column 0", "5 x 4"];
        assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{line}: {outcome:?}");
    }
    // The folder above says what it holds.
    let outcome = bench.run("refocus s --distance-m 1 --out r.png");
    assert!(outcome.code == Some(1) && outcome.stderr.contains("no raw image"), "{outcome:?}");
}

/// Depth from a cross is that from the cross of all views, whichever folder has it, and it is right.
#[test]
fn depth_is_estimated_from_some_of_the_views() {
    let bench = Bench::new();
    run(&bench, "scene tiles --out tiles.glb");
    let render =
        "render tiles.glb --views 7 --lenses 72x48 --spp 16 --integrator direct --disparity -1,1 --exposure 0 --quiet";
    run(&bench, &format!("{render} --write el,disparity --out whole"));
    let score = |map: &str| {
        let outcome = bench.run(&format!("eval {map} whole/scene_disparity.pfm --border 8 --json"));
        let scores: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
        scores["bad_pixels_0.07_percent"].as_f64().unwrap_or_else(|| panic!("{scores}"))
    };
    run(&bench, "depth whole --effort fast --out all.pfm");
    let all = score("all.pfm");
    for subset in ["cross", "star", "3,3;0,0;6,0;0,6;6,6;2,5"] {
        run(&bench, &format!("{render} --subset {subset} --out some --overwrite"));
        run(&bench, &format!("depth whole --effort fast --subset {subset} --out whole.pfm"));
        let read = |name: &str| std::fs::read(bench.path(name)).unwrap();
        let folders: &[&str] = if subset == "star" { &["some", "some/hci"] } else { &["some/hci"] };
        for folder in folders {
            run(&bench, &format!("depth {folder} --effort fast --out some.pfm"));
            assert!(read("some.pfm") == read("whole.pfm"), "{subset}: {folder}");
        }
        let bad = score("some.pfm");
        println!("{subset}: {bad}");
        // As good as from all views: small images, whose edges are many.
        assert!(bad < all + 3.0, "{subset}: {bad} {all}");
    }
    // A part of what a folder has is the same part of all views.
    run(&bench, &format!("{render} --subset star --out some --overwrite"));
    run(&bench, "depth some --effort fast --subset cross --out some.pfm");
    run(&bench, "depth whole --effort fast --subset cross --out whole.pfm");
    assert!(std::fs::read(bench.path("some.pfm")).unwrap() == std::fs::read(bench.path("whole.pfm")).unwrap());
    // By depth instead of disparity.
    run(&bench, "depth whole --effort fast --subset cross --depths-m 0.5,inf --out d.pfm");
    for (line, part) in [
        (
            "depth whole --subset 0,0;6,6 --out d.pfm",
            "the view in column 3, row 3, whose disparity is estimated, is not among the views",
        ),
        ("depth whole --subset ring --out d.pfm", "star"),
        ("depth whole --camera a --out d.pfm", "no transforms.json"),
        ("depth whole --range -1,1 --depths-m 1,2 --out d.pfm", "cannot be used with"),
    ] {
        let outcome = bench.run(line);
        assert!(outcome.code == Some(2) && outcome.stderr.contains(part), "{line}: {outcome:?}");
    }
}

#[test]
fn wrong_use_is_said() {
    let bench = Bench::new();
    for (more, part) in [
        ("--subset ring", "star"),
        ("--subset 5,0", "5,0"),
        ("--subset cross --write el", "el"),
        ("--subset cross --denoise views", "--denoise"),
        ("--subset cross --layers color", "color"),
        ("--subset cross --ground-truth all", "--ground-truth"),
        ("--subset cross --shard 1/2", "--shard"),
    ] {
        let outcome = bench.run(&format!("{SMALL} --out o {more}"));
        assert!(outcome.code == Some(2) && outcome.stderr.contains(part), "{more}: {outcome:?}");
        assert!(!bench.path("o").exists(), "{more}");
    }
}
