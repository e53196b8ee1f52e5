//! The optics of a holoscopic camera: disparities, depth of field and depth resolution of a rig, and the rig for a
//! range of disparities.
//!
//! [`CameraDesign`] converts the parameters of a camera with a microlens array to a [`Rig`]. [`Optics`] computes the
//! properties of a rig. [`rig_for_disparities`] computes focus distance and baseline from a range of depths and of
//! disparities.
//!
//! Everything follows from Eq. 3 for the rig's horizontal axis, with pinhole views that share one focus plane. The main
//! lens is a thin lens, and distances are measured from it.

mod design;
mod solve;
mod warnings;

pub use design::CameraDesign;
pub use solve::{DisparitySolution, rig_for_disparities};
pub use warnings::OpticsWarning;

use crate::base::error::{positive, positive_or_infinite};
use crate::{Disparity, Error, Rig};

/// A range of depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    /// The nearest depth, in meters.
    pub near_m: f64,
    /// The farthest depth, in meters; may be infinite.
    pub far_m: f64,
}

impl DepthRange {
    /// Returns the range between two depths in front of the camera, in meters.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the nearest depth is not finite and above 0 or the farthest is not above 0 (infinity is
    /// allowed); [`Error::ImpossibleRange`] if the nearest is not below the farthest.
    pub fn new(near_m: f64, far_m: f64) -> Result<Self, Error> {
        let near_m = positive("nearest depth in meters", near_m)?;
        let far_m = positive_or_infinite("farthest depth in meters", far_m)?;
        if near_m < far_m {
            Ok(Self { near_m, far_m })
        } else {
            Err(Error::ImpossibleRange { why: "the nearest depth must be below the farthest" })
        }
    }
}

/// A range of disparities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisparityRange {
    /// The smallest disparity, that of the farthest depth, in pixels between adjacent views.
    pub min_px: f64,
    /// The largest disparity, that of the nearest depth, in pixels between adjacent views.
    pub max_px: f64,
}

/// The optical properties of a rig.
///
/// # Examples
///
/// ```
/// use holo_core::optics::{DepthRange, Optics};
/// use holo_core::{GridSize, LightFieldShape, Rig};
///
/// // The camera of the benchmark's scene "cotton".
/// let rig = Rig::builder(LightFieldShape::new(GridSize::new(9, 9), GridSize::new(512, 512))?)
///     .focal_length_m(0.1)
///     .sensor_size_m(0.035)
///     .baseline_m(0.025)
///     .focus_distance_m(4.25)
///     .build()?;
/// let optics = Optics::new(rig)?;
/// let range = optics.disparity_range_px(DepthRange::new(3.5, 6.0)?);
/// assert!((range.max_px - 1.8439).abs() < 5e-5 && (range.min_px + 2.5098).abs() < 5e-5);
/// // Disparities are at most one pixel between 3.81 m and 4.81 m.
/// let smooth = optics.angular_depth_of_field(1.0)?;
/// assert!((smooth.near_m - 3.8075).abs() < 1e-4 && (smooth.far_m - 4.8088).abs() < 1e-4);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    rig: Rig,
}

impl Optics {
    /// Returns the optics of a rig.
    ///
    /// # Errors
    ///
    /// [`Error::NoBaseline`] if its views coincide horizontally, or if there is only one column of views.
    pub fn new(rig: Rig) -> Result<Self, Error> {
        if rig.baseline_x_m() == 0.0 || rig.shape().views().columns < 2 {
            return Err(Error::NoBaseline);
        }
        Ok(Self { rig })
    }

    /// Returns the rig.
    #[must_use]
    pub const fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Returns the disparities of a range of depths, in pixels between adjacent views.
    ///
    /// # Source
    ///
    /// Eq. 3.
    #[must_use]
    pub fn disparity_range_px(&self, depths: DepthRange) -> DisparityRange {
        let disparity = self.disparity();
        DisparityRange { min_px: disparity.from_depth_m(depths.far_m), max_px: disparity.from_depth_m(depths.near_m) }
    }

    /// Returns the width of the synthetic aperture, in meters: from the first to the last view of a row.
    #[must_use]
    pub fn aperture_m(&self) -> f64 {
        self.rig.baseline_x_m() * self.gaps()
    }

    /// Returns the depths whose disparities are at most `limit_px`, of either sign.
    ///
    /// Up to half a pixel or one pixel, the angular sampling is dense enough for view blending without ghosting and for
    /// refocusing without aliasing.
    ///
    /// # Units
    ///
    /// Pixels in, meters out. The far end is infinite if the disparity of infinity is within the limit.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the limit is not finite and above 0.
    pub fn angular_depth_of_field(&self, limit_px: f64) -> Result<DepthRange, Error> {
        Ok(self.depths_within(positive("disparity limit in pixels", limit_px)?))
    }

    /// Returns the depth of field of the refocused image of all views at the rig's focus distance: the depths whose
    /// circle of confusion is at most `circle_px` wide.
    ///
    /// The circle of confusion of a point is the distance between its images in the outermost views of a row.
    ///
    /// # Units
    ///
    /// Pixels in, meters out. The far end is infinite for focus distances from the hyperfocal distance on.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the circle is not finite and above 0.
    ///
    /// # Source
    ///
    /// The thin-lens relation for an aperture A, `c = A f |1/Z - 1/F|`. As everywhere in this crate, f is the image
    /// distance.
    pub fn defocus_depth_of_field(&self, circle_px: f64) -> Result<DepthRange, Error> {
        Ok(self.depths_within(positive("circle of confusion in pixels", circle_px)? / self.gaps()))
    }

    /// Returns the hyperfocal distance, in meters: the nearest focus distance whose depth of field extends to infinity.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the circle is not finite and above 0.
    ///
    /// # Source
    ///
    /// `A f / c`, the focus distance at which infinity has the circle of confusion c.
    pub fn hyperfocal_m(&self, circle_px: f64) -> Result<f64, Error> {
        Ok(self.disparity().scale_m_px() * self.gaps() / positive("circle of confusion in pixels", circle_px)?)
    }

    /// Returns the angle between adjacent views at the point of the focus plane on the axis, in radians; 0 for a focus
    /// at infinity.
    #[must_use]
    pub fn angular_step_rad(&self) -> f64 {
        // Two views half a baseline to either side of the axis.
        2.0 * (self.rig.baseline_x_m() / 2.0 / self.rig.focus_distance_m()).atan()
    }

    /// Returns the width of one pixel of a view at a depth, in meters.
    ///
    /// It is the same at every depth for an orthographic view.
    #[must_use]
    pub fn pixel_size_m(&self, depth_m: f64) -> f64 {
        let pixel = |column| self.rig.ray(0, column, 0, 0, 0.5, 0.5).at_depth_m(depth_m)[0];
        pixel(1) - pixel(0)
    }

    /// Returns the depth interval around a depth that corresponds to a disparity interval of `step_px`, in meters.
    ///
    /// For the disparity resolution of an estimate this is its depth resolution. It is infinite if the interval extends
    /// to infinity.
    ///
    /// # Accuracy
    ///
    /// Exact for a disparity interval centered on that of the depth. To first order it is `step * Z^2 / k`.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the depth or the step is not finite and above 0.
    pub fn depth_resolution_m(&self, depth_m: f64, step_px: f64) -> Result<f64, Error> {
        let depth_m = positive("depth in meters", depth_m)?;
        let step_px = positive("disparity step in pixels", step_px)?;
        let at_px = self.disparity().from_depth_m(depth_m);
        Ok(self.depth_or_infinity_m(at_px - step_px / 2.0) - self.depth_or_infinity_m(at_px + step_px / 2.0))
    }

    /// Returns warnings about the use of the rig for a range of depths.
    ///
    /// # Units
    ///
    /// `limit_px` is the largest acceptable disparity, of either sign, and `step_px` the disparity resolution of the
    /// estimate.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the limit or the step is not finite and above 0.
    pub fn warnings(&self, depths: DepthRange, limit_px: f64, step_px: f64) -> Result<Vec<OpticsWarning>, Error> {
        warnings::of(self, depths, limit_px, step_px)
    }

    fn disparity(&self) -> Disparity {
        self.rig.disparity_x()
    }

    /// The number of baselines between the first and the last view of a row.
    fn gaps(&self) -> f64 {
        (self.rig.shape().views().columns - 1) as f64
    }

    fn depths_within(&self, limit_px: f64) -> DepthRange {
        DepthRange { near_m: self.depth_or_infinity_m(limit_px), far_m: self.depth_or_infinity_m(-limit_px) }
    }

    /// The depth of a disparity: infinity for disparities below that of infinity, and 0 for disparities of points
    /// behind an orthographic rig.
    fn depth_or_infinity_m(&self, disparity_px: f64) -> f64 {
        let disparity = self.disparity();
        if disparity_px <= disparity.at_infinity_px() {
            f64::INFINITY
        } else {
            disparity.to_depth_m(disparity_px).max(0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GridSize, LightFieldShape, Projection};

    /// k = 0.02 * 0.05 * 360 / 0.036 = 10 m px.
    fn optics(focus_distance_m: f64, projection: Projection) -> Optics {
        let rig = Rig::builder(LightFieldShape::new(GridSize::new(5, 11), GridSize::new(240, 360)).unwrap())
            .focal_length_m(0.05)
            .sensor_size_m(0.036)
            .baseline_x_m(0.02)
            .baseline_y_m(0.01)
            .focus_distance_m(focus_distance_m)
            .projection(projection)
            .build()
            .unwrap();
        Optics::new(rig).unwrap()
    }

    fn close(value: f64, expected: f64) {
        // Some ten roundings.
        assert!((value - expected).abs() <= 1e-14 * expected.abs().max(1.0), "{value} for {expected}");
    }

    #[test]
    fn ranges_by_hand() {
        let optics = optics(5.0, Projection::Perspective);
        let range = optics.disparity_range_px(DepthRange::new(2.0, f64::INFINITY).unwrap());
        // 10 (1/2 - 1/5) and -10/5.
        close(range.max_px, 3.0);
        close(range.min_px, -2.0);
        close(optics.aperture_m(), 0.2);
        // 1/Z = 1/5 +- 1/10.
        let smooth = optics.angular_depth_of_field(1.0).unwrap();
        close(smooth.near_m, 10.0 / 3.0);
        close(smooth.far_m, 10.0);
        // Up to 2 px everything to infinity.
        assert_eq!(optics.angular_depth_of_field(2.0).unwrap().far_m, f64::INFINITY);
        assert_eq!(optics.angular_depth_of_field(7.0).unwrap().far_m, f64::INFINITY);
        // Ten gaps: a circle of 2 px is a disparity of 0.2 px, and 1/Z = 1/5 +- 1/50.
        let sharp = optics.defocus_depth_of_field(2.0).unwrap();
        close(sharp.near_m, 50.0 / 11.0);
        close(sharp.far_m, 50.0 / 9.0);
        close(optics.hyperfocal_m(2.0).unwrap(), 50.0);
    }

    #[test]
    fn depth_of_field_at_the_hyperfocal_distance_starts_at_half_of_it() {
        let hyperfocal_m = optics(5.0, Projection::Perspective).hyperfocal_m(1.5).unwrap();
        let sharp = optics(hyperfocal_m, Projection::Perspective).defocus_depth_of_field(1.5 * (1.0 + 1e-15)).unwrap();
        close(sharp.near_m, hyperfocal_m / 2.0);
        assert_eq!(sharp.far_m, f64::INFINITY);
    }

    #[test]
    fn depth_of_field_agrees_with_the_hyperfocal_formula() {
        // near = H F/(H + F), far = H F/(H - F), for a lens whose image distance is f.
        let optics = optics(5.0, Projection::Perspective);
        for circle_px in [0.5, 1.0, 3.0, 15.0] {
            let (h, f) = (optics.hyperfocal_m(circle_px).unwrap(), 5.0);
            let sharp = optics.defocus_depth_of_field(circle_px).unwrap();
            close(sharp.near_m, h * f / (h + f));
            close(sharp.far_m, h * f / (h - f));
        }
    }

    #[test]
    fn sampling_by_hand() {
        let optics = optics(5.0, Projection::Perspective);
        close(optics.angular_step_rad(), 2.0 * (0.01_f64 / 5.0).atan());
        // 0.036/(0.05 * 360) = 0.002 m a meter.
        close(optics.pixel_size_m(7.0), 0.014);
        close(self::optics(5.0, Projection::Orthographic).pixel_size_m(7.0), 0.01);
        assert_eq!(self::optics(f64::INFINITY, Projection::Perspective).angular_step_rad(), 0.0);
    }

    #[test]
    fn depth_resolution_is_an_interval_around_the_depth() {
        let optics = optics(5.0, Projection::Perspective);
        // 1/Z = 1/4 +- 0.05/10.
        close(optics.depth_resolution_m(4.0, 0.1).unwrap(), 1.0 / 0.245 - 1.0 / 0.255);
        // The first order: 0.1 * 16/10. The next is 1/4 (0.1 * 4/10)^2 of it.
        assert!((optics.depth_resolution_m(4.0, 0.1).unwrap() / 0.16 - 1.0).abs() < 5e-4);
        assert_eq!(optics.depth_resolution_m(100.0, 0.3).unwrap(), f64::INFINITY);
        // Orthographic: Z = F (1 - d F/k), so 0.1 px are 0.1 * 25/10 at every depth.
        let orthographic = self::optics(5.0, Projection::Orthographic);
        for depth_m in [4.0, 20.0] {
            assert!((orthographic.depth_resolution_m(depth_m, 0.1).unwrap() - 0.25).abs() < 1e-13);
        }
        assert!(optics.depth_resolution_m(0.0, 0.1).is_err() && optics.depth_resolution_m(1.0, f64::NAN).is_err());
    }

    #[test]
    fn invalid_ranges_and_rigs_are_errors() {
        for (near_m, far_m) in
            [(0.0, 1.0), (2.0, 2.0), (3.0, 2.0), (f64::NAN, 2.0), (1.0, f64::NAN), (f64::INFINITY, 9.0)]
        {
            assert!(DepthRange::new(near_m, far_m).is_err(), "{near_m} {far_m}");
        }
        let rig = *optics(5.0, Projection::Perspective).rig();
        let without = rig.to_builder().baseline_x_m(0.0).build().unwrap();
        assert_eq!(Optics::new(without), Err(Error::NoBaseline));
        let single = LightFieldShape::new(GridSize::new(5, 1), GridSize::new(240, 360)).unwrap();
        assert_eq!(Optics::new(rig.to_builder().shape(single).build().unwrap()), Err(Error::NoBaseline));
    }
}
