//! The choice of the estimate: the one with most samples whose value does not differ from those of smaller ones by more
//! than noise explains.
//!
//! The squared error of an estimate is its variance plus the square of its bias. The variance follows from that of the
//! samples. The bias against a smaller estimate j shows in the difference of the two, whose expected square is
//! bias^2 + variance_j - variance. Both are averaged over the microlenses around, relative to their luminance. A
//! difference below two and a half standard errors of that average counts as noise, where noise is normal, and so does one that single
//! places make: rare bright samples are not normal. (The comparison of nested windows is that of
//! Lepski, 1991, and of Goldenshluger and Nemirovski, 1997, known in image processing as the intersection of confidence
//! intervals.)

use super::fit;
use super::nodes::WINDOW_COUNT;

/// The largest number of levels: the pixel itself, windows, the trend over the views, fits.
pub(super) const LEVELS: usize = levels(WINDOW_COUNT);

/// The number of levels with this many windows.
pub(super) const fn levels(windows: usize) -> usize {
    2 + windows + fit::RADII.len()
}

/// Microlenses on each side over which evidence is averaged.
pub(super) const LENSES: usize = 1;

/// Standard errors above which a difference counts as bias.
const STANDARD_ERRORS: f32 = 2.5;

/// The same for the standard error that the places show. Of k places alike among many without a difference it is the mean
/// over the root of k: one or two of them count as noise, three as bias.
const RARE: f32 = 1.5;

/// The evidence of a place is relative to its luminance and to that around; the latter has this share of the mean square. So
/// a place that is dark, or is found dark by chance, does not outweigh its neighbors.
const AROUND: f32 = 0.5;

/// The same share for the estimated error of a pixel, which is relative to its own luminance; it is finite in the dark.
const FLOOR: f32 = 0.01;

/// The pairs of levels, the smaller first.
const PAIRS: usize = LEVELS * (LEVELS - 1) / 2;

/// The luminance of an estimate and its variance.
pub(super) type Estimate = [f32; 2];

/// What the estimates of one place, or of several ones together, tell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence {
    /// Sums of variances, by level, relative to the luminance.
    variance: [f32; LEVELS],
    /// Sums of squared differences between two levels, and what noise alone would give.
    difference: [f32; PAIRS],
    noise: [f32; PAIRS],
    /// Sums of squares of how far a squared difference is from that of noise.
    spread: [f32; PAIRS],
    /// The weights of the places that have this level, and both levels.
    weights: [f32; LEVELS],
    pair_weights: [f32; PAIRS],
    /// The pixels among the places: those that do not only compare. Few of them have samples of their own where not all are
    /// traced; the variance of few samples is no evidence.
    pixels: f32,
}

/// The level of a place, and its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Choice {
    /// A level; fractions stand for mixtures of two.
    pub level: f32,
    /// The estimated relative squared error.
    pub error: f32,
}

const fn pair(smaller: usize, larger: usize) -> usize {
    larger * (larger - 1) / 2 + smaller
}

/// The root of the weighted mean square of a luminance and that around it, which has this share. (Squares may exceed f32.)
#[inline(always)]
fn mixed(own: f32, around: f32, share: f32) -> f32 {
    ((1.0 - share).sqrt() * own).hypot(share.sqrt() * around).max(f32::MIN_POSITIVE)
}

/// The squared error of a place relative to its own luminance, from one that is relative as evidence is.
#[inline(always)]
pub(super) fn relative_to_own(error: f32, own: f32, around: f32) -> f32 {
    let ratio = mixed(own, around, AROUND) / mixed(own, around, FLOOR);
    error * ratio * ratio
}

impl Default for Evidence {
    fn default() -> Self {
        Self::NONE
    }
}

impl Evidence {
    /// Nothing.
    pub const NONE: Self = Self {
        variance: [0.0; LEVELS],
        difference: [0.0; PAIRS],
        noise: [0.0; PAIRS],
        spread: [0.0; PAIRS],
        weights: [0.0; LEVELS],
        pair_weights: [0.0; PAIRS],
        pixels: 0.0,
    };

    /// Adds a place, whose levels without an estimate are `None`; `around` is the luminance of what is around it. The
    /// smallest level of a place that `compares` is only there to be compared with.
    #[inline(always)]
    pub fn add(&mut self, estimates: &[Option<Estimate>; LEVELS], levels: usize, around: f32, compares: bool) {
        self.pixels += if compares { 0.0 } else { 1.0 };
        let mut bright = 0.0;
        for estimate in estimates[..levels].iter().flatten() {
            bright = estimate[0];
        }
        let scale = 1.0 / mixed(bright, around, AROUND);
        for larger in 0..levels {
            let Some([value, noise]) = estimates[larger] else { continue };
            if !(compares && larger == 0) {
                self.variance[larger] += noise * scale * scale;
                self.weights[larger] += 1.0;
            }
            for smaller in 0..larger {
                if let Some([other, more]) = estimates[smaller] {
                    let apart = (value - other) * scale;
                    let expected = (more - noise).max(0.0) * scale * scale;
                    self.difference[pair(smaller, larger)] += apart * apart;
                    self.noise[pair(smaller, larger)] += expected;
                    self.spread[pair(smaller, larger)] += (apart * apart - expected).powi(2);
                    self.pair_weights[pair(smaller, larger)] += 1.0;
                }
            }
        }
    }

    /// Adds the places of another one; both have so many levels.
    #[inline(always)]
    pub fn merge(&mut self, other: &Self, levels: usize) {
        self.pixels += other.pixels;
        for k in 0..levels {
            self.variance[k] += other.variance[k];
            self.weights[k] += other.weights[k];
        }
        for k in 0..pair(0, levels) {
            self.difference[k] += other.difference[k];
            self.noise[k] += other.noise[k];
            self.spread[k] += other.spread[k];
            self.pair_weights[k] += other.pair_weights[k];
        }
    }

    /// Chooses; `observations` tells how many independent ones each place is at a level. `None` if no level has an
    /// estimate.
    #[inline(always)]
    pub fn choose(&self, levels: usize, observations: &[f32; LEVELS]) -> Option<Choice> {
        let mut variance = [0.0; LEVELS];
        for level in 0..levels {
            variance[level] = self.variance[level] / self.weights[level];
        }
        let mut best: Option<Choice> = None;
        for larger in 0..levels {
            let is_rare = larger == 0 && levels > 1 && 2.0 * self.weights[0] < self.pixels;
            if self.weights[larger] == 0.0 || is_rare {
                continue;
            }
            let mut error = variance[larger];
            for smaller in 0..larger {
                let weight = self.pair_weights[pair(smaller, larger)];
                if weight == 0.0 {
                    continue;
                }
                let noise = self.noise[pair(smaller, larger)] / weight;
                let found = self.difference[pair(smaller, larger)] / weight;
                let bias = found - noise;
                let independent = (weight * observations[smaller]).max(1.0);
                // Of the mean of squared normal numbers, for the difference and for its expectation.
                let of_normal = noise * (4.0 / independent).sqrt();
                let spread = self.spread[pair(smaller, larger)] / weight - bias * bias;
                let of_places = (spread.max(0.0) / independent).sqrt();
                if bias > (STANDARD_ERRORS * of_normal).max(RARE * of_places) {
                    error = error.max(variance[larger] + bias);
                }
            }
            if best.is_none_or(|best| error <= best.error) {
                best = Some(Choice { level: larger as f32, error });
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The choice among pixels and one window, whose values are 1; the pixels differ from it by these, and have the variance
    /// 0.0001.
    fn chosen(differences: impl Iterator<Item = f32>) -> Choice {
        let mut all = Evidence::NONE;
        for difference in differences {
            let mut estimates = [None; LEVELS];
            estimates[..2].copy_from_slice(&[Some([1.0 + difference, 1e-4]), Some([1.0, 1e-6])]);
            all.add(&estimates, 2, 1.0, false);
        }
        all.choose(2, &[1.0; LEVELS]).expect("estimates")
    }

    #[test]
    fn a_rare_bright_sample_is_noise_and_a_common_difference_is_bias() {
        let noise = |k: usize| if k.is_multiple_of(2) { 0.01 } else { -0.01 };
        let window = chosen((0..81).map(noise));
        assert_eq!(window.level, 1.0);
        assert!((window.error - 1e-6).abs() < 1e-8, "{window:?}");
        // One pixel that is twice as bright: the mean of the squares is 120 times the variance.
        let rare = chosen((0..81).map(|k| if k == 40 { 1.0 } else { noise(k) }));
        assert_eq!(rare, window);
        // Every third pixel is brighter by a tenth: a highlight, an edge.
        let bias = chosen((0..81).map(|k| if k % 3 == 0 { 0.1 } else { noise(k) }));
        assert_eq!(bias.level, 0.0);
        assert!((bias.error / 1e-4 - 1.0).abs() < 1e-3, "{bias:?}");
    }
}
