//! What is told of the jobs: a line each, and a table at the end.

use std::path::Path;

use holo_dataset::{DatasetJob, RenderReport};
use holo_io::Manifest;
use serde_json::{Value, json};

use crate::console::say;
use crate::report::{self, short};

/// What became of a job.
enum Outcome {
    Made { report: Box<RenderReport>, why: Option<String> },
    Kept,
    Failed(String),
}

/// A job that is over.
pub struct Line {
    scene: String,
    views: String,
    outcome: Outcome,
    disparity_px: Option<(f64, f64)>,
    bytes: u64,
}

impl Line {
    pub fn made(job: &DatasetJob, report: Box<RenderReport>, folder: &Path, why: Option<String>) -> Self {
        let disparity_px = report.disparity_px;
        let size = |name: &String| folder.join(name).metadata().ok().map(|file| file.len());
        let bytes = report.files.iter().filter_map(size).sum();
        Self::new(job, Outcome::Made { report, why }, disparity_px, bytes)
    }

    pub fn kept(job: &DatasetJob, manifest: &Manifest) -> Self {
        let bytes = manifest.files.values().map(|written| written.bytes).sum();
        Self::new(job, Outcome::Kept, manifest.disparity_px, bytes)
    }

    pub fn failed(job: &DatasetJob, why: String) -> Self {
        Self::new(job, Outcome::Failed(why), None, 0)
    }

    fn new(job: &DatasetJob, outcome: Outcome, disparity_px: Option<(f64, f64)>, bytes: u64) -> Self {
        let views = job.shape.views().to_string();
        Self { scene: job.render.source.name(), views, outcome, disparity_px, bytes }
    }

    /// For people.
    pub fn text(&self) -> String {
        let name = format!("{} {}", self.scene, self.views);
        match &self.outcome {
            Outcome::Made { report, why } => format!(
                "{name}: {:.1} s, {:.1} Mrays/s, disparity {} px, {}{}",
                report.seconds.total,
                report::mrays_per_second(report),
                self.disparities(),
                size(self.bytes),
                why.as_ref().map_or_else(String::new, |why| format!(" (made again: {why})"))
            ),
            Outcome::Kept => format!("{name}: done already, {}", size(self.bytes)),
            Outcome::Failed(why) => format!("{name}: failed: {why}"),
        }
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let mut object = json!({
            "scene": self.scene,
            "views": self.views,
            "disparity_px": self.disparity_px.map(|(min, max)| json!({"min": min, "max": max})),
            "bytes": self.bytes,
        });
        let (status, more) = match &self.outcome {
            Outcome::Made { report, why } => {
                let mut more = json!({"run": report::run_json(report), "files": report.files.len()});
                if let Some(why) = why {
                    more["why"] = why.as_str().into();
                }
                ("made", more)
            }
            Outcome::Kept => ("kept", json!({})),
            Outcome::Failed(why) => ("failed", json!({"why": why})),
        };
        object["status"] = status.into();
        if let Value::Object(more) = more {
            more.into_iter().for_each(|(key, value)| object[key] = value);
        }
        object
    }

    fn disparities(&self) -> String {
        self.disparity_px.map_or_else(|| "-".into(), |(min, max)| format!("{} to {}", short(min), short(max)))
    }
}

/// All of them.
#[derive(Default)]
pub struct Table(Vec<Line>);

impl Table {
    pub fn push(&mut self, line: Line) {
        self.0.push(line);
    }

    /// Made, done already, failed.
    pub fn counts(&self) -> (usize, usize, usize) {
        let count = |is: fn(&Outcome) -> bool| self.0.iter().filter(|line| is(&line.outcome)).count();
        (
            count(|outcome| matches!(outcome, Outcome::Made { .. })),
            count(|outcome| matches!(outcome, Outcome::Kept)),
            count(|outcome| matches!(outcome, Outcome::Failed(_))),
        )
    }

    /// On standard error.
    pub fn print(&self, root: &Path, seconds: f64) {
        say!("");
        say!("{:<12} {:>8} {:>9} {:>8} {:>22} {:>9}", "scene", "views", "seconds", "Mrays/s", "disparity, px", "size");
        for line in &self.0 {
            let (time, speed) = match &line.outcome {
                Outcome::Made { report, .. } => {
                    (format!("{:.1}", report.seconds.total), format!("{:.1}", report::mrays_per_second(report)))
                }
                Outcome::Kept => ("kept".into(), "-".into()),
                Outcome::Failed(_) => ("failed".into(), "-".into()),
            };
            let (range, size) = (line.disparities(), size(line.bytes));
            say!("{:<12} {:>8} {time:>9} {speed:>8} {range:>22} {size:>9}", line.scene, line.views);
        }
        let (made, kept, failed) = self.counts();
        let bytes = size(self.0.iter().map(|line| line.bytes).sum());
        say!("{made} made, {kept} done already, {failed} failed; {bytes} in {}; {seconds:.0} s", root.display());
    }
}

/// Bytes for people.
fn size(bytes: u64) -> String {
    match bytes as f64 {
        bytes if bytes < 1e6 => format!("{:.0} kB", bytes / 1e3),
        bytes if bytes < 1e9 => format!("{:.0} MB", bytes / 1e6),
        bytes => format!("{:.1} GB", bytes / 1e9),
    }
}
