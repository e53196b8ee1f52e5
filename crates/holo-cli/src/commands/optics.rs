//! `holo optics`: what a camera will see, before it is built or rendered; and the camera that sees what is wanted.

use holo_core::optics::{CameraDesign, DepthRange, DisparityRange, Optics, rig_for_disparities};
use holo_core::{GridSize, Intrinsics, LightFieldShape, Remainder, Rig, automatic_baseline_m};
use holo_dataset::text::json_number;
use holo_dataset::{Focus, RigSpec};
use holo_io::Limits;
use serde_json::{Value, json};

use crate::arguments::OpticsOptions;
use crate::console::say;
use crate::failure::Failure;
use crate::quantities::{self, Quantity};

pub fn run(options: &OpticsOptions) -> Result<(), Failure> {
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
    let rows = rows(options, &optics, depths)?;
    quantities::print(rows, options.json)?;
    if let Some(depths) = depths {
        for warning in optics.warnings(depths, options.limit_px, options.step_px)? {
            say!("warning: {warning}");
        }
    }
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

fn size(size: GridSize) -> Value {
    json!({ "columns": size.columns, "rows": size.rows })
}

fn rows(options: &OpticsOptions, optics: &Optics, depths: Option<DepthRange>) -> Result<Vec<Quantity>, Failure> {
    let mut rows = Vec::new();
    let mut row = |key: &str, name: &str, value, unit| rows.push(Quantity::new(key, name, value, unit));
    let rig = optics.rig();
    let shape = rig.shape();
    let range = |range: DepthRange| json!([json_number(range.near_m), json_number(range.far_m)]);
    row("views", "views", size(shape.views()), "");
    row("lenses", "lenses (pixels of a view)", size(shape.lenses()), "");
    row("focal_length_mm", "focal length", json_number(rig.focal_length_m() * 1e3), "mm");
    row("sensor_size_mm", "larger image side on the sensor", json_number(rig.sensor_size_m() * 1e3), "mm");
    row("focus_distance_m", "focus distance", json_number(rig.focus_distance_m()), "m");
    row("baseline_mm", "baseline (between adjacent views)", json_number(rig.baseline_x_m() * 1e3), "mm");
    row("aperture_mm", "synthetic aperture (first to last view)", json_number(optics.aperture_m() * 1e3), "mm");
    let f_number = rig.focal_length_m() / optics.aperture_m();
    row("f_number", "f-number of that aperture", json_number(f_number), "");
    row("angular_step_mrad", "angle between views at the focus", json_number(optics.angular_step_rad() * 1e3), "mrad");
    if rig.focus_distance_m().is_finite() {
        let pixel = optics.pixel_size_m(rig.focus_distance_m()) * 1e3;
        row("pixel_at_focus_mm", "a pixel of a view at the focus", json_number(pixel), "mm");
    }
    let smooth = optics.angular_depth_of_field(1.0)?;
    row("smooth_depths_m", "depths that move at most 1 px a view", range(smooth), "m");
    let sharp = optics.defocus_depth_of_field(options.circle_px)?;
    row("depth_of_field_m", "depth of field of all views together", range(sharp), "m");
    row("hyperfocal_m", "hyperfocal distance", json_number(optics.hyperfocal_m(options.circle_px)?), "m");
    if let Some(depths) = depths {
        row("depths_m", "depths", range(depths), "m");
        let DisparityRange { min_px, max_px } = optics.disparity_range_px(depths);
        row("disparity_px", "their disparities", json!([json_number(min_px), json_number(max_px)]), "px");
        let near = optics.depth_resolution_m(depths.near_m, options.step_px)?;
        row("depth_resolution_near_mm", "one step of disparity at the nearest", json_number(near * 1e3), "mm");
        if depths.far_m.is_finite() {
            let far = optics.depth_resolution_m(depths.far_m, options.step_px)?;
            row("depth_resolution_far_mm", "one step of disparity at the farthest", json_number(far * 1e3), "mm");
        }
    }
    Ok(rows)
}
