//! What the reconstruction across views needs to know of a pixel beside its color: how far its samples disagree, and
//! how far what they hit moves from view to view.
//!
//! The samples of a pixel are divided into two halves. With A and B the means of the luminance of n_a and n_b samples,
//! the **half difference** is (A - B) sqrt(n_a n_b) / (n_a + n_b): its expected square is the variance of the mean of all
//! samples if they are independent, and more if they are stratified. It holds noise alone: texture and edges are in
//! both halves. (Rousselle, Knaus and Zwicker, "Adaptive rendering with non-local means filtering", 2012.)

use holo_core::Disparity;

use super::tint;
use crate::simd::{LANES, at};

/// Channels of the guides of a pixel: the half difference, the mean disparity of the first hits, px, the number of samples,
/// and the mean [tint](super::tint) of the first hits.
pub(crate) const CHANNELS: usize = 4;

/// The channel of the number of samples: 0 for a pixel that was only seen, whose disparity is that of one ray.
pub(crate) const SAMPLES: usize = 2;

/// The channel of the packed tint; it is only known of pixels with samples.
pub(crate) const TINT: usize = 3;

/// What tells how far things move from view to view.
#[derive(Clone, Copy)]
pub(crate) enum Movement {
    /// The disparity of the views, and how far things move between adjacent ones, in multiples of it along the axis where
    /// they move more: the mean over the samples is the second guide.
    Disparity(Disparity, f32),
    /// The statistics of the inverse depth, in which samples have the weight of their light. The second guide stays 0.
    Statistics,
}

/// From this many samples on, groups of this many belong to one half; of fewer samples, the first half are one half.
const GROUP: u32 = 4;

/// The guides of the packets of a tile during rendering.
#[derive(Default)]
pub(crate) struct Guides {
    /// The bits of an index in a sequence that count the samples of a pixel.
    mask: u32,
    /// The bit of the number of a sample that tells its half.
    bit: u32,
    /// The sums of the luminance of the samples of the second half.
    second: Vec<[f32; LANES]>,
    /// The sums of the disparity of the first hits.
    disparity: Vec<[f32; LANES]>,
    /// The sums of their tints.
    tint: Vec<[[f32; LANES]; 3]>,
}

/// Luminance, Rec. 709.
#[inline(always)]
pub(crate) fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

impl Guides {
    /// Resets the state for another tile of this many packets, with up to this many samples per pixel.
    pub fn begin(&mut self, samples: u32, packets: usize) {
        self.mask = samples.next_power_of_two() - 1;
        self.bit = if samples > GROUP { GROUP } else { samples.div_ceil(2) };
        for sums in [&mut self.second, &mut self.disparity] {
            sums.clear();
            sums.resize(packets, [0.0; LANES]);
        }
        self.tint.clear();
        self.tint.resize(packets, [[0.0; LANES]; 3]);
    }

    /// Whether the sample at `index` of its sequence belongs to the second half.
    #[inline(always)]
    pub fn is_second(&self, index: u32) -> bool {
        index & self.mask & self.bit != 0
    }

    /// Adds light of a sample of the second half.
    #[inline(always)]
    pub fn add_second(&mut self, packet: usize, lane: usize, color: [f32; 3]) {
        self.second[packet][lane] += luminance(color);
    }

    /// Adds the tints of the first hits of one sample.
    #[inline(always)]
    pub fn add_tint(&mut self, packet: usize, tint: &[[f32; LANES]; 3]) {
        for c in 0..3 {
            for lane in 0..LANES {
                self.tint[packet][c][lane] += tint[c][lane];
            }
        }
    }

    /// Adds the disparities of the first hits of one sample.
    #[inline(always)]
    pub fn add_disparity(&mut self, packet: usize, disparity: &[f32; LANES]) {
        for lane in 0..LANES {
            self.disparity[packet][lane] += disparity[lane];
        }
    }

    /// The sums of the disparities of the first hits.
    #[inline(always)]
    pub fn disparity(&self, packet: usize) -> &[f32; LANES] {
        &self.disparity[packet]
    }

    /// The guides of a packet with the given sums of color over `samples` samples.
    #[inline(always)]
    pub fn packet(&self, packet: usize, color: &[[f32; LANES]; 3], samples: u32) -> [[f32; LANES]; CHANNELS] {
        let second_count = self.second_count(samples);
        let [a, b] = [samples - second_count, second_count].map(|count| count as f32);
        let mut out = [[0.0; LANES], [0.0; LANES], [samples as f32; LANES], [0.0; LANES]];
        let scale = 1.0 / samples.max(1) as f32;
        for lane in 0..LANES {
            let all = luminance([color[0][lane], color[1][lane], color[2][lane]]);
            let second = self.second[packet][lane];
            let difference = ((all - second) / a - second / b) * ((a * b).sqrt() / (a + b));
            out[0][lane] = if second_count > 0 { difference } else { 0.0 };
            out[1][lane] = self.disparity[packet][lane] / samples.max(1) as f32;
            if samples > 0 {
                out[TINT][lane] = tint::pack(at(&self.tint[packet], lane).map(|sum| sum * scale));
            }
        }
        out
    }

    /// How many of the first `samples` samples belong to the second half.
    fn second_count(&self, samples: u32) -> u32 {
        let period = 2 * self.bit;
        samples / period * self.bit + (samples % period).saturating_sub(self.bit)
    }
}

/// Adds the sums of color of a later round and its guides to the means of a packet, over `counts` samples before and in the
/// round. The halves of the half difference are then the samples before and those of the round.
#[inline(always)]
pub(crate) fn merge(
    (color, all): (&mut [[f32; LANES]; 3], &mut [[f32; LANES]; CHANNELS]),
    (sums, added): (&[[f32; LANES]; 3], &[[f32; LANES]; CHANNELS]),
    [before, count]: [f32; 2],
) {
    let total = before + count;
    let scale = (before * count).sqrt() / total;
    for lane in 0..LANES {
        let old = [color[0][lane], color[1][lane], color[2][lane]];
        let new = [sums[0][lane], sums[1][lane], sums[2][lane]].map(|sum| sum / count);
        let difference = (luminance(old) - luminance(new)) * scale;
        all[0][lane] = if before > 0.0 { difference } else { added[0][lane] };
        all[1][lane] = (all[1][lane] * before + added[1][lane] * count) / total;
        all[SAMPLES][lane] = total;
        let added = added[TINT][lane];
        all[TINT][lane] = if before > 0.0 { tint::mixed(all[TINT][lane], added, before / total) } else { added };
        for c in 0..3 {
            color[c][lane] = (old[c] * before + sums[c][lane]) / total;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_have_the_samples_that_are_counted() {
        for samples in 1..200 {
            let mut guides = Guides::default();
            guides.begin(samples, 1);
            // The runs of pixels begin at multiples of a power of two.
            let first = 3 * samples.next_power_of_two();
            for taken in 1..=samples {
                let second = (first..first + taken).filter(|&index| guides.is_second(index)).count() as u32;
                assert_eq!(second, guides.second_count(taken), "{taken} of {samples}");
            }
            let second = guides.second_count(samples);
            assert!(samples == 1 || (second > 0 && samples - second >= second), "{samples}: {second}");
        }
    }

    /// Rounds of 3 and 5 samples are merged to the means of all eight; a half difference has their weight.
    #[test]
    fn rounds_are_merged_by_their_samples() {
        let tints = [[0.2, 0.4, 0.9], [1.0, 0.8, 0.1]];
        let guides = |level: f32, tint: [f32; 3]| {
            let mut all = [[0.0; LANES]; CHANNELS];
            (all[0], all[1], all[TINT]) = ([0.5; LANES], [level; LANES], [tint::pack(tint); LANES]);
            all
        };
        let (mut color, mut all) = ([[2.0; LANES], [4.0; LANES], [6.0; LANES]], guides(1.0, tints[0]));
        // Sums of five samples of 10, 5 and 0.
        let sums = [[50.0; LANES], [25.0; LANES], [0.0; LANES]];
        merge((&mut color, &mut all), (&sums, &guides(9.0, tints[1])), [3.0, 5.0]);
        let near = |found: f32, expected: f32, error: f32| {
            assert!((found / expected - 1.0).abs() < error, "{found} {expected}");
        };
        for lane in 0..LANES {
            for (c, sum) in [56.0, 37.0, 18.0].into_iter().enumerate() {
                near(color[c][lane], sum / 8.0, 1e-6);
            }
            near(all[1][lane], 48.0 / 8.0, 1e-6);
            near(all[SAMPLES][lane], 8.0, 1e-6);
            near(all[0][lane], (luminance([2.0, 4.0, 6.0]) - luminance([10.0, 5.0, 0.0])) * 15f32.sqrt() / 8.0, 1e-5);
            // Tints are packed to 0.4 %, twice.
            for (c, found) in tint::unpack(all[TINT][lane]).into_iter().enumerate() {
                near(found, (3.0 * tints[0][c] + 5.0 * tints[1][c]) / 8.0, 0.008);
            }
        }
        // The first round is taken as it is.
        let (mut color, mut all) = ([[0.0; LANES]; 3], guides(0.0, tints[0]));
        merge((&mut color, &mut all), (&sums, &guides(9.0, tints[1])), [0.0, 5.0]);
        assert!(color.iter().zip([10.0, 5.0, 0.0]).all(|(found, expected)| *found == [expected; LANES]));
        assert_eq!([all[0][0], all[1][0], all[SAMPLES][0], all[TINT][0]], [0.5, 9.0, 5.0, tint::pack(tints[1])]);
    }

    /// Over many pixels of independent samples, the mean square of the half difference is the variance of the mean.
    #[test]
    fn the_half_difference_has_the_variance_of_the_mean() {
        use crate::sampling::{self, Purpose};
        for samples in [2u32, 3, 4, 6, 16] {
            let (mut squares, mut pixels) = (0.0, 0.0);
            for pixel in 0..2000u32 {
                let mut guides = Guides::default();
                guides.begin(samples, 1);
                let mut color = [[0.0; LANES]; 3];
                for sample in 0..samples {
                    let numbers: [u32; LANES] =
                        std::array::from_fn(|lane| (pixel * samples + sample) * 16 + lane as u32);
                    let [value, _] =
                        sampling::points(&sampling::sequences(5, &numbers, &[1; LANES]), 0, Purpose::PIXEL);
                    for lane in 0..LANES {
                        (0..3).for_each(|c| color[c][lane] += value[lane]);
                        if guides.is_second(sample) {
                            guides.add_second(0, lane, [value[lane]; 3]);
                        }
                    }
                }
                let [difference, ..] = guides.packet(0, &color, samples);
                squares += difference.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>();
                pixels += LANES as f64;
            }
            // Numbers uniform in [0, 1) have the variance 1/12; 32,000 squares agree within 2 %.
            let expected = 1.0 / 12.0 / f64::from(samples);
            assert!((squares / pixels / expected - 1.0).abs() < 0.03, "{samples}: {}", squares / pixels / expected);
        }
    }
}
