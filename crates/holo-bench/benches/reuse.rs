//! Path reuse between views: time and error with and without it.
//!
//! `cargo bench -p holo-bench --bench reuse -- [SCENE..] [--views N] [--spp N] [--reference N] [--rows N] [--sky] [--direct]`
//!
//! Scenes of the gallery, or glTF files, on the 8K sensor of the paper, `--views` an axis (100), `--rows` of the lens rows in the middle
//! (6), `--spp` samples (4), paths of 8 bounces or direct light, with a
//! bluish sky if wanted. Errors as in the benchmark `denoise`: nine views against
//! two references of `--reference` samples each (1024); the median of the views. The error of the mean over the 4 x 4
//! views around each of the nine tells what is left for refocusing. `gain` is that in error times time.

use std::time::Instant;

use holo_bench::error::{Images, nine, rgb, sorted, squared_error};
use holo_bench::on_the_paper_sensor;
use holo_core::LightFieldOwned;
use holo_render::{Integrator, Request, Reuse, Views};

struct Options {
    scenes: Vec<String>,
    views: usize,
    samples: u32,
    reference: u32,
    rows: usize,
    integrator: Integrator,
    sky: [f32; 3],
}

fn main() {
    let options = options();
    println!(
        "{0} x {0} views at 8K, {1} lens rows, {2} samples, {3:?}; medians of nine views",
        options.views, options.rows, options.samples, options.integrator
    );
    println!(
        "{:<10} {:>8} {:>8} {:>6} {:>10} {:>10} {:>6} {:>6} {:>16}",
        "", "off s", "views s", "ratio", "off", "views", "ratio", "gain", "ratio of 4 x 4"
    );
    let gains: Vec<f64> = options.scenes.iter().map(|scene| measure(scene, &options)).collect();
    println!("geometric mean of the gains: {:.2}", (gains.iter().sum::<f64>() / gains.len() as f64).exp());
}

fn options() -> Options {
    let mut options = Options {
        scenes: Vec::new(),
        views: 100,
        samples: 4,
        reference: 1024,
        rows: 6,
        integrator: Integrator::Path,
        sky: [0.0; 3],
    };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|text| text.parse().ok()).expect("a number after the option");
        match argument.as_str() {
            "--views" => options.views = number() as usize,
            "--spp" => options.samples = number(),
            "--reference" => options.reference = number(),
            "--rows" => options.rows = number() as usize,
            "--sky" => options.sky = [0.5, 0.6, 0.8],
            "--direct" => options.integrator = Integrator::Direct,
            _ => options.scenes.push(argument),
        }
    }
    if options.scenes.is_empty() {
        options.scenes = ["garden", "glasses", "plaster", "chess"].map(String::from).into();
    }
    options
}

/// Prints a line; returns the logarithm of the gain.
fn measure(name: &str, options: &Options) -> f64 {
    let scene = holo_bench::scene(name);
    let (renderer, rig) = on_the_paper_sensor(&scene, options.views);
    let shape = rig.shape();
    let middle = shape.lenses().rows / 2;
    let rows = middle - options.rows / 2..middle + options.rows.div_ceil(2);
    let request =
        Request::new(rig).integrator(options.integrator).samples(options.samples).sky(options.sky).rows(Some(rows));

    let list = nine(options.views);
    let blocks: Vec<_> = list
        .iter()
        .map(|view| [view.row.min(options.views - 4) / 4 * 4, view.column.min(options.views - 4) / 4 * 4])
        .collect();
    let [own, shared] = [Reuse::Off, Reuse::Views].map(|reuse| {
        let start = Instant::now();
        let color = renderer.render(&request.clone().reuse(reuse), &()).expect("a render").color.expect("an image");
        let seconds = start.elapsed().as_secs_f64();
        let single: Images = list.iter().map(|view| image(&color, &[[view.row, view.column]])).collect();
        let in_block =
            |[row, column]: [usize; 2]| -> Vec<[usize; 2]> { (0..16).map(|k| [row + k / 4, column + k % 4]).collect() };
        let mean: Images = blocks.iter().map(|&block| image(&color, &in_block(block))).collect();
        (seconds, single, mean)
    });
    let references = [1, 2].map(|seed| {
        let request = request.clone().samples(options.reference).seed(seed);
        let rendered = renderer.render(&request.views(Views::List(list.clone())), &()).expect("a reference");
        let color = rendered.color.expect("an image");
        (0..9).map(|k| image(&color, &[[0, k]])).collect::<Images>()
    });
    let error = |images: &Images| {
        let errors: Vec<f64> = (0..9).map(|k| squared_error(&images[k], &references, k)).collect();
        sorted(&errors)[4]
    };
    let (before, after) = (error(&own.1), error(&shared.1));
    // Views of one block differ by less than the noise only near the plane in focus; the ratio tells the noise.
    let block_ratio = error(&own.2) / error(&shared.2);
    let (time, less) = (shared.0 / own.0, before / after);
    println!(
        "{:<10} {:>8.2} {:>8.2} {time:>6.2} {before:>10.5} {after:>10.5} {less:>6.2} {:>6.2} {block_ratio:>16.2}",
        name.rsplit('/').next().unwrap_or(name),
        own.0,
        shared.0,
        less / time
    );
    (less / time).ln()
}

/// The mean of some views, pixel by pixel.
fn image(color: &LightFieldOwned<f32>, views: &[[usize; 2]]) -> Vec<[f32; 3]> {
    let mut sum: Vec<[f32; 3]> = Vec::new();
    for &[row, column] in views {
        let view = color.view(row, column).expect("a view");
        let pixels: Vec<[f32; 3]> = view.rows().into_iter().flat_map(|row| rgb(row.iter())).collect();
        sum.resize(pixels.len(), [0.0; 3]);
        for (sum, pixel) in sum.iter_mut().zip(&pixels) {
            (0..3).for_each(|c| sum[c] += pixel[c] / views.len() as f32);
        }
    }
    sum
}
