//! The reference implementation of the aggregation: Hirschmueller's recursion pixel by pixel and direction by
//! direction.

use super::{EDGE, LARGE, SMALL, aggregate};
use crate::GridSize;

/// The cost of the best path in one direction at every pixel and plane.
fn along(costs: &[u16], size: GridSize, planes: usize, guide: &[f32], direction: (isize, isize)) -> Vec<i64> {
    let (rows, columns) = (size.rows, size.columns);
    let mut paths = vec![0_i64; costs.len()];
    // An order in which the previous pixel of the path always comes first.
    let mut pixels: Vec<(usize, usize)> = (0..rows * columns).map(|pixel| (pixel / columns, pixel % columns)).collect();
    pixels.sort_by_key(|&(row, column)| row as isize * direction.0 * columns as isize + column as isize * direction.1);
    for (row, column) in pixels {
        let pixel = row * columns + column;
        let before = row
            .checked_add_signed(-direction.0)
            .zip(column.checked_add_signed(-direction.1))
            .filter(|&(row, column)| row < rows && column < columns)
            .map(|(row, column)| row * columns + column);
        for plane in 0..planes {
            let mut value = i64::from(costs[pixel * planes + plane]);
            if let Some(before) = before {
                let edge = (guide[before] - guide[pixel]) / EDGE;
                let jump = i64::from((LARGE.1 + (LARGE.0 - LARGE.1) / (1.0 + edge * edge)) as u16);
                let from = &paths[before * planes..(before + 1) * planes];
                let least = *from.iter().min().unwrap();
                value += from
                    .iter()
                    .enumerate()
                    .map(|(other, &cost)| match plane.abs_diff(other) {
                        0 => cost,
                        1 => cost + i64::from(SMALL as u16),
                        _ => cost + jump,
                    })
                    .chain([least + jump])
                    .min()
                    .unwrap()
                    - least;
            }
            paths[pixel * planes + plane] = value;
        }
    }
    paths
}

#[test]
fn sums_agree_with_the_recursion() {
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    // Wider than a chunk, single rows and columns, a single pixel.
    for (rows, columns, planes) in [(7, 150, 6), (13, 9, 11), (1, 30, 5), (30, 1, 5), (1, 1, 5)] {
        let size = GridSize::new(rows, columns);
        let costs: Vec<u16> = (0..rows * columns * planes).map(|_| (random() % 1001) as u16).collect();
        let guide: Vec<f32> = (0..rows * columns).map(|_| (random() % 100) as f32 / 300.0).collect();
        let mut sums = vec![9; costs.len()];
        aggregate(&costs, size, planes, &guide, &mut sums);
        let mut expected = vec![0; costs.len()];
        for direction in [(0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
            for (sum, path) in expected.iter_mut().zip(along(&costs, size, planes, &guide, direction)) {
                *sum += path;
            }
        }
        assert!(sums.iter().zip(&expected).all(|(&found, &expected)| i64::from(found) == expected), "{rows}x{columns}");
    }
}
