//! Time against noise of every integrator, backend and sampler, on two scenes of the gallery.

use holo_bench::error::{relative_squared_error, rgb, squared_difference};
use holo_core::{GridSize, LightFieldOwned};
use holo_render::{Backend, Integrator, Renderer, Request, Sampling};

use crate::plot::{Plot, Series};
use crate::scenes::{FramedScene, backend_name, integrator_label, integrator_name, sky};
use crate::table::{Seconds, Table, short, timed};
use crate::{RunOptions, Section};

const SCENES: [&str; 2] = ["garden", "glasses"];

/// The sampler and Russian roulette; `Default` is that of a render.
#[derive(Clone, Copy, PartialEq)]
enum Setting {
    Default,
    SharedPositions,
    Independent,
    NoRoulette,
}

impl Setting {
    fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::SharedPositions => "sample positions shared by 4 x 4 views",
            Self::Independent => "independent random numbers",
            Self::NoRoulette => "no Russian roulette",
        }
    }

    fn sampling(self) -> Sampling {
        match self {
            Self::Default | Self::NoRoulette => Sampling::OwnPositions,
            Self::SharedPositions => Sampling::SharedPositions,
            Self::Independent => Sampling::Independent,
        }
    }
}

/// The measured combinations: every backend with the default setting, then the fastest one with the other settings.
fn lines(engines: &[Backend], integrator: Integrator) -> Vec<(Backend, Setting)> {
    let mut lines: Vec<_> = engines.iter().map(|&engine| (engine, Setting::Default)).collect();
    lines.extend([Setting::SharedPositions, Setting::Independent].map(|setting| (engines[0], setting)));
    if integrator == Integrator::Path {
        lines.push((engines[0], Setting::NoRoulette));
    }
    lines
}

/// Repeated renders of one request: time, rays and samples of one render, errors against the reference.
struct Measurement {
    seconds: Seconds,
    rays: f64,
    samples: f64,
    rmse: f64,
    relative: f64,
}

impl Measurement {
    fn new(rounds: usize, renderer: &Renderer, request: &Request, reference: &LightFieldOwned<f32>) -> Self {
        let (seconds, rendered) = timed(rounds, || renderer.render(request, &()).expect("a render"));
        let [rmse, relative] = errors(&rendered.color.expect("the scene is lit"), reference);
        Self { seconds, rays: rendered.rays.total() as f64, samples: rendered.samples as f64, rmse, relative }
    }

    /// Time x relative squared error: inversely proportional to efficiency, independent of the number of samples.
    fn cost(&self) -> Seconds {
        Seconds { median: self.seconds.median * self.relative, ..self.seconds }
    }

    fn mrays_per_second(&self) -> String {
        short(self.rays / self.seconds.median / 1e6)
    }
}

/// The parameters and results of this section.
struct LightSection<'a> {
    options: &'a RunOptions,
    views: usize,
    lenses: GridSize,
    samples: &'static [u32],
    reference_samples: u32,
    table: Table,
    highlights: Vec<[String; 3]>,
}

pub fn section(options: &RunOptions) -> Section {
    let table = Table::new(&[
        "scene",
        "integrator",
        "engine",
        "sampling",
        "samples",
        "seconds",
        "Mrays/s",
        "Msamples/s",
        "RMSE",
        "relative MSE",
        "time x relMSE / fastest backend, default",
    ]);
    let mut light = LightSection {
        options,
        views: if options.quick { 6 } else { 8 },
        lenses: if options.quick { GridSize::new(12, 18) } else { GridSize::new(24, 36) },
        samples: if options.quick { &[1, 4, 16] } else { &[1, 4, 16, 64] },
        reference_samples: if options.quick { 256 } else { 512 },
        table,
        highlights: Vec::new(),
    };
    let plots = [(Integrator::Direct, "light_direct"), (Integrator::Path, "light_path")]
        .map(|(integrator, name)| (name, light.integrator(integrator)));
    let LightSection { views, lenses, reference_samples, .. } = light;
    Section {
        text: format!(
            "Gallery scenes, {views} x {views} views of {} x {} px, all threads, paths of up to 8 bounces. Reference: \
             {reference_samples} samples with another seed, same integrator. Relative squared error: the mean of (x - \
             r)^2 / (r^2 + 0.01 mean(r^2)) without the worst pixel of a hundred. Time x error compares settings independently of the number of samples: half of \
             it is twice as efficient. Default sampling: Owen-scrambled Sobol points, one sequence per \
             microlens, Russian roulette. Intersections are computed in f32 and refined in f64. Nothing is shared \
             between views.",
            lenses.columns, lenses.rows
        ),
        highlights: light.highlights,
        table: light.table,
        plots: plots.into(),
    }
}

impl LightSection<'_> {
    /// Measures all scenes with one integrator; returns their plot.
    fn integrator(&mut self, integrator: Integrator) -> String {
        let (views, lenses, label) = (self.views, self.lenses, integrator_name(integrator));
        let mut plot = Plot::new(
            &format!("{label}: time against noise, {views} x {views} views of {} x {} px", lenses.columns, lenses.rows),
            "seconds",
            "relative squared error",
        );
        for (color, scene) in SCENES.into_iter().enumerate() {
            for (dashes, (name, points)) in self.scene(scene, integrator).into_iter().enumerate() {
                plot.add(Series { name, color, dashes, points });
            }
        }
        plot.svg()
    }

    /// Measures one scene with every backend and setting; returns name and points of the plot for each backend with the
    /// default setting.
    fn scene(&mut self, scene: &str, integrator: Integrator) -> Vec<(String, Vec<(f64, f64)>)> {
        let framed = FramedScene::new(scene, self.views, self.lenses, None);
        let request = Request::new(framed.rig).integrator(integrator).sky(sky(scene));
        let renderer = framed.renderer(self.options.engines[0], None);
        let reference = request.clone().samples(self.reference_samples).seed(0xBEEF);
        let reference = renderer.render(&reference, &()).expect("a render").color.expect("the scene is lit");
        drop(renderer);
        let mut plotted = Vec::new();
        // Cost of the fastest backend with the default setting, by the number of samples.
        let mut default_cost = Vec::new();
        for (engine, setting) in lines(&self.options.engines, integrator) {
            let renderer = framed.renderer(engine, None);
            let mut points = Vec::new();
            for (k, &samples) in self.samples.iter().enumerate() {
                // Long renders have little relative scatter.
                let rounds = if samples > 4 { self.options.rounds.min(3) } else { self.options.rounds };
                let (roulette, sampling) = (setting != Setting::NoRoulette, setting.sampling());
                let request = request.clone().samples(samples).roulette(roulette).sampling(sampling);
                let measured = Measurement::new(rounds, &renderer, &request, &reference);
                points.push((measured.seconds.median, measured.relative));
                if default_cost.len() == k {
                    default_cost.push(measured.cost());
                    if k + 1 == self.samples.len() {
                        self.highlights.push([
                            format!("`{scene}`: {}, {samples} samples per pixel", integrator_label(integrator)),
                            format!("{} Mrays/s", measured.mrays_per_second()),
                            format!("relative MSE {} (RMSE {})", short(measured.relative), short(measured.rmse)),
                        ]);
                    }
                }
                self.table.push([
                    scene.into(),
                    integrator_name(integrator).into(),
                    backend_name(engine).into(),
                    setting.name().into(),
                    samples.to_string(),
                    measured.seconds.text(),
                    measured.mrays_per_second(),
                    short(measured.samples / measured.seconds.median / 1e6),
                    short(measured.rmse),
                    short(measured.relative),
                    measured.cost().ratio(default_cost[k]),
                ]);
            }
            if setting == Setting::Default {
                plotted.push((format!("{scene}, {}", backend_name(engine)), points));
            }
        }
        plotted
    }
}

/// RMSE, and relative squared error without the worst pixels, over all views.
fn errors(image: &LightFieldOwned<f32>, reference: &LightFieldOwned<f32>) -> [f64; 2] {
    let [image, reference] = [image, reference].map(pixels);
    [squared_difference(&image, &reference).sqrt(), relative_squared_error(&image, &reference)[0]]
}

fn pixels(color: &LightFieldOwned<f32>) -> Vec<[f32; 3]> {
    color.samples().rows().into_iter().flat_map(|row| rgb(row.iter())).collect()
}
