//! The raw image of a plenoptic camera, from scene to folder.

use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use holo_core::GridSize;
use holo_core::plenoptic::PlenopticMode;
use holo_io::{CameraFile, Manifest, ManifestValue, Sha256};
use holo_render::{GroundTruth, Integrator, Layer, LayerSet, Progress, RawRendered, RawRequest, RayCounts, Renderer};
use ndarray::{Array2, Axis};
use serde_json::{Value, json};

use crate::diagnostics::{About, Diagnostics};
use crate::exports::Tool;
use crate::identity::check_replaceable;
use crate::job::{source_identity, transport};
use crate::options::{self, Options, integrator_name};
use crate::output_folder::{OutputFolder, Rollback};
use crate::prepare::{PreparedScene, prepare_scene};
use crate::raw_files::{RawTraced, TOOLS, exposure_ev, lit_white_image, raw_layer, wanted_layers};
use crate::report::Seconds;
use crate::source::SceneSource;
use crate::spec::{EngineSpec, Exposure, LayerChoice, Output, RawLayer, RenderSpec, Shard};
use crate::{Error, shard, text};

/// One raw image: a scene, a plenoptic camera, and how it is rendered.
#[derive(Clone, Debug)]
pub struct RawJob {
    /// The scene.
    pub source: SceneSource,
    /// The camera. Its pose is that of the scene's camera; what that sees beside it does not matter.
    pub camera: CameraFile,
    /// What to render. Of [`RenderSpec::rig`] the name of the scene's camera alone counts.
    pub spec: RenderSpec,
    /// The programs that it is also written for.
    pub tools: Vec<Tool>,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSpec,
    /// The specification as text, for the manifest.
    options: Options,
}

/// Statistics of a finished raw image.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RawReport {
    /// Wall-clock times.
    pub seconds: Seconds,
    /// Number of rays by kind.
    pub rays: RayCounts,
    /// The ray tracing backend and its version.
    pub backend: String,
    /// Number of threads.
    pub threads: usize,
    /// The integrator that rendered.
    pub integrator: Integrator,
    /// Why it was chosen.
    pub why: String,
    /// Name of the camera, size of its sensor, and number of its micro-images.
    pub camera: (String, GridSize, usize),
    /// The rows of pixels that were rendered.
    pub rows: Range<usize>,
    /// The share of their pixels that light reaches.
    pub lit_share: f64,
    /// Names of the files, relative to the folder.
    pub files: Vec<String>,
}

/// Layers that follow from the camera, axes (row, column).
pub type RawLayers = Vec<(RawLayer, Array2<f32>)>;

impl RawJob {
    /// Creates a job whose manifest contains the specification as [`RenderSpec::to_options`] writes it.
    #[must_use]
    pub fn new(source: SceneSource, camera: CameraFile, spec: RenderSpec) -> Self {
        let options = spec.to_options();
        Self { source, camera, spec, tools: Vec::new(), engine: EngineSpec::default(), options }
    }

    /// Replaces the text of the specification in the manifest, for example by the options as they were typed. The path
    /// of an environment map is removed from it.
    #[must_use]
    pub fn with_options(self, options: Options) -> Self {
        let options = options::without_paths(options, &self.spec);
        Self { options, ..self }
    }

    /// Checks that the folder `out` holds no other image, as [`RenderJob::check_replaceable`](crate::RenderJob).
    ///
    /// # Errors
    /// As there.
    pub fn check_replaceable(&self, out: &Path, shard: Option<Shard>) -> Result<(), Error> {
        check_replaceable(out, || self.identity(""), |older| shard::other(older, shard))
    }

    /// Renders into the folder `out`: the complete image, or one shard of it.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the specification contradicts itself, or no light reaches the sensor, or the image has
    /// fewer rows than shards; [`Error::Scene`] and
    /// [`Error::Failed`] if the scene or the environment map cannot be read; [`Error::Render`] for errors and
    /// cancellation of the renderer; [`Error::Io`] if files cannot be written. Files and folders that the run created are
    /// removed then.
    pub fn run(
        &self,
        out: &Path,
        shard: Option<Shard>,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<RawReport, Error> {
        let start = Instant::now();
        self.validate()?;
        let size = self.camera.camera.sensor().size;
        let rows = shard.map_or(Ok(0..size.rows), |shard| rows_of(shard, size.rows))?;
        warnings(&self.camera).iter().for_each(|line| diagnostics.report(About::Setup, &format!("warning: {line}")));
        let [width, height] = self.camera.camera.angles_of_view_rad().map(f64::to_degrees);
        let note = format!(
            "note: the angle of view of the scene's camera is not used; this one sees {width:.1} x {height:.1} degrees"
        );
        diagnostics.report(About::Setup, &note);
        let white = lit_white_image(&self.camera)?;
        let folder = OutputFolder::create(out, rollback)?;
        let sky = Some(&self.spec.sky);
        let prepared = prepare_scene((&self.source, &self.spec.scene), &self.spec.rig, &self.engine, sky, diagnostics)?;
        let rendering = Instant::now();
        let rendered = prepared.renderer.render_raw(&self.request(rows.clone()), progress)?;
        if rendered.integrator == Integrator::Depth && self.spec.integrator == Integrator::Auto {
            let note = "note: the scene has no light sources, so there is no color, only ground truth; try --sky auto";
            diagnostics.report(About::Scene, note);
        }
        let (render, writing) = (rendering.elapsed().as_secs_f64(), Instant::now());
        folder.unseal()?;
        let (rays, integrator, why) = (rendered.rays, rendered.integrator, rendered.why.clone());
        let lit = white.slice_axis(Axis(0), rows.clone().into()).iter().filter(|&&light| light > 0.0).count();
        let manifest = self.manifest(&prepared, &rendered)?;
        let (camera, spec, tools) = (self.camera.clone(), self.spec.clone(), self.tools.clone());
        let traced = RawTraced { rendered, white, camera, spec, tools, manifest };
        let files = prepared.renderer.install(|| match shard {
            Some(shard) => shard::write_raw(traced, shard, folder),
            None => traced.write(folder),
        })?;
        Ok(RawReport {
            seconds: Seconds {
                load: prepared.load_seconds,
                build: prepared.build_seconds,
                render,
                write: writing.elapsed().as_secs_f64(),
                total: start.elapsed().as_secs_f64(),
            },
            rays,
            backend: prepared.renderer.engine_name().to_owned(),
            threads: Renderer::threads(&prepared.renderer),
            integrator,
            why,
            camera: (self.camera.name.clone(), size, self.camera.camera.lens_count()),
            lit_share: lit as f64 / (rows.len() * size.columns) as f64,
            rows,
            files,
        })
    }

    /// Renders the complete raw image into memory, without files; returns it with the requested layers that follow from the
    /// camera, axes (row, column).
    ///
    /// # Errors
    /// As [`run`](Self::run), without those of files that are written.
    pub fn render(
        &self,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
    ) -> Result<(RawRendered, RawLayers), Error> {
        self.validate()?;
        let white = lit_white_image(&self.camera)?;
        warnings(&self.camera).iter().for_each(|line| diagnostics.report(About::Setup, &format!("warning: {line}")));
        let sky = Some(&self.spec.sky);
        let prepared = prepare_scene((&self.source, &self.spec.scene), &self.spec.rig, &self.engine, sky, diagnostics)?;
        let rows = 0..self.camera.camera.sensor().size.rows;
        let rendered = prepared.renderer.render_raw(&self.request(rows), progress)?;
        let (_, others) = wanted_layers(&self.spec);
        let layer = |layer: RawLayer| Some((layer, raw_layer(&self.camera.camera, layer, &rendered, &white)?));
        let layers = prepared.renderer.install(|| others.into_iter().filter_map(layer).collect());
        Ok((rendered, layers))
    }

    /// The exposure of the image, if integers of it are wanted, else as specified; and the ray tracing backend.
    pub(crate) fn automatic_exposure(
        &self,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
    ) -> Result<(String, Exposure), Error> {
        self.validate()?;
        drop(lit_white_image(&self.camera)?);
        let sky = Some(&self.spec.sky);
        let prepared = prepare_scene((&self.source, &self.spec.scene), &self.spec.rig, &self.engine, sky, diagnostics)?;
        let engine = prepared.renderer.engine_name().to_owned();
        let outputs = &self.spec.outputs;
        let has_integers = outputs.is_empty() || outputs.contains(&Output::RawPng) || !self.tools.is_empty();
        let has_color = self.spec.integrator != Integrator::Depth;
        if self.spec.exposure != Exposure::Automatic || !has_integers || !has_color {
            return Ok((engine, self.spec.exposure));
        }
        let rows = 0..self.camera.camera.sensor().size.rows;
        let request = self.request(rows).layers(LayerSet::EMPTY).statistics(false);
        let rendered = prepared.renderer.render_raw(&request, progress)?;
        let Some(color) = &rendered.color else { return Ok((engine, Exposure::Automatic)) };
        let ev = prepared.renderer.install(|| exposure_ev(color, Exposure::Automatic))?;
        Ok((engine, Exposure::Ev(ev)))
    }

    fn validate(&self) -> Result<(), Error> {
        let bad = |what: String| Err(Error::BadRequest(what));
        if let Some(output) = self.spec.outputs.iter().find(|output| !Output::RAW.contains(output)) {
            let name = output.name();
            return bad(format!(
                "--write {name} is of rendered views; a plenoptic camera writes raw, raw-png, white and centers, and \
                 `holo decode` makes views of them"
            ));
        }
        self.tools.iter().try_for_each(|tool| tool.check(&self.camera.camera))?;
        if let (Some(tool), Integrator::Depth) = (self.tools.first(), self.spec.integrator) {
            return bad(format!("--integrator depth renders no color; remove --for {}", tool.name()));
        }
        if self.spec.denoise != holo_render::Denoise::Off {
            return bad("--denoise views needs views; render the raw image of a plenoptic camera without it".into());
        }
        if self.spec.ground_truth == GroundTruth::All {
            return bad(
                "--ground-truth all is of rendered views; the layers of a raw image are those of its pixels, and `holo \
                 decode --scene` adds those of the central view"
                    .into(),
            );
        }
        let of_views = [LayerChoice::Error, LayerChoice::Visibility, LayerChoice::OpticalFlow, LayerChoice::SceneFlow];
        if let Some(layer) = of_views.into_iter().find(|layer| self.spec.layers.contains(layer)) {
            return bad(format!("--layers {} is of rendered views; remove it", layer.name()));
        }
        let needs_color = [Output::Raw, Output::RawPng].iter().find(|output| self.spec.outputs.contains(output));
        if let (Some(output), Integrator::Depth) = (needs_color, self.spec.integrator) {
            let name = output.name();
            return bad(format!("--integrator depth renders no color; remove {name} from --write"));
        }
        Ok(())
    }

    fn request(&self, rows: Range<usize>) -> RawRequest {
        let (traced, others) = wanted_layers(&self.spec);
        let needs_depth = others.iter().any(|layer| layer.needs_depth());
        let layers = if needs_depth { traced.union(LayerSet::of(&[Layer::Depth])) } else { traced };
        RawRequest::new(self.camera.camera.clone())
            .transport(transport(&self.spec, self.spec.integrator))
            .layers(layers)
            .statistics(others.iter().any(|layer| layer.needs_samples()))
            .rows(Some(rows))
    }

    /// What identifies the job in a manifest, as [`RenderJob::identity`](crate::RenderJob::identity).
    pub(crate) fn identity(&self, backend: &str) -> Result<Manifest, Error> {
        let mut manifest = source_identity(&self.source, &self.spec, &self.options, backend)?;
        let camera = Sha256::of(self.camera.to_toml().as_bytes());
        manifest.settings.insert("camera_sha256".into(), camera.to_string().into());
        if !self.tools.is_empty() {
            let names = self.tools.iter().map(|tool| tool.name().into()).collect();
            manifest.settings.insert(TOOLS.into(), ManifestValue::List(names));
        }
        Ok(manifest)
    }

    fn manifest(&self, prepared: &PreparedScene, rendered: &RawRendered) -> Result<Manifest, Error> {
        let mut manifest = self.identity(prepared.renderer.engine_name())?;
        let transport = transport(&self.spec, rendered.integrator);
        let settings = &mut manifest.settings;
        settings.insert("camera".into(), prepared.framed.camera.clone().into());
        settings.insert("camera-file".into(), self.camera.name.clone().into());
        if self.camera.is_approximate {
            settings.insert("approximate".into(), "some numbers of the camera are not published, and guesses".into());
        }
        settings.insert("integrator".into(), integrator_name(rendered.integrator).into());
        settings.insert("spp".into(), transport.samples.into());
        let sky = transport.sky.map(|c| ManifestValue::Float(f64::from(c)));
        settings.insert("sky".into(), ManifestValue::List(sky.to_vec()));
        if prepared.has_automatic_sky {
            settings.insert("automatic-sky".into(), "on".into());
        }
        Ok(manifest)
    }
}

/// The rows of pixels of a shard.
fn rows_of(shard: Shard, rows: usize) -> Result<Range<usize>, Error> {
    let Shard { part, of } = shard;
    if part == 0 || part > of || of > rows {
        let what = format!("shard {part}/{of}: an image of {rows} rows has 1 to {rows} shards, counted from 1");
        return Err(Error::BadRequest(what));
    }
    Ok((part - 1) * rows / of..part * rows / of)
}

/// What is probably not wanted of a camera, with numbers.
#[must_use]
pub fn warnings(file: &CameraFile) -> Vec<String> {
    let camera = &file.camera;
    let mut lines = Vec::new();
    if file.is_approximate {
        lines.push(format!("some numbers of the camera '{}' are not published, and guesses", file.name));
    }
    let pitch_px = camera.array().pitch_m / camera.sensor().pixel_m;
    if pitch_px < 4.0 {
        lines.push(format!("a microlens covers only {} pixels", text::number(pitch_px)));
    }
    let image_pitch_px = camera.micro_image_pitch_px();
    let half_px = camera.micro_image_radii_m(0)[1] / camera.sensor().pixel_m;
    if camera.mode(0) == PlenopticMode::Unfocused {
        let filled = 2.0 * half_px / image_pitch_px;
        // f-numbers match where micro-images touch.
        let matching = camera.main_lens().f_number * filled;
        if filled > 1.01 {
            lines.push(format!(
                "micro-images are {} px wide and {} px apart: they overlap; f/{} would match the microlenses",
                text::number(2.0 * half_px),
                text::number(image_pitch_px),
                text::number(matching)
            ));
        } else if filled < 0.8 {
            lines.push(format!(
                "micro-images are {} px wide and {} px apart: much of the sensor stays dark; f/{} would match the \
                 microlenses",
                text::number(2.0 * half_px),
                text::number(image_pitch_px),
                text::number(matching)
            ));
        }
    }
    lines
}

impl RawReport {
    /// Rays of all kinds a second of rendering, in millions.
    #[must_use]
    pub fn mrays_per_second(&self) -> f64 {
        self.rays.total() as f64 / self.seconds.render.max(1e-9) / 1e6
    }

    /// The report as a JSON object, the one that `holo render --camera-file --json` prints without the memory of the
    /// process.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let (s, rays, (name, size, lenses)) = (&self.seconds, self.rays, &self.camera);
        json!({
            "seconds": {"load": s.load, "build": s.build, "render": s.render, "write": s.write, "total": s.total},
            "rays": {"primary": rays.primary, "shadow": rays.shadow, "other": rays.secondary},
            "backend": self.backend,
            "threads": self.threads,
            "integrator": {"name": integrator_name(self.integrator), "why": self.why},
            "camera": {"name": name, "size": {"columns": size.columns, "rows": size.rows}, "lenses": lenses},
            "lit_share": self.lit_share,
            "files": self.files,
        })
    }
}

/// Two lines: what was rendered how fast, and the camera.
impl fmt::Display for RawReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, size, lenses) = &self.camera;
        writeln!(
            f,
            "rendered {} x {} px in {:.2} s ({:.1} Mrays/s, {}, {} threads, {}: {})",
            size.columns,
            self.rows.len(),
            self.seconds.render,
            self.mrays_per_second(),
            self.backend,
            self.threads,
            integrator_name(self.integrator),
            self.why
        )?;
        write!(f, "camera {name}: {lenses} micro-images, {:.0} % of the pixels lit", 100.0 * self.lit_share)
    }
}
