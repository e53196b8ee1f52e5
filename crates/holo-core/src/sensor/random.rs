//! Random numbers that every machine computes equally: functions of a key, by + - * / and square roots alone, which
//! IEEE 754 defines to the last bit. (Library functions such as `ln` differ between systems.)

/// A mean above which a Poisson number is a rounded normal one.
///
/// # Accuracy
///
/// Mean within 1e-3; variance larger by 0.14, 5e-4 of the least mean; skewness to second order.
const LARGE_MEAN: f64 = 256.0;

/// What a random number is for. Numbers of different purposes are independent.
#[derive(Clone, Copy)]
pub(crate) enum Purpose {
    Photons = 1,
    Read,
    Row,
    Response,
    Offset,
    Column,
    Hot,
    HotRate,
    CameraPosition,
    CameraRotation,
    CameraFocal,
    CameraGain,
    CameraColor,
    CameraTime,
}

/// A family of random numbers: one for every place.
#[derive(Clone, Copy)]
pub(crate) struct Stream(u64);

impl Stream {
    pub fn new(seed: u64, frame: u64, purpose: Purpose) -> Self {
        Self(mixed(mixed(mixed(seed) ^ frame) ^ purpose as u64))
    }

    /// Evenly distributed over (0, 1), in steps of 2^-53.
    #[inline]
    pub fn uniform(self, place: u64) -> f64 {
        ((mixed(self.0 ^ place) >> 11) as f64 + 0.5) * (1.0 / (1u64 << 53) as f64)
    }

    /// Normally distributed, of mean 0 and variance 1.
    #[inline]
    pub fn normal(self, place: u64) -> f64 {
        inverse_normal(self.uniform(place))
    }

    /// Poisson distributed: the number of electrons where `mean` are expected.
    #[inline]
    pub fn poisson(self, place: u64, mean: f64) -> f64 {
        if mean >= LARGE_MEAN {
            let z = self.normal(place);
            return (mean + mean.sqrt() * z + (z * z - 1.0) / 6.0).round();
        }
        if mean <= 0.0 {
            return 0.0;
        }
        poisson_inverse(self.uniform(place), mean)
    }
}

/// The finalizer of SplitMix64 (Steele, Lea and Flood, 2014), whose input is a counter.
#[inline]
fn mixed(counter: u64) -> u64 {
    let z = counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The smallest number whose cumulative probability exceeds `u`, by the recurrence p(k + 1) = p(k) mean / (k + 1).
fn poisson_inverse(u: f64, mean: f64) -> f64 {
    let mut probability = exp(-mean);
    let mut cumulative = probability;
    let mut k = 0.0;
    // Rounding keeps the sum a little below 1 for ever: the bound is never reached by another number.
    while cumulative < u && k < 10.0 * LARGE_MEAN {
        k += 1.0;
        probability *= mean / k;
        cumulative += probability;
    }
    k
}

/// The value below which a normal number lies with this probability.
///
/// # Source
///
/// Wichura (1988), Algorithm AS 241, PPND16.
///
/// # Accuracy
///
/// 1e-14, relative.
fn inverse_normal(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return rational(q, 0.180_625 - q * q, &CENTER);
    }
    let r = (-ln(p.min(1.0 - p))).sqrt();
    let value = if r <= 5.0 { rational(1.0, r - 1.6, &TAIL) } else { rational(1.0, r - 5.0, &FAR_TAIL) };
    if q < 0.0 { -value } else { value }
}

/// Numerator and denominator, from the highest power.
type Rational = [[f64; 8]; 2];

#[inline]
fn rational(factor: f64, x: f64, [numerator, denominator]: &Rational) -> f64 {
    let polynomial = |all: &[f64; 8]| all[1..].iter().fold(all[0], |sum, c| sum * x + c);
    polynomial(numerator) * factor / polynomial(denominator)
}

#[rustfmt::skip]
const CENTER: Rational = [
    [2.509_080_928_730_122_7e3, 3.343_057_558_358_813e4, 6.726_577_092_700_87e4, 4.592_195_393_154_987e4,
     1.373_169_376_550_946e4, 1.971_590_950_306_551_3e3, 1.331_416_678_917_843_8e2, 3.387_132_872_796_366_5],
    [5.226_495_278_852_854e3, 2.872_908_573_572_194_3e4, 3.930_789_580_009_271e4, 2.121_379_430_158_659_7e4,
     5.394_196_021_424_751e3, 6.871_870_074_920_579e2, 4.231_333_070_160_091e1, 1.0],
];

#[rustfmt::skip]
const TAIL: Rational = [
    [7.745_450_142_783_414e-4, 2.272_384_498_926_918_4e-2, 2.417_807_251_774_506e-1, 1.270_458_252_452_368_4,
     3.647_848_324_763_204_5, 5.769_497_221_460_691, 4.630_337_846_156_546, 1.423_437_110_749_683_5],
    [1.050_750_071_644_416_9e-9, 5.475_938_084_995_345e-4, 1.519_866_656_361_645_7e-2, 1.481_039_764_274_800_8e-1,
     6.897_673_349_851e-1, 1.676_384_830_183_803_8, 2.053_191_626_637_759, 1.0],
];

#[rustfmt::skip]
const FAR_TAIL: Rational = [
    [2.010_334_399_292_288_1e-7, 2.711_555_568_743_487_6e-5, 1.242_660_947_388_078_4e-3, 2.653_218_952_657_612_4e-2,
     2.965_605_718_285_048_7e-1, 1.784_826_539_917_291_3, 5.463_784_911_164_114, 6.657_904_643_501_103],
    [2.044_263_103_389_939_8e-15, 1.421_511_758_316_446e-7, 1.846_318_317_510_054_8e-5, 7.868_691_311_456_133e-4,
     1.487_536_129_085_061_5e-2, 1.369_298_809_227_358e-1, 5.998_322_065_558_88e-1, 1.0],
];

/// The natural logarithm of a normal number above 0: that of its fraction in [1/sqrt 2, sqrt 2) by the series of
/// atanh, and its exponent.
///
/// # Accuracy
///
/// 1e-15 of the larger of the result and 1.
fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let mut exponent = ((bits >> 52) & 0x7ff) as i64 - 1023;
    let mut fraction = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
    if fraction > std::f64::consts::SQRT_2 {
        (fraction, exponent) = (fraction / 2.0, exponent + 1);
    }
    let s = (fraction - 1.0) / (fraction + 1.0);
    let square = s * s;
    // s^2 is at most 0.0295: eleven terms.
    let series = (0..11).rev().fold(0.0, |sum, k| sum * square + 1.0 / f64::from(2 * k + 1));
    2.0 * s * series + exponent as f64 * std::f64::consts::LN_2
}

/// e^x for |x| <= 700: a power of two, and the series of the exponential function.
///
/// # Accuracy
///
/// 1e-15 + |x| 2e-16, relative.
pub(super) fn exp(x: f64) -> f64 {
    /// ln 2 in two parts, the first of which has 20 trailing zero bits: its multiples are exact.
    const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
    let power = (x / std::f64::consts::LN_2).round();
    let rest = x - power * LN_2[0] - power * LN_2[1];
    // |rest| is at most 0.347: fourteen terms.
    let series = (1..=14).rev().fold(1.0, |sum, k| 1.0 + sum * rest / f64::from(k));
    series * f64::from_bits(((power as i64 + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_and_logarithm_are_those_of_the_library() {
        for k in -6990..=6990 {
            let x = f64::from(k) * 0.1;
            assert!((exp(x) / x.exp() - 1.0).abs() < 1e-15 + x.abs() * 2e-16, "exp {x}: {} {}", exp(x), x.exp());
            let y = x.exp();
            assert!((ln(y) - x).abs() < 1e-15 * x.abs().max(1.0), "ln {y}: {} {x}", ln(y));
        }
    }

    /// Values of the standard library of Python 3.11, `statistics.NormalDist().inv_cdf`.
    #[test]
    fn the_inverse_normal_distribution_has_known_values() {
        for (p, z) in PYTHON {
            let found = inverse_normal(p);
            assert!((found - z).abs() <= 1e-14 * z.abs(), "{p}: {found} {z}");
        }
    }

    const PYTHON: [(f64, f64); 13] = [
        (1e-16, -8.222_082_216_130_435),
        (1e-12, -7.034_483_825_301_132),
        (1e-7, -5.199_337_582_192_817),
        (0.001, -3.090_232_306_167_813),
        (0.0749, -1.440_238_267_527_963_2),
        (0.0751, -1.438_825_392_752_539_8),
        (0.3, -0.524_400_512_708_040_7),
        (0.4999, -0.000_250_662_830_088_007_5),
        (0.75, 0.674_489_750_196_081_7),
        (0.925, 1.439_531_470_938_456),
        (0.9251, 1.440_238_267_527_963_2),
        (0.999, 3.090_232_306_167_813),
        (0.999_999_999, 5.997_807_019_601_638),
    ];

    /// Bits that no machine may change, as a script in Python computes them: a change here changes every developed image.
    #[test]
    fn numbers_are_pinned() {
        let stream = Stream::new(7, 3, Purpose::Photons);
        let bits = |x: f64| x.to_bits();
        let found: Vec<u64> = (0..3u64).map(|k| bits(stream.normal(k << 40 | 5))).collect();
        let poisson: Vec<f64> = [0.3, 17.0, 255.9, 256.0, 1e4].iter().map(|&mean| stream.poisson(9, mean)).collect();
        assert_eq!(
            (found, poisson),
            (
                vec![0xbfec_5afb_92b6_70de, 0xbfdb_dcaa_d80e_8b60, 0xbff2_513c_9f29_4119],
                vec![1.0, 21.0, 270.0, 270.0, 10_087.0]
            )
        );
    }

    /// Mean and variance from 0.1 to 1e4 electrons, as sums of the inverse over evenly spaced u. Half a step of u is
    /// the error of every cumulative probability, and the mean has the sum of these errors: 5e-4 for 1e4 electrons,
    /// where five standard deviations either way are 1000 numbers.
    #[test]
    fn poisson_numbers_have_their_mean_and_variance() {
        const COUNT: u64 = 1 << 20;
        for mean in [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 200.0, 255.0, 256.0, 300.0, 1e3, 1e4] {
            let (mut sum, mut squares) = (0.0, 0.0);
            for k in 0..COUNT {
                let u = (k as f64 + 0.5) / COUNT as f64;
                let value = if mean < LARGE_MEAN {
                    poisson_inverse(u, mean)
                } else {
                    let z = inverse_normal(u);
                    (mean + mean.sqrt() * z + (z * z - 1.0) / 6.0).round()
                };
                sum += value - mean;
                squares += (value - mean) * (value - mean);
            }
            let (bias, variance) = (sum / COUNT as f64, squares / COUNT as f64);
            assert!(bias.abs() < 1e-3 * mean.min(1.0), "{mean}: mean off by {bias}");
            assert!((variance / mean - 1.0).abs() < 1e-3, "{mean}: variance {variance}");
        }
    }

    /// Streams: neighboring places, frames and purposes are uncorrelated.
    #[test]
    fn streams_are_independent() {
        const COUNT: u64 = 1 << 16;
        let base = Stream::new(1, 0, Purpose::Read);
        let others =
            [Stream::new(1, 1, Purpose::Read), Stream::new(2, 0, Purpose::Read), Stream::new(1, 0, Purpose::Row)];
        let mean = |value: &dyn Fn(u64) -> f64| (0..COUNT).map(value).sum::<f64>() / COUNT as f64;
        // Five standard errors of 2^16 products.
        let bound = 5.0 / (COUNT as f64).sqrt();
        assert!(mean(&|k| base.normal(k)).abs() < bound);
        assert!(mean(&|k| base.normal(k) * base.normal(k + 1)).abs() < bound);
        assert!(mean(&|k| base.normal(k) * base.normal(k + (1 << 32))).abs() < bound);
        for other in others {
            assert!(mean(&|k| base.normal(k) * other.normal(k)).abs() < bound);
        }
    }
}
