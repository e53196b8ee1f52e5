//! Files of other programs in `data/`, so that the tests need no other program.
//!
//! OpenEXR 3.5.3 (`openexr_*`), Blender 5.0.1 and Mitsuba 3.9.1 wrote them; `blender_*.pfm` is what OpenEXR reads of
//! `blender_multilayer.exr`, a render of Blender's first scene. All others contain [`ramp`], unless their test states
//! otherwise.

use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightField, LightFieldOwned, LightFieldShape};
use ndarray::Array3;

pub fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests").join("data").join(name)
}

/// The samples of the files: exact in half precision.
#[allow(dead_code, reason = "some test files use `data` alone")]
pub fn ramp(row: usize, column: usize, channel: usize) -> f32 {
    (row * 8 + column) as f32 + channel as f32 / 8.0
}

/// The names of what is in a folder, in alphabetical order.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// The shape of [`light_field`]: 4 x 3 views of 7 x 5 pixels.
pub fn shape() -> LightFieldShape {
    LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7)).unwrap()
}

/// A light field with every sample different from its neighbours.
pub fn light_field() -> LightFieldOwned<u8> {
    let raw = Array3::from_shape_fn((15, 28, 3), |(row, column, channel)| (row * 13 + column * 3 + channel) as u8);
    LightField::from_elemental_grid(raw, shape()).unwrap()
}
