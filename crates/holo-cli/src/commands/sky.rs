//! What `--sky` names: one radiance for everywhere, or a map around the scene.

use std::path::Path;

use holo_io::{FileKind, Limits};
use ndarray::Array3;

use crate::arguments::SkyArgument;
use crate::failure::Failure;

/// The radiance of the constant sky, black beside a map.
pub fn constant(sky: &SkyArgument) -> [f32; 3] {
    match sky {
        SkyArgument::Constant(radiance) => *radiance,
        SkyArgument::Map(_) => [0.0; 3],
    }
}

/// The file of the map, if it is one.
pub fn map(sky: &SkyArgument) -> Option<&Path> {
    match sky {
        SkyArgument::Constant(_) => None,
        SkyArgument::Map(path) => Some(path),
    }
}

/// Reads an equirectangular map as linear RGB, by what the file is and not by what it is called.
pub fn read(path: &Path) -> Result<Array3<f32>, Failure> {
    let limits = Limits::default();
    match holo_io::recognise(path)? {
        FileKind::Exr => Ok(holo_io::read_exr_rgb(path, &limits)?),
        FileKind::Hdr => Ok(holo_io::read_hdr(path, &limits)?),
        _ => Err(Failure::Failed(format!(
            "{}: not an environment map; --sky takes an OpenEXR or a Radiance HDR file, or a constant R,G,B",
            path.display()
        ))),
    }
}
