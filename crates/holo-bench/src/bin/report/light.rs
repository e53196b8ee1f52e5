//! Time against noise of every integrator and engine, on scenes with every kind of light.

use holo_core::{GridSize, LightFieldOwned};
use holo_render::{Backend, Integrator, Renderer, Request, Sampling};

use crate::plot::{Plot, Series};
use crate::scenes::{Ready, light, name, sky, word};
use crate::sheet::{Seconds, Sheet, short, timed};
use crate::{Section, Wish};

const SCENES: [&str; 4] = ["garden", "plaster", "chess", "glasses"];

/// Those that the summary names.
const IN_SHORT: [&str; 2] = ["garden", "glasses"];

/// Added to the square of the reference in the relative squared error, so that black pixels do not decide alone.
const EPSILON: f64 = 1e-2;

/// How light is sampled, beside how many samples there are. The first is what a render does.
#[derive(Clone, Copy, PartialEq)]
enum Setting {
    Usual,
    OwnPlaces,
    Independent,
    NoRoulette,
}

impl Setting {
    fn name(self) -> &'static str {
        match self {
            Self::Usual => "as usual",
            Self::OwnPlaces => "places of its own in every view",
            Self::Independent => "independent numbers",
            Self::NoRoulette => "no roulette",
        }
    }

    fn sampling(self) -> Sampling {
        match self {
            Self::Usual | Self::NoRoulette => Sampling::SharedPositions,
            Self::OwnPlaces => Sampling::OwnPositions,
            Self::Independent => Sampling::Independent,
        }
    }
}

/// What is measured: every engine as usual, then the fast one with the other settings.
fn lines(engines: &[Backend], integrator: Integrator) -> Vec<(Backend, Setting)> {
    let mut lines: Vec<_> = engines.iter().map(|&engine| (engine, Setting::Usual)).collect();
    lines.extend([Setting::OwnPlaces, Setting::Independent].map(|setting| (engines[0], setting)));
    if integrator == Integrator::Path {
        lines.push((engines[0], Setting::NoRoulette));
    }
    lines
}

/// One render after another of the same request.
struct Measured {
    seconds: Seconds,
    rays: f64,
    samples: f64,
    rmse: f64,
    relative: f64,
}

impl Measured {
    fn new(rounds: usize, renderer: &Renderer, request: &Request, reference: &LightFieldOwned<f32>) -> Self {
        let (seconds, rendered) = timed(rounds, || renderer.render(request, &()).expect("a render"));
        let [rmse, relative] = errors(&rendered.color.expect("a picture"), reference);
        Self { seconds, rays: rendered.rays.total() as f64, samples: rendered.samples as f64, rmse, relative }
    }

    /// Time times error.
    fn cost(&self) -> Seconds {
        Seconds { median: self.seconds.median * self.relative, ..self.seconds }
    }

    fn mrays_per_second(&self) -> String {
        short(self.rays / self.seconds.median / 1e6)
    }
}

/// What the section is made of.
struct Work<'a> {
    wish: &'a Wish,
    views: usize,
    lenses: GridSize,
    samples: &'static [u32],
    reference_samples: u32,
    sheet: Sheet,
    highlights: Vec<[String; 3]>,
}

pub fn section(wish: &Wish) -> Section {
    let sheet = Sheet::new(&[
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
        "time x relMSE, of the fast engine as usual",
    ]);
    let mut work = Work {
        wish,
        views: if wish.quick { 6 } else { 8 },
        lenses: if wish.quick { GridSize::new(12, 18) } else { GridSize::new(24, 36) },
        samples: if wish.quick { &[1, 4, 16] } else { &[1, 4, 16, 64] },
        reference_samples: if wish.quick { 256 } else { 512 },
        sheet,
        highlights: Vec::new(),
    };
    let plots = [(Integrator::Direct, "light_direct"), (Integrator::Path, "light_path")]
        .map(|(integrator, name)| (name, work.integrator(integrator)));
    let Work { views, lenses, reference_samples, .. } = work;
    Section {
        title: "Light",
        text: format!(
            "Gallery scenes, {views} x {views} views of {} x {} px, all threads, paths of up to 8 bounces. Reference: {reference_samples} \
             samples of another seed, same integrator. Relative squared error: the mean of (x - r)^2 / (r^2 + {EPSILON}). Time times \
             error says which is better whatever the samples: half of it is twice as fast. Sampling as usual: Owen-scrambled Sobol points, \
             their places in the pixel shared by 4 x 4 views, weak paths ended by roulette. (There is no choice of precision: engines \
             work in f32, what they hit is refined in f64. Nothing that is shaded is used again for another view.)",
            lenses.columns, lenses.rows
        ),
        highlights: work.highlights,
        sheet: work.sheet,
        plots: plots.into(),
    }
}

impl Work<'_> {
    /// All scenes with one integrator; their plot.
    fn integrator(&mut self, integrator: Integrator) -> String {
        let (views, lenses, word) = (self.views, self.lenses, word(integrator));
        let mut plot = Plot::new(
            &format!("{word}: time against noise, {views} x {views} views of {} x {} px", lenses.columns, lenses.rows),
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

    /// One scene with every engine and setting; the line in the plot of each engine as usual, with its name.
    fn scene(&mut self, scene: &str, integrator: Integrator) -> Vec<(String, Vec<(f64, f64)>)> {
        let ready = Ready::new(scene, self.views, self.lenses, None);
        let request = Request { integrator, sky: sky(scene), ..Request::new(ready.rig) };
        let renderer = ready.renderer(self.wish.engines[0], 0);
        let reference = Request { samples: self.reference_samples, seed: 0xBEEF, ..request.clone() };
        let reference = renderer.render(&reference, &()).expect("a render").color.expect("a picture");
        drop(renderer);
        let mut plotted = Vec::new();
        // Time and error of the fast engine as usual, by samples.
        let mut usual = Vec::new();
        for (engine, setting) in lines(&self.wish.engines, integrator) {
            let renderer = ready.renderer(engine, 0);
            let mut points = Vec::new();
            for (k, &samples) in self.samples.iter().enumerate() {
                // What takes long scatters little.
                let rounds = if samples > 4 { self.wish.rounds.min(3) } else { self.wish.rounds };
                let (roulette, sampling) = (setting != Setting::NoRoulette, setting.sampling());
                let request = Request { samples, roulette, sampling, ..request.clone() };
                let measured = Measured::new(rounds, &renderer, &request, &reference);
                points.push((measured.seconds.median, measured.relative));
                if usual.len() == k {
                    usual.push(measured.cost());
                    if k + 1 == self.samples.len() && IN_SHORT.contains(&scene) {
                        self.highlights.push([
                            format!("`{scene}`: {}, {samples} samples a pixel", light(integrator)),
                            format!("{} Mrays/s", measured.mrays_per_second()),
                            format!("relative MSE {} (RMSE {})", short(measured.relative), short(measured.rmse)),
                        ]);
                    }
                }
                self.sheet.push([
                    scene.into(),
                    word(integrator).into(),
                    name(engine).into(),
                    setting.name().into(),
                    samples.to_string(),
                    measured.seconds.text(),
                    measured.mrays_per_second(),
                    short(measured.samples / measured.seconds.median / 1e6),
                    short(measured.rmse),
                    short(measured.relative),
                    measured.cost().ratio(usual[k]),
                ]);
            }
            if setting == Setting::Usual {
                plotted.push((format!("{scene}, {}", name(engine)), points));
            }
        }
        plotted
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
