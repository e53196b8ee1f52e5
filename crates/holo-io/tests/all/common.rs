//! Files of other programs in `data/`, so that the tests need no other program.
//!
//! OpenEXR 3.5.3 (`openexr_*`), Blender 5.0.1 and Mitsuba 3.9.1 wrote them; `blender_*.pfm` is what OpenEXR reads of
//! `blender_multilayer.exr`, a render of Blender's first scene. All others contain [`ramp`], unless their test states
//! otherwise.

use std::path::PathBuf;

pub fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests").join("data").join(name)
}

/// The samples of the files: exact in half precision.
#[allow(dead_code, reason = "some test files use `data` alone")]
pub fn ramp(row: usize, column: usize, channel: usize) -> f32 {
    (row * 8 + column) as f32 + channel as f32 / 8.0
}
