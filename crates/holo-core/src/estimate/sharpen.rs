//! Sharp edges: near a jump of the disparity every pixel takes that of the pixels around it that look like it.
//!
//! Costs of squares of pixels and smooth paths make foregrounds wider by some pixels where the background has little texture.
//!
//! # Source
//!
//! Weighted median filter of disparities, guided by color: Ma, He, Wei, Sun and Wu, "Constant Time Weighted Median Filtering
//! for Stereo Matching and Beyond", ICCV 2013.

use crate::base::parallel::*;

use super::plane::Plane;
use crate::base::memory::filled;
use crate::{Error, GridSize};

/// The color difference, the same in every channel, at which the weight of a pixel is 4/9, for colors from 0 to 1.
const COLOR: f32 = 0.02;
/// Half the side of the square of pixels, px.
const RADIUS: usize = 8;
/// The weight of a pixel of the same color: a whole number, for sums without rounding.
const MOST_WEIGHT: f32 = 65_536.0;
/// A jump: disparities within [`NEAR`] are more than this off the plane around a pixel, px.
const JUMP_PX: f32 = 0.1;
/// Half the side of the square that is searched for a jump, px.
const NEAR: usize = 3;
/// The largest slope of a plane, px per px: steeper ones lie across edges.
const STEEPEST: f32 = 0.015;

/// Returns the disparities of fitted planes, with the weighted medians that are more than half a jump away from a pixel near
/// one.
///
/// `image` is the central view with little noise, channel by channel.
pub(super) fn sharpen(size: GridSize, planes: &[Plane], image: &[f32]) -> Result<Vec<f32>, Error> {
    let mut out = filled("a disparity map", planes.len(), 0.0)?;
    let around = Around::new(size, planes, image);
    out.par_chunks_exact_mut(size.columns).enumerate().for_each_init(Vec::new, |found, (row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            *out = planes[row * size.columns + column].here;
            if around.has_jump(row, column) {
                let median = around.median(row, column, found);
                if (median - *out).abs() > 0.5 * JUMP_PX {
                    *out = median;
                }
            }
        }
    });
    Ok(out)
}

struct Around<'a> {
    size: GridSize,
    planes: &'a [Plane],
    image: &'a [f32],
    /// The factor of a sum of squares over channels.
    per_square: f32,
}

impl<'a> Around<'a> {
    fn new(size: GridSize, planes: &'a [Plane], image: &'a [f32]) -> Self {
        let per_square = 0.5 * planes.len() as f32 / (COLOR * COLOR * image.len() as f32);
        Self { size, planes, image, per_square }
    }

    /// The weight of a pixel whose color differs by a sum of squares over the channels.
    fn weight(&self, squares: f32) -> u32 {
        (MOST_WEIGHT / (1.0 + squares * self.per_square).powi(2)) as u32
    }

    /// The places of the pixels of a square.
    fn square(&self, row: usize, column: usize, radius: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let GridSize { rows, columns } = self.size;
        let across = column.saturating_sub(radius)..(column + radius + 1).min(columns);
        let down = row.saturating_sub(radius)..(row + radius + 1).min(rows);
        down.flat_map(move |v| across.clone().map(move |u| (v, u)))
    }

    fn has_jump(&self, row: usize, column: usize) -> bool {
        let columns = self.size.columns;
        let Plane { here, by_row, by_column, .. } = self.planes[row * columns + column];
        let [by_row, by_column] = [by_row, by_column].map(|slope| slope.clamp(-STEEPEST, STEEPEST));
        self.square(row, column, NEAR).any(|(v, u)| {
            let plane = here + by_row * (v as f32 - row as f32) + by_column * (u as f32 - column as f32);
            (self.planes[v * columns + u].here - plane).abs() > JUMP_PX
        })
    }

    fn median(&self, row: usize, column: usize, found: &mut Vec<(f32, u32)>) -> f32 {
        let (here, pixels, columns) = (row * self.size.columns + column, self.planes.len(), self.size.columns);
        let weight = |k: usize| {
            let squares: f32 =
                self.image.chunks_exact(pixels).map(|channel| (channel[k] - channel[here]).powi(2)).sum();
            self.weight(squares)
        };
        found.clear();
        let numbers = self.square(row, column, RADIUS).map(|(v, u)| v * columns + u);
        found.extend(numbers.map(|k| (self.planes[k].here, weight(k))));
        weighted_median(found)
    }
}

/// Returns the smallest value such that it and all smaller values have half of the weight. Reorders `values`, which are not empty.
fn weighted_median(mut values: &mut [(f32, u32)]) -> f32 {
    let weight_of = |values: &[(f32, u32)]| values.iter().map(|(_, weight)| weight).sum::<u32>();
    let mut half = weight_of(values).div_ceil(2);
    while values.len() > 1 {
        let middle = values.len() / 2;
        values.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0));
        let (below, above) = values.split_at_mut(middle);
        // Sums of integers are the same in any order.
        let weight = weight_of(below);
        values = if half <= weight {
            below
        } else {
            half -= weight;
            above
        };
    }
    values[0].0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The selection agrees with sorting and adding.
    #[test]
    fn the_median_has_half_of_the_weight() {
        let mut state = 9_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for count in [1, 2, 3, 10, 81, 289] {
            for distinct in [1, 4, 1000] {
                let mut values: Vec<(f32, u32)> = (0..count).map(|_| (random(distinct) as f32, random(5))).collect();
                values[0].1 = 1;
                let mut sorted = values.clone();
                sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
                let total: u32 = sorted.iter().map(|value| value.1).sum();
                let up_to = |k: usize| sorted[..=k].iter().map(|value| value.1).sum::<u32>();
                let expected = (0..sorted.len()).find(|&k| 2 * up_to(k) >= total).unwrap();
                assert_eq!(weighted_median(&mut values), sorted[expected].0, "{count} {distinct}");
            }
        }
    }

    #[test]
    fn pixels_of_another_color_weigh_less() {
        let planes = [Plane::default(); 2];
        for channels in [1, 3] {
            let image = vec![0.0; 2 * channels];
            let around = Around::new(GridSize::new(1, 2), &planes, &image);
            let weights = [0.0, 1.0, 5.0].map(|parts| around.weight(parts * channels as f32 * COLOR * COLOR));
            assert_eq!(weights, [65_536, 29_127, 5349], "{channels}");
        }
    }

    /// A foreground that is three pixels too wide gets the width of its color; a slope keeps every value.
    #[test]
    fn edges_of_the_map_move_to_those_of_the_image() {
        let size = GridSize::new(30, 40);
        let column = |pixel: usize| pixel % 40;
        let image: Vec<f32> = (0..1200).map(|pixel| if column(pixel) < 20 { 0.7 } else { 0.4 }).collect();
        let flat = |here: f32| Plane { here, ..Plane::default() };
        let planes: Vec<Plane> = (0..1200).map(|pixel| flat(if column(pixel) < 23 { 1.0 } else { -0.5 })).collect();
        let sharp = sharpen(size, &planes, &image).unwrap();
        assert!((0..1200).all(|pixel| sharp[pixel] == if column(pixel) < 20 { 1.0 } else { -0.5 }));
        let slope = |pixel: usize| Plane { here: 0.02 * column(pixel) as f32, by_column: 0.02, ..Plane::default() };
        let slope: Vec<Plane> = (0..1200).map(slope).collect();
        let kept = sharpen(size, &slope, &[0.5; 1200]).unwrap();
        assert!(kept.iter().zip(&slope).all(|(kept, plane)| *kept == plane.here));
    }
}
