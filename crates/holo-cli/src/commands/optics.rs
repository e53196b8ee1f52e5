//! `holo optics`: what a camera will see, before it is built or rendered; and the camera that sees what is wanted.

use holo_core::optics::{CameraDesign, DepthRange, DisparityRange, Optics, rig_for_disparities};
use holo_core::{Intrinsics, LightFieldShape, Remainder, Rig, automatic_baseline_m};
use holo_dataset::{Focus, NamedQuantity, RigSpec, camera_optics, camera_warnings, rig_optics};
use holo_io::{CameraFile, Limits};

use crate::arguments::OpticsOptions;
use crate::console::say;
use crate::failure::Failure;
use crate::quantities::{self, Quantity};

pub fn run(options: &OpticsOptions) -> Result<(), Failure> {
    if let Some(camera) = &options.camera_file {
        return plenoptic(options, camera);
    }
    let depths = options.depths_m.map(|(near_m, far_m)| DepthRange::new(near_m, far_m)).transpose()?;
    let rig = match &options.input {
        Some(input) => holo_io::read_rig(input, &Limits::default())?.ok_or_else(|| {
            Failure::Usage(format!(
                "{}: the camera parameters are unknown; is there a parameters.cfg beside it?",
                input.display()
            ))
        })?,
        None => rig(options, depths)?,
    };
    let optics = Optics::new(rig)?;
    let rows = rig_optics(&optics, depths, options.circle_px, options.step_px)?;
    print(rows, options.json)?;
    if let Some(depths) = depths {
        for warning in optics.warnings(depths, options.limit_px, options.step_px)? {
            say!("warning: {warning}");
        }
    }
    Ok(())
}

fn print(rows: Vec<NamedQuantity>, as_json: bool) -> Result<(), Failure> {
    let rows = rows.into_iter().map(|(key, name, value, unit)| Quantity::new(key, name, value, unit));
    quantities::print(rows.collect(), as_json)
}

/// The optics of a plenoptic camera.
fn plenoptic(options: &OpticsOptions, camera: &str) -> Result<(), Failure> {
    let camera = options.main_lens.adjusted(CameraFile::open(camera)?)?;
    let depths = options.depths_m.map_or(Vec::new(), |(near_m, far_m)| vec![near_m, far_m]);
    print(camera_optics(&camera.camera, &depths)?, options.json)?;
    camera_warnings(&camera).iter().for_each(|line| say!("warning: {line}"));
    Ok(())
}

/// The rig that the numbers describe.
fn rig(options: &OpticsOptions, depths: Option<DepthRange>) -> Result<Rig, Failure> {
    // Divided, because 1e-3 is not exact: 36 mm times it is not 0.036 m.
    let intrinsics = Intrinsics { focal_length_m: options.focal_mm / 1e3, sensor_size_m: options.sensor_mm / 1e3 };
    let f_number = options.main_lens.spec().f_number_or_default();
    if let Some(lens_pitch_mm) = options.lens_pitch_mm {
        let design = CameraDesign {
            sensor: options.main_lens.sensor,
            sensor_size_m: intrinsics.sensor_size_m,
            lens_pitch_m: lens_pitch_mm / 1e3,
            focal_length_m: intrinsics.focal_length_m,
            f_number,
            focus_distance_m: 1.0,
        };
        let shape = design.sensor_division()?.shape;
        return match wanted(options, depths, intrinsics, shape)? {
            Some(rig) => Ok(rig),
            None => Ok(CameraDesign { focus_distance_m: focus_m(options, depths)?, ..design }.rig()?),
        };
    }
    let views = options.views.unwrap_or(RigSpec::default().views);
    let shape = match options.lenses {
        Some(lenses) => LightFieldShape::new(views, lenses)?,
        None => options.main_lens.sensor.divide(views, Remainder::Crop)?.shape,
    };
    if let Some(rig) = wanted(options, depths, intrinsics, shape)? {
        return Ok(rig);
    }
    let baseline_m = match options.baseline_m {
        Some(baseline_m) => baseline_m,
        None => automatic_baseline_m(intrinsics.focal_length_m, f_number, views)?,
    };
    with(shape, intrinsics, baseline_m, focus_m(options, depths)?)
}

fn with(
    shape: LightFieldShape,
    intrinsics: Intrinsics,
    baseline_m: f64,
    focus_distance_m: f64,
) -> Result<Rig, Failure> {
    Ok(Rig::builder(shape).intrinsics(intrinsics).baseline_m(baseline_m).focus_distance_m(focus_distance_m).build()?)
}

/// The rig with the requested disparities, if there are any.
fn wanted(
    options: &OpticsOptions,
    depths: Option<DepthRange>,
    intrinsics: Intrinsics,
    shape: LightFieldShape,
) -> Result<Option<Rig>, Failure> {
    let Some((min_px, max_px)) = options.main_lens.disparity else { return Ok(None) };
    let depths = depths.ok_or_else(|| Failure::Usage("--disparity of which depths? give --depths-m".into()))?;
    let found = rig_for_disparities(depths, DisparityRange { min_px, max_px }, intrinsics, shape.lenses())?;
    with(shape, intrinsics, found.baseline_m, found.focus_distance_m).map(Some)
}

fn focus_m(options: &OpticsOptions, depths: Option<DepthRange>) -> Result<f64, Failure> {
    match (options.main_lens.focus_m, depths) {
        (Focus::Meters(focus_m), _) => Ok(focus_m),
        // The harmonic mean, as a render does it: it halves the range of disparities.
        (Focus::Automatic, Some(depths)) => Ok(2.0 * depths.near_m / (1.0 + depths.near_m / depths.far_m)),
        (Focus::Automatic, None) => {
            Err(Failure::Usage("where is the focus? give --focus-m, or --depths-m and it lies between them".into()))
        }
    }
}
