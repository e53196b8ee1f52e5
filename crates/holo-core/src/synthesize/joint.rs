//! The views around a viewpoint as samples of one image: how much each of their pixels says about a pixel between them.
//!
//! Where they show one surface, their pixels lie at different places on it. Together they sample it more densely than each of them,
//! so that what is lost between the pixels of one is found in another. The weights are those of ordinary kriging (Matheron 1963),
//! an axis at a time: the least expected square of the error of an image whose variance between two points grows with their
//! distance, as that of natural images does, and whose pixels are means over their areas.

use std::array::from_fn;

use ndarray::ArrayView3;

use crate::Sample;
use crate::base::parallel::*;
use crate::refocus::add_pixels;

/// Views show one surface if their disparities of a point differ by no more than this, px.
pub(super) const SAME_PX: f64 = 0.05;

/// Disparities are rounded to one part of this many of a pixel.
const PARTS: f64 = 1024.0;

/// Weights of disparities up to this, px, are computed once; others for each pixel.
const TABLE_PX: f64 = 32.0;

/// The variance of a pixel about the surface (noise, and what changes with direction) of a view half-way, where the variance between
/// points of the image far apart grows by 1 for each pixel. 0.01 is best for images without noise, by 0.2 dB and less; with 16 samples
/// a pixel it loses up to 0.8 dB, and 0.1 loses anywhere.
const OWN: f64 = 3e-2;

/// More than the variogram of any two of the pixels: covariances are this minus the variogram.
const SILL: f64 = 16.0;

/// The pixels of a view along an axis.
const TAPS: usize = 4;

/// The pixels along an axis of up to two views: of each the first one, counted from the pixel of the new view, and the weights.
type Axis = [(isize, [f32; TAPS]); 2];

/// The views of the cell around a viewpoint.
pub(super) struct Joint {
    /// By how many pixels a point moves for each pixel of disparity, for each view along rows and along columns.
    steps: [Vec<f64>; 2],
    /// How near they are: 1 at the viewpoint, 0 a view away.
    shares: [Vec<f64>; 2],
    /// The disparity of the first weights of the table, in parts of a pixel.
    first: i64,
    table: Vec<[Axis; 2]>,
}

impl Joint {
    /// The views around a viewpoint, by its row and column in views; `None` if it is a view.
    pub fn new(at: [f64; 2], per_view: [f64; 2], range_px: [f64; 2]) -> Option<Self> {
        if at.iter().all(|at| at.fract() == 0.0) {
            return None;
        }
        let away = at.map(|at| if at.fract() == 0.0 { vec![0.0] } else { vec![-at.fract(), 1.0 - at.fract()] });
        let [low, high] = range_px.map(|x| (x.clamp(-TABLE_PX, TABLE_PX) * PARTS).round() as i64);
        let mut joint = Self {
            steps: from_fn(|axis| away[axis].iter().map(|views| -views * per_view[axis]).collect()),
            shares: from_fn(|axis| away[axis].iter().map(|views| 1.0 - views.abs()).collect()),
            first: low,
            table: Vec::new(),
        };
        joint.table = (low..=high).into_par_iter().map(|parts| joint.weights(parts)).collect();
        Some(joint)
    }

    /// The pixel of a point from all the views, row by row, at its disparity.
    pub fn add<'a, T: Sample>(
        &self,
        images: impl Iterator<Item = ArrayView3<'a, T>>,
        [row, column]: [usize; 2],
        disparity_px: f64,
        sample: &mut [f32],
    ) {
        let parts = (disparity_px * PARTS).round() as i64;
        let known = usize::try_from(parts - self.first).ok().and_then(|k| self.table.get(k));
        let [down, along] = known.copied().unwrap_or_else(|| self.weights(parts));
        for (k, image) in images.enumerate() {
            let ((first_row, down), (first_column, along)) =
                (down[k / self.steps[1].len()], along[k % self.steps[1].len()]);
            add_pixels(image, [row as isize + first_row, column as isize + first_column], [down, along], sample);
        }
    }

    fn weights(&self, parts: i64) -> [Axis; 2] {
        from_fn(|axis| {
            let steps: Vec<f64> = self.steps[axis].iter().map(|step| step * parts as f64 / PARTS).collect();
            kriging(&steps, &self.shares[axis])
        })
    }
}

/// The weights of the pixels of one or two views, whose pixel 0 lies at -`shifts` from the point.
fn kriging(shifts: &[f64], shares: &[f64]) -> Axis {
    let mut axis: Axis = [(0, [0.0; TAPS]); 2];
    let firsts: Vec<isize> = shifts.iter().map(|shift| shift.floor() as isize - 1).collect();
    let place = |k: usize| (firsts[k / TAPS] + (k % TAPS) as isize) as f64 - shifts[k / TAPS];
    let count = TAPS * shifts.len();
    let mut covariance = [[0.0; 2 * TAPS]; 2 * TAPS];
    let mut sides = [[1.0; 2 * TAPS]; 2];
    for i in 0..count {
        for (j, value) in covariance[i][..count].iter_mut().enumerate() {
            *value = SILL - variogram(place(i) - place(j));
        }
        covariance[i][i] += OWN * (1.0 / shares[i / TAPS] - 1.0);
        sides[0][i] = SILL - variogram(place(i));
    }
    solve(&mut covariance, &mut sides, count);
    let [of_point, of_ones] = sides.map(|side| side[..count].iter().sum::<f64>());
    let constant = (1.0 - of_point) / of_ones;
    for k in 0..count {
        axis[k / TAPS].0 = firsts[k / TAPS];
        axis[k / TAPS].1[k % TAPS] = (sides[0][k] + constant * sides[1][k]) as f32;
    }
    axis
}

/// Half the expected square of the difference between two pixels, by their distance in px: of an image whose half square of differences
/// between points is half their distance, averaged over the areas of the pixels along the axis.
fn variogram(distance_px: f64) -> f64 {
    let h = distance_px.abs();
    if h < 1.0 { h * h * (0.5 - h / 6.0) } else { h / 2.0 - 1.0 / 6.0 }
}

/// Solves the first `count` equations of a symmetric, positive definite matrix for two right sides, by the decomposition of Cholesky.
fn solve(matrix: &mut [[f64; 2 * TAPS]; 2 * TAPS], sides: &mut [[f64; 2 * TAPS]; 2], count: usize) {
    for i in 0..count {
        for j in 0..=i {
            let sum = matrix[i][j] - (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum::<f64>();
            matrix[i][j] = if i == j { sum.sqrt() } else { sum / matrix[j][j] };
        }
    }
    for side in sides {
        for i in 0..count {
            side[i] = (side[i] - (0..i).map(|k| matrix[i][k] * side[k]).sum::<f64>()) / matrix[i][i];
        }
        for i in (0..count).rev() {
            side[i] = (side[i] - (i + 1..count).map(|k| matrix[k][i] * side[k]).sum::<f64>()) / matrix[i][i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The weights of all pixels and their places.
    fn spread(shifts: &[f64], shares: &[f64]) -> Vec<(f64, f64)> {
        let axis = kriging(shifts, shares);
        let taps = |k: usize| (0..TAPS).map(move |tap| (axis[k].0 + tap as isize, axis[k].1[tap]));
        (0..shifts.len())
            .flat_map(|k| taps(k).map(move |(at, weight)| (at as f64 - shifts[k], f64::from(weight))))
            .collect()
    }

    /// The expected square of the error of weights: what kriging makes least.
    fn expected_error(pixels: &[(f64, f64)], shares: &[f64]) -> f64 {
        let between: f64 =
            pixels.iter().map(|(x, w)| pixels.iter().map(|(y, v)| w * v * variogram(x - y)).sum::<f64>()).sum();
        let to_point: f64 = pixels.iter().map(|(x, w)| w * variogram(*x)).sum();
        let own: f64 = pixels.iter().enumerate().map(|(k, (_, w))| w * w * OWN * (1.0 / shares[k / TAPS] - 1.0)).sum();
        2.0 * to_point - between + own
    }

    /// Weights add up to 1, and no others with that sum expect a smaller error: neither changed ones nor those of a view alone.
    #[test]
    fn no_other_weights_expect_a_smaller_error() {
        for (shifts, shares) in [([0.5, -0.5], [0.5, 0.5]), ([0.31, -1.7], [0.75, 0.25]), ([4.0, -4.0], [0.5, 0.5])] {
            let best = spread(&shifts, &shares);
            assert!((best.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-6);
            let least = expected_error(&best, &shares);
            assert!(least >= 0.0);
            for k in 1..best.len() {
                for step in [-0.01, 0.01] {
                    let mut other = best.clone();
                    (other[0].1, other[k].1) = (other[0].1 + step, other[k].1 - step);
                    assert!(expected_error(&other, &shares) > least, "{shifts:?} {k} {step}");
                }
            }
            let cubic = crate::refocus::Kernel::CatmullRom.weights(shifts[0] - shifts[0].floor());
            let alone: Vec<_> =
                best.iter().enumerate().map(|(k, (x, _))| (*x, *cubic.get(k).unwrap_or(&0.0))).collect();
            assert!(expected_error(&alone, &shares) > least);
        }
    }

    /// Beside a view the new view is that view; one view alone shows its pixel.
    #[test]
    fn weights_go_over_into_those_of_a_view() {
        for (shifts, shares) in [(vec![0.0, 0.6], vec![1.0 - 1e-9, 1e-9]), (vec![0.0], vec![1.0])] {
            for (place, weight) in spread(&shifts, &shares) {
                let expected = if place == 0.0 { 1.0 } else { 0.0 };
                assert!((weight - expected).abs() < 1e-6, "{shifts:?} {place} {weight}");
            }
        }
    }

    /// Views half a pixel apart sample an image twice as densely: a wave of 3 px errs by half of what it does by cubic
    /// interpolation.
    #[test]
    fn two_views_show_what_is_lost_in_one() {
        let wave = |x: f64, phase: f64| (std::f64::consts::TAU / 3.0 * x + phase).sin();
        let (mut joint, mut alone) = (0.0f64, 0.0f64);
        for step in 0..16 {
            let phase = f64::from(step) * 0.4;
            let pixels = spread(&[0.25, -0.25], &[0.5, 0.5]);
            joint = joint.max((pixels.iter().map(|(x, w)| w * wave(*x, phase)).sum::<f64>() - wave(0.0, phase)).abs());
            let cubic = |shift: f64| -> f64 {
                let weights = crate::refocus::Kernel::CatmullRom.weights(shift - shift.floor());
                weights.iter().enumerate().map(|(k, w)| w * wave(shift.floor() - 1.0 + k as f64 - shift, phase)).sum()
            };
            alone = alone.max(((cubic(0.25) + cubic(-0.25)) / 2.0 - wave(0.0, phase)).abs());
        }
        println!("{joint} {alone}");
        assert!(joint * 1.8 < alone, "{joint} {alone}");
    }
}
