//! glTF of any bytes: it loads or is an error; what loads is valid, and can be written and loaded again.

use holo_scene::gltf::{Limits, LoadOptions, load_slice, load_slice_with, to_glb};

/// Small enough that a file of a few bytes cannot make the fuzzer run out of memory.
const LIMITS: Limits = Limits {
    max_triangles: 1 << 16,
    max_vertices: 1 << 16,
    max_instances: 1 << 12,
    max_texture_pixels: 1 << 20,
    max_bytes: 1 << 24,
};

/// One glTF file, binary or JSON.
///
/// # Panics
/// If a property does not hold. The loader converts a panic to an error; libFuzzer stops at it all the same, and this
/// function recognizes its message.
pub fn gltf(data: &[u8]) {
    let mut options = LoadOptions::default();
    options.limits = LIMITS;
    // The pose of the nodes, or by the length of the data a moment of the animations.
    options.time_s = (data.len() % 2 == 1).then_some(0.4);
    let loaded = match load_slice_with(data, &options) {
        Ok(loaded) => loaded,
        Err(error) => {
            assert!(!error.to_string().contains("the reader failed on this file"), "{error}");
            return;
        }
    };
    loaded.scene.validate().expect("what loads is valid");
    // Meshes without triangles load, but cannot be written.
    if let Ok(bytes) = to_glb(&loaded.scene) {
        // With the default limits: vertices that primitives shared are separate now, textures decoded.
        let again = load_slice(&bytes, &Limits::default()).expect("what was written loads");
        assert_eq!(again.scene, loaded.scene);
    }
}
