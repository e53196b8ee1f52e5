//! What views gain from each other: light of their own, path reuse, and reconstruction, on the scenes of the gallery.

use std::ops::Range;
use std::time::Instant;

use holo_bench::error::{Images, nine, rgb, sorted, squared_error};
use holo_bench::on_the_paper_sensor;
use holo_core::{GridSize, LightFieldOwned};
use holo_render::{Denoise, Request, Reuse, TextureFilter, Views};
use holo_scene::gallery;

use crate::table::{Table, short};
use crate::{RunOptions, Section};

const SAMPLES: u32 = 4;

/// The views that are compared, and the center among them.
const VIEWS: usize = 9;
const CENTER: usize = VIEWS / 2;

/// Measured at few views too, where neighbors are farther apart.
const FEW_VIEWS: [&str; 4] = ["glasses", "chess", "garden", "plaster"];

/// What the views share, in the order of the table.
const SETTINGS: [(&str, Reuse, Denoise); 3] = [
    ("nothing (default)", Reuse::Off, Denoise::Off),
    ("paths (`--reuse views`)", Reuse::Views, Denoise::Off),
    ("samples (`--denoise views`)", Reuse::Views, Denoise::Views),
];

/// A division of the 8K sensor, the part of its lens rows that is rendered, the samples of a reference, and the scenes.
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

/// The divisions of this section and of that on Cycles.
pub fn divisions(options: &RunOptions) -> Vec<Division> {
    if options.quick {
        return vec![Division { views: 100, rows: 4, reference: 128, scenes: vec!["plaster".into()] }];
    }
    let all = gallery::NAMES.iter().map(|&name| name.to_owned());
    vec![
        Division { views: 100, rows: 6, reference: 4096, scenes: all.collect() },
        Division { views: 20, rows: 12, reference: 1024, scenes: FEW_VIEWS.map(String::from).into() },
    ]
}

pub fn section(options: &RunOptions) -> Section {
    let divisions = divisions(options);
    let mut table = Table::new(&[
        "views",
        "scene",
        "shared between views",
        "seconds",
        "error, median view",
        "center",
        "corners",
        "error, of nothing shared: 1 /",
        "time x error, of nothing shared: 1 /",
    ]);
    let mut highlights = Vec::new();
    for division in &divisions {
        let mut gains: [Vec<[f64; 2]>; 3] = Default::default();
        for scene in &division.scenes {
            for (gains, gain) in gains.iter_mut().zip(add_rows(scene, division, &mut table)) {
                gains.push(gain);
            }
        }
        for ((name, ..), gains) in SETTINGS.iter().zip(&gains).skip(1) {
            let [less, efficient] = [0, 1].map(|k| sorted(&gains.iter().map(|gain| gain[k]).collect::<Vec<f64>>()));
            let [mean_less, mean_efficient] = [&less, &efficient].map(|gains| geometric_mean(gains));
            highlights.push([
                format!("{0} x {0} views, {SAMPLES} samples, shared: {name}; {1} scenes", division.views, less.len()),
                format!("{} times less time for the same error", short(mean_efficient)),
                format!(
                    "1/{} of the error (1/{} to 1/{})",
                    short(mean_less),
                    short(less[0]),
                    short(less[less.len() - 1])
                ),
            ]);
        }
    }
    Section {
        text: format!(
            "Scenes of the gallery on the 8K sensor of the paper, {SAMPLES} samples, paths of up to 8 bounces, the lens \
             rows in the middle ({}). Error: the mean of (x - r)^2 / (r^2 + 0.01 mean(r^2)) over the pixels of a view \
             without the worst of a hundred, against two references of {} samples whose own noise has the expectation 0 \
             in it; corners: the median of four views, median view: of corners, middles of the edges, and center. Single \
             runs. Seconds include the lens rows around that the reconstruction needs, which an image rendered whole \
             does not pay for. The least gains of the reconstruction are \
             those of scenes whose surfaces differ from pixel to pixel.",
            listed(&divisions, |division| format!(
                "{} of {} x {} views",
                division.rows, division.views, division.views
            )),
            listed(&divisions, |division| division.reference.to_string()),
        ),
        highlights,
        table,
        plots: Vec::new(),
    }
}

fn listed(divisions: &[Division], text: impl Fn(&Division) -> String) -> String {
    divisions.iter().map(text).collect::<Vec<_>>().join(", ")
}

pub fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// Adds the rows of a scene; returns, for each setting, the gains in error and in time x error.
fn add_rows(name: &str, division: &Division, table: &mut Table) -> [[f64; 2]; 3] {
    let settings = measure(name, division);
    let (first_seconds, first_errors) = settings[0];
    std::array::from_fn(|k| {
        let (seconds, errors) = settings[k];
        let corners = sorted(&[0, 2, 6, 8].map(|k| errors[k]));
        let ratios: Vec<f64> = first_errors.iter().zip(&errors).map(|(before, after)| before / after).collect();
        let less = sorted(&ratios)[CENTER];
        let gain = [less, less * first_seconds / seconds];
        table.push([
            format!("{0} x {0}", division.views),
            name.to_owned(),
            SETTINGS[k].0.to_owned(),
            short(seconds),
            short(sorted(&errors)[CENTER]),
            short(errors[CENTER]),
            short((corners[1] + corners[2]) / 2.0),
            short(gain[0]),
            short(gain[1]),
        ]);
        gain
    })
}

/// The seconds of each setting, and the errors of nine views.
fn measure(name: &str, division: &Division) -> [(f64, [f64; VIEWS]); SETTINGS.len()] {
    let scene = gallery::scene(name).expect("a scene of the gallery");
    let (renderer, rig) = on_the_paper_sensor(&scene, division.views);
    let rows = division.range(rig.shape().lenses());
    let request = Request::new(rig).samples(SAMPLES).rows(Some(rows));
    let list = nine(division.views);
    let references = [1, 2].map(|seed| {
        let request = request.clone().samples(division.reference).seed(seed).texture_filter(TextureFilter::Off);
        let color = renderer.render(&request.views(Views::List(list.clone())), &()).expect("a reference").color;
        let color = color.expect("the scene is lit");
        (0..VIEWS).map(|k| image(&color, 0, k)).collect::<Images>()
    });
    SETTINGS.map(|(_, reuse, denoise)| {
        let request = request.clone().reuse(reuse).denoise(denoise);
        let start = Instant::now();
        let color = renderer.render(&request, &()).expect("a render").color.expect("the scene is lit");
        let seconds = start.elapsed().as_secs_f64();
        let images: Images = list.iter().map(|view| image(&color, view.row, view.column)).collect();
        (seconds, std::array::from_fn(|k| squared_error(&images[k], &references, k)))
    })
}

/// The mean of all pixels and channels.
pub fn mean(pixels: &[[f32; 3]]) -> f64 {
    pixels.as_flattened().iter().map(|&value| f64::from(value)).sum::<f64>() / (3 * pixels.len()) as f64
}

/// A view, pixel by pixel.
pub fn image(color: &LightFieldOwned<f32>, row: usize, column: usize) -> Vec<[f32; 3]> {
    color.view(row, column).expect("a view").rows().into_iter().flat_map(|row| rgb(row.iter())).collect()
}
