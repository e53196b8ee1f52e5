//! The optics of rigs and plenoptic cameras as named numbers.

use holo_core::optics::{CameraDesign, DepthRange, DisparityRange, Optics, rig_for_disparities};
use holo_core::plenoptic::{Aberrations, PlenopticCamera, PlenopticMode};
use holo_core::{Intrinsics, LightFieldShape, Remainder, Rig, automatic_baseline_m};

use super::quantity::NamedQuantity;
use super::quantity::QuantityValue::{Count, List, Matrix, Number, Range, Size, Text};
use crate::Error;
use crate::settings::{Focus, Pixels, RigSettings, Spacing};
use crate::shot::shifted;

/// The wavelength of the Airy disc, m: green light.
const WAVELENGTH_M: f64 = 550e-9;

/// Sensors with more pixels are judged by some of their rows, which have about this many.
const MOST_PIXELS: usize = 1 << 26;

/// Places from the axis to the corner at which a lens of glass is judged, but for the axis.
const FIELDS: usize = 5;

/// The F and the C line, nm.
const F_LINE_NM: f64 = 486.1327;
const C_LINE_NM: f64 = 656.2725;

/// The rows of a band of these pixels.
const BAND_ROWS: usize = 512;

/// Returns the properties of a plenoptic camera, and at `depths_m` those of points there.
///
/// # Errors
/// [`Error::Core`] if there is not enough memory for its white image.
pub fn camera_optics(camera: &PlenopticCamera, depths_m: &[f64]) -> Result<Vec<NamedQuantity>, Error> {
    let mut rows: Vec<NamedQuantity> = Vec::new();
    let mut row = |key: &str, name: &str, value, unit| rows.push(NamedQuantity::new(key, name, value, unit));
    let (sensor, array, lens) = (camera.sensor(), camera.array(), camera.main_lens());
    let (pixel_m, gap_m) = (sensor.pixel_m, array.gap_m);
    let types = 0..array.type_count();
    let mm = |meters: f64| Number(meters * 1e3);
    row("sensor_px", "sensor", Size(sensor.size), "px");
    let modes = types.clone().map(|k| mode_name(camera.mode(k))).collect::<Vec<_>>();
    row("mode", "microlenses", Text(modes.join(", ")), "");
    row("mla_distance_mm", "main lens from the array (D)", mm(camera.mla_distance_m()), "mm");
    row("exit_pupil_mm", "exit pupil from the array (D_X)", mm(camera.exit_pupil_m()), "mm");
    row("entrance_pupil_mm", "entrance pupil from the main lens", mm(camera.entrance_pupil_offset_m()), "mm");
    row("focus_distance_m", "focus distance, from the entrance pupil", Number(1.0 / camera.inverse_focus_per_m()), "m");
    let pupil_f = camera.exit_pupil_m() / (2.0 * camera.exit_pupil_radius_m());
    let lens_f = gap_m / (2.0 * array.aperture.half_width_m());
    row("pupil_f_number", "f-number of the exit pupil, seen from the array", Number(pupil_f), "");
    row("microlens_f_number", "f-number of the microlenses, seen from the sensor", Number(lens_f), "");
    let pitch_px = camera.micro_image_pitch_px();
    let half_px = camera.micro_image_radii_m(0)[1] / pixel_m;
    let matching = lens.f_number * 2.0 * half_px / pitch_px;
    row("matching_f_number", "f-number of the main lens whose micro-images touch", Number(matching), "");
    row("alpha", "alpha of every type", List(types.clone().map(|k| camera.alpha(k)).collect()), "");
    row("micro_image_pitch_px", "distance between micro-images", Number(pitch_px), "px");
    let radii = camera.micro_image_radii_m(0).map(|radius| radius / pixel_m);
    row("micro_image_radii_px", "micro-image: fully lit, half, dark", List(radii.to_vec()), "px");
    row("lenses", "micro-images on the sensor", Count(camera.lens_count()), "");
    row("lit_share", "pixels that light reaches", Number(100.0 * lit_share(camera)?), "%");
    let corner = f64::from(corner_light(camera)?);
    row("corner_light", "light of a micro-image in the corner", Number(100.0 * corner), "%");
    let airy_m = 1.22 * WAVELENGTH_M * gap_m / (2.0 * array.aperture.half_width_m());
    row("airy_radius_px", "radius of the Airy disc at 550 nm", Number(airy_m / pixel_m), "px");
    let is_unfocused = camera.mode(0) == PlenopticMode::Unfocused;
    let views = camera.equivalent_views();
    if camera.has_rendered_views() {
        row("views", "views along each axis", Count(camera.decodable_views()?), "");
    }
    if is_unfocused {
        if let Some(views) = camera.decodable_views().ok().filter(|_| !camera.has_rendered_views()) {
            row("views", "views along each axis that are fully lit", Count(views), "");
        }
        row("baseline_mm", "baseline (between the views of neighboring pixels)", mm(views.baseline_m), "mm");
        row("slope_per_lens", "slope between microlenses", Number(views.slope_per_lens), "m/m");
        let scale = views.baseline_m / views.slope_per_lens;
        row("disparity_scale_m_px", "disparity scale (Eq. 3: k)", Number(scale), "m px");
        row("cos4_disparity_px", "disparity that the cos^4 law adds", Number(views.cos4_disparity_px), "px");
    }
    for &depth_m in depths_m {
        let at = |what: &str| format!("{what} at {depth_m} m");
        let key = |what: &str| format!("{what}_at_{depth_m}m");
        if is_unfocused {
            let scale = views.baseline_m / views.slope_per_lens;
            let disparity = scale * (1.0 / depth_m - views.inverse_focus_per_m);
            row(&key("disparity_px"), &at("disparity"), Number(disparity), "px");
        }
        row(&key("virtual_depth"), &at("virtual depth"), Number(camera.virtual_depth(depth_m)), "gaps");
        let blur = types.clone().map(|k| 2.0 * camera.blur_radius_px(depth_m, k).abs()).collect();
        row(&key("blur_px"), &at("blur of every type"), List(blur), "px");
    }
    rows.extend(glass_optics(camera));
    Ok(rows)
}

/// The properties of a main lens of glass: what it does otherwise than a thin lens, from the axis to the corner of the sensor.
fn glass_optics(camera: &PlenopticCamera) -> Vec<NamedQuantity> {
    let Some(lens) = &camera.main_lens().prescription else { return Vec::new() };
    let size = camera.sensor().size;
    let corner_m = [[0.0, 0.0], [size.columns as f64, size.rows as f64]].map(|corner| camera.place_m(corner));
    let corner_m = corner_m.map(|[x, y]| x.hypot(y)).into_iter().fold(0.0, f64::max) / camera.micro_image_scale();
    let field: Vec<_> = (0..=FIELDS).filter_map(|k| camera.aberrations(corner_m * k as f64 / FIELDS as f64)).collect();
    let paraxial = lens.paraxial();
    let list = |value: fn(&Aberrations) -> f64| List(field.iter().map(value).collect());
    let chromatic = [F_LINE_NM, C_LINE_NM].map(|nm| camera.chromatic_shift_m(nm).unwrap_or_default() * 1e3);
    let um = "\u{b5}m";
    [
        ("focal_length_mm", "focal length", Number(paraxial.focal_length_m * 1e3), "mm"),
        ("f_number", "f-number", Number(paraxial.f_number), ""),
        ("back_focal_mm", "image of infinity from the last surface", Number(paraxial.back_focal_m * 1e3), "mm"),
        ("chromatic_shift_mm", "focus of 486 and 656 nm behind that of 588 nm", List(chromatic.to_vec()), "mm"),
        ("field_mm", "places on the array, from the axis", list(|at| at.field_m * 1e3), "mm"),
        ("distortion", "distortion there", list(|at| at.distortion * 100.0), "%"),
        ("pupil_share", "light that vignetting leaves", list(|at| at.pupil_share * 100.0), "%"),
        ("spot_um", "spot of a point in focus (RMS)", list(|at| at.spot_m * 1e6), um),
        ("sagittal_mm", "sagittal focus behind the array", list(|at| at.sagittal_m * 1e3), "mm"),
        ("tangential_mm", "tangential focus behind the array", list(|at| at.tangential_m * 1e3), "mm"),
        ("lateral_color_um", "486 nm farther from the axis than 656 nm", list(|at| at.lateral_color_m * 1e6), um),
    ]
    .map(|(key, name, value, unit)| NamedQuantity::new(key, name, value, unit))
    .into()
}

/// The share of pixels that light reaches: of all of them, or on large sensors of some bands of rows, evenly spread.
fn lit_share(camera: &PlenopticCamera) -> Result<f64, Error> {
    let size = camera.sensor().size;
    let bands = size.rows.div_ceil(BAND_ROWS);
    let step = size.count().div_ceil(MOST_PIXELS).max(1);
    let (mut lit, mut all) = (0, 0);
    for band in (0..bands).step_by(step) {
        let white = camera.white_rows(band * BAND_ROWS..(band + 1) * BAND_ROWS)?;
        lit += white.iter().filter(|&&light| light > 0.0).count();
        all += white.len();
    }
    Ok(lit as f64 / all as f64)
}

/// The brightest pixel of a block in the corner.
fn corner_light(camera: &PlenopticCamera) -> Result<f32, Error> {
    /// Rows and columns of the block.
    const SIDE: usize = 64;
    let white = camera.white_rows(0..SIDE)?;
    let corner = white.indexed_iter().filter(|((_, column), _)| *column < SIDE);
    Ok(corner.fold(0.0, |most, (_, &light)| most.max(light)))
}

fn mode_name(mode: PlenopticMode) -> &'static str {
    match mode {
        PlenopticMode::Unfocused => "unfocused (plenoptic 1.0)",
        PlenopticMode::Keplerian => "focused, Keplerian",
        PlenopticMode::Galilean => "focused, Galilean",
    }
}

/// Returns the properties of a rig, and those of a range of depths: the depth of field of views in which a point may be
/// `circle_px` wide, and the depth that `step_px` of disparity tell apart.
///
/// # Errors
/// [`Error::Core`] for a rig without baseline, or limits that are not above 0.
pub fn rig_optics(
    optics: &Optics,
    depths: Option<DepthRange>,
    circle_px: f64,
    step_px: f64,
) -> Result<Vec<NamedQuantity>, Error> {
    let mut rows: Vec<NamedQuantity> = Vec::new();
    let mut row = |key: &str, name: &str, value, unit| rows.push(NamedQuantity::new(key, name, value, unit));
    let rig = optics.rig();
    let shape = rig.shape();
    let range = |range: DepthRange| Range([range.near_m, range.far_m]);
    row("views", "views", Size(shape.views()), "");
    row("lenses", "lenses (pixels of a view)", Size(shape.lenses()), "");
    row("focal_length_mm", "focal length", Number(rig.focal_length_m() * 1e3), "mm");
    row("sensor_size_mm", "larger image side on the sensor", Number(rig.sensor_size_m() * 1e3), "mm");
    row("focus_distance_m", "focus distance", Number(rig.focus_distance_m()), "m");
    row("baseline_mm", "baseline (between adjacent views)", Number(rig.baseline_x_m() * 1e3), "mm");
    row("aperture_mm", "synthetic aperture (first to last view)", Number(optics.aperture_m() * 1e3), "mm");
    let f_number = rig.focal_length_m() / optics.aperture_m();
    row("f_number", "f-number of that aperture", Number(f_number), "");
    row("angular_step_mrad", "angle between views at the focus", Number(optics.angular_step_rad() * 1e3), "mrad");
    if rig.focus_distance_m().is_finite() {
        let pixel = optics.pixel_size_m(rig.focus_distance_m()) * 1e3;
        row("pixel_at_focus_mm", "a pixel of a view at the focus", Number(pixel), "mm");
    }
    let matrix = rig.intrinsic_matrix(1).map(|row| row.to_vec());
    row("intrinsic_matrix", "ray (x, y, dx, dy, 1) of (s, t, u, v, 1), from 1", Matrix(matrix.to_vec()), "");
    let smooth = optics.angular_depth_of_field(1.0)?;
    row("smooth_depths_m", "depths that move at most 1 px a view", range(smooth), "m");
    let sharp = optics.defocus_depth_of_field(circle_px)?;
    row("depth_of_field_m", "depth of field of all views together", range(sharp), "m");
    row("hyperfocal_m", "hyperfocal distance", Number(optics.hyperfocal_m(circle_px)?), "m");
    if let Some(depths) = depths {
        row("depths_m", "depths", range(depths), "m");
        let DisparityRange { min_px, max_px } = optics.disparity_range_px(depths);
        row("disparity_px", "their disparities", Range([min_px, max_px]), "px");
        let near = optics.depth_resolution_m(depths.near_m, step_px)?;
        row("depth_resolution_near_mm", "one step of disparity at the nearest", Number(near * 1e3), "mm");
        if depths.far_m.is_finite() {
            let far = optics.depth_resolution_m(depths.far_m, step_px)?;
            row("depth_resolution_far_mm", "one step of disparity at the farthest", Number(far * 1e3), "mm");
        }
    }
    Ok(rows)
}

/// Returns the rig that settings describe without a scene: with `depths` instead, for disparities and an automatic focus,
/// and the pitch of the microlenses instead of a number of views.
///
/// # Errors
/// [`Error::BadRequest`] if disparities or focus need depths, or there is no focal length; [`Error::Core`] for an impossible
/// rig.
pub fn planned_rig(
    settings: &RigSettings,
    lens_pitch_mm: Option<f64>,
    depths: Option<DepthRange>,
) -> Result<Rig, Error> {
    let focal_mm = settings.focal_mm.ok_or_else(|| Error::BadRequest("give a focal length: `focal-mm`".into()))?;
    // Divided, because 1e-3 is not exact: 36 mm times it is not 0.036 m.
    let intrinsics = Intrinsics { focal_length_m: focal_mm / 1e3, sensor_size_m: settings.sensor_mm / 1e3 };
    if let Some(lens_pitch_mm) = lens_pitch_mm {
        let (Pixels::Sensor(sensor), Spacing::FNumber(f_number)) = (settings.pixels, settings.spacing) else {
            let what = "`lens-pitch-mm` divides a sensor behind a main lens; give `sensor` and `f-number` with it";
            return Err(Error::BadRequest(what.into()));
        };
        let focus_distance_m = planned_focus_m(settings, depths)?;
        return Ok(CameraDesign {
            sensor,
            sensor_size_m: intrinsics.sensor_size_m,
            lens_pitch_m: lens_pitch_mm / 1e3,
            focal_length_m: intrinsics.focal_length_m,
            f_number,
            focus_distance_m,
        }
        .rig()?);
    }
    let shape = match settings.pixels {
        Pixels::Lenses(lenses) => LightFieldShape::new(settings.views, lenses)?,
        Pixels::Sensor(sensor) => sensor.divide(settings.views, Remainder::Crop)?.shape,
        Pixels::OfPoses => return Err(Error::BadRequest("give the pixels of a view: `lenses` or `sensor`".into())),
    };
    let shape = shifted(settings, shape)?;
    let (baseline_m, focus_m) = match settings.spacing {
        Spacing::DisparitiesPx((min_px, max_px)) => {
            let which = || Error::BadRequest("`disparity` needs the depths of the scene: give `depths-m`".into());
            let depths = depths.ok_or_else(which)?;
            let range = DisparityRange { min_px, max_px };
            let found = rig_for_disparities(depths, range, intrinsics, shape.lenses())?;
            (found.baseline_m, found.focus_distance_m)
        }
        Spacing::BaselineM(baseline_m) => (baseline_m, planned_focus_m(settings, depths)?),
        Spacing::FNumber(f_number) => {
            let baseline_m = automatic_baseline_m(intrinsics.focal_length_m, f_number, settings.views)?;
            (baseline_m, planned_focus_m(settings, depths)?)
        }
    };
    Ok(Rig::builder(shape).intrinsics(intrinsics).baseline_m(baseline_m).focus_distance_m(focus_m).build()?)
}

fn planned_focus_m(settings: &RigSettings, depths: Option<DepthRange>) -> Result<f64, Error> {
    match (settings.focus, depths) {
        (Focus::Meters(focus_m), _) => Ok(focus_m),
        // The harmonic mean, as a render does it: it halves the range of disparities.
        (Focus::Automatic, Some(depths)) => Ok(2.0 * depths.near_m / (1.0 + depths.near_m / depths.far_m)),
        (Focus::Automatic, None) => {
            Err(Error::BadRequest("where is the focus? give `focus-m`, or `depths-m` and it lies between them".into()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::plenoptic::Preset;

    /// The disparities of a plenoptic camera are those of the rig of its decoded views, and follow from the scale that is listed
    /// (Eq. 3). The views of a hexagonal array are resampled, so that their lenses are as far apart as its rows.
    #[test]
    fn disparities_are_those_of_decoded_views() {
        let camera = Preset::by_name("lytro-illum").unwrap().camera().unwrap();
        let rows = camera_optics(&camera, &[0.3, 2.0]).unwrap();
        let number = |key: &str| match rows.iter().find(|row| row.key == key).map(|row| &row.value) {
            Some(Number(number)) => *number,
            other => panic!("{key}: {other:?}"),
        };
        let [near, far] = ["disparity_px_at_0.3m", "disparity_px_at_2m"].map(number);
        let scale = number("disparity_scale_m_px");
        assert!((near - far - scale * (1.0 / 0.3 - 1.0 / 2.0)).abs() < 1e-9 * scale, "{near} {far} {scale}");
        let disparity = camera.decoded_rig(3).unwrap().disparity();
        for (listed, depth_m) in [(near, 0.3), (far, 2.0)] {
            let expected = disparity.from_depth_m(depth_m) * 0.75_f64.sqrt();
            assert!((listed / expected - 1.0).abs() < 1e-6, "{depth_m} m: {listed} {expected}");
        }
    }
}
