//! A scalar f64 reference implementation of the BSDF, compared with the lanes; and reciprocity.

use std::f64::consts::PI;

use super::quadrature::{Vector, distribution, dot, half_vector, lambda, visible};
use super::{CLEAR_GLASS, One, Random, all, bsdf, lanes_of, viewers};
use crate::material::bsdf::microfacet::{INDEX_MATCHED_BELOW, SMOOTH_BELOW};
use crate::material::bsdf::{Bsdf, albedo, exact};
use crate::simd::LANES;

/// BSDF * |into.z| and its pdf.
#[derive(Clone, Copy, Debug, Default)]
struct Scattered {
    value: Vector,
    pdf: f64,
}

fn schlick(f0: f64, f90: f64, c: f64) -> f64 {
    f0 + (f90 - f0) * (1.0 - c).powi(5)
}

/// The reflectance of glass, per channel and of the strongest channel.
fn glass(one: &One, c: f64, eta: f64) -> [f64; 4] {
    let exact = exact::interface(c.max(1e-12), eta);
    let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let f90 = f64::from(one.specular);
    let channel = |f0: f64| {
        if exact.transmitted == 0.0 {
            return 1.0;
        }
        // From the transmittance: 1 - normal is 0 for no index.
        (f90 - (f90 - f0) * exact.transmitted / (1.0 - normal)).clamp(0.0, 1.0)
    };
    let [r, g, b] = one.f0().map(f64::from);
    [channel(r), channel(g), channel(b), channel(r.max(g).max(b))]
}

/// Albedo of the coat and its mean; W; the gain; the strengths of the light that is scattered more than once. From the
/// table, which has a test of its own.
struct Tabulated {
    albedo: f64,
    mean: f64,
    escape: f64,
    gain: f64,
    metal: Vector,
    coat: Vector,
}

/// What the light that is scattered more than once has left.
fn repeated(reflectance: f64, escape: f64) -> f64 {
    reflectance * reflectance * escape / (1.0 - reflectance * (1.0 - escape))
}

fn mean_schlick(f0: f64, f90: f64) -> f64 {
    f0 + (f90 - f0) / 21.0
}

fn tabulated(one: &One, z: f64) -> Tabulated {
    let (alpha, base) = ([one.alpha(); LANES], one.base_color.map(f64::from));
    let smooth = [one.alpha() < SMOOTH_BELOW; LANES];
    let rows = albedo::rows(&alpha);
    let z = z as f32;
    let f0 = one.f0().into_iter().fold(0.0, f32::max);
    let here = albedo::table().albedo(&rows, &[z; LANES], &alpha, &smooth);
    let mean = albedo::table().average(&rows, &smooth);
    let schlick_weight = (1.0 - z).powi(5);
    let (escape, mean_escape) = (f64::from(here.scale[0]), f64::from(mean.scale[0]));
    let again = repeated(mean_schlick(f64::from(f0), f64::from(one.specular)), mean_escape);
    let once = f64::from(here.of(0, f0, one.specular, schlick_weight));
    Tabulated {
        albedo: once + again * (1.0 - escape),
        mean: f64::from(mean.of(0, f0, one.specular)) + again * (1.0 - mean_escape),
        escape,
        gain: f64::from(here.gain[0]),
        metal: base.map(|b| repeated(mean_schlick(b, 1.0), mean_escape)),
        coat: one.f0().map(|f0| repeated(mean_schlick(f64::from(f0), f64::from(one.specular)), mean_escape)),
    }
}

/// The textbook BSDF; `shift` is added to the cosines at microfacets.
fn textbook(one: &One, out: Vector, into: Vector, shift: f64) -> Scattered {
    let alpha = f64::from(one.alpha());
    let (smooth, eta) = (one.alpha() < SMOOTH_BELOW, f64::from(one.eta));
    let clear = smooth || (!one.thin && (one.eta - 1.0).abs() < INDEX_MATCHED_BELOW);
    let base = one.base_color.map(f64::from);
    let f0 = one.f0().map(f64::from);
    let metal = f64::from(one.metallic);
    let glassy = (1.0 - metal) * f64::from(one.transmission);
    let coated = (1.0 - metal) * (1.0 - f64::from(one.transmission));

    let Tabulated { albedo: albedo_out, mean, escape, gain: gain_out, metal: metal_again, coat: coat_again } =
        tabulated(one, out[2]);
    let mean_of = |of: &dyn Fn(usize) -> f64| (of(0) + of(1) + of(2)) / 3.0;
    let energies = [
        metal * mean_of(&|c| schlick(base[c], 1.0, out[2]) * escape + metal_again[c] * (1.0 - escape)).max(0.05),
        glassy,
        coated * albedo_out,
        coated * (1.0 - albedo_out) * mean_of(&|c| base[c]),
    ];
    let sum: f64 = energies.iter().sum();
    let pick = if sum > 0.0 { energies.map(|e| e / sum) } else { [0.0, 0.0, 0.0, 1.0] };

    let mut scattered = Scattered::default();
    let gain = gain_out * tabulated(one, into[2].abs()).gain;
    let lambda_sum = 1.0 + lambda(out[2], alpha) + lambda(into[2].abs(), alpha);
    if into[2] > 0.0 {
        let albedo_into = tabulated(one, into[2]).albedo;
        let coupling = (1.0 - albedo_out) * (1.0 - albedo_into) / (1.0 - mean).max(1e-7);
        for c in 0..3 {
            scattered.value[c] += coated * base[c] / PI * coupling * into[2];
        }
        scattered.pdf += pick[3] * into[2] / PI;

        let h = half_vector(out, into, 1.0);
        let c = (dot(out, h) + shift).clamp(0.0, 1.0);
        let mirror = distribution(h, alpha) / lambda_sum / (4.0 * out[2] * into[2]);
        let density = visible(out, h, alpha) / (4.0 * dot(out, h));
        let reflected = glass(one, c, eta);
        for channel in 0..3 {
            let specular = f64::from(one.specular);
            let mut f = 0.0;
            if !smooth {
                f += metal * (schlick(base[channel], 1.0, c) + metal_again[channel] * (gain - 1.0)).max(0.0);
                f += coated * (schlick(f0[channel], specular, c) + coat_again[channel] * (gain - 1.0)).max(0.0);
            }
            if !clear {
                f += glassy * reflected[channel] * if one.thin { gain } else { 1.0 };
            }
            scattered.value[channel] += f * if f > 0.0 { mirror * into[2] } else { 0.0 };
        }
        scattered.pdf += if smooth { 0.0 } else { (pick[0] + pick[2]) * density };
        scattered.pdf += if clear { 0.0 } else { pick[1] * reflected[3] * density };
    } else if into[2] < 0.0 && !clear {
        let (value, density, through) = if one.thin {
            let there = [into[0], into[1], -into[2]];
            let h = half_vector(out, there, 1.0);
            let value = distribution(h, alpha) / lambda_sum / (4.0 * out[2] * there[2]);
            let through = 1.0 - glass(one, dot(out, h) + shift, eta)[3];
            (value * gain, visible(out, h, alpha) / (4.0 * dot(out, h)), through)
        } else {
            let h = half_vector(out, into, eta);
            let (o, i) = (dot(out, h), -dot(into, h));
            if o <= 0.0 || i <= 0.0 {
                return scattered;
            }
            // Walter et al., equation 21, with the light on the far side, divided by eta^2 for radiance.
            let square = (o - eta * i).powi(2);
            let value = o * i / (out[2] * -into[2]) * distribution(h, alpha) / lambda_sum / square;
            let through = if eta < 1.0 { glass(one, i + shift, 1.0 / eta) } else { glass(one, o + shift, eta) };
            (value, visible(out, h, alpha) * eta * eta * i / square, 1.0 - through[3])
        };
        for c in 0..3 {
            scattered.value[c] += glassy * base[c] * through * value * -into[2];
        }
        scattered.pdf += pick[1] * through * density;
    }
    scattered
}

/// The relative error bound of f32 and that of the slope: the half vector has an error of 1e-7 of the directions that
/// it is made of, so its slope has that error over its length, and D depends on the slope over alpha.
fn bound(one: &One, out: Vector, into: Vector) -> (f64, f64) {
    let bends = into[2] < 0.0 && !one.thin;
    let scale = if bends { f64::from(one.eta) } else { 1.0 };
    let z = if into[2] < 0.0 && one.thin { -into[2] } else { into[2] };
    let half = [out[0] + scale * into[0], out[1] + scale * into[1], out[2] + scale * z];
    let slope = 2e-7 * (1.0 + scale) / dot(half, half).sqrt();
    (1e-5 + 4.0 * slope / f64::from(one.alpha()).max(1e-3), slope)
}

fn at(directions: &[[f32; LANES]; 3], lane: usize) -> Vector {
    std::array::from_fn(|axis| f64::from(directions[axis][lane]))
}

/// Values and pdfs of random mixtures, for random directions and for sampled ones, within the bound above plus the
/// effect of the error of the cosine on the reflectance.
#[test]
fn the_lanes_agree_with_the_textbook() {
    let mut random = Random::new(21);
    let (mut sharp, mut seen) = (0, 0);
    for round in 0..600 {
        let ones: [One; LANES] = std::array::from_fn(|_| One::random(&mut random));
        let surfaces = bsdf(&ones);
        let out = lanes_of(&viewers(&mut random));
        let mut into = lanes_of(&std::array::from_fn(|_| random.direction()));
        if round % 2 == 0 {
            into = surfaces.sample(&out, &random.lanes(), &random.points()).into;
        }
        let evaluated = surfaces.evaluate(&out, &into);
        for lane in 0..LANES {
            let one = &ones[lane];
            let (o, i) = (at(&out, lane), at(&into, lane));
            let (bound, slope) = bound(one, o, i);
            if i[2].abs() < 1e-6 || bound > 0.1 {
                continue;
            }
            let expected = textbook(one, o, i, 0.0);
            let moved = [-slope, slope].map(|shift| textbook(one, o, i, shift));
            let mut check = |computed: f32, of: &dyn Fn(&Scattered) -> f64| {
                let expected = of(&expected);
                let slack = moved.iter().map(|m| (of(m) - expected).abs()).fold(0.0, f64::max);
                let error = (f64::from(computed) - expected).abs();
                assert!(
                    error <= bound * expected + slack + 1e-9,
                    "{computed} {expected} {evaluated:?} {lane} off by {error}, {bound} {slack}; {one:?} {o:?} {i:?}"
                );
                seen += u32::from(expected > 1e-6);
                sharp += u32::from(expected > 1e-6 && bound * expected + slack < 1e-3 * expected);
            };
            for c in 0..3 {
                check(evaluated.value[c][lane], &|s| s.value[c]);
            }
            check(evaluated.pdf[lane], &|s| s.pdf);
        }
    }
    assert!(seen > 20_000 && sharp > seen * 3 / 4, "most are held to a thousandth: {sharp} of {seen}");
}

/// The BSDF is reciprocal; for refraction up to the factor eta^2 of radiance.
#[test]
fn mixtures_are_reciprocal() {
    let mut random = Random::new(22);
    let (mut reflected, mut passed) = (0, 0);
    for round in 0..600 {
        let mut ones: [One; LANES] = std::array::from_fn(|_| One::random(&mut random));
        if round % 2 == 1 {
            ones = ones.map(|one| One { metallic: 0.0, roughness: one.roughness.max(0.1), ..CLEAR_GLASS });
        }
        let surfaces = bsdf(&ones);
        let out = lanes_of(&viewers(&mut random));
        let into = if round % 4 < 2 {
            lanes_of(&std::array::from_fn(|_| random.direction()))
        } else {
            surfaces.sample(&out, &random.lanes(), &random.points()).into
        };
        // Seen from the other side if the light is transmitted.
        let (mut back, mut back_out, mut back_into) = (ones, into, out);
        for lane in 0..LANES {
            if into[2][lane] < 0.0 {
                back_out[2][lane] *= -1.0;
                back_into[2][lane] *= -1.0;
                // A thin pane is glass in air from either side.
                back[lane].eta = if ones[lane].thin { ones[lane].eta } else { 1.0 / ones[lane].eta };
            }
        }
        let forth = surfaces.evaluate(&out, &into);
        let back = bsdf(&back).evaluate(&back_out, &back_into);
        for lane in 0..LANES {
            let (o, i) = (at(&out, lane), at(&into, lane));
            let (bound, _) = bound(&ones[lane], o, i);
            if i[2].abs() < 1e-5 || bound > 0.1 {
                continue;
            }
            let bends = i[2] < 0.0 && !ones[lane].thin;
            let scale = if bends { f64::from(ones[lane].eta).powi(2) } else { 1.0 };
            for c in 0..3 {
                let forth = f64::from(forth.value[c][lane]) / i[2].abs() * scale;
                let back = f64::from(back.value[c][lane]) / o[2];
                let error = (forth - back).abs();
                assert!(
                    error <= 2.0 * bound * forth.max(back) + 1e-9,
                    "{forth} {back}, {bound}; {:?} {o:?} {i:?}",
                    ones[lane]
                );
                reflected += u32::from(forth > 1e-6 && i[2] > 0.0);
                passed += u32::from(forth > 1e-6 && i[2] < 0.0);
            }
        }
    }
    assert!(reflected > 3000 && passed > 3000, "{reflected} {passed}");
}

/// The weights of delta lobes, over all choices, equal closed forms.
#[test]
fn single_directions_weigh_what_they_reflect() {
    const STEPS: usize = 16_384;
    let mut random = Random::new(23);
    for _ in 0..40 {
        let one = One { roughness: 0.0, ..One::random(&mut random) };
        let (surfaces, out): (Bsdf, Vector) = (all(one), super::viewer(random.next().max(0.02)));
        let mut means = [[0.0; 3]; 2];
        for first in (0..STEPS).step_by(LANES) {
            let choice = std::array::from_fn(|lane| ((first + lane) as f32 + 0.5) / STEPS as f32);
            let sampled = surfaces.sample(&super::same_in_all_lanes(out), &choice, &[[0.4; LANES], [0.3; LANES]]);
            for lane in 0..LANES {
                if sampled.pdf[lane] == f32::INFINITY {
                    for c in 0..3 {
                        let side = usize::from(sampled.transmitted[lane]);
                        means[side][c] += f64::from(sampled.weight[c][lane]) / STEPS as f64;
                    }
                }
            }
        }
        let metal = f64::from(one.metallic);
        let glassy = (1.0 - metal) * f64::from(one.transmission);
        let coated = (1.0 - metal) * (1.0 - f64::from(one.transmission));
        let (mu, eta) = (f64::from(out[2] as f32), f64::from(one.eta));
        let reflected = glass(&one, mu, eta);
        let spread = if one.thin { 1.0 } else { eta * eta };
        for c in 0..3 {
            let base = f64::from(one.base_color[c]);
            let mirror = metal * schlick(base, 1.0, mu)
                + coated * schlick(f64::from(one.f0()[c]), f64::from(one.specular), mu)
                + glassy * reflected[c];
            let window = glassy * (1.0 - reflected[3]) * base / spread;
            // The choices are a grid: one more or less may fall on either side of a threshold.
            for (mean, expected) in [(means[0][c], mirror), (means[1][c], window)] {
                assert!((mean - expected).abs() < 1e-3 * (1.0 + 1.0 / spread), "{mean} {expected} {one:?} {mu}");
            }
        }
    }
}
