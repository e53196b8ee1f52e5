//! From a specification to a renderer and a rig.

use std::path::Path;
use std::time::Instant;

use holo_core::{LightFieldShape, Remainder, Rig};
use holo_render::{Baseline, CameraChoice, Framed, Framing, Renderer};
use holo_scene::Environment;
use holo_scene::gltf::Loaded;

use crate::diagnostics::{About, Diagnostics};
use crate::source::SceneSource;
use crate::spec::{EngineSpec, Focus, RigSpec};
use crate::{Error, sky};

/// A scene ready to be rendered.
pub struct Prepared {
    /// The scene and what its file says.
    pub loaded: Loaded,
    /// The camera.
    pub framed: Framed,
    /// The scene with its acceleration structure.
    pub renderer: Renderer,
    /// The cameras of all views.
    pub rig: Rig,
    /// Wall-clock time that reading the scene took.
    pub load_seconds: f64,
    /// Wall-clock time that building the acceleration structure took.
    pub build_seconds: f64,
}

/// What a command is going to do with the scene.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Purpose<'a> {
    /// An environment map to put around it.
    pub sky: Option<&'a Path>,
    /// What will be kept of every sample of the light field, bytes.
    pub sample_bytes: usize,
    /// What will be kept of every pixel of the central view, bytes.
    pub lens_bytes: usize,
}

/// Loads and frames the scene, builds the acceleration structure and settles the focus.
///
/// # Errors
/// A scene that cannot be read, numbers that no rig can have, a light field that does not fit into memory.
pub(crate) fn prepare(
    source: &SceneSource,
    rig: &RigSpec,
    engine: &EngineSpec,
    purpose: Purpose,
    diagnostics: &dyn Diagnostics,
) -> Result<Prepared, Error> {
    let shape = shape(rig, diagnostics)?;
    validate_memory(&shape, purpose)?;
    let start = Instant::now();
    let scene = source.path();
    let mut loaded = source.load().map_err(|e| match e {
        holo_scene::Error::Read { .. } => Error::Failed(e.to_string()),
        other => Error::Failed(named(scene, &other.to_string())),
    })?;
    if let Some(path) = purpose.sky {
        loaded.scene.environment = Some(Environment { radiance: sky::read(path)? });
    }
    let load_seconds = start.elapsed().as_secs_f64();
    loaded.warnings.iter().for_each(|warning| diagnostics.report(About::Scene, &format!("warning: {warning}")));
    let baseline = match rig.baseline_m {
        Some(baseline) => Baseline::Meters(baseline),
        None => Baseline::FNumber(rig.f_number_or_default()),
    };
    let framing = Framing::new(shape)
        .camera(camera(rig.camera.as_ref(), &loaded))
        // Divided, because 1e-3 is not exact: 36 mm times it is not 0.036 m.
        .focal_length_m(rig.focal_mm.map(|mm| mm / 1e3))
        .sensor_size_m(rig.sensor_mm / 1e3)
        .baseline(baseline)
        .projection(rig.projection);
    let framed = framing.frame(&loaded.scene).map_err(|e| match e {
        // Nobody chose this camera: it is the file that has none that will do.
        holo_render::Error::BadSetting(why) if rig.camera.is_none() => Error::Failed(named(scene, &why)),
        other => blame(scene, other),
    })?;
    if loaded.scene.cameras.is_empty() {
        diagnostics.report(About::Scene, &format!("warning: {}", framed.camera));
    }
    let start = Instant::now();
    let renderer = Renderer::new(&loaded.scene, &framed.pose, engine.backend, engine.threads).map_err(|e| {
        match (&e, purpose.sky) {
            (holo_render::Error::Scene(holo_scene::Error::BadScene { at, what }), Some(sky))
                if at.starts_with("environment") =>
            {
                Error::Failed(named(sky, &format!("{at}: {what}")))
            }
            _ => blame(scene, e),
        }
    })?;
    let build_seconds = start.elapsed().as_secs_f64();
    report_backend(&renderer, diagnostics);
    let focus = match rig.focus {
        Focus::Meters(distance) => distance,
        Focus::Automatic => renderer.automatic_focus_m(&framed).map_err(|e| blame(scene, e))?,
    };
    let rig = framed.rig(focus).map_err(|e| blame(scene, e))?;
    Ok(Prepared { loaded, framed, renderer, rig, load_seconds, build_seconds })
}

impl SceneSource {
    /// Loads and frames the scene, builds the acceleration structure and settles the focus, ready for depth and disparity of
    /// the central view.
    ///
    /// # Errors
    /// A scene that cannot be read, numbers that no rig can have.
    pub fn prepare(
        &self,
        rig: &RigSpec,
        engine: &EngineSpec,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Prepared, Error> {
        let purpose = Purpose { lens_bytes: 2 * size_of::<f32>(), ..Purpose::default() };
        prepare(self, rig, engine, purpose, diagnostics)
    }
}

/// Reports which backend stands in for the one that was requested.
pub(crate) fn report_backend(renderer: &Renderer, diagnostics: &dyn Diagnostics) {
    if let Some(note) = renderer.engine_note() {
        diagnostics.report(About::Setup, &format!("warning: {note}"));
    }
}

/// A number chooses by index unless a camera has that very name.
fn camera(requested: Option<&String>, loaded: &Loaded) -> CameraChoice {
    let Some(text) = requested else { return CameraChoice::First };
    match text.parse::<usize>() {
        Ok(index) if loaded.scene.cameras.iter().all(|c| c.name != *text) => CameraChoice::Index(index),
        _ => CameraChoice::Name(text.clone()),
    }
}

/// The failure behind an error; numbers that come from the scene file, alone or with the options, name it.
fn blame(scene: &Path, error: holo_render::Error) -> Error {
    let numbers = matches!(error, holo_render::Error::Scene(_) | holo_render::Error::Core(_));
    match Error::from(error) {
        error if numbers && !error.is_bad_request() => Error::Failed(named(scene, &error.to_string())),
        error => error,
    }
}

/// A message that begins with the name of the scene file, once.
fn named(scene: &Path, message: &str) -> String {
    let name = scene.display().to_string();
    if message.starts_with(&format!("{name}: ")) { message.into() } else { format!("{name}: {message}") }
}

/// Asks for the memory that a render will need and gives it back untouched, so that impossible sizes are refused before
/// any time is spent on them.
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
    // Unseen, a compiler may leave out the request.
    std::hint::black_box(&room);
    if refused {
        return Err(Error::BadRequest(format!(
            "a light field of {} x {} views of {} x {} px ({} x {} in all) needs {:.0} GB of memory, more than there is; \
             use fewer views or lenses",
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
