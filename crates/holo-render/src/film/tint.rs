//! Tints: the part of the light that a surface reflects, by color, as its material says.
//!
//! Light divided by the tint is what would fall on a white surface there: it is smooth where textures are not. (Demodulation;
//! Zwicker et al., "Recent Advances in Adaptive Sampling and Reconstruction for Monte Carlo Rendering", 2015.)

use crate::material::SurfaceInteraction;
use crate::simd::LANES;

/// What a surface of any color reflects without being tinted: the reflectance of glass, or of a varnish, of index 1.5.
const UNTINTED: f32 = 0.04;

/// The smallest and the largest tint that can be packed.
const RANGE: [f32; 2] = [1.0 / 32.0, 1.99];

/// Bits of a packed color, of which seven are of the mantissa.
const BITS: u32 = 10;

/// The bits of the smallest tint, and the first ones of an f32 that is neither 0 nor denormal.
const ZERO: u32 = RANGE[0].to_bits();
const NORMAL: u32 = f32::MIN_POSITIVE.to_bits();

/// Those of hits; of what is not hit 1, as emission and the sky are not tinted.
#[inline(always)]
pub(crate) fn of(found: Option<&SurfaceInteraction>) -> [[f32; LANES]; 3] {
    let mut out = [[1.0; LANES]; 3];
    let Some(interaction) = found else { return out };
    for c in 0..3 {
        for lane in 0..LANES {
            let tint = interaction.base_color[c][lane] + UNTINTED;
            out[c][lane] = if interaction.hit[lane] { tint } else { 1.0 };
        }
    }
    out
}

/// Packs a tint into one number that is kept by copies and multiplications by 1.
///
/// # Accuracy
/// 0.4 %, from 1/32 to 1.99.
#[inline(always)]
pub(crate) fn pack(tint: [f32; 3]) -> f32 {
    let mut bits = 0;
    for color in tint {
        let color = color.clamp(RANGE[0], RANGE[1]);
        let code = (color.to_bits() - ZERO + (1 << 15)) >> 16;
        bits = bits << BITS | code;
    }
    f32::from_bits(bits + NORMAL)
}

/// The tint that was packed.
#[inline(always)]
pub(crate) fn unpack(packed: f32) -> [f32; 3] {
    let bits = packed.to_bits().saturating_sub(NORMAL);
    let color = |k: u32| f32::from_bits(((bits >> (k * BITS) & ((1 << BITS) - 1)) << 16) + ZERO);
    [color(2), color(1), color(0)]
}

/// The mean of two packed tints, of which the first has this part.
#[inline(always)]
pub(crate) fn mixed(first: f32, second: f32, part: f32) -> f32 {
    let [a, b] = [unpack(first), unpack(second)];
    pack([0, 1, 2].map(|c| a[c] * part + b[c] * (1.0 - part)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_tints_are_kept() {
        for k in 0..2000u32 {
            let tint = [0, 7, 13].map(|step| 0.032 + ((k * 37 + step * 101) % 1950) as f32 / 1000.0);
            let packed = pack(tint);
            assert!(packed.is_normal() && packed * 1.0 == packed);
            for (a, b) in tint.into_iter().zip(unpack(packed)) {
                assert!((a / b - 1.0).abs() < 0.004, "{a} {b}");
            }
            for (a, b) in unpack(packed).into_iter().zip(unpack(mixed(packed, packed, 0.3))) {
                assert!((a / b - 1.0).abs() < 1e-6);
            }
        }
        assert_eq!(unpack(pack([0.0, 1.0, 3.0]))[..2], [1.0 / 32.0, 1.0]);
    }
}
