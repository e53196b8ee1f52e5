//! The data of benchmarks.

use std::cell::RefCell;
use std::path::PathBuf;

use holo_dataset::settings::EngineSettings;
use holo_dataset::{About, CalibrationBenchmark, Rollback};
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::render::{Told, listening};
use crate::watch::{self, Watch};

/// Writes the benchmark of calibrations; returns the parts that were written, and diagnostics.
#[pyfunction]
pub fn calibration_benchmark(
    py: Python<'_>,
    out: PathBuf,
    is_full: bool,
    cameras: Vec<String>,
    samples: u32,
    overwrite: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> Result<Told<Vec<String>>, Failure> {
    let benchmark = CalibrationBenchmark { is_full, cameras, samples, engine: EngineSettings::default() };
    let run = |watch: &Watch| {
        let parts = RefCell::new(Vec::new());
        let (_, lines) = listening(|tell| {
            let hear = |about: About, line: &str| match about {
                About::Scene => parts.borrow_mut().push(line.to_owned()),
                About::Setup => tell.report(about, line),
            };
            benchmark.run(&out, overwrite, (watch, &hear, &Rollback::default()))
        })?;
        Ok::<_, holo_dataset::Error>((parts.into_inner(), lines))
    };
    watch::run(py, progress.as_ref(), run)
}
