//! Focal length, principal planes and pupils of a lens: its rays near the axis.

use super::Surface;
use super::glass::D_LINE_NM;
use crate::Error;

/// What follows from the surfaces of a lens for rays near the axis.
///
/// # Units
///
/// Meters along the axis, towards the sensor.
///
/// # Source
///
/// Products of the matrices of refraction and transfer, as in Welford, "Aberrations of optical systems" (1986), ch. 3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paraxial {
    /// The focal length.
    pub focal_length_m: f64,
    /// Focal length / diameter of the entrance pupil.
    pub f_number: f64,
    /// From the last surface to the image of what is infinitely far.
    pub back_focal_m: f64,
    /// From the first surface to the front principal plane.
    pub front_principal_m: f64,
    /// From the last surface to the rear principal plane.
    pub rear_principal_m: f64,
    /// From the first surface to the entrance pupil.
    pub entrance_pupil_m: f64,
    /// From the last surface to the exit pupil.
    pub exit_pupil_m: f64,
    /// From the first surface to the last one.
    pub length_m: f64,
}

/// The height and the reduced slope (index times slope) of a ray behind a part of a lens, from those before it.
#[derive(Clone, Copy)]
struct Matrix([[f64; 2]; 2]);

impl Matrix {
    const UNIT: Self = Self([[1.0, 0.0], [0.0, 1.0]]);

    /// What this part and then another one do.
    fn then(self, Self([[a, b], [c, d]]): Self) -> Self {
        let Self([[e, f], [g, h]]) = self;
        Self([[a * e + b * g, a * f + b * h], [c * e + d * g, c * f + d * h]])
    }

    fn refraction(surface: &Surface, before: f64, behind: f64) -> Self {
        Self([[1.0, 0.0], [-(behind - before) * surface.curvature_per_m(), 1.0]])
    }

    fn transfer(distance_m: f64, index: f64) -> Self {
        Self([[1.0, distance_m / index], [0.0, 1.0]])
    }
}

impl Paraxial {
    pub(super) fn new(surfaces: &[Surface]) -> Result<Self, Error> {
        Self::at(surfaces, D_LINE_NM)
    }

    /// The same for another wavelength.
    pub(in crate::plenoptic) fn at(surfaces: &[Surface], wavelength_nm: f64) -> Result<Self, Error> {
        let (mut front, mut rear) = (Matrix::UNIT, Matrix::UNIT);
        let (mut before, mut length_m, mut stop_radius_m) = (1.0, 0.0, 0.0);
        for (k, surface) in surfaces.iter().enumerate() {
            let behind = surface.medium.index(wavelength_nm);
            if surface.is_stop {
                (front, rear) = (rear, Matrix::UNIT);
                stop_radius_m = surface.semi_aperture_m;
            }
            rear = rear.then(Matrix::refraction(surface, before, behind));
            if k + 1 < surfaces.len() {
                rear = rear.then(Matrix::transfer(surface.thickness_m, behind));
                length_m += surface.thickness_m;
            }
            before = behind;
        }
        let Matrix([[a, _], [c, d]]) = front.then(rear);
        let (Matrix([[to_stop, from_slope], _]), Matrix([[_, height], [_, slope]])) = (front, rear);
        let focal_length_m = -1.0 / c;
        let found = Self {
            focal_length_m,
            f_number: focal_length_m / (2.0 * stop_radius_m / to_stop.abs()),
            back_focal_m: -a / c,
            front_principal_m: (d - 1.0) / c,
            rear_principal_m: (1.0 - a) / c,
            entrance_pupil_m: from_slope / to_stop,
            exit_pupil_m: -height / slope,
            length_m,
        };
        let need = "finite and above 0: the lens must gather light";
        for (what, value) in [
            ("focal length of the lens surfaces in meters", focal_length_m),
            ("f-number of the lens surfaces", found.f_number),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::BadNumber { what, value, need });
            }
        }
        for (what, value) in [
            ("distance of the entrance pupil from the first lens surface in meters", found.entrance_pupil_m),
            ("distance of the exit pupil from the last lens surface in meters", found.exit_pupil_m),
            ("distance of the focus from the last lens surface in meters", found.back_focal_m),
        ] {
            if !value.is_finite() {
                return Err(Error::BadNumber { what, value, need: "finite" });
            }
        }
        Ok(found)
    }

    /// Returns the distance from the rear principal plane to the exit pupil, towards the sensor, in meters.
    #[must_use]
    pub(crate) fn exit_pupil_from_principal_m(&self) -> f64 {
        self.exit_pupil_m - self.rear_principal_m
    }

    /// Returns the distance from the front principal plane to the entrance pupil, towards the scene, in meters.
    #[must_use]
    pub(crate) fn entrance_pupil_from_principal_m(&self) -> f64 {
        self.front_principal_m - self.entrance_pupil_m
    }
}
