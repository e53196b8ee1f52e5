//! Files that `holo` writes, pinned to the byte: SHA-256 of every one, against `pinned/files.txt`.
//!
//! Of a manifest all but the versions counts. What changes files on purpose writes the list anew (`HOLO_PIN=write cargo
//! test -p holo-cli --features hdf5 --test all pinned::`) and says why in the changelog; nothing else may change a line of it.

use crate::common;
use crate::pins;
use std::collections::BTreeMap;
use std::path::Path;

use crate::common::Bench;
use holo_io::{Limits, Sha256};

/// A render: its name and its options. The scenes are files, so that no mathematics library decides their shape.
const RENDERS: [(&str, &str); 8] = [
    (
        "path",
        "window.glb --lenses 14x10 --views 5x4 --spp 3 --reuse views --sky sky.hdr --ground-truth all --layers all,color \
         --write vpi,el,mat,disparity,depth,exr,hci",
    ),
    (
        "direct",
        "window.glb --lenses 9x14 --views 6 --spp 2 --reuse views --sky 0.3,0.4,0.5 --no-indirect --bit-depth 16 --mat-order lftoolbox \
         --seed 7",
    ),
    (
        "gloss",
        "metal.glb --sensor 100x71 --views 7x6 --spp 4 --reuse views --sky 1,1,1 --max-bounces 4 --no-roulette --exposure -0.5",
    ),
    ("adaptive", "metal.glb --lenses 24x16 --views 2 --sky 1,1,1 --spp 64 --target-error 0.2 --reuse views"),
    (
        "parallel",
        "metal.glb --lenses 12x9 --views 9x2 --projection orthographic --focus-m 2 --integrator depth --ground-truth all",
    ),
    (
        "dense",
        "window.glb --lenses 5x4 --views 30x33 --spp 1 --sky 0.5,0.5,0.5 --baseline-m 0.001 --focal-mm 40 --sensor-mm 20",
    ),
    ("one", "metal.glb --lenses 40x30 --views 1 --spp 1 --sky 1,1,1 --max-bounces 1 --focus-m inf"),
    ("stereo", "metal.glb --lenses 64x48 --views 5 --spp 2 --reuse views --sky 1,1,1 --no-indirect --baseline-m 0.02"),
];

/// What the toolbox makes of those.
const TOOLS: [(&str, &str); 14] = [
    ("view.png", "extract path/scene_el.png --view 3,1 --out view.png"),
    ("lens.png", "extract direct --lens 2,9 --out lens.png"),
    ("view.pfm", "extract path/scene_5d.mat --view 1,2 --out view_mat.png"),
    ("own_vpi.png", "remap path/scene_el.png own_vpi.png"),
    ("sharp.png", "refocus path --disparity 0.3 --out sharp.png"),
    ("far.png", "refocus direct --distance-m 3 --aperture disc:4 --kernel bilinear --out far.png"),
    ("all.png", "refocus stereo --all-in-focus stereo/scene_disparity.pfm --out all.png"),
    ("estimate.pfm", "depth stereo --out estimate.pfm"),
    ("epi.png", "epi path --row 4,2 --out epi.png"),
    ("column.png", "epi direct --column 4,2 --out column.png"),
    ("turned.png", "rotate-elements path turned.png"),
    ("quilt.png", "quilt path --tiles 3x1 --out quilt.png"),
    ("moving.png", "animate path --path circle --out moving.png"),
    ("error.png", "eval estimate.pfm stereo/scene_disparity.pfm --border 3 --error-map error.png"),
];

/// The digest of a file; of a manifest without versions.
fn digest(name: &str, bytes: &[u8]) -> String {
    if Path::new(name).file_name().is_none_or(|file| file != "manifest.json") {
        return Sha256::of(bytes).to_string();
    }
    let mut manifest: serde_json::Value = serde_json::from_slice(bytes).expect("a manifest");
    manifest.as_object_mut().and_then(|object| object.remove("versions")).expect("versions");
    Sha256::of(manifest.to_string().as_bytes()).to_string()
}

fn made(backend: &str) -> (String, BTreeMap<String, String>) {
    let bench = Bench::new();
    let radiance = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/radiance");
    for (from, to) in
        [("window.glb", "window.glb"), ("metal_and_glass.glb", "metal.glb"), ("window_sky.hdr", "sky.hdr")]
    {
        std::fs::copy(radiance.join(from), bench.path(to)).expect("a scene of tests/radiance");
    }
    let run = |line: &str| {
        let outcome = bench.run(line);
        assert_eq!(outcome.code, Some(0), "{line}: {outcome:?}");
    };
    for (name, options) in RENDERS {
        run(&format!("render {options} --out {name} --backend {backend} --quiet"));
    }
    for part in 1..=3 {
        let options =
            "--lenses 14x50 --views 5x4 --spp 3 --reuse views --sky 0.5,0.5,0.5 --write el,exr --layers albedo,depth";
        run(&format!("render window.glb {options} --shard {part}/3 --out part{part} --backend {backend} --quiet"));
    }
    run("merge merged part1 part2 part3 --quiet");
    let dataset = "--scenes none --glb window.glb,metal.glb --sensor 60x40 --splits 3,4x5 --sky 1,1,1 --spp 1";
    run(&format!("dataset --out dataset {dataset} --backend {backend} --quiet"));
    if cfg!(feature = "hdf5") {
        run(&format!(
            "render window.glb --lenses 14x10 --views 5x4 --spp 1 --sky 1,1,1 --write h5 --out h5 --backend {backend} --quiet"
        ));
    }
    for (_, line) in TOOLS {
        run(line);
    }
    let mut found = BTreeMap::new();
    let engine = bench.run("info path/manifest.json").stdout;
    let engine = if engine.contains("embree 4.4.0") {
        pins::embree().unwrap_or("other")
    } else if engine.contains("bvh") {
        "bvh"
    } else {
        "other"
    };
    let folders = RENDERS.iter().map(|render| render.0).chain(["part1", "part2", "part3", "merged", "dataset", "h5"]);
    for folder in folders.filter(|folder| bench.path(folder).is_dir()) {
        // The description of a dataset is text about versions and options. So is a manifest beside digests of files, which are
        // pinned themselves: those of one engine show its text.
        let is_pinned = |name: &str| {
            !["DATASET.md", "dataset.json"].contains(&name) && (engine == "bvh" || !name.ends_with("manifest.json"))
        };
        for (name, bytes) in bench.bytes(folder).into_iter().filter(|(name, _)| is_pinned(name)) {
            found.insert(format!("{engine}/{folder}/{name}"), digest(&name, &bytes));
        }
    }
    for (name, bytes) in bench.bytes(".").into_iter().filter(|(name, _)| !name.contains('/')) {
        if name.ends_with(".png") || name.ends_with(".pfm") {
            found.insert(format!("{engine}/{name}"), digest(&name, &bytes));
        }
    }
    (engine.to_owned(), folded(found))
}

/// One line for all the numbered files of a folder.
fn folded(files: BTreeMap<String, String>) -> BTreeMap<String, String> {
    let mut folded = BTreeMap::<String, String>::new();
    for (name, digest) in files {
        let name = name.split_once("Cam").map_or(name.clone(), |(before, _)| format!("{before}Cam*"));
        folded
            .entry(name)
            .and_modify(|all| *all = Sha256::of(format!("{all}{digest}").as_bytes()).to_string())
            .or_insert(digest);
    }
    folded
}

#[test]
fn no_byte_of_a_file_changes() {
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pinned/files.txt");
    let mut found = BTreeMap::new();
    for backend in ["bvh", "auto"] {
        let (engine, files) = made(backend);
        if engine == "other" {
            println!("not run for this Embree: the files are pinned for version 4.4.0 with AVX2 or AVX-512");
        } else if backend == "auto" && engine == "bvh" {
            common::peer::missing("Embree 4.4.0");
        }
        if engine != "other" {
            found.extend(files);
        }
    }
    pins::check(&list, &found, |name| !cfg!(feature = "hdf5") && name.contains("/h5/"));
}

/// A dataset that version 0.1.0 made: it verifies, and the same command makes it again and says why.
#[test]
fn an_older_dataset_verifies_and_is_made_again() {
    let bench = Bench::new();
    let older = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pinned/from_0.1.0");
    for file in ["DATASET.md", "dataset.json"] {
        std::fs::create_dir_all(bench.path("set/window/2x2")).unwrap();
        std::fs::copy(older.join(file), bench.path("set").join(file)).unwrap();
    }
    for file in std::fs::read_dir(older.join("window/2x2")).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), bench.path("set/window/2x2").join(file.file_name())).unwrap();
    }
    std::fs::copy(older.join("../../../../../tests/radiance/window.glb"), bench.path("window.glb")).unwrap();
    let verified = bench.run("verify set");
    assert_eq!(verified.code, Some(0), "{verified:?}");
    let before = bench.bytes("set/window/2x2");

    let line = "dataset --out set --scenes none --glb window.glb --sensor 12x8 --splits 2 --spp 1 --sky 1,1,1 \
                --write el,disparity,mat --backend bvh";
    let again = bench.run(line);
    assert_eq!(again.code, Some(0), "{again:?}");
    assert!(again.stderr.contains("(made again: it was made by holo 0.1.0, this is holo "), "{again:?}");
    // Light is other than in 0.1.0 (see the changelog), and the mask is new; the ground truth and the camera are not.
    let is_new = ["manifest.json", "scene_el.png", "scene_5d.mat", "scene_hit_mask.png"];
    let has_light = |name: &str| is_new.contains(&name);
    for (name, bytes) in bench.bytes("set/window/2x2").into_iter().filter(|(name, _)| !has_light(name)) {
        if name == "scene_disparity.png" {
            // It says its range now; its pixels are the same.
            let [made, older] =
                [&bytes, &before[&name]].map(|png| holo_io::decode_png(png.as_slice(), &Limits::default()).unwrap());
            assert_eq!(made, older);
            continue;
        }
        assert_eq!(digest(&name, &bytes), digest(&name, &before[&name]), "{name} is other than 0.1.0 made it");
    }
    assert!(bench.bytes("set/window/2x2").keys().any(|name| !has_light(name)));
    let kept = bench.run(line);
    assert!(kept.stderr.contains("done already"), "{kept:?}");
}
