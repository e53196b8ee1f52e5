//! The preparation of a render: scene, camera, renderer and rig.

use std::path::Path;
use std::time::Instant;

use holo_core::optics::DisparityRange;
use holo_core::{GridSize, LightFieldShape, Remainder, Rig};
use holo_render::{Baseline, CameraChoice, Framed, Framing, Renderer};
use holo_scene::Scene;
use holo_scene::gltf::Loaded;

use crate::diagnostics::{About, Diagnostics};
use crate::source::SceneSource;
use crate::spec::{EngineSpec, Focus, RigSpec, SceneSpec, Sky};
use crate::{Error, sky};

/// A scene that is ready to be rendered.
pub struct Prepared {
    /// The scene, and warnings about its file.
    pub loaded: Loaded,
    /// The camera and its position.
    pub framed: Framed,
    /// The renderer with the acceleration structure of the scene.
    pub renderer: Renderer,
    /// The rig.
    pub rig: Rig,
    /// Whether the scene has no light sources and got the soft sky of [`Sky::Automatic`].
    pub has_automatic_sky: bool,
    /// Wall-clock time of reading the scene, s.
    pub load_seconds: f64,
    /// Wall-clock time of building the acceleration structure, s.
    pub build_seconds: f64,
}

/// The environment and the memory of a render.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Purpose<'a> {
    /// The sky; `None`: its light does not matter.
    pub sky: Option<&'a Sky>,
    /// Memory of every sample of the light field, bytes.
    pub sample_bytes: usize,
    /// Memory of every pixel of the central view, bytes.
    pub lens_bytes: usize,
}

/// Loads the scene, chooses its camera, builds the acceleration structure and determines the focus.
///
/// # Errors
/// A scene that cannot be read, an invalid rig, a light field that does not fit into memory.
pub(crate) fn prepare(
    (source, spec): (&SceneSource, &SceneSpec),
    rig: &RigSpec,
    engine: &EngineSpec,
    purpose: Purpose,
    diagnostics: &dyn Diagnostics,
) -> Result<Prepared, Error> {
    let shape = shape(rig, diagnostics)?;
    validate_memory(&shape, purpose)?;
    let scene = prepare_for((source, spec), (rig, shape), engine, purpose.sky, diagnostics)?;
    if let Some(change) = scene.framed.aspect_change {
        diagnostics.report(About::Scene, &format!("note: {}: {change}", scene.framed.camera));
    }
    let PreparedScene { loaded, framed, renderer, has_automatic_sky, load_seconds, build_seconds } = scene;
    let rig = match (rig.disparity_px, rig.focus) {
        (Some((min_px, max_px)), _) => renderer.rig_for_disparities(&framed, DisparityRange { min_px, max_px }),
        (None, Focus::Meters(distance)) => framed.rig(distance),
        (None, Focus::Automatic) => renderer.automatic_focus_m(&framed).and_then(|distance| framed.rig(distance)),
    }
    .map_err(|e| blame(source.path(), e))?;
    Ok(Prepared { loaded, framed, renderer, rig, has_automatic_sky, load_seconds, build_seconds })
}

/// A scene and its renderer, without a rig.
pub(crate) struct PreparedScene {
    pub loaded: Loaded,
    pub framed: Framed,
    pub renderer: Renderer,
    pub has_automatic_sky: bool,
    pub load_seconds: f64,
    pub build_seconds: f64,
}

/// Loads the scene, chooses its camera and builds the acceleration structure, for cameras that have their own optics.
pub(crate) fn prepare_scene(
    source: (&SceneSource, &SceneSpec),
    rig: &RigSpec,
    engine: &EngineSpec,
    sky: Option<&Sky>,
    diagnostics: &dyn Diagnostics,
) -> Result<PreparedScene, Error> {
    let one = GridSize::new(1, 1);
    prepare_for(source, (rig, LightFieldShape::new(one, one)?), engine, sky, diagnostics)
}

fn prepare_for(
    (source, spec): (&SceneSource, &SceneSpec),
    (rig, shape): (&RigSpec, LightFieldShape),
    engine: &EngineSpec,
    sky: Option<&Sky>,
    diagnostics: &dyn Diagnostics,
) -> Result<PreparedScene, Error> {
    let start = Instant::now();
    let scene = source.path();
    let mut loaded = load(source, spec, diagnostics)?;
    let has_automatic_sky = sky.map_or(Ok(false), |wanted| sky::add(wanted, &mut loaded.scene, diagnostics))?;
    let load_seconds = start.elapsed().as_secs_f64();
    let framed = frame(scene, &loaded, rig, shape, diagnostics)?;
    let start = Instant::now();
    let renderer =
        Renderer::new(&loaded.scene, &framed.pose, engine.backend, engine.threads).map_err(|e| match (&e, sky) {
            (holo_render::Error::Scene(holo_scene::Error::BadScene { at, what }), Some(Sky::Map(sky)))
                if at.starts_with("environment") =>
            {
                Error::Failed(named(sky, &format!("{at}: {what}")))
            }
            _ => blame(scene, e),
        })?;
    let build_seconds = start.elapsed().as_secs_f64();
    report_backend(&renderer, diagnostics);
    Ok(PreparedScene { loaded, framed, renderer, has_automatic_sky, load_seconds, build_seconds })
}

/// Loads a scene and reports its warnings.
pub(crate) fn load(source: &SceneSource, spec: &SceneSpec, diagnostics: &dyn Diagnostics) -> Result<Loaded, Error> {
    if let Some(frames) = spec.frames.filter(|frames| frames.single().is_none()) {
        return Err(Error::BadRequest(format!("--frame {frames} is of several images; render one at a time")));
    }
    let loaded = source.load(spec).map_err(|e| match e {
        holo_scene::Error::Read { .. } => Error::Failed(e.to_string()),
        other => Error::Failed(named(source.path(), &other.to_string())),
    })?;
    loaded.warnings.iter().for_each(|warning| diagnostics.report(About::Scene, &format!("warning: {warning}")));
    Ok(loaded)
}

/// Loads a scene and chooses its camera, without warnings and without a renderer.
pub(crate) fn load_frame(
    (source, spec): (&SceneSource, &SceneSpec),
    rig: &RigSpec,
    shape: LightFieldShape,
) -> Result<(Scene, Framed), Error> {
    let loaded = load(source, spec, &())?;
    let framed = frame(source.path(), &loaded, rig, shape, &())?;
    Ok((loaded.scene, framed))
}

/// The camera of the scene with the intrinsics and the baseline of the rig.
fn frame(
    scene: &Path,
    loaded: &Loaded,
    rig: &RigSpec,
    shape: LightFieldShape,
    diagnostics: &dyn Diagnostics,
) -> Result<Framed, Error> {
    let baseline = match rig.baseline_m {
        Some(baseline) => Baseline::Meters(baseline),
        None => Baseline::FNumber(rig.f_number_or_default()),
    };
    let framing = Framing::new(shape)
        .camera(camera(rig.camera.as_ref(), loaded))
        // Divided, because 1e-3 is not exact: 36 mm times it is not 0.036 m.
        .focal_length_m(rig.focal_mm.map(|mm| mm / 1e3))
        .sensor_size_m(rig.sensor_mm / 1e3)
        .baseline(baseline)
        .projection(rig.projection);
    let framed = framing.frame(&loaded.scene).map_err(|e| match e {
        // No camera was requested: the file has no suitable one.
        holo_render::Error::BadSetting(why) if rig.camera.is_none() => Error::Failed(named(scene, &why)),
        other => blame(scene, other),
    })?;
    if loaded.scene.cameras.is_empty() {
        diagnostics.report(About::Scene, &format!("warning: {}", framed.camera));
    }
    Ok(framed)
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
        spec: &SceneSpec,
        rig: &RigSpec,
        engine: &EngineSpec,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Prepared, Error> {
        let purpose = Purpose { lens_bytes: 2 * size_of::<f32>(), ..Purpose::default() };
        prepare((self, spec), rig, engine, purpose, diagnostics)
    }
}

/// Reports if another backend is used than the requested one.
pub(crate) fn report_backend(renderer: &Renderer, diagnostics: &dyn Diagnostics) {
    if let Some(note) = renderer.engine_note() {
        diagnostics.report(About::Setup, &format!("warning: {note}"));
    }
}

/// The choice of the camera: a number is an index, unless a camera has that name.
fn camera(requested: Option<&String>, loaded: &Loaded) -> CameraChoice {
    let Some(text) = requested else { return CameraChoice::First };
    match text.parse::<usize>() {
        Ok(index) if loaded.scene.cameras.iter().all(|c| c.name != *text) => CameraChoice::Index(index),
        _ => CameraChoice::Name(text.clone()),
    }
}

/// Converts an error of the renderer. If it may be caused by numbers of the scene file, its message names the file.
pub(crate) fn blame(scene: &Path, error: holo_render::Error) -> Error {
    let numbers = matches!(error, holo_render::Error::Scene(_) | holo_render::Error::Core(_));
    match Error::from(error) {
        error if numbers && !error.is_bad_request() => Error::Failed(named(scene, &error.to_string())),
        error => error,
    }
}

/// A message with the path of a file in front, unless it begins with that already.
fn named(scene: &Path, message: &str) -> String {
    let name = scene.display().to_string();
    if message.starts_with(&format!("{name}: ")) { message.into() } else { format!("{name}: {message}") }
}

/// Allocates the memory that a render needs and frees it untouched, so that impossible sizes are refused first.
fn validate_memory(shape: &LightFieldShape, purpose: Purpose) -> Result<(), Error> {
    /// Room for tables over the rows and columns of lenses and views.
    const LINE_BYTES: usize = 64;
    let (views, lenses, raw) = (shape.views(), shape.lenses(), shape.raw_size());
    let lines = [views.rows, views.columns, lenses.rows, lenses.columns];
    let bytes = lines.iter().map(|count| count.saturating_mul(LINE_BYTES)).fold(
        shape
            .sample_count()
            .saturating_mul(purpose.sample_bytes)
            .saturating_add(lenses.count().saturating_mul(purpose.lens_bytes)),
        usize::saturating_add,
    );
    let mut room = Vec::<u8>::new();
    let refused = room.try_reserve_exact(bytes).is_err();
    // Otherwise the compiler may remove the allocation.
    std::hint::black_box(&room);
    if refused {
        return Err(Error::BadRequest(format!(
            "a light field of {} x {} views of {} x {} px ({} x {} in all) needs {:.0} GB of memory, more than there \
             is; use fewer views or lenses",
            views.columns,
            views.rows,
            lenses.columns,
            lenses.rows,
            raw.columns,
            raw.rows,
            bytes as f64 / 1e9
        )));
    }
    Ok(())
}

fn shape(rig: &RigSpec, diagnostics: &dyn Diagnostics) -> Result<LightFieldShape, Error> {
    shifted(rig, unshifted(rig, diagnostics)?)
}

/// The microlenses of an array in all of its positions.
pub(crate) fn shifted(rig: &RigSpec, shape: LightFieldShape) -> Result<LightFieldShape, Error> {
    let Some(shifts) = rig.lens_shifts else { return Ok(shape) };
    if shifts == 0 {
        return Err(Error::BadRequest("--lens-shifts is a number of positions; give 1 or more".into()));
    }
    let more = |count: usize| count.saturating_mul(shifts as usize);
    let lenses = shape.lenses();
    Ok(LightFieldShape::new(rig.views, GridSize::new(more(lenses.rows), more(lenses.columns)))?)
}

/// The same with the microlens array in one position.
fn unshifted(rig: &RigSpec, diagnostics: &dyn Diagnostics) -> Result<LightFieldShape, Error> {
    if let Some(lenses) = rig.lenses {
        return Ok(LightFieldShape::new(rig.views, lenses)?);
    }
    let divided = rig.sensor.divide(rig.views, Remainder::Crop)?;
    let border = divided.border;
    if (border.rows, border.columns) != (0, 0) {
        let size = rig.sensor.size();
        let note = format!(
            "note: {} x {} views leave {} columns and {} rows of the {} x {} sensor unused",
            rig.views.columns, rig.views.rows, border.columns, border.rows, size.columns, size.rows
        );
        diagnostics.report(About::Setup, &note);
    }
    Ok(divided.shape)
}
