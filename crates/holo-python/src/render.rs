//! Renders: into memory, and into folders as the command line does.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;

use holo_core::{LightFieldOwned, Sample};
use holo_dataset::options::{Options, integrator_name};
use holo_dataset::{
    About, CancelOnly, Checkpoints, Diagnostics, ImageJob, ImageReport, JobOutcome, PartProgress, RawJob, RenderJob,
    Rollback, SequenceJob, Shard, Tool,
};
use holo_io::dataset::SEQUENCE_HDF5;
use holo_render::{Backend, Layer, Layers, Motion, Progress, RayCounts};
use ndarray::{Array, Array3, Array5, Axis, Dimension};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

use crate::arrays::{give, give_json};
use crate::camera::PlenopticCamera;
use crate::failure::Failure;
use crate::rig::Rig;
use crate::scene::Source;
use crate::{options, watch};

/// Backend and number of threads.
pub type Engine = (String, usize);

/// A result, and the diagnostics on the way to it.
type Told<T> = (T, Vec<String>);

/// Why Embree cannot be used; None if it can.
#[pyfunction]
pub fn missing_embree() -> Option<String> {
    Backend::find_embree().err().map(|why| why.to_string())
}

/// Renders into arrays.
#[pyfunction]
pub fn render<'py>(
    py: Python<'py>,
    source: Source,
    options: BTreeMap<String, String>,
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyDict>, Failure> {
    let engine = options::engine(&engine.0, engine.1)?;
    let job = RenderJob::new(source.open()?, options::spec(&options)?).with_engine(engine);
    let (rendering, lines) = watch::run(py, progress.as_ref(), |watch| listening(|tell| job.render(watch, tell)))?;
    let (rendered, seconds) = (rendering.rendered, rendering.seconds);
    let result = PyDict::new(py);
    result.set_item("color", rendered.color.map(|color| give(py, color.into_samples())))?;
    result.set_item("error", rendered.error.map(|error| give_channel(py, error)))?;
    let central = give_layers(py, rendered.central, |image| give_plane(py, image))?;
    if let Some(visibility) = rendering.visibility {
        central.set_item("visibility", give(py, visibility))?;
    }
    let rig = rendering.rig;
    let all = rendered.all.map(|all| give_layers(py, all, |field| give_channel(py, field))).transpose()?;
    // Motion of all views may be the only layer.
    let all = if rendering.motion.len() > 1 { Some(all.unwrap_or_else(|| PyDict::new(py))) } else { all };
    give_motion(py, rendering.motion, &rig, &central, all.as_ref())?;
    result.set_item("central", central)?;
    result.set_item("all", all)?;
    result.set_item("rig", Rig(rig))?;
    result.set_item("exposure_ev", rendering.exposure_ev)?;
    result.set_item("integrator", integrator_name(rendered.integrator))?;
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
    tools: Vec<String>,
    shard: Option<String>,
    overwrite: bool,
    checkpoint_seconds: f64,
}

/// Renders into a folder, as the command line does, and returns its report.
#[pyfunction]
pub fn render_folder<'py>(
    py: Python<'py>,
    source: Source,
    options: BTreeMap<String, String>,
    engine: Engine,
    request: FolderRequest,
    progress: Option<Bound<'py, PyAny>>,
) -> Result<(Bound<'py, PyAny>, Vec<String>), Failure> {
    let shard = request.shard.as_deref().map(str::parse::<Shard>).transpose().map_err(Failure::Usage)?;
    let (spec, engine) = (options::spec(&options)?, options::engine(&engine.0, engine.1)?);
    // As the command line keeps them: what was given, and the defaults of the rest.
    let mut words: Options = spec.to_options();
    words.extend(options);
    if words.contains_key("lenses") {
        words.remove("sensor");
    }
    let source = source.open()?;
    let place = Place { out: request.out, shard, overwrite: request.overwrite };
    let (report, lines) = if let Some(camera) = request.camera {
        let mut job = RawJob::new(source, camera.0, spec).with_options(words);
        job.engine = engine;
        job.tools = request.tools.iter().map(|name| tool(name)).collect::<Result<_, _>>()?;
        watch::run(py, progress.as_ref(), |watch| listening(|tell| place.fill(job, watch, tell)))?
    } else {
        let checkpoints = Checkpoints::every_seconds(request.checkpoint_seconds);
        let job = RenderJob::new(source, spec).with_options(words).with_engine(engine).with_checkpoints(checkpoints);
        watch::run(py, progress.as_ref(), |watch| listening(|tell| place.fill(job, watch, tell)))?
    };
    Ok((give_json(py, &report)?, lines))
}

/// Where an image goes, or the frames of a sequence.
struct Place {
    out: PathBuf,
    shard: Option<Shard>,
    overwrite: bool,
}

impl Place {
    /// Renders into it, and returns the report.
    fn fill(
        &self,
        job: impl ImageJob,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Value, holo_dataset::Error> {
        let Self { out, shard, overwrite } = self;
        let rollback = Rollback::default();
        if job.spec().scene.frames.is_none_or(|frames| frames.single().is_some()) {
            if !overwrite {
                job.check_replaceable(out, *shard)?;
            }
            return Ok(job.run(out, *shard, progress, diagnostics, &rollback)?.to_json());
        }
        if !overwrite {
            SequenceJob::check_replaceable(&job, out)?;
        }
        let sequence = SequenceJob::new(job, &CancelOnly(progress), diagnostics)?;
        let frames: Vec<u32> = sequence.frames(*shard).collect();
        let mut reports = Vec::with_capacity(frames.len());
        for (k, &frame) in frames.iter().enumerate() {
            let part = PartProgress { inner: progress, k, of: frames.len() };
            if let JobOutcome::Made(report, _) = sequence.run_frame(frame, out, &part, diagnostics, &rollback)? {
                let mut report = report.to_json();
                report["frame"] = frame.into();
                reports.push(report);
            }
        }
        let files: &[&str] = if sequence.finish(out)? { &[SEQUENCE_HDF5] } else { &[] };
        Ok(json!({"made": reports.len(), "kept": frames.len() - reports.len(), "files": files, "frames": reports}))
    }
}

fn tool(name: &str) -> Result<Tool, Failure> {
    let known: Vec<(&str, Tool)> = Tool::ALL.iter().map(|tool| (tool.name(), *tool)).collect();
    options::choice("tools", name, &known)
}

/// Renders the raw image of a plenoptic camera into arrays.
#[pyfunction]
pub fn render_raw<'py>(
    py: Python<'py>,
    source: Source,
    camera: PlenopticCamera,
    options: BTreeMap<String, String>,
    engine: Engine,
    progress: Option<Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyDict>, Failure> {
    let mut job = RawJob::new(source.open()?, camera.0, options::spec(&options)?);
    job.engine = options::engine(&engine.0, engine.1)?;
    let ((rendered, others), lines) =
        watch::run(py, progress.as_ref(), |watch| listening(|tell| job.render(watch, tell)))?;
    let result = PyDict::new(py);
    result.set_item("color", rendered.color.map(|color| give(py, color)))?;
    let layers = give_layers(py, rendered.layers, |image| give_plane(py, image))?;
    for (layer, image) in others {
        layers.set_item(layer.name(), give(py, image))?;
    }
    result.set_item("layers", layers)?;
    result.set_item("integrator", integrator_name(rendered.integrator))?;
    result.set_item("why", rendered.why)?;
    result.set_item("rays", give_rays(py, rendered.rays)?)?;
    result.set_item("diagnostics", lines)?;
    Ok(result)
}

/// Does `work` with a receiver of diagnostics, and returns what it received.
fn listening<T>(
    work: impl FnOnce(&dyn holo_dataset::Diagnostics) -> Result<T, holo_dataset::Error>,
) -> Result<Told<T>, holo_dataset::Error> {
    let lines = RefCell::new(Vec::new());
    let done = work(&|_: About, line: &str| lines.borrow_mut().push(line.to_owned()))?;
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
