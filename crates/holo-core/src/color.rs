//! The sRGB transfer curve (IEC 61966-2-1) in both directions: display codes to linear light and back.
//!
//! Values are relative: 0 is black, 1 the brightest that a display shows. The functions in f64 are the definition; the table
//! and [`Srgb8Encoder`] are the fast forms, equal to it for every input.

use std::sync::OnceLock;

/// How the samples of an image or a light field represent light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum ColorEncoding {
    /// Color or gray on the sRGB curve, as displays take it. A PNG says so in its `sRGB` chunk.
    #[default]
    Srgb,
    /// Values proportional to what they measure: radiance, or a quantity that is no light, such as disparity. A PNG claims
    /// no color space.
    Linear,
}

/// Linear light of an encoded value, both 0 to 1.
#[must_use]
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encoded value of linear light, both 0 to 1; what lies outside is clamped, NaN is 0.
#[must_use]
pub fn linear_to_srgb(linear: f64) -> f64 {
    let x = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The linear light of every 8-bit code, rounded to f32 once.
#[must_use]
pub fn srgb8_to_linear_table() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|code| srgb_to_linear(code as f64 / 255.0) as f32))
}

/// 8-bit encoding by table. The reference implementation is [`linear_to_srgb8`]; the result is the same for every f32.
pub struct Srgb8Encoder {
    /// The code of the smallest value of every bucket. A bucket is one exponent and the first 8 bits of the mantissa:
    /// narrower than a code everywhere, so that it holds at most one threshold.
    first: Vec<u8>,
    /// The smallest f32 that has code k, for k = 1..=255; then infinity.
    threshold: Vec<f32>,
}

const DROPPED_BITS: u32 = 15;

impl Srgb8Encoder {
    /// The encoder; its table is computed once.
    #[must_use]
    pub fn get() -> &'static Self {
        static ENCODER: OnceLock<Srgb8Encoder> = OnceLock::new();
        ENCODER.get_or_init(Self::build)
    }

    fn build() -> Self {
        let threshold = (1..=255u32)
            .map(|code| {
                // Positive floats are ordered like their bits: bisect for the first that rounds to `code`.
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

    /// The code of linear light `x`.
    #[inline(always)]
    #[must_use]
    pub fn encode(&self, x: f32) -> u8 {
        // NaN compares false and becomes 0, as in the naive form.
        let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
        let code = self.first[(x.to_bits() >> DROPPED_BITS) as usize];
        code + u8::from(x >= self.threshold[code as usize])
    }
}

/// The 8-bit code of linear light.
#[must_use]
pub fn linear_to_srgb8(x: f32) -> u8 {
    (linear_to_srgb(f64::from(x)) * 255.0).round() as u8
}

/// The 16-bit code of linear light.
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
    fn codes_survive_the_round_trip() {
        for code in 0..=255u8 {
            assert_eq!(linear_to_srgb8(srgb8_to_linear_table()[code as usize]), code);
        }
    }
}
