use super::*;
use crate::sampling::{self, Purpose};
use crate::simd::LANES;

/// A synthetic light field.
struct Synthetic {
    shape: [usize; 4],
    color: Vec<f32>,
    guides: Vec<f32>,
}

impl Synthetic {
    /// `value` gives the radiance of a pixel, `noise` the standard deviation of the mean of its samples, relative to it.
    fn new(shape: [usize; 4], disparity: f32, noise: f32, seed: u64, value: impl Fn([usize; 4]) -> f32) -> Self {
        let [lens_rows, lens_columns, view_rows, view_columns] = shape;
        let (mut color, mut guides) = (Vec::new(), Vec::new());
        for v in 0..lens_rows {
            for t in 0..view_rows {
                for u in 0..lens_columns {
                    for s in 0..view_columns {
                        let number = (((v * lens_columns + u) * view_rows + t) * view_columns + s) as u32;
                        let [a, b] = uniform_pair(seed, number);
                        let expected = value([v, u, t, s]);
                        // Uniform numbers of this width have variance 1; mean and half difference of two halves.
                        let half = |x: f32| (x - 0.5) * 12.0f32.sqrt() * noise * 2.0f32.sqrt() * expected;
                        let radiance = expected + (half(a) + half(b)) / 2.0;
                        color.extend([radiance, 0.5 * radiance, 2.0 * radiance]);
                        guides.extend([luminance([1.0, 0.5, 2.0]) * (half(a) - half(b)) / 2.0, disparity]);
                    }
                }
            }
        }
        Self { shape, color, guides }
    }

    /// The first channel and the error of every pixel after the reconstruction of some lens rows.
    fn reconstructed(&self, samples: u32, rows: Range<usize>) -> (Vec<f32>, Vec<f32>) {
        let (mut color, mut guides) = (self.color.clone(), self.guides.clone());
        let mut error = vec![0.0; color.len() / 3];
        Reconstruction {
            shape: self.shape,
            color: &mut color,
            guides: &mut guides,
            movement: [1.0; 2],
            samples,
            filters: true,
            replaces: true,
            rows,
            error: Some(&mut error),
        }
        .run(|| true);
        (color.into_iter().step_by(3).collect(), error)
    }

    fn whole(&self, samples: u32) -> (Vec<f32>, Vec<f32>) {
        self.reconstructed(samples, 0..self.shape[0])
    }
}

fn uniform_pair(seed: u64, number: u32) -> [f32; 2] {
    let sequences = sampling::sequences(seed, &[number; LANES], &[7; LANES]);
    let [a, b] = sampling::points(&sequences, 0, Purpose::PIXEL);
    [a[0], b[0]]
}

/// The mean relative squared error against what `value` says.
fn squared_error(shape: [usize; 4], values: &[f32], value: impl Fn([usize; 4]) -> f32) -> f64 {
    let [lens_rows, lens_columns, view_rows, view_columns] = shape;
    let mut values = values.iter();
    let mut sum = 0.0;
    for v in 0..lens_rows {
        for t in 0..view_rows {
            for u in 0..lens_columns {
                for s in 0..view_columns {
                    let (found, expected) = (values.next().expect("a value"), value([v, u, t, s]));
                    sum += f64::from(found / expected - 1.0).powi(2);
                }
            }
        }
    }
    sum / shape.iter().product::<usize>() as f64
}

fn median_square(error: &[f32]) -> f64 {
    let mut sorted = error.to_vec();
    sorted.sort_by(f32::total_cmp);
    f64::from(sorted[sorted.len() / 2]).powi(2)
}

/// The sums along both axes are those of loops in f64, for windows inside the views, at their border, and larger than the
/// views.
#[test]
fn box_means_are_the_means_over_windows() {
    for [rows, columns] in [[30, 25], [21, 21], [9, 40], [4, 3], [1, 7], [1, 1]] {
        let source: Planes =
            std::array::from_fn(|k| (0..rows * columns).map(|i| uniform_pair(k as u64, i as u32)[0]).collect());
        let radii = Radii::up_to(10);
        for level in 0..LEVELS {
            let (mut sums, mut out) = (Sums::default(), Planes::default());
            let (views, radii) = ([rows, columns], &radii);
            let ended = if radii.is_moved(level) { level - 1 } else { level };
            simd::run(BoxMean { source: &source, views, radii, level: ended, scratch: &mut sums, out: &mut out });
            if radii.is_moved(level) {
                let ended = std::mem::take(&mut out);
                move_windows(&ended, views, radii, level, &mut out);
            }
            for (plane, out) in source.iter().zip(&out) {
                for t in 0..rows {
                    for s in 0..columns {
                        let (down, across) = (radii.window(level, t, rows), radii.window(level, s, columns));
                        let count = down.len() * across.len();
                        let cells = down.flat_map(|t| across.clone().map(move |s| t * columns + s));
                        let mean = cells.map(|k| f64::from(plane[k])).sum::<f64>() / count as f64;
                        // Two sums of at most 21 terms, and a product: 44 roundings of 2^-24.
                        let found = f64::from(out[t * columns + s]);
                        assert!((found - mean).abs() <= 44.0 * mean * 2f64.powi(-24), "{found} {mean}");
                    }
                }
            }
        }
    }
}

/// A window along the disparity by its definition: every view is examined, and the sums are f64.
fn gathered(field: &Field, [v, u, t, s]: [usize; 4], (views, beside_px): (usize, f32)) -> [[f64; 2]; VALUES] {
    let [_, disparity] = field.guides(v, u, t, s);
    // The microlens along one axis, if the view belongs to the window.
    let along = |axis: usize, lens: usize, view: usize, other: usize| {
        let count = field.shape[axis + 2];
        let first = view.saturating_sub(10).min(count - count.min(21));
        let shift = field.movement[axis] * disparity * (other as f32 - view as f32);
        let (nearest, place) = (shift.round_ties_even(), lens as f32 - shift.round_ties_even());
        let is_candidate = (first..first + 21).contains(&other) && other.abs_diff(view) <= views;
        let is_close = (shift - nearest).abs() <= beside_px && nearest.abs() <= REACH as f32;
        (is_candidate && is_close && (0.0..field.shape[axis] as f32).contains(&place)).then_some(place as usize)
    };
    let (mut sums, mut count) = ([[0.0; 2]; VALUES], 0.0);
    for row in 0..field.shape[2] {
        for column in 0..field.shape[3] {
            let (Some(lens_row), Some(lens_column)) = (along(0, v, t, row), along(1, u, s, column)) else { continue };
            let [difference, found] = field.guides(lens_row, lens_column, row, column);
            let distance = |axis: usize, apart: usize| field.movement[axis] * apart as f32;
            let farthest = distance(0, row.abs_diff(t)).max(distance(1, column.abs_diff(s)));
            if (found - disparity).abs() * farthest <= gather::MAX_PARTING_PX {
                let [r, g, b] = field.color(lens_row, lens_column, row, column);
                for (sum, value) in sums.iter_mut().zip([r, g, b, difference]) {
                    *sum = [sum[0] + f64::from(value), sum[1] + f64::from(value.abs())];
                }
                count += 1.0;
            }
        }
    }
    sums.map(|sum| sum.map(|sum| sum / count))
}

/// Gathering is that definition, for points that move by any speed, with neighbors at other depths, in every window.
#[test]
fn gathering_is_its_definition() {
    let shape = [7, 9, 14, 23];
    let mut taken = 0;
    for (seed, speed) in [(1, 0.05f32), (2, 0.17), (3, -0.6), (4, 2.3)] {
        let mut synthetic = Synthetic::new(shape, 0.0, 0.5, seed, |_| 1.0);
        for (number, guides) in synthetic.guides.chunks_exact_mut(CHANNELS).enumerate() {
            let [jump, jitter] = uniform_pair(seed, number as u32);
            guides[1] = speed * (1.0 + 0.02 * jitter) + if jump > 0.8 { 0.4 } else { 0.0 };
        }
        let length = shape[1] * shape[2] * shape[3] * 3;
        let rows = synthetic.color.chunks_exact(length).collect();
        let field = Field { shape, movement: [0.5, 1.0], rows, guides: &synthetic.guides };
        for pixel in [[0, 0, 0, 0], [3, 4, 7, 11], [6, 8, 13, 22], [2, 7, 1, 20], [5, 1, 12, 3]] {
            let means = gather::gather(&field, pixel, GATHER_LEVELS - 1);
            for (level, window) in gather::WINDOWS.into_iter().enumerate() {
                for (found, [mean, size]) in means[level].into_iter().zip(gathered(&field, pixel, window)) {
                    // At most 441 additions in f32 and a division.
                    let bound = 442.0 * size * 2f64.powi(-24);
                    assert!((f64::from(found) - mean).abs() <= bound, "{speed} {pixel:?} {level}: {found} {mean}");
                    taken += usize::from(mean != f64::from(means[0][0]));
                }
            }
        }
    }
    assert!(taken > 200, "windows of more than one view: {taken}");
}

/// Where all views see the same, the noise falls with the number of views of the largest window, at the border as in the
/// middle, and the estimated error says so.
#[test]
fn noise_falls_with_the_number_of_views() {
    let shape = [4, 5, 64, 64];
    // The same from microlens to microlens to 1 %.
    let value = |[v, u, ..]: [usize; 4]| 1.0 + 0.01 * ((v * 3 + u * 7) % 5) as f32;
    for (disparity, radius) in [(0.006, 20), (0.0, 20), (0.02, 7)] {
        let radii = Radii::up_to(radius);
        let views = (radii.window(radii.count() - 1, 0, 64).len() as f64).powi(2);
        let (mut found, mut estimated) = (0.0, 0.0);
        for seed in 1..5 {
            let (values, error) = Synthetic::new(shape, disparity, 0.3, seed, value).whole(4);
            found += squared_error(shape, &values, value) / 4.0;
            estimated += median_square(&error) / 4.0;
        }
        let gain = 0.09 / found;
        // Some 240 windows and more are independent: the mean of their squares is within a third of its expectation. The
        // window of the smallest estimate is taken, so that noise of the estimates costs up to a third of the gain.
        assert!(gain > 0.6 * views && gain < 1.3 * views, "{disparity}: {gain}");
        let ratio = estimated / found;
        assert!((0.7..1.4).contains(&ratio), "{disparity}: the estimate is {ratio} of the error");
    }
}

/// The points of a pattern that moves with its disparity are found in the other views.
#[test]
fn windows_follow_the_disparity() {
    let shape = [9, 30, 9, 9];
    for disparity in [0.5f32, -0.25, 1.0] {
        // Steps of 1/2 and 1/4 px an adjacent view show the same whole microlens in every second or fourth view.
        let value = move |[_, u, _, s]: [usize; 4]| {
            let place = u as f32 + disparity * (s as f32 - 4.0);
            2.0 + (0.9 * place).sin()
        };
        let field = Synthetic::new(shape, disparity, 0.2, 2, value);
        let (values, _) = field.whole(4);
        let before = squared_error(shape, &field.color.iter().copied().step_by(3).collect::<Vec<_>>(), value);
        let gain = before / squared_error(shape, &values, value);
        assert!(gain > 3.0, "{disparity}: {gain}");
    }
}

/// What the guides do not know of - a reflection that moves faster than the surface - is kept: the error is never above
/// that of the samples, and with less noise smaller windows are taken.
#[test]
fn what_moves_otherwise_is_kept() {
    let shape = [7, 12, 24, 24];
    let value = |[_, u, _, s]: [usize; 4]| 2.0 + (1.3 * (u as f32 + 0.3 * s as f32)).sin();
    let mut errors = Vec::new();
    for noise in [0.3f32, 0.1, 0.03, 0.003] {
        let field = Synthetic::new(shape, 0.001, noise, 3, value);
        let (values, estimated) = field.whole(4);
        let after = squared_error(shape, &values, value);
        let before = f64::from(noise * noise);
        assert!(after < 1.1 * before, "noise {noise}: {after} instead of {before}");
        let estimated = median_square(&estimated);
        assert!((0.4..2.5).contains(&(estimated / after)), "noise {noise}: estimated {estimated}, is {after}");
        errors.push(after);
    }
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
}

/// Parts with their margin have the bytes of the whole, and the number of threads changes nothing.
#[test]
fn parts_and_threads_give_the_same_bytes() {
    let shape = [24, 6, 10, 10];
    let value = |[v, u, t, s]: [usize; 4]| 1.0 + 0.5 * ((v * 5 + u * 3) as f32 + 0.2 * (t + s) as f32).sin();
    for disparity in [0.01, 0.3, -2.0] {
        let field = Synthetic::new(shape, disparity, 0.1, 4, value);
        let (whole, error) = field.whole(4);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        assert_eq!(pool.install(|| field.whole(4)), (whole.clone(), error.clone()));
        let length = shape[1] * shape[2] * shape[3];
        for rows in [0..5usize, 5..13, 13..24] {
            let cut = rows.start.saturating_sub(HALO)..(rows.end + HALO).min(shape[0]);
            let part = Synthetic {
                shape: [cut.len(), shape[1], shape[2], shape[3]],
                color: field.color[cut.start * length * 3..cut.end * length * 3].to_vec(),
                guides: field.guides[cut.start * length * CHANNELS..cut.end * length * CHANNELS].to_vec(),
            };
            let (values, errors) = part.reconstructed(4, rows.start - cut.start..rows.end - cut.start);
            let inner = (rows.start - cut.start) * length..(rows.end - cut.start) * length;
            let same = rows.start * length..rows.end * length;
            assert!(
                values[inner.clone()] == whole[same.clone()] && errors[inner] == error[same],
                "{disparity} {rows:?}"
            );
        }
    }
}

/// With one sample per pixel neighboring views take the place of halves: the same gain, and an estimate that is right for
/// noise.
#[test]
fn one_sample_per_pixel_is_enough() {
    let shape = [4, 5, 30, 30];
    let value = |_: [usize; 4]| 1.0;
    let mut field = Synthetic::new(shape, 0.006, 0.3, 5, value);
    field.guides.iter_mut().step_by(CHANNELS).for_each(|difference| *difference = f32::NAN);
    let (values, error) = field.whole(1);
    let after = squared_error(shape, &values, value);
    assert!(0.09 / after > 180.0, "{}", 0.09 / after);
    let estimated = median_square(&error);
    assert!((0.5..2.0).contains(&(estimated / after)), "estimated {estimated}, is {after}");
}

/// Pixels without light, and one view, are no division by zero; the largest radiance does not overflow.
#[test]
fn black_bright_and_single_views_stay_finite() {
    for shape in [[3, 3, 6, 6], [2, 2, 1, 1], [1, 1, 9, 1]] {
        for disparity in [0.0, f32::NEG_INFINITY] {
            // Black, and the largest radiance.
            let field = Synthetic::new(shape, disparity, 0.1, 6, |[v, ..]| [0.0, 1.0, 1e30][v]);
            let (values, error) = field.whole(4);
            assert!(values.iter().chain(&error).all(|x| x.is_finite()), "{shape:?} {disparity}");
            if shape[2] * shape[3] == 1 {
                assert!(values.iter().eq(field.color.iter().step_by(3)));
            }
        }
    }
}
