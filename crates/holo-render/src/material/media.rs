//! Media: what bodies of glass are filled with, and the stack of media around a path.
//!
//! A path that enters a body of glass is in its medium until it leaves it. Bodies may contain others (a bubble or a
//! stone in glass, glass in water): entering puts a medium on top of the stack, leaving takes it off, wherever it is.
//! The top absorbs (Beer-Lambert law), and surfaces inside see its index of refraction. The stack has four places; the
//! outermost media of deeper bodies are forgotten. Paths begin in air.

use crate::simd::LANES;

/// A number of a medium of [`Appearance`](super::Appearance), from 1; 0 is air.
pub(crate) type MediumId = u16;

/// The largest number of media with different properties.
pub(crate) const MAX_MEDIA: usize = MediumId::MAX as usize;

/// Dominant wavelengths of red, green and blue of sRGB, nm.
const DOMINANT_NM: [f32; 3] = [611.4, 549.1, 464.2];

/// Cauchy's equation with two terms: n - n(yellow) = (n(yellow) - 1) / Abbe number * (this / wavelength^2 - its value
/// at 587.6 nm), so that the blue and red lines of hydrogen (486.1 and 656.3 nm) differ by (n - 1) / Abbe number.
const CAUCHY_NM2: f32 = 523_655.0;
const CAUCHY_AT_YELLOW: f32 = 1.5168;

/// A medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Medium {
    /// Index of refraction for yellow light (587.6 nm).
    pub ior: f32,
    /// 20 / Abbe number, KHR_materials_dispersion.
    pub dispersion: f32,
    /// Absorption coefficient, 1/m, linear RGB.
    pub absorption: [f32; 3],
}

impl Medium {
    pub const AIR: Self = Self { ior: 1.0, dispersion: 0.0, absorption: [0.0; 3] };

    /// The index of refraction of a channel: Cauchy's equation through that of yellow light with the Abbe number of
    /// the medium, as in KHR_materials_dispersion, at the dominant wavelengths of the primaries of sRGB; at least 1.
    pub fn ior_of(&self, channel: usize) -> f32 {
        if self.dispersion == 0.0 {
            return self.ior;
        }
        let offset = CAUCHY_NM2 / (DOMINANT_NM[channel] * DOMINANT_NM[channel]) - CAUCHY_AT_YELLOW;
        (self.ior + (self.ior - 1.0) * self.dispersion * (1.0 / 20.0) * offset).max(1.0)
    }
}

/// The media around a point of a path, the innermost first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MediaStack(u64);

impl MediaStack {
    pub const AIR: Self = Self(0);
    const PLACE_BITS: u32 = MediumId::BITS;

    /// The innermost medium.
    #[inline(always)]
    pub fn top(self) -> MediumId {
        self.0 as MediumId
    }

    /// The stack after entering a body of `medium`.
    #[inline(always)]
    pub fn entered(self, medium: MediumId) -> Self {
        Self(self.0 << Self::PLACE_BITS | u64::from(medium))
    }

    /// The stack after leaving a body of `medium`; unchanged if the path was not inside one.
    #[inline(always)]
    pub fn left(self, medium: MediumId) -> Self {
        for place in 0..4 {
            let shift = place * Self::PLACE_BITS;
            if (self.0 >> shift) as MediumId == medium {
                let inner = self.0 & ((1_u64 << shift) - 1);
                let outer = self.0.checked_shr(shift + Self::PLACE_BITS).unwrap_or(0);
                return Self(inner | outer << shift);
            }
        }
        self
    }
}

/// Whether all sixteen points are in air.
#[inline(always)]
pub(crate) fn are_air(media: &[MediaStack; LANES]) -> bool {
    let mut all = 0;
    for lane in 0..LANES {
        all |= media[lane].0;
    }
    all == 0
}

/// The transmittance of `length` meters of sixteen media.
#[inline(always)]
pub(crate) fn transmittance(media: &[Medium; LANES], length: &[f32; LANES]) -> [[f32; LANES]; 3] {
    let mut out = [[1.0; LANES]; 3];
    for c in 0..3 {
        let mut optical_depth = [0.0; LANES];
        let mut any = false;
        for lane in 0..LANES {
            optical_depth[lane] = media[lane].absorption[c] * length[lane];
            // Also for NaN.
            any |= optical_depth[lane] != 0.0;
        }
        // Most glass is clear.
        if any {
            for lane in 0..LANES {
                out[c][lane] = exp_of_minus(optical_depth[lane]);
            }
        }
    }
    out
}

/// exp(-x) for x >= 0 with a relative error below 2e-7, bitwise identical on all machines; 0 above 87.
#[inline(always)]
fn exp_of_minus(x: f32) -> f32 {
    const LOG2_E: f64 = std::f64::consts::LOG2_E;
    // The sum with it is rounded to an integer, which is in the low bits of the sum. Conversions would saturate, which
    // is not vectorized well.
    const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
    let x = x.min(100.0);
    // 2^-(k + f) with f between -1/2 and 1/2; in f64, so that k * ln 2 loses no precision.
    let exponent = f64::from(x) * LOG2_E;
    let rounded = exponent + ROUND;
    let y = ((rounded - ROUND) - exponent) * std::f64::consts::LN_2;
    let power = 1.0
        + y * (1.0
            + y * (0.5
                + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (1.0 / 720.0 + y * (1.0 / 5040.0)))))));
    let k = rounded.to_bits().wrapping_sub(ROUND.to_bits());
    let scale = f64::from_bits(1023_u64.wrapping_sub(k) << 52);
    if x > 87.0 { 0.0 } else { (power * scale) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_left_in_any_order() {
        let in_three = MediaStack::AIR.entered(1).entered(2).entered(3);
        assert_eq!([in_three.top(), in_three.left(3).top(), in_three.left(2).top()], [3, 2, 3]);
        assert_eq!(in_three.left(2), MediaStack::AIR.entered(1).entered(3));
        assert_eq!(in_three.left(1).left(3).left(2), MediaStack::AIR);
        assert_eq!(in_three.left(9), in_three, "a body that was not entered");
        assert_eq!(MediaStack::AIR.left(4), MediaStack::AIR);
        // The outermost of five is forgotten.
        let in_five = in_three.entered(4).entered(5);
        assert_eq!(in_five.left(5).left(4).left(3).left(2), MediaStack::AIR);
        assert_eq!(in_five.left(2).top(), 5);
    }

    #[test]
    fn the_exponential_is_right() {
        for k in 0..87_000 {
            let x = k as f32 / 1000.0;
            let exact = (-f64::from(x)).exp();
            assert!((f64::from(exp_of_minus(x)) / exact - 1.0).abs() < 2e-7, "{x}");
        }
        assert_eq!([exp_of_minus(0.0), exp_of_minus(1e30)], [1.0, 0.0]);
    }
}
