//! Renders: into memory, and into folders as the command line does.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;

use holo_core::{LightFieldOwned, Sample};
use holo_dataset::settings::word;
use holo_dataset::{About, Camera, Checkpoints, Diagnostics, Event, RenderJob, Rendering, RunOptions, Shard};
use holo_render::{Layer, Layers, Motion, RayCounts};
use ndarray::{Array, Array3, Array5, Axis, Dimension};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::give;
use crate::cameras::camera::PlenopticCamera;
use crate::cameras::rig::Rig;
use crate::failure::{Failure, keywords};
use crate::scene::Source;
use crate::watch::Watch;
use crate::{options, watch};

/// Backend and number of threads.
pub type Engine = (String, usize);

/// A result, and the diagnostics on the way to it.
pub type Told<T> = (T, Vec<String>);

/// Renders into arrays.
#[pyfunction]
pub fn render<'py>(
    py: Python<'py>,
    source: Source,
    camera: Option<PlenopticCamera>,
    options: BTreeMap<String, String>,
    preset: Option<String>,
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyDict>, Failure> {
    let camera = camera.map_or_else(Camera::default, |camera| camera.0.into());
    let settings = options::settings(&options, preset.as_deref(), camera, None)?;
    let job = RenderJob::new(source.open()?, settings).engine(options::engine(&engine.0, engine.1)?);
    let work = |watch: &Watch| listening(|tell| job.render(&RunOptions::new().progress(watch).diagnostics(tell)));
    let (rendering, lines) = watch::run(py, progress.as_ref(), work)?;
    let Rendering { rendered, seconds, .. } = rendering;
    let result = PyDict::new(py);
    result.set_item("color", rendered.color.map(|color| give(py, color.into_samples())))?;
    result.set_item("error", rendered.error.map(|error| give_channel(py, error)))?;
    let central = give_layers(py, rendered.central, |image| give_plane(py, image))?;
    if let Some(visibility) = rendering.visibility {
        central.set_item("visibility", give(py, visibility))?;
    }
    for (layer, image) in rendering.raw_layers {
        central.set_item(layer.name(), give(py, image))?;
    }
    let all = rendered.all.map(|all| give_layers(py, all, |field| give_channel(py, field))).transpose()?;
    // Motion of all views may be the only layer.
    let all = if rendering.motion.len() > 1 { Some(all.unwrap_or_else(|| PyDict::new(py))) } else { all };
    if let Some(rig) = rendering.rig {
        give_motion(py, rendering.motion, &rig, &central, all.as_ref())?;
    }
    result.set_item("central", central)?;
    result.set_item("all", all)?;
    result.set_item("rig", rendering.rig.map(Rig))?;
    result.set_item("exposure_ev", rendering.exposure_ev)?;
    result.set_item("integrator", word(&rendered.integrator))?;
    result.set_item("why", rendered.why)?;
    result.set_item("rays", give_rays(py, rendered.rays)?)?;
    result.set_item("samples", rendered.samples)?;
    let times = [("load", seconds.load), ("build", seconds.build), ("render", seconds.render)];
    result.set_item("seconds", BTreeMap::from(times))?;
    result.set_item("diagnostics", lines)?;
    Ok(result)
}

/// What decides the files of a folder beside the options.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct FolderRequest {
    out: PathBuf,
    camera: Option<PlenopticCamera>,
    transforms: Option<PathBuf>,
    transforms_up: String,
    preset: Option<String>,
    shard: Option<String>,
    overwrite: bool,
    checkpoint_seconds: f64,
}

/// The reports of shots as JSON texts, the number of shots that were done already, the names of all files, and diagnostics.
type FolderReport = (Vec<String>, usize, Vec<String>, Vec<String>);

/// Renders into a folder, as the command line does.
#[pyfunction]
pub fn render_folder<'py>(
    py: Python<'py>,
    source: Source,
    options: BTreeMap<String, String>,
    engine: Engine,
    request: FolderRequest,
    progress: Option<Bound<'py, PyAny>>,
) -> Result<FolderReport, Failure> {
    let shard =
        request.shard.as_deref().map(str::parse::<Shard>).transpose().map_err(|why| Failure::Usage(why.to_string()))?;
    let camera = request.camera.map_or_else(Camera::default, |camera| camera.0.into());
    let up = options::world_up(&request.transforms_up)?;
    let poses = request.transforms.as_deref().map(|path| (path, up));
    let settings = options::settings(&options, request.preset.as_deref(), camera, poses)?;
    let job = RenderJob::new(source.open()?, settings)
        .engine(options::engine(&engine.0, engine.1)?)
        .checkpoints(Checkpoints::every_seconds(request.checkpoint_seconds));
    let (out, overwrite) = (request.out, request.overwrite);
    let work = |watch: &Watch| {
        let events = |event: Event| match event {
            Event::Begin(number, of, _) => watch.shots(number, of),
            Event::End(number, of, ..) => watch.shots(number + 1, of),
        };
        let how = RunOptions::new().shard(shard).overwrite(overwrite).progress(watch).events(&events);
        listening(|tell| job.run(&out, &how.clone().diagnostics(tell)))
    };
    let (outcomes, lines) = watch::run(py, progress.as_ref(), work)?;
    let reports: Vec<String> = outcomes.iter().filter_map(|(_, outcome)| Some(outcome.report()?.to_json())).collect();
    let kept = outcomes.len() - reports.len();
    Ok((reports, kept, job.files(&out, &outcomes), lines))
}

/// Does `work` with a receiver of diagnostics, and returns what it received.
pub fn listening<T>(
    work: impl FnOnce(&dyn Diagnostics) -> Result<T, holo_dataset::Error>,
) -> Result<Told<T>, holo_dataset::Error> {
    let lines = RefCell::new(Vec::new());
    let done = work(&|_: About, line: &str| lines.borrow_mut().push(keywords(line)))?;
    Ok((done, lines.into_inner()))
}

fn give_rays(py: Python<'_>, rays: RayCounts) -> Result<Bound<'_, PyDict>, Failure> {
    let dict = PyDict::new(py);
    dict.set_item("primary", rays.primary)?;
    dict.set_item("shadow", rays.shadow)?;
    dict.set_item("other", rays.secondary)?;
    Ok(dict)
}

/// Layers by their names on the command line.
fn give_layers<'py, T>(
    py: Python<'py>,
    mut layers: Layers<T>,
    mut give: impl FnMut(T) -> Bound<'py, PyAny>,
) -> Result<Bound<'py, PyDict>, Failure> {
    let dict = PyDict::new(py);
    for layer in Layer::ALL {
        if let Some(value) = layers.take(layer) {
            dict.set_item(layer.name(), give(value))?;
        }
    }
    Ok(dict)
}

/// Optical and scene flow: of the central view, and of all views as light fields if there is more than one.
fn give_motion<'py>(
    py: Python<'py>,
    motion: Vec<Motion>,
    rig: &holo_core::Rig,
    central: &Bound<'py, PyDict>,
    all: Option<&Bound<'py, PyDict>>,
) -> Result<(), Failure> {
    let shape = rig.shape();
    let (row, column) = shape.central_view();
    let position = if motion.len() > 1 { row * shape.views().columns + column } else { 0 };
    let Some(seen) = motion.get(position) else { return Ok(()) };
    central.set_item("optical-flow", give(py, seen.optical_flow.clone()))?;
    central.set_item("scene-flow", give(py, seen.scene_flow.clone()))?;
    let Some(all) = all.filter(|_| motion.len() > 1) else { return Ok(()) };
    let (lenses, views) = (shape.lenses(), shape.views());
    for (name, channels) in [("optical-flow", 2), ("scene-flow", 3)] {
        let mut field = Array5::zeros((lenses.rows, lenses.columns, views.rows, views.columns, channels));
        for (k, motion) in motion.iter().enumerate() {
            let own = if channels == 2 { &motion.optical_flow } else { &motion.scene_flow };
            // Without its view rows, the view columns are the third axis.
            let mut row = field.index_axis_mut(Axis(2), k / views.columns);
            row.index_axis_mut(Axis(2), k % views.columns).assign(own);
        }
        all.set_item(name, give(py, field))?;
    }
    Ok(())
}

/// An image without its channel axis if it has one channel.
fn give_plane(py: Python<'_>, image: Array3<f32>) -> Bound<'_, PyAny> {
    squeezed(py, image, Axis(2))
}

/// The same for a light field.
fn give_channel<T: Sample + numpy::Element>(py: Python<'_>, field: LightFieldOwned<T>) -> Bound<'_, PyAny> {
    squeezed(py, field.into_samples(), Axis(4))
}

fn squeezed<T: numpy::Element, D: Dimension + ndarray::RemoveAxis>(
    py: Python<'_>,
    array: Array<T, D>,
    channels: Axis,
) -> Bound<'_, PyAny> {
    match array.len_of(channels) {
        1 => give(py, array.index_axis_move(channels, 0)),
        _ => give(py, array),
    }
}
