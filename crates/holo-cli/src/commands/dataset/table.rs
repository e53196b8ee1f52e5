//! What is told of the jobs: a line each, and a table at the end.

use std::path::Path;

use holo_io::Manifest;
use serde_json::{Value, json};

use super::plan::Job;
use crate::console::say;
use crate::report::{RunJson, short};

/// What became of a job.
enum Outcome {
    Made { run: RunJson, files: usize },
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
    pub fn made(job: &Job, run: RunJson, bytes: u64, files: usize) -> Self {
        let disparity_px = run.disparity_px;
        Self::new(job, Outcome::Made { run, files }, disparity_px, bytes)
    }

    pub fn kept(job: &Job, manifest: &Manifest) -> Self {
        let bytes = manifest.files.values().map(|written| written.bytes).sum();
        Self::new(job, Outcome::Kept, manifest.disparity_px, bytes)
    }

    pub fn failed(job: &Job, why: String) -> Self {
        Self::new(job, Outcome::Failed(why), None, 0)
    }

    fn new(job: &Job, outcome: Outcome, disparity_px: Option<(f64, f64)>, bytes: u64) -> Self {
        let views = super::plan::in_words(job.split.views());
        Self { scene: job.source.name(), views, outcome, disparity_px, bytes }
    }

    /// For people.
    pub fn text(&self) -> String {
        let name = format!("{} {}", self.scene, self.views);
        match &self.outcome {
            Outcome::Made { run, .. } => format!(
                "{name}: {:.1} s, {:.1} Mrays/s, disparity {} px, {}",
                run.seconds.total,
                run.mrays_per_second(),
                self.disparities(),
                size(self.bytes)
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
            Outcome::Made { run, files } => ("made", json!({"run": run.json(), "files": files})),
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
                Outcome::Made { run, .. } => {
                    (format!("{:.1}", run.seconds.total), format!("{:.1}", run.mrays_per_second()))
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
