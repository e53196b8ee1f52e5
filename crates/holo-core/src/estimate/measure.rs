//! One Gauss-Newton step per pixel on the disparity, from the views in which the pixel is visible.

#[cfg(test)]
mod naive;

use crate::base::parallel::*;

use super::views::Views;
use crate::Error;
use crate::base::memory::filled;

/// The noise floor of color differences, for colors from 0 to 1.
const FLOOR: f32 = 0.002;
/// The largest number of views: those of a grid of 9 x 9.
const MOST_VIEWS: usize = 80;

/// The result of one step at every pixel.
pub(super) struct Measurements {
    /// The disparity after the step.
    pub(super) disparity_px: Vec<f32>,
    /// The inverse of its variance, in 1/px^2.
    pub(super) information: Vec<f32>,
    /// The weighted mean color over the views, channel by channel: the central view with less noise.
    pub(super) image: Vec<f32>,
}

/// Makes one step at every pixel from the disparities of a map.
///
/// The gradients are those of `image`; `step_px` is the longest step.
pub(super) fn measure(
    views: &Views,
    map: &[f32],
    image: &[f32],
    nearest_px: f32,
    step_px: f32,
) -> Result<Measurements, Error> {
    let (pixels, columns) = (views.pixels(), views.size.columns);
    let mut disparity_px = filled("a disparity map", pixels, 0.0)?;
    let mut information = filled("the information of a disparity map", pixels, 0.0)?;
    // Interleaved while it is written, so that every thread has its own part.
    let mut mixed = filled("an averaged view", pixels * views.channels, 0.0)?;
    disparity_px
        .par_iter_mut()
        .zip(information.par_iter_mut())
        .zip(mixed.par_chunks_exact_mut(views.channels))
        .with_min_len(columns)
        .enumerate()
        .for_each(|(pixel, ((disparity_px, information), mean))| {
            let (row, column) = (pixel / columns, pixel % columns);
            let limits = visible_steps(views, map, row, column, nearest_px);
            let (delta, found) = measure_pixel(views, map[pixel], image, row, column, &limits, mean);
            *disparity_px = map[pixel] + delta.clamp(-step_px, step_px);
            *information = found;
        });
    let mut image = filled("an averaged view", mixed.len(), 0.0)?;
    for channel in 0..views.channels {
        for (to, from) in image[channel * pixels..].iter_mut().zip(mixed.iter().skip(channel).step_by(views.channels)) {
            *to = *from;
        }
    }
    Ok(Measurements { disparity_px, information, image })
}

/// The reach along every arm up to which no nearer point occludes a pixel.
///
/// A point x pixels along the arm whose disparity is larger by e pixels occludes the pixel from the view on in which
/// points move by x/e pixels per pixel of disparity. Pixels are the nearest to the line of the arm.
fn visible_steps(views: &Views, map: &[f32], row: usize, column: usize, nearest_px: f32) -> [f32; 8] {
    let (rows, columns) = (views.size.rows, views.size.columns);
    let here = map[row * columns + column];
    let reach = views.reach();
    let far = ((nearest_px - here) * reach).ceil().max(0.0) as usize;
    views.directions.map(|(down, right)| {
        let mut limit = f32::INFINITY;
        if down == 0.0 && right == 0.0 {
            return limit;
        }
        for distance in 1..=far {
            let along = |part: f32| (part * distance as f32).round() as isize;
            let (Some(row), Some(column)) =
                (row.checked_add_signed(along(down)), column.checked_add_signed(along(right)))
            else {
                break;
            };
            if row >= rows || column >= columns {
                break;
            }
            let nearer = map[row * columns + column] - here;
            if nearer * reach > distance as f32 {
                limit = limit.min(distance as f32 / nearer);
            }
        }
        limit
    })
}

/// The step and its information. `mean` receives the mean color.
fn measure_pixel(
    views: &Views,
    disparity_px: f32,
    image: &[f32],
    row: usize,
    column: usize,
    limits: &[f32; 8],
    mean: &mut [f32],
) -> (f32, f32) {
    let (pixels, channels) = (views.pixels(), views.channels);
    let (rows, columns) = (views.size.rows, views.size.columns);
    let pixel = row * columns + column;
    let mut gradients = [(0.0, 0.0); 3];
    let mut center = [0.0; 3];
    for channel in 0..channels {
        gradients[channel] = gradient(&image[channel * pixels..(channel + 1) * pixels], rows, columns, row, column);
        center[channel] = views.center[channel * pixels + pixel];
    }

    let Seen { mut squares, views: seen, count } = compare(views, disparity_px, row, column, limits, &center);
    if count == 0 {
        mean.copy_from_slice(&center[..channels]);
        return (0.0, 0.0);
    }
    let mut sorted = squares;
    let median = *sorted[..count].select_nth_unstable_by(count / 2, f32::total_cmp).1;
    let scale = 3.0 * median + FLOOR * FLOOR;

    // A linear fit to (h, difference) with one slope for all channels. The constant of a channel is the noise of the
    // central view.
    let (mut hh, mut hr, mut rr, mut spread) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    let mut total = 1.0;
    for index in 0..count {
        let weight = 1.0 / (1.0 + squares[index] / scale);
        let (down, right, _) = seen[index];
        total += weight;
        spread += weight * (down * down + right * right);
        squares[index] = weight;
    }
    for channel in 0..channels {
        let (by_row, by_column) = gradients[channel];
        let (mut h_sum, mut r_sum, mut hh_sum, mut hr_sum, mut rr_sum) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for index in 0..count {
            let (down, right, difference) = seen[index];
            let (weight, r) = (squares[index], difference[channel]);
            let h = down * by_row + right * by_column;
            h_sum += weight * h;
            r_sum += weight * r;
            hh_sum += weight * h * h;
            hr_sum += weight * h * r;
            rr_sum += weight * r * r;
        }
        mean[channel] = center[channel] + r_sum / total;
        hh += hh_sum - h_sum * h_sum / total;
        hr += hr_sum - h_sum * r_sum / total;
        rr += rr_sum - r_sum * r_sum / total;
    }
    let delta = if hh > 1e-12 { hr / hh } else { 0.0 };
    let variance = ((rr - hr * delta) / (total * channels as f32)).max(0.0) + FLOOR * FLOOR;
    // The gradient of noise alone, which the mean over `total` views reduces.
    let of_noise = 0.5 * variance / total * spread * channels as f32 * 0.5;
    (delta, (hh - of_noise).max(0.0) / variance)
}

/// The views in which a pixel is visible.
struct Seen {
    /// Rows and columns from the central view, and the difference of the colors to it.
    views: [(f32, f32, [f32; 3]); MOST_VIEWS],
    /// The mean squares of the differences.
    squares: [f32; MOST_VIEWS],
    count: usize,
}

/// Compares a pixel with every view in which it is visible.
fn compare(views: &Views, disparity_px: f32, row: usize, column: usize, limits: &[f32; 8], center: &[f32; 3]) -> Seen {
    let (pixels, channels) = (views.pixels(), views.channels);
    let (rows, columns) = (views.size.rows, views.size.columns);
    let mut seen = [(0.0_f32, 0.0_f32, [0.0_f32; 3]); MOST_VIEWS];
    let mut squares = [0.0_f32; MOST_VIEWS];
    let mut count = 0;
    for view in &views.others {
        let y = row as f32 - disparity_px * view.down;
        let x = column as f32 - disparity_px * view.right;
        let is_inside = y >= 0.0 && x >= 0.0 && y <= (rows - 1) as f32 && x <= (columns - 1) as f32;
        if !is_inside || view.reach > limits[view.arm] {
            continue;
        }
        let cubic = Cubic::new(y, x, rows, columns);
        let mut difference = [0.0; 3];
        for channel in 0..channels {
            let plane = &view.samples[channel * pixels..(channel + 1) * pixels];
            difference[channel] = cubic.sample(plane, columns) - center[channel];
        }
        squares[count] = difference.iter().map(|d| d * d).sum::<f32>() / channels as f32;
        seen[count] = (view.down, view.right, difference);
        count += 1;
    }
    Seen { views: seen, squares, count }
}

/// Differences of neighbors, one-sided at the border.
fn gradient(plane: &[f32], rows: usize, columns: usize, row: usize, column: usize) -> (f32, f32) {
    let slope = |low: usize, high: usize, first: usize, second: usize| {
        if high > low { (plane[second] - plane[first]) / (high - low) as f32 } else { 0.0 }
    };
    let (above, below) = (row.saturating_sub(1), (row + 1).min(rows - 1));
    let (left, right) = (column.saturating_sub(1), (column + 1).min(columns - 1));
    (
        slope(above, below, above * columns + column, below * columns + column),
        slope(left, right, row * columns + left, row * columns + right),
    )
}

/// The 4 x 4 weights of an image position in Keys' cubic convolution.
struct Cubic {
    rows: [usize; 4],
    columns: [usize; 4],
    by_row: [f32; 4],
    by_column: [f32; 4],
    /// Whether the four columns are consecutive.
    is_inner: bool,
}

impl Cubic {
    fn new(y: f32, x: f32, rows: usize, columns: usize) -> Self {
        let (row, column) = (y.floor(), x.floor());
        let place = |first: f32, count: usize| {
            std::array::from_fn(|tap| (first as isize + tap as isize - 1).clamp(0, count as isize - 1) as usize)
        };
        let (rows, places) = (place(row, rows), place(column, columns));
        Self {
            rows,
            columns: places,
            by_row: keys(y - row),
            by_column: keys(x - column),
            is_inner: places[3] == places[0] + 3,
        }
    }

    fn sample(&self, plane: &[f32], width: usize) -> f32 {
        // Down the four columns at once, then across.
        let mut sums = [0.0_f32; 4];
        for (&row, &weight) in self.rows.iter().zip(&self.by_row) {
            let row = &plane[row * width..(row + 1) * width];
            let four: [f32; 4] = match row[self.columns[0]..].first_chunk() {
                Some(four) if self.is_inner => *four,
                _ => self.columns.map(|column| row[column]),
            };
            for (sum, value) in sums.iter_mut().zip(four) {
                *sum += weight * value;
            }
        }
        sums.iter().zip(&self.by_column).map(|(sum, weight)| sum * weight).sum()
    }
}

/// Keys' weights with a = -1/2, which reproduce parabolas.
fn keys(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3]
}

#[cfg(test)]
mod tests {
    use super::super::views::{directions, test_views, test_views_of};
    use super::*;
    use crate::BaselineRatio;

    #[test]
    fn cubic_convolution_reproduces_a_parabola_and_holds_at_the_border() {
        let plane: Vec<f32> = (0..80)
            .map(|pixel| {
                let (y, x) = ((pixel / 10) as f32, (pixel % 10) as f32);
                0.3 + 0.02 * y * y - 0.01 * x * x + 0.005 * x * y
            })
            .collect();
        for (y, x) in [(3.25_f32, 4.5_f32), (1.0, 1.0), (5.9, 7.1), (2.5, 6.75)] {
            let expected = 0.3 + 0.02 * y * y - 0.01 * x * x + 0.005 * x * y;
            let found = Cubic::new(y, x, 8, 10).sample(&plane, 10);
            // Sixteen products of numbers of about 1 in f32.
            assert!((found - expected).abs() < 2e-6, "({y}, {x}): {found}, {expected}");
        }
        for (row, column) in [(0, 0), (7, 9), (0, 9), (7, 0)] {
            let found = Cubic::new(row as f32, column as f32, 8, 10).sample(&plane, 10);
            assert_eq!(found, plane[row * 10 + column]);
        }
        assert_eq!(Cubic::new(0.0, 0.0, 1, 1).sample(&[0.5], 1), 0.5);
    }

    #[test]
    fn visibility_agrees_with_moving_every_pixel() {
        for ratio in [1.0, 0.5, 0.0] {
            visibility_agrees(BaselineRatio::vertical_over_horizontal(ratio).unwrap());
        }
        visibility_agrees(BaselineRatio::VERTICAL_ONLY);
    }

    fn visibility_agrees(ratio: BaselineRatio) {
        let views = test_views_of(24, 24, 1, ratio);
        // A tilted ground with two boxes on it.
        let map: Vec<f32> = (0..576)
            .map(|pixel| match (pixel / 24, pixel % 24) {
                (5..=9, 6..=12) => 1.6,
                (14..=20, 11..=13) => 0.9,
                (row, _) => 0.013 * row as f32,
            })
            .collect();
        for pixel in 0..576 {
            let (row, column) = (pixel / 24, pixel % 24);
            let limits = visible_steps(&views, &map, row, column, 1.6);
            for (arm, &(down, right)) in directions(ratio).iter().enumerate() {
                for reach in [1.0, 2.0, 3.0] {
                    // Occluded if, in the view, another pixel of the line has passed from one side of this pixel to the
                    // other.
                    let hidden = (1..24).any(|distance| {
                        let distance = distance as f32;
                        let r = (row as f32 + (down * distance).round()) as isize;
                        let c = (column as f32 + (right * distance).round()) as isize;
                        (0..24).contains(&r) && (0..24).contains(&c) && {
                            let nearer = map[(r * 24 + c) as usize] - map[pixel];
                            distance - nearer * reach < 0.0
                        }
                    });
                    assert_eq!(hidden, reach > limits[arm], "{ratio:?} ({row}, {column}) arm {arm}, reach {reach}");
                }
            }
        }
    }

    #[test]
    fn equal_samples_have_no_information() {
        let mut views = test_views(8, 8, 3);
        views.center.fill(0.5);
        views.others.iter_mut().for_each(|view| view.samples.fill(0.5));
        let map = vec![0.25; 64];
        let found = measure(&views, &map, &views.center, 1.0, 0.1).unwrap();
        assert_eq!(found.information, [0.0; 64]);
        assert_eq!(found.disparity_px, map);
    }
}
