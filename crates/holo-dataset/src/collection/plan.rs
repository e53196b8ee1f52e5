//! The plan of a dataset: a job for every scene, pose, frame and camera, their order, and which of them are done.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use holo_core::GridSize;
use holo_io::dataset::{self, DatasetCamera, DatasetPoses, DatasetRecipe};
use holo_io::{Folder, WorldUp};
use holo_scene::gallery;
use holo_scene::recipe::Recipe;

use super::cameras::{self, DatasetCameras};
use super::properties;

use crate::Error;
use crate::describe::index::{self, Entry};
use crate::output::{OutputFolder, Rollback, poses};
use crate::resume::Checkpoints;
use crate::settings::{Camera, EngineSettings, Given, Group, Poses, RenderSettings, Setting, texts};
use crate::shot::{
    Drawing, RenderJob, RunOptions, Runner, SceneSource, Shot, ShotOutcome, camera_digest, engine_name, poses_digest,
};
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
        let cameras = cameras.into();
        // Before scenes are looked at.
        cameras.check(&settings)?;
        let scenes = sources.iter().map(|source| (source.clone(), settings.clone())).collect::<Vec<_>>();
        Self::of_each(&scenes, cameras, engine)
    }

    /// Plans a job for every source and every camera with settings of its own: see [`new`](Self::new), and [`drawn`](crate::drawn).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_each(
        scenes: &[(SceneSource, RenderSettings)],
        cameras: impl Into<DatasetCameras>,
        engine: EngineSettings,
    ) -> Result<Self, Error> {
        let cameras = cameras.into();
        check_names(scenes.iter().map(|(source, _)| source))?;
        let mut first = None;
        let (mut renders, mut jobs) = (Vec::new(), Vec::new());
        for (source, settings) in scenes {
            for (camera, mut settings) in cameras::of(&cameras, settings)? {
                if let (SceneSource::Recipe(drawing), Camera::Plenoptic(file)) = (source, &mut settings.camera) {
                    **file = drawing.perturbed((**file).clone())?;
                }
                let render = RenderJob::new(source.clone(), settings.clone()).engine(engine);
                first.get_or_insert(settings);
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
        Ok(Self { settings: first.unwrap_or_default(), engine, renders, jobs })
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

    /// Creates the root folder and writes `dataset.json`, `DATASET.md`, of several poses `transforms.json` and of drawn scenes `recipe.toml` into it:
    /// before the jobs, so that an unfinished dataset can be verified too.
    ///
    /// # Errors
    /// [`Error::Failed`], before anything changes, if a file of these names or of those of the catalog is not the
    /// dataset's own; [`Error::Failed`] or [`Error::Io`] if folder or files cannot be written; [`Error::Render`] if the requested backend
    /// is not available.
    pub fn describe(&self, root: &Path, diagnostics: &dyn Diagnostics, rollback: &Rollback) -> Result<(), Error> {
        let backend = engine_name(&self.engine, diagnostics)?;
        let folder = OutputFolder::create_plain(root, rollback)?;
        let recipe = match self.renders.first().map(|render| &render.source) {
            Some(SceneSource::Recipe(drawing)) => Some(drawing.recipe().text()),
            _ => None,
        };
        let has_recipe = recipe.map_or(Ok(true), |text| has_recipe(folder.folder(), text))?;
        let mut entries = Vec::with_capacity(self.jobs.len());
        let mut digest = (usize::MAX, String::new());
        for job in &self.jobs {
            if digest.0 != job.render {
                digest = (job.render, job.source.sha256()?.to_string());
            }
            let (name, scene, sha256) = (job.scene(), job.source.name(), digest.1.clone());
            let purpose = match &job.source {
                SceneSource::Recipe(drawing) => format!("drawn from the recipe {}", drawing.recipe().name()),
                _ => gallery::purpose(&scene).unwrap_or("a scene from a file").to_owned(),
            };
            let camera = job.camera.clone();
            let own_camera = own_camera(&camera, &self.renders[job.render].settings.camera);
            entries.push(Entry { name, scene, purpose, sha256, camera, own_camera });
        }
        // What all have in common: a recipe draws some for each scene.
        let mut options = texts(&self.settings);
        for render in &self.renders {
            let own = texts(&render.settings);
            options.retain(|key, text| own.get(key) == Some(text));
        }
        // Every light field has its own.
        options.remove("views");
        index::write(folder.folder(), &entries, (self.poses(), self.recipe()), (&options, &backend))?;
        if let (Some(text), false) = (recipe, has_recipe) {
            holo_io::write_file(folder.folder().file(RECIPE), text.as_bytes())?;
        }
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

    /// What `dataset.json` says of the recipe, if the scenes are drawn.
    fn recipe(&self) -> Option<DatasetRecipe> {
        let SceneSource::Recipe(drawing) = &self.renders.first()?.source else { return None };
        let count = self.renders.iter().map(|render| render.source.name()).collect::<BTreeSet<_>>().len();
        Some(DatasetRecipe { name: drawing.recipe().name().to_owned(), seed: drawing.seed(), count })
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

/// The recipe of a set that was drawn, in its root.
const RECIPE: &str = "recipe.toml";

/// Draws the settings of the first scenes of a recipe, from 0 to `count - 1`: those given, over those of the recipe. The seed of
/// the samples of a scene is `seed` plus its number.
///
/// # Errors
/// [`Error::BadRequest`] if the recipe has a setting or a property that does not exist, or settings exclude each other;
/// [`Error::Io`] if a file of the recipe cannot be read. Settings of rigs do not concern other cameras.
pub fn drawn(
    recipe: &Arc<Recipe>,
    (seed, count): (u64, u64),
    given: &Given,
    base: &RenderSettings,
) -> Result<Vec<(SceneSource, RenderSettings)>, Error> {
    for (name, _) in recipe.shares() {
        if !properties::names().any(|known| known == name) {
            let known = properties::names().collect::<Vec<_>>().join(", ");
            let name = holo_core::shown(name);
            return Err(Error::BadRequest(format!("`recipe`: {name} in [shares] is no property; they are {known}")));
        }
    }
    let of = |drawing: Drawing| {
        let mut own = Given::default();
        for (key, text) in recipe.settings(seed, drawing.number()) {
            let is_of_rig = Setting::by_key(&key).is_some_and(|setting| setting.group() == Group::Rig);
            // Plenoptic cameras are what their files say.
            if !is_of_rig || base.camera.rig().is_some() {
                own.insert(&key, text)?;
            }
        }
        let mut settings = base.clone();
        settings.apply(&given.clone().over(own))?;
        settings.light.seed = seed.wrapping_add(drawing.number());
        Ok((SceneSource::Recipe(drawing), settings))
    };
    Drawing::first(recipe, seed, count)?.map(of).collect()
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

/// Whether the recipe of a set lies in its root. Another one there is an error.
fn has_recipe(root: &Folder, text: &str) -> Result<bool, Error> {
    if root.kind(RECIPE)?.is_none() {
        return Ok(false);
    }
    if root.read(RECIPE, text.len() as u64 + 1).ok().as_deref() != Some(text.as_bytes()) {
        let path = root.path_of(RECIPE);
        return Err(Error::Failed(format!("{}: another recipe; give an empty `out`", path.display())));
    }
    Ok(true)
}

/// The digest of the camera of a render, if it differs from that of the dataset.
fn own_camera(camera: &DatasetCamera, own: &Camera) -> Option<String> {
    let (DatasetCamera::Plenoptic { sha256, .. }, Camera::Plenoptic(own)) = (camera, own) else { return None };
    Some(camera_digest(own).to_string()).filter(|own| own != sha256)
}

/// Checks that every scene has a unique folder.
fn check_names<'a>(sources: impl Iterator<Item = &'a SceneSource>) -> Result<(), Error> {
    let mut names = BTreeSet::new();
    for source in sources {
        let name = source.name();
        // Before anything is rendered.
        dataset::folder(&name, GridSize::new(1, 1))?;
        if names.contains(&name) {
            return Err(Error::BadRequest(format!(
                "two scenes have the name '{name}' and would share a folder; rename one"
            )));
        }
        names.insert(name);
    }
    if names.is_empty() {
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
