//! Trigonometric functions of a single lane, for loops over lanes: branch-free polynomials that are bitwise identical
//! on all machines (those of the C library are not).
//!
//! All angles are in rad. Errors are absolute and hold for every input of the stated range; the tests assert them.

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// tan(pi/8), the end of the range of the arc tangent polynomial.
const TAN_PI_8: f32 = 0.414_213_57;

/// Sine and cosine up to a quarter of pi, within 1.2e-7 (Taylor).
#[inline(always)]
pub(crate) fn sin_cos_quarter(x: f32) -> (f32, f32) {
    let s = x * x;
    let sin = x * (1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s * (1.0 / 362_880.0)))));
    let cos = 1.0 + s * (-0.5 + s * (1.0 / 24.0 + s * (-1.0 / 720.0 + s * (1.0 / 40320.0))));
    (sin, cos)
}

/// Sine and cosine up to two turns (4 pi) either way, within 2e-7. The sine of a signed zero is that zero.
#[inline(always)]
pub(crate) fn sin_cos(x: f32) -> (f32, f32) {
    // A quarter turn in two parts: a whole multiple of the first has few enough bits to be exact.
    const HIGH: f32 = 201.0 / 128.0;
    const LOW: f32 = 4.838_268e-4;
    let quarters = (x * FRAC_2_PI + 0.5).floor();
    let (sin, cos) = sin_cos_quarter((x - quarters * HIGH) - quarters * LOW);
    let turned = quarters as i32;
    let odd = turned & 1 != 0;
    let (s, c) = if odd { (cos, sin) } else { (sin, cos) };
    let s = if turned & 2 != 0 { -s } else { s };
    let c = if (turned + 1) & 2 != 0 { -c } else { c };
    (s, c)
}

/// The angle of the point (x, y) in rad, from -pi to pi, within 2e-7.
///
/// Zeros have the signs of IEEE 754: (y, x) = (+-0, 1) gives +-0, (+-0, -1) gives +-pi, (+-0, -0) gives +-pi; the axes
/// give exactly +-pi/2. The coordinates must be finite and below 1e38; they may be arbitrarily small.
#[inline(always)]
pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    let (a, b) = (y.abs(), x.abs());
    let (small, large) = (a.min(b), a.max(b));
    // atan(t) = pi/4 + atan((t - 1) / (t + 1)) halves the range once more for the same one division.
    let steep = small > TAN_PI_8 * large;
    let numerator = if steep { small - large } else { small };
    let denominator = if steep { small + large } else { large };
    let t = if denominator > 0.0 { numerator / denominator } else { 0.0 };
    let s = t * t;
    // Minimax over |t| <= tan(pi/8), off by 5.3e-9.
    let series = s * (-0.333_327_56 + s * (0.199_718_79 + s * (-0.138_244_54 + s * 0.079_025_98)));
    let octant = (t + t * series) + if steep { FRAC_PI_4 } else { 0.0 };
    // The nearest axis, from which the octant is counted, plus the rounding error of its f32 value.
    let (upright, leftward) = (a > b, x.is_sign_negative());
    let axis = if leftward { PI } else { 0.0 };
    let axis = if upright { FRAC_PI_2 } else { axis };
    let rest = axis * (-8.742_278e-8 / PI);
    let counted = if upright != leftward { -octant } else { octant };
    (axis + (rest + counted)).copysign(y)
}

/// `1 - cos(angle)` in f64 for angles from 0 to pi/2, within a relative 1e-15, also where the cosine is close to 1.
pub(crate) fn versine(angle: f64) -> f64 {
    // 2 sin^2(angle / 2), the sine by its Taylor series to x^19: the rest is below 1e-20 at pi/4.
    let x = 0.5 * angle;
    let s = x * x;
    let mut series = 0.0;
    for k in (1..=9u32).rev() {
        series = -s / f64::from(2 * k * (2 * k + 1)) * (1.0 + series);
    }
    let sine = x + x * series;
    2.0 * sine * sine
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::LANES;
    use crate::simd::{Kernel, run_on_all};

    /// Angles all around, in steps that no other number here divides.
    fn turns() -> impl Iterator<Item = f64> {
        (-100_000..=100_000).map(|k| f64::from(k) * std::f64::consts::PI / 100_000.0)
    }

    #[test]
    fn sines_and_cosines_are_right() {
        for angle in turns() {
            for x in [angle as f32, 4.0 * angle as f32] {
                let (sin, cos) = sin_cos(x);
                assert!((f64::from(sin) - f64::from(x).sin()).abs() < 2e-7, "sin {x}");
                assert!((f64::from(cos) - f64::from(x).cos()).abs() < 2e-7, "cos {x}");
            }
            let x = 0.25 * angle as f32;
            let (sin, cos) = sin_cos_quarter(x);
            assert!((f64::from(sin) - f64::from(x).sin()).abs() < 1.2e-7, "quarter sin {x}");
            assert!((f64::from(cos) - f64::from(x).cos()).abs() < 1.2e-7, "quarter cos {x}");
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!(sin_cos(-0.0).0.is_sign_negative());
    }

    #[test]
    fn arc_tangents_are_right_at_every_length() {
        for angle in turns() {
            for length in [1e-30, 1e-3, 1.0, 7.3, 1e30] {
                let (x, y) = ((angle.cos() * length) as f32, (angle.sin() * length) as f32);
                let error = f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x));
                assert!(error.abs() < 2e-7, "atan2({y}, {x}) is off by {error}");
            }
        }
    }

    #[test]
    fn the_axes_and_signed_zeros_are_exact() {
        let cases = [
            (0.0, 1.0, 0.0),
            (-0.0, 1.0, -0.0),
            (0.0, -1.0, PI),
            (-0.0, -1.0, -PI),
            (1.0, 0.0, FRAC_PI_2),
            (1.0, -0.0, FRAC_PI_2),
            (-1.0, 0.0, -FRAC_PI_2),
            (0.0, 0.0, 0.0),
            (-0.0, 0.0, -0.0),
            (0.0, -0.0, PI),
            (-0.0, -0.0, -PI),
        ];
        for (y, x, expected) in cases {
            assert_eq!(atan2(y, x).to_bits(), f32::to_bits(expected), "atan2({y}, {x}) = {}", atan2(y, x));
        }
    }

    /// Against the same quantity from the library's sine of the half angle, which is good to 1e-16.
    #[test]
    fn the_versine_is_right_where_the_cosine_has_no_digits_left() {
        for k in 1..=1000 {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / 1000.0;
            for angle in [angle, angle * 1e-6] {
                let expected = 2.0 * (angle / 2.0).sin().powi(2);
                assert!((versine(angle) / expected - 1.0).abs() < 1e-15, "{angle}");
            }
        }
        assert_eq!(versine(0.0), 0.0);
    }

    struct All([f32; LANES], [f32; LANES]);

    impl Kernel for All {
        type Output = [[u32; LANES]; 3];

        #[inline(always)]
        fn run(self) -> Self::Output {
            let mut out = [[0; LANES]; 3];
            for lane in 0..LANES {
                let (x, y) = (self.0[lane], self.1[lane]);
                let (sin, cos) = sin_cos(x);
                out[0][lane] = sin.to_bits();
                out[1][lane] = cos.to_bits();
                out[2][lane] = atan2(y, x).to_bits();
            }
            out
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        for k in 0..2000u32 {
            let x = std::array::from_fn(|lane| (k as f32 - 1000.0) * 0.003 + lane as f32 * 1e-4);
            let y = std::array::from_fn(|lane| 2.0 - (k * 16 + lane as u32) as f32 * 1.3e-4);
            let results = run_on_all(|| All(x, y));
            assert!(results.iter().all(|r| *r == results[0]));
        }
    }
}
