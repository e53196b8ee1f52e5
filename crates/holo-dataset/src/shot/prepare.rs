//! The preparation of a shot: the scene at its frame, the camera at its pose, the acceleration structure, the focus.

use std::path::Path;
use std::time::Instant;

use holo_core::optics::DisparityRange;
use holo_core::plenoptic::PlenopticCamera;
use holo_core::{GridSize, LightFieldShape, Remainder, Rig, Sensor};
use holo_io::ArrayCamera;
use holo_render::{Baseline, Camera as Optics, CameraChoice, Framed, Framing, Renderer, World};
use holo_scene::gltf::Loaded;
use holo_scene::{Camera as SceneCamera, CameraProjection, Scene, Transform};

use super::engine::report_backend;
use super::memory::{validate_memory, validate_raw_memory};
use super::source::SceneSource;
use super::viewpoint;
use super::{ground, sky};
use crate::Error;
use crate::output::Wanted;
use crate::settings::{
    Camera, EngineSettings, Focus, Output, Pixels, RenderSettings, RigSettings, SceneSettings, Sky, Spacing,
};
use crate::watch::{About, Diagnostics};

/// The length of the larger image side of cameras whose focal length is in pixels, m: only the ratio matters.
const SENSOR_M: f64 = 0.036;

/// A scene at one frame, with its sky.
pub struct Stage {
    /// The scene, and warnings about its file.
    pub loaded: Loaded,
    /// Whether the scene has no light sources and got the soft sky of [`Sky::Automatic`].
    pub has_automatic_sky: bool,
    /// Of a scene of a recipe: how many before it were of no use.
    pub attempt: Option<u64>,
    /// Wall-clock time of reading the scene, s.
    pub load_seconds: f64,
}

/// A camera in front of a scene, ready to render.
pub struct Prepared {
    /// The camera.
    pub camera: Optics,
    /// Its pose, camera to world.
    pub pose: Transform,
    /// The name of the scene's camera or of the pose, for messages and manifests.
    pub name: String,
    /// The renderer with the acceleration structure of the scene.
    pub renderer: Renderer,
    /// Wall-clock time of building the acceleration structure and finding the focus, s.
    pub build_seconds: f64,
}

impl Prepared {
    /// Returns the rig; `None` for other cameras.
    #[must_use]
    pub fn rig(&self) -> Option<&Rig> {
        self.camera.rig()
    }
}

impl Stage {
    /// Loads a scene at the frame of `scene`, and gives it its sky; `None`: its light does not matter.
    ///
    /// # Errors
    /// [`Error::Failed`] if the scene or the environment map cannot be read; [`Error::BadRequest`] for several frames.
    pub fn load(
        source: &SceneSource,
        scene: &SceneSettings,
        sky: Option<&Sky>,
        engine: &EngineSettings,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Self, Error> {
        Self::load_later(source, (scene, 0.0), sky, engine, diagnostics)
    }

    /// As [`load`](Self::load), so many seconds after the frame.
    fn load_later(
        source: &SceneSource,
        at: (&SceneSettings, f64),
        sky: Option<&Sky>,
        engine: &EngineSettings,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Self, Error> {
        let start = Instant::now();
        let (mut loaded, attempt) = load(source, at, engine, diagnostics)?;
        let has_automatic_sky = sky.map_or(Ok(false), |wanted| sky::add(wanted, &mut loaded.scene, diagnostics))?;
        Ok(Self { loaded, has_automatic_sky, attempt, load_seconds: start.elapsed().as_secs_f64() })
    }

    /// Prepares the scene for cameras at any pose.
    ///
    /// # Errors
    /// [`Error::Failed`] if the scene is invalid; [`Error::Render`] if the threads cannot be started.
    pub fn world(&self, source: &SceneSource, sky: &Sky, engine: &EngineSettings) -> Result<World<'_>, Error> {
        World::new(&self.loaded.scene, engine.backend, engine.threads).map_err(|error| blame(source.path(), sky, error))
    }
}

/// What a job has in common for all of its shots.
#[derive(Clone, Copy)]
pub(super) struct Setup<'a> {
    pub source: &'a SceneSource,
    pub settings: &'a RenderSettings,
    pub wanted: &'a Wanted,
    pub engine: &'a EngineSettings,
    /// The electrons of the radiance 1 on an image sensor that the first shot chose; `None`: every shot chooses its own.
    pub electrons: Option<f64>,
}

impl Setup<'_> {
    /// Checks what can be checked of sizes and poses before a scene is loaded.
    ///
    /// # Errors
    /// [`Error::BadRequest`] and [`Error::Core`] for impossible sizes, for more memory than there is, and for a pose that
    /// is none.
    pub fn check(&self) -> Result<(), Error> {
        let settings = self.settings;
        let Some(array) = settings.poses.cameras() else {
            return match &settings.camera {
                Camera::Rig(rig) => validate_memory(&shape(rig, None, &())?, settings, self.wanted),
                Camera::Plenoptic(file) => validate_raw_memory(file.camera.sensor().size, settings, self.wanted),
                Camera::Pinhole => Ok(()),
            };
        };
        if let Camera::Plenoptic(file) = &settings.camera {
            validate_raw_memory(file.camera.sensor().size, settings, self.wanted)?;
        }
        for camera in &array.cameras {
            pose_of(camera)?;
            if !matches!(settings.camera, Camera::Pinhole) && (camera.gain != [1.0; 3] || camera.time_s != 0.0) {
                return Err(Error::BadRequest(format!(
                    "camera '{}' has a gain or a time of its own (`gain`, `time_s`), which cameras of one image can have; a light \
                     field or a raw image at its pose cannot: remove them from the file of `transforms`",
                    holo_core::visible(&camera.name)
                )));
            }
            match &settings.camera {
                Camera::Rig(rig) => validate_memory(&shape(rig, Some(camera), &())?, settings, self.wanted)?,
                Camera::Pinhole if camera.size.is_none() => return Err(without_size(camera)),
                Camera::Pinhole | Camera::Plenoptic(_) => {}
            }
        }
        Ok(())
    }

    /// Loads the scene at a frame.
    pub fn stage(&self, diagnostics: &dyn Diagnostics) -> Result<Stage, Error> {
        self.stage_later(0.0, diagnostics)
    }

    /// Loads the scene so many seconds after the frame.
    pub fn stage_later(&self, later_s: f64, diagnostics: &dyn Diagnostics) -> Result<Stage, Error> {
        let light = &self.settings.light;
        let sees_light = light.sky != Sky::Automatic || self.wanted.integrator != holo_render::Integrator::Depth;
        let at = (&self.settings.scene, later_s);
        Stage::load_later(self.source, at, sees_light.then_some(&light.sky), self.engine, diagnostics)
    }

    /// Prepares the camera at the pose of this number; of a job without poses at that of the scene's camera.
    pub fn prepare(
        &self,
        stage: &Stage,
        world: &World,
        pose: usize,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Prepared, Error> {
        self.prepare_after(None, (stage, world), pose, diagnostics)
    }

    /// As [`prepare`](Self::prepare), with the acceleration structure of `earlier` if that was prepared in the same world and
    /// has the same pose.
    pub fn prepare_after(
        &self,
        earlier: Option<Prepared>,
        (stage, world): (&Stage, &World),
        pose: usize,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Prepared, Error> {
        let start = Instant::now();
        let placed = self.place(stage, pose, diagnostics)?;
        let (pose, name) = (placed.pose(), placed.name());
        let renderer = match earlier {
            Some(earlier) if earlier.pose == pose => earlier.renderer,
            _ => world.at(&pose).map_err(|e| self.blame(e))?,
        };
        let camera = self.optics(&renderer, placed)?;
        Ok(Prepared { camera, pose, name, renderer, build_seconds: start.elapsed().as_secs_f64() })
    }

    /// Prepares the same camera for previews of a moving camera. `still` is a renderer at the origin of the world.
    pub fn prepare_moved(&self, stage: &Stage, still: &Renderer) -> Result<Prepared, Error> {
        let start = Instant::now();
        let placed = self.place(stage, 0, &())?;
        let (pose, name) = (placed.pose(), placed.name());
        let renderer = still.moved(&pose).map_err(|e| self.blame(e))?;
        let camera = self.optics(&renderer, placed)?;
        Ok(Prepared { camera, pose, name, renderer, build_seconds: start.elapsed().as_secs_f64() })
    }

    /// The camera with its focus.
    fn optics(&self, renderer: &Renderer, placed: Placed) -> Result<Optics, Error> {
        Ok(match placed {
            Placed::Views(framed) => Optics::Rig(self.focused(renderer, &framed)?),
            Placed::Raw { camera, .. } => *camera,
        })
    }

    fn blame(&self, error: holo_render::Error) -> Error {
        blame(self.source.path(), &self.settings.light.sky, error)
    }

    /// The camera at a pose, before its focus is known.
    fn place(&self, stage: &Stage, pose: usize, diagnostics: &dyn Diagnostics) -> Result<Placed, Error> {
        let Self { source, settings, .. } = *self;
        let at = settings.poses.cameras().and_then(|array| array.cameras.get(pose));
        match (&settings.camera, at) {
            (Camera::Rig(rig), None) => {
                let shape = shape(rig, None, diagnostics)?;
                validate_memory(&shape, settings, self.wanted)?;
                let framed = frame(source.path(), &stage.loaded, (rig, shape, None), &settings.scene, diagnostics)?;
                if let Some(change) = framed.aspect_change {
                    diagnostics.report(About::Scene, &format!("note: {}: {change}", framed.camera));
                }
                Ok(Placed::Views(Box::new(framed)))
            }
            (Camera::Rig(rig), Some(camera)) => {
                let shape = shape(rig, Some(camera), diagnostics)?;
                validate_memory(&shape, settings, self.wanted)?;
                Ok(Placed::Views(Box::new(frame_at(camera, rig, shape)?)))
            }
            (Camera::Plenoptic(file), None) => {
                let slopes = half_view(&file.camera);
                let framed = pose_of_scene(source, &stage.loaded, (&settings.scene, slopes), diagnostics)?;
                let camera = Box::new(file.camera.clone().into());
                Ok(Placed::Raw { camera, pose: framed.pose, name: framed.camera })
            }
            (Camera::Plenoptic(file), Some(at)) => {
                let camera = Box::new(file.camera.clone().into());
                Ok(Placed::Raw { camera, pose: pose_of(at)?, name: at.name.clone() })
            }
            (Camera::Pinhole, Some(camera)) => {
                let size = camera.size.ok_or_else(|| without_size(camera))?;
                let shape = LightFieldShape::new(GridSize::new(1, 1), size)?;
                let rig = RigSettings { focus: Focus::Meters(f64::INFINITY), ..RigSettings::default() };
                Ok(Placed::Views(Box::new(frame_at(camera, &rig, shape)?)))
            }
            (Camera::Pinhole, None) => {
                Err(Error::BadRequest("pinhole cameras need `transforms`, which places them".into()))
            }
        }
    }

    /// The rig with its focus.
    fn focused(&self, renderer: &Renderer, framed: &Framed) -> Result<Rig, Error> {
        let (spacing, focus) = match &self.settings.camera {
            Camera::Rig(rig) => (rig.spacing, rig.focus),
            _ => (Spacing::BaselineM(0.0), Focus::Meters(f64::INFINITY)),
        };
        let rig = match (spacing, focus) {
            (Spacing::DisparitiesPx((min_px, max_px)), _) => {
                renderer.rig_for_disparities(framed, DisparityRange { min_px, max_px })
            }
            (_, Focus::Meters(distance)) => framed.rig(distance),
            (_, Focus::Automatic) => renderer.automatic_focus_m(framed).and_then(|distance| framed.rig(distance)),
        };
        rig.map_err(|error| blame(self.source.path(), &self.settings.light.sky, error))
    }

    /// The camera of another frame with the focus distance of `rig`, for motion: the scene, and the rig with its pose.
    pub fn next_frame(&self, frame: u32, rig: &Rig, pose: usize) -> Result<(Scene, Transform, Rig), Error> {
        let mut scene = self.settings.scene.clone();
        scene.frames = Some(crate::settings::Frames::one(frame));
        let (loaded, attempt) = load(self.source, (&scene, 0.0), self.engine, &())?;
        let stage = Stage { loaded, has_automatic_sky: false, attempt, load_seconds: 0.0 };
        let Placed::Views(framed) = self.place(&stage, pose, &())? else {
            return Err(Error::BadRequest("motion is of views, and a raw image has none".into()));
        };
        let spacing = self.settings.camera.rig().map(|rig| rig.spacing);
        let next = match spacing {
            // A baseline that followed from disparities stays; one of an f-number changes with the focal length.
            Some(Spacing::DisparitiesPx(_)) => rig.to_builder().intrinsics(framed.intrinsics).build()?,
            _ => framed.rig(rig.focus_distance_m())?,
        };
        Ok((stage.loaded.scene, framed.pose, next))
    }
}

/// A camera at a pose.
enum Placed {
    Views(Box<Framed>),
    Raw { camera: Box<Optics>, pose: Transform, name: String },
}

impl Placed {
    fn pose(&self) -> Transform {
        match self {
            Self::Views(framed) => framed.pose,
            Self::Raw { pose, .. } => *pose,
        }
    }

    fn name(&self) -> String {
        match self {
            Self::Views(framed) => framed.camera.clone(),
            Self::Raw { name, .. } => name.clone(),
        }
    }
}

impl SceneSource {
    /// Loads the scene, chooses its camera, builds the acceleration structure and determines the focus, for rendering
    /// depth and disparity of the central view.
    ///
    /// # Errors
    /// [`Error::Failed`] if the scene cannot be read or its camera is unsuitable; [`Error::BadRequest`] and
    /// [`Error::Core`] if the rig is invalid; [`Error::Render`] if the backend is not available.
    pub fn prepare(
        &self,
        settings: &RenderSettings,
        engine: &EngineSettings,
        diagnostics: &dyn Diagnostics,
    ) -> Result<(Stage, Prepared), Error> {
        let mut of_truth = settings.clone();
        if settings.camera.rig().is_some() {
            // Nothing of the other views is rendered.
            of_truth.light.integrator = holo_render::Integrator::Depth;
            (of_truth.output.write, of_truth.output.layers) = (vec![Output::Depth, Output::Disparity], Vec::new());
        }
        let settings = &of_truth;
        let wanted = Wanted::new(settings)?;
        let setup = Setup { source: self, settings, wanted: &wanted, engine, electrons: None };
        let stage = Stage::load(self, &settings.scene, None, engine, diagnostics)?;
        let prepared = setup.prepare(&stage, &stage.world(self, &settings.light.sky, engine)?, 0, diagnostics)?;
        report_backend(&prepared.renderer, diagnostics);
        Ok((stage, prepared))
    }
}

/// Loads a scene and reports its warnings; with the number of the attempt of one that is drawn.
fn load(
    source: &SceneSource,
    (scene, later_s): (&SceneSettings, f64),
    engine: &EngineSettings,
    diagnostics: &dyn Diagnostics,
) -> Result<(Loaded, Option<u64>), Error> {
    if scene.frames.is_some_and(|frames| frames.single().is_none()) {
        return Err(Error::BadRequest("`frame` is of several images here; give one".into()));
    }
    let loaded = |error| match error {
        holo_scene::Error::Read { .. } => Error::Failed(error.to_string()),
        other => Error::Failed(named(source.path(), &other.to_string())),
    };
    let (mut loaded, attempt) = match source {
        SceneSource::Recipe(drawing) => {
            let (scene, attempt) = drawing.draw(engine)?;
            (Loaded::from(scene), Some(attempt))
        }
        other => (other.load_later(scene, later_s).map_err(loaded)?, None),
    };
    loaded.warnings.iter().for_each(|warning| diagnostics.report(About::Scene, &format!("warning: {warning}")));
    if scene.ground {
        keep_view(&mut loaded.scene)?;
        ground::add(&mut loaded.scene)?;
    }
    Ok((loaded, attempt))
}

/// Half of what a plenoptic camera sees at a distance of 1.
pub(crate) fn half_view(camera: &PlenopticCamera) -> [f64; 2] {
    let sensor = camera.sensor();
    let lens = camera.equivalent_views().slope_per_lens / camera.array().pitch_m;
    [sensor.size.columns, sensor.size.rows].map(|side| side as f64 * sensor.pixel_m * lens / 2.0)
}

/// The pose of the camera of the scene, for cameras that have their own optics and see `slopes` at a distance of 1.
pub(crate) fn pose_of_scene(
    source: &SceneSource,
    loaded: &Loaded,
    (scene, slopes): (&SceneSettings, [f64; 2]),
    diagnostics: &dyn Diagnostics,
) -> Result<Framed, Error> {
    let one = GridSize::new(1, 1);
    let shape = LightFieldShape::new(one, one)?;
    frame(source.path(), loaded, (&RigSettings::default(), shape, Some(slopes)), scene, diagnostics)
}

/// The camera of the scene, or that which the settings place in it, with the intrinsics and the baseline of the rig. `slopes`:
/// half of the image at a distance of 1, if it is not that of the rig.
fn frame(
    path: &Path,
    loaded: &Loaded,
    (rig, shape, slopes): (&RigSettings, LightFieldShape, Option<[f64; 2]>),
    scene: &SceneSettings,
    diagnostics: &dyn Diagnostics,
) -> Result<Framed, Error> {
    let size = shape.lenses();
    let larger = size.columns.max(size.rows) as f64;
    // Divided, because 1e-3 is not exact: 36 mm times it is not 0.036 m.
    let sensor_m = rig.sensor_mm / 1e3;
    // From the width of the image to half the angle.
    let of_angle = |deg: f64| sensor_m * (size.columns as f64 / larger) / (2.0 * (deg.to_radians() / 2.0).tan());
    let framing = Framing::new(shape)
        .camera(choice(scene.camera.as_ref(), loaded))
        .focal_length_m(rig.focal_mm.map(|mm| mm / 1e3).or(scene.fov_deg.map(of_angle)))
        .sensor_size_m(sensor_m)
        .baseline(baseline(rig))
        .projection(rig.projection);
    let mut framed = framing.frame(&loaded.scene).map_err(|e| match e {
        // No camera was requested: the file has no suitable one.
        holo_render::Error::BadSetting(why) if scene.camera.is_none() => Error::Failed(named(path, &why)),
        other => blame(path, &Sky::Automatic, other),
    })?;
    let half = framed.intrinsics.sensor_size_m / (2.0 * framed.intrinsics.focal_length_m);
    let slopes = slopes.unwrap_or([size.columns, size.rows].map(|side| half * side as f64 / larger));
    if let Some((pose, name)) = viewpoint::placed(scene, &framed.pose, slopes, &loaded.scene)? {
        (framed.pose, framed.camera) = (pose, name);
    } else if loaded.scene.cameras.is_empty() {
        diagnostics.report(About::Scene, &format!("warning: {}", framed.camera));
    }
    Ok(framed)
}

/// Gives a scene without cameras that which sees all of it, before something is added that is not to be seen whole.
fn keep_view(scene: &mut Scene) -> Result<(), Error> {
    if scene.cameras.is_empty() {
        let one = GridSize::new(1, 1);
        let Framed { pose, intrinsics, .. } = Framing::new(LightFieldShape::new(one, one)?).frame(scene)?;
        let vertical_angle_rad = 2.0 * (intrinsics.sensor_size_m / (2.0 * intrinsics.focal_length_m)).atan();
        let projection = CameraProjection::Perspective { vertical_angle_rad, aspect_ratio: None };
        scene.cameras.push(SceneCamera { name: "whole scene".into(), pose, projection });
    }
    Ok(())
}

/// The rig at a pose of a list, with the focal length of its camera.
fn frame_at(camera: &ArrayCamera, rig: &RigSettings, shape: LightFieldShape) -> Result<Framed, Error> {
    let pose = pose_of(camera)?;
    // The focal length is in pixels of the image without shifts.
    let size = camera.size.unwrap_or_else(|| shape.lenses());
    let projection = CameraProjection::Perspective { vertical_angle_rad: 1.0, aspect_ratio: None };
    let only = Scene { cameras: vec![SceneCamera { name: camera.name.clone(), pose, projection }], ..Scene::default() };
    let framed = Framing::new(shape)
        .camera(CameraChoice::First)
        .sensor_size_m(SENSOR_M)
        .focal_length_m(Some(SENSOR_M * camera.focal_px / size.columns.max(size.rows) as f64))
        .baseline(baseline(rig))
        .projection(rig.projection)
        .frame(&only)?;
    Ok(framed)
}

fn baseline(rig: &RigSettings) -> Baseline {
    match rig.spacing {
        Spacing::FNumber(f_number) => Baseline::FNumber(f_number),
        Spacing::BaselineM(meters) => Baseline::Meters(meters),
        // It is found later.
        Spacing::DisparitiesPx(_) => Baseline::FNumber(5.0),
    }
}

/// The pose of a camera of a list, whose axes may be rounded.
fn pose_of(camera: &ArrayCamera) -> Result<Transform, Error> {
    let [x, y, z, translation] = camera.axes_and_position;
    match holo_core::rotation_near([x, y, z]) {
        Ok(columns) => Ok(Transform { columns, translation }),
        Err(_) => {
            let name = &camera.name;
            Err(Error::BadRequest(format!(
                "the matrix of camera '{name}' is no rotation and translation; remove scale and mirroring from it"
            )))
        }
    }
}

fn without_size(camera: &ArrayCamera) -> Error {
    let name = &camera.name;
    Error::BadRequest(format!(
        "camera '{name}' has no size in pixels; add `w` and `h` to the file of `transforms`, or give the size of the images \
         as `lenses=WIDTHxHEIGHT`"
    ))
}

/// The choice of the camera: a number is an index, unless a camera has that name.
fn choice(requested: Option<&String>, loaded: &Loaded) -> CameraChoice {
    let Some(text) = requested else { return CameraChoice::First };
    match text.parse::<usize>() {
        Ok(index) if loaded.scene.cameras.iter().all(|c| c.name != *text) => CameraChoice::Index(index),
        _ => CameraChoice::Name(text.clone()),
    }
}

/// Converts an error of the renderer. If it may be caused by numbers of the scene file or the environment map, its message
/// names the file.
fn blame(scene: &Path, sky: &Sky, error: holo_render::Error) -> Error {
    if let (holo_render::Error::Scene(holo_scene::Error::BadScene { at, what }), Sky::Map(sky)) = (&error, sky)
        && at.starts_with("environment")
    {
        return Error::Failed(named(sky, &format!("{at}: {what}")));
    }
    let numbers = matches!(error, holo_render::Error::Scene(_) | holo_render::Error::Core(_));
    match Error::from(error) {
        error if numbers && !error.is_bad_request() => Error::Failed(named(scene, &error.to_string())),
        error => error,
    }
}

/// A message with the path of a file in front, unless it begins with that already.
fn named(path: &Path, message: &str) -> String {
    let name = path.display().to_string();
    if message.starts_with(&format!("{name}: ")) { message.into() } else { format!("{name}: {message}") }
}

/// The numbers of views and microlenses of a rig, at a pose with a size of its own or at that of the scene.
fn shape(rig: &RigSettings, at: Option<&ArrayCamera>, diagnostics: &dyn Diagnostics) -> Result<LightFieldShape, Error> {
    let own = match rig.pixels {
        Pixels::Lenses(lenses) => Some(LightFieldShape::new(rig.views, lenses)?),
        Pixels::Sensor(sensor) => Some(divided(sensor, rig.views, diagnostics)?),
        Pixels::OfPoses => None,
    };
    let shape = match (own, at.map(|camera| (camera, camera.size))) {
        (Some(shape), None | Some((_, None))) => shape,
        (Some(shape), Some((_, Some(size)))) if size == shape.lenses() => shape,
        (Some(shape), Some((camera, Some(size)))) => {
            let (name, lenses) = (&camera.name, shape.lenses());
            return Err(Error::BadRequest(format!(
                "camera '{name}' has {size} pixels, and with `lenses` or `sensor` a view has {lenses}; remove them"
            )));
        }
        (None, Some((_, Some(size)))) => LightFieldShape::new(rig.views, size)?,
        (None, Some((camera, None))) => return Err(without_size(camera)),
        (None, None) => {
            return Err(Error::BadRequest("the pixels of a view are those of poses, and there are none".into()));
        }
    };
    shifted(rig, shape)
}

/// The views and microlenses of a sensor.
fn divided(sensor: Sensor, views: GridSize, diagnostics: &dyn Diagnostics) -> Result<LightFieldShape, Error> {
    let divided = sensor.divide(views, Remainder::Crop)?;
    let border = divided.border;
    if (border.rows, border.columns) != (0, 0) {
        let size = sensor.size();
        let note = format!(
            "note: {} x {} views leave {} columns and {} rows of the {} x {} sensor unused",
            views.columns, views.rows, border.columns, border.rows, size.columns, size.rows
        );
        diagnostics.report(About::Setup, &note);
    }
    Ok(divided.shape)
}

/// The microlenses of an array in all of its positions.
pub(crate) fn shifted(rig: &RigSettings, shape: LightFieldShape) -> Result<LightFieldShape, Error> {
    let Some(shifts) = rig.lens_shifts else { return Ok(shape) };
    let more = |count: usize| count.saturating_mul(shifts as usize);
    let lenses = shape.lenses();
    Ok(LightFieldShape::new(rig.views, GridSize::new(more(lenses.rows), more(lenses.columns)))?)
}
