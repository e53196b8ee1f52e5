//! Depth from the views alone, for four efforts.

use holo_core::metrics::{Region, disparity_scores, trivial_constant, trivial_plane};
use holo_core::{Effort, GridSize, PlaneSweepOptions, plane_sweep};
use holo_render::{Integrator, Layer, Request, Sampling, exposure};

use crate::plot::{Plot, Series};
use crate::scenes::{Ready, sky};
use crate::sheet::{Sheet, short, timed};
use crate::{Section, Wish};

/// Efforts and the samplers of the pictures that they are tried on: all of them on pictures as they are usually made.
const TRIED: [(Effort, Sampling, &str, &str); 5] = [
    (Effort::Draft, Sampling::SharedPositions, "draft", "as usual"),
    (Effort::Fast, Sampling::SharedPositions, "fast", "as usual"),
    (Effort::Balanced, Sampling::SharedPositions, "balanced", "as usual"),
    (Effort::Thorough, Sampling::SharedPositions, "thorough", "as usual"),
    (Effort::Balanced, Sampling::OwnPositions, "balanced", "places of its own in every view"),
];

pub fn section(wish: &Wish) -> Section {
    let lenses = if wish.quick { GridSize::new(120, 180) } else { GridSize::new(300, 450) };
    let samples = if wish.quick { 4 } else { 16 };
    let mut sheet = Sheet::new(&[
        "scene",
        "sampling",
        "effort",
        "seconds",
        "BadPix(0.07), %",
        "MSE x 100",
        "Q25 x 100",
        "BadPix of the best constant",
        "of the best plane",
    ]);
    let mut highlights = Vec::new();
    let mut plot = Plot::new("Stereo: time against bad pixels", "seconds", "BadPix(0.07), %");
    for (color, scene_name) in ["mountains", "dominoes", "garden"].into_iter().enumerate() {
        let ready = Ready::new(scene_name, 9, lenses, Some(0.003 * 300.0 / lenses.rows as f64));
        let renderer = ready.renderer(wish.engines[0], 0);
        let integrator = Integrator::Direct;
        let request = Request { integrator, samples, sky: sky(scene_name), ..Request::new(ready.rig) };
        let render = |sampling| {
            let request = Request { sampling, ..request.clone() };
            let rendered = renderer.render(&request, &()).expect("a render");
            let color = rendered.color.expect("a picture");
            let stops = exposure::automatic_exposure(&color);
            let coded = exposure::encode_8bit(&color, stops).expect("a picture");
            (coded, rendered.central[Layer::Disparity].index_axis(ndarray::Axis(2), 0).to_owned())
        };
        let ((usual, truth), (own, _)) = (render(Sampling::SharedPositions), render(Sampling::OwnPositions));
        let finite = truth.iter().copied().filter(|d| d.is_finite());
        let (low, high) = finite.fold((f32::MAX, f32::MIN), |(low, high), d| (low.min(d), high.max(d)));
        let region = Region::with_border(15);
        let constant = trivial_constant(&truth, 0.07, &region).expect("a map").bad_pixels_percent;
        let plane = trivial_plane(&truth, 0.07, &region).expect("a map").bad_pixels_percent;
        let mut points = Vec::new();
        for (effort, sampler, name, sampling) in TRIED {
            let options = PlaneSweepOptions { effort, disparity_min_px: low - 0.1, disparity_max_px: high + 0.1 };
            let coded = if sampler == Sampling::SharedPositions { &usual } else { &own };
            let (seconds, estimate) =
                timed(wish.rounds.min(3), || plane_sweep(coded, &options).expect("an estimate").disparity_px);
            let scores = disparity_scores(&estimate, &truth, &region).expect("maps of one size");
            if sampler == Sampling::SharedPositions {
                points.push((seconds.median, scores.bad_pixels_percent[2]));
            }
            if (effort, sampler) == (Effort::Balanced, Sampling::SharedPositions) {
                highlights.push([
                    format!("depth from stereo: `{scene_name}`, {name}"),
                    format!("{} s", seconds.text()),
                    format!("{} % of pixels off by more than 0.07 px", short(scores.bad_pixels_percent[2])),
                ]);
            }
            sheet.push([
                scene_name.into(),
                sampling.into(),
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
             the central view, 15 px of border left out. Sampling: usually 4 x 4 views share the places within their pixels.",
            lenses.columns, lenses.rows
        ),
        highlights,
        sheet,
        plots: vec![("stereo", plot.svg())],
    }
}
