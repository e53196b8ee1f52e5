//! The sRGB transfer curve (IEC 61966-2-1) in both directions: display codes to linear light and back.
//!
//! Values are relative: 0 is black, 1 is the white of a display. The functions in `f64` follow the standard. The table
//! and [`Srgb8Encoder`] are faster and have equal results for every input.

use std::sync::OnceLock;

/// How the samples of an image or a light field represent light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum ColorEncoding {
    /// Color or gray on the sRGB curve, the usual input of displays. A PNG has an `sRGB` chunk.
    #[default]
    Srgb,
    /// Values proportional to a quantity: radiance, or a quantity other than light, such as disparity. A PNG names no
    /// color space.
    Linear,
}

/// Returns the linear light of an sRGB value, both from 0 to 1.
///
/// # Source
///
/// IEC 61966-2-1.
#[must_use]
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Returns the sRGB value of linear light, both from 0 to 1. Input outside that range is clamped; NaN gives 0.
///
/// # Source
///
/// IEC 61966-2-1.
#[must_use]
pub fn linear_to_srgb(linear: f64) -> f64 {
    let x = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Returns the linear light of every 8-bit sRGB code.
///
/// # Accuracy
///
/// Computed in `f64` and rounded to `f32` once.
#[must_use]
pub fn srgb8_to_linear_table() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|code| srgb_to_linear(code as f64 / 255.0) as f32))
}

/// An encoder from linear light to 8-bit sRGB codes that uses a table.
///
/// Its reference implementation is [`linear_to_srgb8`]; the results are equal for every `f32`.
pub struct Srgb8Encoder {
    /// The code of the smallest value of every bucket. A bucket is one exponent with the first 8 bits of the mantissa.
    /// Every bucket is narrower than a code, so it contains at most one threshold.
    first: Vec<u8>,
    /// The smallest `f32` of code k, for k = 1..=255; then infinity.
    threshold: Vec<f32>,
}

const DROPPED_BITS: u32 = 15;

impl Srgb8Encoder {
    /// Returns the encoder. Its table is computed once per process.
    #[must_use]
    pub fn get() -> &'static Self {
        static ENCODER: OnceLock<Srgb8Encoder> = OnceLock::new();
        ENCODER.get_or_init(Self::build)
    }

    fn build() -> Self {
        let threshold = (1..=255u32)
            .map(|code| {
                // Positive floats have the order of their bits: bisect for the first that rounds to `code`.
                let (mut low, mut high) = (0u32, 1.0f32.to_bits());
                while low < high {
                    let middle = low + (high - low) / 2;
                    if linear_to_srgb8(f32::from_bits(middle)) as u32 >= code {
                        high = middle
                    } else {
                        low = middle + 1
                    }
                }
                f32::from_bits(low)
            })
            .chain([f32::INFINITY])
            .collect();
        let last = 1.0f32.to_bits() >> DROPPED_BITS;
        let first = (0..=last).map(|bucket| linear_to_srgb8(f32::from_bits(bucket << DROPPED_BITS))).collect();
        Self { first, threshold }
    }

    /// Returns the 8-bit sRGB code of linear light. Input outside 0 to 1 is clamped; NaN gives 0.
    #[inline(always)]
    #[must_use]
    pub fn encode(&self, x: f32) -> u8 {
        // NaN compares false and becomes 0, as in the reference implementation.
        let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
        let code = self.first[(x.to_bits() >> DROPPED_BITS) as usize];
        code + u8::from(x >= self.threshold[code as usize])
    }
}

/// Returns the 8-bit sRGB code of linear light. Input outside 0 to 1 is clamped; NaN gives 0.
///
/// # Accuracy
///
/// Computed in `f64` and rounded to nearest once.
#[must_use]
pub fn linear_to_srgb8(x: f32) -> u8 {
    (linear_to_srgb(f64::from(x)) * 255.0).round() as u8
}

/// Returns the 16-bit sRGB code of linear light; as [`linear_to_srgb8`].
#[must_use]
pub fn linear_to_srgb16(x: f32) -> u16 {
    (linear_to_srgb(f64::from(x)) * 65535.0).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_formula() {
        let encoder = Srgb8Encoder::get();
        let check = |x: f32| assert_eq!(encoder.encode(x), linear_to_srgb8(x), "{x:e}");
        for x in [0.0, -0.0, -1.0, 1.0, 1.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE, 1e-45] {
            check(x);
        }
        for &t in &encoder.threshold[..255] {
            check(t);
            check(t.next_down());
        }
        for bits in (0..1.01f32.to_bits()).step_by(9973) {
            check(f32::from_bits(bits));
        }
    }

    #[test]
    fn codes_round_trip() {
        for code in 0..=255u8 {
            assert_eq!(linear_to_srgb8(srgb8_to_linear_table()[code as usize]), code);
        }
    }
}
