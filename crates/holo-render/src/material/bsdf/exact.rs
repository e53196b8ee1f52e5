//! Fresnel's equations and refraction in scalar f64: a reference implementation for tests.
//!
//! # Accuracy
//! Reflectance and transmittance have an error of 1e-15 for the given cosine and index, at any angle including the
//! critical one. The transmittance keeps its relative accuracy towards grazing incidence, where it approaches 0.

/// Fresnel's equations at one angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    pub reflected: f64,
    /// 1 - `reflected`, accurate where it is small.
    pub transmitted: f64,
    /// The cosine of the refracted ray with the normal, times n; 0 for total internal reflection.
    pub scaled_cosine: f64,
}

/// Fresnel's equations at the cosine `c`; `n` is the index of refraction behind the surface relative to that in front.
pub(super) fn interface(c: f64, n: f64) -> Interface {
    // n^2 - 1 + c^2 cancels near the critical angle: squares and sums are computed with their rounding errors.
    let (c_square, c_error) = square(c);
    let (n_square, n_error) = square(n);
    let (difference, first_error) = sum(n_square, -1.0);
    let (total, second_error) = sum(difference, c_square);
    let g_square = total + (first_error + second_error + c_error + n_error);
    if g_square <= 0.0 {
        return Interface { reflected: 1.0, transmitted: 0.0, scaled_cosine: 0.0 };
    }
    let g = g_square.sqrt();
    let (across, along) = (c + g, n * n * c + g);
    let (s, p) = ((c - g) / across, (n * n * c - g) / along);
    let transmitted = 2.0 * c * g * (1.0 / (across * across) + n * n / (along * along));
    Interface { reflected: 0.5 * (s * s + p * p), transmitted, scaled_cosine: g }
}

/// The direction from which a ray towards `out` is refracted by a surface with the normal `normal`, whose cosine with
/// `out` is `c`; `None` for total internal reflection.
pub(super) fn refract(out: [f64; 3], normal: [f64; 3], c: f64, n: f64) -> Option<[f64; 3]> {
    let g = interface(c, n).scaled_cosine;
    let into: [f64; 3] = std::array::from_fn(|k| ((c * normal[k] - out[k]) - g * normal[k]) / n);
    let length = into.iter().map(|x| x * x).sum::<f64>().sqrt();
    (g > 0.0).then(|| into.map(|x| x / length))
}

/// The square of a number and its rounding error.
fn square(x: f64) -> (f64, f64) {
    let product = x * x;
    (product, x.mul_add(x, -product))
}

/// The sum of two numbers and its rounding error (Knuth, TwoSum).
fn sum(a: f64, b: f64) -> (f64, f64) {
    let total = a + b;
    let part = total - a;
    (total, (a - (total - part)) + (b - part))
}
