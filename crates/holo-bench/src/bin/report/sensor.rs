//! Image sensors: the photon transfer curve of every preset, and what their noise costs stereo and refocusing.

use holo_core::metrics::{Region, disparity_scores, psnr_db};
use holo_core::refocus::Refocus;
use holo_core::sensor::{ColorFilter, Demosaic, Exposure, SensorModel, SensorPreset, demosaic, sensor_presets};
use holo_core::{Effort, GridSize, LightField, LightFieldOwned, PlaneSweepOptions, plane_sweep};
use holo_render::{Integrator, Layer, Request, exposure};
use ndarray::{Array3, Axis};

use crate::plot::{Plot, Series};
use crate::scenes::{FramedScene, sky};
use crate::table::{Table, short};
use crate::{RunOptions, Section};

/// The share of saturation of the levels of a curve.
const LEVELS: [f64; 10] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8];

/// Film speeds, relative to the base speed.
const SPEEDS: [f64; 4] = [1.0, 4.0, 16.0, 64.0];

/// Photon transfer curves.
pub fn photon_transfer(options: &RunOptions) -> Section {
    let side = if options.quick { 256 } else { 1024 };
    let mut table = Table::new(&["sensor", "level of saturation", "mean, DN", "variance, DN^2", "slope / K"]);
    let mut plot = Plot::new("Photon transfer", "mean above black, DN", "variance, DN^2");
    let mut worst = 0.0f64;
    for (color, preset) in sensor_presets().iter().enumerate() {
        let sensor = SensorModel { filter: ColorFilter::Mono, hot_share: 0.0, ..preset.model };
        let (iso, gain) = (sensor.base_iso, sensor.gain(sensor.base_iso));
        let image = Array3::from_elem((side, side, 1), 1.0f32);
        let mut points = Vec::new();
        for level in LEVELS {
            let shot = Exposure::new(level * sensor.saturation_e(iso), iso);
            let expose = |frame| {
                let codes = sensor.expose(image.view(), &Exposure { frame, ..shot }, 1).expect("a sensor");
                codes.mapv(f64::from)
            };
            let (one, other) = (expose(0), expose(1));
            let count = one.len() as f64;
            let mean = (one.sum() + other.sum()) / (2.0 * count) - sensor.black;
            let difference = (one.sum() - other.sum()) / count;
            // Fixed patterns cancel in the difference of two frames (EMVA 1288, section 6.6).
            let squares: f64 = one.iter().zip(&other).map(|(a, b)| (a - b - difference).powi(2)).sum();
            let variance = squares / (2.0 * count);
            let own = gain * gain * (sensor.read_noise_e.powi(2) + sensor.row_noise_e.powi(2)) + 1.0 / 12.0;
            let slope = (variance - own) / mean / gain;
            worst = worst.max((slope - 1.0).abs());
            points.push((mean, variance));
            table.push([preset.name.into(), short(level), short(mean), short(variance), format!("{slope:.4}")]);
        }
        plot.add(Series { name: preset.name.into(), color, dashes: 0, points });
    }
    Section {
        text: format!(
            "Two frames of an even scene, {side} x {side} pixels without color filter, at ten levels: the variance of \
             their difference, by which fixed patterns cancel, against the mean (EMVA 1288). What reading and rounding \
             add is taken off the variance; the rest grows by the gain K, DN an electron."
        ),
        highlights: vec![[
            format!("photon transfer: {} sensors at ten levels", sensor_presets().len()),
            String::new(),
            format!("slope at most {} % from the gain", short(100.0 * worst)),
        ]],
        table,
        plots: vec![("photon_transfer", plot.svg())],
    }
}

/// How a sensor with a mosaic becomes a light field again.
#[derive(Clone, Copy)]
enum Color {
    /// Three colors in every pixel.
    Full,
    /// Each view has a mosaic of its own, as in an array of cameras.
    Views,
    /// The raw image has one mosaic, and neighboring pixels are those of neighboring views.
    Raw,
}

/// How, its name in the table, and in the legend.
const COLORS: [(Color, &str, &str); 3] = [
    (Color::Full, "three colors in every pixel", "three colors"),
    (Color::Views, "a mosaic in every view", "mosaics of views"),
    (Color::Raw, "one mosaic over the raw image", "one mosaic"),
];

/// Film speed against the errors of stereo and refocusing.
pub fn noise(options: &RunOptions) -> Section {
    let lenses = if options.quick { GridSize::new(100, 150) } else { GridSize::new(200, 300) };
    let samples = if options.quick { 16 } else { 64 };
    let mut table = Table::new(&[
        "scene",
        "light field",
        "ISO / base",
        "electrons of the brightest",
        "BadPix(0.07), %",
        "PSNR of a view, dB",
        "PSNR refocused, dB",
    ]);
    let mut plot = Plot::new("Noise: film speed against bad pixels", "ISO / base", "BadPix(0.07), %");
    let preset = SensorPreset::by_name("imx250").expect("a preset");
    for (color, scene_name) in ["mountains", "dominoes"].into_iter().enumerate() {
        let framed = FramedScene::new(scene_name, 9, lenses, Some(0.003 * 300.0 / lenses.rows as f64));
        let renderer = framed.renderer(options.engines[0], None);
        let request = Request::new(framed.rig).integrator(Integrator::Direct).samples(samples).sky(sky(scene_name));
        let rendered = renderer.render(&request, &()).expect("a render");
        let truth = rendered.central[Layer::Disparity].index_axis(Axis(2), 0).to_owned();
        let clean = rendered.color.expect("the scene is lit");
        let finite = truth.iter().copied().filter(|d| d.is_finite());
        let (low, high) = finite.fold((f32::MAX, f32::MIN), |(low, high), d| (low.min(d), high.max(d)));
        // Both have the exposure of the clean one.
        let stops = exposure::automatic_exposure(&clean);
        let coded = |field: &LightFieldOwned<f32>| exposure::encode_8bit(field, stops).expect("an image");
        let focused = |coded: &LightFieldOwned<u8>| {
            let refocus = Refocus::new(coded.shape().views()).expect("views");
            refocus.at_disparity(coded, 0.5 * (f64::from(low) + f64::from(high))).expect("an image")
        };
        let clean_coded = coded(&clean);
        let clean_focused = focused(&clean_coded);
        let mut measure = |field: &LightFieldOwned<f32>, name: &str, speed: Option<f64>, electrons: f64| {
            let coded = coded(field);
            let sweep = PlaneSweepOptions::default().range_px(low - 0.1, high + 0.1).effort(Effort::Balanced);
            let estimate = plane_sweep(&coded, &sweep).expect("an estimate").disparity_px;
            let scores = disparity_scores(&estimate, &truth, &Region::with_border(15)).expect("maps of one size");
            let view = |field: &LightFieldOwned<u8>| field.view(4, 4).expect("a view").to_owned();
            let view_psnr = psnr_db(&view(&coded), &view(&clean_coded), 255.0).expect("one size");
            let focused_psnr = psnr_db(&focused(&coded), &clean_focused, 255.0).expect("one size");
            let bad = scores.bad_pixels_percent[2];
            table.push([
                scene_name.into(),
                name.into(),
                speed.map_or("no sensor".into(), short),
                if electrons > 0.0 { short(electrons) } else { String::new() },
                short(bad),
                short(view_psnr),
                short(focused_psnr),
            ]);
            bad
        };
        measure(&clean, "rendered", None, 0.0);
        for (dashes, (kind, name, short_name)) in COLORS.into_iter().enumerate() {
            let mut points = Vec::new();
            for speed in SPEEDS {
                let (field, electrons) = seen(&clean, &preset.model, speed, kind);
                points.push((speed, measure(&field, name, Some(speed), electrons)));
            }
            plot.add(Series { name: format!("{scene_name}, {short_name}"), color, dashes, points });
        }
    }
    Section {
        text: format!(
            "9 x 9 views of {} x {} px, {samples} samples, through the sensor {} with automatic exposure: the gain takes \
             the light. Disparity by the plane sweep (balanced) against the exact one; refocused by shift and sum to the \
             middle of the range; PSNR against the same without a sensor. Mosaics are demosaiced by Malvar's method. One mosaic over \
             the raw image mixes views: its methods need micro-images that are larger than two pixels.",
            lenses.columns, lenses.rows, preset.name
        ),
        highlights: Vec::new(),
        table,
        plots: vec![("sensor_noise", plot.svg())],
    }
}

/// A light field as a sensor sees it, and the electrons of its brightest pixels.
fn seen(clean: &LightFieldOwned<f32>, model: &SensorModel, speed: f64, kind: Color) -> (LightFieldOwned<f32>, f64) {
    let filter = if matches!(kind, Color::Full) { ColorFilter::Rgb } else { model.filter };
    let sensor = SensorModel { filter, ..*model };
    let iso = speed * sensor.base_iso;
    let shape = clean.shape();
    let grid = match kind {
        Color::Views => clean.to_viewpoint_grid(),
        _ => clean.to_elemental_grid(),
    }
    .expect("memory");
    let exposure = Exposure::new(sensor.automatic_electrons(grid.view(), iso).expect("a sensor"), iso);
    let codes = sensor.expose(grid.view(), &exposure, 1).expect("a sensor");
    let light = codes.mapv(|code| sensor.linear(f64::from(code), &exposure) as f32);
    let color = match kind {
        Color::Full => light,
        _ => demosaic(light.index_axis(Axis(2), 0), filter, Demosaic::Malvar).expect("a mosaic"),
    };
    let color = sensor.rgb_from_camera(color);
    let field = match kind {
        Color::Views => LightField::from_viewpoint_grid(color, shape),
        _ => LightField::from_elemental_grid(color, shape),
    };
    (field.expect("the same shape"), sensor.saturation_e(iso))
}
