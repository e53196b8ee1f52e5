//! Time against noise of every integrator and engine, on scenes with every kind of light.

use holo_core::{GridSize, LightFieldOwned};
use holo_render::{Integrator, Request};

use crate::plot::{Plot, Series};
use crate::scenes::{Ready, name, sky};
use crate::sheet::{Sheet, short, timed};
use crate::{Section, Wish};

const SCENES: [&str; 4] = ["garden", "plaster", "chess", "glasses"];

/// Added to the square of the reference in the relative squared error, so that black pixels do not decide alone.
const EPSILON: f64 = 1e-2;

pub fn section(wish: &Wish) -> Section {
    let (views, lenses) = if wish.quick { (6, GridSize::new(12, 18)) } else { (8, GridSize::new(24, 36)) };
    let samples: &[u32] = if wish.quick { &[1, 4, 16] } else { &[1, 4, 16, 64] };
    let reference_samples = if wish.quick { 256 } else { 512 };
    let mut sheet = Sheet::new(&[
        "scene",
        "integrator",
        "engine",
        "samples",
        "seconds",
        "Mrays/s",
        "Msamples/s",
        "RMSE",
        "relative MSE",
        "time x relMSE",
    ]);
    let mut plots = Vec::new();
    for (integrator, word, plot_name) in
        [(Integrator::Direct, "direct", "light_direct"), (Integrator::Path, "path", "light_path")]
    {
        let mut plot = Plot::new(
            &format!("{word}: time against noise, {views} x {views} views of {} x {} px", lenses.columns, lenses.rows),
            "seconds",
            "relative squared error",
        );
        for (color, scene_name) in SCENES.into_iter().enumerate() {
            let ready = Ready::new(scene_name, views, lenses, None);
            let request = Request { integrator, sky: sky(scene_name), ..Request::new(ready.rig) };
            let renderer = ready.renderer(wish.engines[0], 0);
            let reference = Request { samples: reference_samples, seed: 0xBEEF, ..request.clone() };
            let reference = renderer.render(&reference, &()).expect("a render").color.expect("a picture");
            drop(renderer);
            for (dashes, &engine) in wish.engines.iter().enumerate() {
                let renderer = ready.renderer(engine, 0);
                let mut points = Vec::new();
                for &samples in samples {
                    // What takes long scatters little.
                    let rounds = if samples > 4 { wish.rounds.min(3) } else { wish.rounds };
                    let request = Request { samples, ..request.clone() };
                    let (seconds, rendered) = timed(rounds, || renderer.render(&request, &()).expect("a render"));
                    let [rmse, relative] = errors(&rendered.color.expect("a picture"), &reference);
                    points.push((seconds.median, relative));
                    sheet.push([
                        scene_name.into(),
                        word.into(),
                        name(engine).into(),
                        samples.to_string(),
                        seconds.text(),
                        short(rendered.rays.total() as f64 / seconds.median / 1e6),
                        short(rendered.samples as f64 / seconds.median / 1e6),
                        short(rmse),
                        short(relative),
                        short(seconds.median * relative),
                    ]);
                }
                plot.add(Series { name: format!("{scene_name}, {}", name(engine)), color, dashes, points });
            }
        }
        plots.push((plot_name, plot.svg()));
    }
    Section {
        title: "Light",
        text: format!(
            "Gallery scenes, {views} x {views} views of {} x {} px, all threads, paths of up to 8 bounces. Reference: {reference_samples} \
             samples of another seed, same integrator. Relative squared error: the mean of (x - r)^2 / (r^2 + {EPSILON}). Time times \
             error says which is better whatever the samples: halving it is twice as fast.",
            lenses.columns, lenses.rows
        ),
        sheet,
        plots,
    }
}

/// Root mean squared and mean relative squared difference.
fn errors(picture: &LightFieldOwned<f32>, reference: &LightFieldOwned<f32>) -> [f64; 2] {
    let (mut squares, mut relative) = (0.0, 0.0);
    for (&x, &r) in picture.samples().iter().zip(reference.samples()) {
        let (x, r) = (f64::from(x), f64::from(r));
        squares += (x - r).powi(2);
        relative += (x - r).powi(2) / (r * r + EPSILON);
    }
    let count = picture.samples().len() as f64;
    [(squares / count).sqrt(), relative / count]
}
