//! The reference implementation of the cost of one pixel on one plane.

use super::super::views::{ARMS, View, Views, test_views};
use super::{Planes, TRUNCATION, UNSEEN, WORST, fill};

/// The truncated difference of one view, or `None` outside of it.
fn difference(views: &Views, view: &View, disparity_px: f64, row: usize, column: usize) -> Option<f64> {
    let (rows, columns) = (views.size.rows, views.size.columns);
    let y = row as f64 - disparity_px * f64::from(view.down);
    let x = column as f64 - disparity_px * f64::from(view.right);
    if y < 0.0 || x < 0.0 || y > (rows - 1) as f64 || x > (columns - 1) as f64 {
        return None;
    }
    let (top, left) = (y.floor() as usize, x.floor() as usize);
    let (bottom, right) = ((top + 1).min(rows - 1), (left + 1).min(columns - 1));
    let (down, across) = (y - y.floor(), x - x.floor());
    let squares = |part: f64| (1.0 - part).powi(2) + part.powi(2);
    // The noise of the difference, in that of a difference of whole pixels.
    let noise = ((1.0 + squares(down) * squares(across)) / 2.0).sqrt();
    let mut sum = 0.0;
    for channel in 0..views.channels {
        let at = |row: usize, column: usize| f64::from(view.samples[channel * rows * columns + row * columns + column]);
        let value = (1.0 - down) * ((1.0 - across) * at(top, left) + across * at(top, right))
            + down * ((1.0 - across) * at(bottom, left) + across * at(bottom, right));
        sum += (value - f64::from(views.center[channel * rows * columns + row * columns + column])).abs();
    }
    Some((sum / noise / views.channels as f64 / f64::from(TRUNCATION)).min(1.0))
}

/// The cost, a number from 0 to 1.
fn cost(views: &Views, disparity_px: f64, row: usize, column: usize) -> f64 {
    let (rows, columns) = (views.size.rows as isize, views.size.columns as isize);
    let mut arms = [(0.0, 0.0); ARMS.len()];
    for view in &views.others {
        for step in 0..9 {
            let row = (row as isize + step / 3 - 1).clamp(0, rows - 1) as usize;
            let column = (column as isize + step % 3 - 1).clamp(0, columns - 1) as usize;
            if let Some(difference) = difference(views, view, disparity_px, row, column) {
                arms[view.arm].0 += difference;
                arms[view.arm].1 += 1.0;
            }
        }
    }
    let all: f64 = arms.iter().map(|arm| arm.1).sum();
    if all == 0.0 {
        return f64::from(UNSEEN);
    }
    (0..8)
        .filter_map(|middle| {
            let half = (6..11).map(|turn| arms[(middle + turn) % 8]);
            let (sum, count) = half.fold((0.0, 0.0), |total, arm| (total.0 + arm.0, total.1 + arm.1));
            (count * 3.0 >= all).then_some(sum / count)
        })
        .fold(1.0, f64::min)
}

#[test]
fn tiles_agree_with_the_definition() {
    for (rows, columns, channels) in [(21, 19, 3), (9, 34, 1), (1, 17, 1), (11, 1, 3), (2, 2, 1)] {
        let views = test_views(rows, columns, channels);
        // Quarters, halves and whole pixels, some of them outside the image in every view.
        let planes = Planes { first_px: -3.0, step_px: 0.375, count: 17 };
        let mut costs = vec![0; rows * columns * planes.count];
        fill(&views, &planes, 0, &mut costs);
        for row in 0..rows {
            for column in 0..columns {
                for plane in 0..planes.count {
                    let disparity_px = f64::from(planes.disparity_px(plane as f32));
                    let expected = cost(&views, disparity_px, row, column) * f64::from(WORST);
                    let found = f64::from(costs[(row * columns + column) * planes.count + plane]);
                    // Rounding to an integer is half a unit; the rest is f32.
                    assert!(
                        (found - expected).abs() < 0.51,
                        "{rows}x{columns} ({row}, {column}) {plane}: {found}, {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_band_has_the_costs_of_the_whole() {
    let views = test_views(40, 13, 1);
    let planes = Planes { first_px: -1.0, step_px: 0.25, count: 9 };
    let row_cells = 13 * planes.count;
    let mut whole = vec![0; 40 * row_cells];
    fill(&views, &planes, 0, &mut whole);
    let mut band = vec![0; 11 * row_cells];
    fill(&views, &planes, 5, &mut band);
    assert_eq!(band, whole[5 * row_cells..16 * row_cells]);
}
