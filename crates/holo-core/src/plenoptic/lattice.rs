//! The lattice of the micro-images of a white image, found without knowing the camera.

use ndarray::{Array2, ArrayView2, Axis};

use super::MicrolensGrid;
use crate::base::parallel::*;

/// The side of the middle of the image that is compared with itself, px.
const SIDE: usize = 256;

/// The farthest displacement at which it is, px.
const REACH: usize = 80;

/// How often an image is halved until its lattice is found: pitches of up to half of `REACH`, 8-fold.
const HALVINGS: usize = 3;

/// A peak counts if it has this part of the highest one.
const HEIGHT: f32 = 0.7;

/// An image whose highest peak has a smaller correlation has no lattice.
const CORRELATION: f32 = 0.15;

/// The shortest step of a lattice, px.
const SHORTEST: f64 = 4.0;

/// How far steps may be from equal, and their angle from 60 or 90 degrees: relative, and as a cosine.
const EQUAL: f64 = 0.06;
const COSINE: f64 = 0.08;

/// A regular lattice of micro-images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    pub grid: MicrolensGrid,
    pub pitch_px: f64,
    /// Counterclockwise in the image.
    pub rotation_rad: f64,
}

/// The lattice of the middle of a white image; `None` without a square or hexagonal one.
pub(super) fn find(white: ArrayView2<f32>) -> Option<Lattice> {
    let mut image = smoothed(white);
    for halving in 0..=HALVINGS {
        if let Some(found) = at_one_size(image.view()) {
            return Some(Lattice { pitch_px: found.pitch_px * f64::from(1u32 << halving), ..found });
        }
        image = halved(image.view());
    }
    None
}

/// An image without the mosaic of a color sensor, whose period is 2 px.
fn smoothed(image: ArrayView2<f32>) -> Array2<f32> {
    let (rows, columns) = image.dim();
    let at =
        |v: isize, u: isize| image[[v.clamp(0, rows as isize - 1) as usize, u.clamp(0, columns as isize - 1) as usize]];
    Array2::from_shape_fn((rows, columns), |(v, u)| {
        let (v, u) = (v as isize, u as isize);
        let row = |v: isize| at(v, u - 1) + 2.0 * at(v, u) + at(v, u + 1);
        (row(v - 1) + 2.0 * row(v) + row(v + 1)) / 16.0
    })
}

fn halved(image: ArrayView2<f32>) -> Array2<f32> {
    let (rows, columns) = image.dim();
    Array2::from_shape_fn((rows / 2, columns / 2), |(v, u)| {
        (image[[2 * v, 2 * u]] + image[[2 * v, 2 * u + 1]] + image[[2 * v + 1, 2 * u]] + image[[2 * v + 1, 2 * u + 1]])
            / 4.0
    })
}

/// How an image correlates with itself, displaced.
struct Correlation {
    /// From no displacement down, and from `-reach` to the right.
    values: Array2<f32>,
    reach: isize,
}

impl Correlation {
    fn new(image: ArrayView2<f32>) -> Option<Self> {
        let (rows, columns) = image.dim();
        let [height, width] = [rows, columns].map(|count| count.min(SIDE));
        let reach = REACH.min(height / 2).min(width / 2);
        if reach < 2 * SHORTEST as usize {
            return None;
        }
        let [top, left] = [(rows - height) / 2, (columns - width) / 2];
        let part = image.slice_axis(Axis(0), (top..top + height).into());
        let part = part.slice_axis(Axis(1), (left..left + width).into());
        let mean = part.mean()?;
        let part = part.mapv(|x| x - mean);
        let all: f32 = part.iter().map(|x| x * x).sum::<f32>() / part.len() as f32;
        if !(all.is_finite() && all > 0.0) {
            return None;
        }
        let value = |down: usize, right: usize| {
            let right = right as isize - reach as isize;
            let (left, from) = ((-right).max(0) as usize, right.max(0) as usize);
            let count = width - right.unsigned_abs();
            let mut sum = 0.0;
            for v in 0..height - down {
                let (a, b) = (part.row(v), part.row(v + down));
                let (Some(a), Some(b)) = (a.as_slice(), b.as_slice()) else { continue };
                sum += product(&a[left..left + count], &b[from..from + count]);
            }
            sum / ((height - down) * count) as f32 / all
        };
        let across = 2 * reach + 1;
        let mut values = vec![0.0; (reach + 1) * across];
        values.par_chunks_mut(across).enumerate().for_each(|(down, row)| {
            row.iter_mut().enumerate().for_each(|(right, place)| *place = value(down, right));
        });
        let values = Array2::from_shape_vec((reach + 1, across), values).ok()?;
        Some(Self { values, reach: reach as isize })
    }

    /// The correlation at a displacement to the right and down; `None` beyond the reach.
    fn at(&self, x: isize, y: isize) -> Option<f32> {
        let (x, y) = if y < 0 { (-x, -y) } else { (x, y) };
        (x.abs() <= self.reach && y <= self.reach).then(|| self.values[[y as usize, (x + self.reach) as usize]])
    }

    /// The highest value around a displacement, between pixels, and the value.
    fn peak(&self, near: [f64; 2], within: isize) -> Option<([f64; 2], f32)> {
        let [x, y] = near.map(|a| a.round() as isize);
        let places = (-within..=within).flat_map(|v| (-within..=within).map(move |u| [x + u, y + v]));
        let valued = places.filter_map(|place| Some((place, self.at(place[0], place[1])?)));
        let ([x, y], value) = valued.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let [left, right, above, below] =
            [self.at(x - 1, y)?, self.at(x + 1, y)?, self.at(x, y - 1)?, self.at(x, y + 1)?];
        if [left, right, above, below].iter().any(|other| *other > value) {
            return None;
        }
        // The vertex of a parabola through three values.
        let vertex = |before: f32, after: f32| {
            let curve = 2.0 * value - before - after;
            if curve > 0.0 { f64::from((after - before) / (2.0 * curve)) } else { 0.0 }
        };
        Some(([x as f64 + vertex(left, right), y as f64 + vertex(above, below)], value))
    }

    /// All peaks but that of no displacement, one of every two that are opposite, with their heights.
    fn peaks(&self) -> Vec<([f64; 2], f32)> {
        let mut found = Vec::new();
        for y in 0..self.reach {
            for x in 1 - self.reach..self.reach {
                let is_other_half = y == 0 && x <= 0;
                let Some(value) = self.at(x, y).filter(|_| !is_other_half && x.abs().max(y) > 2) else { continue };
                let around = (-2..=2).flat_map(|v| (-2..=2).map(move |u| [x + u, y + v]));
                if around.filter_map(|[x, y]| self.at(x, y)).all(|other| other <= value)
                    && let Some(peak) = self.peak([x as f64, y as f64], 0)
                {
                    found.push(peak);
                }
            }
        }
        found
    }

    /// A step of the lattice, from all its multiples that are in reach.
    fn refined(&self, mut step: [f64; 2]) -> [f64; 2] {
        for count in 2..REACH as u32 {
            let next = step.map(|x| x * f64::from(count));
            let Some((found, _)) = self.peak(next, 1) else { break };
            step = found.map(|x| x / f64::from(count));
        }
        step
    }
}

/// The sum of the products, in lanes.
fn product(a: &[f32], b: &[f32]) -> f32 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<16>(), b.as_chunks::<16>());
    let mut sums = [0.0; 16];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..16 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f32>() + a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum::<f32>()
}

fn length(a: [f64; 2]) -> f64 {
    a[0].hypot(a[1])
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn at_one_size(image: ArrayView2<f32>) -> Option<Lattice> {
    let correlation = Correlation::new(image)?;
    let mut peaks = correlation.peaks();
    let highest = peaks.iter().map(|peak| peak.1).fold(0.0, f32::max);
    if highest < CORRELATION {
        return None;
    }
    peaks.retain(|peak| peak.1 >= HEIGHT * highest);
    peaks.sort_by(|a, b| length(a.0).total_cmp(&length(b.0)));
    let a = peaks.first()?.0;
    let is_another = |b: [f64; 2]| dot(a, b).abs() < 0.9 * length(a) * length(b);
    let b = peaks.iter().map(|peak| peak.0).find(|b| is_another(*b))?;
    let [a, b] = [a, b].map(|step| correlation.refined(step));
    classified(a, b).filter(|found| found.pitch_px >= SHORTEST)
}

/// The lattice of two of its shortest steps, to the right and down.
fn classified(a: [f64; 2], b: [f64; 2]) -> Option<Lattice> {
    let cosine = dot(a, b) / length(a) / length(b);
    if (length(a) / length(b) - 1.0).abs() > EQUAL {
        return None;
    }
    let folds = match cosine.abs() {
        near if near < COSINE => 4.0,
        near if (near - 0.5).abs() < COSINE => 6.0,
        _ => return None,
    };
    // All steps of a lattice have one direction, times the number of its folds.
    let turned = [a, b].map(|[x, y]| folds * (-y).atan2(x));
    let (sin, cos) = turned.iter().fold((0.0, 0.0), |sum, angle| (sum.0 + angle.sin(), sum.1 + angle.cos()));
    let angle = sin.atan2(cos) / folds;
    let pitch_px = (length(a) + length(b)) / 2.0;
    let quarter = std::f64::consts::FRAC_PI_6;
    let (grid, rotation_rad) = match folds {
        4.0 => (MicrolensGrid::Square, angle),
        // Of columns the directions are those of rows, turned by 30 degrees.
        _ if angle.abs() <= quarter / 2.0 => (MicrolensGrid::HexRows, angle),
        _ => (MicrolensGrid::HexColumns, angle - quarter * angle.signum()),
    };
    Some(Lattice { grid, pitch_px, rotation_rad })
}
