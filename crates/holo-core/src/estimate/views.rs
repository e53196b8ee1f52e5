//! The selection of views, and their samples as planes of `f32`.

use crate::base::parallel::*;
use ndarray::{ArrayView3, Data};

use super::effort::Settings;
use crate::base::memory::filled;
use crate::light_field::layout::checked_product;
use crate::{BaselineRatio, Error, GridSize, LightField, Sample};

/// The arms of the star, clockwise from the right: rows and columns of one step.
pub(super) const ARMS: [(isize, isize); 8] = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];

/// The largest number of views of a grid from the central one to a side: 9 x 9 in all.
const GRID_ARM: usize = 4;

/// One view: its position relative to the central view, and its samples.
pub(super) struct View {
    /// Pixels up that a point moves from the central view to this one, per pixel of disparity.
    pub(super) down: f32,
    /// Pixels to the left, likewise.
    pub(super) right: f32,
    /// Its arm, an index of [`ARMS`].
    pub(super) arm: usize,
    /// The larger of the two movements.
    pub(super) reach: f32,
    /// Channel by channel, row by row.
    pub(super) samples: Vec<f32>,
}

/// The central view and the views that are matched with it.
pub(super) struct Views {
    pub(super) size: GridSize,
    pub(super) channels: usize,
    /// Channel by channel, row by row.
    pub(super) center: Vec<f32>,
    pub(super) others: Vec<View>,
    /// The directions in which points move along the arms; the larger part of each is 1 (or both are 0).
    pub(super) directions: [(f32, f32); 8],
}

/// A view and where it stands: rows down and columns to the right, with the baselines, and its arm.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a, T> {
    pub(super) down: f32,
    pub(super) right: f32,
    pub(super) arm: usize,
    pub(super) image: ArrayView3<'a, T>,
}

impl Views {
    /// Copies the star or the grid of views of the settings.
    pub(super) fn gather<S>(
        light_field: &LightField<S>,
        settings: &Settings,
        ratio: BaselineRatio,
    ) -> Result<Self, Error>
    where
        S: Data,
        S::Elem: Sample,
    {
        let views = light_field.shape().views();
        let (middle_row, middle_column) = (views.rows / 2, views.columns / 2);
        let center = light_field.view(middle_row, middle_column)?;
        let placed = |(row, column, arm): (usize, usize, usize)| {
            let (down, right) = (row as f64 - middle_row as f64, column as f64 - middle_column as f64);
            let (down, right) = ((down * ratio.vertical()) as f32, (right * ratio.horizontal()) as f32);
            Ok(Placed { down, right, arm, image: light_field.view(row, column)? })
        };
        let others = chosen(views, settings).into_iter().map(placed).collect::<Result<Vec<_>, Error>>()?;
        Self::of(center, &others, settings, ratio)
    }

    /// Copies views around a central one.
    ///
    /// Views at the place of the central one are left out: in a rig without vertical baseline, those of its column.
    pub(super) fn of<T: Sample>(
        central: ArrayView3<'_, T>,
        placed: &[Placed<'_, T>],
        settings: &Settings,
        ratio: BaselineRatio,
    ) -> Result<Self, Error> {
        let (rows, columns, all_channels) = central.dim();
        // Two channels are gray and alpha, four are color and alpha.
        let colors = if all_channels >= 3 { 3 } else { 1 };
        let channels = if settings.is_grey { 1 } else { colors };
        let length = checked_product(&[rows, columns, channels]).ok_or(Error::TooLarge { what: "plane of a view" })?;
        let mut center = filled("the central view", length, 0.0)?;
        copy(&central, colors, channels, &mut center)?;
        let scale = if T::WHITE.is_none() { Scale::of(&center) } else { Scale::IDENTITY };
        scale.apply(&mut center);

        if placed.is_empty() {
            return Err(Error::ZeroCount { what: "views beside the central one" });
        }
        let (mut others, mut images) = (Vec::new(), Vec::new());
        for &Placed { down, right, arm, image } in placed {
            let reach = down.abs().max(right.abs());
            if reach > 0.0 {
                others.push(View { down, right, arm, reach, samples: filled("a view", length, 0.0)? });
                images.push(image);
            }
        }
        if others.is_empty() {
            return Err(Error::NoBaseline);
        }
        others.par_iter_mut().zip(&images).try_for_each(|(view, image)| {
            copy(image, colors, channels, &mut view.samples)?;
            scale.apply(&mut view.samples);
            Ok(())
        })?;
        Ok(Self { size: GridSize::new(rows, columns), channels, center, others, directions: directions(ratio) })
    }

    /// The largest movement of a point between the central view and another, in pixels per pixel of disparity.
    pub(super) fn reach(&self) -> f32 {
        self.others.iter().map(|view| view.reach).fold(0.0, f32::max)
    }

    /// The central view in gray, filtered by the mean of 3 x 3 pixels to reduce noise: the guide for edges.
    pub(super) fn guide(&self) -> Result<Vec<f32>, Error> {
        let GridSize { rows, columns } = self.size;
        let mut guide = filled("a guide image", self.pixels(), 0.0)?;
        guide.par_chunks_exact_mut(columns).enumerate().for_each(|(row, guide)| {
            for (column, guide) in guide.iter_mut().enumerate() {
                let (mut sum, mut count) = (0.0, 0.0);
                for channel in self.center.chunks_exact(rows * columns) {
                    for row in row.saturating_sub(1)..(row + 2).min(rows) {
                        for column in column.saturating_sub(1)..(column + 2).min(columns) {
                            sum += channel[row * columns + column];
                            count += 1.0;
                        }
                    }
                }
                *guide = sum / count;
            }
        });
        Ok(guide)
    }

    /// The number of pixels of one view.
    pub(super) fn pixels(&self) -> usize {
        self.size.rows * self.size.columns
    }
}

/// The directions of [`ARMS`] in the image, where the baselines differ.
pub(super) fn directions(ratio: BaselineRatio) -> [(f32, f32); 8] {
    ARMS.map(|(down, right)| {
        let (down, right) = (down as f64 * ratio.vertical(), right as f64 * ratio.horizontal());
        let larger = down.abs().max(right.abs());
        if larger > 0.0 { ((down / larger) as f32, (right / larger) as f32) } else { (0.0, 0.0) }
    })
}

/// The views of the star or the grid, `(row, column, arm)`.
fn chosen(views: GridSize, settings: &Settings) -> Vec<(usize, usize, usize)> {
    match settings.views_per_arm {
        Some(views_per_arm) => star(views, views_per_arm, settings.has_diagonals),
        None => grid(views),
    }
}

/// The arm whose direction is nearest to that of a place.
pub(super) fn nearest_arm(down: f32, right: f32) -> usize {
    // Clockwise from the right, as the arms.
    let eighth = down.atan2(right) / std::f32::consts::FRAC_PI_4;
    (eighth.round() as i32).rem_euclid(8) as usize
}

/// A grid of views, evenly spaced along both axes, the outermost included. Each belongs to the nearest arm.
fn grid(views: GridSize) -> Vec<(usize, usize, usize)> {
    let along = |count: usize| -> Vec<usize> {
        let middle = count / 2;
        let (before, after) = (middle, count - 1 - middle);
        let steps =
            |length: usize| (1..=length.min(GRID_ARM)).map(move |k| (k * length).div_ceil(length.min(GRID_ARM)));
        let before = steps(before).map(|step| middle - step);
        before.chain([middle]).chain(steps(after).map(|step| middle + step)).collect()
    };
    let mut chosen = Vec::new();
    for row in along(views.rows) {
        for column in along(views.columns) {
            let (down, right) = (row as f32 - (views.rows / 2) as f32, column as f32 - (views.columns / 2) as f32);
            if (down, right) != (0.0, 0.0) {
                chosen.push((row, column, nearest_arm(down, right)));
            }
        }
    }
    chosen
}

/// The views of the star: evenly spaced along every arm, the outermost included.
fn star(views: GridSize, views_per_arm: usize, has_diagonals: bool) -> Vec<(usize, usize, usize)> {
    let (middle_row, middle_column) = (views.rows / 2, views.columns / 2);
    let mut chosen = Vec::new();
    for (arm, &(down, right)) in ARMS.iter().enumerate() {
        if arm % 2 == 1 && !has_diagonals {
            continue;
        }
        let room = |step: isize, middle: usize, count: usize| match step {
            1 => count - 1 - middle,
            -1 => middle,
            _ => usize::MAX,
        };
        let length = room(down, middle_row, views.rows).min(room(right, middle_column, views.columns));
        let taken = length.min(views_per_arm);
        for index in 1..=taken {
            // Rounded up, so that the last one is the outermost; distinct because taken <= length.
            let steps = (index * length).div_ceil(taken) as isize;
            let row = middle_row.wrapping_add_signed(down * steps);
            chosen.push((row, middle_column.wrapping_add_signed(right * steps), arm));
        }
    }
    chosen
}

/// Copies one view into planes. `channels` is `colors`, or 1 for the mean of the colors.
fn copy<T: Sample>(view: &ArrayView3<'_, T>, colors: usize, channels: usize, planes: &mut [f32]) -> Result<(), Error> {
    let (rows, columns, _) = view.dim();
    let white = T::WHITE.unwrap_or(1.0);
    for row in 0..rows {
        for column in 0..columns {
            let mut mean = 0.0;
            for channel in 0..colors {
                let value = view[[row, column, channel]].to_f32() / white;
                if !value.is_finite() {
                    return Err(Error::BadNumber { what: "sample of a view", value: f64::from(value), need: "finite" });
                }
                if channels == colors {
                    planes[(channel * rows + row) * columns + column] = value;
                } else {
                    mean += value / colors as f32;
                }
            }
            if channels != colors {
                planes[row * columns + column] = mean;
            }
        }
    }
    Ok(())
}

/// A linear map of sample values to about 0 to 1.
#[derive(Clone, Copy)]
struct Scale {
    offset: f32,
    factor: f32,
}

impl Scale {
    const IDENTITY: Self = Self { offset: 0.0, factor: 1.0 };

    /// The map of the middle 98 % of the values to 0 to 1. The rest are lights and highlights.
    fn of(values: &[f32]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f32::total_cmp);
        let low = sorted[sorted.len() / 100];
        let high = sorted[sorted.len() - 1 - sorted.len() / 100];
        let factor = 1.0 / (high - low);
        // An image of one value, or of a span beyond the range of f32, cannot be matched.
        if factor.is_finite() && factor > 0.0 {
            Self { offset: low, factor }
        } else {
            Self { offset: low, factor: 0.0 }
        }
    }

    fn apply(self, values: &mut [f32]) {
        if self.factor == 1.0 && self.offset == 0.0 {
            return;
        }
        for value in values {
            // Lights are clamped, because they could overflow.
            *value = ((*value - self.offset) * self.factor).clamp(-1.0, 4.0);
        }
    }
}

/// Views of pseudo-random samples: a star with two views per arm, without one of the arms.
#[cfg(test)]
pub(super) fn test_views(rows: usize, columns: usize, channels: usize) -> Views {
    test_views_of(rows, columns, channels, BaselineRatio::EQUAL)
}

/// The same with the given baselines.
#[cfg(test)]
pub(super) fn test_views_of(rows: usize, columns: usize, channels: usize, ratio: BaselineRatio) -> Views {
    let mut state = 3_u32;
    let mut samples = || {
        let next = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Near gray, so that not all differences are truncated.
            0.4 + 0.08 * (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..rows * columns * channels).map(next).collect::<Vec<f32>>()
    };
    let center = samples();
    let mut others = Vec::new();
    for (arm, &(down, right)) in ARMS.iter().enumerate().skip(1) {
        for steps in [1.0, 3.0] {
            let (down, right) = (down as f32 * steps, right as f32 * steps);
            let (down, right) = (down * ratio.vertical() as f32, right * ratio.horizontal() as f32);
            others.push(View { down, right, arm, reach: down.abs().max(right.abs()), samples: samples() });
        }
    }
    Views { size: GridSize::new(rows, columns), channels, center, others, directions: directions(ratio) }
}

#[cfg(test)]
mod tests {
    use super::super::Effort;
    use super::*;

    fn chosen(rows: usize, columns: usize, effort: Effort) -> Vec<(usize, usize, usize)> {
        super::chosen(GridSize::new(rows, columns), &effort.settings())
    }

    #[test]
    fn stars_and_grids_reach_the_rim_and_take_no_view_twice() {
        for (rows, columns) in [(9, 9), (20, 20), (100, 100), (1, 9), (7, 1), (2, 2), (3, 40), (1, 2), (2, 1)] {
            for effort in [Effort::Draft, Effort::Fast, Effort::Balanced, Effort::Thorough] {
                let views = chosen(rows, columns, effort);
                let mut places: Vec<_> = views.iter().map(|&(row, column, _)| (row, column)).collect();
                places.sort_unstable();
                places.dedup();
                assert_eq!(places.len(), views.len(), "{rows}x{columns}");
                assert!(!places.contains(&(rows / 2, columns / 2)));
                assert!(places.iter().all(|&(row, column)| row < rows && column < columns));
                assert_eq!(columns > 1, places.contains(&(rows / 2, 0)), "{rows}x{columns}");
                assert_eq!(rows > 1, places.contains(&(0, columns / 2)), "{rows}x{columns}");
                assert!(views.len() <= 80, "what `measure` can hold");
            }
        }
        assert_eq!(chosen(9, 9, Effort::Balanced).len(), 32);
        assert_eq!(chosen(9, 9, Effort::Thorough).len(), 80);
        assert_eq!(chosen(1, 1, Effort::Thorough), []);
        // Two columns: the central one is the right one, so the only other view is left of it.
        assert_eq!(chosen(1, 2, Effort::Balanced), [(0, 0, 4)]);
    }

    #[test]
    fn floats_of_any_scale_become_zero_to_one() {
        let mut values: Vec<f32> = (0..1000).map(|value| 3e5 + 7e3 * value as f32).collect();
        values[500] = 1e30;
        let scale = Scale::of(&values);
        scale.apply(&mut values);
        assert!((values[10] - 0.0).abs() < 1e-3 && (values[989] - 1.0).abs() < 2e-3, "{} {}", values[10], values[989]);
        assert_eq!(values[500], 4.0);
        let mut even = vec![5.0; 10];
        Scale::of(&even).apply(&mut even);
        assert_eq!(even, [0.0; 10]);
    }
}
