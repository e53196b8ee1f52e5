//! The raw image of a plenoptic camera, from scene to folder.

use std::fmt;
use std::path::Path;
use std::time::Instant;

use holo_core::plenoptic::{MicrolensIndex, PlenopticCamera, PlenopticMode};
use holo_core::{GridSize, LightField, LightFieldShape};
use holo_io::interop::micro_images;
use holo_io::{CameraFile, ColorEncoding, Compression, ExrChannel, Manifest, ManifestValue, Sha256};
use holo_render::{
    GroundTruth, Integrator, Layer, LayerSet, Progress, RawRendered, RawRequest, RayCounts, Renderer, exposure,
};
use ndarray::{Array2, Array3, Axis, Zip};
use serde_json::{Value, json};

use crate::diagnostics::{About, Diagnostics};
use crate::exports::Tool;
use crate::identity::check_replaceable;
use crate::job::{source_identity, transport};
use crate::options::{self, Options, integrator_name};
use crate::output_folder::{OutputFolder, Rollback};
use crate::prepare::{PreparedScene, prepare_scene};
use crate::report::Seconds;
use crate::source::SceneSource;
use crate::spec::{EngineSpec, Exposure, LayerChoice, Output, RawLayer, RenderSpec};
use crate::{Error, text};

/// The files of a raw image.
pub(crate) const CAMERA_TOML: &str = "camera.toml";
const RAW_EXR: &str = "raw.exr";
const RAW_PNG: &str = "raw_linear.png";
pub(crate) const CENTERS_CSV: &str = "centers.csv";

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
    /// The share of the pixels that light reaches.
    pub lit_share: f64,
    /// Names of the files, relative to the folder.
    pub files: Vec<String>,
}

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
    pub fn check_replaceable(&self, out: &Path) -> Result<(), Error> {
        check_replaceable(out, || self.identity(""), |_| None)
    }

    /// Renders into the folder `out`.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the specification contradicts itself, or no light reaches the sensor; [`Error::Scene`] and
    /// [`Error::Failed`] if the scene or the environment map cannot be read; [`Error::Render`] for errors and
    /// cancellation of the renderer; [`Error::Io`] if files cannot be written. Files and folders that the run created are
    /// removed then.
    pub fn run(
        &self,
        out: &Path,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<RawReport, Error> {
        let start = Instant::now();
        self.validate()?;
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
        let rendered = prepared.renderer.render_raw(&self.request(), progress)?;
        if rendered.integrator == Integrator::Depth && self.spec.integrator == Integrator::Auto {
            let note = "note: the scene has no light sources, so there is no color, only ground truth; try --sky auto";
            diagnostics.report(About::Scene, note);
        }
        let (render, writing) = (rendering.elapsed().as_secs_f64(), Instant::now());
        folder.unseal()?;
        let (rays, integrator, why) = (rendered.rays, rendered.integrator, rendered.why.clone());
        let lit = white.iter().filter(|&&light| light > 0.0).count();
        let manifest = self.manifest(&prepared, &rendered)?;
        let files = prepared.renderer.install(|| self.write(folder, rendered, white, manifest))?;
        let size = self.camera.camera.sensor().size;
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
            lit_share: lit as f64 / size.count() as f64,
            files,
        })
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
        if self.spec.layers.contains(&LayerChoice::Error) {
            return bad("--layers error is of rendered views; remove it".into());
        }
        let needs_color = [Output::Raw, Output::RawPng].iter().find(|output| self.spec.outputs.contains(output));
        if let (Some(output), Integrator::Depth) = (needs_color, self.spec.integrator) {
            let name = output.name();
            return bad(format!("--integrator depth renders no color; remove {name} from --write"));
        }
        Ok(())
    }

    /// The layers of the renderer that are wanted, and those that follow from the camera.
    fn layers(&self) -> (LayerSet, Vec<RawLayer>) {
        let mut traced = LayerSet::EMPTY;
        let mut others = Vec::new();
        for layer in &self.spec.layers {
            match layer {
                LayerChoice::One(layer) => traced = traced.union(LayerSet::of(&[*layer])),
                LayerChoice::All => {
                    traced = LayerSet::ALL;
                    others.extend(RawLayer::ALL);
                }
                LayerChoice::Raw(layer) => others.push(*layer),
                LayerChoice::Color | LayerChoice::Error => {}
            }
        }
        (traced, others)
    }

    fn request(&self) -> RawRequest {
        let (traced, others) = self.layers();
        let needs_depth = others.iter().any(|layer| layer.needs_depth());
        let layers = if needs_depth { traced.union(LayerSet::of(&[Layer::Depth])) } else { traced };
        RawRequest::new(self.camera.camera.clone())
            .transport(transport(&self.spec, self.spec.integrator))
            .layers(layers)
            .statistics(others.iter().any(|layer| layer.needs_samples()))
    }

    fn identity(&self, backend: &str) -> Result<Manifest, Error> {
        let mut manifest = source_identity(&self.source, &self.spec, &self.options, backend)?;
        let camera = Sha256::of(self.camera.to_toml().as_bytes());
        manifest.settings.insert("camera_sha256".into(), camera.to_string().into());
        if !self.tools.is_empty() {
            let names = self.tools.iter().map(|tool| tool.name().into()).collect();
            manifest.settings.insert("for".into(), ManifestValue::List(names));
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

    /// Writes all files and last the manifest.
    fn write(
        &self,
        mut folder: OutputFolder,
        mut rendered: RawRendered,
        white: Array2<f32>,
        mut manifest: Manifest,
    ) -> Result<Vec<String>, Error> {
        let camera = &self.camera.camera;
        let wants = |output: Output| self.spec.outputs.is_empty() || self.spec.outputs.contains(&output);
        let text = self.camera.to_toml();
        folder.add(CAMERA_TOML, holo_io::write_file(folder.file(CAMERA_TOML), text.as_bytes())?);
        if wants(Output::Centers) {
            folder.add(CENTERS_CSV, holo_io::write_file(folder.file(CENTERS_CSV), centers(camera).as_bytes())?);
        }
        if wants(Output::White) {
            write_white(&mut folder, "white", &white)?;
        }
        self.write_layers(&mut folder, &rendered, &white)?;
        if let Some(color) = rendered.color.take() {
            let ev = exposure_ev(&color, self.spec.exposure)?;
            for tool in &self.tools {
                tool.write(&mut folder, camera, color.view(), &white, ev)?;
            }
            drop(white);
            if wants(Output::Raw) {
                write_raw_exr(&mut folder, RAW_EXR, &color)?;
            }
            if wants(Output::RawPng) {
                let image = encoded(color, ev);
                let path = folder.file(RAW_PNG);
                folder.add(RAW_PNG, holo_io::write_png(path, image.view(), ColorEncoding::Linear, Compression::Best)?);
                manifest.exposure_ev = Some(ev);
            }
        }
        folder.seal(manifest)
    }

    /// Writes `raw_LAYER.pfm` of every layer that is wanted.
    fn write_layers(
        &self,
        folder: &mut OutputFolder,
        rendered: &RawRendered,
        white: &Array2<f32>,
    ) -> Result<(), Error> {
        let (traced, others) = self.layers();
        let name = |layer: &str| format!("raw_{layer}.pfm");
        for (layer, image) in rendered.layers.iter().filter(|(layer, _)| traced.contains(*layer)) {
            let name = name(layer.name());
            let path = folder.file(&name);
            folder.add(
                name,
                match layer.channels() {
                    1 => holo_io::write_pfm(path, image.index_axis(Axis(2), 0))?,
                    _ => holo_io::write_pfm_rgb(path, image.view())?,
                },
            );
        }
        for layer in others {
            let name = name(layer.name());
            // Ground truth alone has no statistics.
            let Some(image) = raw_layer(&self.camera.camera, layer, rendered, white) else { continue };
            folder.add(name.clone(), holo_io::write_pfm(folder.file(&name), image.view())?);
        }
        let wants_color = self.spec.layers.iter().any(|layer| matches!(layer, LayerChoice::Color | LayerChoice::All));
        if let Some(color) = rendered.color.as_ref().filter(|_| wants_color) {
            let name = name(LayerChoice::Color.name());
            folder.add(name.clone(), holo_io::write_pfm_rgb(folder.file(&name), color.view())?);
        }
        Ok(())
    }
}

/// The white image of a camera, of which a pixel is lit at least.
pub(crate) fn lit_white_image(file: &CameraFile) -> Result<Array2<f32>, Error> {
    let white = file.camera.white_image()?;
    match white.iter().any(|&light| light > 0.0) {
        true => Ok(white),
        false => Err(Error::BadRequest(format!(
            "no light reaches the sensor of the camera '{}': its micro-images lie beside the sensor or between the \
             light-sensitive parts of its pixels; check mla.offset_um, main_lens.f_number and sensor.fill",
            file.name
        ))),
    }
}

/// Writes a white image as EXR, and as a PNG of 16 bits in linear light, 1 being the brightest pixel.
pub(crate) fn write_white(folder: &mut OutputFolder, stem: &str, white: &Array2<f32>) -> Result<(), Error> {
    let (exr, png) = (format!("{stem}.exr"), format!("{stem}.png"));
    let digest = holo_io::write_exr(folder.file(&exr), &[ExrChannel::float("Y", white.view())])?;
    folder.add(exr, digest);
    let brightest = white.iter().fold(0.0f32, |most, &light| most.max(light)).max(f32::MIN_POSITIVE);
    let codes = white.mapv(|light| (light / brightest * 65_535.0).round() as u16).insert_axis(Axis(2));
    let digest = holo_io::write_png(folder.file(&png), codes.view(), ColorEncoding::Linear, Compression::Best)?;
    folder.add(png, digest);
    Ok(())
}

/// Writes linear color as EXR.
fn write_raw_exr(folder: &mut OutputFolder, name: &str, color: &Array3<f32>) -> Result<(), Error> {
    let planes = ["R", "G", "B"].iter().zip(color.axis_iter(Axis(2)));
    let channels: Vec<_> = planes.map(|(name, plane)| ExrChannel::float(name, plane)).collect();
    folder.add(name, holo_io::write_exr(folder.file(name), &channels)?);
    Ok(())
}

/// Writes a raw image as EXR and as a linear PNG of 16 bits.
pub(crate) fn write_raw(
    folder: &mut OutputFolder,
    stem: &str,
    color: Array3<f32>,
    wanted: Exposure,
) -> Result<(), Error> {
    write_raw_exr(folder, &format!("{stem}.exr"), &color)?;
    let ev = exposure_ev(&color, wanted)?;
    let image = encoded(color, ev);
    let name = format!("{stem}.png");
    let path = folder.file(&name);
    folder.add(name, holo_io::write_png(path, image.view(), ColorEncoding::Linear, Compression::Best)?);
    Ok(())
}

/// The exposure of raw color.
fn exposure_ev(color: &Array3<f32>, wanted: Exposure) -> Result<f64, Error> {
    if let Exposure::Ev(ev) = wanted {
        return Ok(ev);
    }
    let (rows, columns, _) = color.dim();
    let shape = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(rows, columns))?;
    Ok(exposure::automatic_exposure(&LightField::from_elemental_grid(color.view(), shape)?))
}

/// Raw color as codes of 16 bits in linear light: 65,535 is the radiance 2^-EV.
fn encoded(color: Array3<f32>, ev: f64) -> Array3<u16> {
    let scale = (65_535.0 * ev.exp2()) as f32;
    color.mapv(|value| (value * scale).round().clamp(0.0, 65_535.0) as u16)
}

/// The lowest row and column of the micro-images on the sensor, from which files count.
pub(crate) fn first_indices(camera: &PlenopticCamera) -> (i32, i32) {
    let all = micro_images(camera);
    let first = |of: fn(&MicrolensIndex) -> i32| all.iter().map(|(lens, _)| of(lens)).min().unwrap_or(0);
    (first(|lens| lens.row), first(|lens| lens.column))
}

/// The centers of all micro-images on the sensor: column and row of the micro-image from the upper left, and the position
/// in pixels, whose centers are whole numbers.
pub(crate) fn centers(camera: &PlenopticCamera) -> String {
    use fmt::Write as _;
    let (first_row, first_column) = first_indices(camera);
    let mut text = String::from("k,l,u,v\n");
    for (lens, [x, y]) in micro_images(camera) {
        let (k, l) = (lens.column - first_column, lens.row - first_row);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{k},{l},{},{}", x - 0.5, y - 0.5);
    }
    text
}

/// A layer that follows from the camera, the depth of the chief rays, or the statistics of the samples, if there are any.
fn raw_layer(
    camera: &PlenopticCamera,
    layer: RawLayer,
    rendered: &RawRendered,
    white: &Array2<f32>,
) -> Option<Array2<f32>> {
    let owner = |row: usize, column: usize| camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5]));
    let lens_type = |row: usize, column: usize| camera.array().type_of(owner(row, column));
    let image = |value: &(dyn Fn(usize, usize) -> f32 + Sync)| {
        let mut image = Array2::zeros(white.dim());
        Zip::indexed(&mut image).par_for_each(|(row, column), pixel| *pixel = value(row, column));
        Some(image)
    };
    let of_depth = |value: &(dyn Fn(f64, usize) -> f64 + Sync)| {
        let depth_m = rendered.layers.depth_m()?;
        image(&|row, column| value(f64::from(depth_m[[row, column, 0]]), lens_type(row, column)) as f32)
    };
    let statistics = rendered.statistics.as_ref();
    match layer {
        RawLayer::LensRow => image(&|row, column| owner(row, column).row as f32),
        RawLayer::LensColumn => image(&|row, column| owner(row, column).column as f32),
        RawLayer::LensType => image(&|row, column| lens_type(row, column) as f32),
        RawLayer::White => Some(white.clone()),
        RawLayer::VirtualDepth => of_depth(&|depth_m, _| camera.virtual_depth(depth_m)),
        RawLayer::Blur => of_depth(&|depth_m, lens_type| 2.0 * camera.blur_radius_px(depth_m, lens_type).abs()),
        RawLayer::InverseDepthMean => statistics.map(|all| all.inverse_depth_mean.clone()),
        RawLayer::InverseDepthDeviation => statistics.map(|all| all.inverse_depth_deviation.clone()),
        RawLayer::Coverage => statistics.map(|all| all.coverage.clone()),
    }
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
            size.rows,
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
