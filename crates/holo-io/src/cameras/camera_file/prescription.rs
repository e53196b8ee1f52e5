//! Prescriptions of main lenses: tables of surfaces, as TOML and as other programs write them.
//!
//! | file | program | notes |
//! |---|---|---|
//! | `.toml` | holo | the keys of [`SurfaceTable`]; also in camera files, as `[[main_lens.surface]]` |
//! | `.csv` | CamGen | `radius;thickness;material;index;v-no;sa` |
//! | `.dat` | pbrt, ISET3d | radius, thickness, index and diameter of every surface; no dispersion |
//! | `.zmx` | Zemax | sequential, of standard and even aspheric surfaces with their diameters |
//! | `.json` | DeepLens | spherical and aspheric surfaces |
//!
//! All give millimeters, and surfaces from the scene to the sensor.

mod deeplens;
mod lists;
mod table;
mod zemax;

use std::path::{Component, Path, PathBuf};

use holo_core::plenoptic::{Glass, Medium, Objective, Prescription, Surface, objectives};
pub(super) use table::{SurfaceTable, surface_lines};

use super::suggestion;
use crate::files::limits::read_small_file;
use crate::{Error, Folder};

/// The largest file of a prescription, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The endings of files of prescriptions.
const ENDINGS: &str = ".toml, .csv (CamGen), .dat (pbrt), .zmx (Zemax) or .json (DeepLens)";

/// Reads the prescription of a main lens, or returns that of an objective of this name.
///
/// # Errors
/// [`Error::Io`] if a file cannot be read; [`Error::Broken`] if it is no lens. The message names the surface or the line.
pub fn read_prescription(path_or_objective: &str) -> Result<Prescription, Error> {
    let path = Path::new(path_or_objective);
    if !path.is_file()
        && let Some(found) = Objective::by_name(path_or_objective)
    {
        return found.prescription().map_err(|why| Error::Camera(why.to_string()));
    }
    decoded(&read_small_file(path, MAX_BYTES)?, path)
}

/// The lens of a file.
fn decoded(bytes: &[u8], path: &Path) -> Result<Prescription, Error> {
    let broken = |what: String| Error::Broken { path: path.into(), format: "prescription", what };
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    let read: fn(&str) -> Result<Vec<Surface>, String> = match ending.as_str() {
        "toml" => table::surfaces,
        "csv" => lists::camgen,
        "dat" => lists::pbrt,
        "zmx" => zemax::surfaces,
        "json" => deeplens::surfaces,
        _ => return Err(broken(format!("its name ends neither in {ENDINGS}"))),
    };
    let text = text(bytes).ok_or_else(|| broken("it is not text in UTF-8 or UTF-16".into()))?;
    let surfaces = read(&text).map_err(broken)?;
    Prescription::new(surfaces).map_err(|why| broken(why.to_string()))
}

/// The text of a file in UTF-8, or in UTF-16 with its mark as Zemax writes it.
fn text(bytes: &[u8]) -> Option<String> {
    let units = |to_unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| to_unit([pair[0], pair[1]])).collect();
        String::from_utf16(&units).ok()
    };
    match bytes {
        [0xff, 0xfe, ..] => units(u16::from_le_bytes),
        [0xfe, 0xff, ..] => units(u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8(rest.to_vec()).ok(),
        // Latin-1 in comments: numbers and names of glass are ASCII.
        _ => Some(String::from_utf8_lossy(bytes).into_owned()),
    }
}

/// Where a camera file may name another file from.
#[derive(Clone, Copy)]
pub(super) enum Beside<'a> {
    /// A text without a place.
    Nowhere,
    /// A camera file.
    File(&'a Path),
    /// A camera file of an open folder.
    Folder(&'a Folder),
}

impl Beside<'_> {
    /// The lens of a file beside the camera file, or the objective of this name.
    ///
    /// A file is named below the folder of the camera file, whose author may be a stranger.
    pub fn prescription(self, name: &str) -> Result<Prescription, String> {
        const KEY: &str = "main_lens.prescription";
        if let Some(found) = Objective::by_name(name) {
            return found.prescription().map_err(|why| format!("{KEY}: {why}"));
        }
        let path = PathBuf::from(name);
        let is_below = path.components().all(|part| matches!(part, Component::Normal(_)));
        let names = objectives().iter().map(|objective| objective.name);
        if !path.to_string_lossy().contains('.') {
            let advice = suggestion(name, names.clone());
            let names = names.collect::<Vec<_>>().join(", ");
            let name = crate::shown(name);
            return Err(format!("{KEY}: there is no objective '{name}'{advice}; there are {names}, or name a file"));
        }
        if !is_below {
            let name = crate::shown(name);
            return Err(format!("{KEY} is '{name}'; name a file in the folder of the camera file, or below it"));
        }
        let read = match self {
            Self::Nowhere => return Err(format!("{KEY}: the camera is not in a file, beside which '{name}' could be")),
            Self::File(file) => Folder::beside(file).and_then(|folder| folder.read(name, MAX_BYTES)),
            Self::Folder(folder) => folder.read(name, MAX_BYTES),
        };
        let bytes = read.map_err(|why| format!("{KEY}: {why}"))?;
        decoded(&bytes, &path).map_err(|why| format!("{KEY}: {why}"))
    }
}

/// A surface in millimeters, as files list them.
struct Row {
    radius_mm: f64,
    thickness_mm: f64,
    semi_aperture_mm: f64,
    medium: Medium,
    conic: f64,
    /// The coefficients of r^4, r^6 and so on, in 1/mm^3, 1/mm^5 and so on.
    aspheric: Vec<f64>,
    is_stop: bool,
}

impl Row {
    fn surface(self) -> Surface {
        let mut aspheric: Vec<f64> = self.aspheric.iter().zip(0..).map(|(a, k)| a * 1e3f64.powi(3 + 2 * k)).collect();
        while aspheric.last() == Some(&0.0) {
            aspheric.pop();
        }
        Surface {
            radius_m: holo_core::millimeters_to_meters(self.radius_mm),
            thickness_m: holo_core::millimeters_to_meters(self.thickness_mm),
            semi_aperture_m: holo_core::millimeters_to_meters(self.semi_aperture_mm),
            medium: self.medium,
            conic: self.conic,
            aspheric,
            is_stop: self.is_stop,
        }
    }
}

/// The glass of a name, or a suggestion.
fn glass(name: &str) -> Result<Medium, String> {
    if let Some(found) = Glass::by_name(name) {
        return Ok(Medium::Glass(found));
    }
    let all = holo_core::plenoptic::glasses().iter().map(|glass| glass.name);
    let advice = suggestion(&name.to_uppercase(), all);
    Err(format!("'{}' is no glass of the table{advice}; give its nd and vd", crate::shown(name)))
}

/// A medium by its numbers; an Abbe number of 0 is none.
fn by_numbers(nd: f64, vd: f64) -> Medium {
    match nd {
        1.0 => Medium::Air,
        _ => Medium::Abbe { nd, vd: (vd != 0.0).then_some(vd) },
    }
}

#[cfg(test)]
mod tests;
