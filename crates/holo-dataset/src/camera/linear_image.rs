//! Images in linear light, from the files that hold them.

use std::path::Path;

use holo_io::Limits;
use ndarray::Array3;

use crate::Error;

/// Reads an image in linear light, axes (row, column, channel), of one or three channels; see [`holo_io::read_linear`].
pub(crate) fn read_linear(path: &Path) -> Result<Array3<f32>, Error> {
    Ok(holo_io::read_linear(path, &Limits::default())?)
}
