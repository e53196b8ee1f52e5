//! The sky: a constant radiance, or an environment map.

use std::path::Path;

use holo_io::{FileFormat, Limits};
use ndarray::Array3;

use crate::Error;
use crate::spec::Sky;

/// The radiance of a constant sky; black for an environment map.
pub(crate) fn constant(sky: &Sky) -> [f32; 3] {
    match sky {
        Sky::Constant(radiance) => *radiance,
        Sky::Map(_) => [0.0; 3],
    }
}

/// Reads an equirectangular environment map as linear RGB; the format is detected by its contents.
pub(crate) fn read(path: &Path) -> Result<Array3<f32>, Error> {
    let limits = Limits::default();
    match holo_io::detect_format(path)? {
        FileFormat::Exr => Ok(holo_io::read_exr_rgb(path, &limits)?),
        FileFormat::Hdr => Ok(holo_io::read_hdr(path, &limits)?),
        _ => Err(Error::Failed(format!(
            "{}: not an environment map; --sky takes an OpenEXR or a Radiance HDR file, or a constant R,G,B",
            path.display()
        ))),
    }
}
