//! Disparity estimated from the views by a plane sweep, for four efforts.

use holo_core::metrics::{Region, disparity_scores, trivial_constant, trivial_plane};
use holo_core::{Effort, GridSize, PlaneSweepOptions, plane_sweep};
use holo_render::{Integrator, Layer, Request, exposure};

use crate::plot::{Plot, Series};
use crate::scenes::{FramedScene, sky};
use crate::table::{Table, short, timed};
use crate::{RunOptions, Section};

/// The efforts with their names.
const EFFORTS: [(Effort, &str); 4] =
    [(Effort::Draft, "draft"), (Effort::Fast, "fast"), (Effort::Balanced, "balanced"), (Effort::Thorough, "thorough")];

pub fn section(options: &RunOptions) -> Section {
    let lenses = if options.quick { GridSize::new(120, 180) } else { GridSize::new(300, 450) };
    let samples = if options.quick { 4 } else { 16 };
    let mut table = Table::new(&[
        "scene",
        "effort",
        "seconds",
        "BadPix(0.07), %",
        "MSE x 100",
        "Q25 x 100",
        "BadPix of the best constant disparity",
        "BadPix of the best plane",
    ]);
    let mut highlights = Vec::new();
    let mut plot = Plot::new("Stereo: time against bad pixels", "seconds", "BadPix(0.07), %");
    for (color, scene_name) in ["mountains", "dominoes", "garden"].into_iter().enumerate() {
        let framed = FramedScene::new(scene_name, 9, lenses, Some(0.003 * 300.0 / lenses.rows as f64));
        let renderer = framed.renderer(options.engines[0], None);
        let integrator = Integrator::Direct;
        let request = Request::new(framed.rig).integrator(integrator).samples(samples).sky(sky(scene_name));
        let rendered = renderer.render(&request, &()).expect("a render");
        let light = rendered.color.expect("the scene is lit");
        let coded = exposure::encode_8bit(&light, exposure::automatic_exposure(&light)).expect("an image");
        let ground_truth = rendered.central[Layer::Disparity].index_axis(ndarray::Axis(2), 0).to_owned();
        let finite = ground_truth.iter().copied().filter(|d| d.is_finite());
        let (low, high) = finite.fold((f32::MAX, f32::MIN), |(low, high), d| (low.min(d), high.max(d)));
        let region = Region::with_border(15);
        let constant = trivial_constant(&ground_truth, 0.07, &region).expect("a map").bad_pixels_percent;
        let plane = trivial_plane(&ground_truth, 0.07, &region).expect("a map").bad_pixels_percent;
        let mut points = Vec::new();
        for (effort, name) in EFFORTS {
            let sweep = PlaneSweepOptions::default().range_px(low - 0.1, high + 0.1).effort(effort);
            let (seconds, estimate) =
                timed(options.rounds.min(3), || plane_sweep(&coded, &sweep).expect("an estimate").disparity_px);
            let scores = disparity_scores(&estimate, &ground_truth, &region).expect("maps of one size");
            points.push((seconds.median, scores.bad_pixels_percent[2]));
            if effort == Effort::Balanced {
                highlights.push([
                    format!("disparity from stereo: `{scene_name}`, {name}"),
                    format!("{} s", seconds.text()),
                    format!("{} % of pixels off by more than 0.07 px", short(scores.bad_pixels_percent[2])),
                ]);
            }
            table.push([
                scene_name.into(),
                name.into(),
                seconds.text(),
                short(scores.bad_pixels_percent[2]),
                short(scores.mean_squared_error_x100),
                short(scores.q25_x100),
                short(constant),
                short(plane),
            ]);
        }
        plot.add(Series { name: scene_name.into(), color, dashes: 0, points });
    }
    Section {
        text: format!(
            "Plane sweep over 9 x 9 views of {} x {} px in 8 bits, {samples} samples per pixel, direct light. Errors \
             are against the exact disparity of the central view without a border of 15 px.",
            lenses.columns, lenses.rows
        ),
        highlights,
        table,
        plots: vec![("stereo", plot.svg())],
    }
}
