//! The builder of a rig: its parameters and their validation.

use super::{Intrinsics, Rig};
use crate::error::{not_negative, positive, positive_or_infinite};
use crate::{Disparity, Error, LightFieldShape, Projection};

/// The parameters of a [`Rig`], not yet validated; see [`Rig::builder`].
///
/// # Units
///
/// Meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigBuilder {
    pub(super) shape: LightFieldShape,
    pub(super) intrinsics: Intrinsics,
    pub(super) baseline_x_m: f64,
    pub(super) baseline_y_m: f64,
    pub(super) focus_distance_m: f64,
    pub(super) projection: Projection,
}

impl RigBuilder {
    pub(super) const fn new(shape: LightFieldShape) -> Self {
        Self {
            shape,
            intrinsics: Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 },
            baseline_x_m: 0.0,
            baseline_y_m: 0.0,
            focus_distance_m: f64::INFINITY,
            projection: Projection::Perspective,
        }
    }

    /// Sets the numbers of views and of microlenses.
    #[must_use]
    pub const fn shape(self, shape: LightFieldShape) -> Self {
        Self { shape, ..self }
    }

    /// Sets the focal length and the sensor size.
    #[must_use]
    pub const fn intrinsics(self, intrinsics: Intrinsics) -> Self {
        Self { intrinsics, ..self }
    }

    /// Sets the focal length of every view's camera, in meters.
    #[must_use]
    pub const fn focal_length_m(self, focal_length_m: f64) -> Self {
        Self { intrinsics: Intrinsics { focal_length_m, ..self.intrinsics }, ..self }
    }

    /// Sets the length of the larger image side, in meters.
    #[must_use]
    pub const fn sensor_size_m(self, sensor_size_m: f64) -> Self {
        Self { intrinsics: Intrinsics { sensor_size_m, ..self.intrinsics }, ..self }
    }

    /// Sets the distance between adjacent views along both axes, in meters; 0 is allowed.
    #[must_use]
    pub const fn baseline_m(self, baseline_m: f64) -> Self {
        Self { baseline_x_m: baseline_m, baseline_y_m: baseline_m, ..self }
    }

    /// Sets the distance between horizontally adjacent views, in meters; 0 is allowed.
    #[must_use]
    pub const fn baseline_x_m(self, baseline_x_m: f64) -> Self {
        Self { baseline_x_m, ..self }
    }

    /// Sets the distance between vertically adjacent views, in meters; 0 is allowed.
    #[must_use]
    pub const fn baseline_y_m(self, baseline_y_m: f64) -> Self {
        Self { baseline_y_m, ..self }
    }

    /// Sets the depth of the focus plane, in meters; may be `f64::INFINITY`.
    #[must_use]
    pub const fn focus_distance_m(self, focus_distance_m: f64) -> Self {
        Self { focus_distance_m, ..self }
    }

    /// Sets the projection of every view.
    #[must_use]
    pub const fn projection(self, projection: Projection) -> Self {
        Self { projection, ..self }
    }

    /// Validates the parameters and returns the rig.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if a length is NaN, infinite or has the wrong sign (baselines may be 0, the focus distance
    /// may be infinite), or if a number derived from them overflows or underflows; [`Error::OrthographicFocus`] if an
    /// orthographic rig has an infinite focus distance.
    pub fn build(self) -> Result<Rig, Error> {
        let Intrinsics { focal_length_m, sensor_size_m } = self.intrinsics;
        let focal_length_m = positive("focal length in meters", focal_length_m)?;
        let sensor_size_m = positive("sensor size in meters", sensor_size_m)?;
        let baseline_x_m = not_negative("horizontal baseline in meters", self.baseline_x_m)?;
        let baseline_y_m = not_negative("vertical baseline in meters", self.baseline_y_m)?;
        let focus_distance_m = positive_or_infinite("focus distance in meters", self.focus_distance_m)?;
        if self.projection == Projection::Orthographic && focus_distance_m.is_infinite() {
            return Err(Error::OrthographicFocus { focus_distance_m });
        }
        let pixels = self.shape.lenses().larger() as f64;
        let slope_per_px = positive("slope per pixel", sensor_size_m / (focal_length_m * pixels))?;
        let disparity = |what: &'static str, baseline_m: f64| {
            let scale_m_px = baseline_m * focal_length_m * pixels / sensor_size_m;
            if baseline_m > 0.0 && !scale_m_px.is_normal() {
                // An underflow to 0 would turn a baseline above 0 into no baseline.
                return Err(Error::BadNumber { what, value: scale_m_px, need: "within the range of normal numbers" });
            }
            Disparity::new(scale_m_px, focus_distance_m, self.projection)
        };
        let rig = Rig {
            numbers: Self { baseline_x_m, baseline_y_m, ..self },
            disparity_x: disparity("horizontal disparity scale", baseline_x_m)?,
            disparity_y: disparity("vertical disparity scale", baseline_y_m)?,
            slope_per_px,
        };
        // The corner views and pixels have the largest coordinates: if those are finite, all are.
        let views = rig.shape().views();
        let lenses = rig.shape().lenses();
        let corner = rig.ray(0, 0, views.rows - 1, views.columns - 1, 0.0, 0.0);
        let far_corner = rig.ray(lenses.rows - 1, lenses.columns - 1, 0, 0, 1.0, 1.0);
        for ray in [corner, far_corner] {
            for value in ray.origin_m.into_iter().chain(ray.direction) {
                if !value.is_finite() {
                    return Err(Error::BadNumber { what: "coordinate of the rig's corner ray", value, need: "finite" });
                }
            }
        }
        Ok(rig)
    }
}
