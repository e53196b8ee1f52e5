//! `--subset`: some of the views of a rig.

use crate::common;
use crate::common::Bench;

const SMALL: &str = "render tiny.glb --lenses 18x12 --views 5x4 --spp 2 --exposure 0.5 --sky 0.2,0.3,0.4";

/// The files of views in `folder/hci`.
fn views(bench: &Bench, folder: &str) -> Vec<String> {
    let files = bench.list(&format!("{folder}/hci")).into_iter();
    files.filter(|name| name.starts_with("input_Cam")).collect()
}

#[track_caller]
fn run(bench: &Bench, line: &str) -> common::Outcome {
    let outcome = bench.run(line);
    assert_eq!(outcome.code, Some(0), "{line}: {outcome:?}");
    outcome
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
        "depth s/hci --out d.pfm",
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
