//! The camera rig: a grid of parallel cameras whose sensors are shifted so that all views share one focus plane.

use super::{Intrinsics, Pinhole, RigBuilder};
use crate::base::error::{not_negative, positive, positive_or_infinite};
use crate::{Disparity, Error, LightFieldShape, Projection};

/// A validated camera rig: a grid of parallel pinhole cameras that share one focus plane.
///
/// Every parameter is finite (the focus distance may be infinite) and of the right sign.
///
/// # Units
///
/// Meters in the camera's frame: right-handed, +X right, +Y up, looking along -Z. Columns run right and rows run down.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape, Rig};
///
/// let rig = Rig::builder(LightFieldShape::new(GridSize::new(9, 9), GridSize::new(512, 512))?)
///     .focal_length_m(0.1)
///     .sensor_size_m(0.035)
///     .baseline_m(0.025)
///     .focus_distance_m(4.25)
///     .build()?;
/// assert_eq!(rig.view_x_m(8), 0.1);
/// assert!((rig.disparity().from_depth_m(3.5) - 1.8439).abs() < 5e-5);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// Validated by [`RigBuilder::build`].
    pub(super) numbers: RigBuilder,
    pub(super) disparity_x: Disparity,
    pub(super) disparity_y: Disparity,
    /// Slope per pixel: sens/(f*N).
    pub(super) slope_per_px: f64,
}

/// A ray in the camera's frame.
///
/// `direction[2]` is exactly -1, so the parameter of the ray is the planar depth: the point at depth `z` is
/// `origin_m + z * direction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigRay {
    /// The start of the ray in the plane z = 0, in meters.
    pub origin_m: [f64; 3],
    /// The displacement per meter of depth, in meters.
    pub direction: [f64; 3],
}

impl RigRay {
    /// Returns the point at planar depth `depth_m`, in meters.
    #[must_use]
    pub fn at_depth_m(&self, depth_m: f64) -> [f64; 3] {
        std::array::from_fn(|axis| self.origin_m[axis] + depth_m * self.direction[axis])
    }
}

impl RigBuilder {
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

impl Rig {
    /// Returns a builder for a rig of the given shape. Its defaults: perspective, focal length 50 mm, sensor size 36
    /// mm, focus at infinity, baseline 0.
    #[must_use]
    pub const fn builder(shape: LightFieldShape) -> RigBuilder {
        RigBuilder::new(shape)
    }

    /// Returns a builder with the parameters of this rig.
    #[must_use]
    pub const fn to_builder(&self) -> RigBuilder {
        self.numbers
    }

    /// Returns the (rows, columns) of views and of microlenses.
    #[must_use]
    pub const fn shape(&self) -> &LightFieldShape {
        &self.numbers.shape
    }

    /// Returns the focal length and the sensor size, in meters.
    #[must_use]
    pub const fn intrinsics(&self) -> Intrinsics {
        self.numbers.intrinsics
    }

    /// Returns the focal length of every view's camera, in meters.
    #[must_use]
    pub const fn focal_length_m(&self) -> f64 {
        self.numbers.intrinsics.focal_length_m
    }

    /// Returns the length of the larger image side, in meters.
    #[must_use]
    pub const fn sensor_size_m(&self) -> f64 {
        self.numbers.intrinsics.sensor_size_m
    }

    /// Returns the distance between horizontally adjacent views, in meters.
    #[must_use]
    pub const fn baseline_x_m(&self) -> f64 {
        self.numbers.baseline_x_m
    }

    /// Returns the distance between vertically adjacent views, in meters.
    #[must_use]
    pub const fn baseline_y_m(&self) -> f64 {
        self.numbers.baseline_y_m
    }

    /// Returns the depth of the focus plane, in meters; may be infinite. A point of that plane has the same pixel in
    /// every view.
    #[must_use]
    pub const fn focus_distance_m(&self) -> f64 {
        self.numbers.focus_distance_m
    }

    /// Returns the projection of every view.
    #[must_use]
    pub const fn projection(&self) -> Projection {
        self.numbers.projection
    }

    /// Returns the horizontal position of view column `s`: `(s - (S-1)/2) * baseline_x`, in meters, increasing to the
    /// right.
    ///
    /// Columns from S on have positions outside the rig.
    #[must_use]
    pub fn view_x_m(&self, s: usize) -> f64 {
        (s as f64 - (self.shape().views().columns - 1) as f64 / 2.0) * self.numbers.baseline_x_m
    }

    /// Returns the vertical position of view row `t`: `((T-1)/2 - t) * baseline_y`, in meters, decreasing
    /// from the top row on.
    #[must_use]
    pub fn view_y_m(&self, t: usize) -> f64 {
        ((self.shape().views().rows - 1) as f64 / 2.0 - t as f64) * self.numbers.baseline_y_m
    }

    /// Returns the horizontal slope of the line from the rig's center through pixel column `column`: `(column - U/2) *
    /// sens/(f*N)`.
    ///
    /// # Units
    ///
    /// `column` is in pixels from the left edge of a view: the center of column `u` is `u + 0.5`. The slope is in
    /// meters per meter of depth. N is the larger of U and V.
    #[must_use]
    pub fn slope_x(&self, column: f64) -> f64 {
        (column - self.shape().lenses().columns as f64 / 2.0) * self.slope_per_px
    }

    /// Returns the vertical slope of the line from the rig's center through pixel row `row`: `(V/2 - row) *
    /// sens/(f*N)`.
    ///
    /// # Units
    ///
    /// As [`Rig::slope_x`], with `row` in pixels from the top edge of a view.
    #[must_use]
    pub fn slope_y(&self, row: f64) -> f64 {
        (self.shape().lenses().rows as f64 / 2.0 - row) * self.slope_per_px
    }

    /// Returns the pixel column whose slope is `slope`, the inverse of [`Rig::slope_x`].
    #[must_use]
    pub fn column(&self, slope: f64) -> f64 {
        slope / self.slope_per_px + self.shape().lenses().columns as f64 / 2.0
    }

    /// Returns the pixel row whose slope is `slope`, the inverse of [`Rig::slope_y`].
    #[must_use]
    pub fn row(&self, slope: f64) -> f64 {
        self.shape().lenses().rows as f64 / 2.0 - slope / self.slope_per_px
    }

    /// Returns 1/F in 1/m; 0 for a focus at infinity.
    #[must_use]
    pub fn inverse_focus_per_m(&self) -> f64 {
        1.0 / self.numbers.focus_distance_m
    }

    /// Returns the ray of pixel `(v, u)` of view `(t, s)` through the point `(jx, jy)` of that pixel, `(0.5, 0.5)`
    /// being its center.
    ///
    /// All rays of one elemental image, which share `(v, u, jx, jy)`, intersect in one point of the focus plane. `jx`
    /// increases to the right and `jy` downward.
    ///
    /// # Source
    ///
    /// The paper's off-axis rig. Perspective: from `(x, y, 0)` to the pixel's point of the focus plane, `P = ((u + jx - U/2)
    /// q F, (V/2 - v - jy) q F, -F)` with `q = sens / (f N)`. Orthographic: through the same P in the direction `(-x, -y,
    /// -F)`, which is the same for all pixels of a view.
    #[must_use]
    pub fn ray(&self, v: usize, u: usize, t: usize, s: usize, jx: f64, jy: f64) -> RigRay {
        let (x_m, y_m) = (self.view_x_m(s), self.view_y_m(t));
        let (slope_x, slope_y) = (self.slope_x(u as f64 + jx), self.slope_y(v as f64 + jy));
        let focus_m = self.numbers.focus_distance_m;
        // For a focus at infinity the division gives 0: no shift.
        let (shift_x, shift_y) = (x_m / focus_m, y_m / focus_m);
        match self.numbers.projection {
            Projection::Perspective => {
                RigRay { origin_m: [x_m, y_m, 0.0], direction: [slope_x - shift_x, slope_y - shift_y, -1.0] }
            }
            Projection::Orthographic => RigRay {
                origin_m: [slope_x * focus_m + x_m, slope_y * focus_m + y_m, 0.0],
                direction: [-shift_x, -shift_y, -1.0],
            },
        }
    }

    /// Returns the row and column of the image of a point in view `(t, s)`, or `None` if the point is not in front of
    /// the camera.
    ///
    /// It is the inverse of [`Rig::ray`]: `project(ray.at_depth_m(z))` is `(v + jy, u + jx)`. The result may lie
    /// outside the image.
    ///
    /// # Units
    ///
    /// The point in meters in the frame of the rig, the result in pixels from the top left corner.
    #[must_use]
    pub fn project(&self, point_m: [f64; 3], t: usize, s: usize) -> Option<(f64, f64)> {
        let depth_m = -point_m[2];
        if !(depth_m > 0.0 && point_m.iter().all(|value| value.is_finite())) {
            return None;
        }
        let (x_m, y_m) = (self.view_x_m(s), self.view_y_m(t));
        let focus_m = self.numbers.focus_distance_m;
        let slope = |point: f64, view: f64| match self.numbers.projection {
            Projection::Perspective => (point - view) / depth_m + view / focus_m,
            Projection::Orthographic => (point - view + view / focus_m * depth_m) / focus_m,
        };
        Some((self.row(slope(point_m[1], y_m)), self.column(slope(point_m[0], x_m))))
    }

    /// Returns the camera of view `(t, s)` of the rig at a pose: its axes +X (right), +Y (up) and +Z (back) in the world, and its
    /// position.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] for an orthographic rig, whose views are no pinholes, and as [`Pinhole::new`].
    pub fn pinhole(&self, t: usize, s: usize, axes: [[f64; 3]; 3], position_m: [f64; 3]) -> Result<Pinhole, Error> {
        let (x_m, y_m) = (self.view_x_m(s), self.view_y_m(t));
        if self.numbers.projection == Projection::Orthographic {
            let (what, value) = ("focal length of an orthographic view", f64::INFINITY);
            return Err(Error::BadNumber { what, value, need: "finite; only perspective views are pinholes" });
        }
        let [right, up, _] = axes;
        let position_m = std::array::from_fn(|k| position_m[k] + x_m * right[k] + y_m * up[k]);
        let focus_m = self.numbers.focus_distance_m;
        let camera = Pinhole::new(axes, position_m, 1.0 / self.slope_per_px, self.shape().lenses())?;
        camera.with_principal_point([self.row(y_m / focus_m) - 0.5, self.column(x_m / focus_m) - 0.5])
    }

    /// Returns the disparity along x, which is the disparity of files.
    #[must_use]
    pub const fn disparity(&self) -> Disparity {
        self.disparity_x
    }

    /// Returns the map between depth and disparity for horizontally adjacent views.
    #[must_use]
    pub const fn disparity_x(&self) -> Disparity {
        self.disparity_x
    }

    /// Returns the map between depth and disparity for vertically adjacent views.
    #[must_use]
    pub const fn disparity_y(&self) -> Disparity {
        self.disparity_y
    }
}
