//! What a render tells when it is done: a summary for people, one JSON object for programs.

use std::path::Path;

use holo_core::Rig;
use holo_render::{Integrator, RayCounts};
use serde_json::{Value, json};

/// Everything worth telling about one render.
pub struct Report<'a> {
    pub seconds: Seconds,
    pub rays: RayCounts,
    pub samples: u64,
    pub backend: &'a str,
    pub threads: usize,
    pub integrator: Integrator,
    pub why: &'a str,
    pub rig: &'a Rig,
    pub disparity_px: Option<(f64, f64)>,
    pub files: &'a [String],
}

/// Where the time went.
#[derive(Clone, Copy, Default)]
pub struct Seconds {
    pub load: f64,
    pub build: f64,
    pub render: f64,
    pub write: f64,
    pub total: f64,
}

impl Report<'_> {
    /// The object of `--json`.
    pub fn json(&self) -> Value {
        let parameters = self.rig.parameters();
        let split = self.rig.split();
        let size = |s: holo_core::GridSize| json!({"columns": s.columns, "rows": s.rows});
        json!({
            "seconds": {
                "load": self.seconds.load, "build": self.seconds.build, "render": self.seconds.render,
                "write": self.seconds.write, "total": self.seconds.total,
            },
            "rays": {"primary": self.rays.primary, "shadow": self.rays.shadow, "other": 0},
            "samples": self.samples,
            "backend": self.backend,
            "threads": self.threads,
            "peak_rss_bytes": peak_rss_bytes(),
            "integrator": {"name": integrator_name(self.integrator), "why": self.why},
            "rig": {
                "views": size(split.views()), "lenses": size(split.lenses()),
                "baseline_m": {"x": parameters.baseline_x_m, "y": parameters.baseline_y_m},
                "focal_length_mm": parameters.intrinsics.focal_length_m * 1e3,
                "sensor_size_mm": parameters.intrinsics.sensor_size_m * 1e3,
                "focus_distance_m": number(parameters.focus_distance_m),
            },
            "disparity_px": self.disparity_px.map(|(min, max)| json!({"min": min, "max": max})),
            "files": self.files,
        })
    }

    /// A few lines on standard error.
    pub fn print(&self, out: &Path) {
        let s = &self.seconds;
        let rays = self.rays.primary + self.rays.shadow;
        say!(
            "rendered {} in {:.2} s ({:.1} Mrays/s, {}, {} threads, {}: {})",
            describe_split(self.rig),
            s.render,
            rays as f64 / s.render.max(1e-9) / 1e6,
            self.backend,
            self.threads,
            integrator_name(self.integrator),
            self.why
        );
        say!("{}", describe_rig(self.rig, self.disparity_px));
        say!(
            "wrote {} files to {} ({:.2} s; load {:.2} s, build {:.2} s, total {:.2} s)",
            self.files.len(),
            out.display(),
            s.write,
            s.load,
            s.build,
            s.total
        );
    }
}

/// Views, lenses and raw size in words.
pub fn describe_split(rig: &Rig) -> String {
    let (split, raw) = (rig.split(), rig.split().raw_size());
    let (views, lenses) = (split.views(), split.lenses());
    format!(
        "{} x {} views of {} x {} px (raw image {} x {})",
        views.columns, views.rows, lenses.columns, lenses.rows, raw.columns, raw.rows
    )
}

/// The rig's lengths in words.
pub fn describe_rig(rig: &Rig, disparity_px: Option<(f64, f64)>) -> String {
    let parameters = rig.parameters();
    let range = match disparity_px {
        Some((min, max)) => format!("disparity {min:.4} to {max:.4} px between neighbouring views"),
        None => "nothing hit in the central view".into(),
    };
    format!(
        "rig: baseline {:.6} mm, focal length {:.3} mm, sensor {:.3} mm, focus {:.4} m; {range}",
        parameters.baseline_x_m * 1e3,
        parameters.intrinsics.focal_length_m * 1e3,
        parameters.intrinsics.sensor_size_m * 1e3,
        parameters.focus_distance_m
    )
}

/// The name on the command line.
pub fn integrator_name(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::Auto => "auto",
        Integrator::Depth => "depth",
        Integrator::Direct => "direct",
    }
}

/// JSON has no infinity.
fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { json!("inf") }
}

/// The most memory that this process ever held, where the system tells (Linux).
fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}
