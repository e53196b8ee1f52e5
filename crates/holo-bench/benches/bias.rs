//! Whether sampling is unbiased: means over many seeds, of the sampler and path reuse of every render against
//! independent random numbers without them.
//!
//! `cargo bench -p holo-bench --bench bias -- [SCENE..] [--views N] [--spp N] [--seeds N] [--direct]`
//!
//! Scenes of the gallery, or glTF files (default: all of the gallery and `tests/radiance/metal_and_glass.glb`), `--views` an axis (4) of 96 x 64 px behind f/5, `--spp`
//! samples (4), `--seeds` seeds (64) of either kind. Means of 16 x 16 pixels and three channels are compared: their
//! difference, in standard errors that follow from the spread over the seeds. Without bias 0.3 to 0.4 % of normally
//! distributed differences are beyond 3. The footprint filter of textures, which is biased, is off.

use holo_core::{GridSize, LightFieldOwned, LightFieldShape};
use holo_render::{Backend, Framing, Integrator, Renderer, Request, Reuse, Sampling, TextureFilter};
use holo_scene::{Scene, gallery};

/// Pixels an axis of a block.
const BLOCK: usize = 16;
const LENSES: GridSize = GridSize::new(4 * BLOCK, 6 * BLOCK);

struct Options {
    scenes: Vec<String>,
    views: usize,
    samples: u32,
    seeds: u64,
    integrator: Integrator,
}

fn main() {
    let options = options();
    println!(
        "{0} x {0} views of {1} x {2} px, {3} samples, {4} seeds, {5:?}",
        options.views, LENSES.columns, LENSES.rows, options.samples, options.seeds, options.integrator
    );
    println!("{:<16} {:>8} {:>12} {:>12} {:>16}", "", "blocks", "beyond 3, %", "largest", "mean / mean - 1");
    let (mut beyond, mut count) = (0, 0);
    for scene in &options.scenes {
        let found = measure(scene, &options);
        beyond += found.0;
        count += found.1;
    }
    println!("{:<16} {count:>8} {:>12.3}", "all", percent(beyond, count));
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

fn options() -> Options {
    let mut options = Options { scenes: Vec::new(), views: 4, samples: 4, seeds: 64, integrator: Integrator::Path };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|text| text.parse().ok()).expect("a number after the option");
        match argument.as_str() {
            "--views" => options.views = number() as usize,
            "--spp" => options.samples = number(),
            "--seeds" => options.seeds = number().into(),
            "--direct" => options.integrator = Integrator::Direct,
            _ => options.scenes.push(argument),
        }
    }
    if options.scenes.is_empty() {
        options.scenes = gallery::NAMES.iter().map(|&name| name.to_owned()).collect();
        options.scenes.push(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/radiance/metal_and_glass.glb").into());
    }
    options
}

/// Prints a line; returns how many blocks differ by more than 3 standard errors, and of how many.
fn measure(name: &str, options: &Options) -> (usize, usize) {
    let scene = holo_bench::scene(name);
    let (renderer, request) = framed(&scene, options);
    let usual = request.clone().reuse(Reuse::Views);
    let plain = request.reuse(Reuse::Off).roulette(false).sampling(Sampling::Independent);
    let [usual, plain] = [(usual, 0), (plain, options.seeds)].map(|(request, first)| {
        let seeds = first..first + options.seeds;
        let blocks = seeds.map(|seed| {
            let rendered = renderer.render(&request.clone().seed(seed), &()).expect("a render");
            block_means(&rendered.color.expect("the scene is lit"))
        });
        means_and_variances(&blocks.collect::<Vec<_>>())
    });
    let differences: Vec<f64> = usual
        .iter()
        .zip(&plain)
        .map(|(a, b)| {
            let error = ((a[1] + b[1]) / options.seeds as f64).sqrt();
            // Black blocks have neither error nor difference.
            if error > 0.0 { (a[0] - b[0]).abs() / error } else { f64::from(u8::from(a[0] != b[0])) * f64::INFINITY }
        })
        .filter(|difference| !difference.is_nan())
        .collect();
    let beyond = differences.iter().filter(|&&difference| difference > 3.0).count();
    let total = |blocks: &[[f64; 2]]| blocks.iter().map(|block| block[0]).sum::<f64>();
    println!(
        "{:<16} {:>8} {:>12.3} {:>12.2} {:>16.1e}",
        name.rsplit('/').next().unwrap_or(name).trim_end_matches(".glb"),
        differences.len(),
        percent(beyond, differences.len()),
        differences.iter().copied().fold(0.0, f64::max),
        total(&usual) / total(&plain) - 1.0
    );
    (beyond, differences.len())
}

fn framed(scene: &Scene, options: &Options) -> (Renderer, Request) {
    let shape = LightFieldShape::new(GridSize::new(options.views, options.views), LENSES).expect("sizes");
    let framed = Framing::new(shape).frame(scene).expect("a camera");
    let renderer = Renderer::new(scene, &framed.pose, Backend::Auto, None).expect("a renderer");
    let rig = framed.rig(renderer.automatic_focus_m(&framed).expect("a focus")).expect("a rig");
    let request = Request::new(rig).integrator(options.integrator).samples(options.samples);
    (renderer, request.texture_filter(TextureFilter::Off))
}

/// The means over blocks of all views, channels together.
fn block_means(color: &LightFieldOwned<f32>) -> Vec<f64> {
    let views = color.shape().views();
    let views = (0..views.rows).flat_map(|row| (0..views.columns).map(move |column| (row, column)));
    let mut means = Vec::new();
    for (row, column) in views {
        let view = color.view(row, column).expect("a view");
        for block in view.exact_chunks((BLOCK, BLOCK, 3)) {
            means.push(block.iter().map(|&x| f64::from(x)).sum::<f64>() / block.len() as f64);
        }
    }
    means
}

/// Mean and variance over the seeds, of every block.
fn means_and_variances(seeds: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let count = seeds.len() as f64;
    (0..seeds[0].len())
        .map(|block| {
            let values = seeds.iter().map(|blocks| blocks[block]);
            let mean = values.clone().sum::<f64>() / count;
            [mean, values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)]
        })
        .collect()
}
