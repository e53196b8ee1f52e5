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

use holo_core::{GridSize, Remainder, Sensor, ViewIndex};
use holo_render::{Backend, Framing, Integrator, Renderer, Request, Views, bench};
use holo_scene::gallery;

struct Options {
    scenes: Vec<String>,
    views: usize,
    samples: u32,
    reference: u32,
    integrator: Integrator,
}

/// Views as images, pixel by pixel.
type Images = Vec<Vec<[f32; 3]>>;

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
    let views = GridSize::new(options.views, options.views);
    let shape = Sensor::Paper8k.divide(views, Remainder::Crop).expect("views that fit").shape;
    let framed = Framing::new(shape).frame(&scene).expect("a camera");
    let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, 0).expect("a renderer");
    let rig = framed.rig(renderer.automatic_focus_m(&framed).expect("a focus")).expect("a rig");
    let request = Request::new(rig).integrator(options.integrator).samples(options.samples);

    let start = Instant::now();
    let [mut color, mut guides] = bench::samples(&renderer, &request).expect("a render");
    let render = start.elapsed().as_secs_f64();
    let list = nine(options.views);
    let counts = [shape.lenses().rows, shape.lenses().columns, options.views, options.views];
    let color = color.as_slice_mut().expect("an image without gaps");
    let before = images(color.as_chunks().0, counts, &list);
    let mut error = vec![0.0; color.len() / 3];
    let start = Instant::now();
    let guides = guides.as_slice_mut().expect("an image without gaps");
    bench::reconstruct(&renderer, counts, [color, guides], options.samples, Some(&mut error));
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

fn nine(views: usize) -> Vec<ViewIndex> {
    let places = [0, views / 2, views - 1];
    places.iter().flat_map(|&row| places.map(|column| ViewIndex { row, column })).collect()
}

/// Some views of an elemental image array.
fn images(color: &[[f32; 3]], [v, u, t, s]: [usize; 4], list: &[ViewIndex]) -> Images {
    let pixel = |view: &ViewIndex, lens: usize| {
        let (row, column) = (lens / u * t + view.row, lens % u * s + view.column);
        color[row * u * s + column]
    };
    list.iter().map(|view| (0..v * u).map(|lens| pixel(view, lens)).collect()).collect()
}

fn rgb<'a>(mut values: impl Iterator<Item = &'a f32>) -> Option<[f32; 3]> {
    Some([*values.next()?, *values.next()?, *values.next()?])
}

fn squared_error(image: &[[f32; 3]], references: &[Images; 2], view: usize) -> f64 {
    let [a, b] = [&references[0][view], &references[1][view]];
    let mean = |k: usize, c: usize| f64::from(a[k][c] + b[k][c]) / 2.0;
    let bright = (0..a.len()).flat_map(|k| (0..3).map(move |c| (k, c))).map(|(k, c)| mean(k, c).powi(2)).sum::<f64>();
    let floor = 0.01 * bright / (3 * a.len()) as f64;
    // The pixel's error, and the same against the mean of the references, by which the worst are found.
    let mut errors: Vec<[f64; 2]> = (0..a.len())
        .map(|k| {
            let mut error = [0.0; 2];
            for c in 0..3 {
                let (x, m) = (f64::from(image[k][c]), mean(k, c));
                let scale = 1.0 / (m * m + floor) / 3.0;
                error[0] += (x - f64::from(a[k][c])) * (x - f64::from(b[k][c])) * scale;
                error[1] += (x - m).powi(2) * scale;
            }
            error
        })
        .collect();
    errors.sort_by(|x, y| x[1].total_cmp(&y[1]));
    errors.truncate(errors.len() * 99 / 100);
    errors.iter().map(|error| error[0]).sum::<f64>() / errors.len() as f64
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}
