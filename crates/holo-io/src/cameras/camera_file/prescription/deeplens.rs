//! Prescriptions of DeepLens.

use holo_core::plenoptic::{Medium, Surface};
use serde::Deserialize;

use super::{Row, by_numbers, glass};

#[derive(Deserialize)]
struct Document {
    surfaces: Vec<LensSurface>,
}

#[derive(Deserialize)]
struct LensSurface {
    #[serde(rename = "type")]
    kind: String,
    r: f64,
    c: Option<f64>,
    roc: Option<f64>,
    d: Option<f64>,
    d_next: Option<f64>,
    mat2: String,
    #[serde(default)]
    k: f64,
    #[serde(default)]
    ai: Vec<f64>,
    use_ai2: Option<bool>,
}

pub(super) fn surfaces(text: &str) -> Result<Vec<Surface>, String> {
    let document: Document = serde_json::from_str(text).map_err(|why| why.to_string())?;
    let all = &document.surfaces;
    (0..all.len())
        .map(|k| row(&all[k], all.get(k + 1)).map(Row::surface).map_err(|why| format!("surface {}: {why}", k + 1)))
        .collect()
}

/// A surface and the one behind it.
fn row(surface: &LensSurface, next: Option<&LensSurface>) -> Result<Row, String> {
    let is_stop = matches!(surface.kind.as_str(), "Stop" | "Aperture");
    if !is_stop && !matches!(surface.kind.as_str(), "Spheric" | "Aspheric" | "Plane") {
        let kind = crate::shown(&surface.kind);
        return Err(format!("its type is '{kind}'; Spheric, Aspheric, Plane, Aperture and Stop are read"));
    }
    let radius_mm = match (surface.roc, surface.c) {
        (Some(radius), _) => radius,
        (None, Some(c)) if c != 0.0 => 1.0 / c,
        _ => 0.0,
    };
    let thickness_mm = match (surface.d_next, surface.d, next) {
        (Some(thickness), ..) => thickness,
        (None, Some(d), Some(LensSurface { d: Some(next), .. })) => next - d,
        (None, _, None) => 0.0,
        _ => return Err("it has neither d_next nor d".into()),
    };
    // Coefficients begin with that of r^2, unless the file says otherwise.
    let first = usize::from(surface.use_ai2 != Some(false)).min(surface.ai.len());
    if surface.ai[..first].iter().any(|&a| a != 0.0) {
        return Err("its sag has a term of r^2; bring that into the radius".into());
    }
    Ok(Row {
        radius_mm,
        thickness_mm,
        semi_aperture_mm: surface.r,
        medium: medium(&surface.mat2)?,
        conic: surface.k,
        aspheric: surface.ai[first..].to_vec(),
        is_stop,
    })
}

/// A name of glass, or `index/Abbe number`.
fn medium(text: &str) -> Result<Medium, String> {
    if matches!(text.to_lowercase().as_str(), "air" | "vacuum") {
        return Ok(Medium::Air);
    }
    let numbers = text.split_once('/').and_then(|(nd, vd)| Some((nd.trim().parse().ok()?, vd.trim().parse().ok()?)));
    numbers.map_or_else(|| glass(text), |(nd, vd)| Ok(by_numbers(nd, vd)))
}
