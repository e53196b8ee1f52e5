//! The parameters of a rig, before they are validated.

use super::Intrinsics;
use crate::{LightFieldShape, Projection};

/// The parameters of a [`Rig`](super::Rig), not yet validated; see [`Rig::builder`](super::Rig::builder).
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
}
