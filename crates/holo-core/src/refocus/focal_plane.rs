//! A plane of focus, which may be tilted.

use crate::Error;
use crate::base::error::positive_or_infinite;

/// A plane of focus before a camera.
///
/// At `x` meters to the right of the optical axis and `y` meters above it its depth is `distance + x tan(right) + y tan(up)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FocalPlane {
    distance_m: f64,
    slopes: [f64; 2],
}

impl FocalPlane {
    /// Returns the plane at a distance on the optical axis, perpendicular to it.
    ///
    /// # Units
    ///
    /// Planar depth in meters; infinity is allowed.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the distance is not above 0.
    pub fn new(distance_m: f64) -> Result<Self, Error> {
        Ok(Self { distance_m: positive_or_infinite("distance in meters", distance_m)?, slopes: [0.0; 2] })
    }

    /// Tilts the plane about the point where the optical axis meets it: the right side and the upper side move away by these angles.
    ///
    /// # Units
    ///
    /// Radians.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if an angle does not lie between -pi/2 and pi/2, or the plane is at infinity.
    pub fn tilted(self, right_rad: f64, up_rad: f64) -> Result<Self, Error> {
        for value in [right_rad, up_rad] {
            let is_tilt = value.abs() < std::f64::consts::FRAC_PI_2;
            if !is_tilt {
                return Err(Error::BadNumber { what: "tilt in radians", value, need: "between -pi/2 and pi/2" });
            }
        }
        if self.distance_m.is_infinite() && (right_rad, up_rad) != (0.0, 0.0) {
            let (what, need) = ("distance of a tilted plane in meters", "finite");
            return Err(Error::BadNumber { what, value: self.distance_m, need });
        }
        Ok(Self { slopes: [right_rad.tan(), up_rad.tan()], ..self })
    }

    /// Whether it is perpendicular to the optical axis.
    pub(crate) fn is_straight(&self) -> bool {
        self.slopes == [0.0; 2]
    }

    pub(crate) fn distance_m(&self) -> f64 {
        self.distance_m
    }

    /// 1 over the depth at which a ray meets it, from a point beside the optical axis in a direction per meter of depth, both to the
    /// right and up; 0 or below where it does not.
    pub(crate) fn inverse_depth(&self, origin_m: [f64; 2], direction: [f64; 2]) -> f64 {
        let [right, up] = self.slopes;
        let at_origin = self.distance_m + origin_m[0] * right + origin_m[1] * up;
        (1.0 - direction[0] * right - direction[1] * up) / at_origin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_the_plane() {
        let plane = FocalPlane::new(2.0).and_then(|plane| plane.tilted(0.5, -0.25)).expect("a plane");
        for (origin, direction) in [([0.0, 0.0], [0.3, 0.2]), ([0.1, -0.2], [-0.4, 0.1])] {
            let depth = 1.0 / plane.inverse_depth(origin, direction);
            let [x, y] = [0, 1].map(|k| origin[k] + depth * direction[k]);
            assert!((depth - (2.0 + x * 0.5_f64.tan() - y * 0.25_f64.tan())).abs() < 1e-12);
        }
        assert_eq!(FocalPlane::new(f64::INFINITY).expect("a plane").inverse_depth([0.3, 0.1], [1.0, -1.0]), 0.0);
    }

    #[test]
    fn planes_that_are_none_are_refused() {
        assert!(FocalPlane::new(0.0).is_err() && FocalPlane::new(f64::NAN).is_err());
        let plane = FocalPlane::new(1.0).expect("a plane");
        assert!(plane.tilted(1.6, 0.0).is_err() && plane.tilted(0.0, f64::NAN).is_err());
        let infinite = FocalPlane::new(f64::INFINITY).expect("a plane");
        assert!(infinite.tilted(0.0, 0.1).is_err() && infinite.tilted(0.0, 0.0).is_ok());
    }
}
