//! The shape of the aperture of the main lens, which its pupils have too.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

/// The shape of the aperture of the main lens, for a radius that the f-number gives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PupilShape {
    /// A disc.
    #[default]
    Round,
    /// A square whose sides are as long as the diameter of the round aperture, parallel to the sides of the sensor.
    Square,
    /// A regular polygon with its corners on the circle of the round aperture: straight blades of a diaphragm.
    Polygon {
        /// The number of sides, 3 to 64.
        blades: u8,
        /// The angle of the first corner, counterclockwise as the camera sees the scene, from the upright.
        rotation_rad: f64,
    },
}

impl PupilShape {
    /// Whether a point lies within a pupil of this radius (or half width) around (0, 0).
    #[inline]
    pub(super) fn contains(self, [x, y]: [f64; 2], radius: f64) -> bool {
        match self {
            Self::Round => x * x + y * y <= radius * radius,
            Self::Square => x.abs().max(y.abs()) <= radius,
            Self::Polygon { blades, rotation_rad } => {
                if x * x + y * y > radius * radius {
                    return false;
                }
                // The angle from the middle of the nearest side.
                let wedge = 2.0 * PI / f64::from(blades);
                let from_corner = (y.atan2(x) - FRAC_PI_2 - rotation_rad).rem_euclid(wedge);
                x.hypot(y) * (from_corner - wedge / 2.0).cos() <= radius * (wedge / 2.0).cos()
            }
        }
    }

    /// The radius of the largest disc within the shape, and of the smallest around it, relative to its radius.
    pub(super) fn inner_and_outer(self) -> [f64; 2] {
        match self {
            Self::Round => [1.0, 1.0],
            Self::Square => [1.0, SQRT_2],
            Self::Polygon { blades, .. } => [(PI / f64::from(blades)).cos(), 1.0],
        }
    }

    /// The corners of a polygon or square of radius 1, counterclockwise; none of a disc.
    pub(super) fn corners(self) -> Vec<[f64; 2]> {
        match self {
            Self::Round => Vec::new(),
            Self::Square => vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
            Self::Polygon { blades, rotation_rad } => (0..blades)
                .map(|k| FRAC_PI_2 + rotation_rad + f64::from(k) * 2.0 * PI / f64::from(blades))
                .map(|angle| [angle.cos(), angle.sin()])
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_contain_what_lies_within_their_sides() {
        for (blades, rotation_rad) in [(3, 0.0), (5, 0.3), (6, -2.0), (7, 1.0)] {
            let shape = PupilShape::Polygon { blades, rotation_rad };
            let corners = shape.corners();
            let inside = |[x, y]: [f64; 2]| {
                (0..corners.len()).all(|k| {
                    let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                    (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= 0.0
                })
            };
            for k in 0..10_000 {
                let point = [k % 100, k / 100].map(|k| (f64::from(k) + 0.5) / 50.0 - 1.0);
                assert_eq!(
                    shape.contains(point.map(|x| 2.0 * x), 2.0),
                    inside(point),
                    "{blades} {rotation_rad} {point:?}"
                );
            }
        }
    }
}
