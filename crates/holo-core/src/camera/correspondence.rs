//! Where cameras see the same points.

use ndarray::{Array2, ArrayRef2};

use super::Pinhole;
use crate::Error;
use crate::base::memory::filled;

/// How much farther than everything around its place a point may be and still be seen, relative: the curvature of a surface
/// between pixels, and the rounding of depth maps.
const SEEN: f64 = 1e-4;

/// Where another camera sees the point of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correspondence {
    /// Row and column in the image of the other camera, whole in the middle of a pixel. They may lie outside of the image; NaN
    /// if the point is not in front of the camera.
    pub place: [f64; 2],
    /// The planar depth there, m; `+infinity` of a pixel that hits nothing.
    pub depth_m: f64,
    /// Whether the other camera sees the point: its place is in the image and nothing hides it there.
    pub is_visible: bool,
}

impl Pinhole {
    /// Returns where another camera sees the points of all pixels, from the depths of both.
    ///
    /// # Units
    ///
    /// Planar depth in meters, `+infinity` where nothing is hit: such a pixel corresponds to the place in the same direction.
    ///
    /// # Accuracy
    ///
    /// Places are those of the given depth to the rounding of f64. A point is hidden if it is deeper than all four pixels of the
    /// other camera around its place by more than 0.01 %; within a pixel of an edge of the scene both answers may be right.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if a map has not the size of its camera's image; [`Error::OutOfMemory`] if the allocation fails.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, Pinhole};
    /// use ndarray::Array2;
    ///
    /// let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let camera = |x_m| Pinhole::new(axes, [x_m, 0.0, 0.0], 100.0, GridSize::new(3, 9));
    /// let wall = Array2::from_elem((3, 9), 2.0);
    /// // 4 cm to the right of the first, the second sees the wall 2 pixels farther to the left.
    /// let found = camera(0.0)?.correspondences(&wall, &camera(0.04)?, &wall)?;
    /// assert_eq!((found[[1, 5]].place, found[[1, 5]].is_visible), ([1.0, 3.0], true));
    /// assert!(!found[[1, 1]].is_visible);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn correspondences(
        &self,
        depth_m: &ArrayRef2<f32>,
        other: &Self,
        other_depth_m: &ArrayRef2<f32>,
    ) -> Result<Array2<Correspondence>, Error> {
        for (camera, map) in [(self, depth_m), (other, other_depth_m)] {
            let size = camera.size();
            if map.dim() != (size.rows, size.columns) {
                let (expected, found) = (vec![size.rows, size.columns], map.shape().to_vec());
                return Err(Error::Shape { what: "depth map of a camera", expected, found });
            }
        }
        let (rows, columns) = depth_m.dim();
        let none = Correspondence { place: [f64::NAN; 2], depth_m: f64::NAN, is_visible: false };
        let mut all = filled("the correspondences of a camera", rows * columns, none)?;
        for (index, found) in all.iter_mut().enumerate() {
            let at = [index / columns, index % columns];
            *found = self.seen_by(at, f64::from(depth_m[at]), other, other_depth_m);
        }
        Ok(Array2::from_shape_vec((rows, columns), all).expect("the length is the product"))
    }

    fn seen_by(&self, at: [usize; 2], depth_m: f64, other: &Self, other_depth_m: &ArrayRef2<f32>) -> Correspondence {
        let direction = self.direction(at.map(|index| index as f64));
        let seen = if depth_m.is_finite() {
            other.place_of(std::array::from_fn(|k| self.position_m()[k] + depth_m * direction[k]))
        } else {
            // What is infinitely far away moves by the rotation alone.
            other
                .place_of(std::array::from_fn(|k| other.position_m()[k] + direction[k]))
                .map(|(place, _)| (place, depth_m))
        };
        let Some((place, depth_m)) = seen else {
            return Correspondence { place: [f64::NAN; 2], depth_m: f64::NAN, is_visible: false };
        };
        let size = other.size();
        let is_inside = |at: f64, count: usize| (-0.5..=count as f64 - 0.5).contains(&at);
        let is_visible = is_inside(place[0], size.rows) && is_inside(place[1], size.columns) && {
            let around =
                |at: f64, count: usize| [at.floor(), at.ceil()].map(|at| at.clamp(0.0, (count - 1) as f64) as usize);
            let (rows, columns) = (around(place[0], size.rows), around(place[1], size.columns));
            let deepest = rows.iter().flat_map(|&row| columns.map(|column| other_depth_m[[row, column]]));
            depth_m <= f64::from(deepest.fold(0.0, f32::max)) * (1.0 + SEEN)
        };
        Correspondence { place, depth_m, is_visible }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridSize;

    const SIZE: GridSize = GridSize::new(40, 60);

    fn camera([x, y, z]: [f64; 3], turn: f64) -> Pinhole {
        let (sin, cos) = turn.sin_cos();
        let axes = [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]];
        Pinhole::new(axes, [x, y, z], 55.0, SIZE)
            .expect("a camera")
            .with_principal_point([17.5, 31.25])
            .expect("finite")
    }

    /// A wall at z = -3, and a square of 0.5 m before it at z = -2.
    fn depth_m(camera: &Pinhole) -> Array2<f32> {
        Array2::from_shape_fn((SIZE.rows, SIZE.columns), |(row, column)| {
            let direction = camera.direction([row as f64, column as f64]);
            let [_, near, far] = [0.0, -2.0, -3.0].map(|z| (z - camera.position_m()[2]) / direction[2]);
            let at = |depth: f64, axis: usize| camera.position_m()[axis] + depth * direction[axis];
            let is_square = at(near, 0).abs() < 0.25 && at(near, 1).abs() < 0.25;
            (if is_square { near } else { far }) as f32
        })
    }

    /// Points and visibility against rays of the scene, from cameras that stand and look elsewhere.
    #[test]
    fn points_are_found_and_hidden_ones_said() {
        let (a, b) = (camera([0.0, 0.0, 0.0], 0.0), camera([0.4, -0.1, 0.2], 0.15));
        let (depth_a, depth_b) = (depth_m(&a), depth_m(&b));
        let found = a.correspondences(&depth_a, &b, &depth_b).unwrap();
        let (mut hidden, mut outside, mut seen) = (0, 0, 0);
        for ((row, column), one) in found.indexed_iter() {
            let direction = a.direction([row as f64, column as f64]);
            let depth = f64::from(depth_a[[row, column]]);
            let point: [f64; 3] = std::array::from_fn(|k| a.position_m()[k] + depth * direction[k]);
            let (place, depth_there) = b.place_of(point).unwrap();
            assert_eq!((one.place, one.depth_m), (place, depth_there));
            let is_inside = (-0.5..=39.5).contains(&place[0]) && (-0.5..=59.5).contains(&place[1]);
            // On the way from the point to the other camera, at the plane of the square.
            let share = (-2.0 - point[2]) / (b.position_m()[2] - point[2]);
            let [x, y] = [0, 1].map(|k| point[k] + share * (b.position_m()[k] - point[k]));
            let edge = (x.abs() - 0.25).max(y.abs() - 0.25);
            let is_hidden = depth > 2.5 && edge < 0.0;
            // A pixel is 4 cm wide there.
            if edge.abs() > 0.06 || depth < 2.5 {
                assert_eq!(one.is_visible, is_inside && !is_hidden, "{row} {column} {one:?} {edge}");
            }
            outside += usize::from(!is_inside);
            hidden += usize::from(is_hidden && is_inside);
            seen += usize::from(one.is_visible);
        }
        assert!(hidden > 20 && outside > 50 && seen > 1000, "{hidden} {outside} {seen}");
    }

    #[test]
    fn what_hits_nothing_is_seen_in_its_direction() {
        let (a, b) = (camera([0.0; 3], 0.0), camera([5.0, 1.0, -2.0], 0.2));
        let sky = Array2::from_elem((SIZE.rows, SIZE.columns), f32::INFINITY);
        let found = a.correspondences(&sky, &b, &sky).unwrap()[[20, 10]];
        let turned = camera([0.0; 3], 0.2);
        let far: [f64; 3] = a.direction([20.0, 10.0]);
        assert_eq!(found.depth_m, f64::INFINITY);
        let (place, _) = turned.place_of(far).unwrap();
        assert!((0..2).all(|k| (found.place[k] - place[k]).abs() < 1e-9), "{found:?} {place:?}");
        assert!(found.is_visible);
        let wall = Array2::from_elem((SIZE.rows, SIZE.columns), 3.0);
        assert!(!a.correspondences(&sky, &b, &wall).unwrap()[[20, 10]].is_visible);
        let behind = a.correspondences(&wall, &camera([0.0, 0.0, -9.0], 0.0), &wall).unwrap()[[20, 10]];
        assert!(behind.place[0].is_nan() && !behind.is_visible);
        let small = Array2::from_elem((2, 2), 3.0);
        assert!(matches!(a.correspondences(&small, &b, &wall), Err(Error::Shape { .. })));
    }
}
