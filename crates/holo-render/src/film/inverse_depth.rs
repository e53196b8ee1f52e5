//! Statistics of the inverse depth of what a pixel sees, over the samples of its color.
//!
//! A pixel of a plenoptic camera sees a part of the scene through the whole lit part of a microlens. Inverse depth is
//! linear in disparity and in virtual depth, so its mean and deviation give theirs. A ray that misses the scene counts as
//! inverse depth 0. Samples have the weight that they have in color.

use crate::simd::{LANES, Lanes, at};

/// Values of a pixel: the sum of the weights, of those of rays that hit, the mean of the inverse depth, and the sum of
/// the weighted squares of the differences from it.
pub(crate) const CHANNELS: usize = 4;

/// The sums of the packets of a tile during rendering.
#[derive(Default)]
pub(crate) struct InverseDepths {
    /// Of the weights, of those that hit, of weight / depth and weight / depth^2.
    sums: Vec<[[f64; LANES]; 4]>,
}

impl InverseDepths {
    /// Resets the state for another tile of this many packets.
    pub fn begin(&mut self, packets: usize) {
        self.sums.clear();
        self.sums.resize(packets, [[0.0; LANES]; 4]);
    }

    /// Adds the first hits of one sample: depths, infinite for misses.
    #[inline(always)]
    pub fn add(&mut self, packet: usize, valid: &Lanes<i32>, weight: &[f32; LANES], depth: &[f64; LANES]) {
        let sums = &mut self.sums[packet];
        for lane in 0..LANES {
            let weight = if valid.0[lane] != 0 { f64::from(weight[lane]) } else { 0.0 };
            let inverse = 1.0 / depth[lane];
            let hit = if inverse > 0.0 { weight } else { 0.0 };
            for (k, value) in [weight, hit, hit * inverse, hit * inverse * inverse].into_iter().enumerate() {
                sums[k][lane] += value;
            }
        }
    }

    /// The values of a packet.
    #[inline(always)]
    pub fn packet(&self, packet: usize) -> [[f32; LANES]; CHANNELS] {
        let sums = &self.sums[packet];
        let mut out = [[0.0; LANES]; CHANNELS];
        for lane in 0..LANES {
            let weight = sums[0][lane];
            let mean = if weight > 0.0 { sums[2][lane] / weight } else { 0.0 };
            let squares = (sums[3][lane] - mean * sums[2][lane]).max(0.0);
            for (k, value) in [weight, sums[1][lane], mean, squares].into_iter().enumerate() {
                out[k][lane] = value as f32;
            }
        }
        out
    }
}

/// The values of a packet if every sample has `factor` times its weight.
#[inline(always)]
pub(crate) fn scaled(mut values: [[f32; LANES]; CHANNELS], factor: f32) -> [[f32; LANES]; CHANNELS] {
    // All but the mean.
    for k in [0, 1, 3] {
        for lane in 0..LANES {
            values[k][lane] *= factor;
        }
    }
    values
}

/// The values of the samples of two packets of the same pixels together.
pub(crate) fn merged_packets(a: &[[f32; LANES]; CHANNELS], b: &[[f32; LANES]; CHANNELS]) -> [[f32; LANES]; CHANNELS] {
    let mut out = [[0.0; LANES]; CHANNELS];
    for lane in 0..LANES {
        for (out, value) in out.iter_mut().zip(merged(at(a, lane), at(b, lane))) {
            out[lane] = value;
        }
    }
    out
}

/// The values of the samples of `a` and `b` together.
pub(crate) fn merged(a: [f32; CHANNELS], b: [f32; CHANNELS]) -> [f32; CHANNELS] {
    let [a, b] = [a, b].map(|values| values.map(f64::from));
    let weight = a[0] + b[0];
    if weight <= 0.0 {
        return [0.0; CHANNELS];
    }
    let difference = b[2] - a[2];
    let mean = a[2] + difference * b[0] / weight;
    let squares = a[3] + b[3] + difference * difference * a[0] * b[0] / weight;
    [weight, a[1] + b[1], mean, squares].map(|value| value as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums in two groups, merged, are those of all samples.
    #[test]
    fn groups_merge_to_the_whole() {
        let samples: [(f32, f64); 6] =
            [(1.0, 2.0), (0.5, 2.1), (0.25, f64::INFINITY), (2.0, 1.9), (1.0, 2.0), (0.0, 1.0)];
        let all = |samples: &[(f32, f64)]| {
            let mut sums = InverseDepths::default();
            sums.begin(1);
            for &(weight, depth) in samples {
                sums.add(0, &Lanes([-1; LANES]), &[weight; LANES], &[depth; LANES]);
            }
            sums.packet(0).map(|values| values[3])
        };
        let whole = all(&samples);
        let total: f64 = samples.iter().map(|(weight, _)| f64::from(*weight)).sum();
        let mean = samples.iter().map(|(weight, depth)| f64::from(*weight) / depth).sum::<f64>() / total;
        let squares: f64 =
            samples.iter().map(|(weight, depth)| f64::from(*weight) * (1.0 / depth - mean).powi(2)).sum();
        assert!((f64::from(whole[2]) - mean).abs() < 1e-7 && (f64::from(whole[3]) - squares).abs() < 1e-6, "{whole:?}");
        assert_eq!((whole[0], whole[1]), (4.75, 4.5));
        let parts = merged(all(&samples[..2]), all(&samples[2..]));
        for (a, b) in whole.into_iter().zip(parts) {
            assert!((a - b).abs() < 1e-6, "{whole:?} {parts:?}");
        }
        assert_eq!(merged([0.0; 4], whole), whole);
    }

    /// The means of a first round and the sums of a second one are the means of all samples.
    #[test]
    fn rounds_have_the_means_of_all_samples() {
        let packet = |samples: &[(f32, f64)]| {
            let mut sums = InverseDepths::default();
            sums.begin(1);
            for &(weight, depth) in samples {
                sums.add(0, &Lanes([-1; LANES]), &[weight; LANES], &[depth; LANES]);
            }
            sums.packet(0)
        };
        let samples: [(f32, f64); 5] = [(1.0, 2.0), (0.5, 2.1), (0.25, f64::INFINITY), (2.0, 1.9), (0.0, 1.0)];
        let expected = scaled(packet(&samples), 1.0 / 5.0);
        let first = scaled(packet(&samples[..2]), 1.0 / 2.0);
        let all = merged_packets(&scaled(first, 2.0 / 5.0), &scaled(packet(&samples[2..]), 1.0 / 5.0));
        for k in 0..CHANNELS {
            assert!((all[k][7] - expected[k][7]).abs() < 1e-6, "{k}: {} {}", all[k][7], expected[k][7]);
        }
    }
}
