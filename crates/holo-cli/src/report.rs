//! What a render tells when it is done: a summary for people, one JSON object for programs.

use std::path::Path;

use holo_core::Rig;
use holo_io::ManifestRig;
use holo_render::{Integrator, RayCounts};
use serde_json::{Value, json};

use crate::console::say;

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

/// What one of many renders tells.
pub struct RunJson {
    pub seconds: Seconds,
    pub rays: RayCounts,
    pub samples: u64,
    pub integrator: Integrator,
    pub disparity_px: Option<(f64, f64)>,
}

impl RunJson {
    pub fn mrays_per_second(&self) -> f64 {
        self.rays.total() as f64 / self.seconds.render.max(1e-9) / 1e6
    }

    pub fn json(&self) -> Value {
        json!({
            "seconds": self.seconds.json(),
            "rays": rays(self.rays),
            "samples": self.samples,
            "integrator": integrator_name(self.integrator),
        })
    }
}

fn rays(rays: RayCounts) -> Value {
    json!({"primary": rays.primary, "shadow": rays.shadow, "other": rays.other})
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

impl Seconds {
    fn json(&self) -> Value {
        json!({
            "load": self.load, "build": self.build, "render": self.render, "write": self.write, "total": self.total,
        })
    }
}

impl Report<'_> {
    /// The object of `--json`.
    pub fn json(&self) -> Value {
        let rig = ManifestRig::from(self.rig.parameters());
        let size = |s: holo_core::GridSize| json!({"columns": s.columns, "rows": s.rows});
        json!({
            "seconds": self.seconds.json(),
            "rays": rays(self.rays),
            "samples": self.samples,
            "backend": self.backend,
            "threads": self.threads,
            "peak_rss_bytes": peak_rss_bytes(),
            "integrator": {"name": integrator_name(self.integrator), "why": self.why},
            "rig": {
                "views": size(rig.views), "lenses": size(rig.lenses),
                "baseline_m": {"x": rig.baseline_x_m, "y": rig.baseline_y_m},
                "focal_length_mm": rig.focal_length_mm,
                "sensor_size_mm": rig.sensor_size_mm,
                "focus_distance_m": number(rig.focus_distance_m),
            },
            "disparity_px": self.disparity_px.map(|(min, max)| json!({"min": min, "max": max})),
            "files": self.files,
        })
    }

    /// A few lines on standard error.
    pub fn print(&self, out: &Path) {
        let s = &self.seconds;
        let rays = self.rays.total();
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
    let parameters = ManifestRig::from(rig.parameters());
    let range = match disparity_px {
        Some((min, max)) => format!("disparity {} to {} px between neighbouring views", short(min), short(max)),
        None => "no disparity known".into(),
    };
    let focus = match parameters.focus_distance_m {
        distance if distance.is_finite() => format!("{} m", short(distance)),
        _ => "at infinity".into(),
    };
    format!(
        "rig: baseline {} mm, focal length {} mm, sensor {} mm, focus {focus}; {range}",
        short(parameters.baseline_x_m * 1e3),
        short(parameters.focal_length_mm),
        short(parameters.sensor_size_mm),
    )
}

/// Some five digits, and a power of ten only where the number would be unreadable without.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        size if (1e-3..1e6).contains(&size) => {
            let digits = (4 - size.log10().floor() as i32).clamp(0, 7) as usize;
            let text = format!("{x:.digits$}");
            if digits > 0 { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
        }
        _ => format!("{x:.4e}"),
    }
}

/// The name on the command line.
pub fn integrator_name(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::Auto => "auto",
        Integrator::Depth => "depth",
        Integrator::Direct => "direct",
        Integrator::Path => "path",
    }
}

/// JSON has no infinity.
fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { json!("inf") }
}

/// The most memory that this process ever held, where the system tells (Linux).
pub fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (36.0, "36"),
            (1.939_636_9, "1.9396"),
            (-0.024_513_7, "-0.024514"),
            (0.001, "0.001"),
            (123_456.7, "123457"),
            (1e303, "1.0000e303"),
            (-1.25e-7, "-1.2500e-7"),
        ] {
            assert_eq!(short(x), text);
        }
    }
}
