//! Collections: scenes times cameras, at one or many poses and frames, each a job with a folder of its own.
//!
//! **May import:** settings, output, resume, shot, describe.

mod cameras;
mod plan;
mod properties;
mod summary;

pub use self::cameras::DatasetCameras;
pub use self::plan::{DatasetJob, DatasetPlan, DatasetRun, drawn, sources};
pub use self::properties::SetProperties;
pub use self::summary::{DatasetSummary, JobSummary};
