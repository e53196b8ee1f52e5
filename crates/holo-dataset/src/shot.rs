//! Shots: one pose at one frame, from the scene to a folder of files; and the jobs of one or many of them.
//!
//! ```text
//! SceneSource + RenderSettings -> RenderJob -> shots -> folders (images, ground truth, parameters.cfg, manifest.json)
//! ```
//!
//! **May import:** settings, output, resume.

mod choices;
mod drawn;
mod engine;
mod ground;
mod identity;
mod job;
mod library;
mod look;
mod memory;
mod motion;
mod pinholes;
mod prepare;
mod report;
mod runner;
mod sky;
mod source;
mod trace;
mod viewpoint;
mod warning;

pub(crate) use self::engine::{engine_name, libraries};
pub(crate) use self::identity::{camera_digest, poses_digest};
pub use self::job::{Event, RenderJob, Rendering, RunOptions, Shot, ShotOutcome};
pub use self::prepare::{Prepared, Stage};
pub(crate) use self::prepare::{half_view, pose_of_scene, shifted};
pub use self::report::{CameraReport, RenderReport, Seconds};
pub(crate) use self::runner::Runner;
pub use self::source::{Drawing, SceneSource};
pub(crate) use self::viewpoint::looking;
pub use self::warning::{RenderWarning, camera_warnings};
