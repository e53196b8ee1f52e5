//! Texture filtering: the mean of a texture over the footprint of a sample, from a mip pyramid.
//!
//! The footprint is a parallelogram: what a cell of the pixel sees of the plane of the surface. It is replaced by the
//! rectangle with the same covariance, and the mean over it by that of a few interpolated texels of a pyramid in
//! linear light, along the longer side (as in anisotropic filtering of GPUs). Texel size and distance of these taps
//! are such that the covariance of the filter around the center of a footprint is that of the footprint, so that an image
//! gets neither sharper nor blurred to second order. Around a hit anywhere in the footprint it is [`AROUND_HITS`] times
//! that: the places of hits alone have the covariance of the footprint, so the image is blurred, less with more samples.

use super::footprint::{TextureFootprint, TextureFootprints};
use super::{bilinear, neighbors, sample, taps_of_sixteen};
use crate::simd::LANES;
use holo_scene::{Texture, Wrap};

/// The maximum number of taps along a footprint. Longer ones, near a horizon, are averaged over wider texels, which
/// blurs them across.
const MAX_TAPS: f32 = 8.0;

/// The covariance of the filter around hits that lie anywhere in their footprint, relative to that of the footprint. White
/// noise of texels leaves as much noise as with 1 around the centers of footprints.
pub(crate) const AROUND_HITS: f32 = 1.8;

/// Successively halved images of a texture in linear light, from half its size to a single texel. Takes 1.3 times as much
/// memory as the texture.
pub(crate) struct Pyramid {
    /// The texture itself, whose texels are not here, and all levels down to a single texel.
    levels: Vec<Level>,
    /// The texels of the levels, one level after the other, row by row; the fourth value only aligns them.
    texels: Vec<[f32; 4]>,
}

/// A level of a pyramid.
#[derive(Clone, Copy)]
struct Level {
    /// The place of its first texel.
    first: usize,
    width: u32,
    height: u32,
}

/// The filter of a footprint.
#[derive(Clone, Copy)]
pub(crate) struct Filter {
    /// From one tap to the next, in texture coordinates.
    step: [f32; 2],
    /// The number of taps.
    taps: f32,
    /// The squared width of the texels to interpolate, in texels of the texture; at least 1.
    squared_width: f32,
}

/// The filters of sixteen footprints.
pub(crate) struct Filters {
    /// Whether textures are filtered there at all.
    pub is_wide: [bool; LANES],
    step: [[f32; LANES]; 2],
    taps: [f32; LANES],
    squared_width: [f32; LANES],
}

impl Filter {
    /// The filter of a footprint on a texture of `width` x `height` texels; `None` if the footprint is not wider than the interpolation of adjacent texels, or not finite.
    #[inline(always)]
    pub fn new(footprint: &TextureFootprint, [width, height]: [usize; 2]) -> Option<Self> {
        let (filter, is_wide) = Self::of(footprint, [width as f32, height as f32]);
        is_wide.then_some(filter)
    }

    /// The filter, and whether the footprint is wide enough and finite. Without branches.
    #[inline(always)]
    fn of(footprint: &TextureFootprint, [width, height]: [f32; 2]) -> (Self, bool) {
        let [a, b] = footprint.sides;
        // Twelve times the covariance, in texels: its eigenvalues are the squared sides of the rectangle.
        let (ax, ay, bx, by) = (a[0] * width, a[1] * height, b[0] * width, b[1] * height);
        let (xx, xy, yy) = (ax * ax + bx * bx, ax * ay + bx * by, ay * ay + by * by);
        let (mean, difference) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
        let root = (difference * difference + xy * xy).sqrt();
        // False also for NaN.
        let is_wide = (mean + root > BILINEAR) & (mean + root < f32::INFINITY);
        let spread = if footprint.is_centered { 1.0 } else { AROUND_HITS };
        let (mean, difference, xy, root) = (mean * spread, difference * spread, xy * spread, root * spread);
        let (long, short) = (mean + root, (mean - root).max(BILINEAR));
        let taps = ((long / short).sqrt() - 0.25).ceil().clamp(1.0, MAX_TAPS);
        let squared = if taps > 1.0 { short.max(long / (taps * taps)) } else { mean.max(BILINEAR) };
        let squared_width = squared / BILINEAR;
        let (x, y) = if difference > 0.0 { (root + difference, xy) } else { (xy, root - difference) };
        let length = (x * x + y * y).sqrt();
        let distance = ((long - squared).max(0.0) / (taps * taps - 1.0)).sqrt() / length;
        let is_long = (taps > 1.0) & (length > 0.0);
        let step = [x * distance / width, y * distance / height];
        let step = if is_long { step } else { [0.0; 2] };
        (Self { step, taps, squared_width }, is_wide)
    }
}

impl Filters {
    /// The filters of sixteen footprints on a texture of `width` x `height` texels.
    #[inline(always)]
    pub fn new(footprints: &TextureFootprints, [width, height]: [usize; 2]) -> Self {
        let mut out =
            Self { is_wide: [false; LANES], step: [[0.0; LANES]; 2], taps: [1.0; LANES], squared_width: [1.0; LANES] };
        let size = [width as f32, height as f32];
        for lane in 0..LANES {
            let (filter, is_wide) = Filter::of(&footprints.of(lane), size);
            let is_wide = is_wide & footprints.is_inside[lane];
            out.is_wide[lane] = is_wide;
            out.step[0][lane] = filter.step[0];
            out.step[1][lane] = filter.step[1];
            out.taps[lane] = if is_wide { filter.taps } else { 0.0 };
            out.squared_width[lane] = if is_wide { filter.squared_width } else { 1.0 };
        }
        out
    }
}

/// The squared width of the box with the variance of bilinear interpolation between texels of width 1: a box and a
/// tent, 1/12 + 1/6 = 3/12.
const BILINEAR: f32 = 3.0;

impl Pyramid {
    pub fn new(texture: &Texture, table: &[f32; 256]) -> Self {
        let mut level = Level { first: 0, width: texture.width as u32, height: texture.height as u32 };
        let (mut levels, mut texels) = (vec![level], Vec::new());
        while level.width > 1 || level.height > 1 {
            let first = texels.len();
            let [width, height] = if levels.len() == 1 {
                append_halved(level, &mut texels, |_, k| {
                    let [r, g, b, _] = texture.texels[k];
                    [table[r as usize], table[g as usize], table[b as usize], 0.0]
                })
            } else {
                append_halved(level, &mut texels, |all, k| all[k])
            };
            level = Level { first, width, height };
            levels.push(level);
        }
        Self { levels, texels }
    }

    /// The mean of `texture`, whose pyramid this is, over a footprint around `center`, linear RGB.
    #[inline(always)]
    pub fn sample(&self, texture: &Texture, table: &[f32; 256], center: [f32; 2], filter: &Filter) -> [f32; 3] {
        let (finer, fraction) = self.levels_of(filter.squared_width);
        let mut sum = [0.0; 3];
        for tap in 0..filter.taps as u32 {
            let along = tap as f32 - 0.5 * (filter.taps - 1.0);
            let place = [center[0] + filter.step[0] * along, center[1] + filter.step[1] * along];
            let mut value = self.level(finer, texture, table, place);
            if fraction > 0.0 {
                let coarser = self.level(finer + 1, texture, table, place);
                for c in 0..3 {
                    value[c] += (coarser[c] - value[c]) * fraction;
                }
            }
            for c in 0..3 {
                sum[c] += value[c];
            }
        }
        for value in &mut sum {
            *value /= filter.taps;
        }
        sum
    }

    /// [`Self::sample`] at sixteen places, with bitwise identical results; lanes that are not wide stay.
    #[inline(always)]
    pub fn sample_sixteen(
        &self,
        texture: &Texture,
        table: &[f32; 256],
        center: &[[f32; LANES]; 2],
        filters: &Filters,
        out: &mut [[f32; LANES]; 3],
    ) {
        let last = self.levels.len() as u32 - 1;
        let (mut finer, mut coarser, mut fraction) = ([0; LANES], [0; LANES], [0.0; LANES]);
        let (mut most, mut mixed) = (0.0f32, false);
        for lane in 0..LANES {
            (finer[lane], fraction[lane]) = self.levels_of(filters.squared_width[lane]);
            coarser[lane] = (finer[lane] + 1).min(last);
            most = most.max(filters.taps[lane]);
            mixed |= fraction[lane] > 0.0;
        }
        let mut sums = [[0.0; LANES]; 3];
        for tap in 0..most as u32 {
            let mut place = [[0.0; LANES]; 2];
            let mut takes = [false; LANES];
            for lane in 0..LANES {
                let along = tap as f32 - 0.5 * (filters.taps[lane] - 1.0);
                takes[lane] = (tap as f32) < filters.taps[lane];
                for axis in 0..2 {
                    place[axis][lane] = center[axis][lane] + filters.step[axis][lane] * along;
                }
            }
            let mut value = self.level_of_sixteen(&finer, texture, table, &place, &takes);
            if mixed {
                let other = self.level_of_sixteen(&coarser, texture, table, &place, &takes);
                for c in 0..3 {
                    for lane in 0..LANES {
                        let both = value[c][lane] + (other[c][lane] - value[c][lane]) * fraction[lane];
                        value[c][lane] = if fraction[lane] > 0.0 { both } else { value[c][lane] };
                    }
                }
            }
            for c in 0..3 {
                for lane in 0..LANES {
                    sums[c][lane] += if takes[lane] { value[c][lane] } else { 0.0 };
                }
            }
        }
        for c in 0..3 {
            for lane in 0..LANES {
                let mean = sums[c][lane] / filters.taps[lane];
                out[c][lane] = if filters.is_wide[lane] { mean } else { out[c][lane] };
            }
        }
    }

    /// The finer of two levels, mixed such that the squared widths of their texels have the mean `squared_width`, and the
    /// part of the coarser one.
    #[inline(always)]
    fn levels_of(&self, squared_width: f32) -> (u32, f32) {
        let last = self.levels.len() as u32 - 1;
        let finer = half_log2(squared_width).min(last);
        let squared = f32::from_bits((127 + 2 * finer) << 23);
        let fraction = (squared_width / squared - 1.0) / 3.0;
        (finer, if finer == last { 0.0 } else { fraction.clamp(0.0, 1.0) })
    }

    /// A level at texture coordinates; 0 is the texture itself.
    #[inline(always)]
    fn level(&self, level: u32, texture: &Texture, table: &[f32; 256], place: [f32; 2]) -> [f32; 3] {
        if level == 0 {
            return sample(texture, table, place, holo_scene::Filter::Linear);
        }
        let Level { first, width, height } = self.levels[level as usize];
        let size = [width as usize, height as usize];
        let wrap: [Wrap; 2] = [texture.wrap_u, texture.wrap_v];
        let (corners, fraction) = neighbors(&self.texels[first..], size, wrap, holo_scene::Filter::Linear, place);
        let [r, g, b, _] = bilinear(&corners, fraction);
        [r, g, b]
    }

    /// [`Self::level`] at sixteen places on their levels, in the lanes that take part.
    #[inline(always)]
    fn level_of_sixteen(
        &self,
        levels: &[u32; LANES],
        texture: &Texture,
        table: &[f32; 256],
        place: &[[f32; LANES]; 2],
        takes: &[bool; LANES],
    ) -> [[f32; LANES]; 3] {
        let (mut first, mut width, mut height) = ([0; LANES], [0; LANES], [0; LANES]);
        for lane in 0..LANES {
            let level = &self.levels[levels[lane] as usize];
            (first[lane], width[lane], height[lane]) = (level.first, level.width, level.height);
        }
        let columns = taps_of_sixteen(&place[0], &width, texture.wrap_u, holo_scene::Filter::Linear);
        let rows = taps_of_sixteen(&place[1], &height, texture.wrap_v, holo_scene::Filter::Linear);
        let mut out = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            if !takes[lane] {
                continue;
            }
            let (upper, lower) =
                (rows.first[lane] as usize * width[lane] as usize, rows.second[lane] as usize * width[lane] as usize);
            let (left, right) =
                (first[lane] + columns.first[lane] as usize, first[lane] + columns.second[lane] as usize);
            let places = [upper + left, upper + right, lower + left, lower + right];
            let mut corners = [[0.0; 4]; 4];
            for corner in 0..4 {
                corners[corner] = if levels[lane] == 0 {
                    let [r, g, b, _] = texture.texels[places[corner]];
                    [table[r as usize], table[g as usize], table[b as usize], 0.0]
                } else {
                    self.texels[places[corner]]
                };
            }
            let value = bilinear(&corners, [columns.fraction[lane], rows.fraction[lane]]);
            for k in 0..3 {
                out[k][lane] = value[k];
            }
        }
        out
    }
}

/// Half the binary logarithm of a number of at least 1, rounded down: from the bits of its exponent.
#[inline(always)]
fn half_log2(x: f32) -> u32 {
    ((x.to_bits() >> 23) - 127) / 2
}

/// Appends an image of half the size of `level`, rounded down, with the same mean. Returns its width and height.
fn append_halved(level: Level, texels: &mut Vec<[f32; 4]>, texel: impl Fn(&[[f32; 4]], usize) -> [f32; 4]) -> [u32; 2] {
    let Level { first, width, height } = level;
    let (columns, rows) = (halves(width as usize), halves(height as usize));
    texels.reserve(columns.len() * rows.len());
    for (top, row_weights) in &rows {
        for (left, column_weights) in &columns {
            let mut sum = [0.0; 4];
            for (row, row_weight) in row_weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
                for (column, weight) in column_weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
                    let texel = texel(texels, first + (top + row) * width as usize + left + column);
                    for c in 0..4 {
                        sum[c] += row_weight * weight * texel[c];
                    }
                }
            }
            texels.push(sum);
        }
    }
    [columns.len() as u32, rows.len() as u32]
}

/// The weights with which the texels along an axis contribute to those of half the number: for each the first texel,
/// and the weights of this and the next two. If the number is odd, a texel covers two and a fraction.
fn halves(size: usize) -> Vec<(usize, [f32; 3])> {
    let half = size / 2;
    if half == 0 {
        return vec![(0, [1.0, 0.0, 0.0])];
    }
    let weights = |k: usize| {
        let parts = if size.is_multiple_of(2) { [half, half, 0] } else { [half - k, half, k + 1] };
        (2 * k, parts.map(|part| part as f32 / size as f32))
    };
    (0..half).map(weights).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::at;

    fn texture(width: usize, height: usize, texel: impl Fn(usize, usize) -> u8) -> Texture {
        let texels = (0..width * height).map(|k| [texel(k % width, k / width), 0, 255, 255]).collect();
        let (wrap_u, wrap_v, filter) = (Wrap::Repeat, Wrap::Repeat, holo_scene::Filter::Linear);
        Texture { name: String::new(), width, height, texels, wrap_u, wrap_v, filter }
    }

    /// A footprint with these sides in texels of a texture of `size` x `size`.
    fn footprint(sides: [[f32; 2]; 2], size: usize, is_centered: bool) -> TextureFootprint {
        TextureFootprint { sides: sides.map(|side| side.map(|x| x / size as f32)), is_centered }
    }

    fn linear() -> [f32; 256] {
        std::array::from_fn(|code| code as f32 / 255.0)
    }

    /// Every level has the mean of the texture, for even, odd and narrow sizes, down to a single texel.
    #[test]
    fn every_level_has_the_mean_of_the_texture() {
        for [width, height] in [[8, 8], [7, 5], [1, 9], [640, 1], [33, 2], [3, 3], [1, 1]] {
            let texture = texture(width, height, |x, y| (x * 37 + y * 101 + x * y * 13) as u8);
            let sum: f64 = texture.texels.iter().map(|texel| f64::from(texel[0]) / 255.0).sum();
            let mean = sum / (width * height) as f64;
            let pyramid = Pyramid::new(&texture, &linear());
            let mut end = 0;
            for level in &pyramid.levels[1..] {
                assert_eq!(level.first, end, "one after the other");
                end += (level.width * level.height) as usize;
                let texels = &pyramid.texels[level.first..end];
                let sum: f64 = texels.iter().map(|texel| f64::from(texel[0])).sum();
                let of_level = sum / texels.len() as f64;
                assert!((of_level - mean).abs() < 1e-6, "{width} x {height}: {of_level} instead of {mean}");
                assert!(texels.iter().all(|texel| (texel[2] - 1.0).abs() < 1e-6));
            }
            assert_eq!(end, pyramid.texels.len());
            assert_eq!(pyramid.levels.last().map(|level| [level.width, level.height]), Some([1, 1]));
        }
    }

    /// The filter as a distribution of weights over the texels has the sum 1, the center and the covariance of the
    /// footprint, on average over its position in the grid.
    #[test]
    fn the_filter_has_the_moments_of_the_footprint() {
        const SIZE: usize = 32;
        let table = linear();
        let impulses: Vec<(Texture, Pyramid)> = (0..SIZE * SIZE)
            .map(|k| {
                let texture = texture(SIZE, SIZE, |x, y| if y * SIZE + x == k { 255 } else { 0 });
                let pyramid = Pyramid::new(&texture, &table);
                (texture, pyramid)
            })
            .collect();
        // Sides in texels.
        for (sides, is_centered) in [
            ([[3.0, 0.0], [0.0, 3.0]], true),
            ([[2.0, 1.0], [-1.0, 2.0]], true),
            ([[5.0, 0.0], [0.0, 2.0]], true),
            ([[9.0, 3.0], [0.0, 1.0]], true),
            ([[4.0, 4.0], [4.5, 4.0]], true),
            ([[0.1, 0.0], [0.0, 12.0]], true),
            ([[3.0, 0.0], [0.0, 3.0]], false),
            ([[5.0, 0.0], [0.0, 2.0]], false),
        ] {
            let sides: [[f32; 2]; 2] = sides;
            let filter = Filter::new(&footprint(sides, SIZE, is_centered), [SIZE; 2]).expect("a wide one");
            let sides = sides.map(|side| side.map(|x| if is_centered { x } else { x * AROUND_HITS.sqrt() }));
            let mut moments = [[0.0f64; 3]; 2];
            let mut sum = 0.0;
            const PLACES: usize = 16;
            for place in 0..PLACES {
                let center = [13.0 + (place % 4) as f32 * 0.77, 14.0 + (place / 4) as f32 * 0.91];
                for (k, (texture, pyramid)) in impulses.iter().enumerate() {
                    let weight = pyramid.sample(texture, &table, center.map(|x| x / SIZE as f32), &filter)[0];
                    let weight = f64::from(weight) / PLACES as f64;
                    let x = f64::from((k % SIZE) as f32 + 0.5 - center[0]);
                    let y = f64::from((k / SIZE) as f32 + 0.5 - center[1]);
                    sum += weight;
                    for (moments, value) in moments.iter_mut().zip([[x, y, 0.0], [x * x, x * y, y * y]]) {
                        (0..3).for_each(|c| moments[c] += value[c] * weight);
                    }
                }
            }
            assert!((sum - 1.0).abs() < 1e-5, "{sides:?}: {sum}");
            // The texels of a level lie on a fixed grid of the texture, so at one place the filter is off its center by up to
            // half a texel of the level (here up to 4 texels wide), and wider or narrower; sixteen places do not average
            // all of that away.
            assert!(moments[0].iter().all(|offset| offset.abs() < 0.3), "{sides:?}: off by {:?}", moments[0]);
            let [a, b] = sides.map(|side| side.map(f64::from));
            // Interpolation reaches at least over one texel.
            let trace = ((a[0] * a[0] + a[1] * a[1] + b[0] * b[0] + b[1] * b[1]) / 12.0).max(0.5);
            let expected = [a[0] * a[0] + b[0] * b[0], a[0] * a[1] + b[0] * b[1], a[1] * a[1] + b[1] * b[1]];
            for (value, expected) in moments[1].iter().zip(expected) {
                let off = (value - expected / 12.0).abs();
                assert!(off < 0.12 * trace + 0.25, "{sides:?}: {:?} instead of {expected:?} / 12", moments[1]);
            }
        }
    }

    #[test]
    fn narrow_and_impossible_footprints_are_not_filtered() {
        let filter = |sides| Filter::new(&footprint(sides, 64, false), [64, 64]);
        assert!(filter([[0.5, 0.0], [0.0, 1.0]]).is_none());
        assert!(filter([[0.0; 2]; 2]).is_none());
        for bad in [f32::NAN, f32::INFINITY, 1e30] {
            assert!(filter([[bad, 0.0], [0.0, 0.1]]).is_none(), "{bad}");
        }
    }

    /// Sixteen filtered samples together have the values of each alone: taps on all levels, beyond the edges, and lanes that
    /// are not filtered.
    #[test]
    fn sixteen_filtered_samples_equal_single_ones() {
        let table = linear();
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        for [width, height] in [[37, 20], [64, 64], [1, 9], [1, 1]] {
            let mut texture = texture(width, height, |x, y| (x * 37 + y * 101 + x * y * 13) as u8);
            let pyramid = Pyramid::new(&texture, &table);
            for round in 0..200 {
                (texture.wrap_u, texture.wrap_v) =
                    [(Wrap::Repeat, Wrap::Mirror), (Wrap::Mirror, Wrap::Clamp), (Wrap::Clamp, Wrap::Repeat)][round % 3];
                let mut footprints = TextureFootprints::NONE;
                // Every third time so near that all lie in one cell of most levels.
                let (middle, apart) = ([random(), random()], if round % 3 == 0 { 1e-3 } else { 3.0 });
                let center: [[f32; LANES]; 2] =
                    std::array::from_fn(|axis| std::array::from_fn(|_| middle[axis] + apart * (random() - 0.5)));
                for lane in 0..LANES {
                    // From narrow to wider than the texture.
                    let scale = 0.01 * 3.0f32.powf(5.0 * random());
                    for side in 0..2 {
                        for axis in 0..2 {
                            footprints.sides[side][axis][lane] = scale * (random() - 0.5);
                        }
                    }
                    footprints.is_centered[lane] = round % 2 == 0;
                    footprints.is_inside[lane] = lane != 3;
                }
                let filters = Filters::new(&footprints, [width, height]);
                let mut together = [[-1.0; LANES]; 3];
                pyramid.sample_sixteen(&texture, &table, &center, &filters, &mut together);
                for lane in 0..LANES {
                    let filter = Filter::new(&footprints.of(lane), [width, height]);
                    let filter = filter.filter(|_| footprints.is_inside[lane]);
                    assert_eq!(filter.is_some(), filters.is_wide[lane]);
                    let alone = match filter {
                        Some(filter) => pyramid.sample(&texture, &table, at(&center, lane), &filter),
                        None => [-1.0; 3],
                    };
                    assert_eq!(at(&together, lane).map(f32::to_bits), alone.map(f32::to_bits), "{width} {lane}");
                }
            }
        }
    }

    /// Footprints wider than the texture give its mean; taps that lie far outside are finite.
    #[test]
    fn a_footprint_as_wide_as_the_texture_gives_its_mean() {
        let texture = texture(16, 16, |x, y| ((x ^ y) * 16) as u8);
        let pyramid = Pyramid::new(&texture, &linear());
        let mean = texture.texels.iter().map(|texel| f32::from(texel[0]) / 255.0).sum::<f32>() / 256.0;
        for sides in [[[3.0, 0.0], [0.0, 3.0]], [[1e6, 0.0], [0.0, 1e6]], [[1e8, 3.0], [2.0, 1e3]]] {
            let filter = Filter::new(&footprint(sides, 1, true), [16, 16]).expect("a wide one");
            let value = pyramid.sample(&texture, &linear(), [0.3, 0.9], &filter);
            // Exact for the single texel of the last level; the third footprint is cut into eight taps of the first levels,
            // a sample of the texture.
            assert!((value[0] - mean).abs() < 0.05, "{sides:?}: {} instead of {mean}", value[0]);
            assert!(value.iter().all(|x| x.is_finite()));
        }
    }
}
