//! The sweep: a first map from the costs of all planes at all pixels, in bands of limited memory.

use crate::base::parallel::*;

use super::cost::{self, Planes};
use super::pyramid::Prior;
use super::scanline;
use super::views::Views;
use crate::base::memory::filled;
use crate::light_field::layout::checked_product;
use crate::{Error, GridSize};

/// The memory of the costs and their sums together, unless four times the margin needs more.
pub(super) const BAND_BYTES: usize = 256 << 20;
/// Rows above and below a band in which its paths start. Rows farther away have hardly any influence.
const MARGIN_ROWS: usize = 32;

/// Returns the disparity of lowest cost of every pixel, interpolated between planes.
///
/// The bands depend on sizes only, so the map does not depend on the number of threads.
pub(super) fn sweep(
    views: &Views,
    planes: &Planes,
    guide: &[f32],
    prior: Option<&Prior>,
    band_bytes: usize,
) -> Result<Vec<f32>, Error> {
    let GridSize { rows, columns } = views.size;
    let too_large = Error::TooLarge { what: "volume of costs" };
    let row_cells = checked_product(&[columns, planes.count]).ok_or(too_large.clone())?;
    let tall = (band_bytes / 4 / row_cells).max(4 * MARGIN_ROWS).min(rows);
    let core = if tall == rows { rows } else { tall - 2 * MARGIN_ROWS };
    let cells = checked_product(&[tall, row_cells]).ok_or(too_large)?;
    let mut costs = filled("a cost volume", cells, 0_u16)?;
    let mut sums = filled("an aggregated cost volume", cells, 0_u16)?;
    let mut map = filled("a disparity map", rows * columns, 0.0)?;
    for first in (0..rows).step_by(core) {
        let end = (first + core).min(rows);
        let (top, bottom) = (first.saturating_sub(MARGIN_ROWS), (end + MARGIN_ROWS).min(rows));
        let cells = (bottom - top) * row_cells;
        let (costs, sums) = (&mut costs[..cells], &mut sums[..cells]);
        cost::fill(views, planes, top, costs);
        if let Some(prior) = prior {
            prior.add(planes, top, costs);
        }
        let size = GridSize::new(bottom - top, columns);
        scanline::aggregate(costs, size, planes.count, &guide[top * columns..bottom * columns], sums);
        let sums = &sums[(first - top) * row_cells..];
        map[first * columns..end * columns].par_iter_mut().with_min_len(columns).enumerate().for_each(
            |(pixel, disparity_px)| {
                let sums = &sums[pixel * planes.count..(pixel + 1) * planes.count];
                *disparity_px = planes.disparity_px(lowest(sums));
            },
        );
    }
    Ok(map)
}

/// The plane of the lowest sum, with the fraction of a parabola through it and its neighbors.
fn lowest(sums: &[u16]) -> f32 {
    let best = (1..sums.len()).fold(0, |best, plane| if sums[plane] < sums[best] { plane } else { best });
    if best == 0 || best + 1 == sums.len() {
        return best as f32;
    }
    let [before, here, after] = [-1, 0, 1].map(|step| f32::from(sums[best.wrapping_add_signed(step)]));
    let curvature = before + after - 2.0 * here;
    if curvature > 0.0 { best as f32 + 0.5 * (before - after) / curvature } else { best as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_point_of_a_parabola_is_found() {
        let sums: Vec<u16> = (0..9).map(|plane| ((plane as f32 - 3.25).powi(2) * 160.0) as u16).collect();
        // The sums are truncated to integers: 1 of a curvature of 320.
        assert!((lowest(&sums) - 3.25).abs() < 0.005, "{}", lowest(&sums));
        assert_eq!(lowest(&[3, 4, 5, 6, 7]), 0.0);
        assert_eq!(lowest(&[7, 6, 5, 4, 3]), 4.0);
        assert_eq!(lowest(&[5; 5]), 0.0);
    }
}
