//! Wrong use: exit code 2, a message that says what to do, and nothing made.

use crate::common;
use std::time::Duration;

use crate::common::{Bench, SCENE, SMALL};

/// Runs `render` into a new folder; it must be refused with these words, at once, and leave nothing.
fn refused(bench: &Bench, options: &str, words: &[&str]) {
    let outcome = bench.run(&format!("render {SCENE} --out out/inner {options}"));
    assert_eq!(outcome.code, Some(2), "{options}: {outcome:?}");
    assert_eq!(outcome.stdout, "", "{options}");
    for word in words {
        assert!(outcome.stderr.contains(word), "{options}: no '{word}' in: {}", outcome.stderr);
    }
    assert!(!outcome.stderr.contains("panicked"), "{options}: {outcome:?}");
    assert!(outcome.took < Duration::from_secs(2), "{options}: {outcome:?}");
    assert_eq!(bench.list(""), [SCENE], "{options}");
}

#[test]
fn flags_and_values_that_do_not_exist() {
    let bench = Bench::new();
    refused(&bench, "--bogus", &["--bogus", "--help"]);
    refused(&bench, "--views 0", &["--views", "such as 30x20", "from 1 up"]);
    refused(&bench, "--views 5x", &["--views", "COLUMNSxROWS"]);
    refused(&bench, "--views -3", &["--views", "COLUMNSxROWS"]);
    refused(&bench, "--lenses x", &["--lenses", "'x'", "COLUMNSxROWS"]);
    refused(&bench, "--lenses 3x4x5", &["--lenses", "COLUMNSxROWS"]);
    refused(&bench, "--sensor nonsense", &["--sensor", "hd, 4k, 8k, uhd8k or WIDTHxHEIGHT"]);
    refused(&bench, "--integrator magic", &["auto, depth, direct"]);
    refused(&bench, "--write nonsense", &["vpi, el, disparity, depth"]);
    refused(
        &bench,
        "--layers normals",
        &["color, depth, ray-length", "hit-mask, reflective, all", "similar value exists: 'shading-normal'"],
    );
    refused(&bench, "--write hdf5", &["similar value exists: 'h5'"]);
    refused(&bench, "--sky sky.gif", &["--sky", "R,G,B", ".hdr, .exr, .png or .jpg"]);
    refused(&bench, "--bit-depth 12", &["8 or 16"]);
    refused(&bench, "--backend gpu", &["auto, embree, bvh"]);
    refused(&bench, "--exposure bright", &["auto"]);
}

#[test]
fn numbers_out_of_range() {
    let bench = Bench::new();
    refused(&bench, "--baseline-m -1", &["--baseline-m", "from 0 up"]);
    refused(&bench, "--baseline-m nan", &["--baseline-m", "from 0 up"]);
    refused(&bench, "--f-number 0", &["--f-number", "above 0"]);
    refused(&bench, "--focus-m 0", &["--focus-m", "above 0, inf or auto"]);
    refused(&bench, "--focus-m -2", &["--focus-m", "above 0, inf or auto"]);
    refused(&bench, "--focal-mm -35", &["--focal-mm", "above 0"]);
    refused(&bench, "--sensor-mm inf", &["--sensor-mm", "above 0"]);
    refused(&bench, "--spp 0", &["--spp", "an integer from 1 to 65536"]);
    refused(&bench, "--spp 1/4", &["1/4 samples per pixel", "--denoise views"]);
    refused(&bench, "--spp 1/5 --denoise views", &["--spp", "1/64"]);
    refused(&bench, "--spp -1", &["--spp", "an integer from 1 to 65536"]);
    refused(&bench, "--threads 0", &["--threads", "1..=1024"]);
    refused(&bench, "--seed -1", &["--seed"]);
    refused(&bench, "--sky -1,0,0", &["--sky", "three numbers from 0 up"]);
    refused(&bench, "--sky 1,2", &["--sky", "three numbers from 0 up"]);
}

#[test]
fn options_that_contradict_each_other_or_the_scene() {
    let bench = Bench::new();
    refused(&bench, "--sensor hd --lenses 12x8", &["--sensor", "--lenses", "cannot be used with"]);
    refused(&bench, "--baseline-m 0.1 --f-number 5", &["--baseline-m", "--f-number", "cannot be used with"]);
    refused(&bench, "--integrator depth --write el", &["--integrator depth", "remove el"]);
    refused(&bench, "--integrator depth --write depth,vpi", &["remove vpi"]);
    refused(&bench, "--integrator depth --layers color,depth", &["--integrator depth", "remove color"]);
    refused(&bench, &format!("--camera side {SMALL}"), &["'side'", "'front'"]);
    refused(&bench, &format!("--camera 1 {SMALL}"), &["number 1", "'front'"]);
    refused(&bench, "--sensor 100x80 --views 101x4", &["100 x 80 pixels", "101 x 4 views", "at least one pixel"]);
    refused(&bench, "--sensor 10x10 --views 100", &["too small"]);
    refused(&bench, &format!("--projection orthographic --focus-m inf {SMALL}"), &["finite focus distance"]);
    let outcome = bench.run(&format!("render {SCENE}"));
    assert!(outcome.code == Some(2) && outcome.stderr.contains("--out <DIR>"), "{outcome:?}");
    let outcome = bench.run("");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("render"), "{outcome:?}");
    let outcome = bench.run("paint");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("paint"), "{outcome:?}");
}

#[test]
fn pictures_of_a_scene_without_light() {
    let bench = Bench::new();
    let mut scene = common::tiny_scene();
    scene.lights.clear();
    std::fs::write(bench.path("dark.glb"), holo_scene::gltf::to_glb(&scene).unwrap()).unwrap();
    let outcome = bench.run(&format!("render dark.glb --out out --write el {SMALL} --sky 0"));
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("no light") && outcome.stderr.contains("--sky auto"), "{outcome:?}");
    let outcome = bench.run(&format!("render dark.glb --out out --layers colour {SMALL} --sky 0"));
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("remove color") && outcome.stderr.contains("--sky auto"), "{outcome:?}");
    assert_eq!(bench.list(""), ["dark.glb", SCENE]);
}

#[test]
fn what_cannot_be_written_is_said_so() {
    let bench = Bench::new();
    refused(&bench, "--write obj", &["vpi", "el", "mat", "hci"]);
    #[cfg(not(feature = "hdf5"))]
    refused(&bench, "--write el,h5", &["has no HDF5", "cargo xtask build"]);
}

#[test]
fn absurd_sizes_are_refused_without_taking_memory() {
    let bench = Bench::new();
    for options in [
        "--lenses 4000000000x4000000000",
        "--lenses 4000000000x4000000000 --views 1",
        "--views 65535x65535 --lenses 65535x65535",
        "--sensor 4000000000x4000000000",
        "--views 99999999999999999999",
        "--views 18446744073709551615x18446744073709551615",
        "--lenses 30x20 --views 65535x65535",
        "--lenses 1000000x1000000 --views 2",
        "--lenses 1x1 --views 4000000000x1000",
        "--lenses 100000000x1 --views 100000x1",
        "--lenses 100000000x1 --views 100000x1 --integrator depth --ground-truth all",
        "--lenses 1000000x1000000 --views 1 --integrator depth --write exr --layers all",
    ] {
        refused(&bench, options, &[]);
        let outcome = bench.run(&format!("render {SCENE} --out out --quiet {options}"));
        let words = ["use fewer views or lenses", "address space", "COLUMNSxROWS", "too small"];
        assert!(words.iter().any(|word| outcome.stderr.contains(word)), "{options}: {outcome:?}");
    }
}

#[test]
fn an_existing_folder_is_left_alone() {
    let bench = Bench::new();
    bench.render("out", "");
    std::fs::write(bench.path("out/mine.txt"), "keep").unwrap();
    let before = bench.bytes("out");
    for options in [
        "--camera side",
        "--integrator depth --write el,hci",
        "--integrator depth --write el",
        "--views 65535x65535 --lenses 9x9",
    ] {
        let outcome = bench.run(&format!("render {SCENE} --out out {options}"));
        assert_eq!(outcome.code, Some(2), "{outcome:?}");
        assert!(bench.bytes("out") == before, "{options}");
    }
}
