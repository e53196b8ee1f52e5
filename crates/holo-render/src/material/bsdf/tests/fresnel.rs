//! Fresnel's equations and refraction, compared with closed forms and with double-double arithmetic.

use super::super::{exact, fresnel};
use super::{Random, lanes_of};
use crate::simd::LANES;

/// Indices of refraction and inverses.
const INDICES: [f64; 12] =
    [1.000_01, 1.003, 1.1, 1.333, 1.5, 2.4, 1000.0, 1.0 / 1.003, 1.0 / 1.333, 1.0 / 1.5, 1.0 / 2.4, 1e-3];

/// A double-double number: the sum of two f64, about 106 bits.
#[derive(Clone, Copy, Debug)]
struct Double(f64, f64);

impl Double {
    fn new(a: f64, b: f64) -> Self {
        let total = a + b;
        let part = total - a;
        Self(total, (a - (total - part)) + (b - part))
    }

    fn add(self, other: Self) -> Self {
        let high = Self::new(self.0, other.0);
        Self::new(high.0, high.1 + self.1 + other.1)
    }

    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product) + self.0 * other.1 + self.1 * other.0;
        Self::new(product, error)
    }

    fn negative(self) -> Self {
        Self(-self.0, -self.1)
    }

    fn div(self, other: Self) -> Self {
        let mut quotient = Self(self.0 / other.0, 0.0);
        for _ in 0..2 {
            let rest = self.add(quotient.mul(other).negative());
            quotient = quotient.add(Self(rest.0 / other.0, 0.0));
        }
        quotient
    }

    fn sqrt(self) -> Self {
        let mut root = Self(self.0.sqrt(), 0.0);
        for _ in 0..2 {
            let rest = self.add(root.mul(root).negative());
            root = root.add(Self(rest.0 / (2.0 * root.0), 0.0));
        }
        root
    }
}

/// Reflectance, transmittance and the cosine behind the surface, by Snell's law and the textbook formulas.
fn reference(c: f64, n: f64) -> [f64; 3] {
    let one = Double(1.0, 0.0);
    let (c, n) = (Double(c, 0.0), Double(n, 0.0));
    let sine_square = one.add(c.mul(c).negative()).div(n.mul(n));
    let cosine_square = one.add(sine_square.negative());
    if cosine_square.0 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let t = cosine_square.sqrt();
    let ratio = |a: Double, b: Double| a.add(b.negative()).div(a.add(b));
    let (s, p) = (ratio(c, n.mul(t)), ratio(n.mul(c), t));
    let reflected = s.mul(s).add(p.mul(p)).div(Double(2.0, 0.0));
    [reflected.0, one.add(reflected.negative()).0, t.0]
}

/// From normal incidence to 1e-8 rad above grazing, and within ulps of the critical angle.
fn cosines(n: f64) -> Vec<f64> {
    let mut all: Vec<f64> = (0..=200).map(|k| (f64::from(k) * std::f64::consts::FRAC_PI_2 / 200.0).cos()).collect();
    all.extend((1..=80).map(|k| 10f64.powf(-f64::from(k) / 10.0)));
    all.push(1.0 / (1.0 + n * n).sqrt());
    if n < 1.0 {
        let critical = (1.0 - n * n).sqrt();
        all.extend((-20..=20).map(|k| critical + f64::from(k) * f64::EPSILON / 2.0));
        all.extend((1..=60).flat_map(|k| [1.0, -1.0].map(|s| critical * (1.0 + s * 2f64.powi(-k)))));
    }
    all.retain(|c| *c > 0.0 && *c <= 1.0);
    all
}

/// The reference itself, at closed forms: normal incidence, Brewster's angle, the critical angle; and at values
/// computed with 50 digits.
#[test]
fn the_reference_is_right() {
    for n in INDICES {
        let normal = ((n - 1.0) / (n + 1.0)).powi(2);
        assert!((reference(1.0, n)[0] - normal).abs() < 1e-15);
        if n > 0.4 {
            // Lower indices are too close to the critical angle for f64.
            let brewster = ((n * n - 1.0) / (n * n + 1.0)).powi(2) / 2.0;
            assert!((reference(1.0 / (1.0 + n * n).sqrt(), n)[0] - brewster).abs() < 1e-15);
        }
    }
    assert_eq!(reference(0.59, 0.8), [1.0, 0.0, 0.0]);
    for (c, n, reflected, transmitted, cosine) in [
        (0.25, 1.5, 0.264_190_373_434_071_1, 0.735_809_626_565_928_9, 0.763_762_615_825_973_3),
        (0.5f64.powi(26), 2.375, 0.999_999_908_130_617_5, 9.186_938_246_484_644e-8, 0.907_036_207_348_109_8),
    ] {
        let [r, t, k] = reference(c, n);
        assert!((r - reflected).abs() < 3e-16 && (t / transmitted - 1.0).abs() < 1e-14 && (k - cosine).abs() < 3e-16);
    }
}

/// Reflectance and cosine within 1e-14; the transmittance within a relative 1e-13.
#[test]
fn the_exact_form_is_exact() {
    for n in INDICES {
        for c in cosines(n) {
            let [reflected, transmitted, cosine] = reference(c, n);
            let exact = exact::interface(c, n);
            assert!((exact.reflected - reflected).abs() < 1e-14, "{c} {n} {exact:?} {reflected}");
            assert!((exact.transmitted - transmitted).abs() <= 1e-13 * transmitted, "{c} {n} {exact:?} {transmitted}");
            assert!((exact.scaled_cosine / n - cosine).abs() < 1e-14, "{c} {n} {exact:?} {cosine}");
        }
    }
}

/// Reflectance within 1e-6 for the f32 cosine and index, including the critical angle.
#[test]
fn the_lanes_are_within_a_millionth() {
    let mut worst = [0.0f64; 2];
    for n in INDICES {
        for c in cosines(n) {
            let (c, n) = (c as f32, n as f32);
            let exact = exact::interface(f64::from(c), f64::from(n));
            let lane = fresnel::interface(c, n);
            let error = (f64::from(lane.reflected) - exact.reflected).abs();
            worst[0] = worst[0].max(error);
            let cosine = |scaled: f64| scaled / f64::from(n);
            let error = (cosine(f64::from(lane.scaled_cosine)) - cosine(exact.scaled_cosine)).abs();
            worst[1] = worst[1].max(error);
            assert!(!lane.total || exact.transmitted < 1e-6);
        }
    }
    assert!(worst[0] < 1e-6 && worst[1] < 1e-6, "{worst:?}");
}

/// Rounded cosines: half a unit in the last place changes F at the critical angle by 2^-11 (1 + n^-2), and by no more.
#[test]
fn the_critical_angle_is_as_steep_as_the_documents_say() {
    for n in [1.0 / 1.1, 1.0 / 1.5, 1.0 / 2.4] {
        let critical = (1.0f64 - n * n).sqrt();
        let moved = exact::interface(critical * (1.0 + 2f64.powi(-25)), n).transmitted;
        let expected = 2f64.powi(-11) * (1.0 + 1.0 / (n * n));
        assert!((moved / expected - 1.0).abs() < 0.01, "{moved} {expected}");
    }
}

/// Refracted directions within 1e-6, compared with the reference, for level and tilted microfacets. The indices are
/// those of real glass: from inside at 1e3, f32 directions are not precise enough.
#[test]
fn rays_are_bent_to_a_millionth() {
    let mut random = Random::new(11);
    let mut worst = 0.0f64;
    for level in [true, false] {
        for _ in 0..4000 {
            let n = random.choose(&[1.003f32, 1.1, 1.5, 2.4, 1000.0, 1.0 / 1.1, 1.0 / 1.5, 1.0 / 2.4]);
            let facet = if level { [0.0, 0.0, 1.0] } else { random.direction() };
            let towards = random.direction();
            let side = (0..3).map(|k| towards[k] * facet[k]).sum::<f64>().signum();
            let out = lanes_of(&[towards.map(|x| x * side); LANES]);
            let normal = lanes_of(&[facet; LANES]);
            let at = |of: &[[f32; LANES]; 3]| -> [f64; 3] { std::array::from_fn(|k| f64::from(of[k][0])) };
            let cosine = (0..3).map(|k| out[k][0] * normal[k][0]).sum::<f32>();
            let interface = fresnel::interface(cosine, n);
            let into = at(&fresnel::refract(&out, &normal, &[cosine; LANES], &[interface.scaled_cosine; LANES]));
            let Some(exact) = exact::refract(at(&out), at(&normal), f64::from(cosine), f64::from(n)) else {
                assert!(interface.total);
                continue;
            };
            let error = (0..3).map(|k| (into[k] - exact[k]).abs()).fold(0.0, f64::max);
            worst = worst.max(error);
            // Snell's law: the components along the surface have the ratio n.
            let along = (0..3).map(|k| {
                (at(&out)[k] + f64::from(n) * exact[k]) - {
                    let dot: f64 = (0..3).map(|j| (at(&out)[j] + f64::from(n) * exact[j]) * at(&normal)[j]).sum();
                    dot * at(&normal)[k]
                }
            });
            assert!(along.map(f64::abs).fold(0.0, f64::max) < 2e-6 * f64::from(n).max(1.0));
        }
    }
    assert!(worst < 1e-6, "{worst}");
}
