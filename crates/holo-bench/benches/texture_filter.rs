//! Filtered textures: time, error and bias with and without footprints.
//!
//! `cargo bench -p holo-bench --bench texture_filter -- [SCENE..] [--views N] [--reference N] [--seeds N] [--direct]`
//!
//! Scenes of the gallery (default: all) on the 8K sensor of the paper, `--views` an axis (100), paths of 8 bounces or direct light. Nine
//! views are compared with two references of `--reference` unfiltered samples each (1024); the median of the errors, as
//! in the benchmark `denoise`, at 1, 4 and 16 samples, without and with the filter. The bias of 4 samples is the error
//! that the means of two halves of `--seeds` images (64) have in common, as the root of a relative squared error. The time is that
//! of 4 samples in two lens rows in the middle of all views.

use std::time::Instant;

use holo_bench::error::{Images, nine, rgb, sorted, squared_bias, squared_error};
use holo_bench::on_the_paper_sensor;
use holo_core::ViewIndex;
use holo_render::{Integrator, Renderer, Request, TextureFilter, Views};
use holo_scene::gallery;

const FILTERS: [TextureFilter; 2] = [TextureFilter::Off, TextureFilter::Footprint];

struct Options {
    scenes: Vec<String>,
    views: usize,
    reference: u32,
    seeds: u64,
    integrator: Integrator,
}

fn main() {
    let options = options();
    println!(
        "{0} x {0} views at 8K, {1:?}; relative squared errors, medians of nine views",
        options.views, options.integrator
    );
    println!(
        "{:<10} {:>10} {:>6} {:>10} {:>6} {:>10} {:>6} {:>8} {:>6}",
        "", "1 sample", "ratio", "4", "ratio", "16", "ratio", "bias", "time"
    );
    let mut gains = [0.0; 3];
    for scene in &options.scenes {
        let of_scene = measure(scene, &options);
        (0..3).for_each(|k| gains[k] += of_scene[k].ln() / options.scenes.len() as f64);
    }
    let [one, four, sixteen] = gains.map(f64::exp);
    println!("geometric means of the ratios: {one:.2}, {four:.2}, {sixteen:.2}");
}

fn options() -> Options {
    let mut options =
        Options { scenes: Vec::new(), views: 100, reference: 1024, seeds: 64, integrator: Integrator::Path };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|text| text.parse().ok()).expect("a number after the option");
        match argument.as_str() {
            "--views" => options.views = number() as usize,
            "--reference" => options.reference = number() as u32,
            "--direct" => options.integrator = Integrator::Direct,
            "--seeds" => options.seeds = number(),
            _ => options.scenes.push(argument),
        }
    }
    if options.scenes.is_empty() {
        options.scenes = gallery::NAMES.iter().map(|name| (*name).into()).collect();
    }
    options
}

/// Prints a line; returns the ratios of the errors at 1, 4 and 16 samples.
fn measure(name: &str, options: &Options) -> [f64; 3] {
    let scene = holo_bench::scene(name);
    let (renderer, rig) = on_the_paper_sensor(&scene, options.views);
    let request = Request::new(rig).integrator(options.integrator).samples(4);
    let list = nine(options.views);
    let unfiltered = request.clone().texture_filter(TextureFilter::Off).samples(options.reference);
    let references = [1, 2].map(|seed| images(&renderer, &unfiltered.clone().seed(seed), &list));
    let error = |images: &Images| {
        let errors: Vec<f64> = (0..9).map(|k| squared_error(&images[k], &references, k)).collect();
        sorted(&errors)[4]
    };
    let mut line = format!("{:<10}", name.rsplit('/').next().unwrap_or(name));
    let ratios = [1, 4, 16].map(|samples| {
        let [off, on] = FILTERS.map(|filter| {
            error(&images(&renderer, &request.clone().samples(samples).texture_filter(filter).seed(3), &list))
        });
        line += &format!(" {off:>10.5} {:>6.2}", off / on);
        off / on
    });

    let halves = [100, 1000].map(|first| {
        let mut sum: Images = vec![Vec::new(); list.len()];
        for seed in 0..options.seeds / 2 {
            let of_seed = images(&renderer, &request.clone().seed(first + seed), &list);
            for (sum, image) in sum.iter_mut().zip(&of_seed) {
                sum.resize(image.len(), [0.0; 3]);
                for (sum, pixel) in sum.iter_mut().zip(image) {
                    (0..3).for_each(|c| sum[c] += pixel[c] / (options.seeds / 2) as f32);
                }
            }
        }
        sum
    });
    let biases: Vec<f64> = (0..9).map(|k| squared_bias([&halves[0][k], &halves[1][k]], &references, k)).collect();
    let bias = sorted(&biases)[4].max(0.0).sqrt();

    let middle = request.camera.rig().expect("a rig").shape().lenses().rows / 2;
    let rows = request.rows(Some(middle..middle + 2));
    let [off, on] = FILTERS.map(|filter| {
        let start = Instant::now();
        renderer.render(&rows.clone().texture_filter(filter), &()).expect("a render");
        start.elapsed().as_secs_f64()
    });
    println!("{line} {:>7.2}% {:>6.3}", bias * 100.0, on / off);
    ratios
}

/// Some views, without sharing between them.
fn images(renderer: &Renderer, request: &Request, views: &[ViewIndex]) -> Images {
    let request = request.clone().views(Views::List(views.to_vec()));
    let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
    let image = |k| {
        let view = color.view(0, k).expect("a view");
        view.rows().into_iter().flat_map(|row| rgb(row.iter())).collect()
    };
    (0..views.len()).map(image).collect()
}
