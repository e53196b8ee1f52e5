use super::cells::{Cells, MAX_PARTING_PX};
use super::nodes::{WINDOW_COUNT, gather, window};
use super::rows::Rows;
use super::*;
use crate::film::guides::{SAMPLES, TINT, luminance};
use crate::film::tint;
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
                        let difference = luminance([1.0, 0.5, 2.0]) * (half(a) - half(b)) / 2.0;
                        guides.extend([difference, disparity, 4.0, tint::pack([0.5; 3])]);
                    }
                }
            }
        }
        Self { shape, color, guides }
    }

    /// The first channel and the error of every pixel after the reconstruction of some lens rows.
    fn reconstructed(&self, rows: Range<usize>) -> (Vec<f32>, Vec<f32>) {
        let mut color = self.color.clone();
        let mut error = vec![0.0; color.len() / 3];
        Reconstruction {
            shape: self.shape,
            color: &mut color,
            guides: &self.guides,
            movement: [1.0; 2],
            filters: true,
            replaces: true,
            rows,
            error: Some(&mut error),
        }
        .run(|| true);
        (color.into_iter().step_by(3).collect(), error)
    }

    fn whole(&self) -> (Vec<f32>, Vec<f32>) {
        self.reconstructed(0..self.shape[0])
    }

    /// Leaves a single sample, which has no half difference, to one of so many packets of 4 x 4 views, and none to others.
    fn thinned(mut self, packets: u32) -> Self {
        let [_, lens_columns, view_rows, view_columns] = self.shape;
        let pixels = self.color.chunks_exact_mut(3).zip(self.guides.chunks_exact_mut(CHANNELS));
        for (number, (color, guides)) in pixels.enumerate() {
            let (s, u) = (number % view_columns, number / view_columns % lens_columns);
            let (t, v) =
                (number / view_columns / lens_columns % view_rows, number / view_columns / lens_columns / view_rows);
            let lens = (v * lens_columns + u) as u32;
            let is_traced = sampling::rank(3, lens, [t as u32 / 4, s as u32 / 4]) < sampling::RANKS / packets;
            (guides[0], guides[2]) = (f32::NAN, f32::from(u8::from(is_traced)));
            if !is_traced {
                color.fill(f32::NAN);
            }
        }
        self
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

/// A window by its definition: every pixel is examined, and the sums are f64. The mean of a value of a cell's pixels has the
/// place of the cell's middle.
fn gathered(
    field: &Field,
    cells: &Rows<Cells>,
    pixel: [usize; 4],
    disparity: f32,
    k: usize,
    count: usize,
) -> Option<[f64; 5]> {
    let [v, u, t, s] = pixel;
    let [lens_rows, lens_columns, view_rows, view_columns] = field.grid.shape;
    let (distance, beside) = window(k, count);
    let (mut sums, mut weights) = ([0.0f64; 5], 0.0);
    for row in v.saturating_sub(REACH)..(v + REACH + 1).min(lens_rows) {
        for column in u.saturating_sub(REACH)..(u + REACH + 1).min(lens_columns) {
            let own = &cells.row(row)[column];
            for (t2, s2) in (0..view_rows).flat_map(|t2| (0..view_columns).map(move |s2| (t2, s2))) {
                let cell = [t2 / own.size, s2 / own.size];
                let away = [own.middle(0, cell[0]) - t as f32, own.middle(1, cell[1]) - s as f32];
                let apart = [row as f32 - v as f32, column as f32 - u as f32];
                let place = [0, 1].map(|axis| apart[axis] + field.grid.movement[axis] * disparity * away[axis]);
                let found = own.disparities[cell[0] * own.counts[1] + cell[1]];
                let farthest = (away[0] * field.grid.movement[0]).abs().max((away[1] * field.grid.movement[1]).abs());
                let is_inside =
                    away.iter().all(|away| away.abs() <= distance) && place.iter().all(|place| place.abs() <= beside);
                if !is_inside || (found - disparity).abs() * farthest > MAX_PARTING_PX {
                    continue;
                }
                let (colors, guides) = field.line(row, t2);
                let at = column * view_columns + s2;
                let weight = f64::from(guides[at][2]);
                let [r, g, b] = colors[at].map(f64::from);
                for (sum, value) in sums.iter_mut().zip([r, g, b, f64::from(place[0]), f64::from(place[1])]) {
                    *sum += if weight > 0.0 { weight * value } else { 0.0 };
                }
                weights += weight;
            }
        }
    }
    (weights > 0.0).then(|| sums.map(|sum| sum / weights))
}

/// Gathering is that definition, for points that move by any speed, with neighbors at other depths, in every window, whether
/// all pixels have samples or few.
#[test]
fn gathering_is_its_definition() {
    let shape = [7, 9, 14, 23];
    let mut taken = 0;
    for (seed, speed, packets) in
        [(1, 0.004f32, 1), (2, 0.05, 1), (3, 0.17, 1), (4, -0.61, 1), (5, 2.31, 1), (6, 0.03, 4), (7, 0.004, 16)]
    {
        let mut synthetic = Synthetic::new(shape, 0.0, 0.5, seed, |_| 1.0).thinned(packets);
        for (number, guides) in synthetic.guides.chunks_exact_mut(CHANNELS).enumerate() {
            let [jump, jitter] = uniform_pair(seed, number as u32);
            guides[1] = speed * (1.0 + 0.02 * jitter) + if jump > 0.8 && seed % 2 == 1 { 0.4 } else { 0.0 };
        }
        let grid = Grid { shape, movement: [0.5, 1.0] };
        let field = Field { grid, color: &synthetic.color, guides: &synthetic.guides };
        let mut cells = Rows::starting_at(0);
        cells.extend_to(shape[0], |v, row| {
            row.resize(shape[1], Cells::default());
            row.iter_mut().enumerate().for_each(|(u, cells)| cells.find(&field, v, u));
        });
        let count = nodes::window_count([14, 23]);
        for pixel in [[0, 0, 0, 0], [3, 4, 7, 11], [6, 8, 13, 22], [2, 7, 1, 20], [5, 1, 12, 3]] {
            let windows = gather(&grid, &cells, pixel, speed, count, 0..count);
            for (k, found) in windows.iter().enumerate().take(count) {
                let Some([r, g, b, y, x]) = gathered(&field, &cells, pixel, speed, k, count) else {
                    assert_eq!(found.weight, 0.0, "{speed} {pixel:?} {k}");
                    continue;
                };
                // Differences of sums of up to 322 pixels, and up to 81 of them; the values are at most 4, the places 1.
                let bound = 1e-4;
                for (found, expected) in found.values[..3].iter().chain(&found.offset).zip([r, g, b, y, x]) {
                    assert!((f64::from(*found) - expected).abs() < bound, "{speed} {pixel:?} {k}: {found} {expected}");
                }
                taken += 1;
            }
        }
    }
    assert!(taken > 60, "windows with samples: {taken}");
    assert_eq!(WINDOW_COUNT, 5);
}

/// Where all views see the same, the noise falls with the number of views and more with that of microlenses, at the border
/// as in the middle, and the estimated error says so.
#[test]
fn noise_falls_with_the_number_of_samples() {
    let shape = [11, 12, 32, 32];
    let value = |_: [usize; 4]| 1.0;
    for disparity in [0.006, 0.0, 0.05] {
        let (mut found, mut estimated) = (0.0, 0.0);
        for seed in 1..5 {
            let (values, error) = Synthetic::new(shape, disparity, 0.3, seed, value).whole();
            found += squared_error(shape, &values, value) / 4.0;
            estimated += median_square(&error) / 4.0;
        }
        // A fit takes all views of up to 9 x 9 microlenses; at the border of the image it has about half of them.
        let gain = 0.09 / found;
        assert!(gain > 1024.0 * 4.0, "{disparity}: {gain}");
        let ratio = estimated / found;
        assert!((0.4..2.5).contains(&ratio), "{disparity}: the estimate is {ratio} of the error");
    }
}

/// Where light differs from microlens to microlens, the views of each are taken alone.
#[test]
fn patterns_of_microlenses_are_kept() {
    let shape = [11, 12, 32, 32];
    let value = |[v, u, ..]: [usize; 4]| 1.0 + 0.5 * ((v * 3 + u * 7) % 5) as f32;
    let (values, _) = Synthetic::new(shape, 0.0, 0.3, 1, value).whole();
    let gain = 0.09 / squared_error(shape, &values, value);
    assert!(gain > 300.0 && gain < 1500.0, "{gain}");
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
        let (values, _) = field.whole();
        let before = squared_error(shape, &field.color.iter().copied().step_by(3).collect::<Vec<_>>(), value);
        let gain = before / squared_error(shape, &values, value);
        assert!(gain > 3.0, "{disparity}: {gain}");
    }
}

/// What the guides do not know of - a reflection that moves faster than the surface - is kept: the error is never far above
/// that of the samples, and with less noise smaller windows are taken.
#[test]
fn what_moves_otherwise_is_kept() {
    let shape = [7, 12, 24, 24];
    let value = |[_, u, _, s]: [usize; 4]| 2.0 + (1.3 * (u as f32 + 0.3 * s as f32)).sin();
    let mut errors = Vec::new();
    for noise in [0.3f32, 0.1, 0.03, 0.003] {
        let field = Synthetic::new(shape, 0.001, noise, 3, value);
        let (values, estimated) = field.whole();
        let after = squared_error(shape, &values, value);
        let before = f64::from(noise * noise);
        assert!(after < 1.6 * before, "noise {noise}: {after} instead of {before}");
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
        let (whole, error) = field.whole();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        assert_eq!(pool.install(|| field.whole()), (whole.clone(), error.clone()));
        let length = shape[1] * shape[2] * shape[3];
        for rows in [0..5usize, 5..13, 13..24] {
            let cut = rows.start.saturating_sub(HALO)..(rows.end + HALO).min(shape[0]);
            let part = Synthetic {
                shape: [cut.len(), shape[1], shape[2], shape[3]],
                color: field.color[cut.start * length * 3..cut.end * length * 3].to_vec(),
                guides: field.guides[cut.start * length * CHANNELS..cut.end * length * CHANNELS].to_vec(),
            };
            let (values, errors) = part.reconstructed(rows.start - cut.start..rows.end - cut.start);
            let inner = (rows.start - cut.start) * length..(rows.end - cut.start) * length;
            let same = rows.start * length..rows.end * length;
            assert!(
                values[inner.clone()] == whole[same.clone()] && errors[inner] == error[same],
                "{disparity} {rows:?}"
            );
        }
    }
}

/// With one sample in one or many pixels neighbors take the place of halves: the noise falls with the number of samples, and
/// the estimate is right for noise.
#[test]
fn few_samples_are_enough() {
    let shape = [12, 12, 32, 32];
    let value = |[v, u, ..]: [usize; 4]| 1.0 + 0.5 * ((v * 3 + u * 7) % 5) as f32;
    for (packets, samples) in [(1, 1024.0), (4, 256.0), (16, 64.0)] {
        let (values, error) = Synthetic::new(shape, 0.004, 0.3, 5, value).thinned(packets).whole();
        let after = squared_error(shape, &values, value);
        let gain = 0.09 / after / samples;
        assert!((0.3..1.5).contains(&gain), "1/{packets}: {gain}");
        let estimated = median_square(&error);
        assert!((0.4..2.5).contains(&(estimated / after)), "1/{packets}: estimated {estimated}, is {after}");
    }
}

/// A microlens without any sample shows what its neighbors do, though its own light and tint are unknown.
#[test]
fn light_of_neighbors_fills_what_has_no_samples() {
    let shape = [9, 9, 32, 32];
    let value = |[v, u, ..]: [usize; 4]| 1.0 + 0.05 * v as f32 - 0.02 * u as f32;
    let mut field = Synthetic::new(shape, 0.004, 0.3, 8, value).thinned(4);
    let pixels = 32 * 32;
    let is_empty = |number: usize| number / 32 % 9 == 4 && number / (32 * 9 * 32) == 4;
    for number in (0..81 * pixels).filter(|&number| is_empty(number)) {
        field.color[3 * number..][..3].fill(0.0);
        (field.guides[number * CHANNELS + SAMPLES], field.guides[number * CHANNELS + TINT]) = (0.0, 0.0);
    }
    let (values, _) = field.whole();
    let expected = value([4, 4, 0, 0]);
    let empty: Vec<f32> = (0..values.len()).filter(|&number| is_empty(number)).map(|number| values[number]).collect();
    assert_eq!(empty.len(), pixels);
    // Eight neighbors with 256 samples of 30 % each have a noise of 0.7 %.
    assert!(empty.iter().all(|x| (x / expected - 1.0).abs() < 0.03), "{:?} instead of {expected}", &empty[..4]);
}

/// Pixels without light, and one view, are no division by zero; the largest radiance does not overflow.
#[test]
fn black_bright_and_single_views_stay_finite() {
    for shape in [[3, 3, 6, 6], [2, 2, 1, 1], [1, 1, 9, 1]] {
        for disparity in [0.0, f32::NEG_INFINITY] {
            // Black, and the largest radiance.
            let field = Synthetic::new(shape, disparity, 0.1, 6, |[v, ..]| [0.0, 1.0, 1e30][v]);
            let (values, error) = field.whole();
            assert!(values.iter().chain(&error).all(|x| x.is_finite()), "{shape:?} {disparity}");
            if shape[2] * shape[3] == 1 {
                assert!(values.iter().eq(field.color.iter().step_by(3)));
            }
        }
    }
}
