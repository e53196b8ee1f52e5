//! Focal length, sensor size and the automatic baseline.

use crate::base::error::positive;
use crate::{Error, GridSize};

/// Focal length and sensor size of a view's camera.
///
/// Only their ratio affects the image. Both are stored because file formats have both.
///
/// # Units
///
/// Meters. The sensor size is the length of the **larger** side of the image (Blender's "AUTO" fit).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length in meters.
    pub focal_length_m: f64,
    /// Length of the larger image side in meters.
    pub sensor_size_m: f64,
}

impl Intrinsics {
    /// Returns the intrinsics for half the field of view across the larger image side: `f = sens / (2 tan(half
    /// angle))`.
    ///
    /// # Units
    ///
    /// Radians and meters.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the angle does not lie between 0 and pi/2 or the sensor size is not finite and above 0.
    ///
    /// # Examples
    ///
    /// ```
    /// // A full-frame sensor at 45 degrees to either side: f is half its width.
    /// let intrinsics = holo_core::Intrinsics::from_half_angle(std::f64::consts::FRAC_PI_4, 0.036)?;
    /// assert!((intrinsics.focal_length_m - 0.018).abs() < 1e-15);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn from_half_angle(half_angle_rad: f64, sensor_size_m: f64) -> Result<Self, Error> {
        let sensor_size_m = positive("sensor size in meters", sensor_size_m)?;
        if !(half_angle_rad > 0.0 && half_angle_rad < std::f64::consts::FRAC_PI_2) {
            return Err(Error::BadNumber {
                what: "half of the angle of view in radians",
                value: half_angle_rad,
                need: "between 0 and pi/2",
            });
        }
        let focal_length_m = positive("focal length in meters", sensor_size_m / (2.0 * half_angle_rad.tan()))?;
        Ok(Self { focal_length_m, sensor_size_m })
    }

    /// Returns half the field of view across the larger image side, in radians.
    #[must_use]
    pub fn half_angle_rad(&self) -> f64 {
        // tan(half angle) = (sens/2)/f; atan2 is accurate for tiny and for huge ratios.
        (self.sensor_size_m / 2.0).atan2(self.focal_length_m)
    }
}

/// Returns the baseline at which `views` sample the whole aperture of an f/`f_number` lens: `f / f_number / (max(S, T)
/// - 1)`.
///
/// The baseline is the same along both axes. It is 0 for a single view.
///
/// # Units
///
/// Meters.
///
/// # Errors
///
/// [`Error::BadNumber`] if the focal length or the f-number is not finite and above 0; [`Error::ZeroCount`] without
/// views.
///
/// # Source
///
/// The paper's "f5 lens": the views share its aperture of f/5.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, automatic_baseline_m};
///
/// // 50 mm at f/5 have an aperture of 10 mm; 101 views have 100 gaps of 0.1 mm.
/// let baseline_m = automatic_baseline_m(0.05, 5.0, GridSize::new(51, 101))?;
/// assert!((baseline_m - 1e-4).abs() < 1e-18);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn automatic_baseline_m(focal_length_m: f64, f_number: f64, views: GridSize) -> Result<f64, Error> {
    let focal_length_m = positive("focal length in meters", focal_length_m)?;
    let f_number = positive("f-number", f_number)?;
    match views {
        GridSize { rows: 0, .. } => Err(Error::ZeroCount { what: "view rows" }),
        GridSize { columns: 0, .. } => Err(Error::ZeroCount { what: "view columns" }),
        GridSize { rows: 1, columns: 1 } => Ok(0.0),
        _ => positive("automatic baseline in meters", focal_length_m / f_number / (views.larger() - 1) as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_angle_round_trips() {
        for half_angle_rad in [1e-6, 0.1, 0.4, 1.0, 1.57] {
            let intrinsics = Intrinsics::from_half_angle(half_angle_rad, 0.036).unwrap();
            // tan amplifies a relative error by at most angle/(sin*cos) < 1.57/(sin 1.57 cos 1.57) = 1972 here: allow
            // 2000 eps.
            assert!((intrinsics.half_angle_rad() / half_angle_rad - 1.0).abs() < 2000.0 * f64::EPSILON);
        }
    }

    #[test]
    fn impossible_angles_and_sizes_are_errors() {
        for angle in [f64::NAN, 0.0, -0.3, std::f64::consts::FRAC_PI_2, 2.0, f64::INFINITY] {
            assert!(Intrinsics::from_half_angle(angle, 0.036).is_err(), "{angle}");
        }
        for size in [f64::NAN, 0.0, -0.036, f64::INFINITY] {
            assert!(Intrinsics::from_half_angle(0.4, size).is_err(), "{size}");
        }
    }

    #[test]
    fn automatic_baseline_counts_gaps_of_the_longer_axis() {
        let views = |rows, columns| automatic_baseline_m(0.05, 5.0, GridSize::new(rows, columns));
        assert_eq!(views(1, 1), Ok(0.0));
        assert_eq!(views(1, 2), Ok(0.05 / 5.0));
        assert_eq!(views(2, 1), views(1, 2));
        assert_eq!(views(100, 20), Ok(0.05 / 5.0 / 99.0));
        assert_eq!(views(20, 100), views(100, 20));
        assert!(views(0, 5).is_err() && views(5, 0).is_err());
        assert!(automatic_baseline_m(0.05, 0.0, GridSize::new(2, 2)).is_err());
        assert!(automatic_baseline_m(f64::NAN, 5.0, GridSize::new(2, 2)).is_err());
        // A baseline that underflows to 0 is an error.
        assert!(automatic_baseline_m(f64::MIN_POSITIVE, 1e300, GridSize::new(2, 2)).is_err());
    }
}
