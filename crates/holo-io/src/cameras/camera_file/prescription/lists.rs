//! Prescriptions as lists of numbers, a line a surface: those of CamGen and of pbrt.

use holo_core::plenoptic::Surface;

use super::{Row, by_numbers};

/// A number of a line, or what is wrong.
fn number(text: &str, what: &str, line: usize) -> Result<f64, String> {
    let found = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    found.ok_or_else(|| format!("line {line}: '{}' is no number for the {what}", crate::shown(text.trim())))
}

/// The lines of CamGen, `radius;thickness;material;index;v-no;sa`: a plane has no radius, air no index and no Abbe number, and a
/// plane between air is the stop. `sa` is the semi-aperture.
pub(super) fn camgen(text: &str) -> Result<Vec<Surface>, String> {
    let mut rows: Vec<Row> = Vec::new();
    for (line, text) in text.lines().enumerate().map(|(k, text)| (k + 1, text.trim())) {
        if text.is_empty() || text.to_lowercase().starts_with("radius") {
            continue;
        }
        let cells: Vec<&str> = text.split(';').map(str::trim).collect();
        let &[radius, thickness, _, index, abbe, semi_aperture] = cells.as_slice() else {
            return Err(format!("line {line}: {} cells; give radius;thickness;material;index;v-no;sa", cells.len()));
        };
        let or = |text: &str, other: f64, what| if text.is_empty() { Ok(other) } else { number(text, what, line) };
        let medium = by_numbers(or(index, 1.0, "index")?, or(abbe, 0.0, "Abbe number")?);
        let radius_mm = or(radius, 0.0, "radius")?;
        let before = rows.last().map_or(holo_core::plenoptic::Medium::Air, |row| row.medium);
        let is_air = [before, medium].iter().all(|medium| *medium == holo_core::plenoptic::Medium::Air);
        rows.push(Row {
            radius_mm,
            thickness_mm: number(thickness, "thickness", line)?,
            semi_aperture_mm: number(semi_aperture, "semi-aperture", line)?,
            medium,
            conic: 0.0,
            aspheric: Vec::new(),
            is_stop: radius_mm == 0.0 && is_air,
        });
    }
    Ok(rows.into_iter().map(Row::surface).collect())
}

/// The lines of pbrt: radius, thickness, index and diameter of the aperture; a radius of 0 is the stop, an index of 0 is air, a
/// line of one number the focal length, and `#` begins a comment.
pub(super) fn pbrt(text: &str) -> Result<Vec<Surface>, String> {
    let mut rows: Vec<Row> = Vec::new();
    for (line, text) in text.lines().enumerate().map(|(k, text)| (k + 1, text.split('#').next().unwrap_or_default())) {
        let cells: Vec<&str> = text.split_whitespace().collect();
        let &[radius, thickness, index, diameter] = cells.as_slice() else {
            if cells.len() <= 1 {
                continue;
            }
            return Err(format!("line {line}: {} numbers; give radius, thickness, index and aperture", cells.len()));
        };
        let radius_mm = number(radius, "radius", line)?;
        let index = number(index, "index", line)?;
        rows.push(Row {
            radius_mm,
            thickness_mm: number(thickness, "thickness", line)?,
            semi_aperture_mm: number(diameter, "aperture", line)? / 2.0,
            medium: by_numbers(if index == 0.0 { 1.0 } else { index }, 0.0),
            conic: 0.0,
            aspheric: Vec::new(),
            is_stop: radius_mm == 0.0,
        });
    }
    Ok(rows.into_iter().map(Row::surface).collect())
}
