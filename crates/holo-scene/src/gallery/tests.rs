//! Properties of all scenes of the gallery.

use std::sync::LazyLock;

use super::{NAMES, purpose, scene};
use crate::Scene;
use crate::gltf::{Limits, load_slice, to_glb};

/// All scenes, built once.
fn all() -> impl Iterator<Item = (&'static str, &'static Scene)> {
    static SCENES: LazyLock<Vec<Scene>> =
        LazyLock::new(|| NAMES.iter().map(|name| scene(name).expect("a name of the list")).collect());
    NAMES.iter().copied().zip(SCENES.iter())
}

#[test]
fn every_scene_is_valid_and_lit_and_has_a_camera() {
    for (name, scene) in all() {
        scene.validate().expect(name);
        let lit = !scene.lights.is_empty() || scene.materials.iter().any(|material| material.emission != [0.0; 3]);
        assert!(lit && !scene.cameras.is_empty(), "{name}");
        assert!((10_000..=500_000).contains(&scene.triangle_count()), "{name}: {} triangles", scene.triangle_count());
    }
    assert!(scene("no such scene").is_none());
}

#[test]
fn names_are_listed_once() {
    let once: std::collections::BTreeSet<_> = NAMES.iter().collect();
    assert_eq!((NAMES.len(), once.len()), (15, 15));
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
fn every_scene_is_the_same_each_time() {
    for (name, first) in all() {
        assert!(scene(name).expect(name) == *first, "{name}");
    }
}

#[test]
fn every_scene_has_a_purpose() {
    for name in NAMES {
        assert!(purpose(name).is_some_and(|purpose| !purpose.is_empty()), "{name}");
    }
    assert_eq!(purpose("teapot"), None);
}
