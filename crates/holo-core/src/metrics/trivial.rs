//! Trivial baselines for disparity estimates: a constant and a plane.

use ndarray::ArrayRef2;

use super::{PixelCounts, Region};
use crate::base::error::not_negative;
use crate::{Error, Real};

/// Pixels for the first evaluation of every candidate plane.
const FEW: usize = 2048;

/// Pixels for the improvement of the best candidates.
const MANY: usize = 8192;

/// Candidate planes through three pixels each.
const CANDIDATES: usize = 1024;

/// Candidates that are improved.
const FINALISTS: usize = 4;

/// The trivial baseline of a constant disparity; see [`trivial_constant`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrivialConstant {
    /// The disparity, in pixels between adjacent views.
    pub disparity_px: f64,
    /// BadPix of that constant as an estimate of the map, in percent.
    pub bad_pixels_percent: f64,
    /// The numbers of compared and of excluded pixels.
    pub counts: PixelCounts,
}

/// The trivial baseline of a plane of disparity; see [`trivial_plane`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrivialPlane {
    /// The disparity at row 0, column 0.
    pub offset_px: f64,
    /// The change from one row to the next.
    pub per_row_px: f64,
    /// The change from one column to the next.
    pub per_column_px: f64,
    /// BadPix of that plane as an estimate of the map, in percent.
    pub bad_pixels_percent: f64,
    /// The numbers of compared and of excluded pixels.
    pub counts: PixelCounts,
}

impl TrivialPlane {
    /// Returns the disparity of the plane at a pixel, in pixels between adjacent views.
    #[must_use]
    pub fn disparity_px(&self, row: usize, column: usize) -> f64 {
        self.at(row as f64, column as f64)
    }

    fn at(&self, row: f64, column: f64) -> f64 {
        self.offset_px + self.per_row_px * row + self.per_column_px * column
    }
}

/// Returns the constant with the lowest BadPix for a ground truth map: the score of an estimate with one parameter.
///
/// # Units
///
/// Map and threshold in pixels between adjacent views.
///
/// # Accuracy
///
/// Optimal up to the rounding of the comparison with the threshold. A window of twice the threshold slides over the
/// sorted disparities; the constant is the middle of the window with the most pixels.
///
/// # Errors
///
/// [`Error::Shape`] if the mask differs in shape; [`Error::NothingToMeasure`] if no pixel is finite;
/// [`Error::BadNumber`] if the threshold is negative, infinite or NaN.
///
/// # Examples
///
/// ```
/// use holo_core::metrics::{Region, trivial_constant};
/// use ndarray::array;
///
/// let map = array![[1.0_f32, 1.125, 5.0, 1.0625]];
/// let fit = trivial_constant(&map, 0.07, &Region::with_border(0))?;
/// assert_eq!((fit.disparity_px, fit.bad_pixels_percent), (1.0625, 25.0));
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn trivial_constant<T: Real>(
    truth: &ArrayRef2<T>,
    threshold_px: f64,
    region: &Region<'_>,
) -> Result<TrivialConstant, Error> {
    let threshold_px = not_negative("bad pixel threshold in pixels", threshold_px)?;
    let (points, counts) = points(truth, region)?;
    let mut values: Vec<f64> = points.iter().map(|point| point.disparity).collect();
    let (good, disparity_px) = fullest_window(&mut values, threshold_px);
    Ok(TrivialConstant { disparity_px, bad_pixels_percent: percent_bad(good, points.len()), counts })
}

/// Returns a plane with a low BadPix for a ground truth map: the score of an estimate with three parameters.
///
/// Its BadPix is at most that of [`trivial_constant`]. Equal maps give equal planes, bit by bit.
///
/// # Units
///
/// Map and threshold in pixels between adjacent views.
///
/// # Accuracy
///
/// A heuristic search, because BadPix has many local minima. 1,024 planes through three pixels each, half of them
/// neighbors, are evaluated on at most 2,048 pixels. The four best are improved on at most 8,192 pixels by steps along
/// both slopes, which are halved repeatedly. All of these and the constant are then evaluated on all pixels. For given
/// slopes the offset is optimal, as in [`trivial_constant`]. The far triples find a plane of a quarter of the pixels
/// almost surely and a plane of a tenth with a probability of two in five; the near triples find compact planes.
///
/// # Errors
///
/// As [`trivial_constant`].
pub fn trivial_plane<T: Real>(
    truth: &ArrayRef2<T>,
    threshold_px: f64,
    region: &Region<'_>,
) -> Result<TrivialPlane, Error> {
    let threshold_px = not_negative("bad pixel threshold in pixels", threshold_px)?;
    let (points, counts) = points(truth, region)?;
    let mut draw = Draw(0x5eed);
    let few = sample(&points, FEW, &mut draw);
    let many = sample(&points, MANY, &mut draw);

    let mut ranked: Vec<(usize, Slopes)> = Vec::with_capacity(CANDIDATES);
    let mut residuals = Vec::new();
    for candidate in 0..CANDIDATES {
        let three = if candidate % 2 == 0 { far_three(&few, &mut draw) } else { near_three(&few, &mut draw) };
        if let Some(slopes) = slopes_through(three) {
            ranked.push((offset_for(&few, slopes, threshold_px, &mut residuals).0, slopes));
        }
    }
    // The sort is stable: equal planes remain in the order of drawing.
    ranked.sort_by_key(|&(good, _)| std::cmp::Reverse(good));
    ranked.truncate(FINALISTS);

    let extent = points.iter().map(|point| point.row.max(point.column)).fold(1.0, f64::max);
    let mut slopes = vec![Slopes { per_row: 0.0, per_column: 0.0 }];
    for &(_, start) in &ranked {
        slopes.push(start);
        slopes.push(improved(&many, start, threshold_px, extent, &mut residuals));
    }
    let mut best: Option<TrivialPlane> = None;
    for slopes in slopes {
        let offset_px = offset_for(&points, slopes, threshold_px, &mut residuals).1;
        let (per_row_px, per_column_px) = (slopes.per_row, slopes.per_column);
        let mut fit = TrivialPlane { offset_px, per_row_px, per_column_px, bad_pixels_percent: 0.0, counts };
        // Counted again with the public sum, whose rounding differs from that of a residual.
        let off = |point: &Point| (fit.at(point.row, point.column) - point.disparity).abs();
        let good = points.iter().filter(|point| off(point) <= threshold_px).count();
        fit.bad_pixels_percent = percent_bad(good, points.len());
        if best.is_none_or(|best| fit.bad_pixels_percent < best.bad_pixels_percent) {
            best = Some(fit);
        }
    }
    Ok(best.expect("the constant is always among them"))
}

/// A pixel with a finite disparity.
#[derive(Debug, Clone, Copy)]
struct Point {
    row: f64,
    column: f64,
    disparity: f64,
}

/// The slopes of a plane per row and per column.
#[derive(Debug, Clone, Copy)]
struct Slopes {
    per_row: f64,
    per_column: f64,
}

fn points<T: Real>(truth: &ArrayRef2<T>, region: &Region<'_>) -> Result<(Vec<Point>, PixelCounts), Error> {
    let shape = truth.dim().into();
    let (mut points, mut counts) = (Vec::new(), PixelCounts::default());
    for [row, column] in region.pixels(shape)? {
        counts.region += 1;
        let disparity = truth[[row, column]].to_f64();
        if disparity.is_finite() {
            points.push(Point { row: row as f64, column: column as f64, disparity });
        } else {
            counts.truth_not_finite += 1;
        }
    }
    counts.compared = points.len();
    if points.is_empty() {
        let border_px = region.border_px;
        return Err(Error::NothingToMeasure { what: "trivial baseline", shape, border_px });
    }
    Ok((points, counts))
}

fn percent_bad(good: usize, count: usize) -> f64 {
    100.0 * (count - good) as f64 / count as f64
}

/// Sorts values and returns the largest number of them within `threshold` of a constant, and that constant.
fn fullest_window(values: &mut [f64], threshold: f64) -> (usize, f64) {
    values.sort_unstable_by(f64::total_cmp);
    let (mut best, mut constant, mut first) = (0, f64::NAN, 0);
    for last in 0..values.len() {
        // The comparison of BadPix, so that the count is exact.
        let middle = loop {
            let middle = f64::midpoint(values[first], values[last]);
            let within = (values[last] - middle).abs() <= threshold && (values[first] - middle).abs() <= threshold;
            // A window of one value always fits: its middle is that value.
            if within || first == last {
                break middle;
            }
            first += 1;
        };
        if last + 1 - first > best {
            (best, constant) = (last + 1 - first, middle);
        }
    }
    (best, constant)
}

/// The number of points within the threshold of the best plane with the given slopes, and the offset of that plane.
fn offset_for(points: &[Point], slopes: Slopes, threshold: f64, residuals: &mut Vec<f64>) -> (usize, f64) {
    residuals.clear();
    let plane = |point: &Point| slopes.per_row * point.row + slopes.per_column * point.column;
    residuals.extend(points.iter().map(|point| point.disparity - plane(point)));
    fullest_window(residuals, threshold)
}

/// Coordinate search: steps along both slopes while the count increases, then steps of half the length.
fn improved(points: &[Point], start: Slopes, threshold: f64, extent: f64, residuals: &mut Vec<f64>) -> Slopes {
    const STEPS: [(f64, f64); 8] =
        [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let (mut best, mut slopes) = (offset_for(points, start, threshold, residuals).0, start);
    // From eight thresholds over the whole map down to an eighth of a threshold.
    let mut step = 8.0 * threshold.max(1e-6) / extent;
    for _ in 0..7 {
        // At most sixteen iterations per step length.
        for _ in 0..16 {
            let before = best;
            for (down, along) in STEPS {
                let next =
                    Slopes { per_row: slopes.per_row + down * step, per_column: slopes.per_column + along * step };
                let good = offset_for(points, next, threshold, residuals).0;
                if good > best {
                    (best, slopes) = (good, next);
                }
            }
            if best == before {
                break;
            }
        }
        step /= 2.0;
    }
    slopes
}

/// The slopes of the plane through three points, or `None` if they are collinear.
fn slopes_through([a, b, c]: [Point; 3]) -> Option<Slopes> {
    let (row_1, column_1, rise_1) = (b.row - a.row, b.column - a.column, b.disparity - a.disparity);
    let (row_2, column_2, rise_2) = (c.row - a.row, c.column - a.column, c.disparity - a.disparity);
    let area = row_1 * column_2 - row_2 * column_1;
    // Pixel coordinates are whole numbers, so an area below 1 is 0.
    (area.abs() >= 1.0).then(|| Slopes {
        per_row: (rise_1 * column_2 - rise_2 * column_1) / area,
        per_column: (row_1 * rise_2 - row_2 * rise_1) / area,
    })
}

/// At most `count` of the points, one from each of `count` equal parts of the list.
fn sample(points: &[Point], count: usize, draw: &mut Draw) -> Vec<Point> {
    if points.len() <= count {
        return points.to_vec();
    }
    (0..count)
        .map(|piece| {
            let (first, end) = (piece * points.len() / count, (piece + 1) * points.len() / count);
            points[first + draw.below(end - first)]
        })
        .collect()
}

fn far_three(points: &[Point], draw: &mut Draw) -> [Point; 3] {
    std::array::from_fn(|_| points[draw.below(points.len())])
}

/// A random point and the two nearest of sixteen others, for small surfaces.
fn near_three(points: &[Point], draw: &mut Draw) -> [Point; 3] {
    let first = points[draw.below(points.len())];
    let distance = |point: &Point| (point.row - first.row).hypot(point.column - first.column);
    let mut others: [Point; 16] = std::array::from_fn(|_| points[draw.below(points.len())]);
    others.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    [first, others[0], others[1]]
}

/// A deterministic pseudo-random generator (SplitMix64).
struct Draw(u64);

impl Draw {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        // The bias for counts other than powers of two is at most 2^-40 here.
        ((bits ^ (bits >> 31)) % count as u64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::bad_pixels_percent;
    use ndarray::{Array2, array};

    const ALL: Region<'_> = Region::with_border(0);

    /// Pseudo-random values.
    fn noise(shape: (usize, usize), seed: u64) -> Array2<f64> {
        let mut draw = Draw(seed);
        Array2::from_shape_simple_fn(shape, || draw.below(1 << 20) as f64 / (1 << 18) as f64)
    }

    #[test]
    fn no_constant_is_better_than_the_trivial_baseline() {
        for seed in 0..20 {
            let map = noise((9, 11), seed);
            for threshold in [0.0, 0.01, 0.07, 0.5, 9.0] {
                let fit = trivial_constant(&map, threshold, &ALL).unwrap();
                let score =
                    |value: f64| bad_pixels_percent(&Array2::from_elem((9, 11), value), &map, threshold, &ALL).unwrap();
                // Its score is the returned one, and no window that starts or ends at a value is better.
                assert_eq!(score(fit.disparity_px), fit.bad_pixels_percent, "seed {seed}, threshold {threshold}");
                for &value in &map {
                    for constant in [value, value + threshold, value - threshold] {
                        assert!(score(constant) >= fit.bad_pixels_percent, "seed {seed}: {constant} is better");
                    }
                }
            }
        }
    }

    #[test]
    fn pixels_without_truth_are_excluded() {
        let map = array![[f32::NAN, 2.0, f32::INFINITY], [2.0, 2.0, 7.0]];
        let fit = trivial_constant(&map, 0.07, &ALL).unwrap();
        assert_eq!((fit.disparity_px, fit.bad_pixels_percent), (2.0, 25.0));
        assert_eq!(fit.counts, PixelCounts { region: 6, truth_not_finite: 2, estimate_not_finite: 0, compared: 4 });
        let nothing = Array2::from_elem((3, 3), f32::NAN);
        assert!(matches!(trivial_constant(&nothing, 0.07, &ALL), Err(Error::NothingToMeasure { .. })));
        assert!(matches!(trivial_plane(&nothing, 0.07, &ALL), Err(Error::NothingToMeasure { .. })));
        assert!(trivial_plane(&map, f64::NAN, &ALL).is_err());
    }

    #[test]
    fn a_plane_of_few_pixels_is_found() {
        // A third of the map is the plane, the rest noise over 4 px, of which a window of 0.14 px holds 3.5 % by
        // chance.
        let slope = |row: usize, column: usize| 1.0 + 0.01 * row as f64 - 0.02 * column as f64;
        let mut map = noise((60, 80), 3);
        for row in 0..60 {
            for column in 0..27 {
                map[[row, column]] = slope(row, column);
            }
        }
        let fit = trivial_plane(&map, 0.07, &ALL).unwrap();
        // At least 27 of 80 columns, and by chance 3.5 % of the others. A plane that misses a tenth of its own pixels
        // has more.
        assert!(fit.bad_pixels_percent <= 100.0 * 53.0 / 80.0, "{}", fit.bad_pixels_percent);
        // Every pixel of the plane is within the threshold, and so is the fit at the corners of that part.
        for (row, column) in [(0, 0), (59, 0), (0, 26), (59, 26)] {
            assert!((fit.disparity_px(row, column) - slope(row, column)).abs() <= 0.0701, "({row}, {column})");
        }
        let estimate = Array2::from_shape_fn((60, 80), |(row, column)| fit.disparity_px(row, column));
        assert_eq!(bad_pixels_percent(&estimate, &map, 0.07, &ALL), Ok(fit.bad_pixels_percent));
    }

    #[test]
    fn a_plane_is_never_worse_than_a_constant() {
        for seed in 0..5 {
            let map = noise((12, 12), seed).mapv(|value| value.min(1.0));
            let (plane, constant) =
                (trivial_plane(&map, 0.03, &ALL).unwrap(), trivial_constant(&map, 0.03, &ALL).unwrap());
            assert!(plane.bad_pixels_percent <= constant.bad_pixels_percent);
            assert_eq!(trivial_plane(&map, 0.03, &ALL), Ok(plane));
        }
        // Too few pixels for a plane: the constant.
        let fit = trivial_plane(&array![[4.0_f32, 4.5]], 0.25, &ALL).unwrap();
        assert_eq!((fit.offset_px, fit.per_row_px, fit.bad_pixels_percent), (4.25, 0.0, 0.0));
    }
}
