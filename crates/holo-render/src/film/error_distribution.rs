//! The distribution of the estimated error of the pixels of a light field, in constant memory.

use std::collections::BTreeMap;

/// Bits of the mantissa of an error that count: 32 classes for each factor of two.
const MANTISSA_BITS: u32 = 5;

/// The number of classes: that of infinity is the last.
const CLASSES: usize = (f32::INFINITY.to_bits() >> (f32::MANTISSA_DIGITS - 1 - MANTISSA_BITS)) as usize + 1;

/// Pixels with smaller errors see nothing that has noise.
const LEAST_NOISE: f32 = 1e-4;

/// The distribution of the estimated relative standard error of pixels: how many pixels are in each of 32 classes for
/// each factor of two.
///
/// # Accuracy
/// [`Self::quantile`] is the middle of a class: within 1.6 % of the error itself.
///
/// # Examples
/// ```
/// use holo_render::ErrorDistribution;
///
/// let mut distribution = ErrorDistribution::default();
/// (1..=99).for_each(|percent| distribution.add(percent as f32 / 100.0));
/// let median = distribution.quantile(0.5).expect("there are pixels");
/// assert!((median / 0.5 - 1.0).abs() < 0.016);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ErrorDistribution(BTreeMap<u16, u64>);

impl ErrorDistribution {
    /// Adds a pixel with this estimated error. Errors that are not a number count as infinite.
    #[inline]
    pub fn add(&mut self, error: f32) {
        *self.0.entry(class(error)).or_default() += 1;
    }

    /// Adds pixels with these estimated errors.
    pub fn extend(&mut self, errors: &[f32]) {
        if errors.len() < CLASSES / 8 {
            return errors.iter().for_each(|&error| self.add(error));
        }
        let mut counts = vec![0u32; CLASSES];
        errors.iter().for_each(|&error| counts[usize::from(class(error))] += 1);
        for (class, count) in (0..).zip(counts).filter(|(_, count)| *count > 0) {
            *self.0.entry(class).or_default() += u64::from(count);
        }
    }

    /// Adds the pixels of another part of the light field.
    pub fn merge(&mut self, other: &Self) {
        for (class, count) in &other.0 {
            *self.0.entry(*class).or_default() += count;
        }
    }

    /// The error that this part of the pixels with noise, 0 to 1, is below; `None` without pixels. Pixels with an error below
    /// 0.01 %, which see black or a smooth sky, are left out, as long as there are others: else a small object before a sky
    /// has no error.
    #[must_use]
    pub fn quantile(&self, part: f64) -> Option<f64> {
        let least = class(LEAST_NOISE);
        let has_noise = self.0.keys().any(|class| *class >= least);
        let noisy = || self.0.iter().filter(|(class, _)| **class >= least || !has_noise);
        let count: u64 = noisy().map(|(_, pixels)| pixels).sum();
        let rank = (part.clamp(0.0, 1.0) * count.saturating_sub(1) as f64).round() as u64;
        let mut below = 0;
        let found = noisy().find(|(_, pixels)| {
            below += **pixels;
            rank < below
        });
        found.map(|(class, _)| middle(*class))
    }

    /// The classes with their numbers of pixels, for [`Self::from_counts`].
    pub fn counts(&self) -> impl Iterator<Item = (u16, u64)> {
        self.0.iter().map(|(class, count)| (*class, *count))
    }

    /// The distribution with these [`counts`](Self::counts).
    #[must_use]
    pub fn from_counts(counts: impl IntoIterator<Item = (u16, u64)>) -> Self {
        Self(counts.into_iter().collect())
    }
}

/// The class of an error: its exponent, and the first bits of its mantissa.
#[inline]
fn class(error: f32) -> u16 {
    let error = if error.is_nan() { f32::INFINITY } else { error.max(0.0) };
    (error.to_bits() >> (f32::MANTISSA_DIGITS - 1 - MANTISSA_BITS)) as u16
}

/// The error in the middle of a class; 0 and infinity are classes of their own.
fn middle(class: u16) -> f64 {
    let bits = u32::from(class) << (f32::MANTISSA_DIGITS - 1 - MANTISSA_BITS);
    let half = 1 << (f32::MANTISSA_DIGITS - 2 - MANTISSA_BITS);
    let low = f32::from_bits(bits);
    let is_alone = low == 0.0 || low.is_infinite();
    f64::from(if is_alone { low } else { f32::from_bits(bits + half) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_within_the_stated_accuracy() {
        let errors: Vec<f32> = (0..10_001).map(|k| 1e-4 * (k as f32 * 1e-3).exp()).collect();
        let mut all = ErrorDistribution::default();
        all.extend(&errors);
        for (part, k) in [(0.0, 0), (0.1, 1000), (0.5, 5000), (0.9, 9000), (1.0, 10_000)] {
            let found = all.quantile(part).expect("pixels");
            assert!((found / f64::from(errors[k]) - 1.0).abs() < 0.016, "{part}: {found}, {}", errors[k]);
        }
    }

    #[test]
    fn pixels_without_noise_do_not_hide_those_with_some() {
        let mut distribution = ErrorDistribution::default();
        assert_eq!(distribution.quantile(0.5), None);
        distribution.extend(&[0.0; 90]);
        assert_eq!(distribution.quantile(0.5), Some(0.0));
        // A smooth sky.
        distribution.extend(&[2e-5; 90]);
        distribution.extend(&[0.2; 10]);
        assert!((distribution.quantile(0.01).expect("pixels") / 0.2 - 1.0).abs() < 0.016);
    }

    #[test]
    fn parts_add_up_to_the_whole() {
        let errors = [0.0, 1e-3, 0.02, 0.02, 0.5, f32::INFINITY, f32::NAN];
        let (mut whole, mut parts, mut last) = <(ErrorDistribution, ErrorDistribution, ErrorDistribution)>::default();
        whole.extend(&errors);
        parts.extend(&errors[..3]);
        errors[3..].iter().for_each(|error| last.add(*error));
        parts.merge(&last);
        assert_eq!(parts, whole);
        assert_eq!(ErrorDistribution::from_counts(whole.counts()), whole);
        assert_eq!(whole.quantile(1.0), Some(f64::INFINITY));
        assert!((whole.quantile(0.0).expect("pixels") / 1e-3 - 1.0).abs() < 0.016);
        assert_eq!(ErrorDistribution::default().quantile(0.5), None);
    }
}
