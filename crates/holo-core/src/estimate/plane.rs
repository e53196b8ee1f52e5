//! A plane of disparities around a pixel.

/// Disparity as a linear function of the distance to a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Plane {
    pub(super) here: f32,
    pub(super) by_row: f32,
    pub(super) by_column: f32,
    /// The information of the fit, in 1/px^2.
    pub(super) information: f32,
}
