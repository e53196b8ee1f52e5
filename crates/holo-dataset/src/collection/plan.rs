//! The plan of a dataset: a job for every scene, pose, frame and camera, their order, and which of them are done.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use holo_core::GridSize;
use holo_io::WorldUp;
use holo_io::dataset::{self, DatasetCamera, DatasetPoses};
use holo_scene::gallery;

use super::cameras::{self, DatasetCameras};

use crate::Error;
use crate::describe::index::{self, Entry};
use crate::output::{OutputFolder, Rollback, poses};
use crate::resume::Checkpoints;
use crate::settings::{EngineSettings, Poses, RenderSettings, texts};
use crate::shot::{RenderJob, RunOptions, Runner, SceneSource, Shot, ShotOutcome, engine_name, poses_digest};
use crate::watch::Diagnostics;

/// The plan of a dataset: its jobs in order.
#[derive(Clone, Debug)]
pub struct DatasetPlan {
    /// Those of the first camera.
    settings: RenderSettings,
    engine: EngineSettings,
    /// The renders of every scene with every camera.
    renders: Vec<RenderJob>,
    jobs: Vec<DatasetJob>,
}

/// A light field or raw image of a dataset: one scene with one camera, at one pose and one frame.
#[derive(Clone, Debug)]
pub struct DatasetJob {
    camera: DatasetCamera,
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
    /// Returns the name of the scene; of one of several poses and frames with both behind it: `pendulum_left_0012`.
    #[must_use]
    pub fn scene(&self) -> String {
        let frame = self.shot.frame().map(|frame| format!("{frame:04}"));
        let parts = [self.shot.pose().map(str::to_owned), frame].into_iter().flatten();
        parts.fold(self.source.name(), |name, part| format!("{name}_{part}"))
    }

    /// Returns the source of the scene.
    #[must_use]
    pub fn source(&self) -> &SceneSource {
        &self.source
    }

    /// Returns the camera.
    #[must_use]
    pub fn camera(&self) -> &DatasetCamera {
        &self.camera
    }

    /// Returns the name of the job, such as `garden 20x20` with views as columns x rows, or `garden lytro-illum`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.scene(), self.camera.name())
    }

    /// Returns the folder of the job, relative to the root of the dataset.
    ///
    /// # Errors
    /// [`Error::Io`] if the name of the scene cannot be a folder name.
    pub fn folder(&self) -> Result<PathBuf, Error> {
        Ok(self.camera.folder(&self.scene())?)
    }
}

impl DatasetPlan {
    /// Plans a job for every source and every camera, at every pose and every frame if there are several. The settings are
    /// those of all jobs, except for the number of views or the plenoptic camera.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the settings contradict each other or are of another kind of camera, there is no scene, or
    /// views, cameras, scene names or folders repeat; [`Error::Core`] if the sensor has fewer pixels than views;
    /// [`Error::Io`] if the name of a scene cannot be a folder name.
    pub fn new(
        sources: &[SceneSource],
        cameras: impl Into<DatasetCameras>,
        settings: RenderSettings,
        engine: EngineSettings,
    ) -> Result<Self, Error> {
        let cameras = cameras::of(cameras.into(), &settings)?;
        check_names(sources)?;
        let settings = cameras.first().map_or(settings, |(_, first)| first.clone());
        let (mut renders, mut jobs) = (Vec::new(), Vec::new());
        for source in sources {
            for (camera, settings) in &cameras {
                let render = RenderJob::new(source.clone(), settings.clone()).engine(engine);
                jobs.extend(render.shots().into_iter().map(|shot| DatasetJob {
                    camera: camera.clone(),
                    source: source.clone(),
                    render: renders.len(),
                    shot,
                }));
                renders.push(render);
            }
        }
        check_folders(&jobs)?;
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

    /// Creates the root folder and writes `dataset.json`, `DATASET.md` and of several poses `transforms.json` into it:
    /// before the jobs, so that an unfinished dataset can be verified too.
    ///
    /// # Errors
    /// [`Error::Failed`], before anything changes, if a file of these names or of those of the catalog is not the
    /// dataset's own; [`Error::Failed`] or [`Error::Io`] if folder or files cannot be written; [`Error::Render`] if the requested backend
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
            entries.push(Entry { name, scene, sha256, camera: job.camera.clone() });
        }
        let mut options = texts(&self.settings);
        // Every light field has its own.
        options.remove("views");
        index::write(folder.folder(), &entries, self.poses(), (&options, &backend))?;
        if let Poses::Array { cameras, up } = &self.settings.poses {
            poses::write(folder.folder(), cameras, *up, self.settings.camera.size())?;
        }
        folder.keep();
        Ok(())
    }

    /// What `dataset.json` says of the poses, if there are several.
    fn poses(&self) -> Option<DatasetPoses> {
        let Poses::Array { cameras, up } = &self.settings.poses else { return None };
        let up = match up {
            WorldUp::Y => "y",
            WorldUp::Z => "z",
        };
        let sha256 = poses_digest(cameras).to_string();
        Some(DatasetPoses { count: cameras.cameras.len(), sha256, up: up.to_owned() })
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

/// The names of lists of the gallery's scenes, in place of scenes: of the paper's dataset, and the stratified ones.
const PAPER: &str = "paper";
const STRATIFIED: &str = "stratified";

/// Returns the scenes of a dataset: scenes of the gallery by name (`None`: all of [`gallery::NAMES`]; `paper`: the fifteen of the
/// paper's dataset; `stratified`: [`gallery::STRATIFIED`]), then files.
///
/// # Errors
/// [`Error::BadRequest`] if the gallery has no scene of a name; [`Error::Failed`] if a file does not exist.
pub fn sources(names: Option<&[String]>, files: &[PathBuf]) -> Result<Vec<SceneSource>, Error> {
    let names: Vec<&str> = match names {
        None => gallery::NAMES.to_vec(),
        Some([list]) if list == PAPER => gallery::NAMES[..gallery::OF_PAPER].to_vec(),
        Some([list]) if list == STRATIFIED => gallery::STRATIFIED.to_vec(),
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

/// Checks that every job has a folder of its own: names of scenes, poses and frames may combine to the same name.
fn check_folders(jobs: &[DatasetJob]) -> Result<(), Error> {
    let mut folders = BTreeSet::new();
    for job in jobs {
        let folder = job.folder()?;
        if folders.contains(&folder) {
            let folder = folder.display();
            return Err(Error::BadRequest(format!(
                "two images of the dataset would share the folder {folder}; rename a scene, or a pose of `transforms`"
            )));
        }
        folders.insert(folder);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_scenes_have_names() {
        let named = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| (*name).into()).collect();
            sources(Some(&names), &[]).map(|found| found.iter().map(SceneSource::name).collect::<Vec<_>>())
        };
        assert_eq!(named(&["stratified"]).unwrap(), gallery::STRATIFIED);
        assert_eq!(named(&["stripes", "plaster"]).unwrap(), ["stripes", "plaster"]);
        // Beside scenes it is the name of none.
        assert!(named(&["stratified", "plaster"]).is_err());
    }
}
