//! Plenoptic cameras that differ from their preset, as no two that are built are the same.

use serde::Deserialize;

use super::distribution::Span;
use crate::built::parts::noise::Random;

/// What is drawn of a camera.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Perturbed {
    rotation_deg: Option<Span>,
    pitch: Option<Span>,
    offset: Option<Span>,
    focus_m: Option<Span>,
}

/// How the plenoptic camera of a scene differs from its preset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraChange {
    /// By how much the microlens array is turned further, in radians.
    pub rotation_rad: f64,
    /// The factor of the pitch and the apertures of the microlenses.
    pub pitch: f64,
    /// By how much the array is moved further, in pitches, to the right and up.
    pub offset: [f64; 2],
    /// The depth that the camera is focused at, in meters; `None`: that of the preset.
    pub focus_m: Option<f64>,
}

impl Perturbed {
    /// The ranges that are given, with the least and the largest number that they may hold.
    pub fn ranges(&self) -> impl Iterator<Item = (&'static str, Span, f64, f64)> {
        let all = [
            ("camera.perturbed.rotation_deg", self.rotation_deg, -45.0, 45.0),
            ("camera.perturbed.pitch", self.pitch, 0.5, 2.0),
            ("camera.perturbed.offset", self.offset, -1.0, 1.0),
            ("camera.perturbed.focus_m", self.focus_m, 1e-3, 1e3),
        ];
        all.into_iter().filter_map(|(key, span, low, high)| Some((key, span?, low, high)))
    }

    pub fn draw(&self, random: &mut Random) -> CameraChange {
        let mut of = |span: Option<Span>| span.map_or(0.0, |span| span.even(random));
        let (rotation, offset) = (of(self.rotation_deg), [of(self.offset), of(self.offset)]);
        let mut factor = |span: Option<Span>| span.map(|span| span.log(random));
        let (pitch, focus_m) = (factor(self.pitch), factor(self.focus_m));
        CameraChange { rotation_rad: rotation.to_radians(), pitch: pitch.unwrap_or(1.0), offset, focus_m }
    }
}
