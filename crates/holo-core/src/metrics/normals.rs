//! Surface normals of a disparity map, and the median angle between the normals of an estimate and of the ground truth.

use ndarray::{Array2, Array3, ArrayRef2};

use super::region::same_shape;
use super::{Region, Score};
use crate::camera::cross;
use crate::{Error, Real, Rig};

/// The geometry of the point cloud of a disparity map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum NormalGeometry {
    /// Points on the rays of the rig's central view through the pixel centers.
    #[default]
    Pinhole,
    /// The point cloud of the benchmark's toolkit: `x = u / (U-1) * 0.5 * sens/f * Z` and likewise down the rows.
    ///
    /// The toolkit's separate code for point clouds has `- 0.5`, which centers the cloud on the axis, in the place of
    /// `* 0.5`. This cloud is half as wide and high and is sheared, so its angles differ from the true ones. Published
    /// scores use it. The toolkit requires square maps; other maps follow the same formula here.
    Toolkit,
}

/// Returns the unit normals of the surface of a disparity map in the camera's frame (+X right, +Y up), facing the
/// camera.
///
/// The normal is NaN if one of the 3 x 3 neighbors is not finite or does not exist. Disparities below that of infinity
/// have negative depths by the formula; see [`Disparity::to_depth_m`](crate::Disparity::to_depth_m).
///
/// # Shape
///
/// The map is (V, U), the size of the rig's views; the result is (V, U, 3).
///
/// # Errors
///
/// [`Error::Shape`] if the map has not the size of a view; [`Error::NoBaseline`] if the rig has no horizontal baseline.
///
/// # Source
///
/// The cross product of the two derivatives of the points along rows and columns, each by the weights (3, 10, 3) of
/// Scharr, as in the toolkit's `get_depth_normals`.
///
/// # Examples
///
/// ```
/// use holo_core::metrics::{NormalGeometry, normals_from_disparity};
/// use holo_core::{GridSize, LightFieldShape, Rig};
/// use ndarray::Array2;
///
/// let rig = Rig::builder(LightFieldShape::new(GridSize::new(9, 9), GridSize::new(16, 16))?)
///     .focal_length_m(0.1)
///     .sensor_size_m(0.035)
///     .baseline_m(0.025)
///     .focus_distance_m(4.25)
///     .build()?;
/// // Disparity 0 everywhere is a wall that faces the camera.
/// let normals = normals_from_disparity(&Array2::<f32>::zeros((16, 16)), &rig, NormalGeometry::Pinhole)?;
/// assert!((normals[[8, 8, 2]] - 1.0).abs() < 1e-12);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn normals_from_disparity<T: Real>(
    disparity_px: &ArrayRef2<T>,
    rig: &Rig,
    geometry: NormalGeometry,
) -> Result<Array3<f64>, Error> {
    let (rows, columns) = disparity_px.dim();
    let lenses = rig.shape().lenses();
    if (rows, columns) != (lenses.rows, lenses.columns) {
        let expected = vec![lenses.rows, lenses.columns];
        return Err(Error::Shape { what: "disparity map", expected, found: vec![rows, columns] });
    }
    let depth_m = rig.disparity().map_to_depth_m(&disparity_px.mapv(T::to_f64))?;
    let points = points_m(&depth_m, rig, geometry);
    let mut normals = Array3::from_elem((rows, columns, 3), f64::NAN);
    for row in 1..rows.saturating_sub(1) {
        for column in 1..columns.saturating_sub(1) {
            let normal = normal(|i, j| points[[row + i - 1, column + j - 1]]);
            for axis in 0..3 {
                normals[[row, column, axis]] = normal[axis];
            }
        }
    }
    Ok(normals)
}

/// Returns the median angle between the normals of an estimated disparity map and of the ground truth, in degrees.
///
/// A pixel is excluded if one of its two normals is NaN; see [`normals_from_disparity`]. The measure is for smooth or
/// planar regions: pass their mask with the [`Region`].
///
/// # Shape
///
/// Two maps (V, U) of the size of the rig's views.
///
/// # Accuracy
///
/// The angle is the arc tangent of sine and cosine. The arc cosine of the toolkit rounds angles below about 1e-6
/// degrees to 0.
///
/// # Errors
///
/// As [`normals_from_disparity`]; [`Error::Shape`] if the mask differs in shape; [`Error::NothingToMeasure`] if border
/// and mask exclude all pixels.
///
/// # Source
///
/// Honauer et al. 2016, and `MAEPlanes` and `MAEContinSurf` of the toolkit, which differ only in their masks.
/// [`NormalGeometry::Toolkit`] gives the scores of the toolkit. At the edge of the map the toolkit wraps around to the
/// opposite edge; its border of 15 px excludes these pixels.
pub fn median_angle_error_deg<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    rig: &Rig,
    geometry: NormalGeometry,
    region: &Region<'_>,
) -> Result<Score, Error> {
    let shape = same_shape(estimate, truth)?;
    let estimated = normals_from_disparity(estimate, rig, geometry)?;
    let true_normals = normals_from_disparity(truth, rig, geometry)?;
    let (mut angles, mut excluded) = (Vec::new(), 0);
    for [row, column] in region.pixels(shape)? {
        let at = |normals: &Array3<f64>| std::array::from_fn(|axis| normals[[row, column, axis]]);
        let angle_rad = angle_rad(at(&estimated), at(&true_normals));
        if angle_rad.is_finite() {
            angles.push(angle_rad);
        } else {
            excluded += 1;
        }
    }
    if angles.is_empty() && excluded == 0 {
        return Err(Error::NothingToMeasure { what: "angle of normals", shape, border_px: region.border_px });
    }
    Ok(Score { value: median(&mut angles).to_degrees(), pixels: angles.len(), excluded })
}

/// The points of a depth map in the camera's frame.
fn points_m(depth_m: &Array2<f64>, rig: &Rig, geometry: NormalGeometry) -> Array2<[f64; 3]> {
    let (rows, columns) = depth_m.dim();
    let (t, s) = rig.shape().central_view();
    let intrinsics = rig.intrinsics();
    let scale = 0.5 * intrinsics.sensor_size_m / intrinsics.focal_length_m;
    let share = |index: usize, count: usize| index as f64 / (count as f64 - 1.0);
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let depth_m = depth_m[[row, column]];
        match geometry {
            NormalGeometry::Pinhole => rig.ray(row, column, t, s, 0.5, 0.5).at_depth_m(depth_m),
            NormalGeometry::Toolkit => {
                let across = scale * depth_m;
                [share(column, columns) * across, -share(row, rows) * across, -depth_m]
            }
        }
    })
}

/// The unit normal at the center of 3 x 3 points.
fn normal(point: impl Fn(usize, usize) -> [f64; 3]) -> [f64; 3] {
    const WEIGHTS: [f64; 3] = [3.0, 10.0, 3.0];
    let (mut down, mut right) = ([0.0; 3], [0.0; 3]);
    for (place, weight) in WEIGHTS.into_iter().enumerate() {
        let (above, below) = (point(0, place), point(2, place));
        let (left_of, right_of) = (point(place, 0), point(place, 2));
        for axis in 0..3 {
            down[axis] += weight * (below[axis] - above[axis]);
            right[axis] += weight * (right_of[axis] - left_of[axis]);
        }
    }
    // The center has weight 0 in both derivatives, but its depth must be finite.
    let center = point(1, 1)[2] * 0.0;
    // Down x right points along +Z, to the camera.
    let normal = cross(down, right);
    let length = normal[0].hypot(normal[1]).hypot(normal[2]);
    normal.map(|component| component / length + center)
}

fn angle_rad(a: [f64; 3], b: [f64; 3]) -> f64 {
    let sine = cross(a, b);
    let cosine: f64 = (0..3).map(|axis| a[axis] * b[axis]).sum();
    sine[0].hypot(sine[1]).hypot(sine[2]).atan2(cosine)
}

/// The median, for an even count the mean of the two middle values; NaN for an empty list.
fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    let even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if !even {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    f64::midpoint(lower, upper)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GridSize, LightFieldShape, Projection};

    const SIZE: usize = 24;

    fn rig(views: usize, projection: Projection) -> Rig {
        Rig::builder(LightFieldShape::new(GridSize::new(views, views), GridSize::new(SIZE, SIZE)).unwrap())
            .focal_length_m(0.05)
            .sensor_size_m(0.036)
            .baseline_m(0.02)
            .focus_distance_m(3.0)
            .projection(projection)
            .build()
            .unwrap()
    }

    /// The disparity of the plane through (0, 0, -3) with a given normal, as the central view sees it.
    fn plane(rig: &Rig, normal: [f64; 3]) -> Array2<f64> {
        let (t, s) = rig.shape().central_view();
        Array2::from_shape_fn((SIZE, SIZE), |(row, column)| {
            let ray = rig.ray(row, column, t, s, 0.5, 0.5);
            let dot = |vector: [f64; 3]| (0..3).map(|axis| normal[axis] * vector[axis]).sum::<f64>();
            let from_origin = [0.0 - ray.origin_m[0], 0.0 - ray.origin_m[1], -3.0 - ray.origin_m[2]];
            rig.disparity().from_depth_m(dot(from_origin) / dot(ray.direction))
        })
    }

    fn tilted(angle_deg: f64) -> [f64; 3] {
        let angle = angle_deg.to_radians();
        [angle.sin(), 0.0, angle.cos()]
    }

    #[test]
    fn normals_of_planes_are_those_of_the_planes() {
        let length = (0.3_f64 * 0.3 + 0.2 * 0.2 + 1.0).sqrt();
        let leaning = [0.3 / length, -0.2 / length, 1.0 / length];
        for projection in [Projection::Perspective, Projection::Orthographic] {
            // Even counts: the central view is not at the center of the rig.
            for rig in [rig(5, projection), rig(4, projection)] {
                for normal in [[0.0, 0.0, 1.0], tilted(30.0), leaning] {
                    let normals = normals_from_disparity(&plane(&rig, normal), &rig, NormalGeometry::Pinhole).unwrap();
                    // All points lie in the plane, so any difference of two does, up to the rounding of depths of 3 m
                    // against steps of about 0.1 m: 30 * 2^-52 * a few.
                    for row in 1..SIZE - 1 {
                        for column in 1..SIZE - 1 {
                            for axis in 0..3 {
                                let off = normals[[row, column, axis]] - normal[axis];
                                assert!(off.abs() < 1e-12, "{projection:?} {normal:?} ({row}, {column}) {off:e}");
                            }
                        }
                    }
                    assert!(normals[[0, 5, 2]].is_nan() && normals[[5, SIZE - 1, 0]].is_nan());
                }
            }
        }
    }

    #[test]
    fn angle_between_two_planes_is_the_angle_between_two_planes() {
        let rig = rig(5, Projection::Perspective);
        let (flat, tilted) = (plane(&rig, tilted(0.0)), plane(&rig, tilted(25.0)));
        let region = Region::with_border(1);
        let score = |a, b, geometry| median_angle_error_deg(a, b, &rig, geometry, &region).unwrap();
        let found = score(&tilted, &flat, NormalGeometry::Pinhole);
        assert!((found.value - 25.0).abs() < 1e-9, "{}", found.value);
        assert_eq!((found.pixels, found.excluded), ((SIZE - 2) * (SIZE - 2), 0));
        assert_eq!(score(&flat, &flat, NormalGeometry::Toolkit).value, 0.0);
        // The toolkit's cloud is an affine image of the true one: with x = (X + cZ)/2 and c = sens/(2f) up to (U-1)/U,
        // a plane leaning by 25 degrees about Y has Z = -X tan(25) + const, and what comes out is no longer 25.
        let found = score(&tilted, &flat, NormalGeometry::Toolkit).value;
        assert!((found - 25.0).abs() > 5.0, "{found}");
    }

    #[test]
    fn toolkit_geometry_is_the_formula_of_the_toolkit() {
        // By hand: Z = 3 everywhere, x = u/23 * 0.5 * 0.72 * 3, and the cloud is flat.
        let rig = rig(5, Projection::Perspective);
        let normals =
            normals_from_disparity(&Array2::<f64>::zeros((SIZE, SIZE)), &rig, NormalGeometry::Toolkit).unwrap();
        assert!((normals[[7, 9, 2]] - 1.0).abs() < 1e-14);
        let depth = Array2::from_elem((SIZE, SIZE), 3.0);
        let points = points_m(&depth, &rig, NormalGeometry::Toolkit);
        let expected = [9.0 / 23.0 * 0.5 * 0.036 * 3.0 / 0.05, -(7.0 / 23.0) * 0.5 * 0.036 * 3.0 / 0.05, -3.0];
        for axis in 0..3 {
            assert!((points[[7, 9]][axis] - expected[axis]).abs() < 1e-15);
        }
    }

    #[test]
    fn holes_are_excluded_and_counted() {
        let rig = rig(5, Projection::Perspective);
        let flat = Array2::<f32>::zeros((SIZE, SIZE));
        let mut holes = flat.clone();
        holes[[10, 10]] = f32::NAN;
        let geometry = NormalGeometry::Pinhole;
        let region = Region::with_border(1);
        let score = median_angle_error_deg(&holes, &flat, &rig, geometry, &region).unwrap();
        assert_eq!(score, Score { value: 0.0, pixels: 22 * 22 - 9, excluded: 9 });
        let everything = Array2::from_elem((SIZE, SIZE), f32::NAN);
        let score = median_angle_error_deg(&everything, &flat, &rig, geometry, &region).unwrap();
        assert!(score.value.is_nan() && score.pixels == 0);
        assert!(median_angle_error_deg(&flat, &flat, &rig, geometry, &Region::with_border(12)).is_err());
        let other = Array2::<f32>::zeros((SIZE, SIZE + 1));
        assert!(matches!(normals_from_disparity(&other, &rig, geometry), Err(Error::Shape { .. })));
    }

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), 2.5);
        assert!(median(&mut []).is_nan());
    }
}
