//! The plan of a dataset: a job for every scene and every number of views, their order, and which of them are done.

use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape, Remainder};
use holo_io::dataset;
use holo_render::{Progress, Renderer};
use holo_scene::gallery;

use crate::checkpoint::Checkpoints;
use crate::diagnostics::Diagnostics;
use crate::files::validate;
use crate::job::RenderJob;
use crate::options::Options;
use crate::outcome::{JobOutcome, done};
use crate::output_folder::{OutputFolder, Rollback};
use crate::parts::CancelOnly;
use crate::sequence::SequenceJob;
use crate::source::SceneSource;
use crate::spec::{EngineSpec, Frames, RenderSpec};
use crate::{Error, describe, prepare};

/// The plan of a dataset: its jobs in order.
#[derive(Clone, Debug)]
pub struct DatasetPlan {
    /// The specification of all jobs, except for the number of views.
    pub spec: RenderSpec,
    /// The options of `spec` that were requested, for manifests and `dataset.json`.
    pub options: Options,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSpec,
    /// The jobs, scene by scene; the same list on every machine.
    pub jobs: Vec<DatasetJob>,
}

/// A job of a dataset: one scene with one number of views.
#[derive(Clone, Debug)]
pub struct DatasetJob {
    /// Numbers of views and microlenses.
    pub shape: LightFieldShape,
    /// The render. Of a frame, its specification has all frames of the sequence.
    pub render: RenderJob,
    /// The number of the frame, if it is one of several.
    pub frame: Option<u32>,
}

impl DatasetJob {
    /// Returns the name of the scene; of a frame with its number: `pendulum_0012`.
    #[must_use]
    pub fn scene(&self) -> String {
        let name = self.render.source.name();
        self.frame.map_or(name.clone(), |frame| format!("{name}_{frame:04}"))
    }

    /// Returns the name of the job, such as `garden 20x20` with views as columns x rows.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.scene(), self.shape.views())
    }

    /// Returns the folder of the job, relative to the root of the dataset.
    ///
    /// # Errors
    /// [`Error::Io`] if the name of the scene cannot be a folder name.
    pub fn folder(&self) -> Result<PathBuf, Error> {
        Ok(dataset::folder(&self.scene(), self.shape.views())?)
    }
}

impl DatasetPlan {
    /// Plans a job for every source, every frame if there are several, and every number of views. `options` are the options of `spec` that were requested.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the specification contradicts itself, there is no scene, or views or scene names
    /// repeat; [`Error::Core`] if the sensor has fewer pixels than views; [`Error::Io`] if the name of a scene cannot
    /// be a folder name.
    pub fn new(
        sources: &[SceneSource],
        views: &[GridSize],
        spec: RenderSpec,
        options: Options,
        engine: EngineSpec,
    ) -> Result<Self, Error> {
        validate(&spec)?;
        check_names(sources)?;
        let mut shapes: Vec<LightFieldShape> = Vec::new();
        for &views in views {
            if shapes.iter().any(|shape| shape.views() == views) {
                return Err(Error::BadRequest(format!("--views has {} twice", views)));
            }
            shapes.push(spec.rig.sensor.divide(views, Remainder::Crop)?.shape);
        }
        let mut jobs = Vec::new();
        for source in sources {
            for &shape in &shapes {
                let mut spec = spec.clone();
                spec.rig.views = shape.views();
                let mut texts = spec.to_options();
                texts.extend(options.clone());
                texts.insert("views".into(), shape.views().to_string());
                let sequence = spec.scene.frames.filter(|frames| frames.single().is_none());
                let render = RenderJob::new(source.clone(), spec).with_options(texts).with_engine(engine);
                match sequence {
                    None => jobs.push(DatasetJob { shape, render, frame: None }),
                    Some(Frames { first, last }) => jobs.extend((first..=last).map(|k| DatasetJob {
                        shape,
                        render: render.clone(),
                        frame: Some(k),
                    })),
                }
            }
        }
        let options = crate::options::without_paths(options, &spec);
        Ok(Self { spec, options, engine, jobs })
    }

    /// Sets how often and where finished parts of every job are kept; `None`: not at all.
    #[must_use]
    pub fn with_checkpoints(mut self, checkpoints: Option<&Checkpoints>) -> Self {
        self.jobs.iter_mut().for_each(|job| job.render.checkpoints = checkpoints.cloned());
        self
    }

    /// Returns the ray tracing backend of all jobs with its version, as manifests contain it.
    ///
    /// # Errors
    /// [`Error::Render`] if the requested backend is not available.
    pub fn backend(&self, diagnostics: &dyn Diagnostics) -> Result<String, Error> {
        let empty = holo_scene::Scene::default();
        let renderer = Renderer::new(&empty, &holo_scene::Transform::IDENTITY, self.engine.backend, 1)?;
        prepare::report_backend(&renderer, diagnostics);
        Ok(renderer.engine_name().to_owned())
    }

    /// Creates the root folder and writes `dataset.json` and `DATASET.md` into it: before the jobs, so that an
    /// unfinished dataset can be verified too.
    ///
    /// # Errors
    /// [`Error::Failed`] or [`Error::Io`] if folder or files cannot be written.
    pub fn describe(&self, root: &Path, backend: &str, rollback: &Rollback) -> Result<(), Error> {
        let folder = OutputFolder::create_plain(root, rollback)?;
        let jobs: Vec<_> = self.jobs.iter().map(|job| (job.scene(), &job.render.source, job.shape)).collect();
        describe::write(root, &jobs, &self.options, backend)?;
        folder.keep();
        Ok(())
    }

    /// Runs one job in its folder below `root`, unless the folder is up to date.
    ///
    /// # Errors
    /// As [`RenderJob::run`].
    pub fn run_job(
        &self,
        job: &DatasetJob,
        root: &Path,
        backend: &str,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<JobOutcome, Error> {
        let out = root.join(job.folder()?);
        let mut identity = job.render.clone();
        identity.spec.scene.frames = job.frame.map(Frames::one).or(identity.spec.scene.frames);
        let why = match done(&out, &identity.identity(backend)?) {
            Ok(manifest) => return Ok(JobOutcome::Kept(Box::new(manifest))),
            Err(why) => why,
        };
        let report = match job.frame {
            None => job.render.run(&out, None, progress, diagnostics, rollback)?,
            Some(frame) => {
                let sequence = SequenceJob::new(job.render.clone(), &CancelOnly(progress), &())?;
                sequence.frame(frame).run(&out, None, progress, diagnostics, rollback)?
            }
        };
        Ok(JobOutcome::Made(Box::new(report), why))
    }
}

/// Returns the scenes of a dataset: scenes of the gallery by name (`None`: all), then files.
///
/// # Errors
/// [`Error::BadRequest`] if the gallery has no scene of a name; [`Error::Failed`] if a file does not exist.
pub fn sources(names: Option<&[String]>, files: &[PathBuf]) -> Result<Vec<SceneSource>, Error> {
    let names: Vec<&str> = match names {
        None => gallery::NAMES.to_vec(),
        Some(names) => names.iter().map(String::as_str).collect(),
    };
    let mut sources = names.into_iter().map(SceneSource::gallery).collect::<Result<Vec<_>, _>>()?;
    for path in files {
        if !path.is_file() {
            return Err(Error::Failed(format!("{}: there is no such scene file; see --glb", path.display())));
        }
        sources.push(SceneSource::File(path.clone()));
    }
    Ok(sources)
}

/// Checks that every scene has a unique folder.
fn check_names(sources: &[SceneSource]) -> Result<(), Error> {
    for (index, source) in sources.iter().enumerate() {
        let name = source.name();
        if sources[..index].iter().any(|other| other.name() == name) {
            return Err(Error::BadRequest(format!(
                "two scenes have the name '{name}' and would share a folder; rename one"
            )));
        }
        // Before anything is rendered.
        dataset::folder(&name, GridSize::new(1, 1))?;
    }
    if sources.is_empty() {
        return Err(Error::BadRequest("no scene: omit --scenes for all scenes of the gallery, or give --glb".into()));
    }
    Ok(())
}
