//! What a finished render reports: times, rays, rig, files; as text and as JSON.

use std::fmt;

use holo_core::{GridSize, Rig};
use holo_io::meters_to_millimeters;
use holo_render::{Integrator, RayCounts};
use serde_json::{Value, json};

use crate::options::integrator_name;
use crate::statistics::Statistics;
use crate::text;
use crate::warning::RenderWarning;

/// Statistics of a finished render.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderReport {
    /// Wall-clock times.
    pub seconds: Seconds,
    /// Number of rays by kind.
    pub rays: RayCounts,
    /// Number of samples of the light field: views x microlenses x samples a pixel, unless there was a target error.
    pub samples: u64,
    /// The ray tracing backend and its version.
    pub backend: String,
    /// Number of threads.
    pub threads: usize,
    /// The integrator that rendered.
    pub integrator: Integrator,
    /// Why it was chosen.
    pub why: String,
    /// The rig.
    pub rig: Rig,
    /// Smallest and largest finite disparity of the central view, in pixels between horizontally adjacent views.
    pub disparity_px: Option<(f64, f64)>,
    /// Numbers that describe the light field; of a shard none.
    pub statistics: Statistics,
    /// Names of the files, relative to the folder.
    pub files: Vec<String>,
    /// What is probably not wanted in the image; of a shard nothing. Diagnostics received the same as lines.
    pub warnings: Vec<RenderWarning>,
}

/// Wall-clock time by stage, s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    /// Reading the scene.
    pub load: f64,
    /// Building the acceleration structure.
    pub build: f64,
    /// From the first ray to the finished light field in memory, exposure included.
    pub render: f64,
    /// Encoding and writing files.
    pub write: f64,
    /// All stages.
    pub total: f64,
}

impl RenderReport {
    /// Rays of all kinds a second of rendering, in millions.
    #[must_use]
    pub fn mrays_per_second(&self) -> f64 {
        self.rays.total() as f64 / self.seconds.render.max(1e-9) / 1e6
    }

    /// The report as a JSON object, the one that `holo render --json` prints without
    /// the memory of the process.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let rig = &self.rig;
        let size = |size: GridSize| json!({"columns": size.columns, "rows": size.rows});
        let mut object = self.run_json();
        let more = json!({
            "backend": self.backend,
            "threads": self.threads,
            "integrator": {"name": integrator_name(self.integrator), "why": self.why},
            "rig": {
                "views": size(rig.shape().views()), "lenses": size(rig.shape().lenses()),
                "baseline_m": {"x": rig.baseline_x_m(), "y": rig.baseline_y_m()},
                "focal_length_mm": meters_to_millimeters(rig.focal_length_m()),
                "sensor_size_mm": meters_to_millimeters(rig.sensor_size_m()),
                "focus_distance_m": text::json_number(rig.focus_distance_m()),
            },
            "disparity_px": self.disparity_px.map(|(min, max)| json!({"min": min, "max": max})),
            "files": self.files,
            "warnings": self.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        });
        if let (Value::Object(object), Value::Object(more)) = (&mut object, more) {
            object.extend(more);
        }
        object
    }

    /// Times, rays, samples, integrator and statistics: what differs between the renders of a dataset.
    pub(crate) fn run_json(&self) -> Value {
        let (s, rays) = (&self.seconds, self.rays);
        json!({
            "seconds": {"load": s.load, "build": s.build, "render": s.render, "write": s.write, "total": s.total},
            "rays": {"primary": rays.primary, "shadow": rays.shadow, "other": rays.secondary},
            "samples": self.samples,
            "integrator": integrator_name(self.integrator),
            "statistics": self.statistics.to_json(),
        })
    }
}

/// Lines of text: what was rendered how fast, the rig, and the estimated error if there is one.
impl fmt::Display for RenderReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "rendered {} in {:.2} s ({:.1} Mrays/s, {}, {} threads, {}: {})",
            text::shape(self.rig.shape()),
            self.seconds.render,
            self.mrays_per_second(),
            self.backend,
            self.threads,
            integrator_name(self.integrator),
            self.why
        )?;
        f.write_str(&text::rig(&self.rig, self.disparity_px))?;
        let error = self.statistics.error;
        error.map_or(Ok(()), |error| write!(f, "\nestimated error of color: {error}"))
    }
}
