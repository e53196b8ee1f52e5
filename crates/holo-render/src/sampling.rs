//! Random numbers: Owen-scrambled Sobol points, one sequence per microlens.
//!
//! The numbers are a function of (seed, microlens, view, sample, dimension) and of nothing else, so an image does not
//! depend on the number of threads, the size of tiles or the part of it that is rendered.
//!
//! The views behind a microlens see the same spots of the scene from slightly different directions. They take
//! successive points of its sequence: the views along a Morton curve, and along it the samples of a view. So the samples
//! of one view, of 2 x 2 views, of 4 x 4 views, ... are each as evenly distributed as the length of their run allows, and
//! the error of a mean over neighboring views (refocusing, reconstruction) decreases faster than that of independent
//! views.
//!
//! A sample has pairs of numbers (the position in the pixel, a scattered direction, ...). Each pair is a point of the
//! two-dimensional Sobol sequence, which is a (0, 2)-sequence: of every 2^k points that begin at a multiple of 2^k,
//! each box of area 2^-k with sides of powers of two holds one. The pairs of a sample are padded: the order of the
//! points is scrambled separately for each pair (Burley, "Practical Hash-based Owen Scrambling", JCGT 9, 2020). All
//! operations are branch-free arithmetic on 32-bit lanes, so that the points of 16 pixels are computed together. **May
//! import:** SIMD.

mod rate;

pub use self::rate::SamplesPerPixel;
pub(crate) use self::rate::{RANKS, rank};

use crate::simd::LANES;
use crate::simd::angles::sin_cos_quarter;

/// The maximum number of samples per pixel. The sequence is longer, but a sum of so many f32 has a relative error of up
/// to 2^-9 if all roundings have the same sign.
pub(crate) const MAX_SAMPLES: u32 = 1 << 16;

/// The padded dimension of a pair of random numbers: what the pair is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Purpose(u32);

/// The pairs of random numbers of one path vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Draw {
    /// The scattered direction.
    Direction = 1,
    /// The lobe of the BSDF, and Russian roulette.
    Choice = 2,
    /// The RIS choice among punctual lights, and among points on emitters.
    Light = 3,
    /// The point on an emissive triangle.
    Emitter = 4,
    /// The direction of the environment map.
    EnvironmentLight = 5,
    /// The point on the disc of a distant light.
    Disc = 6,
    /// The emissive triangle.
    EmitterChoice = 7,
}

impl Purpose {
    /// The position in the pixel.
    pub const PIXEL: Self = Self(0);

    /// The position in a pixel of the sensor, for cameras whose microlenses have an area: the draw 0 of vertex 1, which is
    /// no [`Draw`], as that of vertex 0 is the position in the pixel.
    pub const SENSOR: Self = Self(8);

    /// The pair `draw` of path vertex number `vertex`, counted from 0.
    #[inline(always)]
    pub const fn at_vertex(vertex: u32, draw: Draw) -> Self {
        Self(vertex * 8 + draw as u32)
    }
}

/// The number of cells of a pixel along each axis, 2^m, for the largest 4^m that is not above the number of samples: a
/// run of 4^m samples has one in each.
pub(crate) fn cells(samples: u32) -> u32 {
    1 << (samples.max(1).ilog2() / 2)
}

/// The runs of sixteen pixels in the sequences of their microlenses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Runs {
    /// The sequence.
    pub sequence: [u32; LANES],
    /// The index of the pixel's first sample in it; below 2^29.
    pub first: [u32; LANES],
}

/// The number of bits of an index in a sequence. The candidates of a sample take up to four indices each, and a path
/// keeps the index beside a flag.
const INDEX_BITS: u32 = 29;

/// A random number of 31 bits for each of sixteen rays from path vertex number `vertex` on, at the given indices of the
/// sequences.
#[inline(always)]
pub(crate) fn ray_numbers(sequences: &[u32; LANES], indices: &[u32; LANES], vertex: u32) -> [u32; LANES] {
    let mut out = [0; LANES];
    for lane in 0..LANES {
        out[lane] = hash(hash(sequences[lane] ^ indices[lane].wrapping_mul(0x85EB_CA6B)).wrapping_add(vertex)) >> 1;
    }
    out
}

/// Sixteen points of the unit square.
pub(crate) type Points = [[f32; LANES]; 2];

/// The sample sequence of a pixel. All variants are unbiased.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Owen-scrambled Sobol points, one sequence per microlens that all views take their samples from. The error of a
    /// mean over neighboring views decreases about as their number, or faster.
    #[default]
    OwnPositions,
    /// As [`OwnPositions`](Self::OwnPositions), but groups of 4 x 4 views share their pixel sample positions, so that the
    /// rays of a packet stay coherent: up to 1.4 times as fast in direct light (foliage), no faster for paths. The
    /// error of a single view is the same; that of a mean over many views is up to ten times larger, because
    /// neighboring views repeat each other's aliasing.
    SharedPositions,
    /// Independent random numbers: a baseline for measurements.
    Independent,
}

/// The identifiers of sixteen pixels that their random numbers depend on.
#[derive(Clone, Copy)]
pub(crate) struct PixelIds {
    /// The microlens.
    pub lens: [u32; LANES],
    /// The view, which is the pixel behind the microlens: its row and column.
    pub view: [[u32; LANES]; 2],
    /// The row and column of the packet among those behind its microlens, if all its pixels are there.
    pub packet: Option<[u32; 2]>,
}

/// Generates the random numbers of a render.
#[derive(Clone, Copy)]
pub(crate) struct Sampler {
    pub seed: u64,
    /// The maximum number of samples per pixel.
    pub samples: u32,
    pub sampling: Sampling,
    /// Whether the only sample of a pixel goes through its center.
    pub centered: bool,
    /// The cells of a pixel along each axis over which textures are averaged, if they are.
    pub cells: Option<u32>,
}

impl Sampling {
    /// The binary logarithm of the width, in views, of the groups that share their pixel sample positions.
    fn shared_bits(self) -> u32 {
        if self == Self::SharedPositions { 2 } else { 0 }
    }
}

impl Sampler {
    /// The runs of sixteen pixels.
    #[inline(always)]
    pub fn runs(&self, pixels: &PixelIds) -> Runs {
        self.runs_of_groups(pixels, 0)
    }

    /// The runs of the groups of 2^`shared_bits` x 2^`shared_bits` views.
    #[inline(always)]
    fn runs_of_groups(&self, pixels: &PixelIds, shared_bits: u32) -> Runs {
        let sample_bits = u32::BITS - (self.samples - 1).leading_zeros();
        let view_bits = INDEX_BITS - sample_bits;
        let mut out = Runs { sequence: [0; LANES], first: [0; LANES] };
        for lane in 0..LANES {
            let view = [pixels.view[0][lane] >> shared_bits, pixels.view[1][lane] >> shared_bits];
            let place = morton(view);
            out.first[lane] = (place & ((1 << view_bits) - 1)) << sample_bits;
            // More views than the index can count continue in other sequences.
            let rest = (place >> view_bits) ^ hash((view[0] >> 16) ^ (view[1] >> 16).wrapping_mul(0x9E37_79B9));
            out.sequence[lane] = sequence(self.seed, pixels.lens[lane], rest);
        }
        out
    }

    /// The position of sample `sample` within each pixel, 0 to 1 from the upper left corner: the same for the views of
    /// a group, different for every group and every microlens.
    #[inline(always)]
    pub fn pixel_positions(&self, pixels: &PixelIds, sample: u32) -> Points {
        let runs = self.runs_of_groups(pixels, self.sampling.shared_bits());
        self.points(&runs.sequence, &runs.first.map(|first| first + sample), Purpose::PIXEL)
    }

    /// The points at the given indices of sixteen sequences, in [0, 1).
    #[inline(always)]
    pub fn points(&self, sequences: &[u32; LANES], indices: &[u32; LANES], purpose: Purpose) -> Points {
        if self.sampling == Sampling::Independent {
            return independent(sequences, indices, purpose);
        }
        points_at(sequences, indices, purpose)
    }
}

/// A sequence of the microlens number `lens`; microlenses are numbered row by row.
#[inline(always)]
fn sequence(seed: u64, lens: u32, number: u32) -> u32 {
    // Hashed before the seed is added: otherwise two seeds would use the same sequences in another order.
    let a = hash(hash(lens) ^ seed as u32);
    hash(number.wrapping_add(a) ^ hash((seed >> 32) as u32 ^ 0x9E37_79B9))
}

/// Sixteen sequences for tests.
#[cfg(test)]
pub(crate) fn sequences(seed: u64, lens: &[u32; LANES], number: &[u32; LANES]) -> [u32; LANES] {
    std::array::from_fn(|lane| sequence(seed, lens[lane], number[lane]))
}

/// The place of a cell on the Morton curve over the lower 16 bits of its row and column.
#[inline(always)]
pub(crate) fn morton([row, column]: [u32; 2]) -> u32 {
    let spread = |x: u32| {
        let x = x & 0xFFFF;
        let x = (x | x << 8) & 0x00FF_00FF;
        let x = (x | x << 4) & 0x0F0F_0F0F;
        let x = (x | x << 2) & 0x3333_3333;
        (x | x << 1) & 0x5555_5555
    };
    spread(row) << 1 | spread(column)
}

/// Point number `index` of sixteen sequences, in [0, 1).
#[cfg(test)]
pub(crate) fn points(sequences: &[u32; LANES], index: u32, purpose: Purpose) -> Points {
    points_at(sequences, &[index; LANES], purpose)
}

/// The points at the given indices of sixteen sequences, in [0, 1).
#[inline(always)]
pub(crate) fn points_at(sequences: &[u32; LANES], indices: &[u32; LANES], purpose: Purpose) -> Points {
    let mut out = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        let seed = hash(sequences[lane] ^ purpose.0.wrapping_mul(0x85EB_CA6B));
        let index = owen(indices[lane], seed);
        let x = owen(index.reverse_bits(), hash(seed ^ 0xA511_E9B3));
        let y = owen(sobol_second(index), hash(seed ^ 0x63D8_3595));
        // The upper 24 bits: an f32 holds them exactly, and 1 is never reached.
        out[0][lane] = (x >> 8) as f32 * (1.0 / 16_777_216.0);
        out[1][lane] = (y >> 8) as f32 * (1.0 / 16_777_216.0);
    }
    out
}

/// Independent random numbers with the interface of [`points_at`].
#[inline(never)]
fn independent(sequences: &[u32; LANES], indices: &[u32; LANES], purpose: Purpose) -> Points {
    let mut out = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        let mut x = hash(hash(sequences[lane] ^ purpose.0.wrapping_mul(0x85EB_CA6B)) ^ hash(indices[lane]));
        for coordinate in &mut out {
            x = hash(x.wrapping_add(0x9E37_79B9));
            coordinate[lane] = (x >> 8) as f32 * (1.0 / 16_777_216.0);
        }
    }
    out
}

/// Mixes 32 bits (the "lowbias32" constants of C. Wellons' hash prospector).
#[inline(always)]
pub(crate) fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7FEB_352D);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846C_A68B);
    x ^ (x >> 16)
}

/// The second dimension of the Sobol sequence as a 32-bit fraction: Pascal's triangle modulo 2 times the bits of the
/// index, in five steps of halves (Ahmed, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and
/// Compact", 2024), then reversed like the first.
#[inline(always)]
fn sobol_second(index: u32) -> u32 {
    let mut x = index;
    x ^= x >> 16;
    x ^= (x & 0xFF00_FF00) >> 8;
    x ^= (x & 0xF0F0_F0F0) >> 4;
    x ^= (x & 0xCCCC_CCCC) >> 2;
    x ^= (x & 0xAAAA_AAAA) >> 1;
    x.reverse_bits()
}

/// Scrambles the digits of a 32-bit fraction, each by a function of those before it: Owen's scrambling, by the hash of
/// Laine and Karras with the constants of Vegdahl ("Building a Better LK Hash", 2021).
#[inline(always)]
fn owen(fraction: u32, seed: u32) -> u32 {
    let mut x = fraction.reverse_bits();
    x ^= x.wrapping_mul(0x3D20_ADEA);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6C56);
    x ^= x.wrapping_mul(0x53A2_2864);
    x.reverse_bits()
}

/// Cosine-distributed directions about +Z (Malley's method over the concentric disk of Shirley and Chiu, 1997).
#[inline(always)]
pub(crate) fn cosine_hemisphere([u, v]: &Points) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let (a, b) = (2.0 * u[lane] - 1.0, 2.0 * v[lane] - 1.0);
        let wide = a.abs() > b.abs();
        let (radius, other) = if wide { (a, b) } else { (b, a) };
        let ratio = if radius == 0.0 { 0.0 } else { other / radius };
        let (sin, cos) = sin_cos_quarter(std::f32::consts::FRAC_PI_4 * ratio);
        let (along, across) = (radius * cos, radius * sin);
        let (x, y) = if wide { (along, across) } else { (across, along) };
        out[0][lane] = x;
        out[1][lane] = y;
        out[2][lane] = (1.0 - x * x - y * y).max(0.0).sqrt();
    }
    out
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al., "Building an Orthonormal
/// Basis, Revisited", JCGT 6, 2017).
#[inline(always)]
pub(crate) fn frame(n: [f32; 3]) -> [[f32; 3]; 2] {
    let sign = 1.0f32.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [[1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]]]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKY: Purpose = Purpose::at_vertex(0, Draw::Direction);

    fn sequence(k: u32) -> [u32; LANES] {
        sequences(7, &std::array::from_fn(|lane| lane as u32), &[k; LANES])
    }

    #[test]
    fn the_frame_is_orthonormal() {
        for n in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [1.0, 0.0, 0.0], [0.48, 0.6, 0.64]] {
            let [x, y] = frame(n);
            let dot = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f32>();
            for (a, b, expected) in [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (x, n, 0.0), (y, n, 0.0)] {
                assert!((dot(a, b) - expected).abs() < 1e-6, "{n:?}");
            }
        }
    }

    /// Scrambling keeps the net property: of 2^k points every elementary box of area 2^-k holds exactly one; the same
    /// holds for every later run of 2^k points.
    #[test]
    fn every_run_of_points_is_a_net() {
        for purpose in [Purpose::PIXEL, SKY] {
            for k in [0u32, 1, 4, 6, 8] {
                let count = 1u32 << k;
                for first in [0, 3 * count] {
                    let runs: Vec<Points> = (first..first + count).map(|i| points(&sequence(3), i, purpose)).collect();
                    for lane in 0..LANES {
                        for across in 0..=k {
                            let (columns, rows) = (1u32 << across, 1u32 << (k - across));
                            let mut boxes = vec![0; count as usize];
                            for p in &runs {
                                let column = (p[0][lane] * columns as f32) as u32;
                                let row = (p[1][lane] * rows as f32) as u32;
                                boxes[(row * columns + column) as usize] += 1;
                            }
                            assert!(boxes.iter().all(|&n| n == 1), "{purpose:?} 2^{k} points, {columns} x {rows}");
                        }
                    }
                }
            }
        }
    }

    /// Blocks of 2 x 2, 4 x 4, ... views are nets together: the samples of all their pixels.
    #[test]
    fn the_samples_of_neighboring_views_are_a_net() {
        for (samples, shift) in [(1u32, 0u32), (4, 0), (16, 0), (4, 2), (3, 0)] {
            let sampler = Sampler { seed: 3, samples, sampling: Sampling::default(), centered: false, cells: None };
            // A power of two of samples fills its run.
            let full = samples.next_power_of_two();
            for block in [2u32, 4, 8] {
                let mut points = Vec::new();
                for view in 0..block * block {
                    let at = [7 * block + view / block, 100 * block + view % block].map(|k| [k << shift; LANES]);
                    let ids = PixelIds { lens: std::array::from_fn(|lane| lane as u32), view: at, packet: None };
                    let runs = sampler.runs_of_groups(&ids, shift);
                    for sample in 0..full {
                        points.push(sampler.points(&runs.sequence, &runs.first.map(|first| first + sample), SKY));
                    }
                }
                let across = points.len().ilog2() / 2;
                let [columns, rows] = [1u32 << across, (points.len() as u32) >> across];
                for lane in 0..LANES {
                    let cells: std::collections::BTreeSet<_> = points
                        .iter()
                        .map(|[x, y]| ((x[lane] * columns as f32) as u32, (y[lane] * rows as f32) as u32))
                        .collect();
                    assert_eq!(cells.len(), points.len(), "{samples} samples, {block} x {block} views");
                }
            }
        }
    }

    /// No two pixels of a microlens share a point, however many views and samples there are.
    #[test]
    fn runs_do_not_overlap() {
        let sampler =
            Sampler { seed: 1, samples: MAX_SAMPLES, sampling: Sampling::default(), centered: false, cells: None };
        let mut seen = std::collections::BTreeSet::new();
        for row in (0..300).chain(65_500..65_600) {
            for column in [0, 1, 90, 127, 128, 4095, 65_536] {
                let view = [[row; LANES], [column; LANES]];
                let runs = sampler.runs(&PixelIds { lens: [5; LANES], view, packet: None });
                assert!(runs.first[0] <= (1 << INDEX_BITS) - MAX_SAMPLES && runs.first[0].is_multiple_of(MAX_SAMPLES));
                assert!(seen.insert((runs.sequence[0], runs.first[0])), "view ({row}, {column})");
            }
        }
    }

    /// Neighboring pixels, and the pairs of one pixel, are uncorrelated: over 4096 views within four standard errors
    /// (1/64 each) of independent numbers.
    #[test]
    fn pixels_and_pairs_are_decorrelated() {
        let draw = |k: u32, purpose| points(&sequence(k), 0, purpose);
        let mut sums = [0.0f64; 4];
        for k in 0..4096 {
            let (here, next, sky) = (draw(k, Purpose::PIXEL), draw(k + 1, Purpose::PIXEL), draw(k, SKY));
            let centered = |x: f32| (f64::from(x) - 0.5) * 12f64.sqrt();
            let pairs =
                [(here[0][0], here[0][1]), (here[0][2], next[0][2]), (here[0][3], sky[0][3]), (here[0][4], here[1][4])];
            for (sum, (a, b)) in sums.iter_mut().zip(pairs) {
                *sum += centered(a) * centered(b) / 4096.0;
            }
        }
        assert!(sums.iter().all(|c| c.abs() < 4.0 / 64.0), "{sums:?}");
    }

    /// Two seeds share no sequence, for any microlens.
    #[test]
    fn seeds_share_no_sequence() {
        let all = |seed: u64| -> std::collections::BTreeSet<u32> {
            (0..256)
                .flat_map(|k| sequences(seed, &std::array::from_fn(|lane| k * 16 + lane as u32), &[5; LANES]))
                .collect()
        };
        let zero = all(0);
        assert!(zero.len() >= 4095, "lenses share sequences");
        for seed in [1, 2, 15, 1 << 32, u64::MAX] {
            assert!(all(seed).intersection(&zero).count() <= 1, "seed {seed}");
        }
    }

    /// The mean of the cosine under a cosine distribution is 2/3, and x, y average to 0: within 1e-3 for 16384 points.
    #[test]
    fn the_hemisphere_has_the_right_moments() {
        let mut sums = [0.0f64; 3];
        let count = 16384;
        for index in 0..count {
            let directions = cosine_hemisphere(&points(&sequence(0), index, SKY));
            for lane in 0..LANES {
                let length: f32 = directions.iter().map(|x| x[lane] * x[lane]).sum();
                assert!((length - 1.0).abs() < 1e-5);
            }
            for axis in 0..3 {
                sums[axis] += f64::from(directions[axis][0]) / f64::from(count);
            }
        }
        assert!(sums[0].abs() < 1e-3 && sums[1].abs() < 1e-3 && (sums[2] - 2.0 / 3.0).abs() < 1e-3, "{sums:?}");
    }
}
