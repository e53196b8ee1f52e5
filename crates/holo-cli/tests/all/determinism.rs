//! Equal inputs give equal bytes: for any number of threads, in any folder, again and again.

use crate::common;
use std::collections::BTreeMap;

use crate::common::Bench;

/// Every file of a render, the manifest and the parameters included.
fn rendered(bench: &Bench, out: &str, more: &str) -> BTreeMap<String, Vec<u8>> {
    bench.render(out, more);
    bench.bytes(out)
}

/// Settings that use random numbers: a sky, and several samples a pixel.
const NOISY: &str = "--sky 0.3,0.4,0.6 --spp 3 --ground-truth all";

#[test]
fn neither_threads_nor_folders_show_in_the_bytes() {
    let bench = Bench::new();
    let first = rendered(&bench, "one", &format!("{NOISY} --threads 1"));
    assert_eq!(first.len(), 9 + 2 * 20);
    for (out, threads) in [("two", 2), ("some/where/else", 5), ("one", 1)] {
        let again = rendered(&bench, out, &format!("{NOISY} --threads {threads}"));
        for (name, bytes) in &first {
            assert!(again[name] == *bytes, "{name} differs in {out} with {threads} threads");
        }
        assert_eq!(again.len(), first.len());
    }
}

#[test]
fn the_name_of_the_scene_changes_only_what_names_it() {
    let bench = Bench::new();
    let first = rendered(&bench, "one", NOISY);
    std::fs::create_dir(bench.path("folder")).unwrap();
    std::fs::copy(bench.path(common::SCENE), bench.path("folder/tiny.glb")).unwrap();
    let moved = bench.run(&format!("render folder/tiny.glb --out two {} {NOISY}", common::SMALL));
    assert_eq!(moved.code, Some(0), "{moved:?}");
    assert!(bench.bytes("two") == first, "the folder of the scene shows");
}

#[test]
fn the_built_in_engine_repeats_itself() {
    let bench = Bench::new();
    let first = rendered(&bench, "one", &format!("{NOISY} --backend bvh --threads 2"));
    let again = rendered(&bench, "two", &format!("{NOISY} --backend bvh --threads 1"));
    assert!(first == again);
    let manifest = String::from_utf8(first["manifest.json"].clone()).unwrap();
    assert!(manifest.contains("\"engine\": \"bvh\""), "{manifest}");
}

#[test]
fn the_seed_chooses_the_noise() {
    let bench = Bench::new();
    let (zero, one) = (rendered(&bench, "zero", NOISY), rendered(&bench, "one", &format!("{NOISY} --seed 1")));
    assert!(zero["scene_el.png"] != one["scene_el.png"], "another seed, other noise");
    assert!(zero["scene_depth.pfm"] == one["scene_depth.pfm"], "ground truth has no noise");
}

#[test]
fn several_seeds_are_the_renders_of_each() {
    let bench = Bench::new();
    let render = format!("render {} {} {NOISY} --quiet", common::SCENE, common::SMALL);
    let outcome = bench.run(&format!("{render} --seeds 1-2 --out seeds"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let two = rendered(&bench, "two", &format!("{NOISY} --seed 2"));
    assert!(bench.bytes("seeds/seed_2") == two, "as by --seed 2");
    assert!(bench.bytes("seeds/seed_1")["scene_el.png"] != two["scene_el.png"], "another seed, other noise");
    assert!(!bench.path("seeds/seed_3").exists() && !bench.path("seeds/manifest.json").exists());
    for (seeds, said) in [
        ("--seeds 2-1", "the smaller one first"),
        ("--seeds 1,x", "0-4"),
        ("--seeds 3,1,3", "seed 3 is there twice"),
        ("--seeds 0-99999999999", "more than 10000"),
        ("--seeds 1-2 --seed 1", "--seed"),
    ] {
        let outcome = bench.run(&format!("{render} {seeds} --out no"));
        assert!(outcome.code == Some(2) && outcome.stderr.contains(said), "{seeds}: {outcome:?}");
        assert!(!bench.path("no").exists());
    }
}

#[test]
fn the_date_comes_from_the_environment_or_not_at_all() {
    let bench = Bench::new();
    bench.render("plain", "");
    let plain = std::fs::read_to_string(bench.path("plain/parameters.cfg")).unwrap();
    let line = |text: &str| text.lines().find(|line| line.starts_with("date =")).map(str::to_string);
    assert_eq!(line(&plain).as_deref().map(str::trim_end), Some("date ="));
    let mut command = bench.command(&format!("render {} --out dated {}", common::SCENE, common::SMALL));
    command.env("SOURCE_DATE_EPOCH", "86400");
    let outcome = common::outcome(command);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let dated = std::fs::read_to_string(bench.path("dated/parameters.cfg")).unwrap();
    assert!(line(&dated).unwrap().contains("1970"), "{dated}");
}
