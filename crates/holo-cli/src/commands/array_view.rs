//! Images of what the cameras of an array see together: of one wide aperture, and between them.

use std::path::Path;

use holo_core::refocus::{FocalPlane, FocalSurface};
use holo_core::{DynImage, Pinhole};
use holo_dataset::{ArrayViewpoint, synthesize_from_array, synthetic_aperture};
use holo_io::{ArrayFolder, Limits};
use ndarray::Array3;

use super::files;
use crate::arguments::{DisparityArgument, InputOptions, RefocusOptions, SynthesizeOptions, ViewpointOptions};
use crate::console::say;
use crate::failure::{Failure, wrong_option};

/// The cameras of the input, if it is a folder with images of cameras anywhere; a light field has no place for a viewpoint.
pub fn opened(input: &InputOptions, viewpoint: &ViewpointOptions) -> Result<Option<ArrayFolder>, Failure> {
    if ArrayFolder::is_one(&input.input) {
        let array = ArrayFolder::open(&input.input, viewpoint.transforms_up)?;
        say!("note: reads the images of {} cameras", array.cameras().len());
        return Ok(Some(array));
    }
    match viewpoint {
        ViewpointOptions { eye: None, target: None, up: None, .. } => Ok(None),
        _ => Err(Failure::Usage(format!(
            "{}: it has no transforms.json, so --eye, --target and --up have no meaning",
            input.input.display()
        ))),
    }
}

fn camera(array: &ArrayFolder, viewpoint: &ViewpointOptions) -> Result<Pinhole, Failure> {
    let ViewpointOptions { eye, target, up, .. } = *viewpoint;
    Ok(ArrayViewpoint { eye, target, up }.camera(array)?)
}

/// The plane of `--distance-m` and `--tilt-deg`.
pub fn plane(distance_m: f64, tilt_deg: Option<[f64; 2]>) -> Result<FocalPlane, Failure> {
    let [right, up] = tilt_deg.unwrap_or_default().map(f64::to_radians);
    FocalPlane::new(distance_m).and_then(|plane| plane.tilted(right, up)).map_err(wrong_option)
}

/// `holo refocus` of an array.
pub fn refocus(options: &RefocusOptions, array: &ArrayFolder) -> Result<(), Failure> {
    let view = camera(array, &options.viewpoint)?;
    let image = |surface| synthetic_aperture(array, view, options.aperture, options.kernel, surface);
    let image = match (options.distance_m, &options.all_in_focus) {
        (Some(distance_m), _) => image(FocalSurface::Plane(plane(distance_m, options.tilt_deg)?))?,
        (None, Some(map)) => {
            let depth_m = holo_io::read_pfm_gray(map, &Limits::default())?;
            image(FocalSurface::Depth(depth_m.view()))?
        }
        (None, None) => {
            let what =
                "cameras anywhere have no disparity; give --distance-m, or the depth of the view with --all-in-focus";
            return Err(Failure::Usage(format!("{}: {what}", options.input.input.display())));
        }
    };
    write(&options.out, &image, array)
}

/// `holo synthesize` of an array.
pub fn synthesize(options: &SynthesizeOptions, array: &ArrayFolder) -> Result<(), Failure> {
    let folder = options.input.input.display();
    if options.at.is_some() {
        return Err(Failure::Usage(format!(
            "{folder}: its cameras do not form a grid; give --eye and --target instead of --at"
        )));
    }
    if !matches!(options.disparity, None | Some(DisparityArgument::Truth)) {
        let what = "of cameras anywhere the depth that was rendered is taken; --disparity is for grids of views";
        return Err(Failure::Usage(format!("{folder}: {what}")));
    }
    let view = synthesize_from_array(array, &camera(array, &options.viewpoint)?, options.kernel)?;
    write(&options.out, &view.image, array)?;
    files::write_holes(&options.out, &view.holes)
}

/// Writes linear light: as it is into a PFM, on the sRGB curve into a PNG with as many bits as the images of the array.
fn write(out: &Path, image: &Array3<f32>, array: &ArrayFolder) -> Result<(), Failure> {
    files::write(out, &DynImage::from_linear(image.view(), files::kind_of(out, array.kind(0)?))?)
}
