//! Eq. 2: two parallel cameras without a sensor shift.

use ndarray::{Array, ArrayRef, Dimension};

use crate::base::error::{not_negative, positive};
use crate::{Error, Real};

/// Two parallel pinhole cameras as a map between depth and displacement on the sensor.
///
/// This is [`Disparity`](crate::Disparity) with the focus at infinity, in meters on the sensor instead of pixels.
///
/// # Source
///
/// Eq. 2: `l = b * f / Z`.
///
/// # Examples
///
/// ```
/// let pair = holo_core::StereoPair::new(0.1, 0.05)?;
/// assert_eq!(pair.displacement_from_depth_m(2.0), 0.1 * 0.05 / 2.0);
/// assert_eq!(pair.displacement_from_depth_m(f64::INFINITY), 0.0);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StereoPair {
    /// b * f in square meters.
    scale_m2: f64,
}

impl StereoPair {
    /// Returns the pair for a distance between the cameras and a focal length, both in meters.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the baseline is not finite or negative, or the focal length is not finite and above 0.
    pub fn new(baseline_m: f64, focal_length_m: f64) -> Result<Self, Error> {
        let baseline_m = not_negative("baseline in meters", baseline_m)?;
        let focal_length_m = positive("focal length in meters", focal_length_m)?;
        Ok(Self { scale_m2: not_negative("baseline times focal length", baseline_m * focal_length_m)? })
    }

    /// Returns the displacement l on the sensor, in meters, of a point at depth `depth_m`; 0 at infinity.
    ///
    /// # Accuracy
    ///
    /// Two roundings: within 2 ulp of the exact `b * f / Z`.
    #[must_use]
    pub fn displacement_from_depth_m(&self, depth_m: f64) -> f64 {
        if self.scale_m2 == 0.0 && !depth_m.is_nan() {
            return 0.0;
        }
        self.scale_m2 / depth_m
    }

    /// Returns the depth, in meters, of a point displaced by `displacement_m` on the sensor; infinity for 0.
    ///
    /// Without a baseline every depth has displacement 0, and the result is NaN.
    ///
    /// # Accuracy
    ///
    /// Two roundings: within 2 ulp of the exact `b * f / l`.
    #[must_use]
    pub fn depth_from_displacement_m(&self, displacement_m: f64) -> f64 {
        if self.scale_m2 == 0.0 {
            return f64::NAN;
        }
        if displacement_m == 0.0 {
            // For either sign of zero: -0 must not give -infinity.
            return f64::INFINITY;
        }
        self.scale_m2 / displacement_m
    }

    /// Returns the displacement of every depth of a map, in meters on the sensor.
    #[must_use]
    pub fn map_displacement_from_depth_m<T: Real, D: Dimension>(&self, depth_m: &ArrayRef<T, D>) -> Array<T, D> {
        depth_m.mapv(|depth| T::from_f64(self.displacement_from_depth_m(depth.to_f64())))
    }

    /// Returns the depth of every displacement of a map, in meters.
    ///
    /// # Errors
    ///
    /// [`Error::NoBaseline`] if the cameras coincide.
    pub fn map_depth_from_displacement_m<T: Real, D: Dimension>(
        &self,
        displacement_m: &ArrayRef<T, D>,
    ) -> Result<Array<T, D>, Error> {
        if self.scale_m2 == 0.0 {
            return Err(Error::NoBaseline);
        }
        Ok(displacement_m.mapv(|displacement| T::from_f64(self.depth_from_displacement_m(displacement.to_f64()))))
    }
}
