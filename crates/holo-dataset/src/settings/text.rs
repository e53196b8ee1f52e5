//! Shapes, rigs, numbers and sizes in words, as `holo` prints them.

use holo_core::{LightFieldShape, Rig};
use holo_io::meters_to_millimeters;
use serde_json::{Value, json};

/// Numbers of views and microlenses, and the size of the raw image.
#[must_use]
pub fn shape(shape: &LightFieldShape) -> String {
    let (views, lenses, raw) = (shape.views(), shape.lenses(), shape.raw_size());
    format!(
        "{} x {} views of {} x {} px (raw image {} x {})",
        views.columns, views.rows, lenses.columns, lenses.rows, raw.columns, raw.rows
    )
}

/// The lengths of a rig, and the disparities of what it sees, smallest and largest, px.
#[must_use]
pub fn rig(rig: &Rig, disparity_px: Option<(f64, f64)>) -> String {
    // Less is the rounding of depths.
    let pixels = |px: f64| number(if px.abs() < 1e-9 { 0.0 } else { px });
    let range = match disparity_px {
        Some((min, max)) => format!("disparity {} to {} px between adjacent views", pixels(min), pixels(max)),
        None => "disparity range unknown".into(),
    };
    let focus = match rig.focus_distance_m() {
        distance if distance.is_finite() => format!("{} m", number(distance)),
        _ => "at infinity".into(),
    };
    format!(
        "rig: baseline {} mm, focal length {} mm, sensor {} mm, focus {focus}; {range}",
        number(rig.baseline_x_m() * 1e3),
        number(meters_to_millimeters(rig.focal_length_m())),
        number(meters_to_millimeters(rig.sensor_size_m())),
    )
}

/// Some five digits, and a power of ten only where the number would be unreadable without.
#[must_use]
pub fn number(x: f64) -> String {
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

/// A number of a JSON file. JSON has neither infinity nor NaN: these are the texts `"inf"`, `"-inf"` and `"NaN"`.
pub(crate) fn json_number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { json!(x.to_string()) }
}

/// A number of things.
pub(crate) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A number of bytes, in kB, MB or GB of powers of ten.
#[must_use]
pub fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        bytes if bytes < 1e6 => format!("{:.0} kB", bytes / 1e3),
        bytes if bytes < 1e9 => format!("{:.0} MB", bytes / 1e6),
        bytes => format!("{:.1} GB", bytes / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people_are_number() {
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
            assert_eq!(number(x), text);
        }
    }
}
