//! `holo render`: scene in, folder of images and ground truth out.

use std::time::Instant;

use holo_core::LightFieldOwned;
use holo_io::{CameraPose, Compression, Manifest, ManifestRig, Meaning, ParametersCfg, Setting, Written, dataset};
use holo_render::{GroundTruth, Integrator, Rendered, Request, Truth, exposure};
use ndarray::ArrayView3;
use rayon::prelude::*;

use super::output::OutputFolder;
use super::prepare::{Prepared, prepare};
use crate::arguments::{ExposureArgument, GroundTruthArgument, IntegratorArgument, Output, RenderOptions};
use crate::console::{out, say};
use crate::failure::Failure;
use crate::progress::Bar;
use crate::report::{Report, Seconds, integrator_name};

pub fn run(options: &RenderOptions) -> Result<(), Failure> {
    let start = Instant::now();
    refuse_what_cannot_be(options)?;
    let mut folder = OutputFolder::create(&options.out)?;
    let prepared = prepare(&options.scene, &options.rig, &options.engine, sample_bytes(options), options.quiet)?;
    let request = request(options, &prepared);

    let rendering = Instant::now();
    let bar = Bar::new("rendering", options.quiet);
    let rendered = prepared.renderer.render(&request, &bar);
    bar.finish();
    let mut rendered = rendered?;
    let outputs = outputs(options, &rendered)?;
    let exposure_ev = rendered.color.as_ref().map(|color| match options.exposure {
        ExposureArgument::Stops(stops) => stops,
        ExposureArgument::Automatic => prepared.renderer.install(|| exposure::automatic_exposure(color)),
    });
    let mut seconds = Seconds {
        load: prepared.load_seconds,
        build: prepared.build_seconds,
        render: rendering.elapsed().as_secs_f64(),
        ..Seconds::default()
    };
    if !options.quiet && rendered.integrator == Integrator::Depth && request.integrator == Integrator::Auto {
        say!("note: the scene has no light, so there is no picture, only ground truth; try --sky 1,1,1");
    }

    let writing = Instant::now();
    let disparity_px = finite_range(&rendered.central);
    folder.unseal()?;
    prepared.renderer.install(|| write(&mut folder, options, &mut rendered, &outputs, exposure_ev, disparity_px))?;
    let parameters = parameters(options, &prepared, disparity_px);
    folder.add(dataset::PARAMETERS_CFG, parameters.write(folder.file(dataset::PARAMETERS_CFG))?);
    let files = folder.seal(manifest(options, &prepared, &rendered, &request, exposure_ev, disparity_px)?)?;
    seconds.write = writing.elapsed().as_secs_f64();
    seconds.total = start.elapsed().as_secs_f64();

    let split = *prepared.rig.split();
    let report = Report {
        seconds,
        rays: rendered.rays,
        samples: split.views().count() as u64 * split.lenses().count() as u64 * u64::from(request.samples),
        backend: prepared.renderer.engine_name(),
        threads: prepared.renderer.threads(),
        integrator: rendered.integrator,
        why: &rendered.why,
        rig: &prepared.rig,
        disparity_px,
        files: &files,
    };
    if !options.quiet {
        report.print(&options.out);
    }
    if options.json {
        out!("{}", report.json())?;
    }
    Ok(())
}

/// The two raw images.
const PICTURES: [Output; 2] = [Output::Vpi, Output::El];

/// What the options alone show to be impossible, before anything is touched.
fn refuse_what_cannot_be(options: &RenderOptions) -> Result<(), Failure> {
    for (output, name) in [(Output::Mat, "mat"), (Output::Exr, "exr"), (Output::H5, "h5"), (Output::Hci, "hci")] {
        if options.write.contains(&output) {
            return Err(Failure::Usage(format!(
                "--write {name} is not in this version; it writes vpi, el, disparity and depth"
            )));
        }
    }
    if options.integrator == IntegratorArgument::Depth && options.write.iter().any(|o| PICTURES.contains(o)) {
        return Err(Failure::Usage(
            "--integrator depth makes no picture; leave vpi and el out of --write, or choose --integrator direct"
                .into(),
        ));
    }
    Ok(())
}

/// How many bytes the renderer keeps of every sample of the light field.
fn sample_bytes(options: &RenderOptions) -> usize {
    let color = if options.integrator == IntegratorArgument::Depth { 0 } else { 3 * size_of::<f32>() };
    let truth = if options.ground_truth == GroundTruthArgument::All { 2 * size_of::<f32>() } else { 0 };
    color + truth
}

fn request(options: &RenderOptions, prepared: &Prepared) -> Request {
    let integrator = match options.integrator {
        // Nobody asked for a picture: no light needs to be traced.
        IntegratorArgument::Auto if wants_no_picture(&options.write) => Integrator::Depth,
        IntegratorArgument::Auto => Integrator::Auto,
        IntegratorArgument::Depth => Integrator::Depth,
        IntegratorArgument::Direct => Integrator::Direct,
        IntegratorArgument::Path => Integrator::Path,
    };
    let samples = options.spp.unwrap_or(if integrator == Integrator::Depth { 1 } else { 16 });
    Request {
        integrator,
        samples,
        seed: options.seed,
        sky: options.sky.0,
        max_bounces: options.max_bounces,
        roulette: !options.no_roulette,
        indirect: !options.no_indirect,
        ground_truth: match options.ground_truth {
            GroundTruthArgument::Central => GroundTruth::Central,
            GroundTruthArgument::All => GroundTruth::All,
        },
        ..Request::new(prepared.rig)
    }
}

fn wants_no_picture(wanted: &[Output]) -> bool {
    !wanted.is_empty() && !wanted.iter().any(|output| matches!(output, Output::Vpi | Output::El))
}

/// What to write: what was asked for, or all that there is.
fn outputs(options: &RenderOptions, rendered: &Rendered) -> Result<Vec<Output>, Failure> {
    if options.write.is_empty() {
        let truth = [Output::Disparity, Output::Depth];
        return Ok(if rendered.color.is_some() { [PICTURES, truth].concat() } else { truth.to_vec() });
    }
    if rendered.color.is_none() && options.write.iter().any(|o| PICTURES.contains(o)) {
        return Err(Failure::Usage(
            "the scene has no light, so there is no picture to write; leave vpi and el out of --write, or light it with \
             --sky 1,1,1"
                .into(),
        ));
    }
    Ok(options.write.clone())
}

/// The range of the finite disparities of the central view; also infinitely far pixels have a finite disparity.
fn finite_range(central: &Truth<ndarray::Array2<f32>>) -> Option<(f64, f64)> {
    let finite = central.disparity_px.iter().filter(|d| d.is_finite()).map(|&d| f64::from(d));
    let range = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), d| (min.min(d), max.max(d)));
    (range.0 <= range.1).then_some(range)
}

fn write(
    folder: &mut OutputFolder,
    options: &RenderOptions,
    rendered: &mut Rendered,
    outputs: &[Output],
    exposure_ev: Option<f64>,
    disparity_px: Option<(f64, f64)>,
) -> Result<(), Failure> {
    let central = &rendered.central;
    if outputs.contains(&Output::Depth) {
        let path = folder.file(dataset::DEPTH_PFM);
        folder.add(dataset::DEPTH_PFM, holo_io::write_pfm(path, central.depth_m.view())?);
    }
    if outputs.contains(&Output::Disparity) {
        let plane = central.disparity_px.view();
        folder.add(dataset::DISPARITY_PFM, holo_io::write_pfm(folder.file(dataset::DISPARITY_PFM), plane)?);
        let (low, high) = disparity_px.unwrap_or((0.0, 0.0));
        let path = folder.file(dataset::DISPARITY_PNG);
        let written = holo_io::write_disparity_png(path, plane, low, high, Compression::Published)?;
        folder.add(dataset::DISPARITY_PNG, written);
    }
    if let Some(all) = &rendered.all {
        for (wanted, name, field) in
            [(Output::Depth, "depth", &all.depth_m), (Output::Disparity, "disparity", &all.disparity_px)]
        {
            if outputs.contains(&wanted) {
                write_all_views(folder, name, field)?;
            }
        }
    }
    // The radiance is four times the size of what is written: it goes as soon as it is encoded.
    if let (Some(color), Some(ev)) = (rendered.color.take(), exposure_ev) {
        if options.bit_depth == 16 {
            let coded = exposure::encode_16bit(&color, ev)?;
            drop(color);
            write_raw(folder, outputs, coded, holo_io::write_png_u16)?;
        } else {
            let coded = exposure::encode_8bit(&color, ev)?;
            drop(color);
            write_raw(folder, outputs, coded, holo_io::write_png_u8)?;
        }
    }
    Ok(())
}

/// One PFM a view in a folder of its own, numbered as in the HCI layout: view row * columns + view column.
fn write_all_views(folder: &mut OutputFolder, name: &str, field: &LightFieldOwned<f32>) -> Result<(), Failure> {
    folder.subfolder(name)?;
    let views = field.split().views();
    let digits = 3.max((views.count() - 1).to_string().len());
    let written: Vec<(String, Written)> = (0..views.count())
        .into_par_iter()
        .map(|k| {
            let file = format!("{name}/scene_{name}_Cam{k:0digits$}.pfm");
            let view = field.view(k / views.columns, k % views.columns)?;
            let written = holo_io::write_pfm(folder.file(&file), view.index_axis(ndarray::Axis(2), 0))?;
            Ok((file, written))
        })
        .collect::<Result<_, Failure>>()?;
    written.into_iter().for_each(|(file, written)| folder.add(file, written));
    Ok(())
}

/// The two raw images, side by side on two threads.
fn write_raw<T: Copy + Send + Sync>(
    folder: &mut OutputFolder,
    outputs: &[Output],
    coded: LightFieldOwned<T>,
    png: fn(std::path::PathBuf, ArrayView3<T>, Meaning, Compression) -> Result<Written, holo_io::Error>,
) -> Result<(), Failure> {
    let write = |name: &str, image: ArrayView3<T>| png(folder.file(name), image, Meaning::Srgb, Compression::Published);
    let (elemental, viewpoint) = rayon::join(
        || {
            outputs.contains(&Output::El).then(|| {
                let name = dataset::ELEMENTAL_PNG;
                match coded.as_elemental_grid() {
                    Some(image) => write(name, image),
                    None => write(name, coded.to_elemental_grid().view()),
                }
            })
        },
        || outputs.contains(&Output::Vpi).then(|| write(dataset::VIEWPOINT_PNG, coded.to_viewpoint_grid().view())),
    );
    for (name, written) in [(dataset::ELEMENTAL_PNG, elemental), (dataset::VIEWPOINT_PNG, viewpoint)] {
        if let Some(written) = written {
            folder.add(name, written?);
        }
    }
    Ok(())
}

fn parameters(options: &RenderOptions, prepared: &Prepared, disparity_px: Option<(f64, f64)>) -> ParametersCfg {
    let mut parameters = ParametersCfg::from_rig(prepared.rig.parameters());
    let pose = prepared.framed.pose;
    let [right, up, back] = pose.columns;
    parameters.center_cam = Some(CameraPose::from_gltf(pose.translation, right, up, back));
    parameters.scene = options.scene.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    parameters.cycles_seed = i64::try_from(options.seed).ok();
    if let Some((min, max)) = disparity_px {
        parameters.set_disparity_range_px(min, max);
    }
    // Reproducible builds set this; without it files carry no date.
    if let Some(seconds) = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse::<i64>().ok()) {
        parameters.date = holo_io::date_from_epoch(seconds);
    }
    parameters
}

fn manifest(
    options: &RenderOptions,
    prepared: &Prepared,
    rendered: &Rendered,
    request: &Request,
    exposure_ev: Option<f64>,
    disparity_px: Option<(f64, f64)>,
) -> Result<Manifest, Failure> {
    let scene = holo_io::hash_file(&options.scene)?;
    let mut manifest = Manifest {
        seed: options.seed,
        rig: Some(ManifestRig::from(prepared.rig.parameters())),
        disparity_px,
        exposure_ev,
        ..Manifest::default()
    };
    manifest.versions.insert("holo".into(), env!("CARGO_PKG_VERSION").into());
    manifest.versions.insert("engine".into(), prepared.renderer.engine_name().into());
    let settings = &mut manifest.settings;
    settings.insert("scene_sha256".into(), scene.sha256.to_string().into());
    settings.insert("camera".into(), prepared.framed.camera.clone().into());
    settings.insert("integrator".into(), integrator_name(rendered.integrator).into());
    settings.insert("spp".into(), request.samples.into());
    let sky = request.sky.map(|c| Setting::Float(f64::from(c)));
    settings.insert("sky".into(), Setting::List(sky.to_vec()));
    settings.insert("bit-depth".into(), u32::from(options.bit_depth).into());
    let all = request.ground_truth == GroundTruth::All;
    settings.insert("ground-truth".into(), if all { "all" } else { "central" }.into());
    Ok(manifest)
}
