//! Fresnel's equations and refraction in f64, one at a time: what the lanes are held against.
//!
//! Accuracy: shares within 1e-15 of those of the cosine and the index as they are given, at any angle, the critical one
//! included; the transmitted share keeps its relative accuracy towards grazing incidence, where it goes to 0.

/// Fresnel's equations at one angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    pub reflected: f64,
    /// 1 - `reflected`, but exact where that is small.
    pub transmitted: f64,
    /// Cosine of the refracted ray with the normal, times n; 0 under total reflection.
    pub scaled_cosine: f64,
}

/// What happens under the cosine `c` where the index of refraction behind over that in front is `n`.
pub(super) fn interface(c: f64, n: f64) -> Interface {
    // n^2 - 1 + c^2 cancels near the critical angle: the squares with their rounding errors, summed with theirs.
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

/// Where a ray towards `out` comes from through a surface of normal `normal`, whose cosine with `out` is `c`: nowhere
/// under total reflection.
pub(super) fn refract(out: [f64; 3], normal: [f64; 3], c: f64, n: f64) -> Option<[f64; 3]> {
    let g = interface(c, n).scaled_cosine;
    let into: [f64; 3] = std::array::from_fn(|k| ((c * normal[k] - out[k]) - g * normal[k]) / n);
    let length = into.iter().map(|x| x * x).sum::<f64>().sqrt();
    (g > 0.0).then(|| into.map(|x| x / length))
}

/// A square and what its rounding left out.
fn square(x: f64) -> (f64, f64) {
    let product = x * x;
    (product, x.mul_add(x, -product))
}

/// A sum and what its rounding left out (Knuth).
fn sum(a: f64, b: f64) -> (f64, f64) {
    let total = a + b;
    let part = total - a;
    (total, (a - (total - part)) + (b - part))
}
