//! The error of the images of a dataset against references with many samples.
//!
//! `dataset_error DATASET [--views 20,100] [--scenes NAME,..] [--samples 4096] [--rows 24]`, for scenes of the gallery.
//! For each job, three of its views are rendered again without reconstruction, in `--rows` lens rows in the middle: the
//! central one, the one in the upper left corner and the one in the middle of the upper edge. A pixel of the 8-bit image is
//! converted to linear light and compared with the reference by luminance: |x - g| / g, with g cut where the integers are.
//! Printed are quantiles over the pixels of all three views, and beside them the estimate in the manifest (a standard error;
//! of a normal distribution the median is 0.67 of it), the error of rounding the reference to 8 bits, and the
//! noise of the reference from the difference of its two halves.
#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use holo_bench::error::{error_in_8bit, error_of_codes, luminance, rgb, sorted};
use holo_core::{DynLightField, LightFieldOwned, ViewIndex};
use holo_io::dataset::{self, DatasetFolder};
use holo_io::{Limits, Manifest, ManifestValue};
use holo_render::{Backend, Framing, Integrator, Renderer, Request, TextureFilter, Views};
use holo_scene::gallery;

struct Settings {
    root: PathBuf,
    views: Vec<u32>,
    scenes: Vec<String>,
    samples: u32,
    rows: usize,
}

/// Errors as they are printed.
type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("dataset_error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let settings = settings()?;
    let mut jobs = dataset::list(&settings.root)?;
    jobs.retain(|job| {
        let is_named = settings.scenes.is_empty() || settings.scenes.contains(&job.scene);
        is_named && job.views().is_some_and(|own| settings.views.iter().any(|&views| views as usize == own.columns))
    });
    if jobs.is_empty() {
        return Err(format!("{}: no light field of these --views and --scenes", settings.root.display()).into());
    }
    println!("{} samples, {} lens rows; median and 90 % of the pixels, relative", settings.samples, settings.rows);
    println!(
        "| scene | views | samples | estimated, standard error | measured | of 8 bits alone | noise of the reference |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut medians: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for job in jobs {
        let Some(views) = job.views() else { continue };
        let measured = measure(&job.scene, &job.path, &settings)?;
        let [estimated, all, rounding, reference] = measured.quantiles.map(|[median, high]| percent(median, high));
        let samples = measured.samples;
        println!("| {} | {views} | {samples} | {estimated} | {all} | {rounding} | {reference} |", job.scene);
        medians.entry(views.columns).or_default().push(measured.quantiles[1][0]);
    }
    for (views, medians) in medians {
        let medians = sorted(&medians);
        let [least, middle, most] = [0, medians.len() / 2, medians.len() - 1].map(|k| medians[k] * 100.0);
        println!(
            "{views} x {views} views: measured median {middle:.2} % (median of the scenes), {least:.2} to {most:.2} %"
        );
    }
    Ok(())
}

fn settings() -> Result<Settings> {
    let (mut root, mut views, mut scenes, mut samples, mut rows) = (None, vec![20, 100], Vec::new(), 4096, 24);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        let number = |text: &str| text.parse::<u32>().map_err(|_| format!("{argument}: '{text}' is not a number"));
        match argument.as_str() {
            "--views" => views = value()?.split(',').map(number).collect::<std::result::Result<_, _>>()?,
            "--scenes" => scenes = value()?.split(',').map(str::to_owned).collect(),
            "--samples" => samples = number(&value()?)?.max(2),
            "--rows" => rows = number(&value()?)?.max(1),
            option if option.starts_with("--") => {
                return Err(format!("unknown option {option}; known are --views, --scenes, --samples, --rows").into());
            }
            _ => root = Some(PathBuf::from(argument)),
        }
    }
    let root = root.ok_or("give the folder of a dataset")?;
    Ok(Settings { root, views, scenes, samples, rows: rows as usize })
}

fn percent(median: f64, high: f64) -> String {
    format!("{:.2} %, {:.2} %", median * 100.0, high * 100.0)
}

struct Measured {
    samples: f64,
    /// Median and ninth decile of: the estimate, the image, rounding, the reference.
    quantiles: [[f64; 2]; 4],
}

/// The error of a job.
fn measure(scene: &str, folder: &Path, settings: &Settings) -> Result<Measured> {
    let bad = |what: &str| format!("{}: {what}", folder.display());
    let folder = DatasetFolder::open(folder)?;
    let (rig, manifest) = (*folder.rig(), folder.manifest());
    let number = |name: &str| manifest.settings.get(name).and_then(ManifestValue::as_f64);
    let gain = manifest.exposure_ev.ok_or_else(|| bad("has no color"))?.exp2() as f32;
    let DynLightField::U8(coded) = folder.read(&Limits::default())? else {
        return Err(bad("its image has not 8 bits").into());
    };
    let scene = gallery::scene(scene).ok_or_else(|| bad("not a scene of the gallery; choose by --scenes"))?;
    let framed = Framing::new(*rig.shape()).frame(&scene)?;
    let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, None)?;
    let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
    let first = lenses.rows.saturating_sub(settings.rows) / 2;
    let rows = first..(first + settings.rows).min(lenses.rows);
    let list = [(views.rows / 2, views.columns / 2), (0, 0), (0, views.columns / 2)];
    let text = |name: &str| manifest.settings.get(name).and_then(ManifestValue::as_text);
    let half = |seed: u64| -> Result<LightFieldOwned<f32>> {
        let list = list.map(|(row, column)| ViewIndex { row, column }).to_vec();
        let request = Request::new(rig)
            .integrator(if text("integrator") == Some("direct") { Integrator::Direct } else { Integrator::Path })
            .max_bounces(number("max-bounces").map_or(8, |bounces| bounces as u32))
            .indirect(text("indirect") != Some("off"))
            .samples(settings.samples / 2)
            .seed(seed)
            .texture_filter(TextureFilter::Off)
            .rows(Some(rows.clone()))
            .views(Views::List(list));
        renderer.render(&request, &())?.color.ok_or_else(|| bad("its scene has no light").into())
    };
    let halves = [half(1)?, half(2)?];
    let mut errors: [Vec<f64>; 3] = Default::default();
    for (k, (t, s)) in list.into_iter().enumerate() {
        let [a, b] = [halves[0].view(0, k)?, halves[1].view(0, k)?];
        let coded = coded.view(t, s)?;
        for (v, (a, b)) in a.outer_iter().zip(b.outer_iter()).enumerate() {
            for (u, (a, b)) in a.outer_iter().zip(b.outer_iter()).enumerate() {
                let (Some(a), Some(b)) = (rgb(a.iter()), rgb(b.iter())) else { continue };
                let [a, b] = [a, b].map(|pixel| pixel.map(|x| x * gain));
                let mean = [0, 1, 2].map(|c| ((a[c] + b[c]) / 2.0).min(1.0));
                let codes = [0, 1, 2].map(|c| coded[[rows.start + v, u, c]]);
                let (image, rounding) = (error_of_codes(codes, mean), error_in_8bit(mean, mean));
                errors[0].extend(image);
                errors[1].extend(rounding);
                let [a, b] = [a, b].map(|pixel| luminance(pixel.map(|x| x.min(1.0))));
                errors[2].extend((luminance(mean) > 0.0).then(|| (a - b).abs() / 2.0 / luminance(mean)));
            }
        }
    }
    let [image, rounding, reference] = errors.map(|errors| {
        let errors = sorted(&errors);
        if errors.is_empty() {
            return [f64::NAN; 2];
        }
        [errors[errors.len() / 2], errors[errors.len() * 9 / 10]]
    });
    let samples = number("spp").unwrap_or(0.0);
    Ok(Measured { samples, quantiles: [estimated(manifest), image, rounding, reference] })
}

fn estimated(manifest: &Manifest) -> [f64; 2] {
    let Some(ManifestValue::Table(statistics)) = manifest.settings.get("statistics") else { return [f64::NAN; 2] };
    ["error-median", "error-percentile-90"]
        .map(|name| statistics.get(name).and_then(ManifestValue::as_f64).unwrap_or(f64::NAN))
}
