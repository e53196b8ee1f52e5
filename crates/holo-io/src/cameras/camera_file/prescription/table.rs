//! Prescriptions as TOML.
//!
//! ```toml
//! [[surface]]                # from the scene to the sensor
//! radius_mm = 29.475         # above 0 where the center of curvature lies towards the sensor; left out: a plane
//! thickness_mm = 3.76        # to the next surface; left out: 0
//! semi_aperture_mm = 12.6
//! material = "N-BAF10"       # behind the surface: a glass of the table, or its numbers:
//! # nd = 1.67                #   the index at 587.6 nm; left out with material: air
//! # vd = 47.1                #   the Abbe number; left out: no dispersion
//! # conic = 0.0
//! # a4 = 0.0                 # coefficients of r^4 to r^18 of the sag, in 1/mm^3 to 1/mm^17
//! # stop = true              # of one surface
//! ```

use std::fmt::Write as _;

use holo_core::meters_to_millimeters;
use holo_core::plenoptic::{Medium, Surface};
use serde::Deserialize;

use super::{Row, by_numbers, glass};
use crate::cameras::camera_file::checks::missing;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    /// For people.
    #[serde(default, rename = "name")]
    _name: Option<String>,
    surface: Vec<SurfaceTable>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(in crate::cameras::camera_file) struct SurfaceTable {
    radius_mm: f64,
    thickness_mm: f64,
    semi_aperture_mm: Option<f64>,
    material: Option<String>,
    nd: Option<f64>,
    vd: Option<f64>,
    conic: f64,
    a4: f64,
    a6: f64,
    a8: f64,
    a10: f64,
    a12: f64,
    a14: f64,
    a16: f64,
    a18: f64,
    stop: bool,
}

impl SurfaceTable {
    /// The surface, which is the `number`-th from the scene.
    pub fn surface(&self, number: usize) -> Result<Surface, String> {
        let at = |what: String| format!("surface {number}: {what}");
        let semi_aperture_mm = self.semi_aperture_mm.ok_or_else(|| at(missing("semi_aperture_mm")))?;
        let medium = match (&self.material, self.nd) {
            (Some(_), Some(_)) => return Err(at("material and nd: give one of them".into())),
            (Some(name), None) if name.eq_ignore_ascii_case("air") => Medium::Air,
            (Some(name), None) => glass(name).map_err(at)?,
            (None, Some(nd)) => by_numbers(nd, self.vd.unwrap_or(0.0)),
            (None, None) => Medium::Air,
        };
        if self.vd.is_some() && self.nd.is_none() {
            return Err(at("vd belongs to nd, which is not given".into()));
        }
        let aspheric = vec![self.a4, self.a6, self.a8, self.a10, self.a12, self.a14, self.a16, self.a18];
        let (radius_mm, thickness_mm, conic, is_stop) = (self.radius_mm, self.thickness_mm, self.conic, self.stop);
        Ok(Row { radius_mm, thickness_mm, semi_aperture_mm, medium, conic, aspheric, is_stop }.surface())
    }
}

pub(super) fn surfaces(text: &str) -> Result<Vec<Surface>, String> {
    let document: Document = toml::from_str(text).map_err(|why| super::super::explained(&why))?;
    document.surface.iter().zip(1..).map(|(surface, number)| surface.surface(number)).collect()
}

/// The tables of a prescription, each below a header.
pub(in crate::cameras::camera_file) fn surface_lines(surfaces: &[Surface], header: &str) -> String {
    let mut text = String::new();
    for surface in surfaces {
        let mm = |meters: f64| format!("{:?}", meters_to_millimeters(meters));
        let mut line = |key: &str, value: String| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{key} = {value}");
        };
        line(&format!("\n[[{header}]]\nradius_mm"), mm(surface.radius_m));
        line("thickness_mm", mm(surface.thickness_m));
        line("semi_aperture_mm", mm(surface.semi_aperture_m));
        match surface.medium {
            Medium::Air => {}
            Medium::Glass(glass) => line("material", format!("\"{}\"", glass.name)),
            Medium::Abbe { nd, vd } => {
                line("nd", format!("{nd:?}"));
                if let Some(vd) = vd {
                    line("vd", format!("{vd:?}"));
                }
            }
        }
        if surface.conic != 0.0 {
            line("conic", format!("{:?}", surface.conic));
        }
        for (a, k) in surface.aspheric.iter().zip(0..) {
            line(&format!("a{}", 4 + 2 * k), format!("{:?}", a / 1e3f64.powi(3 + 2 * k)));
        }
        if surface.is_stop {
            line("stop", "true".into());
        }
    }
    text
}
