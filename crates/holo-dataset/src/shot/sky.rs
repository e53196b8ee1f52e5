//! The sky: a constant radiance, an environment map, or the automatic one.

use std::path::Path;

use holo_io::{FileFormat, Limits};
use holo_scene::{Environment, Scene, gltf};

use crate::Error;
use crate::settings::Sky;
use crate::watch::{About, Diagnostics};

/// The radiance of a constant sky; black for any other, which is an environment map.
pub(crate) fn constant(sky: &Sky) -> [f32; 3] {
    match sky {
        Sky::Constant(radiance) => *radiance,
        Sky::Automatic | Sky::Map(_) => [0.0; 3],
    }
}

/// Gives the scene the environment of a sky. Returns whether the automatic sky was needed.
pub(crate) fn add(sky: &Sky, scene: &mut Scene, diagnostics: &dyn Diagnostics) -> Result<bool, Error> {
    match sky {
        Sky::Constant(_) => Ok(false),
        Sky::Map(path) => {
            scene.environment = Some(read(path)?);
            Ok(false)
        }
        Sky::Automatic if scene.has_light_sources() => Ok(false),
        Sky::Automatic => {
            scene.environment = Some(Environment::overcast());
            let note = "note: the scene has no light sources: a soft sky lights it; `sky` changes that \
                (0: ground truth alone)";
            diagnostics.report(About::Scene, note);
            Ok(true)
        }
    }
}

/// Reads an equirectangular environment map as linear RGB; the format is detected by its contents.
fn read(path: &Path) -> Result<Environment, Error> {
    let limits = Limits::default();
    let failed = |why: &dyn std::fmt::Display| Error::Failed(format!("{}: {why}", path.display()));
    let radiance = match holo_io::detect_format(path)? {
        FileFormat::Exr => holo_io::read_exr_rgb(path, &limits)?,
        FileFormat::Hdr => holo_io::read_hdr(path, &limits)?,
        _ if is_image(path) => {
            let bytes = std::fs::read(path).map_err(|why| failed(&why))?;
            return Environment::from_image(&bytes, &gltf::Limits::default()).map_err(|why| failed(&why));
        }
        _ => {
            return Err(failed(
                &"not an environment map; `sky` takes OpenEXR, Radiance HDR, PNG or JPEG files, or a constant R,G,B",
            ));
        }
    };
    Ok(Environment { radiance })
}

/// Whether a file is called as an image with codes of 8 or 16 bits; its contents decide which.
fn is_image(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    ending.is_some_and(|ending| ["png", "jpg", "jpeg"].contains(&ending.as_str()))
}
