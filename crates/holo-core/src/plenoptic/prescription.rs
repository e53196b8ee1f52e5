//! A main lens of glass: its surfaces one behind the other, and what follows from them near the axis.

mod field;
mod focus;
mod glass;
mod objectives;
mod paraxial;
mod trace;

pub use glass::{Glass, Medium, glasses};
pub use objectives::{Objective, objectives};
pub use paraxial::Paraxial;
pub use trace::LensRays;

pub(super) use field::{Field, FieldTable, LightEdge, chief_direction};
pub(super) use trace::TracedLens;

use crate::Error;
use crate::base::error::positive;

/// The largest number of surfaces of a lens.
const MAX_SURFACES: usize = 64;

/// The largest number of aspheric coefficients of a surface.
const MAX_COEFFICIENTS: usize = 8;

/// The largest length in a prescription, m.
const MAX_LENGTH_M: f64 = 1e3;

/// A surface of a lens, and the medium behind it.
///
/// # Units
///
/// Meters.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// The radius of curvature, above 0 where the center of curvature lies towards the sensor; 0 for a plane.
    pub radius_m: f64,
    /// The distance to the next surface on the axis; that of the last surface is ignored.
    pub thickness_m: f64,
    /// Half of the diameter through which light passes.
    pub semi_aperture_m: f64,
    /// What lies behind the surface, towards the sensor.
    pub medium: Medium,
    /// The conic constant: 0 for a sphere, -1 for a paraboloid.
    pub conic: f64,
    /// The coefficients of r^4, r^6 and so on of the sag, in 1/m^3, 1/m^5 and so on.
    pub aspheric: Vec<f64>,
    /// Whether it is the aperture stop.
    pub is_stop: bool,
}

impl Surface {
    /// Returns a spherical surface that is not the stop.
    #[must_use]
    pub const fn sphere(radius_m: f64, thickness_m: f64, semi_aperture_m: f64, medium: Medium) -> Self {
        Self { radius_m, thickness_m, semi_aperture_m, medium, conic: 0.0, aspheric: Vec::new(), is_stop: false }
    }

    /// Returns a stop in air.
    #[must_use]
    pub fn stop(thickness_m: f64, semi_aperture_m: f64) -> Self {
        Self { is_stop: true, ..Self::sphere(0.0, thickness_m, semi_aperture_m, Medium::Air) }
    }

    /// Returns 1 / radius; 0 for a plane.
    #[must_use]
    pub(crate) fn curvature_per_m(&self) -> f64 {
        if self.radius_m == 0.0 { 0.0 } else { 1.0 / self.radius_m }
    }

    /// Checks that light can pass.
    fn validate(&self) -> Result<(), Error> {
        let finite = |what, value: f64| match value.is_finite() && value.abs() <= MAX_LENGTH_M {
            true => Ok(()),
            false => Err(Error::BadNumber { what, value, need: "finite, at most 1000 m" }),
        };
        finite("radius of a lens surface in meters", self.radius_m)?;
        finite("thickness behind a lens surface in meters", self.thickness_m)?;
        if self.thickness_m < 0.0 {
            let (what, value) = ("thickness behind a lens surface in meters", self.thickness_m);
            return Err(Error::BadNumber { what, value, need: "0 or more" });
        }
        positive("semi-aperture of a lens surface in meters", self.semi_aperture_m)?;
        finite("semi-aperture of a lens surface in meters", self.semi_aperture_m)?;
        finite("conic constant of a lens surface", self.conic)?;
        if self.aspheric.len() > MAX_COEFFICIENTS {
            let (what, value) = ("number of aspheric coefficients of a lens surface", self.aspheric.len() as f64);
            return Err(Error::BadNumber { what, value, need: "at most 8" });
        }
        if let Some(&value) = self.aspheric.iter().find(|value| !value.is_finite()) {
            return Err(Error::BadNumber { what: "aspheric coefficient of a lens surface", value, need: "finite" });
        }
        self.medium.validate()
    }
}

/// The surfaces of a main lens, from the scene to the sensor.
///
/// It has at most 64 surfaces. One of them is the stop. Air lies in front of the first and behind the last. The lens gathers light.
#[derive(Debug, Clone, PartialEq)]
pub struct Prescription {
    surfaces: Vec<Surface>,
    paraxial: Paraxial,
}

impl Prescription {
    /// Validates a lens.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] for a number out of its range, no stop or more than one, glass behind the last surface, and for a
    /// lens without a focal length above 0 or with a pupil at infinity.
    pub fn new(surfaces: Vec<Surface>) -> Result<Self, Error> {
        if surfaces.is_empty() || surfaces.len() > MAX_SURFACES {
            let (what, value) = ("number of lens surfaces", surfaces.len() as f64);
            return Err(Error::BadNumber { what, value, need: "1 to 64" });
        }
        surfaces.iter().try_for_each(Surface::validate)?;
        let stops = surfaces.iter().filter(|surface| surface.is_stop).count();
        if stops != 1 {
            return Err(Error::BadNumber { what: "number of stops of a lens", value: stops as f64, need: "1" });
        }
        if let Some(last) = surfaces.last().filter(|last| last.medium != Medium::Air) {
            let value = last.medium.index(glass::D_LINE_NM);
            let what = "refractive index behind the last lens surface";
            return Err(Error::BadNumber { what, value, need: "1: the sensor lies in air" });
        }
        let paraxial = Paraxial::new(&surfaces)?;
        Ok(Self { surfaces, paraxial })
    }

    /// Returns the surfaces.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Returns what follows from the surfaces near the axis, for light of the d line (587.6 nm).
    #[must_use]
    pub const fn paraxial(&self) -> &Paraxial {
        &self.paraxial
    }

    /// Returns the same lens with all lengths scaled, so that it has another focal length.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the focal length is not above 0, or a length becomes too large.
    pub fn scaled_to(&self, focal_length_m: f64) -> Result<Self, Error> {
        let factor =
            positive("focal length of the main lens in meters", focal_length_m)? / self.paraxial.focal_length_m;
        let scaled = |surface: &Surface| Surface {
            radius_m: factor * surface.radius_m,
            thickness_m: factor * surface.thickness_m,
            semi_aperture_m: factor * surface.semi_aperture_m,
            aspheric: (surface.aspheric.iter().zip(0..)).map(|(a, k)| a / factor.powi(3 + 2 * k)).collect(),
            ..surface.clone()
        };
        Self::new(self.surfaces.iter().map(scaled).collect())
    }

    /// Returns the same lens with its stop closed to an f-number.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the f-number is below that of the open lens.
    pub fn stopped_down(&self, f_number: f64) -> Result<Self, Error> {
        let open = self.paraxial.f_number;
        // The f-number that a file gives for the open lens is rounded.
        if !f_number.is_finite() || f_number < 0.999 * open {
            let need = "at least that of the open lens";
            return Err(Error::BadNumber { what: "f-number of the main lens", value: f_number, need });
        }
        self.with_stop(self.stop_m() * (open / f_number).min(1.0))
    }

    /// Half of the diameter of the stop, m.
    pub(super) fn stop_m(&self) -> f64 {
        self.surfaces.iter().filter(|surface| surface.is_stop).map(|stop| stop.semi_aperture_m).sum()
    }

    /// The same lens with another stop.
    pub(super) fn with_stop(&self, semi_aperture_m: f64) -> Result<Self, Error> {
        let mut surfaces = self.surfaces.clone();
        for stop in surfaces.iter_mut().filter(|surface| surface.is_stop) {
            stop.semi_aperture_m = semi_aperture_m;
        }
        Self::new(surfaces)
    }
}

#[cfg(test)]
mod tests;
