//! Camera paths through the views of a light field, for animations and displays.

use super::ViewOrder;
use crate::base::error::index_below;
use crate::{Error, GridSize};

/// A camera path: a sequence of views of the light field, without interpolated views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ViewPath {
    /// One turn around the middle of the grid on the largest inscribed ellipse, from the rightmost view downward
    /// (clockwise as seen from behind the cameras). The path is closed, for loops: the last view is adjacent to the
    /// first.
    Circle,
    /// One row of views from left to right.
    Sweep {
        /// The row, from 0 at the top.
        row: usize,
    },
    /// One row of views from left to right and back, the two ends once each. The path is closed, for loops.
    PingPong {
        /// The row, from 0 at the top.
        row: usize,
    },
    /// All views row by row from the top, every other row from right to left: consecutive views are adjacent.
    Serpentine,
}

impl ViewPath {
    /// Returns the rows and columns `(t, s)` of the views of the path, in its order.
    ///
    /// Consecutive views differ. The last view of a circle differs from its first.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if there are no views; [`Error::OutOfRange`] if there is no such row; [`Error::TooLarge`]
    /// if there are more views than an array can list.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, ViewPath};
    ///
    /// let views = GridSize::new(3, 3);
    /// assert_eq!(ViewPath::PingPong { row: 1 }.views(views)?, [(1, 0), (1, 1), (1, 2), (1, 1)]);
    /// let circle = ViewPath::Circle.views(views)?;
    /// assert_eq!(circle[..3], [(1, 2), (2, 2), (2, 1)]);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn views(self, views: GridSize) -> Result<Vec<(usize, usize)>, Error> {
        // An error for grids without rows or columns, or with more views than a list can hold.
        crate::LightFieldShape::new(views, GridSize::new(1, 1))?;
        match self {
            Self::Circle => Ok(circle(views)),
            Self::Sweep { row } => {
                index_below("view row", row, views.rows)?;
                Ok((0..views.columns).map(|s| (row, s)).collect())
            }
            Self::PingPong { row } => {
                index_below("view row", row, views.rows)?;
                let back = (1..views.columns.saturating_sub(1)).rev();
                Ok((0..views.columns).chain(back).map(|s| (row, s)).collect())
            }
            Self::Serpentine => (0..views.count()).map(|index| ViewOrder::Serpentine.view(index, views)).collect(),
        }
    }
}

/// The views nearest to the points of an ellipse around the middle, without consecutive duplicates.
fn circle(views: GridSize) -> Vec<(usize, usize)> {
    let (radius_t, radius_s) = ((views.rows - 1) as f64 / 2.0, (views.columns - 1) as f64 / 2.0);
    // Eight points for every view along the path, so that no view is skipped.
    let points = 8 * 4 * views.larger();
    let mut path: Vec<(usize, usize)> = Vec::new();
    for point in 0..points {
        let angle = std::f64::consts::TAU * point as f64 / points as f64;
        // Rows run down, so increasing angles go clockwise. Both values are between 0 and count - 1 before and after
        // rounding.
        let t = (radius_t + radius_t * angle.sin()).round() as usize;
        let s = (radius_s + radius_s * angle.cos()).round() as usize;
        if path.last() != Some(&(t, s)) {
            path.push((t, s));
        }
    }
    if path.len() > 1 && path.last() == path.first() {
        path.pop();
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether two views are neighbors, diagonals included.
    fn adjacent(a: (usize, usize), b: (usize, usize)) -> bool {
        a != b && a.0.abs_diff(b.0) <= 1 && a.1.abs_diff(b.1) <= 1
    }

    #[test]
    fn circles_are_closed_and_step_to_neighbors() {
        for (rows, columns) in [(2, 2), (3, 3), (9, 9), (10, 4), (1, 7), (5, 1), (100, 100)] {
            let views = GridSize::new(rows, columns);
            let path = ViewPath::Circle.views(views).unwrap();
            for (index, &view) in path.iter().enumerate() {
                assert!(view.0 < rows && view.1 < columns);
                assert!(adjacent(view, path[(index + 1) % path.len()]), "{rows}x{columns}: {view:?}");
            }
            // It reaches all four sides.
            assert_eq!(path.iter().map(|view| view.1).max(), Some(columns - 1));
            assert_eq!(path.iter().map(|view| view.1).min(), Some(0));
            assert_eq!(path.iter().map(|view| view.0).max(), Some(rows - 1));
            assert_eq!(path.iter().map(|view| view.0).min(), Some(0));
        }
        assert_eq!(ViewPath::Circle.views(GridSize::new(1, 1)), Ok(vec![(0, 0)]));
        // Clockwise, from the right: down comes before up.
        let path = ViewPath::Circle.views(GridSize::new(9, 9)).unwrap();
        let bottom = path.iter().position(|&view| view == (8, 4)).unwrap();
        let top = path.iter().position(|&view| view == (0, 4)).unwrap();
        assert!(path[0] == (4, 8) && bottom < top);
    }

    #[test]
    fn serpentine_visits_every_view_once_by_steps_of_one() {
        let path = ViewPath::Serpentine.views(GridSize::new(4, 5)).unwrap();
        assert!(path.windows(2).all(|pair| pair[0].0.abs_diff(pair[1].0) + pair[0].1.abs_diff(pair[1].1) == 1));
        let mut sorted = path.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!((path.len(), sorted.len()), (20, 20));
    }

    #[test]
    fn ping_pong_repeats_no_end() {
        let ping_pong = |columns| ViewPath::PingPong { row: 0 }.views(GridSize::new(1, columns)).unwrap();
        assert_eq!(ping_pong(1), [(0, 0)]);
        assert_eq!(ping_pong(2), [(0, 0), (0, 1)]);
        assert_eq!(ping_pong(4), [(0, 0), (0, 1), (0, 2), (0, 3), (0, 2), (0, 1)]);
    }

    #[test]
    fn impossible_grids_and_rows_are_errors() {
        for path in [ViewPath::Circle, ViewPath::Sweep { row: 0 }, ViewPath::Serpentine] {
            assert!(path.views(GridSize::new(0, 3)).is_err());
            assert!(path.views(GridSize::new(usize::MAX, usize::MAX)).is_err());
        }
        assert!(matches!(ViewPath::Sweep { row: 3 }.views(GridSize::new(3, 3)), Err(Error::OutOfRange { .. })));
    }
}
