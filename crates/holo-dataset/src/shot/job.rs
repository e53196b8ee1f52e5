//! Render jobs: a scene and settings, and how they are run.

use std::fmt;
use std::path::{Path, PathBuf};

use holo_core::Rig;
use holo_io::dataset::{MANIFEST_JSON, SEQUENCE_HDF5, SequenceFolder};
use holo_io::{CameraFile, Manifest};
use holo_render::{Motion, Progress, Rendered};
use ndarray::Array2;

use super::report::{RenderReport, Seconds};
use super::source::SceneSource;
use super::warning::RenderWarning;
use crate::Error;
use crate::output::{Rollback, TRANSFORMS, Wanted};
use crate::resume::Checkpoints;
use crate::settings::{Camera, EngineSettings, Output, RawLayer, RenderSettings, Shard};
use crate::watch::Diagnostics;

/// A render: a scene, settings and a ray tracing backend. It has a shot for every pose and every frame.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderJob {
    /// The scene.
    pub source: SceneSource,
    /// What to render.
    pub settings: RenderSettings,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSettings,
    /// How often and where finished parts are kept, so that an interrupted job continues; `None`: not at all.
    pub checkpoints: Option<Checkpoints>,
}

/// One pose at one frame; of pinhole cameras all poses at one frame. It owns a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shot {
    pub(super) pose: usize,
    pub(super) pose_name: Option<String>,
    pub(super) frame: Option<u32>,
}

/// What became of a shot.
#[derive(Clone, Debug)]
pub enum ShotOutcome {
    /// It was rendered; the reason if its folder contained an older result.
    Made(Box<RenderReport>, Option<String>),
    /// Its folder is up to date.
    Kept(Box<Manifest>),
}

/// What happens while a job runs.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A shot begins: its number among those that are run, from 0, and how many there are.
    Begin(usize, usize, &'a Shot),
    /// A shot ends, with the same numbers.
    End(usize, usize, &'a Shot, &'a ShotOutcome),
}

/// How a job is run. The default renders everything, replaces no other image, and says nothing.
#[derive(Clone)]
pub struct RunOptions<'a> {
    pub(super) shard: Option<Shard>,
    pub(super) overwrite: bool,
    pub(super) progress: &'a dyn Progress,
    pub(super) diagnostics: &'a dyn Diagnostics,
    pub(super) rollback: Rollback,
    pub(super) events: &'a dyn Fn(Event),
}

/// A render in memory.
#[derive(Debug)]
#[non_exhaustive]
pub struct Rendering {
    /// Color and layers.
    pub rendered: Rendered,
    /// [`Renderer::visibility`](holo_render::Renderer::visibility), if it was requested.
    pub visibility: Option<Array2<f32>>,
    /// [`Renderer::motion`](holo_render::Renderer::motion) of the central view, or with ground truth of all views of each,
    /// if it was requested.
    pub motion: Vec<Motion>,
    /// Layers of a raw image that follow from its camera, axes (row, column).
    pub raw_layers: Vec<(RawLayer, Array2<f32>)>,
    /// The rig; `None` for other cameras.
    pub rig: Option<Rig>,
    /// The plenoptic camera; `None` for other cameras.
    pub camera: Option<Box<CameraFile>>,
    /// The exposure compensation with which integers are written, EV; `None` without color.
    pub exposure_ev: Option<f64>,
    /// Wall-clock times; nothing was written.
    pub seconds: Seconds,
    /// Warnings about the result.
    pub warnings: Vec<RenderWarning>,
}

impl Default for RunOptions<'_> {
    fn default() -> Self {
        Self {
            shard: None,
            overwrite: false,
            progress: &(),
            diagnostics: &(),
            rollback: Rollback::default(),
            events: &|_| {},
        }
    }
}

impl<'a> RunOptions<'a> {
    /// Creates the default options.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Renders one part only: some rows of the image of a job with one shot, else some of the shots, whole.
    #[must_use]
    pub fn shard(self, shard: impl Into<Option<Shard>>) -> Self {
        Self { shard: shard.into(), ..self }
    }

    /// Replaces another image in the folder: of another scene, seed, settings or shard. An image that another version or
    /// backend made of the same is replaced in any case.
    #[must_use]
    pub fn overwrite(self, overwrite: bool) -> Self {
        Self { overwrite, ..self }
    }

    /// Sets the receiver of progress, which may cancel.
    #[must_use]
    pub fn progress(self, progress: &'a dyn Progress) -> Self {
        Self { progress, ..self }
    }

    /// Sets the receiver of warnings and notes.
    #[must_use]
    pub fn diagnostics(self, diagnostics: &'a dyn Diagnostics) -> Self {
        Self { diagnostics, ..self }
    }

    /// The receiver of warnings and notes.
    pub(crate) fn diagnostics_of(&self) -> &'a dyn Diagnostics {
        self.diagnostics
    }

    /// Sets the list of files that are removed if the process ends early.
    #[must_use]
    pub fn rollback(self, rollback: &Rollback) -> Self {
        Self { rollback: rollback.clone(), ..self }
    }

    /// Sets the receiver of the begin and the end of shots.
    #[must_use]
    pub fn events(self, events: &'a dyn Fn(Event)) -> Self {
        Self { events, ..self }
    }
}

impl fmt::Debug for RunOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shard, overwrite, .. } = self;
        f.debug_struct("RunOptions").field("shard", shard).field("overwrite", overwrite).finish_non_exhaustive()
    }
}

impl Shot {
    /// Returns the name of the pose, if the job has poses.
    #[must_use]
    pub fn pose(&self) -> Option<&str> {
        self.pose_name.as_deref()
    }

    /// Returns the number of the frame, if it is one of several.
    #[must_use]
    pub fn frame(&self) -> Option<u32> {
        self.frame
    }

    /// Returns the folder below that of its job; empty without poses and frames.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        let mut folder = PathBuf::new();
        if let Some(pose) = &self.pose_name {
            folder.push(pose);
        }
        if let Some(frame) = self.frame {
            folder.push(SequenceFolder::frame_name(frame));
        }
        folder
    }

    /// The name of a file of the shot, relative to the folder of its job.
    pub(super) fn file(&self, name: &str) -> String {
        let frame = self.frame.map(SequenceFolder::frame_name);
        let parts = self.pose_name.as_deref().into_iter().chain(frame.as_deref()).chain([name]);
        parts.collect::<Vec<_>>().join("/")
    }
}

impl fmt::Display for Shot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.pose_name, self.frame) {
            (Some(pose), Some(frame)) => write!(f, "{pose}, frame {frame}"),
            (Some(pose), None) => f.write_str(pose),
            (None, Some(frame)) => write!(f, "frame {frame}"),
            (None, None) => f.write_str("the image"),
        }
    }
}

impl RenderJob {
    /// Creates a job with the default backend and checkpoints.
    #[must_use]
    pub fn new(source: SceneSource, settings: RenderSettings) -> Self {
        let checkpoints = Some(Checkpoints::default());
        Self { source, settings, engine: EngineSettings::default(), checkpoints }
    }

    /// Sets the ray tracing backend and the number of threads.
    #[must_use]
    pub fn engine(self, engine: EngineSettings) -> Self {
        Self { engine, ..self }
    }

    /// Sets how often and where finished parts are kept; `None`: not at all.
    #[must_use]
    pub fn checkpoints(self, checkpoints: impl Into<Option<Checkpoints>>) -> Self {
        Self { checkpoints: checkpoints.into(), ..self }
    }

    /// Checks whether the settings are possible for any scene, before anything is loaded or written.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if they contradict each other, or request what the camera or this build does not have.
    pub fn check(&self) -> Result<(), Error> {
        Wanted::new(&self.settings).map(drop)
    }

    /// Returns all shots in the order in which they are rendered: frame by frame, and the poses of each.
    #[must_use]
    pub fn shots(&self) -> Vec<Shot> {
        let frames = self.settings.scene.frames.filter(|frames| frames.single().is_none());
        let frames: Vec<Option<u32>> =
            frames.map_or_else(|| vec![None], |frames| (frames.first..=frames.last).map(Some).collect());
        let poses: Vec<(usize, Option<String>)> = match (self.settings.poses.cameras(), &self.settings.camera) {
            (Some(array), Camera::Rig(_) | Camera::Plenoptic(_)) => {
                array.cameras.iter().enumerate().map(|(k, camera)| (k, Some(camera.name.clone()))).collect()
            }
            _ => vec![(0, None)],
        };
        let shot = |frame| poses.iter().map(move |(pose, name)| Shot { pose: *pose, pose_name: name.clone(), frame });
        frames.into_iter().flat_map(shot).collect()
    }

    /// Returns the names of all files that these shots of the job have in its folder `out`, relative to it: those of every
    /// shot, made or kept, the poses, and the light fields of all frames as one array.
    #[must_use]
    pub fn files(&self, out: impl AsRef<Path>, shots: &[(Shot, ShotOutcome)]) -> Vec<String> {
        let mut files: Vec<String> = shots.iter().flat_map(|(shot, outcome)| outcome.files(shot)).collect();
        let mut of_all = Vec::new();
        if self.settings.poses.cameras().is_some() && !matches!(self.settings.camera, Camera::Pinhole) {
            of_all.push(TRANSFORMS.to_owned());
        }
        if self.settings.output.write.contains(&Output::H5) {
            let of_frames = shots.iter().filter(|(shot, _)| shot.frame.is_some());
            of_all.extend(of_frames.map(|(shot, _)| Shot { frame: None, ..shot.clone() }.file(SEQUENCE_HDF5)));
        }
        of_all.sort_unstable();
        of_all.dedup();
        files.extend(of_all.into_iter().filter(|name| out.as_ref().join(name).is_file()));
        files
    }
}

impl ShotOutcome {
    /// Returns the report of a shot that was rendered.
    #[must_use]
    pub fn report(&self) -> Option<&RenderReport> {
        match self {
            Self::Made(report, _) => Some(report),
            Self::Kept(_) => None,
        }
    }

    /// The names of the files of a shot, relative to the folder of its job.
    fn files(&self, shot: &Shot) -> Vec<String> {
        match self {
            Self::Made(report, _) => report.files.clone(),
            Self::Kept(manifest) => {
                let names = manifest.files.keys().map(String::as_str).chain([MANIFEST_JSON]);
                names.map(|name| shot.file(name)).collect()
            }
        }
    }
}
