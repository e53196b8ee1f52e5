//! `holo scene`: the gallery listed and exported.

use crate::common;
use crate::common::Bench;
use holo_scene::gltf::{Limits, load};

#[test]
fn the_gallery_is_listed() {
    let bench = Bench::new();
    let outcome = bench.run("scene");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    let lines = outcome.stdout.lines().map(|line| line.split_once(' ').expect("a name, and what it is for"));
    let (names, purposes): (Vec<&str>, Vec<&str>) = lines.unzip();
    assert_eq!(names, holo_scene::gallery::all_names().collect::<Vec<_>>());
    assert!(purposes.iter().all(|purpose| !purpose.trim().is_empty()), "{purposes:?}");
    assert_eq!(bench.list(""), [common::SCENE], "listing writes nothing");
}

#[test]
fn a_scene_is_exported_whole() {
    let bench = Bench::new();
    let name = holo_scene::gallery::NAMES[0];
    let outcome = bench.run(&format!("scene {name}"));
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), ""), "{outcome:?}");
    assert!(
        outcome.stderr.contains(&format!("wrote {name}.glb")) && outcome.stderr.contains("triangles"),
        "{outcome:?}"
    );
    let loaded = load(&bench.path(format!("{name}.glb")), &Limits::default()).unwrap();
    let triangles = loaded.scene.triangle_count();
    assert!(outcome.stderr.contains(&format!("({triangles} triangles")), "{triangles}: {outcome:?}");
    assert_eq!(loaded.warnings, Vec::<String>::new());
}

#[test]
fn unknown_scenes_and_places_are_refused() {
    let bench = Bench::new();
    let outcome = bench.run("scene atlantis");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    let known = holo_scene::gallery::NAMES.join(", ");
    assert!(outcome.stderr.contains("'atlantis'") && outcome.stderr.contains(&known), "{outcome:?}");
    let outcome = bench.run("scene --out x.glb");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    let outcome = bench.run(&format!("scene {} --out nowhere/x.glb", holo_scene::gallery::NAMES[0]));
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("nowhere/x.glb"), "{outcome:?}");
    assert_eq!(bench.list(""), [common::SCENE]);
}
