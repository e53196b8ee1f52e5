//! Images in linear light, from the files that hold them.

use std::path::Path;

use holo_core::plenoptic::PlenopticCamera;
use holo_io::interop::LytroImage;
use holo_io::{CameraFile, Limits};
use ndarray::{Array2, Array3, Axis};

use crate::Error;

/// Reads an image in linear light, axes (row, column, channel), of one or three channels; see [`holo_io::read_linear`].
pub(crate) fn read_linear(path: &Path) -> Result<Array3<f32>, Error> {
    Ok(holo_io::read_linear(path, &Limits::default())?)
}

/// Reads a white image, axes (row, column): the mean of its colors; that of a Lytro camera with all colors at one mean.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Failed`] if it has no pixels.
pub fn read_white(path: &Path) -> Result<Array2<f32>, Error> {
    if LytroImage::is_at(path)? {
        return Ok(LytroImage::read(path, &Limits::default())?.white());
    }
    let image = read_linear(path)?;
    image.mean_axis(Axis(2)).ok_or_else(|| Error::Failed(format!("{}: it has no pixels", path.display())))
}

/// Reads the raw image of a camera, axes (row, column, channel): that of a Lytro camera gets the colors of its pixels from the
/// neighbors under the same microlens, weighted with the white image.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Core`] if a mosaic has not the size of the camera.
pub fn read_raw(path: &Path, camera: &PlenopticCamera, white: &Array2<f32>) -> Result<Array3<f32>, Error> {
    if !LytroImage::is_at(path)? {
        return read_linear(path);
    }
    let image = LytroImage::read(path, &Limits::default())?;
    let sensor = image.info.sensor;
    let colors = camera.demosaic(image.mosaic().view(), white.view(), sensor.filter)?;
    Ok(sensor.rgb_from_camera(colors))
}

/// Returns the camera that a raw image describes itself: those of Lytro do.
///
/// # Errors
/// [`Error::Io`] if the image cannot be read.
pub fn camera_of_raw(path: &Path) -> Result<Option<CameraFile>, Error> {
    if !LytroImage::is_at(path)? {
        return Ok(None);
    }
    let image = LytroImage::read(path, &Limits::default())?;
    // At what the lens is focused, is not known.
    let of_model = CameraFile::preset(image.preset);
    Ok(of_model.map(|file| CameraFile { camera: image.camera, is_approximate: true, ..file }))
}
