//! The views of the raw image of a plenoptic camera.

use std::path::Path;

use holo_core::{DynLightField, LightFieldShape};

use crate::{CameraFile, Error, Limits, read_linear};

/// Decodes the views of `shape`, as many along both axes, by the white image of the camera without dirt and noise.
pub(super) fn decode(
    image: &Path,
    file: &CameraFile,
    shape: LightFieldShape,
    limits: &Limits,
) -> Result<DynLightField, Error> {
    let failed = |error| Error::core(image, error);
    let raw = read_linear(image, limits)?;
    limits.elements(image, "light field", &shape.array_shape(raw.dim().2), size_of::<f32>())?;
    let size = file.camera.sensor().size;
    if (raw.dim().0, raw.dim().1) != (size.rows, size.columns) {
        // Before the white image, which may be as large as its camera says.
        let (expected, found) = (vec![size.rows, size.columns], vec![raw.dim().0, raw.dim().1]);
        return Err(failed(holo_core::Error::Shape { what: "raw image", expected, found }));
    }
    limits.elements(image, "white image", &[size.rows, size.columns], size_of::<f32>())?;
    let white = file.camera.white_image().map_err(failed)?;
    if !white.iter().any(|&light| light > 0.0) {
        let what = format!(
            "no light reaches the sensor of the camera '{}': its micro-images lie beside the sensor or between the \
             light-sensitive parts of its pixels",
            crate::shown(&file.name)
        );
        return Err(Error::NoLightField { path: image.to_owned(), what });
    }
    let decoded = file.camera.decode(raw.view(), white.view(), shape.views().rows).map_err(failed)?;
    Ok(decoded.light_field.into())
}
