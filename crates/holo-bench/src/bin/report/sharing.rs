//! Light shared between views at less than one sample a pixel: time, error, estimated error and bias, on the scenes of the
//! gallery.

use std::ops::Range;
use std::time::Instant;

use holo_bench::error::{Images, error_in_8bit, nine, rgb, sorted};
use holo_bench::on_the_paper_sensor;
use holo_core::{GridSize, LightFieldOwned, Rig};
use holo_render::{Denoise, Renderer, Request, SamplesPerPixel, TextureFilter, Views, exposure};
use holo_scene::{Scene, gallery};

use crate::honesty::{self, Mask, Pixel};
use crate::scenes::FramedScene;
use crate::table::{Table, short};
use crate::{RunOptions, Section};

/// The compared views of [`nine`]: corner, middle of an edge, center.
const VIEWS: [usize; 3] = [0, 1, 4];

/// The scenes that are measured where all would take hours: with views farther apart, and in Cycles.
pub const FEW_SCENES: [&str; 4] = ["glasses", "chess", "garden", "plaster"];

/// How a sensor is divided into views, the part of its lens rows that is compared, the samples of a reference, the scenes.
pub struct Division {
    pub views: usize,
    pub rows: usize,
    pub reference: u32,
    pub scenes: Vec<String>,
}

impl Division {
    /// The lens rows of `lenses` that are compared: those in the middle.
    pub fn range(&self, lenses: GridSize) -> Range<usize> {
        let first = (lenses.rows - self.rows) / 2;
        first..first + self.rows
    }
}

/// The samples of a pixel, by what they are called.
type Samples = (&'static str, SamplesPerPixel);

/// A division with the samples that it is measured with, and a baseline if it is not that of an f/5 lens.
struct Measured {
    division: Division,
    size: Option<(GridSize, f64)>,
    samples: Vec<Samples>,
}

/// The divisions of this section and of those on Cycles, with a few scenes.
pub fn divisions(options: &RunOptions) -> [Division; 2] {
    let scenes: Vec<String> =
        FEW_SCENES.iter().take(if options.quick { 1 } else { FEW_SCENES.len() }).map(|&name| name.into()).collect();
    let reference = |samples| if options.quick { 128 } else { samples };
    [
        Division { views: 100, rows: 24, reference: reference(2048), scenes: scenes.clone() },
        Division { views: 20, rows: 24, reference: reference(512), scenes },
    ]
}

fn measured(options: &RunOptions) -> Vec<Measured> {
    let part = |one_in| SamplesPerPixel::one_in(one_in).expect("a power of two");
    let (eighth, quarter) = (("1/8", part(8)), ("1/4", part(4)));
    let [mut many, few] = divisions(options);
    let apart = Division { views: 41, scenes: few.scenes.clone(), ..few };
    if !options.quick {
        // Those of the dataset.
        many.scenes = gallery::NAMES[..gallery::OF_PAPER].iter().map(|&name| name.into()).collect();
    }
    let mut all = vec![
        Measured { division: many, size: None, samples: vec![eighth, quarter] },
        Measured { division: few, size: None, samples: vec![quarter] },
    ];
    if !options.quick {
        let size = Some((GridSize::new(132, 198), 0.00025));
        all.push(Measured { division: apart, size, samples: vec![quarter, ("1", 1.into())] });
    }
    all
}

pub fn section(options: &RunOptions) -> Section {
    let mut table = Table::new(&[
        "views",
        "scene",
        "samples a pixel",
        "seconds",
        "median error, %",
        "90 % of the pixels, %",
        "true / estimated error",
        "jumps",
        "brightest 1 %",
        "darkest 10 %",
        "glass",
        "metal",
        "corner view",
        "beyond 3 estimated, %",
        "bias, brightest 1 %, %",
        "bias, darkest 10 %, %",
    ]);
    let mut highlights = Vec::new();
    for measured in measured(options) {
        let mut found: Vec<Vec<[f64; 2]>> = vec![Vec::new(); measured.samples.len()];
        for scene in &measured.division.scenes {
            for (found, row) in found.iter_mut().zip(add_rows(scene, &measured, &mut table)) {
                found.push(row);
            }
        }
        highlights
            .extend(measured.samples.iter().zip(&found).map(|(samples, found)| summary(&measured, samples, found)));
    }
    Section {
        text: "Paths of up to 8 bounces, `--denoise views`. Behind an f/5 lens, at 8K: fifteen scenes in 100 x 100 views of 79 \
               x 53 px, four of them in 20 x 20 views of 397 x 265 px. With views 0.25 mm apart: these four in 41 x 41 views \
               of 198 x 132 px. \
               Seconds are those of the whole light field in memory, one run each. The error is that of the luminance of \
               the 8-bit image, |x - g| / g, over 24 lens rows of the central view, a corner and the middle of an edge, \
               against 4096 (100 x 100) or 1024 samples without sharing. True and estimated error: root mean squares, \
               relative to the pixel and no less than a tenth of the scene; two references of half the samples take the \
               noise of the references out. Jumps: within a pixel of a jump of the depth. Bias: the sum of the luminance \
               over these pixels against that of the references, of one image, noise included; pixels are chosen by \
               the references. Empty: fewer than 40 pixels."
            .into(),
        highlights,
        table,
        plots: Vec::new(),
    }
}

/// A row of the summary; `found` are seconds and median error of every scene.
fn summary(measured: &Measured, (name, _): &Samples, found: &[[f64; 2]]) -> [String; 3] {
    let [seconds, errors] = [0, 1].map(|k| sorted(&found.iter().map(|row| row[k]).collect::<Vec<f64>>()));
    let below = |limit: f64| errors.iter().filter(|&&error| error <= limit).count();
    let views = measured.division.views;
    [
        format!("{views} x {views} views, {name} sample, denoise views; {} scenes", found.len()),
        format!(
            "{} s (geometric mean; {} to {})",
            short(geometric_mean(&seconds)),
            short(seconds[0]),
            short(seconds[seconds.len() - 1])
        ),
        format!(
            "median error {} % ({} to {}); at most 2 % in {}, 3 % in {}, 4 % in {}",
            short(100.0 * errors[errors.len() / 2]),
            short(100.0 * errors[0]),
            short(100.0 * errors[errors.len() - 1]),
            below(0.02),
            below(0.03),
            below(0.04)
        ),
    ]
}

pub fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// Adds the rows of a scene; returns, for each number of samples, seconds and median error.
fn add_rows(name: &str, measured: &Measured, table: &mut Table) -> Vec<[f64; 2]> {
    let scene = gallery::scene(name).expect("a scene of the gallery");
    let (renderer, rig) = match measured.size {
        None => on_the_paper_sensor(&scene, measured.division.views),
        Some((lenses, baseline_m)) => {
            let framed = FramedScene::new(name, measured.division.views, lenses, Some(baseline_m));
            (framed.renderer(holo_render::Backend::Auto, None), framed.rig)
        }
    };
    let truth = Truth::render(&renderer, &scene, rig, &measured.division);
    let row = |&(samples, count): &Samples| {
        let request = Request::new(rig).denoise(Denoise::Views).samples(count).estimate_error(true);
        let start = Instant::now();
        let rendered = renderer.render(&request, &()).expect("a render");
        let seconds = start.elapsed().as_secs_f64();
        let (color, error) = (rendered.color.expect("the scene is lit"), rendered.error.expect("an estimate"));
        let gain = exposure::automatic_exposure(&color).exp2() as f32;
        let (errors, pixels) = truth.compare(&color, &error, gain);
        let [median, high] = [errors[errors.len() / 2], errors[errors.len() * 9 / 10]];
        let of = |mask, value: &dyn Fn(&[&Pixel]) -> f64| {
            honesty::within(&pixels, mask).map_or_else(String::new, |within| short(value(&within)))
        };
        let ratio = |mask| of(mask, &|within| honesty::true_by_estimated(within, &pixels));
        let bias = |mask| of(mask, &|within| 100.0 * honesty::bias(within));
        // The section takes long: what is measured is seen before its end.
        eprintln!(
            "        {0} x {0} views of {name}, {samples} sample: {1} s",
            measured.division.views,
            short(seconds)
        );
        table.push([
            format!("{0} x {0}", measured.division.views),
            name.to_owned(),
            samples.to_owned(),
            short(seconds),
            short(100.0 * median),
            short(100.0 * high),
            ratio(Mask::All),
            ratio(Mask::Jumps),
            ratio(Mask::Brightest),
            ratio(Mask::Darkest),
            ratio(Mask::Glass),
            ratio(Mask::Metal),
            ratio(Mask::Corner),
            of(Mask::All, &|within| 100.0 * honesty::beyond_three(within)),
            bias(Mask::Brightest),
            bias(Mask::Darkest),
        ]);
        [seconds, median]
    };
    measured.samples.iter().map(row).collect()
}

/// The references of some views, and what their pixels show.
struct Truth {
    rows: Range<usize>,
    columns: usize,
    views: Vec<holo_core::ViewIndex>,
    references: [Images; 2],
    marks: Vec<honesty::Marks>,
}

impl Truth {
    fn render(renderer: &Renderer, scene: &Scene, rig: Rig, division: &Division) -> Self {
        let lenses = rig.shape().lenses();
        let rows = division.range(lenses);
        let views: Vec<_> = VIEWS.map(|number| nine(division.views)[number]).into();
        let request = Request::new(rig).rows(Some(rows.clone())).samples(division.reference);
        let references = [1, 2].map(|seed| {
            let request = request.clone().seed(seed).texture_filter(TextureFilter::Off);
            let color = renderer.render(&request.views(Views::List(views.clone())), &()).expect("a reference").color;
            let color = color.expect("the scene is lit");
            (0..VIEWS.len()).map(|k| image(&color, 0, k)).collect::<Images>()
        });
        let marks = honesty::marks(renderer, scene, &request, &views, 0);
        Self { rows, columns: lenses.columns, views, references, marks }
    }

    /// The sorted errors in 8 bits, and the pixels in linear light.
    fn compare(&self, color: &LightFieldOwned<f32>, error: &LightFieldOwned<f32>, gain: f32) -> (Vec<f64>, Vec<Pixel>) {
        let (mut errors, mut pixels) = (Vec::new(), Vec::new());
        for (k, view) in self.views.iter().enumerate() {
            let found = image(color, view.row, view.column);
            let estimated = error.view(view.row, view.column).expect("a view");
            let size = self.references[0][k].len();
            let first = self.rows.start * self.columns;
            for (i, found) in found[first..first + size].iter().enumerate() {
                let references = [0, 1].map(|half| self.references[half][k][i]);
                let mean = [0, 1, 2].map(|c| (references[0][c] + references[1][c]) / 2.0 * gain);
                errors.extend(error_in_8bit(found.map(|x| x * gain), mean));
                let place = [(first + i) / self.columns, (first + i) % self.columns, 0];
                pixels.push(honesty::pixel(*found, references, estimated[place], self.marks[k * size + i]));
            }
        }
        (sorted(&errors), pixels)
    }
}

/// The mean of all pixels and channels.
pub fn mean(pixels: &[[f32; 3]]) -> f64 {
    pixels.as_flattened().iter().map(|&value| f64::from(value)).sum::<f64>() / (3 * pixels.len()) as f64
}

/// A view, pixel by pixel.
pub fn image(color: &LightFieldOwned<f32>, row: usize, column: usize) -> Vec<[f32; 3]> {
    color.view(row, column).expect("a view").rows().into_iter().flat_map(|row| rgb(row.iter())).collect()
}
