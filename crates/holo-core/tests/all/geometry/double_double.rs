//! Double-double arithmetic, the reference for accuracy.
//!
//! A number is the unevaluated sum of two f64, good to about 2^-100 of itself: exact enough for the error of an f64 in
//! units in the last place.

use std::ops::{Add, Div, Mul, Sub};

#[derive(Debug, Clone, Copy)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

pub fn exact(value: f64) -> DoubleDouble {
    DoubleDouble { high: value, low: 0.0 }
}

/// The sum of two f64 without any error (Knuth).
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let b_part = high - a;
    DoubleDouble { high, low: (a - (high - b_part)) + (b - b_part) }
}

/// The product of two f64 without any error, by fused multiply-add.
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let high = a * b;
    DoubleDouble { high, low: a.mul_add(b, -high) }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let high = two_sum(self.high, other.high);
        let low = two_sum(self.low, other.low);
        let sum = two_sum(high.high, high.low + low.high);
        two_sum(sum.high, sum.low + low.low)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self { high: -other.high, low: -other.low }
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.high, other.high);
        two_sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        // Long division, three digits of f64 each.
        let first = self.high / other.high;
        let rest = self - other * exact(first);
        let second = rest.high / other.high;
        let rest = rest - other * exact(second);
        let third = rest.high / other.high;
        exact(first) + exact(second) + exact(third)
    }
}

/// The distance of `value` from `reference`, in units in the last place of the reference.
pub fn ulps(value: f64, reference: DoubleDouble) -> f64 {
    let nearest = reference.high.abs();
    let unit = nearest.next_up() - nearest;
    ((value - reference.high) - reference.low).abs() / unit
}
