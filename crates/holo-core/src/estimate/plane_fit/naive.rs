//! The reference implementation of the fit around one pixel: one neighbor after another, in f64.

use super::super::cells::PRIOR;
use super::{COLOR, Fit, Measurements, Neighbors, PLAIN_COLOR, Plane, RIDGE};
use crate::GridSize;

/// The plane at a pixel and its information, by the normal equations of all squares of pixels.
fn fitted(neighbors: &Neighbors, [row, column]: [usize; 2], last: &Plane, gate_px: f64, side: usize) -> [f64; 4] {
    let GridSize { rows, columns } = neighbors.size;
    let (pixels, radius) = (rows * columns, neighbors.fit.radius_px as isize);
    let (found, map) = (neighbors.found, &neighbors.cells[0].map);
    let (mut sums, mut information) = ([[0.0; 3]; 3], 0.0);
    let mut right = [0.0; 3];
    for cell_row in 0..rows.div_ceil(side) {
        for cell_column in 0..columns.div_ceil(side) {
            let off = [(cell_row, row), (cell_column, column)].map(|(cell, k)| cell as isize - (k / side) as isize);
            if off.iter().any(|off| off.abs() > radius) {
                continue;
            }
            // The square as one measurement.
            let (mut own, mut so_far, mut value, mut count, mut known) = (0.0, 0.0, 0.0, 0.0, 0.0);
            let mut color = vec![0.0; neighbors.channels];
            for v in cell_row * side..((cell_row + 1) * side).min(rows) {
                for u in cell_column * side..((cell_column + 1) * side).min(columns) {
                    let k = v * columns + u;
                    let (measured, prior) = (f64::from(found.information[k]), f64::from(PRIOR));
                    let current = f64::from(map[k]);
                    known += measured;
                    own += measured + prior;
                    so_far += (measured + prior) * current;
                    value += measured * f64::from(found.disparity_px[k]) + prior * current;
                    count += 1.0;
                    for (channel, color) in color.iter_mut().enumerate() {
                        *color += f64::from(found.image[channel * pixels + k]);
                    }
                }
            }
            let [y, x] = [(cell_row, row), (cell_column, column)]
                .map(|(cell, k)| (cell * side) as f64 + 0.5 * (side as f64 - 1.0) - k as f64);
            let plane = f64::from(last.here) + f64::from(last.by_row) * y + f64::from(last.by_column) * x;
            let same = (1.0 - ((so_far / own - plane) / gate_px).powi(2)).max(0.0);
            let here = |channel: usize| f64::from(found.image[channel * pixels + row * columns + column]);
            let squares: f64 = color.iter().enumerate().map(|(k, sum)| (sum / count - here(k)).powi(2)).sum();
            let widest = f64::from(if side == 1 { COLOR } else { PLAIN_COLOR });
            let alike = (1.0 - squares / (neighbors.channels as f64 * widest.powi(2))).max(0.0);
            let distance = (off[0] * off[0] + off[1] * off[1]) as f64;
            let near = 1.0 / (1.0 + distance / (0.75 * (radius * radius) as f64));
            information += (same * alike * near).powi(2) * known;
            let weight = (same * alike * near).powi(2) * own;
            let terms = [1.0, x, y];
            for i in 0..3 {
                for j in 0..3 {
                    sums[i][j] += weight * terms[i] * terms[j];
                }
                right[i] += weight * terms[i] * (value / own - f64::from(last.here));
            }
        }
    }
    let reach = neighbors.fit.radius_px * side;
    let ridge = sums[0][0] * (reach * reach) as f64 * f64::from(RIDGE);
    sums[1][1] += ridge;
    sums[2][2] += ridge;
    let [here, by_column, by_row] = solved(&sums, &right);
    [f64::from(last.here) + here, by_row, by_column, information]
}

/// Cramer's rule.
pub(super) fn solved(sums: &[[f64; 3]; 3], right: &[f64; 3]) -> [f64; 3] {
    let determinant = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    [0, 1, 2].map(|unknown| {
        let mut replaced = *sums;
        (0..3).for_each(|row| replaced[row][unknown] = right[row]);
        determinant(&replaced) / determinant(sums)
    })
}

/// Everywhere, in images narrower than the lanes, smaller than the square and larger, with squares of every side.
#[test]
fn lanes_agree_with_one_neighbor_after_another() {
    let mut state = 5_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for (rows, columns, channels, radius_px) in
        [(5, 3, 1, 3), (7, 11, 3, 7), (20, 33, 3, 3), (40, 38, 2, 7), (1, 19, 1, 5)]
    {
        let size = GridSize::new(rows, columns);
        let pixels = size.count();
        let map: Vec<f32> = (0..pixels).map(|pixel| 0.02 * (pixel % columns) as f32 + 0.1 * random()).collect();
        let found = Measurements {
            disparity_px: map.iter().map(|disparity_px| disparity_px + 0.05 * random()).collect(),
            information: (0..pixels).map(|_| 500.0 * random()).collect(),
            image: (0..channels * pixels).map(|_| 0.4 + 0.2 * random()).collect(),
        };
        let fit = Fit { radius_px, gate_px: 0.25, widest_px: 1.0 };
        let neighbors = Neighbors::new(&fit, size, &map, &found, &[]).unwrap();
        for pixel in 0..pixels {
            let (row, column) = (pixel / columns, pixel % columns);
            let last = Plane { here: map[pixel], by_row: 0.003, by_column: 0.02, information: 0.0 };
            for cells in &neighbors.cells {
                let side = cells.side;
                let plane = neighbors.fitted(row, column, &last, 0.25, cells);
                let expected = fitted(&neighbors, [row, column], &last, 0.25, side);
                let errors = [plane.here, plane.by_row, plane.by_column, plane.information]
                    .into_iter()
                    .zip(expected)
                    .map(|(found, expected)| (f64::from(found) - expected).abs());
                // Up to 225 terms in f32: their rounding, 2e-6 of sums, by the spread of the neighbors, which pixels at a side
                // have on one side only. Information is a sum of up to 1e5.
                for (error, bound) in errors.zip([2e-5, 2e-5, 2e-5, 1e-5 * expected[3].max(1.0)]) {
                    assert!(error < bound, "{rows}x{columns} ({row}, {column}) side {side}: {error} {bound}");
                }
            }
        }
    }
}
