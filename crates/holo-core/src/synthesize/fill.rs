//! The farthest surface around a hole fills it: what is hidden from a view belongs to it.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Neighboring pixels whose disparities differ by more belong to different surfaces, px.
pub(super) const STEP_PX: f32 = 0.5;

/// Fills the pixels of a map that are NaN, and their colors of `channels` numbers a pixel, from their neighbors: the farthest ones
/// spread first, into all of a hole that they reach. A map without any number stays as it is.
pub(crate) fn fill(map: &mut [f32], [rows, columns]: [usize; 2], colors: &mut [f32], channels: usize) {
    let neighbors = |at: usize| {
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        near(at / columns, rows)
            .flat_map(move |row| near(at % columns, columns).map(move |column| row * columns + column))
    };
    let is_known = |map: &[f32], k: usize| !map[k].is_nan();
    let is_rim = |k: &usize| is_known(map, *k) && neighbors(*k).any(|near| !is_known(map, near));
    let mut rim: BinaryHeap<Reverse<Rim>> =
        (0..map.len()).filter(is_rim).map(|at| Reverse(Rim { disparity_px: map[at], at })).collect();
    let mut color = vec![0.0; channels];
    while let Some(Reverse(Rim { disparity_px, at })) = rim.pop() {
        for hole in neighbors(at) {
            if is_known(map, hole) {
                continue;
            }
            let (mut count, mut sum_px) = (0.0, 0.0);
            color.fill(0.0);
            for k in neighbors(hole).filter(|&k| (map[k] - disparity_px).abs() <= STEP_PX) {
                count += 1.0;
                sum_px += map[k];
                color.iter_mut().zip(&colors[k * channels..]).for_each(|(sum, value)| *sum += value);
            }
            map[hole] = sum_px / count;
            colors[hole * channels..][..channels].iter_mut().zip(&color).for_each(|(value, sum)| *value = sum / count);
            rim.push(Reverse(Rim { disparity_px: map[hole], at: hole }));
        }
    }
}

/// A pixel beside a hole; the farthest is the least.
#[derive(PartialEq)]
struct Rim {
    disparity_px: f32,
    at: usize,
}

impl Eq for Rim {}

impl Ord for Rim {
    fn cmp(&self, other: &Self) -> Ordering {
        self.disparity_px.total_cmp(&other.disparity_px).then(self.at.cmp(&other.at))
    }
}

impl PartialOrd for Rim {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::fill;

    #[test]
    fn the_farthest_surface_fills_a_hole() {
        let mut map = [8.0, 8.0, f32::NAN, f32::NAN, f32::NAN, 0.25];
        let mut colors = [1.0, 1.0, 9.0, 9.0, 9.0, 0.5];
        fill(&mut map, [1, 6], &mut colors, 1);
        assert_eq!(map, [8.0, 8.0, 0.25, 0.25, 0.25, 0.25]);
        assert_eq!(colors, [1.0, 1.0, 0.5, 0.5, 0.5, 0.5]);
        let mut nothing = [f32::NAN; 4];
        fill(&mut nothing, [2, 2], &mut [], 0);
        assert!(nothing.iter().all(|x| x.is_nan()));
    }
}
