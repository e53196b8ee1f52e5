//! What a render tells when it is done: a summary for people, one JSON object for programs.

use std::path::Path;

use holo_core::Rig;
use holo_dataset::options::integrator_name;
use holo_dataset::{RenderReport, Seconds};
use holo_io::meters_to_millimeters;
use holo_render::RayCounts;
use serde_json::{Value, json};

use crate::console::say;

/// Rays of all kinds a second of rendering, in millions.
pub fn mrays_per_second(report: &RenderReport) -> f64 {
    report.rays.total() as f64 / report.seconds.render.max(1e-9) / 1e6
}

/// What one of many renders tells.
pub fn run_json(report: &RenderReport) -> Value {
    json!({
        "seconds": seconds(&report.seconds),
        "rays": rays(report.rays),
        "samples": report.samples,
        "integrator": integrator_name(report.integrator),
    })
}

/// The object of `--json`.
pub fn json(report: &RenderReport) -> Value {
    let rig = &report.rig;
    let size = |s: holo_core::GridSize| json!({"columns": s.columns, "rows": s.rows});
    json!({
        "seconds": seconds(&report.seconds),
        "rays": rays(report.rays),
        "samples": report.samples,
        "backend": report.backend,
        "threads": report.threads,
        "peak_rss_bytes": peak_rss_bytes(),
        "integrator": {"name": integrator_name(report.integrator), "why": report.why},
        "rig": {
            "views": size(rig.shape().views()), "lenses": size(rig.shape().lenses()),
            "baseline_m": {"x": rig.baseline_x_m(), "y": rig.baseline_y_m()},
            "focal_length_mm": meters_to_millimeters(rig.focal_length_m()),
            "sensor_size_mm": meters_to_millimeters(rig.sensor_size_m()),
            "focus_distance_m": number(rig.focus_distance_m()),
        },
        "disparity_px": report.disparity_px.map(|(min, max)| json!({"min": min, "max": max})),
        "files": report.files,
    })
}

/// A few lines on standard error.
pub fn print(report: &RenderReport, out: &Path) {
    let s = &report.seconds;
    say!(
        "rendered {} in {:.2} s ({:.1} Mrays/s, {}, {} threads, {}: {})",
        describe_split(&report.rig),
        s.render,
        mrays_per_second(report),
        report.backend,
        report.threads,
        integrator_name(report.integrator),
        report.why
    );
    say!("{}", describe_rig(&report.rig, report.disparity_px));
    say!(
        "wrote {} files to {} ({:.2} s; load {:.2} s, build {:.2} s, total {:.2} s)",
        report.files.len(),
        out.display(),
        s.write,
        s.load,
        s.build,
        s.total
    );
}

fn rays(rays: RayCounts) -> Value {
    json!({"primary": rays.primary, "shadow": rays.shadow, "other": rays.other})
}

fn seconds(s: &Seconds) -> Value {
    json!({"load": s.load, "build": s.build, "render": s.render, "write": s.write, "total": s.total})
}

/// Views, lenses and raw size in words.
pub fn describe_split(rig: &Rig) -> String {
    let (split, raw) = (rig.shape(), rig.shape().raw_size());
    let (views, lenses) = (split.views(), split.lenses());
    format!(
        "{} x {} views of {} x {} px (raw image {} x {})",
        views.columns, views.rows, lenses.columns, lenses.rows, raw.columns, raw.rows
    )
}

/// The rig's lengths in words.
pub fn describe_rig(rig: &Rig, disparity_px: Option<(f64, f64)>) -> String {
    let range = match disparity_px {
        Some((min, max)) => format!("disparity {} to {} px between neighbouring views", short(min), short(max)),
        None => "no disparity known".into(),
    };
    let focus = match rig.focus_distance_m() {
        distance if distance.is_finite() => format!("{} m", short(distance)),
        _ => "at infinity".into(),
    };
    format!(
        "rig: baseline {} mm, focal length {} mm, sensor {} mm, focus {focus}; {range}",
        short(rig.baseline_x_m() * 1e3),
        short(meters_to_millimeters(rig.focal_length_m())),
        short(meters_to_millimeters(rig.sensor_size_m())),
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
