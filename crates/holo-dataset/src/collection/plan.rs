//! The plan of a dataset: a job for every scene and every number of views, their order, and which of them are done.

use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape, Remainder};
use holo_io::dataset;
use holo_scene::gallery;

use crate::Error;
use crate::describe::index::{self, Entry};
use crate::output::{OutputFolder, Rollback, Wanted};
use crate::resume::Checkpoints;
use crate::settings::{Camera, EngineSettings, Pixels, RenderSettings, texts};
use crate::shot::{RenderJob, RunOptions, Runner, SceneSource, Shot, ShotOutcome, engine_name};
use crate::watch::Diagnostics;

/// The plan of a dataset: its jobs in order.
#[derive(Clone, Debug)]
pub struct DatasetPlan {
    settings: RenderSettings,
    engine: EngineSettings,
    /// The renders of every scene with every number of views.
    renders: Vec<RenderJob>,
    jobs: Vec<DatasetJob>,
}

/// A light field of a dataset: one scene with one number of views, at one frame.
#[derive(Clone, Debug)]
pub struct DatasetJob {
    shape: LightFieldShape,
    source: SceneSource,
    /// The number of its render.
    render: usize,
    shot: Shot,
}

/// Runs the jobs of a dataset. What is chosen by the first frame of a scene is chosen once for all of its frames.
pub struct DatasetRun<'a> {
    plan: &'a DatasetPlan,
    /// Of the render of the last job.
    runner: Option<(usize, Runner<'a>)>,
}

impl DatasetJob {
    /// Returns the name of the scene; of a frame with its number: `pendulum_0012`.
    #[must_use]
    pub fn scene(&self) -> String {
        let name = self.source.name();
        self.shot.frame().map_or(name.clone(), |frame| format!("{name}_{frame:04}"))
    }

    /// Returns the source of the scene.
    #[must_use]
    pub fn source(&self) -> &SceneSource {
        &self.source
    }

    /// Returns the numbers of views and microlenses.
    #[must_use]
    pub fn shape(&self) -> LightFieldShape {
        self.shape
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
    /// Plans a job for every source, every number of views, and every frame if there are several. The settings are those of
    /// all jobs, except for the number of views.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the settings contradict each other or are of another camera than a rig at the pose of its
    /// scene, there is no scene, or views or scene names repeat; [`Error::Core`] if the sensor has fewer pixels than views;
    /// [`Error::Io`] if the name of a scene cannot be a folder name.
    pub fn new(
        sources: &[SceneSource],
        views: &[GridSize],
        settings: RenderSettings,
        engine: EngineSettings,
    ) -> Result<Self, Error> {
        Wanted::new(&settings)?;
        check_names(sources)?;
        let (Camera::Rig(rig), None) = (&settings.camera, settings.poses.cameras()) else {
            return Err(Error::BadRequest(
                "a dataset is of rigs that stand where the cameras of its scenes stand".into(),
            ));
        };
        let Pixels::Sensor(sensor) = rig.pixels else {
            return Err(Error::BadRequest(
                "a dataset divides one sensor by several numbers of views; give `sensor`".into(),
            ));
        };
        let mut shapes: Vec<LightFieldShape> = Vec::new();
        for &views in views {
            if shapes.iter().any(|shape| shape.views() == views) {
                return Err(Error::BadRequest(format!("`views` has {views} twice")));
            }
            shapes.push(sensor.divide(views, Remainder::Crop)?.shape);
        }
        let (mut renders, mut jobs) = (Vec::new(), Vec::new());
        for source in sources {
            for &shape in &shapes {
                let mut rig = rig.clone();
                rig.views = shape.views();
                let settings = RenderSettings { camera: rig.into(), ..settings.clone() };
                let render = RenderJob::new(source.clone(), settings).engine(engine);
                jobs.extend(render.shots().into_iter().map(|shot| DatasetJob {
                    shape,
                    source: source.clone(),
                    render: renders.len(),
                    shot,
                }));
                renders.push(render);
            }
        }
        Ok(Self { settings, engine, renders, jobs })
    }

    /// Sets how often and where finished parts of every job are kept; `None`: not at all.
    #[must_use]
    pub fn checkpoints(mut self, checkpoints: Option<&Checkpoints>) -> Self {
        self.renders.iter_mut().for_each(|render| render.checkpoints = checkpoints.cloned());
        self
    }

    /// Returns the jobs, scene by scene; the same list on every machine.
    #[must_use]
    pub fn jobs(&self) -> &[DatasetJob] {
        &self.jobs
    }

    /// Creates the root folder and writes `dataset.json` and `DATASET.md` into it: before the jobs, so that an
    /// unfinished dataset can be verified too.
    ///
    /// # Errors
    /// [`Error::Failed`] or [`Error::Io`] if folder or files cannot be written; [`Error::Render`] if the requested backend
    /// is not available.
    pub fn describe(&self, root: &Path, diagnostics: &dyn Diagnostics, rollback: &Rollback) -> Result<(), Error> {
        let backend = engine_name(&self.engine, diagnostics)?;
        let folder = OutputFolder::create_plain(root, rollback)?;
        let mut entries = Vec::with_capacity(self.jobs.len());
        let mut digest = (usize::MAX, String::new());
        for job in &self.jobs {
            if digest.0 != job.render {
                digest = (job.render, job.source.sha256()?.to_string());
            }
            let (name, scene, sha256) = (job.scene(), job.source.name(), digest.1.clone());
            entries.push(Entry { name, scene, sha256, shape: job.shape });
        }
        let mut options = texts(&self.settings);
        // Every light field has its own.
        options.remove("views");
        index::write(folder.folder(), &entries, &options, &backend)?;
        folder.keep();
        Ok(())
    }

    /// Returns what runs the jobs.
    #[must_use]
    pub fn run(&self) -> DatasetRun<'_> {
        DatasetRun { plan: self, runner: None }
    }
}

impl DatasetRun<'_> {
    /// Runs one job in its folder below `root`, unless the folder is up to date. Another image in it is replaced.
    ///
    /// # Errors
    /// As [`RenderJob::run`].
    pub fn job(&mut self, job: &DatasetJob, root: &Path, options: &RunOptions) -> Result<ShotOutcome, Error> {
        let runner = match self.runner.take() {
            Some((render, runner)) if render == job.render => runner,
            _ => Runner::new(&self.plan.renders[job.render], options.diagnostics_of())?,
        };
        let outcome = runner.run_shot(&job.shot, root, &job.folder()?, options);
        self.runner = Some((job.render, runner));
        outcome
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
            return Err(Error::Failed(format!("{}: there is no such scene file; see `glb`", path.display())));
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
        return Err(Error::BadRequest("no scene: omit `scenes` for all scenes of the gallery, or give `glb`".into()));
    }
    Ok(())
}
