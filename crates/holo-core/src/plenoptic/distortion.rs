//! The distortion of the main lens.

use crate::Error;

/// Radial and tangential distortion of the main lens (Brown's model): the light for a point of the microlens array arrives
/// at `q (1 + k1 r^2 + k2 r^4 + k3 r^6)` instead of `q`, and displaced tangentially, where r is the distance of `q` from the
/// axis.
///
/// # Units
///
/// k1 in 1/m^2, k2 in 1/m^4, k3 in 1/m^6; p1 and p2 in 1/m; upright coordinates. libpleno's coefficients, in 1/mm^2, are
/// these times 1e-6, 1e-12, 1e-18.
///
/// # Source
///
/// Brown, "Decentering distortion of lenses" (Photogrammetric Engineering, 1966).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// k1, k2, k3.
    pub radial: [f64; 3],
    /// p1, p2.
    pub tangential: [f64; 2],
}

impl Distortion {
    /// No distortion.
    pub const NONE: Self = Self { radial: [0.0; 3], tangential: [0.0; 2] };

    /// Returns whether there is none.
    #[inline]
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Returns where light for a place on the array arrives, in meters from the axis.
    #[must_use]
    pub fn distorted(&self, place_m: [f64; 2]) -> [f64; 2] {
        self.with_slopes(place_m).0
    }

    /// Returns the place whose light arrives at this one, the inverse of [`distorted`](Self::distorted).
    ///
    /// # Accuracy
    ///
    /// Newton's method to the rounding of f64, where the distortion can be inverted; [`PlenopticCamera::new`] checks that it
    /// can at the corners of the sensor.
    ///
    /// [`PlenopticCamera::new`]: super::PlenopticCamera::new
    #[inline]
    #[must_use]
    pub fn undistorted(&self, place_m: [f64; 2]) -> [f64; 2] {
        if self.is_none() {
            return place_m;
        }
        let mut found = place_m;
        for _ in 0..8 {
            let ([x, y], [xx, xy, yy]) = self.with_slopes(found);
            let [dx, dy] = [place_m[0] - x, place_m[1] - y];
            let determinant = xx * yy - xy * xy;
            let step = [(yy * dx - xy * dy) / determinant, (xx * dy - xy * dx) / determinant];
            found = [found[0] + step[0], found[1] + step[1]];
            if step[0].abs().max(step[1].abs()) <= 1e-17 {
                break;
            }
        }
        found
    }

    /// The distorted place, and its derivatives dx/dx, dx/dy = dy/dx and dy/dy.
    fn with_slopes(&self, [x, y]: [f64; 2]) -> ([f64; 2], [f64; 3]) {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let squared = x * x + y * y;
        let scale = 1.0 + squared * (k1 + squared * (k2 + squared * k3));
        // d scale / d squared.
        let growth = k1 + squared * (2.0 * k2 + squared * 3.0 * k3);
        let place = [
            x * scale + 2.0 * p1 * x * y + p2 * (squared + 2.0 * x * x),
            y * scale + p1 * (squared + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        let slopes = [
            scale + 2.0 * x * x * growth + 2.0 * p1 * y + 6.0 * p2 * x,
            2.0 * x * y * growth + 2.0 * p1 * x + 2.0 * p2 * y,
            scale + 2.0 * y * y * growth + 6.0 * p1 * y + 2.0 * p2 * x,
        ];
        (place, slopes)
    }

    /// Checks that the distortion can be inverted out to some places.
    pub(super) fn validate(&self, places_m: &[[f64; 2]]) -> Result<(), Error> {
        let fine = |place_m: [f64; 2]| {
            // Along the way from the axis too: distortion must not fold the image.
            (1..=16).all(|k| {
                let place = place_m.map(|x| x * f64::from(k) / 16.0);
                let found = self.undistorted(place);
                let (again, [xx, xy, yy]) = self.with_slopes(found);
                let away = (again[0] - place[0]).hypot(again[1] - place[1]);
                away <= 1e-12 * place[0].hypot(place[1]) && xx * yy - xy * xy > 0.0 && xx > 0.0
            })
        };
        let numbers = self.radial.iter().chain(&self.tangential);
        if let Some(&value) = numbers.clone().find(|x| !x.is_finite()) {
            return Err(Error::BadNumber { what: "distortion coefficient", value, need: "finite" });
        }
        if self.is_none() || places_m.iter().all(|&place| fine(place)) {
            return Ok(());
        }
        let value = numbers.fold(0.0f64, |most, x| most.max(x.abs()));
        Err(Error::BadNumber { what: "distortion coefficient", value, need: "so small that the image does not fold" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_is_the_inverse() {
        let distortion = Distortion { radial: [60.0, -2e4, 1e6], tangential: [0.05, -0.03] };
        for k in 0..100 {
            let place = [k % 10, k / 10].map(|k| f64::from(k) * 3e-3 - 13.5e-3);
            let found = distortion.distorted(distortion.undistorted(place));
            assert!((found[0] - place[0]).hypot(found[1] - place[1]) < 1e-16, "{place:?} {found:?}");
        }
        assert!(distortion.validate(&[[13.5e-3, 9e-3]]).is_ok());
        let folded = Distortion { radial: [-3e4, 0.0, 0.0], tangential: [0.0; 2] };
        assert!(folded.validate(&[[13.5e-3, 9e-3]]).is_err());
    }
}
