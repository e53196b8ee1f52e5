//! What a rig is made of, before it is checked.

use super::Intrinsics;
use crate::{Projection, Split};

/// The parameters of a [`Rig`](crate::Rig), unchecked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigParameters {
    /// Views and lenses.
    pub split: Split,
    /// Focal length and sensor size of every view's camera.
    pub intrinsics: Intrinsics,
    /// Distance between horizontally adjacent views, in metres; 0 is allowed.
    pub baseline_x_m: f64,
    /// Distance between vertically adjacent views, in metres; 0 is allowed.
    pub baseline_y_m: f64,
    /// Depth of the plane in which a point has the same pixel in every view, in metres; may be `f64::INFINITY`.
    pub focus_distance_m: f64,
    /// Perspective or orthographic.
    pub projection: Projection,
}
