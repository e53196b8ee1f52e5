//! This renderer, Mitsuba 3 and Blender's Cycles on the same scene, views, samples and reference, in the same run.
//!
//! `cargo xtask report --peers` installs both under `target/peers` and names that folder in `HOLO_PEERS`; the scripts
//! that drive them are in `crates/holo-bench/peers`. The scene and the reference, many thousand samples of Mitsuba's,
//! are those of `tests/radiance`.

use std::path::{Path, PathBuf};

use holo_bench::error::{relative_squared_error, rgb, squared_difference};
use holo_core::{GridSize, LightFieldShape};
use holo_io::Limits;
use holo_render::{Backend, Baseline, Denoise, Framing, Integrator, Renderer, Request, Reuse};
use holo_scene::Scene;
use ndarray::Array3;

use crate::plot::{Plot, Series};
use crate::scenes::{backend_name, integrator_label, integrator_name};
use crate::table::{LONGEST, Seconds, Table, peak_of_process, reset_peak, short, timed};
use crate::{RunOptions, Section, scripts};

/// The width of all views together, and the focus distance, of the scripts: 11 views 2 mm apart.
const APERTURE_M: f64 = 0.02;
const FOCUS_M: f64 = 0.8;
const SKY: [f32; 3] = [0.2, 0.24, 0.32];

/// Time, memory and images of one program for one number of samples.
struct Measurement {
    program: String,
    samples: u32,
    /// Of one view.
    seconds: Seconds,
    peak_bytes: Option<u64>,
    /// The central view, one image per seed.
    images: Vec<Array3<f32>>,
}

pub fn section(options: &RunOptions) -> Section {
    let mut table = Table::new(&[
        "integrator",
        "program",
        "samples",
        "ms per view",
        "Msamples/s",
        "RMSE",
        "relative MSE",
        "without the worst 1 %",
        "time / own time",
        "time x error / own",
        "peak memory, MB",
    ]);
    let samples: &[u32] = if options.quick { &[1, 4] } else { &[1, 4, 16, 64] };
    // More for the others: to reach the error of the reconstruction.
    let [samples_of_peers, of_single_views]: [&[u32]; 2] =
        if options.quick { [samples, &[]] } else { [&[1, 4, 16, 64, 256], &[1024, 4096]] };
    let side = if options.quick { 5 } else { 11 };
    let mut plots = Vec::new();
    let mut missing = Vec::new();
    let mut highlights = Vec::new();
    for (integrator, plot_name) in [(Integrator::Direct, "peers_direct"), (Integrator::Path, "peers_path")] {
        let reference = folder().join(format!("metal_and_glass_{}.pfm", integrator_name(integrator)));
        let reference = holo_io::read_pfm(reference, &Limits::default());
        let reference = reference.expect("the reference of tests/radiance").values;
        let mut lines = Vec::new();
        let engine = options.engines[0];
        for light in [Light::Own, Light::Shared, Light::Denoised] {
            lines.extend(measure_own(options, engine, light, integrator, side, samples));
        }
        if !options.quick {
            lines.extend(measure_own(options, engine, Light::Denoised, integrator, 101, &samples[..2]));
        }
        let (theirs, failures) = measure_peers(options, integrator, side, [samples_of_peers, of_single_views]);
        lines.extend(theirs);
        missing.extend(failures);
        plots.push((plot_name, add_rows(integrator, &lines, &reference, &mut table, &mut highlights)));
    }
    missing.sort();
    missing.dedup();
    let missing = if missing.is_empty() { String::new() } else { format!(" Not run: {}.", missing.join("; ")) };
    Section {
        text: format!(
            "`tests/radiance/metal_and_glass.glb` (rough metal, glass, dielectric coat; two lights and a sky), views \
             of 99 x 66 px over an aperture of 20 mm, focus distance 0.8 m, paths of up to 8 bounces without Russian \
             roulette, all threads. `holo` and Mitsuba 3 (`llvm_ad_rgb`, one `batch`, kernels compiled before) render \
             {side} x {side} views at once; Blender's Cycles renders one view at a time with the scene kept in memory. \
             Ratios are to `holo` with *reuse off*, where every pixel has samples of its own alone, as in the others; \
             *reuse views* shares samples in groups of 16 views, *denoise views* is the reconstruction across views, and *OIDN* \
             OpenImageDenoise in Cycles with albedo, normals and accurate prefilter. \
             `holo` scatters light once between microfacets (`--no-multiple-scattering`), as Mitsuba does. \
             With more than 256 samples the others render a single view. \
             Errors are those of the central view against a reference of thousands of samples, averaged over seeds \
             (of single views one): the mean of (x - r)^2 / (r^2 + 0.01 mean(r^2)), which contains the noise of the reference, some 5e-6. \
             The reference was rendered by Mitsuba; Cycles models the coat differently, with a difference of up to 3 % \
             on one small ball. Time x error excludes the 1 % of pixels with the largest errors, because a few \
             fireflies dominate the plain mean. Memory is the peak of the whole process.{missing}"
        ),
        highlights,
        table,
        plots,
    }
}

/// Adds the measurements of one integrator to the table, and those of the most samples to the summary; returns their
/// plot. The measurements of this renderer come first: the others are relative to them.
fn add_rows(
    integrator: Integrator,
    lines: &[Measurement],
    reference: &Array3<f32>,
    table: &mut Table,
    highlights: &mut Vec<[String; 3]>,
) -> String {
    let label = integrator_name(integrator);
    let most = lines.iter().filter(|line| line.program == lines[0].program).map(|line| line.samples).max().unwrap_or(0);
    let own_program = lines[0].program.replace("holo, ", "`holo` with ");
    let mut own = Vec::new();
    let mut series: Vec<Series> = Vec::new();
    for line in lines {
        let [rmse, relative, trimmed] = errors(&line.images, reference);
        let cost = Seconds { median: line.seconds.median * trimmed, ..line.seconds };
        if line.program == lines[0].program {
            own.push((line.samples, line.seconds, cost));
        }
        let same = own.iter().find(|own| own.0 == line.samples);
        let ratio = |of: &dyn Fn(&(u32, Seconds, Seconds)) -> String| same.map_or("-".into(), of);
        let pixels = (reference.len() / 3) as f64;
        table.push([
            label.into(),
            line.program.clone(),
            line.samples.to_string(),
            Seconds { median: 1e3 * line.seconds.median, ..line.seconds }.text(),
            short(pixels * f64::from(line.samples) / line.seconds.median / 1e6),
            short(rmse),
            short(relative),
            short(trimmed),
            ratio(&|own| line.seconds.ratio(own.1)),
            ratio(&|own| cost.ratio(own.2)),
            line.peak_bytes.map_or("?".into(), |bytes| short(bytes as f64 / 1e6)),
        ]);
        let is_first = line.program == lines[0].program;
        // The reconstruction is shown below, at few samples.
        let is_shown = !line.program.ends_with("denoise views");
        if line.samples == most && !is_first && is_shown {
            let error = short(trimmed);
            highlights.push([
                format!("{}: {}, {most} samples per pixel", line.program, integrator_label(integrator)),
                format!("{} times as long as {own_program}", ratio(&|own| line.seconds.ratio(own.1))),
                format!(
                    "relative MSE {error} (worst 1 % excluded); {} times as long for the same error",
                    ratio(&|own| cost.ratio(own.2))
                ),
            ]);
        }
        let point = (line.seconds.median, trimmed);
        match series.iter_mut().find(|series| series.name == line.program) {
            Some(series) => series.points.push(point),
            None => {
                let dashes = usize::from(!line.program.starts_with("holo"));
                let color = series.iter().filter(|series| series.dashes == dashes).count();
                series.push(Series { name: line.program.clone(), color, dashes, points: vec![point] });
            }
        }
    }
    highlights.extend(for_the_error_of_the_reconstruction(integrator, &series));
    let mut plot = Plot::new(
        &format!("{label}: time against noise, other renderers"),
        "seconds per view of 99 x 66 px",
        "relative squared error, without the worst 1 %",
    );
    series.into_iter().for_each(|series| plot.add(series));
    plot.svg()
}

/// How long the other programs take for the error that the reconstruction reaches with its most samples.
fn for_the_error_of_the_reconstruction(integrator: Integrator, series: &[Series]) -> Vec<[String; 3]> {
    let Some(own) = series.iter().rfind(|series| series.name.ends_with("denoise views")) else { return Vec::new() };
    let Some(&(seconds, error)) = own.points.last() else { return Vec::new() };
    let others = series.iter().filter(|other| ["multijitter", "OIDN"].iter().any(|end| other.name.ends_with(end)));
    let row = |other: &Series| {
        let (more, needed) = seconds_for(error, &other.points)?;
        Some([
            format!("{}: {}, for the error of {}", other.name, integrator_label(integrator), own.name),
            format!("{more}{} times as long", short(needed / seconds)),
            format!("relative MSE {} (worst 1 % excluded)", short(error)),
        ])
    };
    others.filter_map(row).collect()
}

/// The seconds in which a program reaches an error, interpolated between its measurements (seconds, error) on logarithmic
/// scales; after `> ` those of its most samples where these do not suffice.
pub fn seconds_for(error: f64, points: &[(f64, f64)]) -> Option<(&'static str, f64)> {
    let after = points.iter().position(|point| point.1 <= error);
    match after {
        None => Some(("> ", points.last()?.0)),
        Some(0) => Some(("", points[0].0)),
        Some(k) => {
            let ((t0, e0), (t1, e1)) = (points[k - 1], points[k]);
            let part = (error / e0).ln() / (e1 / e0).ln();
            Some(("", t0 * (t1 / t0).powf(part)))
        }
    }
}

/// What the views of this renderer have in common.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Light {
    /// Nothing: the default.
    Own,
    /// Samples in groups of 16 views: `--reuse views`.
    Shared,
    /// Their samples: `--denoise views`.
    Denoised,
}

impl Light {
    fn label(self) -> &'static str {
        match self {
            Self::Own => ", reuse off",
            Self::Shared => ", reuse views",
            Self::Denoised => ", denoise views",
        }
    }
}

/// The folder of the scene and its references.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/radiance")
}

fn measure_own(
    options: &RunOptions,
    engine: Backend,
    light: Light,
    integrator: Integrator,
    side: usize,
    samples: &[u32],
) -> Vec<Measurement> {
    let scene: Scene =
        holo_scene::gltf::load(&folder().join("metal_and_glass.glb"), &Default::default()).expect("a scene").scene;
    let framing = Framing::new(LightFieldShape::new(GridSize::new(side, side), GridSize::new(66, 99)).expect("sizes"))
        .baseline(Baseline::Meters(APERTURE_M / (side - 1) as f64));
    let framed = framing.frame(&scene).expect("a camera");
    let rig = framed.rig(FOCUS_M).expect("a rig");
    let renderer = Renderer::new(&scene, &framed.pose, engine, None).expect("a renderer");
    let size = if side > 11 { format!(", {side} x {side}") } else { String::new() };
    let program = format!("holo, {}{size}{}", backend_name(engine), light.label());
    let rounds = if side > 11 { 1 } else { options.rounds.min(3) };
    let reuse = if light == Light::Own { Reuse::Off } else { Reuse::Views };
    let denoise = if light == Light::Denoised { Denoise::Views } else { Denoise::Off };
    reset_peak();
    samples
        .iter()
        .map(|&samples| {
            let request = Request::new(rig).integrator(integrator).samples(samples).sky(SKY).roulette(false);
            // As in Mitsuba, which the reference is from.
            let request = request.multiple_scattering(false).reuse(reuse).denoise(denoise);
            let mut images = Vec::new();
            let (seconds, ()) = timed(rounds, || {
                let request = request.clone().seed(images.len() as u64);
                let color = renderer.render(&request, &()).expect("a render").color.expect("the scene is lit");
                images.push(color.view(side / 2, side / 2).expect("the central view").to_owned());
            });
            let seconds = Seconds { median: seconds.median / (side * side) as f64, ..seconds };
            Measurement { program: program.clone(), samples, seconds, peak_bytes: peak_of_process(), images }
        })
        .collect()
}

/// Measures Mitsuba with its best sampler, and Blender; also returns a message for each that could not be run. With many
/// samples a single view is enough to be measured.
fn measure_peers(
    options: &RunOptions,
    integrator: Integrator,
    side: usize,
    [samples, of_single_views]: [&[u32]; 2],
) -> (Vec<Measurement>, Vec<String>) {
    let bounces = if integrator == Integrator::Direct { 1 } else { 8 };
    let (rounds, longest) = (options.rounds.min(3).to_string(), LONGEST.to_string());
    let (depth, cycles) = ((bounces + 1).to_string(), (bounces - 1).to_string());
    let mut lines = Vec::new();
    let mut failures = Vec::new();
    let mut collect = |found: Result<Vec<Measurement>, String>| match found {
        Ok(found) => lines.extend(found),
        Err(why) => failures.push(why),
    };
    for (side, samples) in [(side, samples), (1, of_single_views)] {
        let views = side.to_string();
        let arguments = [
            "--side",
            &views,
            "--depth",
            &depth,
            "--rounds",
            &rounds,
            "--longest-s",
            &longest,
            "--sampler",
            "multijitter",
        ];
        // A round renders all views.
        let views = (side * side) as f64;
        collect(run("mitsuba", "mitsuba_grid.py", &arguments, samples, "Mitsuba 3, multijitter", views));
    }
    for (denoise, side, samples) in [("off", "3", samples), ("oidn", "3", samples), ("oidn", "1", of_single_views)] {
        // The noise of many samples is small.
        let seeds = if side == "1" { "1" } else { &rounds };
        let arguments = ["--bounces", &cycles, "--seeds", seeds, "--denoise", denoise, "--side", side];
        let program = if denoise == "off" { "Blender, Cycles" } else { "Blender, Cycles + OIDN" };
        collect(run("blender", "blender_loop.py", &arguments, samples, program, 1.0));
    }
    (lines, failures)
}

fn run(
    peer: &str,
    script: &str,
    arguments: &[&str],
    samples: &[u32],
    program: &str,
    views: f64,
) -> Result<Vec<Measurement>, String> {
    if samples.is_empty() {
        return Ok(Vec::new());
    }
    let samples: Vec<String> = samples.iter().map(u32::to_string).collect();
    let (scene, list) = (folder().join("metal_and_glass.glb"), samples.join(","));
    let arguments = [&["--samples", &list][..], arguments].concat();
    let lines = scripts::run(peer, script, program, &scene, &arguments, |text| -> Vec<Measurement> {
        text.lines().filter_map(|line| parse(line, program, views)).collect()
    })?;
    if lines.len() == samples.len() { Ok(lines) } else { Err(format!("{program}: {} measurements", lines.len())) }
}

/// Parses a line of a script (see `peers/peer.py`): samples, seconds, peak memory, images; `None` for other lines.
fn parse(line: &str, program: &str, views: f64) -> Option<Measurement> {
    let fields: Vec<&str> = line.split('\t').collect();
    let [samples, seconds, peak, images] = fields[..] else { return None };
    let seconds: Option<Vec<f64>> = seconds.split(',').map(|s| Some(s.parse::<f64>().ok()? / views)).collect();
    let read = |path: &str| Some(holo_io::read_pfm(path, &Limits::default()).ok()?.values);
    Some(Measurement {
        program: program.into(),
        samples: samples.parse().ok()?,
        seconds: Seconds::of(seconds?)?,
        peak_bytes: peak.parse().ok(),
        images: images.split(',').map(read).collect::<Option<_>>()?,
    })
}

/// RMSE, relative MSE, and relative MSE without the worst pixels, means over the images.
fn errors(images: &[Array3<f32>], reference: &Array3<f32>) -> [f64; 3] {
    let reference = pixels(reference);
    let mut means = [0.0; 3];
    for image in images.iter().map(pixels) {
        let [trimmed, relative] = relative_squared_error(&image, &reference);
        let errors = [squared_difference(&image, &reference), relative, trimmed];
        means.iter_mut().zip(errors).for_each(|(mean, error)| *mean += error / images.len() as f64);
    }
    means[0] = means[0].sqrt();
    means
}

fn pixels(image: &Array3<f32>) -> Vec<[f32; 3]> {
    image.rows().into_iter().flat_map(|row| rgb(row.iter())).collect()
}
