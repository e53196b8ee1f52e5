//! A pinhole camera anywhere in the world.

use super::rotation::{dot, rotation_near};
use crate::base::error::positive;
use crate::{Error, GridSize};

/// A pinhole camera anywhere in the world with square pixels. Its principal point is the middle of the image unless it is set:
/// the views of a [`Rig`](crate::Rig) have it elsewhere.
///
/// # Units
///
/// Meters. Places in its image are (row, column) from 0, whole in the middle of a pixel. Depth is planar: along the optical axis.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Pinhole};
///
/// // 3 m before the origin, towards it.
/// let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let camera = Pinhole::new(axes, [0.0, 0.0, 3.0], 100.0, GridSize::new(11, 21))?;
/// // A point 0.3 m to the right and 1 m nearer is 15 pixels to the right of the middle.
/// assert_eq!(camera.place_of([0.3, 0.0, 1.0]), Some(([5.0, 25.0], 2.0)));
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    axes: [[f64; 3]; 3],
    position_m: [f64; 3],
    focal_px: f64,
    size: GridSize,
    /// Row and column.
    principal_point: [f64; 2],
}

impl Pinhole {
    /// Returns the camera with the axes +X (right), +Y (up) and +Z (back) in the world, which may be rounded: see [`rotation_near`].
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the axes are no right-handed frame of unit vectors, the position is not finite, or the focal length
    /// is not finite and above 0; [`Error::ZeroCount`] without pixels.
    pub fn new(axes: [[f64; 3]; 3], position_m: [f64; 3], focal_px: f64, size: GridSize) -> Result<Self, Error> {
        let focal_px = positive("focal length in pixels", focal_px)?;
        if size.count() == 0 {
            return Err(Error::ZeroCount { what: "pixels of a camera" });
        }
        if let Some(&value) = position_m.iter().find(|x| !x.is_finite()) {
            return Err(Error::BadNumber { what: "position of a camera in meters", value, need: "finite" });
        }
        let principal_point = [size.rows, size.columns].map(|count| (count - 1) as f64 / 2.0);
        Ok(Self { axes: rotation_near(axes)?, position_m, focal_px, size, principal_point })
    }

    /// The axes +X (right), +Y (up) and +Z (back), each of length 1.
    #[must_use]
    pub const fn axes(&self) -> [[f64; 3]; 3] {
        self.axes
    }

    /// Where it stands, m.
    #[must_use]
    pub const fn position_m(&self) -> [f64; 3] {
        self.position_m
    }

    /// The focal length, px.
    #[must_use]
    pub const fn focal_px(&self) -> f64 {
        self.focal_px
    }

    /// Rows and columns of its image.
    #[must_use]
    pub const fn size(&self) -> GridSize {
        self.size
    }

    /// Returns the camera with the principal point at a row and a column, where it sees along its axis.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if they are not finite.
    pub fn with_principal_point(self, principal_point: [f64; 2]) -> Result<Self, Error> {
        match principal_point.iter().find(|at| !at.is_finite()) {
            Some(&value) => Err(Error::BadNumber { what: "principal point in pixels", value, need: "finite" }),
            None => Ok(Self { principal_point, ..self }),
        }
    }

    /// The row and the column where it sees along its axis.
    #[must_use]
    pub const fn principal_point(&self) -> [f64; 2] {
        self.principal_point
    }

    /// The way of the light of a place of the image, in the world, per meter of depth.
    #[must_use]
    pub fn direction(&self, place: [f64; 2]) -> [f64; 3] {
        let [x, y] = self.slopes(place);
        let [right, up, back] = self.axes;
        std::array::from_fn(|k| x * right[k] + y * up[k] - back[k])
    }

    /// The place of the image of a point, which may lie outside of the image, and its depth in meters; `None` if it is not in front
    /// of the camera.
    #[must_use]
    pub fn place_of(&self, point_m: [f64; 3]) -> Option<([f64; 2], f64)> {
        let [x, y, depth_m] = self.seen(std::array::from_fn(|k| point_m[k] - self.position_m[k]));
        (depth_m > 0.0).then(|| (self.place([x / depth_m, y / depth_m]), depth_m))
    }

    /// A vector of the world along the right, up and forward.
    fn seen(&self, vector: [f64; 3]) -> [f64; 3] {
        let [right, up, back] = self.axes;
        [dot(vector, right), dot(vector, up), -dot(vector, back)]
    }

    /// Meters to the right and up per meter of depth.
    pub(crate) fn slopes(&self, [row, column]: [f64; 2]) -> [f64; 2] {
        let [middle_row, middle_column] = self.principal_point;
        [(column - middle_column) / self.focal_px, (middle_row - row) / self.focal_px]
    }

    /// The place at which slopes are seen.
    pub(crate) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [middle_row, middle_column] = self.principal_point;
        [middle_row - y * self.focal_px, middle_column + x * self.focal_px]
    }
}

/// Where a camera sees the points of another one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Relative {
    /// The position of the other one, along right, up and forward.
    pub origin_m: [f64; 3],
    /// Its axes right, up and forward, along them.
    axes: [[f64; 3]; 3],
}

impl Relative {
    pub fn new(camera: &Pinhole, other: &Pinhole) -> Self {
        let away = std::array::from_fn(|k| other.position_m[k] - camera.position_m[k]);
        let [right, up, back] = other.axes;
        Self { origin_m: camera.seen(away), axes: [right, up, back.map(|x| -x)].map(|axis| camera.seen(axis)) }
    }

    /// The way of the light that the other one sees at its slopes, per meter of depth there.
    pub fn direction(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let [right, up, ahead] = &self.axes;
        std::array::from_fn(|k| x * right[k] + y * up[k] + ahead[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LightFieldShape, Projection, Rig};

    const SIZE: GridSize = GridSize::new(6, 9);

    /// A camera turned about two axes.
    fn turned() -> Pinhole {
        let ((sin, cos), (rise, flat)) = (0.4_f64.sin_cos(), (-0.7_f64).sin_cos());
        let axes = [[cos, 0.0, -sin], [-sin * rise, flat, -cos * rise], [sin * flat, rise, cos * flat]];
        Pinhole::new(axes, [1.0, -2.0, 0.5], 12.5, SIZE).expect("a camera")
    }

    #[test]
    fn points_on_a_ray_are_seen_at_its_place() {
        let camera = turned();
        for place in [[0.0, 0.0], [5.0, 8.0], [2.5, 4.0], [-3.0, 20.25]] {
            let direction = camera.direction(place);
            for depth_m in [1e-3, 1.0, 70.0] {
                let point = std::array::from_fn(|k| camera.position_m()[k] + depth_m * direction[k]);
                let ([row, column], found_m) = camera.place_of(point).expect("in front");
                assert!((row - place[0]).abs() < 1e-9 && (column - place[1]).abs() < 1e-9, "{place:?} {row} {column}");
                assert!((found_m / depth_m - 1.0).abs() < 1e-9);
            }
            let behind = std::array::from_fn(|k| camera.position_m()[k] - direction[k]);
            assert_eq!(camera.place_of(behind), None);
        }
    }

    /// The views of a rig are pinholes with its rays.
    #[test]
    fn views_of_rigs_are_pinholes() {
        let shape = LightFieldShape::new(GridSize::new(3, 5), GridSize::new(20, 30)).expect("a shape");
        let builder = Rig::builder(shape).focal_length_m(0.04).baseline_x_m(0.05).baseline_y_m(0.03);
        for focus_m in [1.7, f64::INFINITY] {
            let rig = builder.focus_distance_m(focus_m).build().expect("a rig");
            let base = turned();
            for (t, s) in [(0, 0), (1, 2), (2, 4), (0, 3)] {
                let view = rig.pinhole(t, s, base.axes(), base.position_m()).expect("a camera");
                for (v, u, depth_m) in [(0, 0, 0.3), (7, 19, 2.0), (19, 29, 40.0)] {
                    let [x, y, z] = rig.ray(v, u, t, s, 0.5, 0.5).at_depth_m(depth_m);
                    let [right, up, back] = base.axes();
                    let point = std::array::from_fn(|k| base.position_m()[k] + x * right[k] + y * up[k] + z * back[k]);
                    let ([row, column], found_m) = view.place_of(point).expect("in front");
                    assert!((row - v as f64).abs() < 1e-9 && (column - u as f64).abs() < 1e-9, "{row} {column}");
                    assert!((found_m / depth_m - 1.0).abs() < 1e-12);
                }
            }
        }
        let flat = builder.focus_distance_m(1.0).projection(Projection::Orthographic).build().expect("a rig");
        assert!(flat.pinhole(0, 0, turned().axes(), [0.0; 3]).is_err());
    }

    #[test]
    fn cameras_that_are_none_are_refused() {
        let good = turned();
        let [right, up, back] = good.axes();
        assert!(Pinhole::new([up, right, back], [0.0; 3], 1.0, SIZE).is_err());
        for (focal_px, size) in [(0.0, SIZE), (f64::NAN, SIZE), (1.0, GridSize::new(0, 3))] {
            assert!(Pinhole::new(good.axes(), [0.0; 3], focal_px, size).is_err());
        }
        assert!(Pinhole::new(good.axes(), [0.0, f64::INFINITY, 0.0], 1.0, SIZE).is_err());
    }
}
