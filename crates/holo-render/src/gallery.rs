//! Scenes built in code: nothing to download, the same bytes everywhere.
//!
//! A scene of the gallery is an ordinary [`Scene`]: render it, change it, or export it with [`crate::gltf::to_glb`]. All
//! are at table-top scale (0.2 to 1 m), where an f/5 lens of about 40 mm gives disparities worth measuring.
//!
//! | name | what it is there for |
//! |---|---|
//! | `garden` | textured background, hard shadows, smooth and flat surfaces, dense thin geometry (about 250,000 triangles) |

mod garden;
mod noise;
mod patterns;
mod shapes;

use crate::scene::Scene;

/// The names that [`scene`] knows.
pub const NAMES: &[&str] = &["garden"];

/// The scene of this name, or `None`.
#[must_use]
pub fn scene(name: &str) -> Option<Scene> {
    match name {
        "garden" => Some(garden::scene()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_valid_and_lit_and_has_a_camera() {
        for name in NAMES {
            let scene = scene(name).expect("a name of the list");
            scene.validate().expect(name);
            assert!(!scene.cameras.is_empty() && !scene.lights.is_empty() && scene.triangle_count() > 1000, "{name}");
        }
        assert!(scene("no such scene").is_none());
    }
}
