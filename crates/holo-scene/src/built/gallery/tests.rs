//! Properties of all scenes of the gallery.

use std::sync::LazyLock;

use super::{ANIMATED, NAMES, STRATIFIED, all_names, animation, purpose, scene};
use crate::Scene;
use crate::animation::Target;
use crate::gltf::{Limits, LoadOptions, load_slice, load_slice_with, to_glb, to_glb_animated};

/// All scenes, built once.
fn all() -> impl Iterator<Item = (&'static str, &'static Scene)> {
    static SCENES: LazyLock<Vec<Scene>> =
        LazyLock::new(|| all_names().map(|name| scene(name).expect("a name of the list")).collect());
    all_names().zip(SCENES.iter())
}

#[test]
fn every_scene_is_valid_and_lit_and_has_a_camera() {
    for (name, scene) in all() {
        scene.validate().expect(name);
        let lit = !scene.lights.is_empty() || scene.materials.iter().any(|material| material.emission != [0.0; 3]);
        assert!(lit && !scene.cameras.is_empty(), "{name}");
        let least = if STRATIFIED.contains(&name) { 1 } else { 10_000 };
        assert!((least..=500_000).contains(&scene.triangle_count()), "{name}: {} triangles", scene.triangle_count());
    }
    assert!(scene("no such scene").is_none());
}

#[test]
fn names_are_listed_once() {
    let once: std::collections::BTreeSet<_> = all_names().collect();
    assert_eq!((NAMES.len(), all_names().count(), once.len()), (16, 23, 23));
}

/// Everything except emissive objects (lamps and the room) is 0.2 to 1 m in size.
#[test]
fn every_scene_fits_a_table() {
    for (name, scene) in all() {
        let mut scene = scene.clone();
        let emissive: Vec<bool> =
            scene.meshes.iter().map(|mesh| scene.materials[mesh.material].emission != [0.0; 3]).collect();
        scene.instances.retain(|instance| !emissive[instance.mesh]);
        let (low, high) = scene.bounds().expect(name);
        let longest = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        // Positions are f32.
        assert!((0.2..1.0 + 1e-6).contains(&longest), "{name}: {longest} m");
    }
}

#[test]
fn every_scene_round_trips_through_glb() {
    for (name, scene) in all() {
        assert!(scene.environment.is_none(), "{name}: glTF has no place for an environment");
        let loaded = load_slice(&to_glb(scene).expect(name), &Limits::default()).expect(name);
        let mut scene = scene.clone();
        scene.add_tangents().expect(name);
        assert!(loaded.scene == scene, "{name} changed");
        assert_eq!(loaded.warnings, [""; 0], "{name}");
    }
}

#[test]
fn every_scene_has_a_purpose() {
    for name in all_names() {
        assert!(purpose(name).is_some_and(|purpose| !purpose.is_empty()), "{name}");
    }
    assert_eq!(purpose("teapot"), None);
}

/// Nothing moves without a time, and at a key every thing is where the key has it.
#[test]
fn animated_scenes_move_as_their_files_do() {
    assert!(NAMES.iter().all(|name| animation(name).is_none()));
    for name in ANIMATED {
        let (scene, moving) = (scene(name).expect(name), animation(name).expect(name));
        let glb = to_glb_animated(&scene, &moving).expect(name);
        let mut rest = scene.clone();
        rest.add_tangents().expect(name);
        let mut loaded = load_slice(&glb, &Limits::default()).expect(name);
        // What moves is written as a quaternion.
        for track in &moving.tracks {
            let (is, was) = match track.target {
                Target::Instance(index) => {
                    (&mut loaded.scene.instances[index].transform, scene.instances[index].transform)
                }
                Target::Camera(index) => (&mut loaded.scene.cameras[index].pose, scene.cameras[index].pose),
            };
            let pairs = is.columns.as_flattened().iter().zip(was.columns.as_flattened());
            assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-14, "{name}");
            *is = was;
        }
        assert!(loaded.scene == rest, "{name} changed");
        assert_eq!(loaded.summary.animations[0].name, moving.name);
        for k in [0, 5] {
            let time_s = Some(f64::from(moving.tracks[0].keys[k].time_s));
            let options = LoadOptions { time_s, ..LoadOptions::default() };
            let loaded = load_slice_with(&glb, &options).expect(name);
            assert_eq!(loaded.warnings, [""; 0], "{name}");
            let moved = loaded.scene;
            for track in &moving.tracks {
                let (place, before) = match track.target {
                    Target::Instance(index) => (moved.instances[index].transform, scene.instances[index].transform),
                    Target::Camera(index) => (moved.cameras[index].pose, scene.cameras[index].pose),
                };
                let key = track.keys[k];
                assert_eq!(place.translation, key.translation.map(f64::from), "{name}");
                let expected = crate::Transform::from_parts([0.0; 3], key.rotation.map(f64::from), [1.0; 3]).columns;
                let worst = place.columns.as_flattened().iter().zip(expected.as_flattened());
                assert!(worst.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-6, "{name}");
                assert!(place != before || k == 0, "{name} rests");
            }
            // What does not move is untouched.
            let still = |k: usize| moving.tracks.iter().all(|track| track.target != Target::Instance(k));
            assert!((0..scene.instances.len()).filter(|&k| still(k)).all(|k| moved.instances[k] == scene.instances[k]));
        }
    }
}
