//! From options to a renderer and a rig: what `render` and `info` have in common.

use std::path::Path;
use std::time::Instant;

use holo_core::{Projection, Remainder, Rig, Split};
use holo_render::gltf::{self, Limits, Loaded};
use holo_render::{Backend, Baseline, CameraChoice, Framed, Framing, Renderer};

use crate::arguments::{BackendArgument, CameraArgument, EngineOptions, FocusArgument, ProjectionArgument, RigOptions};
use crate::failure::Failure;

/// A scene ready to be rendered.
pub struct Prepared {
    pub loaded: Loaded,
    pub framed: Framed,
    pub renderer: Renderer,
    pub rig: Rig,
    pub load_seconds: f64,
    pub build_seconds: f64,
}

/// Loads and frames the scene, builds the acceleration structure and settles the focus. Warnings go to standard error.
pub fn prepare(scene: &Path, rig: &RigOptions, engine: &EngineOptions, quiet: bool) -> Result<Prepared, Failure> {
    let split = split(rig, quiet)?;
    let start = Instant::now();
    let loaded = gltf::load(scene, &Limits::default()).map_err(|e| match e {
        holo_render::Error::Read { .. } => Failure::Failed(e.to_string()),
        other => Failure::Failed(format!("{}: {other}", scene.display())),
    })?;
    let load_seconds = start.elapsed().as_secs_f64();
    if !quiet {
        loaded.warnings.iter().for_each(|warning| say!("warning: {warning}"));
    }
    let framing = Framing {
        split,
        camera: camera(rig.camera.as_ref(), &loaded),
        focal_length_m: rig.focal_mm.map(|mm| mm * 1e-3),
        sensor_size_m: rig.sensor_mm * 1e-3,
        baseline: match rig.baseline_m {
            Some(baseline) => Baseline::Metres(baseline),
            None => Baseline::FNumber(rig.f_number.unwrap_or(5.0)),
        },
        projection: match rig.projection {
            ProjectionArgument::Perspective => Projection::Perspective,
            ProjectionArgument::Orthographic => Projection::Orthographic,
        },
    };
    let framed = framing.frame(&loaded.scene)?;
    if !quiet && loaded.scene.cameras.is_empty() {
        say!("warning: {}", framed.camera);
    }
    let start = Instant::now();
    let backend = match engine.backend {
        BackendArgument::Auto => Backend::Auto,
        BackendArgument::Embree => Backend::Embree,
        BackendArgument::Bvh => Backend::Bvh,
    };
    let renderer = Renderer::new(&loaded.scene, &framed.pose, backend, usize::from(engine.threads.unwrap_or(0)))?;
    let build_seconds = start.elapsed().as_secs_f64();
    if let Some(note) = renderer.engine_note().filter(|_| !quiet) {
        say!("warning: {note}");
    }
    let focus = match rig.focus_m {
        FocusArgument::Metres(distance) => distance,
        FocusArgument::Automatic => framed.automatic_focus_m(&renderer)?,
    };
    let rig = framed.rig(focus)?;
    Ok(Prepared { loaded, framed, renderer, rig, load_seconds, build_seconds })
}

/// A number chooses by index unless a camera has that very name.
fn camera(wanted: Option<&CameraArgument>, loaded: &Loaded) -> CameraChoice {
    let Some(CameraArgument(text)) = wanted else { return CameraChoice::First };
    match text.parse::<usize>() {
        Ok(index) if loaded.scene.cameras.iter().all(|c| c.name != *text) => CameraChoice::Index(index),
        _ => CameraChoice::Name(text.clone()),
    }
}

fn split(rig: &RigOptions, quiet: bool) -> Result<Split, Failure> {
    if let Some(lenses) = rig.lenses {
        return Ok(Split::new(rig.views, lenses)?);
    }
    let divided = rig.sensor.split(rig.views, Remainder::Crop)?;
    let border = divided.border;
    if !quiet && (border.rows, border.columns) != (0, 0) {
        let size = rig.sensor.size();
        say!(
            "note: {} x {} views leave {} columns and {} rows of the {} x {} sensor unused",
            rig.views.columns,
            rig.views.rows,
            border.columns,
            border.rows,
            size.columns,
            size.rows
        );
    }
    Ok(divided.split)
}
