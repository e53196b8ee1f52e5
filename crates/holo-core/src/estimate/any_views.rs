//! The estimate from views that stand anywhere in a plane.

use ndarray::ArrayView3;

use super::views::{Placed, Views, nearest_arm};
use super::{DisparityEstimate, PlaneSweepOptions, check_range, estimated};
use crate::{Effort, Error, Sample};

/// A view and where it stands from the view whose disparity is estimated.
#[derive(Debug, Clone, Copy)]
pub struct OffsetView<'a, T> {
    /// How far it stands below, in baselines: the disparity is that between views which are 1 apart. Fractions are allowed.
    pub down: f64,
    /// How far it stands to the right, likewise.
    pub right: f64,
    /// The image: row, column, channel.
    pub image: ArrayView3<'a, T>,
}

/// Estimates the disparity of every pixel of a view from other views anywhere in its plane: a part of a grid, a cross, a line, the
/// cameras of an array. All look in one direction, have one focal length, and one point of a plane at infinite distance (or at the
/// distance of disparity 0) in the same pixel.
///
/// As [`plane_sweep`](crate::plane_sweep); of more views than its effort takes those are taken that lie evenly in all directions. The
/// baseline ratio of the options multiplies the places.
///
/// # Errors
///
/// As [`plane_sweep`](crate::plane_sweep), and [`Error::Shape`] if the images have not the same shape; [`Error::BadNumber`] if a place
/// is not finite.
///
/// # Examples
///
/// ```
/// use holo_core::{OffsetView, PlaneSweepOptions, plane_sweep_of_views};
/// use ndarray::Array3;
///
/// // A wall that moves half a pixel for a baseline, seen from three places.
/// let wall = |v: f32, u: f32| 0.5 + 0.2 * (0.7 * u).sin() + 0.2 * (0.6 * v).cos();
/// let image = |down: f32, right: f32| {
///     Array3::from_shape_fn((24, 24, 1), |(v, u, _)| wall(v as f32 + 0.5 * down, u as f32 + 0.5 * right))
/// };
/// let (center, right, below) = (image(0.0, 0.0), image(0.0, 1.5), image(1.2, -0.4));
/// let others = [
///     OffsetView { down: 0.0, right: 1.5, image: right.view() },
///     OffsetView { down: 1.2, right: -0.4, image: below.view() },
/// ];
/// let options = PlaneSweepOptions::default().range_px(-1.0, 1.0);
/// let estimate = plane_sweep_of_views(center.view(), &others, &options)?;
/// assert!((estimate.disparity_px[[12, 12]] - 0.5).abs() < 0.01);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn plane_sweep_of_views<T: Sample>(
    center: ArrayView3<'_, T>,
    others: &[OffsetView<'_, T>],
    options: &PlaneSweepOptions,
) -> Result<DisparityEstimate, Error> {
    check_range(options.disparity_min_px, options.disparity_max_px)?;
    let ratio = options.baseline_ratio;
    let mut placed = Vec::with_capacity(others.len());
    for &OffsetView { down, right, image } in others {
        if image.dim() != center.dim() {
            let (expected, found) = (center.shape().to_vec(), image.shape().to_vec());
            return Err(Error::Shape { what: "image of a view", expected, found });
        }
        if let Some(value) = [down, right].into_iter().find(|at| !at.is_finite()) {
            return Err(Error::BadNumber { what: "place of a view in baselines", value, need: "finite" });
        }
        let arm = nearest_arm(down as f32, right as f32);
        let (down, right) = ((down * ratio.vertical()) as f32, (right * ratio.horizontal()) as f32);
        placed.push(Placed { down, right, arm, image });
    }
    let places: Vec<[f64; 2]> = others.iter().map(|view| [view.down, view.right]).collect();
    let chosen: Vec<_> = evenly_chosen_views(&places, options.effort).into_iter().map(|k| placed[k]).collect();
    let settings = options.effort.settings();
    let views = Views::of(center, &chosen, &settings, ratio)?;
    estimated(&views, &settings, options)
}

/// Returns which views [`plane_sweep_of_views`] takes of more than an effort needs: their numbers, by their places (down, right),
/// evenly chosen from all in the order of their directions and distances. All of few.
#[must_use]
pub fn evenly_chosen_views(places: &[[f64; 2]], effort: Effort) -> Vec<usize> {
    let (count, most) = (places.len(), effort.settings().most_views());
    let mut order: Vec<usize> = (0..count).collect();
    if count <= most {
        return order;
    }
    let key = |&k: &usize| {
        let [down, right] = places[k];
        (nearest_arm(down as f32, right as f32), down.abs().max(right.abs()))
    };
    order.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
    // The last of every share: the outermost one of the last arm is among them.
    (1..=most).map(|k| order[k * count / most - 1]).collect()
}

#[cfg(test)]
mod tests {
    use ndarray::Array3;

    use super::*;
    use crate::{GridSize, LightField, LightFieldShape, plane_sweep};

    /// A slanted wall: its disparity is 0.4 + 0.02 u.
    fn wall(down: f32, right: f32) -> Array3<f32> {
        let texture =
            |v: f32, u: f32| 0.5 + 0.15 * (0.9 * u).sin() + 0.15 * (0.8 * v).cos() + 0.1 * (0.31 * (u + v)).sin();
        Array3::from_shape_fn((40, 44, 1), |(v, u, _)| {
            // A point of column x is at x - d(x) * right.
            let x = (u as f32 + 0.4 * right) / (1.0 - 0.02 * right);
            texture(v as f32 + (0.4 + 0.02 * x) * down, x)
        })
    }

    /// All views of a grid, given one by one, are the grid.
    #[test]
    fn views_of_a_grid_are_the_grid() {
        let images: Vec<Array3<f32>> = (0..9).map(|k| wall((k / 3) as f32 - 1.0, (k % 3) as f32 - 1.0)).collect();
        let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(40, 44)).unwrap();
        let mut field = LightField::filled(shape, 1, crate::Layout::ViewpointGrid, 0.0_f32).unwrap();
        for ((v, u, t, s, c), sample) in field.samples_mut().indexed_iter_mut() {
            *sample = images[3 * t + s][[v, u, c]];
        }
        let options = PlaneSweepOptions::default().range_px(-0.5, 2.0).effort(Effort::Thorough);
        let whole = plane_sweep(&field, &options).unwrap();
        let others: Vec<OffsetView<'_, f32>> = (0..9)
            .filter(|&k| k != 4)
            .map(|k| OffsetView { down: (k / 3) as f64 - 1.0, right: (k % 3) as f64 - 1.0, image: images[k].view() })
            .collect();
        assert_eq!(plane_sweep_of_views(images[4].view(), &others, &options).unwrap(), whole);
    }

    /// Views at random places of the plane, and few of them.
    #[test]
    fn places_need_no_grid() {
        let places = [(0.3, 1.7), (-1.1, 0.4), (0.9, -1.3), (-0.6, -0.9), (1.8, 0.2)];
        let images: Vec<Array3<f32>> = places.iter().map(|&(down, right)| wall(down, right)).collect();
        let others: Vec<OffsetView<'_, f32>> = places
            .iter()
            .zip(&images)
            .map(|(&(down, right), image)| OffsetView {
                down: f64::from(down),
                right: f64::from(right),
                image: image.view(),
            })
            .collect();
        let center = wall(0.0, 0.0);
        for count in [2, 5] {
            let options = PlaneSweepOptions::default().range_px(-0.5, 2.0);
            let found = plane_sweep_of_views(center.view(), &others[..count], &options).unwrap().disparity_px;
            let inside = |&((v, u), _): &((usize, usize), &f32)| (8..32).contains(&v) && (8..36).contains(&u);
            let errors = found.indexed_iter().filter(inside).map(|((_, u), d)| (d - 0.4 - 0.02 * u as f32).abs());
            let worst = errors.fold(0.0_f32, f32::max);
            assert!(worst < 0.02, "{count}: {worst}");
        }
    }

    #[test]
    fn more_views_than_needed_are_thinned_evenly_and_wrong_ones_refused() {
        let image = wall(0.0, 0.0);
        let places: Vec<[f64; 2]> = (0..200).map(|k| [f64::from(k % 20) - 9.5, f64::from(k / 20) - 4.5]).collect();
        let mut kept = evenly_chosen_views(&places, Effort::Balanced);
        let arm = |k: &usize| nearest_arm(places[*k][0] as f32, places[*k][1] as f32);
        assert!((0..8).all(|expected| kept.iter().any(|k| arm(k) == expected)));
        kept.sort_unstable();
        kept.dedup();
        assert_eq!(kept.len(), 32);
        assert_eq!(evenly_chosen_views(&places[..5], Effort::Balanced), [0, 1, 2, 3, 4]);
        let options = PlaneSweepOptions::default();
        let view = |down, image| OffsetView { down, right: 0.0, image };
        let small = Array3::<f32>::zeros((3, 3, 1));
        let estimate = |others: &[OffsetView<'_, f32>]| plane_sweep_of_views(image.view(), others, &options);
        assert!(matches!(estimate(&[]), Err(Error::ZeroCount { .. })));
        assert!(matches!(estimate(&[view(1.0, small.view())]), Err(Error::Shape { .. })));
        assert!(matches!(estimate(&[view(f64::NAN, image.view())]), Err(Error::BadNumber { .. })));
        assert!(matches!(estimate(&[view(0.0, image.view())]), Err(Error::NoBaseline)));
    }
}
