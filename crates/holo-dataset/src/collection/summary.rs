//! What became of the jobs of a dataset: a line each, and a table of all.

use std::fmt;
use std::path::Path;

use serde_json::{Value, json};

use super::plan::DatasetJob;
use crate::output::Statistics;
use crate::settings::text;
use crate::shot::{RenderReport, ShotOutcome};

/// What became of a job; prints as a line of text.
#[derive(Clone, Debug)]
pub struct JobSummary {
    scene: String,
    /// The name of the camera: that of its folder.
    camera: String,
    is_rig: bool,
    result: JobResult,
    disparity_px: Option<(f64, f64)>,
    statistics: Statistics,
    bytes: u64,
}

#[derive(Clone, Debug)]
enum JobResult {
    Made { report: Box<RenderReport>, why: Option<String> },
    Kept,
    Failed(String),
}

impl JobSummary {
    /// Summarizes a job of a dataset in the folder `root`. The error of a failed job is its message.
    #[must_use]
    pub fn new(job: &DatasetJob, root: &Path, outcome: Result<ShotOutcome, String>) -> Self {
        let (result, disparity_px, statistics, bytes) = match outcome {
            Ok(ShotOutcome::Made(report, why)) => {
                let folder = job.folder().map(|folder| root.join(folder)).unwrap_or_default();
                let size = |name: &String| folder.join(name).metadata().ok().map(|file| file.len());
                let (range, statistics) = (report.disparity_px(), report.statistics.clone());
                let bytes = report.files.iter().filter_map(size).sum();
                (JobResult::Made { report, why }, range, statistics, bytes)
            }
            Ok(ShotOutcome::Kept(manifest)) => {
                let bytes = manifest.files.values().map(|written| written.bytes).sum();
                (JobResult::Kept, manifest.disparity_px, Statistics::of_manifest(&manifest), bytes)
            }
            Err(why) => (JobResult::Failed(why), None, Statistics::default(), 0),
        };
        let (camera, is_rig) = (job.camera().name(), job.camera().shape().is_some());
        Self { scene: job.scene(), camera, is_rig, result, disparity_px, statistics, bytes }
    }

    /// The line of `holo dataset --json`: scene, views and disparities of a rig or the name of a plenoptic camera, bytes,
    /// status, and what the status tells more.
    #[must_use]
    pub fn to_json(&self) -> String {
        self.json().to_string()
    }

    fn json(&self) -> Value {
        let mut object = json!({
            "scene": self.scene,
            "bytes": self.bytes,
        });
        if self.is_rig {
            object["views"] = self.camera.as_str().into();
            object["disparity_px"] = json!(self.disparity_px.map(|(min, max)| json!({"min": min, "max": max})));
        } else {
            object["camera"] = self.camera.as_str().into();
        }
        match &self.result {
            JobResult::Made { report, why } => {
                object["status"] = "made".into();
                object["run"] = report.run_json();
                object["files"] = report.files.len().into();
                if let Some(why) = why {
                    object["why"] = why.as_str().into();
                }
            }
            JobResult::Kept => {
                object["status"] = "kept".into();
                object["statistics"] = self.statistics.json();
            }
            JobResult::Failed(why) => {
                object["status"] = "failed".into();
                object["why"] = why.as_str().into();
            }
        }
        object
    }

    fn disparities(&self) -> String {
        let range = |(min, max)| format!("{} to {}", text::number(min), text::number(max));
        self.disparity_px.map_or_else(|| "-".into(), range)
    }

    /// The median of the estimated error.
    fn error_text(&self) -> String {
        self.statistics.error.map_or_else(|| "-".into(), |error| format!("{:.2} %", error.median * 100.0))
    }
}

impl fmt::Display for JobSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = text::bytes(self.bytes);
        write!(f, "{} {}: ", holo_io::shown(&self.scene), holo_io::shown(&self.camera))?;
        match &self.result {
            JobResult::Made { report, why } => {
                let (seconds, speed) = (report.seconds.total, report.mrays_per_second());
                write!(f, "{seconds:.1} s, {speed:.1} Mrays/s, ")?;
                if self.is_rig {
                    write!(f, "disparity {} px, ", self.disparities())?;
                }
                write!(f, "{size}")?;
                self.statistics.error.map_or(Ok(()), |_| write!(f, ", estimated error {}", self.error_text()))?;
                why.as_ref().map_or(Ok(()), |why| write!(f, " (made again: {why})"))
            }
            JobResult::Kept => write!(f, "done already, {size}"),
            JobResult::Failed(why) => write!(f, "failed: {why}"),
        }
    }
}

/// What became of all jobs; prints as a table with a last line that counts them.
#[derive(Clone, Debug, Default)]
pub struct DatasetSummary(Vec<JobSummary>);

impl DatasetSummary {
    /// Adds a job.
    pub fn push(&mut self, job: JobSummary) {
        self.0.push(job);
    }

    /// Numbers of jobs that were made, were done already, and failed.
    #[must_use]
    pub fn counts(&self) -> (usize, usize, usize) {
        let count = |is: fn(&JobResult) -> bool| self.0.iter().filter(|job| is(&job.result)).count();
        (
            count(|result| matches!(result, JobResult::Made { .. })),
            count(|result| matches!(result, JobResult::Kept)),
            count(|result| matches!(result, JobResult::Failed(_))),
        )
    }
}

impl fmt::Display for DatasetSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let camera = if self.0.iter().all(|job| job.is_rig) { "views" } else { "camera" };
        let heads = ["scene", camera, "seconds", "Mrays/s", "disparity, px", "median error", "size"];
        let rows = self.0.iter().map(|job| {
            let (time, speed) = match &job.result {
                JobResult::Made { report, .. } => {
                    (format!("{:.1}", report.seconds.total), format!("{:.1}", report.mrays_per_second()))
                }
                JobResult::Kept => ("kept".into(), "-".into()),
                JobResult::Failed(_) => ("failed".into(), "-".into()),
            };
            let (range, error, size) = (job.disparities(), job.error_text(), text::bytes(job.bytes));
            [job.scene.clone(), job.camera.clone(), time, speed, range, error, size]
        });
        let width = |least: usize, of: fn(&JobSummary) -> &str| {
            self.0.iter().map(|job| of(job).chars().count()).fold(least, usize::max)
        };
        let (first, second) = (width(12, |job| job.scene.as_str()), width(8, |job| job.camera.as_str()));
        for [scene, camera, time, speed, range, error, size] in std::iter::once(heads.map(String::from)).chain(rows) {
            writeln!(f, "{scene:<first$} {camera:>second$} {time:>9} {speed:>8} {range:>22} {error:>13} {size:>9}")?;
        }
        let (made, kept, failed) = self.counts();
        let bytes = text::bytes(self.0.iter().map(|job| job.bytes).sum());
        write!(f, "{made} made, {kept} done already, {failed} failed; {bytes}")
    }
}
