//! Reconstruction across views: its time beside that of rendering, and the error before and after.
//!
//! `cargo bench -p holo-bench --bench denoise -- [SCENE..] [--views N] [--spp N] [--reference N] [--direct]`
//!
//! Scenes of the gallery (default: `garden`, `glasses`) on the 8K sensor of the paper, `--views` an axis (100), `--spp`
//! samples (4), paths of 8 bounces or direct light. Nine views - corners, middles of the edges, center - are compared
//! with two references of `--reference` samples each (1024; 0 leaves the comparison out). The relative squared error is
//! the mean of (x - a)(x - b) / (m^2 + 0.01 mean(m^2)) with the references a and b and their mean m, so the noise of the
//! references has the expectation 0 in it; the worst pixel of a hundred is left out.

use std::time::Instant;

use holo_bench::error::{Images, nine, rgb, sorted, squared_error};
use holo_bench::on_the_paper_sensor;
use holo_core::ViewIndex;
use holo_render::{Integrator, Request, Views, bench};
use holo_scene::gallery;

struct Options {
    scenes: Vec<String>,
    views: usize,
    samples: u32,
    reference: u32,
    integrator: Integrator,
}

fn main() {
    let options = options();
    println!(
        "{0} x {0} views at 8K, {1} samples, {2:?}; gain in relative squared error: median of nine views, center, smallest",
        options.views, options.samples, options.integrator
    );
    println!(
        "{:<10} {:>9} {:>12} {:>6} {:>9} {:>9} {:>6} {:>6} {:>6} {:>10} {:>10}",
        "", "render s", "reconstruct", "share", "before", "after", "gain", "center", "least", "estimated", "error"
    );
    let mut gains = Vec::new();
    for scene in &options.scenes {
        gains.extend(measure(scene, &options));
    }
    if !gains.is_empty() {
        println!("geometric mean of the gains: {:.0}", (gains.iter().sum::<f64>() / gains.len() as f64).exp());
    }
}

fn options() -> Options {
    let mut options =
        Options { scenes: Vec::new(), views: 100, samples: 4, reference: 1024, integrator: Integrator::Path };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|text| text.parse().ok()).expect("a number after the option");
        match argument.as_str() {
            "--views" => options.views = number() as usize,
            "--spp" => options.samples = number(),
            "--reference" => options.reference = number(),
            "--direct" => options.integrator = Integrator::Direct,
            _ => options.scenes.push(argument),
        }
    }
    if options.scenes.is_empty() {
        options.scenes = ["garden", "glasses"].map(String::from).into();
    }
    options
}

/// Prints a line; returns the logarithm of the gain.
fn measure(name: &str, options: &Options) -> Option<f64> {
    let scene = gallery::scene(name).expect("a scene of the gallery");
    let (renderer, rig) = on_the_paper_sensor(&scene, options.views);
    let shape = rig.shape();
    let request = Request::new(rig).integrator(options.integrator).samples(options.samples);

    let start = Instant::now();
    let [mut color, guides] = bench::samples(&renderer, &request).expect("a render");
    let render = start.elapsed().as_secs_f64();
    let list = nine(options.views);
    let counts = [shape.lenses().rows, shape.lenses().columns, options.views, options.views];
    let color = color.as_slice_mut().expect("an image without gaps");
    let before = images(color.as_chunks().0, counts, &list);
    let mut error = vec![0.0; color.len() / 3];
    let start = Instant::now();
    let guides = guides.as_slice().expect("an image without gaps");
    bench::reconstruct(&renderer, counts, color, guides, Some(&mut error));
    let seconds = start.elapsed().as_secs_f64();
    print!("{name:<10} {render:>9.2} {seconds:>12.2} {:>5.0}%", 100.0 * seconds / render);
    if options.reference == 0 {
        println!();
        return None;
    }
    let after = images(color.as_chunks().0, counts, &list);
    let references = [1, 2].map(|seed| {
        let list = Views::List(list.clone());
        let request = request.clone().samples(options.reference).seed(seed).views(list);
        let rendered = renderer.render(&request, &()).expect("a reference").color.expect("an image");
        let view =
            |k| rendered.view(0, k).expect("a view").rows().into_iter().flat_map(|row| rgb(row.iter())).collect();
        (0..9).map(view).collect::<Images>()
    });
    let errors = |images: &Images| (0..9).map(|k| squared_error(&images[k], &references, k)).collect::<Vec<f64>>();
    let (before, after) = (errors(&before), errors(&after));
    let gains: Vec<f64> = before.iter().zip(&after).map(|(before, after)| before / after).collect();
    let median = |values: &[f64]| sorted(values)[values.len() / 2];
    error.sort_by(f32::total_cmp);
    println!(
        " {:>9.5} {:>9.6} {:>6.0} {:>6.0} {:>6.0} {:>10.4} {:>10.4}",
        median(&before),
        median(&after),
        median(&gains),
        gains[4],
        sorted(&gains)[0],
        error[error.len() / 2],
        median(&after).max(0.0).sqrt()
    );
    Some(median(&gains).ln())
}

/// Some views of an elemental image array.
fn images(color: &[[f32; 3]], [v, u, t, s]: [usize; 4], list: &[ViewIndex]) -> Images {
    let pixel = |view: &ViewIndex, lens: usize| {
        let (row, column) = (lens / u * t + view.row, lens % u * s + view.column);
        color[row * u * s + column]
    };
    list.iter().map(|view| (0..v * u).map(|lens| pixel(view, lens)).collect()).collect()
}
