//! `holo render`: scene in, folder of images and ground truth out.

use std::time::Instant;

use holo_io::{CameraPose, Manifest, ManifestRig, ParametersCfg, Setting, dataset};
use holo_render::{GroundTruth, Integrator, Layers, Rendered, Request, exposure};
use ndarray::Array3;

use super::layers::{self, Wanted};
use super::output::OutputFolder;
use super::pictures::{self, Pictures};
use super::prepare::{Prepared, Purpose, prepare};
use super::sky;
use crate::arguments::{ExposureArgument, GroundTruthArgument, IntegratorArgument, Output, RenderOptions};
use crate::console::{out, say};
use crate::failure::Failure;
use crate::progress::Bar;
use crate::report::{Report, Seconds, integrator_name};

pub fn run(options: &RenderOptions) -> Result<(), Failure> {
    let start = Instant::now();
    refuse_what_cannot_be(options)?;
    let mut folder = OutputFolder::create(&options.out)?;
    let wanted = Wanted::new(options);
    let prepared = prepare(&options.scene, &options.rig, &options.engine, purpose(options, &wanted), options.quiet)?;
    let request = request(options, &wanted, &prepared);

    let rendering = Instant::now();
    let bar = Bar::new("rendering", options.quiet);
    let rendered = prepared.renderer.render(&request, &bar);
    bar.finish();
    let mut rendered = rendered?;
    // Of all views fewer layers may be wanted than of the central one.
    let missing = wanted.central.without(rendered.central.set());
    if !missing.is_empty() {
        rendered.central.extend(prepared.renderer.central_layers(&prepared.rig, missing)?);
    }
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
    let manifest = manifest(options, &wanted, &prepared, &rendered, &request, exposure_ev, disparity_px)?;
    let parameters = parameters(options, &prepared, disparity_px);
    folder.unseal()?;
    prepared.renderer.install(|| {
        layers::write(&mut folder, &wanted, &rendered, disparity_px)?;
        let pictures = Pictures { options, outputs: &outputs, rig: &prepared.rig, parameters: &parameters };
        pictures.write(&mut folder, &wanted, &mut rendered, exposure_ev)
    })?;
    folder.add(dataset::PARAMETERS_CFG, parameters.write(folder.file(dataset::PARAMETERS_CFG))?);
    let files = folder.seal(manifest)?;
    seconds.write = writing.elapsed().as_secs_f64();
    seconds.total = start.elapsed().as_secs_f64();

    let split = *prepared.rig.split();
    let report = Report {
        seconds,
        rays: rendered.rays,
        samples: match rendered.integrator {
            Integrator::Depth => split.views().count() as u64 * split.lenses().count() as u64,
            _ => rendered.samples,
        },
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

/// What the options alone show to be impossible, before anything is touched.
fn refuse_what_cannot_be(options: &RenderOptions) -> Result<(), Failure> {
    #[cfg(not(feature = "hdf5"))]
    if options.write.contains(&Output::H5) {
        return Err(pictures::without_hdf5());
    }
    if let Some(names) =
        pictures::needing_color(&options.write).filter(|_| options.integrator == IntegratorArgument::Depth)
    {
        return Err(Failure::Usage(format!(
            "--integrator depth makes no picture; leave {names} out of --write, or choose --integrator direct"
        )));
    }
    if options.integrator == IntegratorArgument::Depth && layers::names_color(options) {
        return Err(Failure::Usage(
            "--integrator depth makes no picture; leave color out of --layers, or choose --integrator direct".into(),
        ));
    }
    Ok(())
}

/// What the renderer keeps.
fn purpose<'a>(options: &'a RenderOptions, wanted: &Wanted) -> Purpose<'a> {
    let color = if options.integrator == IntegratorArgument::Depth { 0 } else { 3 };
    Purpose {
        sky: sky::map(&options.sky),
        sample_bytes: (color + wanted.all.channels()) * size_of::<f32>(),
        lens_bytes: wanted.central.channels() * size_of::<f32>(),
    }
}

fn request(options: &RenderOptions, wanted: &Wanted, prepared: &Prepared) -> Request {
    let integrator = match options.integrator {
        // Nobody asked for a picture: no light needs to be traced.
        IntegratorArgument::Auto if wants_no_picture(options, wanted) => Integrator::Depth,
        IntegratorArgument::Auto => Integrator::Auto,
        IntegratorArgument::Depth => Integrator::Depth,
        IntegratorArgument::Direct => Integrator::Direct,
        IntegratorArgument::Path => Integrator::Path,
    };
    let samples = options.spp.unwrap_or(match (integrator, options.target_error) {
        (Integrator::Depth, _) => 1,
        (_, Some(_)) => 1024,
        (_, None) => 16,
    });
    Request {
        integrator,
        samples,
        seed: options.seed,
        sky: sky::constant(&options.sky),
        max_bounces: options.max_bounces,
        roulette: !options.no_roulette,
        target_error: options.target_error,
        indirect: !options.no_indirect,
        layers: match options.ground_truth {
            GroundTruthArgument::Central => wanted.central,
            GroundTruthArgument::All => wanted.all,
        },
        ground_truth: match options.ground_truth {
            GroundTruthArgument::Central => GroundTruth::Central,
            GroundTruthArgument::All => GroundTruth::All,
        },
        ..Request::new(prepared.rig)
    }
}

fn wants_no_picture(options: &RenderOptions, wanted: &Wanted) -> bool {
    let shows = options.write.contains(&Output::Exr) || pictures::needing_color(&options.write).is_some();
    !wanted.color && !options.write.is_empty() && !shows
}

/// What to write beside layers: what was asked for, or the pictures if there are any.
fn outputs(options: &RenderOptions, rendered: &Rendered) -> Result<Vec<Output>, Failure> {
    if rendered.color.is_none() && layers::names_color(options) {
        return Err(Failure::Usage(
            "the scene has no light, so there is no picture to write; leave color out of --layers, or light the scene \
             with --sky 1,1,1"
                .into(),
        ));
    }
    if options.write.is_empty() {
        return Ok(if rendered.color.is_some() { pictures::USUAL.to_vec() } else { Vec::new() });
    }
    if let Some(names) = pictures::needing_color(&options.write).filter(|_| rendered.color.is_none()) {
        return Err(Failure::Usage(format!(
            "the scene has no light, so there is no picture to write; leave {names} out of --write, or light it with \
             --sky 1,1,1"
        )));
    }
    Ok(options.write.clone())
}

/// The range of the finite disparities of the central view; also infinitely far pixels have a finite disparity.
fn finite_range(central: &Layers<Array3<f32>>) -> Option<(f64, f64)> {
    let disparities = central.disparity_px().into_iter().flatten();
    let finite = disparities.filter(|d| d.is_finite()).map(|&d| f64::from(d));
    let range = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), d| (min.min(d), max.max(d)));
    (range.0 <= range.1).then_some(range)
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
    wanted: &Wanted,
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
    if let Some(target) = request.target_error {
        settings.insert("target-error".into(), Setting::Float(target));
    }
    if rendered.integrator == Integrator::Path {
        settings.insert("max-bounces".into(), request.max_bounces.into());
        settings.insert("roulette".into(), if request.roulette { "on" } else { "off" }.into());
        settings.insert("indirect".into(), if request.indirect { "on" } else { "off" }.into());
    }
    let sky = request.sky.map(|c| Setting::Float(f64::from(c)));
    settings.insert("sky".into(), Setting::List(sky.to_vec()));
    if let Some(path) = sky::map(&options.sky) {
        settings.insert("sky_sha256".into(), holo_io::hash_file(path)?.sha256.to_string().into());
    }
    settings.insert("bit-depth".into(), u32::from(options.bit_depth).into());
    settings.insert("layers".into(), wanted.names(rendered).into());
    let all = request.ground_truth == GroundTruth::All;
    settings.insert("ground-truth".into(), if all { "all" } else { "central" }.into());
    Ok(manifest)
}
