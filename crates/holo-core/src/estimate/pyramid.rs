//! Coarser levels: views of half the resolution, whose estimate tells where to look in what has no texture.

use crate::base::parallel::*;

use super::cost::Planes;
use super::plane::Plane;
use super::views::{View, Views};
use crate::base::memory::filled;
use crate::{Error, GridSize};

/// The shorter side, px, from which on views have a coarser level.
const SHORTEST: usize = 128;
/// The largest cost of a plane far from the coarser estimate.
const MOST: f32 = 300.0;
/// The same in mean second differences of the costs from plane to plane, which are their noise where nothing matches better
/// than anything else.
const ROUGH: f32 = 6.0;
/// The information of the coarser level, in 1/px^2 of the finer one, at which the cost is half as large.
const HALF: f32 = 25.0;
/// The distance from the coarser estimate, in planes of the sweep, within which the sweep is no better.
const NEAR: f32 = 2.5;

impl Views {
    /// The views in half the resolution; `None` for small views.
    pub(super) fn halved(&self) -> Result<Option<Self>, Error> {
        let GridSize { rows, columns } = self.size;
        if rows.min(columns) < SHORTEST {
            return Ok(None);
        }
        let halve = |samples: &[f32]| halve(self.size, self.channels, samples);
        let others = self.others.par_iter().map(|view| Ok(View { samples: halve(&view.samples)?, ..*view }));
        Ok(Some(Self {
            size: GridSize::new(rows / 2, columns / 2),
            channels: self.channels,
            center: halve(&self.center)?,
            others: others.collect::<Result<_, Error>>()?,
            directions: self.directions,
        }))
    }
}

/// Every other pixel, between two, of an image filtered by (1, 3, 3, 1) / 8 along both axes. A mean of 2 x 2 would leave
/// frequencies that alias alike in all views, at disparity 0.
fn halve(full: GridSize, channels: usize, samples: &[f32]) -> Result<Vec<f32>, Error> {
    let GridSize { rows, columns } = full;
    let half = GridSize::new(rows / 2, columns / 2);
    let mut out = filled("a smaller view", channels * half.count(), 0.0)?;
    let mut sums = filled("a row of a view", columns, 0.0)?;
    for (k, out) in out.chunks_exact_mut(half.columns).enumerate() {
        let (channel, row) = (k / half.rows, 2 * (k % half.rows));
        let line = |row: usize| &samples[(channel * rows + row) * columns..(channel * rows + row + 1) * columns];
        let [a, b, c, d] = [row.saturating_sub(1), row, row + 1, (row + 2).min(rows - 1)].map(line);
        for ((((sum, a), b), c), d) in sums.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *sum = 0.125 * (a + 3.0 * (b + c) + d);
        }
        for (column, out) in out.iter_mut().enumerate() {
            let k = 2 * column;
            let (before, after) = (sums[k.saturating_sub(1)], sums[(k + 2).min(columns - 1)]);
            *out = 0.125 * (before + 3.0 * (sums[k] + sums[k + 1]) + after);
        }
    }
    Ok(out)
}

/// What a coarser level says about the disparity of every pixel.
pub(super) struct Prior {
    planes: Vec<Plane>,
    columns: usize,
}

impl Prior {
    /// The fits of a coarser level at the pixels of a finer one: of the four pixels around, that of the most similar
    /// brightness. `map` has the disparities of the coarser level.
    pub(super) fn new(
        coarse: &Views,
        map: &[f32],
        planes: &[Plane],
        guide: &[f32],
        fine: GridSize,
    ) -> Result<Self, Error> {
        let coarse_guide = coarse.guide()?;
        let mut finer = filled("planes around pixels", fine.count(), Plane::default())?;
        finer.par_chunks_exact_mut(fine.columns).enumerate().for_each(|(v, finer)| {
            for (u, finer) in finer.iter_mut().enumerate() {
                let (near, other) = (around(v, coarse.size.rows), around(u, coarse.size.columns));
                let here = guide[v * fine.columns + u];
                let mut best = (f32::INFINITY, 0, 0);
                for (row, column) in [(near.0, other.0), (near.1, other.0), (near.0, other.1), (near.1, other.1)] {
                    let off = (coarse_guide[row * coarse.size.columns + column] - here).abs();
                    if off < best.0 {
                        best = (off, row, column);
                    }
                }
                let (_, row, column) = best;
                let pixel = row * coarse.size.columns + column;
                let Plane { by_row, by_column, information, .. } = planes[pixel];
                // A pixel of the coarser level is two of the finer one, between which its center is.
                let (y, x) = (v as f32 - 2.0 * row as f32 - 0.5, u as f32 - 2.0 * column as f32 - 0.5);
                let here = 2.0 * map[pixel] + by_row * y + by_column * x;
                *finer = Plane { here, by_row, by_column, information: 0.25 * information };
            }
        });
        Ok(Self { planes: finer, columns: fine.columns })
    }

    /// The fits.
    pub(super) fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Adds its costs to those of the rows from `first_row` on: up to some times the noise of the costs, so that it decides
    /// where they do not.
    pub(super) fn add(&self, planes: &Planes, first_row: usize, costs: &mut [u16]) {
        let first = first_row * self.columns;
        // Half of the cost two planes away.
        let scale = 0.5 / planes.step_px;
        costs.par_chunks_exact_mut(planes.count).with_min_len(self.columns).enumerate().for_each(|(k, costs)| {
            let second = |w: &[u16]| (i32::from(w[0]) - 2 * i32::from(w[1]) + i32::from(w[2])).unsigned_abs();
            let rough = costs.windows(3).map(second).sum::<u32>() as f32 / (planes.count - 2) as f32;
            let Plane { here, information, .. } = self.planes[first + k];
            let most = information / (information + HALF) * (ROUGH * rough).min(MOST);
            for (plane, cost) in costs.iter_mut().enumerate() {
                let off = (planes.disparity_px(plane as f32) - here) * scale;
                *cost += (most * off * off / (1.0 + off * off)) as u16;
            }
        });
    }

    /// Replaces disparities of a sweep that are as near as its planes: between planes the coarser estimate knows more.
    pub(super) fn replace(&self, map: &mut [f32], step_px: f32) {
        for (map, coarse) in map.iter_mut().zip(&self.planes) {
            if (*map - coarse.here).abs() <= NEAR * step_px && coarse.information > HALF {
                *map = coarse.here;
            }
        }
    }
}

/// The two pixels of a coarser level around pixel `k` of a finer one, the nearer first.
fn around(k: usize, count: usize) -> (usize, usize) {
    let other = if k.is_multiple_of(2) { (k / 2).saturating_sub(1) } else { k / 2 + 1 };
    ((k / 2).min(count - 1), other.min(count - 1))
}

#[cfg(test)]
mod tests {
    use super::super::views::test_views;
    use super::*;

    /// A slope stays a slope, and what changes from pixel to pixel is gone.
    #[test]
    fn halved_views_keep_slopes_and_lose_the_finest_pattern() {
        let mut views = test_views(130, 129, 2);
        let columns = views.size.columns;
        let value = |pixel: usize| 0.002 * (pixel / columns) as f32 + 0.003 * (pixel % columns) as f32;
        for (pixel, sample) in views.center.iter_mut().enumerate() {
            let checker = if (pixel / columns + pixel % columns).is_multiple_of(2) { 0.1 } else { -0.1 };
            *sample = value(pixel % (130 * columns)) + checker;
        }
        let halved = views.halved().unwrap().unwrap();
        assert_eq!((halved.size, halved.center.len()), (GridSize::new(65, 64), 2 * 65 * 64));
        for row in 1..64 {
            for column in 1..63 {
                let found = halved.center[row * 64 + column];
                let expected = 0.002 * (2.0 * row as f32 + 0.5) + 0.003 * (2.0 * column as f32 + 0.5);
                assert!((found - expected).abs() < 1e-6, "{row} {column}: {found} {expected}");
            }
        }
        assert!(halved.halved().unwrap().is_none());
    }

    /// The prior moves the lowest cost of a pixel without texture, and not that of a pixel with one.
    #[test]
    fn a_prior_decides_where_costs_do_not() {
        let planes = Planes { first_px: -1.0, step_px: 0.25, count: 9 };
        let plane = Plane { here: 0.5, information: 1e6, ..Plane::default() };
        let prior = Prior { planes: vec![plane; 2], columns: 2 };
        let flat = [300, 310, 290, 305, 298, 301, 299, 303, 297];
        let textured = [600, 500, 20, 480, 610, 590, 600, 605, 600];
        let mut costs: Vec<u16> = flat.into_iter().chain(textured).collect();
        prior.add(&planes, 0, &mut costs);
        let lowest = |costs: &[u16]| (0..9).min_by_key(|&k| costs[k]).unwrap();
        assert_eq!((lowest(&costs[..9]), lowest(&costs[9..])), (6, 2));
    }
}
