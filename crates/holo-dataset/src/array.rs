//! Camera arrays: pinhole cameras anywhere, each with a pose and an image of its own.
//!
//! | file | contents |
//! |---|---|
//! | `images/NAME.png` | 8 or 16 bits, sRGB, one exposure for all |
//! | `LAYER/NAME.pfm` | a layer, as for views |
//! | `transforms.json` | the cameras ([`CameraArray`]), with the names of the images |
//! | `manifest.json` | options, exposure and digests |
//!
//! Every camera has an acceleration structure in its own frame, so that depth is exact wherever it stands; building it is
//! a small part of an image. Cameras far apart share no light.

use std::path::Path;
use std::time::Instant;

use holo_core::{GridSize, LightFieldShape, Rig};
use holo_io::{ArrayCamera, CameraArray, ColorEncoding, Compression, FileDigest, Manifest, Sha256, WorldUp};
use holo_render::{
    CameraChoice, Denoise, Framing, GroundTruth, Integrator, Layer, Progress, RayCounts, Rendered, Renderer, Request,
    exposure,
};
use holo_scene::{Camera, CameraProjection, Scene, Transform};
use serde_json::{Value, json};

use crate::diagnostics::{About, Diagnostics};
use crate::files::{exposure_ev, validate};
use crate::identity::check_replaceable;
use crate::job::{request_integrator, source_identity, transport};
use crate::layers::{self, Wanted, file_part, write_pfm};
use crate::options::{self, Options, integrator_name};
use crate::output_folder::{OutputFolder, Rollback};
use crate::parts::PartProgress;
use crate::prepare::{blame, load, report_backend};
use crate::source::SceneSource;
use crate::spec::{EngineSpec, Exposure, LayerChoice, RenderSpec};
use crate::{Error, sky};

/// The cameras in the output folder.
const TRANSFORMS: &str = "transforms.json";

/// The folder of the images.
const IMAGES: &str = "images";

/// The length of the larger image side, m: only its ratio to the focal length matters.
const SENSOR_M: f64 = 0.036;

/// How far the axes of a camera may be from orthonormal: files of single precision.
const POSE_TOLERANCE: f64 = 1e-4;

/// A render of a camera array.
#[derive(Clone, Debug)]
pub struct ArrayJob {
    /// The scene.
    pub source: SceneSource,
    /// The cameras.
    pub cameras: CameraArray,
    /// The axis that points up in the world of the file that is written.
    pub up: WorldUp,
    /// What to render; its rig has no effect.
    pub spec: RenderSpec,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSpec,
    options: Options,
}

/// What a finished render of a camera array reports.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ArrayReport {
    /// Wall-clock time of rendering all images, s.
    pub render_seconds: f64,
    /// Wall-clock time of building the acceleration structures, s.
    pub build_seconds: f64,
    /// Wall-clock time of all, s.
    pub total_seconds: f64,
    /// Number of rays by kind.
    pub rays: RayCounts,
    /// The number of cameras.
    pub cameras: usize,
    /// The ray tracing backend and its version.
    pub backend: String,
    /// Names of the files, relative to the folder.
    pub files: Vec<String>,
}

/// What all cameras have in common.
struct Setup {
    scene: Scene,
    integrator: Integrator,
    wanted: Wanted,
}

impl ArrayJob {
    /// Creates a job whose manifest contains the specification as [`RenderSpec::to_options`] writes it.
    #[must_use]
    pub fn new(source: SceneSource, cameras: CameraArray, up: WorldUp, spec: RenderSpec) -> Self {
        let options = spec.to_options();
        Self { source, cameras, up, spec, engine: EngineSpec::default(), options }
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

    /// Renders the images of all cameras into the folder `out`.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the specification contradicts itself or a camera has no size or no pose; otherwise as
    /// [`RenderJob::run`](crate::RenderJob::run). Files and folders that the run created are removed then.
    pub fn run(
        &self,
        out: &Path,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<ArrayReport, Error> {
        let start = Instant::now();
        self.validate()?;
        let mut folder = OutputFolder::create(out, rollback)?;
        let wanted = Wanted::new(&self.spec);
        let integrator = request_integrator(&self.spec, &wanted);
        let mut scene = load(&self.source, &self.spec.scene, diagnostics)?.scene;
        if integrator != Integrator::Depth {
            sky::add(&self.spec.sky, &mut scene, diagnostics)?;
        }
        let setup = Setup { scene, integrator, wanted };
        folder.unseal()?;
        let mut exposure = match self.spec.exposure {
            Exposure::Ev(ev) => Some(ev),
            Exposure::Automatic => None,
        };
        let (mut render_seconds, mut build_seconds, mut rays) = (0.0, 0.0, RayCounts::default());
        let (mut backend, mut has_color, mut used) = (String::new(), false, integrator);
        for (k, camera) in self.cameras.cameras.iter().enumerate() {
            let building = Instant::now();
            let (renderer, rig) = self.place(camera, &setup)?;
            build_seconds += building.elapsed().as_secs_f64();
            if k == 0 {
                report_backend(&renderer, diagnostics);
                backend = renderer.engine_name().to_owned();
            }
            let rendering = Instant::now();
            let rendered =
                renderer.render(&self.request(rig, &setup), &PartProgress { inner: progress, k, of: self.count() })?;
            render_seconds += rendering.elapsed().as_secs_f64();
            rays = rays + rendered.rays;
            if k == 0 && rendered.color.is_none() && integrator == Integrator::Auto {
                let note =
                    "note: the scene has no light sources, so there is no color, only ground truth; try --sky auto";
                diagnostics.report(About::Scene, note);
            }
            (has_color, used) = (has_color || rendered.color.is_some(), rendered.integrator);
            exposure = exposure.or_else(|| renderer.install(|| exposure_ev(&self.spec, &rendered)));
            renderer.install(|| self.write(&mut folder, &camera.name, &rendered, exposure, &setup.wanted))?;
        }
        folder.add(TRANSFORMS, self.sized().write(folder.file(TRANSFORMS), self.up)?);
        let mut manifest = Manifest { exposure_ev: exposure.filter(|_| has_color), ..self.identity(&backend)? };
        manifest.settings.insert("cameras".into(), self.count().into());
        manifest.settings.insert("integrator".into(), integrator_name(used).into());
        let files = folder.seal(manifest)?;
        let (cameras, total_seconds) = (self.count(), start.elapsed().as_secs_f64());
        Ok(ArrayReport { render_seconds, build_seconds, total_seconds, rays, cameras, backend, files })
    }

    fn count(&self) -> usize {
        self.cameras.cameras.len()
    }

    fn validate(&self) -> Result<(), Error> {
        validate(&self.spec)?;
        let bad = |what: &str| Err(Error::BadRequest(format!("{what} of a camera array")));
        if let Some(output) = self.spec.outputs.first() {
            let name = output.name();
            return Err(Error::BadRequest(format!(
                "--write {name} is of a grid of views; a camera array writes {IMAGES}/NAME.png and the maps of --layers"
            )));
        }
        if self.spec.sensor_model.is_some() {
            return bad("--sensor-model exposes a raw image, not those");
        }
        if self.spec.denoise != Denoise::Off {
            return bad("--denoise views needs a grid of views, not those");
        }
        if self.spec.ground_truth == GroundTruth::All {
            return bad(
                "--ground-truth all is of a grid of views; every camera has the layers, not only the central one,",
            );
        }
        let of_views = [
            LayerChoice::Error,
            LayerChoice::Visibility,
            LayerChoice::OpticalFlow,
            LayerChoice::SceneFlow,
            LayerChoice::One(Layer::Disparity),
        ];
        if let Some(layer) = of_views.into_iter().find(|layer| self.spec.layers.contains(layer)) {
            let name = layer.name();
            return Err(Error::BadRequest(format!("--layers {name} is of a grid of views; remove it")));
        }
        match self.cameras.cameras.iter().find(|camera| self.size(camera).is_none()) {
            Some(camera) => {
                let name = &camera.name;
                Err(Error::BadRequest(format!("camera '{name}' has no size; give --lenses WIDTHxHEIGHT")))
            }
            None => Ok(()),
        }
    }

    /// The size of the image of a camera.
    fn size(&self, camera: &ArrayCamera) -> Option<GridSize> {
        camera.size.or(self.spec.rig.lenses)
    }

    /// The cameras with their sizes.
    fn sized(&self) -> CameraArray {
        let sized = |camera: &ArrayCamera| ArrayCamera { size: self.size(camera), ..camera.clone() };
        CameraArray { cameras: self.cameras.cameras.iter().map(sized).collect() }
    }

    /// The renderer and the rig, of one view, of a camera.
    fn place(&self, camera: &ArrayCamera, setup: &Setup) -> Result<(Renderer, Rig), Error> {
        let size = self.size(camera).unwrap_or(GridSize::new(1, 1));
        let pose = pose(camera)?;
        let one = LightFieldShape::new(GridSize::new(1, 1), size)?;
        let projection = CameraProjection::Perspective { vertical_angle_rad: 1.0, aspect_ratio: None };
        let only = Scene { cameras: vec![Camera { name: camera.name.clone(), pose, projection }], ..Scene::default() };
        let framed = Framing::new(one)
            .camera(CameraChoice::First)
            .sensor_size_m(SENSOR_M)
            .focal_length_m(Some(SENSOR_M * camera.focal_px / size.columns.max(size.rows) as f64))
            .frame(&only)?;
        let renderer = Renderer::new(&setup.scene, &pose, self.engine.backend, self.engine.threads)
            .map_err(|why| blame(self.source.path(), why))?;
        Ok((renderer, framed.rig(f64::INFINITY)?))
    }

    fn request(&self, rig: Rig, setup: &Setup) -> Request {
        let transport = transport(&self.spec, setup.integrator);
        Request::new(rig).transport(transport).layers(setup.wanted.central)
    }

    /// Writes the files of one camera.
    fn write(
        &self,
        folder: &mut OutputFolder,
        name: &str,
        rendered: &Rendered,
        exposure: Option<f64>,
        wanted: &Wanted,
    ) -> Result<(), Error> {
        if let (Some(color), Some(ev)) = (&rendered.color, exposure) {
            folder.subfolder(IMAGES)?;
            let file = format!("{IMAGES}/{name}.png");
            let path = folder.file(&file);
            let written: FileDigest = if self.spec.bit_depth == 16 {
                let coded = exposure::encode_16bit(color, ev)?;
                holo_io::write_png(path, coded.view(0, 0)?, ColorEncoding::Srgb, Compression::Best)?
            } else {
                let coded = exposure::encode_8bit(color, ev)?;
                holo_io::write_png(path, coded.view(0, 0)?, ColorEncoding::Srgb, Compression::Best)?
            };
            folder.add(file, written);
        }
        if let Some(color) = rendered.color.as_ref().filter(|_| wanted.color) {
            let file = layer_file(folder, layers::COLOR, name)?;
            folder.add(file.clone(), write_pfm(folder.file(&file), color.view(0, 0)?)?);
        }
        // One view has no disparity.
        let written = wanted.written.without([Layer::Disparity].into());
        for (layer, image) in rendered.central.iter().filter(|(layer, _)| written.contains(*layer)) {
            let file = layer_file(folder, layer.name(), name)?;
            folder.add(file.clone(), write_pfm(folder.file(&file), image.view())?);
        }
        Ok(())
    }

    fn identity(&self, backend: &str) -> Result<Manifest, Error> {
        let mut manifest = source_identity(&self.source, &self.spec, &self.options, backend)?;
        // What is read and what is written have the same cameras.
        let text = format!("{:?}", self.cameras);
        manifest.settings.insert("cameras_sha256".into(), Sha256::of(text.as_bytes()).to_string().into());
        Ok(manifest)
    }
}

/// The file of a layer of a camera, in a folder that exists.
fn layer_file(folder: &OutputFolder, layer: &str, camera: &str) -> Result<String, Error> {
    let layer = file_part(layer);
    folder.subfolder(&layer)?;
    Ok(format!("{layer}/{camera}.pfm"))
}

/// The pose of a camera, whose axes may be rounded.
fn pose(camera: &ArrayCamera) -> Result<Transform, Error> {
    let [x, y, z, translation] = camera.axes_and_position;
    let given = Transform { columns: [x, y, z], translation };
    let pose = given.to_pose();
    let near = |pose: &Transform| {
        let pairs = pose.columns.as_flattened().iter().zip(given.columns.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) <= POSE_TOLERANCE
    };
    pose.filter(near).ok_or_else(|| {
        let name = &camera.name;
        Error::BadRequest(format!(
            "the matrix of camera '{name}' is no rotation and translation; remove scale and mirroring from it"
        ))
    })
}

impl ArrayReport {
    /// Returns the report as a JSON object.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json!({
            "cameras": self.cameras,
            "seconds": { "render": self.render_seconds, "build": self.build_seconds, "total": self.total_seconds },
            "rays": { "primary": self.rays.primary, "shadow": self.rays.shadow, "other": self.rays.secondary },
            "backend": self.backend,
            "files": self.files,
        })
    }
}

impl std::fmt::Display for ArrayReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let speed = self.rays.total() as f64 / self.render_seconds.max(1e-9) / 1e6;
        write!(
            f,
            "rendered {} cameras in {:.2} s ({speed:.1} Mrays/s, {}; acceleration structures {:.2} s)",
            self.cameras, self.render_seconds, self.backend, self.build_seconds
        )
    }
}
