//! What `--sky` names: one radiance for everywhere, or a map around the scene.

use std::path::Path;

use holo_io::{FileKind, Limits};
use ndarray::Array3;

use crate::Error;
use crate::spec::Sky;

/// The radiance of the constant sky, black beside a map.
pub(crate) fn constant(sky: &Sky) -> [f32; 3] {
    match sky {
        Sky::Constant(radiance) => *radiance,
        Sky::Map(_) => [0.0; 3],
    }
}

/// Reads an equirectangular map as linear RGB, by what the file is and not by what it is called.
pub(crate) fn read(path: &Path) -> Result<Array3<f32>, Error> {
    let limits = Limits::default();
    match holo_io::recognise(path)? {
        FileKind::Exr => Ok(holo_io::read_exr_rgb(path, &limits)?),
        FileKind::Hdr => Ok(holo_io::read_hdr(path, &limits)?),
        _ => Err(Error::Failed(format!(
            "{}: not an environment map; --sky takes an OpenEXR or a Radiance HDR file, or a constant R,G,B",
            path.display()
        ))),
    }
}
