//! Depth from the views alone, for four efforts.

use holo_core::metrics::{Region, best_constant, best_plane, disparity_scores};
use holo_core::{Effort, GridSize, PlaneSweepOptions, plane_sweep};
use holo_render::{Integrator, Layer, Request, exposure};

use crate::plot::{Plot, Series};
use crate::scenes::{Ready, sky};
use crate::sheet::{Sheet, short, timed};
use crate::{Section, Wish};

pub fn section(wish: &Wish) -> Section {
    let lenses = if wish.quick { GridSize::new(120, 180) } else { GridSize::new(300, 450) };
    let samples = if wish.quick { 4 } else { 16 };
    let mut sheet = Sheet::new(&[
        "scene",
        "effort",
        "seconds",
        "BadPix(0.07), %",
        "MSE x 100",
        "Q25 x 100",
        "BadPix of the best constant",
        "of the best plane",
    ]);
    let mut plot = Plot::new("Stereo: time against bad pixels", "seconds", "BadPix(0.07), %");
    for (color, scene_name) in ["mountains", "dominoes", "garden"].into_iter().enumerate() {
        let ready = Ready::new(scene_name, 9, lenses, Some(0.003 * 300.0 / lenses.rows as f64));
        let renderer = ready.renderer(wish.engines[0], 0);
        let integrator = Integrator::Direct;
        let request = Request { integrator, samples, sky: sky(scene_name), ..Request::new(ready.rig) };
        let rendered = renderer.render(&request, &()).expect("a render");
        let color_field = rendered.color.expect("a picture");
        let stops = exposure::automatic_exposure(&color_field);
        let coded = exposure::encode_8bit(&color_field, stops).expect("a picture");
        let truth = rendered.central[Layer::Disparity].index_axis(ndarray::Axis(2), 0).to_owned();
        let finite = truth.iter().copied().filter(|d| d.is_finite());
        let (low, high) = finite.fold((f32::MAX, f32::MIN), |(low, high), d| (low.min(d), high.max(d)));
        let region = Region::with_border(15);
        let constant = best_constant(&truth, 0.07, &region).expect("a map").bad_pixels_percent;
        let plane = best_plane(&truth, 0.07, &region).expect("a map").bad_pixels_percent;
        let mut points = Vec::new();
        for (effort, name) in [
            (Effort::Draft, "draft"),
            (Effort::Fast, "fast"),
            (Effort::Balanced, "balanced"),
            (Effort::Thorough, "thorough"),
        ] {
            let options = PlaneSweepOptions { effort, disparity_min_px: low - 0.1, disparity_max_px: high + 0.1 };
            let (seconds, estimate) =
                timed(wish.rounds.min(3), || plane_sweep(&coded, &options).expect("an estimate").disparity_px);
            let scores = disparity_scores(&estimate, &truth, &region).expect("maps of one size");
            points.push((seconds.median, scores.bad_pixels_percent[2]));
            sheet.push([
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
        title: "Depth from stereo",
        text: format!(
            "Plane sweep over 9 x 9 views of {} x {} px in 8 bits, {samples} samples a pixel, direct light; held against exact disparity of \
             the central view, 15 px of border left out.",
            lenses.columns, lenses.rows
        ),
        sheet,
        plots: vec![("stereo", plot.svg())],
    }
}
