//! Collections: scenes times numbers of views, each a job with a folder of its own.
//!
//! **May import:** settings, output, resume, shot, describe.

mod plan;
mod summary;

pub use self::plan::{DatasetJob, DatasetPlan, DatasetRun, sources};
pub use self::summary::{DatasetSummary, JobSummary};
