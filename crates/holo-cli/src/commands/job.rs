//! One render from scene to folder: what `render`, `dataset` and `merge` have in common.

use std::time::Instant;

use holo_core::Rig;
use holo_io::{CameraPose, Manifest, ManifestRig, ParametersCfg, Setting, dataset};
use holo_render::{GroundTruth, Integrator, Layers, Progress, Rendered, Request, exposure};
use ndarray::Array3;

use super::asked::Wish;
use super::layers::{self, Wanted};
use super::output::OutputFolder;
use super::pictures::{self, Pictures};
use super::prepare::{Prepared, Purpose, prepare};
use super::remarks::{About, Remarks};
use super::sky;
use super::source::Source;
use crate::arguments::{ExposureArgument, GroundTruthArgument, IntegratorArgument, JobOptions, Output, Shard};
use crate::failure::Failure;
use crate::report::integrator_name;

/// What was rendered, with all that its files need to know.
pub struct Traced {
    pub rendered: Rendered,
    pub wanted: Wanted,
    pub rig: Rig,
    /// Without what only the whole picture tells: exposure, disparities, files.
    pub manifest: Manifest,
    /// Without the range of disparities.
    pub parameters: ParametersCfg,
}

/// What was found out while the files were written.
pub struct Finished {
    pub disparity_px: Option<(f64, f64)>,
    pub files: Vec<String>,
}

/// What the options alone show to be impossible, before anything is touched.
pub fn refuse_what_cannot_be(options: &JobOptions) -> Result<(), Failure> {
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

/// Loads the scene and makes ready.
pub fn prepare_job(source: &Source, wish: &Wish, remarks: &dyn Remarks) -> Result<Prepared, Failure> {
    let options = &wish.options;
    let wanted = Wanted::new(&options.job);
    prepare(source, &options.rig, &options.engine, purpose(&options.job, &wanted), remarks)
}

/// Renders, all of it or a part. Returns the seconds that it took as well.
pub fn trace(
    source: &Source,
    wish: &Wish,
    prepared: &Prepared,
    shard: Option<Shard>,
    progress: &dyn Progress,
    remarks: &dyn Remarks,
) -> Result<(Traced, f64), Failure> {
    let options = &wish.options.job;
    let wanted = Wanted::new(options);
    let mut request = request(options, &wanted, prepared);
    if let Some(shard) = shard {
        request.lens_rows = Some(prepared.renderer.part_of_lens_rows(&request, shard.part - 1, shard.of)?);
    }
    let start = Instant::now();
    let mut rendered = prepared.renderer.render(&request, progress)?;
    // Of all views fewer layers may be wanted than of the central one.
    let missing = wanted.central.without(rendered.central.set());
    if !missing.is_empty() {
        let mut more = Request { integrator: Integrator::Depth, layers: missing, ..Request::new(prepared.rig) };
        more.lens_rows.clone_from(&request.lens_rows);
        rendered.central.extend(prepared.renderer.render(&more, &())?.central);
    }
    let seconds = start.elapsed().as_secs_f64();
    // What cannot be written is said before the rest is made.
    outputs(options, rendered.color.is_some())?;
    if rendered.integrator == Integrator::Depth && request.integrator == Integrator::Auto {
        let note = "note: the scene has no light, so there is no picture, only ground truth; try --sky 1,1,1";
        remarks.remark(About::Scene, note);
    }
    let manifest = manifest(source, wish, &wanted, prepared, &rendered, &request)?;
    let parameters = parameters(options, source, prepared);
    Ok((Traced { rendered, wanted, rig: prepared.rig, manifest, parameters }, seconds))
}

/// The exposure for the whole picture, if there is one.
pub fn exposure_ev(options: &JobOptions, rendered: &Rendered) -> Option<f64> {
    rendered.color.as_ref().map(|color| match options.exposure {
        ExposureArgument::Stops(stops) => stops,
        ExposureArgument::Automatic => exposure::automatic_exposure(color),
    })
}

/// Writes every file and seals the folder.
pub fn write(
    options: &JobOptions,
    mut traced: Traced,
    exposure_ev: Option<f64>,
    mut folder: OutputFolder,
) -> Result<Finished, Failure> {
    let rendered = &mut traced.rendered;
    let outputs = outputs(options, rendered.color.is_some())?;
    let disparity_px = finite_range(&rendered.central);
    let mut parameters = traced.parameters;
    if let Some((min, max)) = disparity_px {
        parameters.set_disparity_range_px(min, max);
    }
    folder.unseal()?;
    layers::write(&mut folder, &traced.wanted, rendered, disparity_px)?;
    let pictures = Pictures { options, outputs: &outputs, rig: &traced.rig, parameters: &parameters };
    pictures.write(&mut folder, &traced.wanted, rendered, exposure_ev)?;
    folder.add(dataset::PARAMETERS_CFG, parameters.write(folder.file(dataset::PARAMETERS_CFG))?);
    let files = folder.seal(Manifest { disparity_px, exposure_ev, ..traced.manifest })?;
    Ok(Finished { disparity_px, files })
}

/// What the renderer keeps.
fn purpose<'a>(options: &'a JobOptions, wanted: &Wanted) -> Purpose<'a> {
    let color = if options.integrator == IntegratorArgument::Depth { 0 } else { 3 };
    Purpose {
        sky: sky::map(&options.sky),
        sample_bytes: (color + wanted.all.channels()) * size_of::<f32>(),
        lens_bytes: wanted.central.channels() * size_of::<f32>(),
    }
}

fn request(options: &JobOptions, wanted: &Wanted, prepared: &Prepared) -> Request {
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

fn wants_no_picture(options: &JobOptions, wanted: &Wanted) -> bool {
    let shows = options.write.contains(&Output::Exr) || pictures::needing_color(&options.write).is_some();
    !wanted.color && !options.write.is_empty() && !shows
}

/// What to write beside layers: what was asked for, or the pictures if there are any.
fn outputs(options: &JobOptions, has_picture: bool) -> Result<Vec<Output>, Failure> {
    if !has_picture && layers::names_color(options) {
        return Err(Failure::Usage(
            "the scene has no light, so there is no picture to write; leave color out of --layers, or light the scene \
             with --sky 1,1,1"
                .into(),
        ));
    }
    if options.write.is_empty() {
        return Ok(if has_picture { pictures::USUAL.to_vec() } else { Vec::new() });
    }
    if let Some(names) = pictures::needing_color(&options.write).filter(|_| !has_picture) {
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

fn parameters(options: &JobOptions, source: &Source, prepared: &Prepared) -> ParametersCfg {
    let mut parameters = ParametersCfg::from_rig(prepared.rig.parameters());
    let pose = prepared.framed.pose;
    let [right, up, back] = pose.columns;
    parameters.center_cam = Some(CameraPose::from_gltf(pose.translation, right, up, back));
    parameters.scene = source.name();
    parameters.cycles_seed = i64::try_from(options.seed).ok();
    // Reproducible builds set this; without it files carry no date.
    if let Some(seconds) = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse::<i64>().ok()) {
        parameters.date = holo_io::date_from_epoch(seconds);
    }
    parameters
}

/// What decides a job's files beside the options: scene, sky, versions. A manifest that says the same is of the same job.
pub fn identity(source: &Source, wish: &Wish, engine: &str) -> Result<Manifest, Failure> {
    let mut manifest = Manifest { seed: wish.options.job.seed, ..Manifest::default() };
    manifest.versions.insert("holo".into(), env!("CARGO_PKG_VERSION").into());
    manifest.versions.insert("engine".into(), engine.into());
    let settings = &mut manifest.settings;
    settings.insert("scene_sha256".into(), source.sha256()?.to_string().into());
    if let Some(path) = sky::map(&wish.options.job.sky) {
        settings.insert("sky_sha256".into(), holo_io::hash_file(path)?.sha256.to_string().into());
    }
    settings.insert("options".into(), wish.setting());
    Ok(manifest)
}

fn manifest(
    source: &Source,
    wish: &Wish,
    wanted: &Wanted,
    prepared: &Prepared,
    rendered: &Rendered,
    request: &Request,
) -> Result<Manifest, Failure> {
    let mut manifest = identity(source, wish, prepared.renderer.engine_name())?;
    manifest.rig = Some(ManifestRig::from(prepared.rig.parameters()));
    let settings = &mut manifest.settings;
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
    settings.insert("bit-depth".into(), u32::from(wish.options.job.bit_depth).into());
    settings.insert("layers".into(), wanted.names(rendered).into());
    let all = request.ground_truth == GroundTruth::All;
    settings.insert("ground-truth".into(), if all { "all" } else { "central" }.into());
    Ok(manifest)
}
