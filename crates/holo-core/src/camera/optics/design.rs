//! A camera with a microlens array, and its equivalent rig.

use crate::base::error::{positive, positive_or_infinite};
use crate::{Error, GridSize, Remainder, Rig, Sensor, SensorDivision, automatic_baseline_m};

/// The tolerance of a lens pitch against a whole number of pixels, in pixels, for rounded input.
const WHOLE_PIXEL: f64 = 1e-3;

/// The parameters of a camera with a square grid of microlenses, not validated.
///
/// # Examples
///
/// ```
/// use holo_core::optics::CameraDesign;
/// use holo_core::{GridSize, Sensor};
///
/// // The full-frame sensor of the paper behind microlenses of 0.45 mm: 100 pixels each.
/// let design = CameraDesign {
///     sensor: Sensor::Paper8k,
///     sensor_size_m: 0.0357_840,
///     lens_pitch_m: 0.45e-3,
///     focal_length_m: 0.05,
///     f_number: 5.0,
///     focus_distance_m: 1.0,
/// };
/// assert_eq!(design.views_per_lens()?, 100);
/// let rig = design.rig()?;
/// assert_eq!(rig.shape().lenses(), GridSize::new(53, 79));
/// // The views share the aperture of 10 mm.
/// assert!((rig.baseline_x_m() - 0.010 / 99.0).abs() < 1e-18);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraDesign {
    /// The sensor in pixels.
    pub sensor: Sensor,
    /// Length of the larger side of the sensor, in meters.
    pub sensor_size_m: f64,
    /// Distance between the centers of adjacent microlenses, in meters: a whole number of pixels.
    pub lens_pitch_m: f64,
    /// Focal length of the main lens, in meters.
    pub focal_length_m: f64,
    /// F-number of the main lens. That of the microlenses must match it, so that elemental images fill the sensor
    /// without overlap.
    pub f_number: f64,
    /// Focus distance, in meters; may be infinite.
    pub focus_distance_m: f64,
}

impl CameraDesign {
    /// Returns the pixel pitch of the sensor, in meters.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the sensor size is not finite and above 0; [`Error::ZeroCount`] if the sensor has no
    /// pixels.
    pub fn pixel_pitch_m(&self) -> Result<f64, Error> {
        match self.sensor.size().larger() {
            0 => Err(Error::ZeroCount { what: "sensor pixels" }),
            pixels => Ok(positive("sensor size in meters", self.sensor_size_m)? / pixels as f64),
        }
    }

    /// Returns the number of pixels behind a microlens along either axis, which is the number of views.
    ///
    /// # Errors
    ///
    /// As [`CameraDesign::pixel_pitch_m`]; [`Error::BadNumber`] if the lens pitch is not within 1/1000 of a whole
    /// number of pixels. (Pitches of a fraction of a pixel are not modeled.)
    pub fn views_per_lens(&self) -> Result<usize, Error> {
        let pixels = positive("lens pitch in meters", self.lens_pitch_m)? / self.pixel_pitch_m()?;
        let whole = pixels.round();
        // More lenses than pixels, or a number of pixels that no sensor has, fails when the sensor is divided.
        if whole >= 1.0 && (pixels - whole).abs() <= WHOLE_PIXEL && whole < 1e9 {
            Ok(whole as usize)
        } else {
            let need = "within 1/1000 of a whole number of pixels, at least 1; change the pitch or the sensor size";
            Err(Error::BadNumber { what: "lens pitch in pixels of the sensor", value: pixels, need })
        }
    }

    /// Returns the numbers of views and of microlenses, and the cropped border of the sensor.
    ///
    /// # Errors
    ///
    /// As [`CameraDesign::views_per_lens`] and [`Sensor::divide`].
    ///
    /// # Source
    ///
    /// Eq. 1.
    pub fn sensor_division(&self) -> Result<SensorDivision, Error> {
        let views = self.views_per_lens()?;
        self.sensor.divide(GridSize::new(views, views), Remainder::Crop)
    }

    /// Returns the equivalent rig of cameras.
    ///
    /// The views share the aperture of the main lens: `baseline = f / f-number / (views - 1)`. The border of the sensor
    /// that fills no microlens is cropped, which reduces the field of view.
    ///
    /// # Errors
    ///
    /// As [`CameraDesign::sensor_division`]; [`Error::BadNumber`] if a length or the f-number is not above 0.
    ///
    /// # Source
    ///
    /// The paper's "f5 lens"; [`automatic_baseline_m`].
    pub fn rig(&self) -> Result<Rig, Error> {
        let shape = self.sensor_division()?.shape;
        let focus_distance_m = positive_or_infinite("focus distance in meters", self.focus_distance_m)?;
        let baseline_m = automatic_baseline_m(self.focal_length_m, self.f_number, shape.views())?;
        let sensor_size_m = self.pixel_pitch_m()? * shape.raw_size().larger() as f64;
        Rig::builder(shape)
            .focal_length_m(self.focal_length_m)
            .sensor_size_m(sensor_size_m)
            .baseline_m(baseline_m)
            .focus_distance_m(focus_distance_m)
            .build()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design() -> CameraDesign {
        CameraDesign {
            sensor: Sensor::Other(GridSize::new(90, 120)),
            sensor_size_m: 0.012,
            lens_pitch_m: 0.0007,
            focal_length_m: 0.02,
            f_number: 4.0,
            focus_distance_m: 0.5,
        }
    }

    #[test]
    fn a_small_camera_by_hand() {
        // Pixels of 0.1 mm, 7 behind a lens: 12 x 17 lenses, 6 rows and 1 column left over.
        let design = design();
        assert_eq!(design.pixel_pitch_m(), Ok(0.0001));
        let division = design.sensor_division().unwrap();
        assert_eq!((division.shape.lenses(), division.border), (GridSize::new(12, 17), GridSize::new(6, 1)));
        let rig = design.rig().unwrap();
        // 119 pixels of the longer side are used, and 5 mm of aperture are shared by six gaps.
        assert!((rig.sensor_size_m() - 0.0119).abs() < 1e-17);
        assert!((rig.baseline_x_m() - 0.005 / 6.0).abs() < 1e-17);
        // A pixel of a view is as wide as a lens: 0.7 mm at 20 mm.
        assert!((rig.slope_x(1.0) - rig.slope_x(0.0) - 0.7 / 20.0).abs() < 1e-15);
    }

    #[test]
    fn pitches_of_fractional_pixels_are_errors() {
        for lens_pitch_m in [0.00075, 0.00004, 0.0, -0.0007, f64::NAN, f64::INFINITY, 1e300] {
            assert!(CameraDesign { lens_pitch_m, ..design() }.rig().is_err(), "{lens_pitch_m}");
        }
        // Written with four digits: 6.9996 pixels.
        let close = CameraDesign { lens_pitch_m: 0.00069996, ..design() };
        assert_eq!(close.views_per_lens(), Ok(7));
        // A lens larger than the sensor.
        assert!(matches!(CameraDesign { lens_pitch_m: 0.0100, ..design() }.rig(), Err(Error::SensorTooSmall { .. })));
        assert!(CameraDesign { sensor: Sensor::Other(GridSize::new(0, 0)), ..design() }.rig().is_err());
        assert!(CameraDesign { f_number: 0.0, ..design() }.rig().is_err());
    }
}
