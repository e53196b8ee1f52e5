//! Instead of the decoder in builds without it: an error that says what to do.

use crate::Error;
use crate::gltf::extensions::{DECOMPRESS, DRACO};
use crate::gltf::json::unsupported;

/// There is none.
pub(super) enum Geometry {}

pub(super) fn decode(at: &str, _data: &[u8], _vertices: usize, _triangles: usize) -> Result<Geometry, Error> {
    let what = format!("{DRACO} in this build, which is without the feature draco (decompress: {DECOMPRESS})");
    Err(unsupported(at, what))
}

impl Geometry {
    pub(super) fn size(&self) -> (usize, usize) {
        match *self {}
    }

    pub(super) fn triangles(&self) -> std::iter::Empty<[u32; 3]> {
        match *self {}
    }

    pub(super) fn attribute(&self, _id: u32, _components: usize, _are_floats: bool) -> Option<Vec<f32>> {
        match *self {}
    }
}
