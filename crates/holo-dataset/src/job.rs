//! One render from scene to folder: prepare, render, write.

use std::path::Path;
use std::time::Instant;

use holo_core::{GridSize, LightFieldShape, Rig};
use holo_io::{CameraPose, Manifest, ManifestValue, ParametersCfg};
use holo_render::{
    Denoise, GroundTruth, Integrator, Layer, Motion, Progress, Rendered, Renderer, Request, Reuse, Transport, Views,
};
use ndarray::{Array2, Axis};

use crate::checkpoint::{Checkpoints, Keeper};
use crate::diagnostics::{About, Diagnostics};
use crate::files::{Traced, exposure_ev, outputs, validate, write};
use crate::identity::check_replaceable;
use crate::images;
use crate::layers::Wanted;
use crate::options::{self, Options, denoise_name, integrator_name, texture_filter_name};
use crate::output_folder::{OutputFolder, Rollback};
use crate::parts::CancelOnly;
use crate::prepare::{Prepared, Purpose, prepare};
use crate::report::{RenderReport, Seconds};
use crate::source::SceneSource;
use crate::spec::{EngineSpec, Frames, LayerChoice, Output, RenderSpec, Shard, Sky};
use crate::warning::RenderWarning;
use crate::{Error, motion, shard, sky, warning};

/// One render: a scene, a specification and a ray tracing backend.
#[derive(Clone, Debug)]
pub struct RenderJob {
    /// The scene.
    pub source: SceneSource,
    /// What to render.
    pub spec: RenderSpec,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSpec,
    /// How often and where finished parts are kept, so that an interrupted job continues; `None`: not at all.
    pub checkpoints: Option<Checkpoints>,
    /// The specification as text, for the manifest.
    options: Options,
}

/// A render in memory.
#[derive(Debug)]
#[non_exhaustive]
pub struct Rendering {
    /// Color and layers.
    pub rendered: Rendered,
    /// [`Renderer::visibility`], if it was requested.
    pub visibility: Option<Array2<f32>>,
    /// [`Renderer::motion`] of the central view, or with ground truth of all views of each, if it was requested.
    pub motion: Vec<Motion>,
    /// The rig.
    pub rig: Rig,
    /// The exposure compensation with which integers are written, EV; `None` without color.
    pub exposure_ev: Option<f64>,
    /// Wall-clock times; nothing was written.
    pub seconds: Seconds,
    /// Warnings about the result.
    pub warnings: Vec<RenderWarning>,
}

impl RenderJob {
    /// Creates a job whose manifest contains the specification as [`RenderSpec::to_options`] writes it.
    #[must_use]
    pub fn new(source: SceneSource, spec: RenderSpec) -> Self {
        let options = spec.to_options();
        Self { source, spec, engine: EngineSpec::default(), checkpoints: Some(Checkpoints::default()), options }
    }

    /// Replaces the text of the specification in the manifest, for example by the options as they were typed. The path
    /// of an environment map is removed from it.
    #[must_use]
    pub fn with_options(self, options: Options) -> Self {
        let options = options::without_paths(options, &self.spec);
        Self { options, ..self }
    }

    /// Sets the ray tracing backend and the number of threads.
    #[must_use]
    pub fn with_engine(self, engine: EngineSpec) -> Self {
        Self { engine, ..self }
    }

    /// Sets how often and where finished parts are kept; `None`: not at all.
    #[must_use]
    pub fn with_checkpoints(self, checkpoints: Option<Checkpoints>) -> Self {
        Self { checkpoints, ..self }
    }

    /// Renders into the folder `out`: the complete light field, or one shard of it. If an earlier run of the same job was
    /// interrupted, this one continues from its [checkpoint](Checkpoints), to the same bytes.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the specification contradicts itself; [`Error::Scene`] and [`Error::Failed`] if the
    /// scene or the environment map cannot be read; [`Error::Render`] for errors and cancellation of the renderer;
    /// [`Error::Io`] if files cannot be written. Files and folders that the run created are removed then, except for a
    /// checkpoint.
    pub fn run(
        &self,
        out: &Path,
        shard: Option<Shard>,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<RenderReport, Error> {
        let start = Instant::now();
        validate(&self.spec)?;
        let flows = [LayerChoice::OpticalFlow, LayerChoice::SceneFlow];
        if let Some(flow) = flows.into_iter().find(|flow| shard.is_some() && self.spec.layers.contains(flow)) {
            let name = flow.name();
            return Err(Error::BadRequest(format!(
                "{name} is not rendered in parts of an image; remove it from --layers, or render without --shard"
            )));
        }
        if shard.is_some() && self.spec.rig.subset.is_some() {
            return Err(Error::BadRequest("--subset is not rendered in parts; render without --shard".into()));
        }
        if shard.is_some() && self.spec.outputs.contains(&Output::HciHighres) {
            return Err(Error::BadRequest(
                "hci-highres is not rendered in parts; remove it from --write, or render without --shard".into(),
            ));
        }
        let folder = OutputFolder::create(out, rollback)?;
        let prepared = self.prepare(diagnostics)?;
        let rendering = Instant::now();
        let identity = self.identity(prepared.renderer.engine_name())?;
        let request = self.request(&prepared, shard)?;
        let keeper = self
            .checkpoints
            .as_ref()
            // Tiles are kept of whole grids.
            .filter(|_| self.spec.rig.subset.is_none())
            .map(|checkpoints| Keeper::open(checkpoints, out, (&prepared, &request), &identity, diagnostics));
        let traced = self.trace(&prepared, &request, identity, keeper.as_ref(), progress, diagnostics);
        let written = traced.and_then(|traced| self.write(traced, &prepared.renderer, shard, folder, rendering));
        if let Some(keeper) = keeper {
            keeper.report(written.is_err(), diagnostics);
            if written.is_ok() {
                keeper.remove();
            }
        }
        let mut report = written?;
        report.seconds.load = prepared.load_seconds;
        report.seconds.build = prepared.build_seconds;
        report.seconds.total = start.elapsed().as_secs_f64();
        Ok(report)
    }

    /// Renders the complete light field into memory: what [`run`](Self::run) writes, before it is encoded. Needs no
    /// folder and keeps no checkpoint.
    ///
    /// # Errors
    /// As [`run`](Self::run), without those of files that are written.
    pub fn render(&self, progress: &dyn Progress, diagnostics: &dyn Diagnostics) -> Result<Rendering, Error> {
        validate(&self.spec)?;
        let prepared = self.prepare(diagnostics)?;
        let start = Instant::now();
        let identity = self.identity(prepared.renderer.engine_name())?;
        let request = self.request(&prepared, None)?;
        let traced = self.trace(&prepared, &request, identity, None, progress, diagnostics)?;
        let exposure_ev = prepared.renderer.install(|| exposure_ev(&self.spec, &traced.rendered));
        let seconds = Seconds {
            load: prepared.load_seconds,
            build: prepared.build_seconds,
            render: start.elapsed().as_secs_f64(),
            ..Seconds::default()
        };
        let Traced { rendered, rig, visibility, motion, warnings, .. } = traced;
        Ok(Rendering { rendered, visibility, motion, rig, exposure_ev, seconds, warnings })
    }

    /// Writes the files of what was rendered since `rendering`.
    fn write(
        &self,
        traced: Traced,
        renderer: &Renderer,
        shard: Option<Shard>,
        folder: OutputFolder,
        rendering: Instant,
    ) -> Result<RenderReport, Error> {
        let (rays, samples, integrator) = (traced.rendered.rays, traced.rendered.samples, traced.rendered.integrator);
        let (why, rig) = (traced.rendered.why.clone(), traced.rig);
        let warnings = traced.warnings.clone();
        let exposure_ev = match shard {
            // The exposure depends on the complete image.
            Some(_) => None,
            None => renderer.install(|| exposure_ev(&self.spec, &traced.rendered)),
        };
        let (render, writing) = (rendering.elapsed().as_secs_f64(), Instant::now());
        let finished = renderer.install(|| match shard {
            Some(shard) => shard::write(traced, shard, folder),
            None => write(&self.spec, traced, exposure_ev, folder),
        })?;
        let shape = rig.shape();
        Ok(RenderReport {
            seconds: Seconds { render, write: writing.elapsed().as_secs_f64(), ..Seconds::default() },
            rays,
            samples: match integrator {
                Integrator::Depth => shape.views().count() as u64 * shape.lenses().count() as u64,
                _ => samples,
            },
            backend: renderer.engine_name().to_owned(),
            threads: renderer.threads(),
            integrator,
            why,
            rig,
            disparity_px: finished.disparity_px,
            statistics: finished.statistics,
            files: finished.files,
            warnings,
        })
    }

    /// Checks that the folder `out` holds no other image: none of another scene, seed, options or shard. An image that
    /// another version or backend made of the same may be replaced.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if there is another image; [`Error::Scene`] and [`Error::Failed`] if the scene or the
    /// environment map cannot be read; [`Error::Io`] if the manifest of the folder is damaged.
    pub fn check_replaceable(&self, out: &Path, shard: Option<Shard>) -> Result<(), Error> {
        check_replaceable(out, || self.identity(""), |older| shard::other(older, shard))
    }

    /// Loads the scene, builds the acceleration structure and determines the focus: the first steps of
    /// [`run`](Self::run).
    ///
    /// # Errors
    /// As [`run`](Self::run), except for rendering and writing; [`Error::BadRequest`] also if the light field does not
    /// fit into memory, [`Error::Core`] if the rig is invalid.
    pub fn prepare(&self, diagnostics: &dyn Diagnostics) -> Result<Prepared, Error> {
        let wanted = Wanted::new(&self.spec);
        let source = (&self.source, &self.spec.scene);
        prepare(source, &self.spec.rig, &self.engine, purpose(&self.spec, &wanted), diagnostics)
    }

    /// Returns what identifies the job in a manifest: digests of scene and sky, options, versions. Two manifests with
    /// the same identity are of the same job. `backend` is
    /// [`Renderer::engine_name`](holo_render::Renderer::engine_name).
    ///
    /// # Errors
    /// [`Error::Io`] if the scene or the environment map cannot be read.
    pub fn identity(&self, backend: &str) -> Result<Manifest, Error> {
        source_identity(&self.source, &self.spec, &self.options, backend)
    }

    /// The request for the complete light field or a shard.
    fn request(&self, prepared: &Prepared, shard: Option<Shard>) -> Result<Request, Error> {
        let mut request = request(&self.spec, &Wanted::new(&self.spec), prepared);
        if let Some(subset) = &self.spec.rig.subset {
            request.views = Views::List(subset.views(request.rig.shape().views()));
            // Groups of views would share light with those that are missing.
            request.transport.reuse = Reuse::Off;
        }
        if let Some(shard) = shard {
            request.lens_rows = Some(prepared.renderer.shard_lens_rows(&request, shard.part - 1, shard.of)?);
        }
        Ok(request)
    }

    /// Renders the complete light field or a shard.
    fn trace(
        &self,
        prepared: &Prepared,
        request: &Request,
        identity: Manifest,
        keeper: Option<&Keeper>,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Traced, Error> {
        let spec = &self.spec;
        let wanted = Wanted::new(spec);
        let mut rendered = match keeper {
            Some(keeper) => prepared.renderer.render_with_checkpoint(request, progress, keeper)?,
            None => prepared.renderer.render(request, progress)?,
        };
        // The layers of all views may be fewer than those of the central view.
        let missing = wanted.central.without(rendered.central.set());
        if !missing.is_empty() {
            let mut more = Request::new(prepared.rig).integrator(Integrator::Depth).layers(missing);
            more.lens_rows.clone_from(&request.lens_rows);
            rendered.central.extend(prepared.renderer.render(&more, &())?.central);
        }
        // Before files are written.
        outputs(spec, rendered.color.is_some())?;
        if rendered.integrator == Integrator::Depth && request.transport.integrator == Integrator::Auto {
            let note = "note: the scene has no light sources, so there is no color, only ground truth; try --sky auto";
            diagnostics.report(About::Scene, note);
        }
        // A part may see nothing where the whole image does.
        let is_whole = request.lens_rows.is_none();
        let warnings = if is_whole { warning::of(prepared, &rendered.central)? } else { Vec::new() };
        warnings.iter().for_each(|warning| diagnostics.report(About::Scene, &format!("warning: {warning}")));
        let manifest = self.manifest(identity, &wanted, prepared, &rendered, request);
        let parameters = self.parameters(prepared);
        let is_highres = spec.outputs.contains(&Output::HciHighres);
        let highres_depth_m = is_highres.then(|| highres_depth_m(prepared)).transpose()?;
        let visibility =
            if wanted.visibility { Some(prepared.renderer.visibility(request, &CancelOnly(progress))?) } else { None };
        let flows = wanted.flow.contains(&true);
        let motion =
            if flows { motion::trace((&self.source, spec), prepared, &CancelOnly(progress))? } else { Vec::new() };
        let rig = prepared.rig;
        Ok(Traced { rendered, wanted, rig, manifest, parameters, highres_depth_m, visibility, motion, warnings })
    }

    fn parameters(&self, prepared: &Prepared) -> ParametersCfg {
        let mut parameters = ParametersCfg::from_rig(&prepared.rig);
        let pose = prepared.framed.pose;
        let [right, up, back] = pose.columns;
        parameters.center_cam = Some(CameraPose::from_gltf(pose.translation, right, up, back));
        parameters.scene = self.source.name();
        parameters.cycles_seed = i64::try_from(self.spec.seed).ok();
        // Reproducible builds set this variable; without it files contain no date.
        if let Some(seconds) = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse::<i64>().ok()) {
            parameters.date = holo_io::date_from_epoch(seconds);
        }
        parameters
    }

    fn manifest(
        &self,
        mut manifest: Manifest,
        wanted: &Wanted,
        prepared: &Prepared,
        rendered: &Rendered,
        request: &Request,
    ) -> Manifest {
        manifest.rig = Some(prepared.rig);
        let settings = &mut manifest.settings;
        settings.insert("camera".into(), prepared.framed.camera.clone().into());
        settings.insert("integrator".into(), integrator_name(rendered.integrator).into());
        settings.insert("spp".into(), request.transport.samples.into());
        if let Some(target) = request.transport.target_error {
            settings.insert("target-error".into(), ManifestValue::Float(target));
        }
        if rendered.integrator == Integrator::Path {
            settings.insert("max-bounces".into(), request.transport.max_bounces.into());
            settings.insert("roulette".into(), if request.transport.roulette { "on" } else { "off" }.into());
            settings.insert("indirect".into(), if request.transport.indirect { "on" } else { "off" }.into());
        }
        if request.transport.indirect_limit.is_finite() {
            settings.insert("indirect-limit".into(), ManifestValue::Float(f64::from(request.transport.indirect_limit)));
        }
        if request.transport.transparent_shadows {
            settings.insert("transparent-shadows".into(), "on".into());
        }
        if !request.transport.multiple_scattering {
            settings.insert("multiple-scattering".into(), "off".into());
        }
        if request.transport.reuse == Reuse::Off && rendered.color.is_some() {
            settings.insert("reuse".into(), "off".into());
        }
        if request.denoise == Denoise::Off && rendered.color.is_some() {
            settings.insert("texture-filter".into(), texture_filter_name(request.transport.texture_filter).into());
        }
        if request.denoise != Denoise::Off && rendered.color.is_some() {
            settings.insert("denoise".into(), denoise_name(request.denoise).into());
            settings.insert("denoise-method".into(), Denoise::METHOD.into());
        }
        if request.transport.cull {
            settings.insert("cull".into(), "on".into());
        }
        let sky = request.transport.sky.map(|c| ManifestValue::Float(f64::from(c)));
        settings.insert("sky".into(), ManifestValue::List(sky.to_vec()));
        if prepared.has_automatic_sky {
            settings.insert("automatic-sky".into(), "on".into());
        }
        settings.insert("bit-depth".into(), u32::from(self.spec.bit_depth).into());
        settings.insert("layers".into(), wanted.names(rendered).into());
        let all = request.ground_truth == GroundTruth::All;
        settings.insert("ground-truth".into(), if all { "all" } else { "central" }.into());
        manifest
    }
}

/// What identifies a job in a manifest: digests of scene and sky, options, versions.
pub(crate) fn source_identity(
    source: &SceneSource,
    spec: &RenderSpec,
    options: &Options,
    backend: &str,
) -> Result<Manifest, Error> {
    let mut manifest = Manifest { seed: spec.seed, ..Manifest::default() };
    manifest.versions.insert("holo".into(), env!("CARGO_PKG_VERSION").into());
    manifest.versions.insert("engine".into(), backend.into());
    let settings = &mut manifest.settings;
    settings.insert("scene_sha256".into(), source.sha256()?.to_string().into());
    if let Some(frame) = spec.scene.frames.and_then(Frames::single) {
        settings.insert("frame".into(), frame.into());
        settings.insert("time_s".into(), ManifestValue::Float(spec.scene.seconds_of(frame)));
    }
    if let Some(path) = spec.sky_map() {
        settings.insert("sky_sha256".into(), holo_io::hash_file(path)?.sha256.to_string().into());
    }
    let options = options.iter().map(|(name, value)| (name.clone(), value.as_str().into()));
    settings.insert("options".into(), ManifestValue::Table(options.collect()));
    Ok(manifest)
}

/// The settings of light transport.
pub(crate) fn transport(spec: &RenderSpec, integrator: Integrator) -> Transport {
    let samples = spec.samples.unwrap_or(match (integrator, spec.target_error) {
        (Integrator::Depth, _) => 1,
        (_, Some(_)) => 1024,
        (_, None) => 16,
    });
    let mut transport = Transport::default();
    (transport.integrator, transport.samples, transport.seed) = (integrator, samples, spec.seed);
    transport.sky = sky::constant(&spec.sky);
    (transport.max_bounces, transport.roulette) = (spec.max_bounces, spec.roulette);
    transport.target_error = spec.target_error;
    (transport.indirect, transport.indirect_limit) = (spec.indirect, spec.indirect_limit);
    transport.transparent_shadows = spec.transparent_shadows;
    transport.multiple_scattering = spec.multiple_scattering;
    (transport.cull, transport.reuse, transport.texture_filter) = (spec.cull, spec.reuse, spec.texture_filter);
    transport
}

/// The memory that the render needs.
fn purpose<'a>(spec: &'a RenderSpec, wanted: &Wanted) -> Purpose<'a> {
    let color = if spec.integrator == Integrator::Depth { 0 } else { 3 };
    let is_denoised = spec.denoise == Denoise::Views;
    let error = usize::from(wanted.error || is_denoised && spec.target_error.is_some());
    let guides = if color > 0 && (is_denoised || wanted.error) { 2 + error } else { 0 };
    Purpose {
        sky: Some(&spec.sky).filter(|sky| **sky != Sky::Automatic || color > 0 && !needs_no_color(spec, wanted)),
        sample_bytes: (color + guides + wanted.all.channels()) * size_of::<f32>(),
        lens_bytes: wanted.central.channels() * size_of::<f32>(),
    }
}

/// Depth of the central view in [`images::HIGHRES_SCALE`] times the resolution, one ray a value.
fn highres_depth_m(prepared: &Prepared) -> Result<Array2<f32>, Error> {
    let (views, lenses) = (prepared.rig.shape().views(), prepared.rig.shape().lenses());
    let finer = |count: usize| count.saturating_mul(images::HIGHRES_SCALE);
    let shape = LightFieldShape::new(views, GridSize::new(finer(lenses.rows), finer(lenses.columns)))?;
    let rig = prepared.rig.to_builder().shape(shape).build()?;
    let mut central = prepared.renderer.central_layers(&rig, [Layer::Depth].into())?;
    central
        .take(Layer::Depth)
        .map(|depth_m| depth_m.index_axis_move(Axis(2), 0))
        .ok_or_else(|| Error::Failed("the renderer returned no depth of the central view".into()))
}

/// The integrator of a request.
pub(crate) fn request_integrator(spec: &RenderSpec, wanted: &Wanted) -> Integrator {
    match spec.integrator {
        // No requested output has color: no light needs to be traced.
        Integrator::Auto if needs_no_color(spec, wanted) => Integrator::Depth,
        chosen => chosen,
    }
}

pub(crate) fn request(spec: &RenderSpec, wanted: &Wanted, prepared: &Prepared) -> Request {
    Request::new(prepared.rig)
        .filter_width_px(f64::from(spec.rig.lens_shifts.unwrap_or(1)))
        .transport(transport(spec, request_integrator(spec, wanted)))
        .denoise(spec.denoise)
        .estimate_error(wanted.error)
        .layers(match spec.ground_truth {
            GroundTruth::Central => wanted.central,
            GroundTruth::All => wanted.all,
        })
        .ground_truth(spec.ground_truth)
}

fn needs_no_color(spec: &RenderSpec, wanted: &Wanted) -> bool {
    let has_color =
        spec.outputs.contains(&Output::Exr) || images::needing_color(&spec.outputs, spec.integrator).is_some();
    !wanted.color && !wanted.error && !spec.outputs.is_empty() && !has_color
}
