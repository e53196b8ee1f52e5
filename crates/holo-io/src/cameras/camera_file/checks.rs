//! Checks of the numbers of a table.

use holo_core::millimeters_to_meters;

pub(crate) fn missing(key: &str) -> String {
    format!("{key} is missing")
}

pub(crate) fn finite(key: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{key} is {value}; give a finite number")) }
}

pub(crate) fn positive(key: &str, value: f64) -> Result<f64, String> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(format!("{key} is {value}; give a number above 0")) }
}

/// Micrometers, or the length of a preset.
pub(crate) fn length(key: &str, um: Option<f64>, base_m: Option<f64>) -> Result<f64, String> {
    match (um, base_m) {
        (Some(um), _) => Ok(meters(positive(key, um)?)),
        (None, Some(base_m)) => Ok(base_m),
        (None, None) => Err(missing(key)),
    }
}

pub(super) fn offset(key: &str, um: Option<[f64; 2]>, base_m: Option<[f64; 2]>) -> Result<[f64; 2], String> {
    match um {
        Some([x, y]) => Ok([meters(finite(key, x)?), meters(finite(key, y)?)]),
        None => Ok(base_m.unwrap_or_default()),
    }
}

/// Micrometers in meters.
pub(super) fn meters(um: f64) -> f64 {
    millimeters_to_meters(millimeters_to_meters(um))
}
