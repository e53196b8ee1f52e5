//! `holo optics`: what a camera will see, before it is built or rendered; and the camera that sees what is wanted.

use holo_core::optics::{CameraDesign, DepthRange, DisparityRange, Optics, rig_for_disparities};
use holo_core::{GridSize, Intrinsics, LightFieldShape, Remainder, Rig, Sensor, automatic_baseline_m};
use holo_dataset::Focus;
use holo_io::Limits;
use serde_json::{Map, Value, json};

use crate::arguments::OpticsOptions;
use crate::console::{out, say};
use crate::failure::Failure;

/// Views of the paper's camera.
const VIEWS: GridSize = GridSize::new(100, 100);

pub fn run(options: &OpticsOptions) -> Result<(), Failure> {
    let depths = options.depths_m.map(|(near_m, far_m)| DepthRange::new(near_m, far_m)).transpose()?;
    let rig = match &options.input {
        Some(input) => holo_io::read_rig(input, &Limits::default())?.ok_or_else(|| {
            Failure::Usage(format!("{}: no rig is known; is there a parameters.cfg beside it?", input.display()))
        })?,
        None => rig(options, depths)?,
    };
    let optics = Optics::new(rig)?;
    let rows = rows(options, &optics, depths)?;
    if options.json {
        let object: Map<String, Value> = rows.into_iter().map(|row| (row.key.into(), row.value)).collect();
        out!("{}", Value::Object(object))?;
    } else {
        rows.iter().try_for_each(|row| out!("{:<44} {}", row.name, row.text()))?;
    }
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
        let split = design.shape()?.shape;
        return match wanted(options, depths, intrinsics, split)? {
            Some(rig) => Ok(rig),
            None => Ok(CameraDesign { focus_distance_m: focus_m(options, depths)?, ..design }.rig()?),
        };
    }
    let views = options.views.unwrap_or(VIEWS);
    let split = match options.lenses {
        Some(lenses) => LightFieldShape::new(views, lenses)?,
        None => sensor_split(options.main_lens.sensor, views)?,
    };
    if let Some(rig) = wanted(options, depths, intrinsics, split)? {
        return Ok(rig);
    }
    let baseline_m = match options.baseline_m {
        Some(baseline_m) => baseline_m,
        None => automatic_baseline_m(intrinsics.focal_length_m, f_number, views)?,
    };
    with(split, intrinsics, baseline_m, focus_m(options, depths)?)
}

fn sensor_split(sensor: Sensor, views: GridSize) -> Result<LightFieldShape, Failure> {
    Ok(sensor.divide(views, Remainder::Crop)?.shape)
}

fn with(
    split: LightFieldShape,
    intrinsics: Intrinsics,
    baseline_m: f64,
    focus_distance_m: f64,
) -> Result<Rig, Failure> {
    Ok(Rig::builder(split).intrinsics(intrinsics).baseline_m(baseline_m).focus_distance_m(focus_distance_m).build()?)
}

/// The rig with the disparities that were asked for, if any were.
fn wanted(
    options: &OpticsOptions,
    depths: Option<DepthRange>,
    intrinsics: Intrinsics,
    split: LightFieldShape,
) -> Result<Option<Rig>, Failure> {
    let (Some((min_px, max_px)), Some(depths)) = (options.disparity, depths) else { return Ok(None) };
    let found = rig_for_disparities(depths, DisparityRange { min_px, max_px }, intrinsics, split.lenses())?;
    with(split, intrinsics, found.baseline_m, found.focus_distance_m).map(Some)
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

/// One line of the table.
struct Row {
    key: &'static str,
    name: &'static str,
    value: Value,
    unit: &'static str,
}

impl Row {
    /// Of a range both ends.
    fn text(&self) -> String {
        let number = |value: &Value| match value.as_f64() {
            Some(number) => five_digits(number),
            None => value.as_str().unwrap_or_default().to_owned(),
        };
        let text = match &self.value {
            Value::Array(ends) => ends.iter().map(number).collect::<Vec<_>>().join(" to "),
            Value::Object(size) => format!("{} x {}", size["columns"], size["rows"]),
            other => number(other),
        };
        format!("{text} {}", self.unit).trim_end().to_owned()
    }
}

/// A number with five significant digits, or all before the point if they are more.
fn five_digits(number: f64) -> String {
    let before_point = if number == 0.0 { 0 } else { number.abs().log10().floor() as i32 };
    let text = format!("{number:.*}", (4 - before_point).clamp(0, 300) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number; JSON has no infinity.
fn finite(number: f64) -> Value {
    if number.is_finite() { json!(number) } else { json!("inf") }
}

fn size(size: GridSize) -> Value {
    json!({ "columns": size.columns, "rows": size.rows })
}

fn rows(options: &OpticsOptions, optics: &Optics, depths: Option<DepthRange>) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    let mut row = |key, name, value, unit| rows.push(Row { key, name, value, unit });
    let rig = optics.rig();
    let split = rig.shape();
    let range = |range: DepthRange| json!([finite(range.near_m), finite(range.far_m)]);
    row("views", "views", size(split.views()), "");
    row("lenses", "lenses (pixels of a view)", size(split.lenses()), "");
    row("focal_length_mm", "focal length", finite(rig.focal_length_m() * 1e3), "mm");
    row("sensor_size_mm", "larger image side on the sensor", finite(rig.sensor_size_m() * 1e3), "mm");
    row("focus_distance_m", "focus distance", finite(rig.focus_distance_m()), "m");
    row("baseline_mm", "baseline (between neighbouring views)", finite(rig.baseline_x_m() * 1e3), "mm");
    row("aperture_mm", "synthetic aperture (first to last view)", finite(optics.aperture_m() * 1e3), "mm");
    let f_number = rig.focal_length_m() / optics.aperture_m();
    row("f_number", "f-number of that aperture", finite(f_number), "");
    row("angular_step_mrad", "angle between views at the focus", finite(optics.angular_step_rad() * 1e3), "mrad");
    if rig.focus_distance_m().is_finite() {
        let pixel = optics.pixel_size_m(rig.focus_distance_m()) * 1e3;
        row("pixel_at_focus_mm", "a pixel of a view at the focus", finite(pixel), "mm");
    }
    let smooth = optics.angular_depth_of_field(1.0)?;
    row("smooth_depths_m", "depths that move at most 1 px a view", range(smooth), "m");
    let sharp = optics.defocus_depth_of_field(options.circle_px)?;
    row("depth_of_field_m", "depth of field of all views together", range(sharp), "m");
    row("hyperfocal_m", "hyperfocal distance", finite(optics.hyperfocal_m(options.circle_px)?), "m");
    if let Some(depths) = depths {
        row("depths_m", "depths", range(depths), "m");
        let DisparityRange { min_px, max_px } = optics.disparity_range_px(depths);
        row("disparity_px", "their disparities", json!([finite(min_px), finite(max_px)]), "px");
        let near = optics.depth_resolution_m(depths.near_m, options.step_px)?;
        row("depth_resolution_near_mm", "one step of disparity at the nearest", finite(near * 1e3), "mm");
        if depths.far_m.is_finite() {
            let far = optics.depth_resolution_m(depths.far_m, options.step_px)?;
            row("depth_resolution_far_mm", "one step of disparity at the farthest", finite(far * 1e3), "mm");
        }
    }
    Ok(rows)
}
