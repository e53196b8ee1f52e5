//! The white furnace test: no lobe gains energy, the losses are those of the documentation, and samples match the
//! evaluated BSDF.

use super::quadrature::{LATTICE, Total, Vector, dot, draw_normal, integrate, lambda, nodes};
use super::{CLEAR_GLASS, One, Random, WHITE_COATED, WHITE_METAL, all, same_in_all_lanes, viewer};
use crate::material::bsdf::{Bsdf, albedo};
use crate::sampling::Points;
use crate::simd;
use crate::simd::LANES;

const ROUGHNESSES: [f32; 6] = [0.0, 0.1, 0.3, 0.5, 0.7, 1.0];
const COSINES: [f64; 6] = [0.02, 0.1, 0.3, 0.6, 0.9, 1.0];
const INDICES: [f32; 6] = [1.1, 1.5, 2.4, 1.0 / 1.1, 1.0 / 1.5, 1.0 / 2.4];

/// The tables of the module documentation: losses in per cent, by roughness and cosine.
type Losses = [[f64; 6]; 6];

const INTO_GLASS: Losses = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [7.99, 0.4, 0.02, 0.0, 0.0, 0.0],
    [4.03, 7.75, 2.09, 0.4, 0.13, 0.09],
    [4.01, 8.39, 7.0, 2.86, 1.07, 0.8],
    [7.07, 14.47, 14.39, 8.49, 3.97, 3.07],
    [12.76, 25.91, 29.61, 23.05, 13.45, 10.67],
];
const OUT_OF_GLASS: Losses = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [8.77, 0.61, 0.07, 0.02, 0.01, 0.01],
    [8.44, 13.24, 5.98, 2.47, 1.06, 0.89],
    [14.86, 18.93, 20.24, 15.67, 8.58, 7.08],
    [26.31, 30.63, 34.1, 32.29, 26.35, 23.84],
    [43.88, 48.94, 50.25, 48.59, 55.36, 58.29],
];

/// The delta lobes and their probability: `sample` over evenly spaced choices.
fn delta_lobes(surfaces: &Bsdf, out: Vector) -> Total {
    const STEPS: usize = 4096;
    let mut total = Total::default();
    for first in (0..STEPS).step_by(LANES) {
        let choice = std::array::from_fn(|lane| ((first + lane) as f32 + 0.5) / STEPS as f32);
        let sampled = surfaces.sample(&same_in_all_lanes(out), &choice, &[[0.4; LANES], [0.3; LANES]]);
        for lane in 0..LANES {
            if sampled.pdf[lane] == f32::INFINITY {
                let side = if sampled.transmitted[lane] { &mut total.below } else { &mut total.above };
                for c in 0..3 {
                    side[c] += f64::from(sampled.weight[c][lane]) / STEPS as f64;
                }
                total.pdf += 1.0 / STEPS as f64;
            }
        }
    }
    total
}

/// The albedo, with the factor eta^2 of transmitted radiance removed.
fn furnace(one: One, mu: f64) -> Vector {
    let out = viewer(mu);
    let spread = if one.thin { 1.0 } else { f64::from(one.eta * one.eta) };
    let (lobes, delta_lobes) = (integrate(&one, out), delta_lobes(&all(one), out));
    std::array::from_fn(|c| lobes.above[c] + delta_lobes.above[c] + spread * (lobes.below[c] + delta_lobes.below[c]))
}

fn lost(one: One, mu: f64) -> f64 {
    1.0 - furnace(one, mu)[0]
}

/// Lambert's law, mirrors, thin panes and smooth bodies have an albedo of 1; so does a coated diffuse surface of any
/// roughness and index, to the accuracy of its table.
#[test]
fn smooth_and_diffuse_surfaces_lose_nothing() {
    for mu in COSINES.into_iter().chain([0.001, 0.005]) {
        assert!(lost(One { specular: 0.0, ..WHITE_COATED }, mu).abs() < 1e-3);
        assert!(lost(WHITE_METAL, mu).abs() < 1e-3);
        for eta in INDICES {
            for thin in [false, true] {
                assert!(lost(One { eta, thin, ..CLEAR_GLASS }, mu).abs() < 1e-3, "{eta} {mu}");
                assert!(lost(One { eta, thin, specular: 0.3, ..CLEAR_GLASS }, mu).abs() < 1e-3, "{eta} {mu}");
            }
        }
        for eta in [1.1, 1.5, 2.4, 100.0] {
            for roughness in ROUGHNESSES {
                let lost = lost(One { eta, roughness, ..WHITE_COATED }, mu);
                assert!(lost.abs() < 2e-3, "{eta} {roughness} {mu}: {lost}");
            }
        }
    }
}

/// A lattice of three dimensions, from the powers of the root of x^4 = x + 1: sixteen points from number `first` on.
fn lattice(first: usize) -> ([f32; LANES], Points) {
    let number = |step: f64| -> [f32; LANES] {
        std::array::from_fn(|lane| ((0.5 + step * (first + lane) as f64).fract() as f32).min(1.0 - f32::EPSILON))
    };
    (number(0.819_172_513_396_164_4), [number(0.671_043_606_703_789_2), number(0.549_700_477_901_970_3)])
}

/// White metal and clear panes of any roughness have an albedo of 1, to the accuracy of the table: the mean weight of
/// 65536 samples. (The quadrature does not resolve the narrowest lobes at grazing incidence.)
#[test]
fn rough_metal_and_panes_lose_nothing() {
    const COUNT: usize = 65_536;
    let albedo = |one: One, mu: f64| {
        let (surfaces, out) = (all(one), same_in_all_lanes(viewer(mu)));
        let sum = |first: usize| {
            let (choice, point) = lattice(first);
            surfaces.sample(&out, &choice, &point).weight[0].iter().map(|&w| f64::from(w)).sum::<f64>()
        };
        (0..COUNT).step_by(LANES).map(sum).sum::<f64>() / COUNT as f64
    };
    for roughness in (0..=20).map(|k| k as f32 / 20.0) {
        for mu in COSINES.into_iter().chain([0.005, 0.05, 0.45, 0.75]) {
            let metal = albedo(One { roughness, ..WHITE_METAL }, mu);
            assert!((metal - 1.0).abs() < 3e-3, "metal {roughness} {mu}: {metal}");
            for (eta, specular) in [(1.1, 1.0), (1.5, 1.0), (2.4, 0.3)] {
                let pane = albedo(One { roughness, eta, specular, thin: true, ..CLEAR_GLASS }, mu);
                assert!((pane - 1.0).abs() < 3e-3, "pane {eta} {roughness} {mu}: {pane}");
            }
        }
    }
}

/// Gray metal reflects what is left after any number of events between the microfacets: the geometric series of the
/// multiple-scattering lobe, in a hemisphere of light.
#[test]
fn repeated_reflection_is_a_geometric_series() {
    let mean = |one: One| {
        let (x, w): (Vec<f64>, Vec<f64>) = (0..40).map(|k| ((f64::from(k) + 0.5) / 40.0, 1.0 / 40.0)).unzip();
        x.iter().zip(&w).map(|(z, w)| 2.0 * z * w * furnace(one, *z)[0]).sum::<f64>()
    };
    for roughness in [0.5, 1.0] {
        let of = |f: f32| One { roughness, base_color: [f; 3], ..WHITE_METAL };
        // Without Fresnel's rise: f90 = f0, so that every event reflects f.
        let flat = |f: f32| {
            let mut surfaces = all(of(f));
            surfaces.metal_f90 = surfaces.base_color;
            surfaces
        };
        let escape = 1.0
            - 2.0
                * (0..400)
                    .map(|k| (f64::from(k) + 0.5) / 400.0)
                    .map(|z| {
                        let rows = albedo::rows(&[of(1.0).alpha(); LANES]);
                        let scale = albedo::table()
                            .albedo(&rows, &[z as f32; LANES], &[of(1.0).alpha(); LANES], &[false; LANES])
                            .scale[0];
                        z * (1.0 - f64::from(scale)) / 400.0
                    })
                    .sum::<f64>();
        for f in [0.2_f32, 0.5, 0.9] {
            let lobes = flat(f).lobes(&same_in_all_lanes(viewer(0.5)));
            let (f, repeated) = (f64::from(f), f64::from(lobes.metal_again[0][0]));
            // Events 2, 3, ...: f^2 W + f^3 (1 - W) W + ...
            let series: f64 = (0..200).map(|k| f * f * escape * (f * (1.0 - escape)).powi(k)).sum();
            assert!((repeated - series).abs() < 2e-3, "{repeated} {series}");
        }
        assert!((mean(of(1.0)) - 1.0).abs() < 2e-3);
    }
}

/// Rough bodies have the documented losses, within 0.05 % (eleven times as many points
/// change nothing), and no gain at any index.
#[test]
fn the_losses_are_those_of_the_documents() {
    for (row, roughness) in ROUGHNESSES.into_iter().enumerate() {
        for (column, mu) in COSINES.into_iter().enumerate() {
            let check = |one: One, table: &Losses| {
                let lost = lost(One { roughness, ..one }, mu);
                assert!((100.0 * lost - table[row][column]).abs() < 0.05, "{one:?} {roughness} {mu}: {lost}");
            };
            check(CLEAR_GLASS, &INTO_GLASS);
            check(One { eta: 1.0 / 1.5, ..CLEAR_GLASS }, &OUT_OF_GLASS);
            for eta in INDICES {
                let lost = lost(One { eta, roughness, ..CLEAR_GLASS }, mu);
                assert!(lost > -1e-3, "{eta} {roughness} {mu}: {lost}");
            }
        }
    }
}

/// The albedo of a mixture is the mixture of the albedos, and a colored reflection reduces all channels.
#[test]
fn mixtures_are_mixtures() {
    let mut random = Random::new(31);
    for _ in 0..24 {
        let (metallic, transmission) = (random.next() as f32, random.next() as f32);
        let one = One {
            metallic,
            transmission,
            roughness: random.choose(&ROUGHNESSES),
            eta: random.choose(&INDICES),
            ..WHITE_COATED
        };
        let mu = random.choose(&COSINES);
        let part = |metallic, transmission| furnace(One { metallic, transmission, ..one }, mu)[0];
        let (m, t) = (f64::from(metallic), f64::from(transmission));
        let expected = m * part(1.0, 0.0) + (1.0 - m) * (t * part(0.0, 1.0) + (1.0 - t) * part(0.0, 0.0));
        let mixed = furnace(one, mu);
        assert!((mixed[0] - expected).abs() < 1.5e-3, "{mixed:?} {expected} {one:?} {mu}");
        let red = furnace(One { specular_color: [1.0, 0.2, 0.0], ..one }, mu);
        assert!(red.iter().all(|x| *x < 1.001) && red[1] < red[0] + 1e-3 && red[2] < red[1] + 1e-3, "{red:?} {one:?}");
    }
}

/// Means over the directions of `sample` - the weights, and their first moments along the axes - equal the integrals of
/// `evaluate`, per channel and side; its pdf integrates to the share of valid samples. 262144 points of a
/// three-dimensional lattice; the differences are below a third of the bound.
#[test]
fn what_is_drawn_is_what_is_evaluated() {
    const COUNT: usize = 262_144;
    let mut random = Random::new(32);
    for k in 0..30 {
        let mut one = One { eta: random.choose(&INDICES), ..One::random(&mut random) };
        // No black: a weight above 0 indicates a valid sample.
        one.base_color = one.base_color.map(|c| 0.1 + 0.9 * c);
        one = match k {
            0 => One { roughness: 0.5, ..WHITE_METAL },
            1 => One { roughness: 0.3, ..CLEAR_GLASS },
            2 => One { roughness: 0.7, eta: 1.0 / 1.5, ..CLEAR_GLASS },
            3 => One { roughness: 0.4, thin: true, ..CLEAR_GLASS },
            4 => One { roughness: 0.2, ..WHITE_COATED },
            _ => one,
        };
        let out = viewer(random.choose(&COSINES[1..]));
        let (surfaces, towards) = (all(one), same_in_all_lanes(out));

        // Per side: the weight of each channel, then that of the first channel along each axis.
        let mut drawn = [[0.0; 6]; 2];
        let (mut found, mut delta_lobes) = (0.0, 0.0);
        for first in (0..COUNT).step_by(LANES) {
            let (choice, point) = lattice(first);
            let sampled = surfaces.sample(&towards, &choice, &point);
            for lane in 0..LANES {
                let weight: Vector = std::array::from_fn(|c| f64::from(sampled.weight[c][lane]) / COUNT as f64);
                if sampled.pdf[lane] == f32::INFINITY {
                    delta_lobes += 1.0 / COUNT as f64;
                    continue;
                }
                found += if weight[0] > 0.0 { 1.0 / COUNT as f64 } else { 0.0 };
                let side = &mut drawn[usize::from(sampled.transmitted[lane])];
                for c in 0..3 {
                    side[c] += weight[c];
                    side[c + 3] += weight[0] * f64::from(sampled.into[c][lane]);
                }
            }
        }

        let mut evaluated = [[0.0; 6]; 2];
        let mut density = 0.0;
        for nodes in nodes(&one, out) {
            let values = surfaces.evaluate(&towards, &nodes.into);
            for lane in 0..LANES {
                let side = &mut evaluated[usize::from(nodes.into[2][lane] < 0.0)];
                let weight: Vector = std::array::from_fn(|c| f64::from(values.value[c][lane]) * nodes.weight[lane]);
                for c in 0..3 {
                    side[c] += weight[c];
                    side[c + 3] += weight[0] * f64::from(nodes.into[c][lane]);
                }
                density += f64::from(values.pdf[lane]) * nodes.weight[lane];
            }
        }
        for (a, b) in drawn.iter().flatten().zip(evaluated.iter().flatten()) {
            assert!((a - b).abs() < 3e-3, "{drawn:?}\n{evaluated:?}\n{one:?} {out:?}");
        }
        assert!(
            (density - found).abs() < 3e-3 && found + delta_lobes < 1.0 + 1e-9,
            "{density} {found} {delta_lobes} {one:?}"
        );
    }
}

/// The table of the coat, between its nodes and down to grazing incidence, compared with another integral: E within
/// 1e-3 for f90 = 1 and any f0, means within 1e-3.
#[test]
fn the_albedo_table_is_right_to_a_thousandth() {
    let integral = |z: f64, alpha: f64| {
        let [count, step] = LATTICE;
        let out = viewer(z);
        let mut sums = [0.0; 2];
        for k in 0..count {
            let h =
                draw_normal(out, alpha, [(k as f64 + 0.5) / count as f64, (k * step % count) as f64 / count as f64]);
            let c = dot(out, h);
            let into = 2.0 * c * h[2] - out[2];
            if into > 0.0 {
                let share = (1.0 + lambda(z, alpha)) / (1.0 + lambda(z, alpha) + lambda(into, alpha)) / count as f64;
                sums[0] += share;
                sums[1] += share * (1.0 - c).powi(5);
            }
        }
        sums
    };
    let table = albedo::table();
    let mut random = Random::new(33);
    let mut worst = [0.0f64; 2];
    for k in 0..400 {
        let alpha = if k % 8 == 0 { 1e-3 } else { (1e-3f64).powf(random.next()) };
        let place = random.next();
        let z = if k % 2 == 0 { place * place * alpha / (1.0 + alpha - place * place) } else { place };
        let (z, alpha) = (z.clamp(1e-6, 1.0), alpha as f32);
        let rows = albedo::rows(&[alpha; LANES]);
        let albedo = table.albedo(&rows, &[z as f32; LANES], &[alpha; LANES], &[false; LANES]);
        let [scale, grazing] = integral(z, f64::from(alpha));
        for f0 in [0.0f32, 0.04, 0.17, 0.5, 1.0] {
            let exact = f64::from(f0) * (scale - grazing) + grazing;
            let error = (f64::from(albedo.of(0, f0, 1.0, (1.0 - z as f32).powi(5))) - exact).abs();
            worst[0] = worst[0].max(error);
        }
        if k % 20 == 1 {
            let mean = table.average(&rows, &[false; LANES]);
            let (mut scale, mut grazing) = (0.0, 0.0);
            for step in 0..64 {
                // Uniform in the square of the cosine, which is the weight of the mean.
                let [w, g] = integral(((f64::from(step) + 0.5) / 64.0).sqrt(), f64::from(alpha));
                scale += w / 64.0;
                grazing += g / 64.0;
            }
            worst[1] = worst[1].max((f64::from(mean.scale[0]) - scale).abs());
            worst[1] = worst[1].max((f64::from(mean.grazing[0]) - grazing).abs());
        }
    }
    assert!(worst[0] < 1e-3 && worst[1] < 1e-3, "{worst:?}");
}

/// Every instruction set computes the same table.
#[test]
fn the_albedo_table_has_the_same_bits_everywhere() {
    for table in simd::run_on_all(|| albedo::Compute) {
        assert!(table == *albedo::table());
    }
}

/// The known values of smooth surfaces.
#[test]
fn smooth_surfaces_do_not_look_into_the_table() {
    let rows = albedo::rows(&[0.0; LANES]);
    let albedo = albedo::table().albedo(&rows, &[0.3; LANES], &[0.0; LANES], &[true; LANES]);
    assert_eq!((albedo.scale[0], albedo.bias[0]), (1.0, 0.0));
    let mean = albedo::table().average(&rows, &[true; LANES]);
    assert_eq!((mean.scale[0], mean.grazing[0]), (1.0, 1.0 / 21.0));
}
