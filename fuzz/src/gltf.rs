//! glTF of any bytes: it loads or is an error; what loads is valid, and can be written and loaded again.

use holo_scene::gltf::{Limits, load_slice, to_glb};

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
    let loaded = match load_slice(data, &LIMITS) {
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
