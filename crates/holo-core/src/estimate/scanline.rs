//! Semi-global matching: costs aggregated along eight directions.

#[cfg(test)]
mod naive;

use crate::base::parallel::*;

use super::cost::WORST;
use crate::GridSize;

/// The penalty for a change by one plane.
const SMALL: f32 = 0.06 * WORST;
/// The penalty for a larger change in a uniform region and at an edge of the image.
const LARGE: (f32, f32) = (0.6 * WORST, 0.12 * WORST);

/// The difference of gray values at which the penalty is halfway between the two.
const EDGE: f32 = 0.06;
/// Columns per task.
const CHUNK: usize = 64;

/// Adds up the path costs of the eight directions.
///
/// # Shape
///
/// `costs` and the result are row, column, plane; `guide`, the gray image, is row, column.
///
/// # Source
///
/// Hirschmueller 2008, "Stereo processing by semiglobal matching and mutual information", equations 13 and 14.
pub(crate) fn aggregate(costs: &[u16], size: GridSize, planes: usize, guide: &[f32], sums: &mut [u16]) {
    let columns = size.columns;
    sums.fill(0);
    sums.par_chunks_mut(columns * planes).enumerate().for_each(|(row, sums)| {
        let costs = &costs[row * columns * planes..(row + 1) * columns * planes];
        let guide = &guide[row * columns..(row + 1) * columns];
        along_row(costs, columns, planes, guide, sums, false);
        along_row(costs, columns, planes, guide, sums, true);
    });
    down_rows(costs, size, planes, guide, sums, false);
    down_rows(costs, size, planes, guide, sums, true);
}

fn along_row(costs: &[u16], columns: usize, planes: usize, guide: &[f32], sums: &mut [u16], backward: bool) {
    let mut path = Path::new(planes);
    let mut next = Path::new(planes);
    let mut last = None;
    for step in 0..columns {
        let column = if backward { columns - 1 - step } else { step };
        let range = column * planes..(column + 1) * planes;
        let from = last.map(|last: usize| (&path, jump(guide[last], guide[column])));
        advance(from, &costs[range.clone()], &mut next, &mut sums[range]);
        std::mem::swap(&mut path, &mut next);
        last = Some(column);
    }
}

/// The three directions from the row above (or below).
fn down_rows(costs: &[u16], size: GridSize, planes: usize, guide: &[f32], sums: &mut [u16], backward: bool) {
    let GridSize { rows, columns } = size;
    let mut paths: Vec<[Path; 3]> = (0..columns).map(|_| std::array::from_fn(|_| Path::new(planes))).collect();
    let mut next = paths.clone();
    let mut last_row = None;
    for step in 0..rows {
        let row = if backward { rows - 1 - step } else { step };
        let row_sums = &mut sums[row * columns * planes..(row + 1) * columns * planes];
        next.par_chunks_mut(CHUNK).zip(row_sums.par_chunks_mut(CHUNK * planes)).enumerate().for_each(
            |(chunk, (next, sums))| {
                for (offset, (next, sums)) in next.iter_mut().zip(sums.chunks_exact_mut(planes)).enumerate() {
                    let column = chunk * CHUNK + offset;
                    let pixel = row * columns + column;
                    let costs = &costs[pixel * planes..(pixel + 1) * planes];
                    for (direction, next) in next.iter_mut().enumerate() {
                        let from = last_row.and_then(|last: usize| {
                            let neighbor = (column + direction).checked_sub(1).filter(|&column| column < columns)?;
                            Some((&paths[neighbor][direction], jump(guide[last * columns + neighbor], guide[pixel])))
                        });
                        advance(from, costs, next, sums);
                    }
                }
            },
        );
        std::mem::swap(&mut paths, &mut next);
        last_row = Some(row);
    }
}

/// The penalty for a jump between two pixels of these gray values.
fn jump(from: f32, to: f32) -> u16 {
    let edge = (from - to) / EDGE;
    (LARGE.1 + (LARGE.0 - LARGE.1) / (1.0 + edge * edge)) as u16
}

/// The costs of the best paths to one pixel, with an unreachable plane at either end.
#[derive(Clone)]
struct Path {
    costs: Vec<u16>,
    least: u16,
}

/// The cost of an unreachable plane: above every cost, and below the end of `u16` by more than a penalty.
const FAR: u16 = 60_000;

impl Path {
    fn new(planes: usize) -> Self {
        Self { costs: vec![FAR; planes + 2], least: 0 }
    }
}

fn advance(from: Option<(&Path, u16)>, costs: &[u16], to: &mut Path, sums: &mut [u16]) {
    let planes = costs.len();
    let inner = &mut to.costs[1..=planes];
    match from {
        None => inner.copy_from_slice(costs),
        Some((from, jump)) => {
            let small = SMALL as u16;
            let (left, here, right) = (&from.costs[..planes], &from.costs[1..=planes], &from.costs[2..planes + 2]);
            let leap = from.least + jump;
            for plane in 0..planes {
                let near = left[plane].min(right[plane]) + small;
                inner[plane] = costs[plane] + (here[plane].min(near).min(leap) - from.least);
            }
        }
    }
    let mut least = u16::MAX;
    for (sum, &cost) in sums.iter_mut().zip(&*inner) {
        *sum += cost;
        least = least.min(cost);
    }
    to.least = least;
}
