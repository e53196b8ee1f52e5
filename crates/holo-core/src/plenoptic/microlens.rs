//! One microlens of a camera, with the numbers that its rays need.

use super::MicrolensIndex;
use super::main_lens::Pupils;

/// A ray into the scene, in the frame of the entrance pupil.
///
/// As for [`RigRay`](crate::RigRay) the direction along z is -1: the point at depth Z is `(origin + Z * direction, -Z)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlenopticRay {
    /// Where it crosses the entrance pupil's plane z = 0, x and y in meters.
    pub origin_m: [f64; 2],
    /// The displacement per meter of depth, in meters.
    pub direction: [f64; 2],
}

/// A microlens of a camera, or the clear gap around it, with the numbers that its rays need.
///
/// Places on the sensor are given from the center of the micro-image, points of the microlens from its own center, all in
/// meters in upright coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microlens {
    /// Its row and column.
    pub index: MicrolensIndex,
    /// Its type; for a gap the number of types.
    pub lens_type: usize,
    /// Its center, in meters from the axis.
    pub center_m: [f64; 2],
    /// The center of its micro-image: the projection of its center from the exit pupil.
    pub image_center_m: [f64; 2],
    /// The distance to the sensor, in meters.
    pub gap_m: f64,
    /// The displacement over the exit pupil per displacement on the microlens.
    pub alpha: f64,
    pub(super) pupils: Pupils,
    pub(super) pupil: LitPupil,
}

/// A disc in the plane of the exit pupil that holds all light for a microlens, in meters from the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LitPupil {
    pub center_m: [f64; 2],
    /// 0 for a microlens that no light reaches.
    pub radius_m: f64,
    /// The radius around the axis within which all is light, for a round pupil; below 0 if there is none.
    pub inner_m: f64,
}

/// How the rays of a microlens depend on the points that they pass, without distortion and near the axis of a lens of glass, along x and y alike: a point X from
/// the center of the micro-image and a point Q from the center of the microlens, both in meters.
///
/// origin = `origin_per_sensor` X - `origin_per_lens` Q, direction = `slope_per_m` (C + Q) - `inverse_focus_per_m` origin
/// for the [center](Microlens::center_m) C.
///
/// # Source
///
/// See [`PlenopticCamera::ray`](super::PlenopticCamera::ray).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayCoefficients {
    /// The displacement of the origin per displacement on the sensor (m D_X / d).
    pub origin_per_sensor: f64,
    /// The displacement of the origin against a displacement on the microlens (m alpha).
    pub origin_per_lens: f64,
    /// The slope of the chief ray per meter on the array (g), in 1/m.
    pub slope_per_m: f64,
    /// 1 / depth of the plane in focus (1 / F), in 1/m.
    pub inverse_focus_per_m: f64,
}

impl Microlens {
    /// Returns the distance from the array to the exit pupil that it sees, in meters: where its chief ray crosses the axis.
    #[inline]
    #[must_use]
    pub const fn exit_pupil_m(&self) -> f64 {
        self.pupils.exit_m
    }

    /// Returns how its rays depend on the points that they pass.
    #[inline]
    #[must_use]
    pub fn ray_coefficients(&self) -> RayCoefficients {
        let Pupils { magnification, exit_m, inverse_focus_per_m, slope_per_m, .. } = self.pupils;
        RayCoefficients {
            origin_per_sensor: magnification * exit_m / self.gap_m,
            origin_per_lens: magnification * self.alpha,
            slope_per_m,
            inverse_focus_per_m,
        }
    }
}
