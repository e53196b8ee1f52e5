//! A dataset: scenes times view counts, a job each; which jobs there are, in which order, and which of them are done.

use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape, Remainder};
use holo_io::{Manifest, Setting, dataset};
use holo_render::{Progress, Renderer};
use holo_scene::gallery;

use crate::diagnostics::Diagnostics;
use crate::files::validate;
use crate::job::{RenderJob, RenderReport};
use crate::options::Options;
use crate::output_folder::{OutputFolder, Rollback, clear_older};
use crate::source::SceneSource;
use crate::spec::{EngineSpec, RenderSpec};
use crate::{Error, describe, prepare};

/// A dataset as it is planned.
#[derive(Clone, Debug)]
pub struct DatasetPlan {
    /// What all jobs have in common; its views are replaced by those of each job.
    pub spec: RenderSpec,
    /// The words of `spec` that were typed, for manifests and the description.
    pub options: Options,
    /// With which backend, on how many threads.
    pub engine: EngineSpec,
    /// The jobs, scene by scene: the same list on every machine.
    pub jobs: Vec<DatasetJob>,
}

/// One scene with one number of views.
#[derive(Clone, Debug)]
pub struct DatasetJob {
    /// Views and lenses.
    pub shape: LightFieldShape,
    /// What to do.
    pub render: RenderJob,
}

/// What became of a job.
#[derive(Clone, Debug)]
pub enum JobOutcome {
    /// It was rendered, for the reason given, if its folder held an older result.
    Made(Box<RenderReport>, Option<String>),
    /// Its folder held what it would make.
    Kept(Box<Manifest>),
}

impl DatasetJob {
    /// As in `garden 20x20`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.render.source.name(), self.shape.views())
    }

    /// Its folder in the root of the dataset.
    ///
    /// # Errors
    /// A scene whose name can be no folder.
    pub fn folder(&self) -> Result<PathBuf, Error> {
        Ok(dataset::folder(&self.render.source.name(), self.shape.views())?)
    }
}

impl DatasetPlan {
    /// Plans a job for every source and every number of views. `options` are the words of `spec` that were typed.
    ///
    /// # Errors
    /// A specification that contradicts itself; the same views or two scenes of one name; a sensor too small.
    pub fn new(
        sources: &[SceneSource],
        views: &[GridSize],
        spec: RenderSpec,
        options: Options,
        engine: EngineSpec,
    ) -> Result<Self, Error> {
        validate(&spec)?;
        check_names(sources)?;
        let mut splits: Vec<LightFieldShape> = Vec::new();
        for &views in views {
            if splits.iter().any(|shape| shape.views() == views) {
                return Err(Error::BadRequest(format!("--views has {} twice", views)));
            }
            splits.push(spec.rig.sensor.divide(views, Remainder::Crop)?.shape);
        }
        let mut jobs = Vec::new();
        for source in sources {
            for &shape in &splits {
                let mut spec = spec.clone();
                spec.rig.views = shape.views();
                let mut words = spec.to_options();
                words.extend(options.clone());
                words.insert("views".into(), shape.views().to_string());
                let render = RenderJob::new(source.clone(), spec).with_options(words).with_engine(engine);
                jobs.push(DatasetJob { shape, render });
            }
        }
        let options = crate::options::without_paths(options, &spec);
        Ok(Self { spec, options, engine, jobs })
    }

    /// The ray tracing backend of all jobs and its version, as manifests name it.
    ///
    /// # Errors
    /// A backend that cannot be had.
    pub fn backend(&self, diagnostics: &dyn Diagnostics) -> Result<String, Error> {
        let empty = holo_scene::Scene::default();
        let renderer = Renderer::new(&empty, &holo_scene::Transform::IDENTITY, self.engine.backend, 1)?;
        prepare::report_backend(&renderer, diagnostics);
        Ok(renderer.engine_name().to_owned())
    }

    /// Makes the root and writes `dataset.json` and `DATASET.md` into it, so that a dataset that is half done can be checked
    /// too.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn describe(&self, root: &Path, backend: &str, rollback: &Rollback) -> Result<(), Error> {
        let folder = OutputFolder::create_plain(root, rollback)?;
        let jobs: Vec<_> = self.jobs.iter().map(|job| (&job.render.source, job.shape)).collect();
        describe::write(root, &jobs, &self.options, backend)?;
        folder.keep();
        Ok(())
    }

    /// Does one job below `root`, or finds that it is done.
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
        let identity = job.render.identity(backend)?;
        let why = match done(&out, &identity) {
            Ok(manifest) => return Ok(JobOutcome::Kept(Box::new(manifest))),
            Err(why) => why,
        };
        Ok(JobOutcome::Made(Box::new(job.render.run(&out, None, progress, diagnostics, rollback)?), why))
    }
}

/// The scenes of a dataset: those of the gallery by name (`None`: all), then files.
///
/// # Errors
/// No such scene, no such file.
pub fn sources(names: Option<&[String]>, files: &[PathBuf]) -> Result<Vec<SceneSource>, Error> {
    let names: Vec<&str> = match names {
        None => gallery::NAMES.to_vec(),
        Some(names) => names.iter().map(String::as_str).collect(),
    };
    let mut sources = names.into_iter().map(SceneSource::gallery).collect::<Result<Vec<_>, _>>()?;
    for path in files {
        if !path.is_file() {
            return Err(Error::Failed(format!("{}: there is no such scene; see --glb", path.display())));
        }
        sources.push(SceneSource::File(path.clone()));
    }
    Ok(sources)
}

/// Every scene needs a folder of its own.
fn check_names(sources: &[SceneSource]) -> Result<(), Error> {
    for (index, source) in sources.iter().enumerate() {
        let name = source.name();
        if sources[..index].iter().any(|other| other.name() == name) {
            return Err(Error::BadRequest(format!(
                "two scenes are called '{name}', and would share a folder; rename one"
            )));
        }
        // A name that can be no folder is said before anything is made.
        dataset::folder(&name, GridSize::new(1, 1))?;
    }
    if sources.is_empty() {
        return Err(Error::BadRequest("no scene: leave --scenes away for all of the gallery, or give --glb".into()));
    }
    Ok(())
}

/// The manifest of a job that is done: the same scene, options and versions, and every file as its digest says. Else why
/// an older result does not count, if there is one.
fn done(folder: &Path, identity: &Manifest) -> Result<Manifest, Option<String>> {
    let path = folder.join(dataset::MANIFEST_JSON);
    let manifest = match Manifest::read(&path) {
        Ok(manifest) => manifest,
        Err(_) if !path.is_file() => return Err(None),
        Err(why) => return Err(Some(why.to_string())),
    };
    if let Some(why) = difference(&manifest, identity) {
        return Err(Some(why));
    }
    if let Some(mismatch) = manifest.verify(folder).first() {
        return Err(Some(mismatch.to_string()));
    }
    // A run may have been killed when it had only this left to do.
    clear_older(folder, &manifest);
    Ok(manifest)
}

/// What an older result was made with that this job is not.
fn difference(manifest: &Manifest, identity: &Manifest) -> Option<String> {
    let text = |value: Option<&String>| value.map_or_else(|| "unknown".to_owned(), Clone::clone);
    for (name, version) in &identity.versions {
        let own = manifest.versions.get(name);
        if own != Some(version) {
            return Some(format!("it was made by {name} {}, this is {name} {version}", text(own)));
        }
    }
    if manifest.seed != identity.seed {
        return Some(format!("it was made with --seed={}, this is --seed={}", manifest.seed, identity.seed));
    }
    for (name, value) in &identity.settings {
        let own = manifest.settings.get(name);
        if own == Some(value) {
            continue;
        }
        return Some(match (name.as_str(), own, value) {
            ("scene_sha256", ..) => "the scene has changed".into(),
            ("sky_sha256", ..) => "the environment map has changed".into(),
            (_, Some(Setting::Table(own)), Setting::Table(value)) => {
                let keys = value.keys().chain(own.keys());
                let changed = keys.into_iter().find(|key| own.get(*key) != value.get(*key));
                changed.map_or_else(|| "its options differ".into(), |key| format!("--{key} has changed"))
            }
            _ => format!("'{name}' has changed"),
        });
    }
    None
}
