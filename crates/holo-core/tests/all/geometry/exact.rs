//! Exact arithmetic: an f64 is an integer times a power of two, and so are sums and products of such numbers.
//!
//! A quotient is not, but the error of one can be computed without division: x is within n units of a/b if |x b - a| <=
//! n unit b.

use std::ops::{Mul, Sub};

use num_bigint::BigInt;

/// mantissa * 2^exponent.
#[derive(Debug, Clone)]
pub struct Exact {
    mantissa: BigInt,
    exponent: i32,
}

impl Exact {
    /// A finite number.
    pub fn new(value: f64) -> Self {
        let bits = value.to_bits();
        let (biased, fraction) = ((bits >> 52 & 0x7FF) as i32, bits & ((1 << 52) - 1));
        assert_ne!(biased, 0x7FF, "{value} is not finite");
        // Subnormal numbers have no hidden bit.
        let (mantissa, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        let mantissa = BigInt::from(mantissa);
        Self { mantissa: if value < 0.0 { -mantissa } else { mantissa }, exponent }
    }

    pub fn abs(self) -> Self {
        Self { mantissa: self.mantissa.magnitude().clone().into(), ..self }
    }

    /// The mantissa for another exponent that is no larger.
    fn scaled(&self, exponent: i32) -> BigInt {
        &self.mantissa << (self.exponent - exponent) as u32
    }

    pub fn is_at_most(&self, other: &Self) -> bool {
        (self.clone() - other.clone()).mantissa <= BigInt::ZERO
    }
}

impl Mul for Exact {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { mantissa: self.mantissa * other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl Sub for Exact {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        let exponent = self.exponent.min(other.exponent);
        Self { mantissa: self.scaled(exponent) - other.scaled(exponent), exponent }
    }
}

/// Whether `value` is within `units` units in the last place of the quotient; both are above 0 in magnitude.
pub fn is_within(value: f64, units: f64, numerator: Exact, denominator: Exact) -> bool {
    // Of the two neighbors the nearer one: below a power of two units are half as large.
    let unit = value.abs() - value.abs().next_down();
    let off = Exact::new(value) * denominator.clone() - numerator;
    off.abs().is_at_most(&(Exact::new(units * unit) * denominator.abs()))
}

#[test]
fn thirds_are_within_half_a_unit() {
    let third: f64 = 1.0 / 3.0;
    let within = |value, units| is_within(value, units, Exact::new(1.0), Exact::new(3.0));
    assert!(within(third, 0.5) && within(-third, 0.5) == within(third, -0.5));
    assert!(!within(third.next_up(), 0.5) && within(third.next_up(), 1.0));
    assert!(is_within(f64::MIN_POSITIVE / 8.0, 0.0, Exact::new(f64::MIN_POSITIVE), Exact::new(8.0)));
}
