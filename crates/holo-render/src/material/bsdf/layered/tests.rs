//! Layered BSDFs against the sixteen-lane BSDF, a plain quadrature, and the white furnace.

use std::f64::consts::TAU;

use super::*;
use crate::material::bsdf::tests::{One, Random, WHITE_COATED, WHITE_METAL, bsdf, same_in_all_lanes, viewer};
use crate::simd::LANES;

/// Without any layer.
fn layered(one: &One) -> Layered {
    Layered {
        base_color: one.base_color,
        metallic: one.metallic,
        transmission: one.transmission,
        alpha: [one.alpha(); 2],
        specular_f0: one.f0(),
        specular_f90: one.specular,
        eta: [one.eta; 3],
        usual_f0: fresnel::normal_incidence(one.eta),
        thin: one.thin,
        multiple_scattering: true,
        diffuse_transmission: 0.0,
        diffuse_transmission_color: [1.0; 3],
        film: None,
        sheen: None,
        clearcoat: None,
        channels: [true; 3],
    }
}

fn single(v: [f64; 3]) -> Vector {
    v.map(|x| x as f32)
}

/// The white furnace: a diffuse surface under a coat, in rough light.
fn white(roughness: f32) -> Layered {
    layered(&One { roughness, ..WHITE_COATED })
}

fn clearcoat(factor: f32, roughness: f32) -> Option<Clearcoat> {
    Some(Clearcoat { factor, alpha: roughness * roughness, axes: Clearcoat::ALIGNED })
}

fn tilted() -> Option<Clearcoat> {
    let (s, c) = (0.3_f32.sin(), 0.3_f32.cos());
    Some(Clearcoat { factor: 0.8, alpha: 0.2, axes: [[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]] })
}

fn sheen(roughness: f32) -> Option<Sheen> {
    Some(Sheen { color: [1.0, 0.7, 0.4], alpha: (roughness * roughness).max(sheen::MIN_ALPHA) })
}

const FILM: Film = Film { factor: 1.0, ior: 1.33, thickness_nm: 400.0 };

/// One of each kind, without delta lobes.
fn rough_kinds() -> Vec<(&'static str, Layered)> {
    let metal = layered(&One { roughness: 0.6, base_color: [0.9, 0.6, 0.3], ..WHITE_METAL });
    let glass = |thin| layered(&One { roughness: 0.7, transmission: 0.7, thin, ..WHITE_COATED });
    vec![
        ("clearcoat", Layered { clearcoat: clearcoat(1.0, 0.5), ..white(0.6) }),
        ("clearcoat on metal", Layered { clearcoat: clearcoat(0.7, 0.6), ..metal.clone() }),
        ("tilted clearcoat", Layered { clearcoat: tilted(), ..white(0.6) }),
        ("sheen", Layered { sheen: sheen(0.3), ..white(0.6) }),
        ("sheen under clearcoat", Layered { sheen: sheen(0.8), clearcoat: clearcoat(0.8, 0.6), ..white(0.7) }),
        ("anisotropy", Layered { alpha: [0.6, 0.2], ..metal.clone() }),
        ("anisotropy over diffuse", Layered { alpha: [0.2, 0.7], ..white(0.6) }),
        ("anisotropic pane", Layered { alpha: [0.7, 0.3], ..glass(true) }),
        ("film on metal", Layered { film: Some(FILM), ..metal }),
        ("film over diffuse", Layered { film: Some(Film { factor: 0.7, ..FILM }), ..white(0.6) }),
        ("film on glass", Layered { film: Some(FILM), ..glass(false) }),
        ("dispersion", Layered { eta: [1.45, 1.5, 1.58], ..glass(false) }),
        ("dispersion from inside", Layered { eta: [0.69, 0.667, 0.63], ..glass(false) }),
        (
            "diffuse transmission",
            Layered {
                diffuse_transmission: 0.6,
                diffuse_transmission_color: [0.9, 0.5, 0.2],
                thin: true,
                ..white(0.5)
            },
        ),
    ]
}

/// Directions of a grid over the sphere with their solid angles, finer towards grazing incidence.
fn grid(rows: usize, columns: usize) -> impl Iterator<Item = (Vector, f64)> {
    (0..rows).flat_map(move |row| {
        (0..columns).map(move |column| {
            let t = 2.0 * (row as f64 + 0.5) / rows as f64 - 1.0;
            let z = t.abs() * t;
            let (sin, cos) = (TAU * (column as f64 + 0.5) / columns as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            (single([r * cos, r * sin, z]), 4.0 * t.abs() / rows as f64 * TAU / columns as f64)
        })
    })
}

/// Points of the unit disk with heights, and choices: a lattice of three dimensions.
fn numbers(count: usize) -> impl Iterator<Item = (f32, Vector)> {
    (0..count).map(|k| {
        let number = |step: f64| (0.5 + step * k as f64).fract();
        let (u, v) = (number(0.671_043_606_703_789_2), number(0.549_700_477_901_970_3));
        let (sin, cos) = (TAU * v).sin_cos();
        let choice = (number(0.819_172_513_396_164_4) as f32).min(1.0 - f32::EPSILON);
        (choice, single([u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt()]))
    })
}

/// The mean weight of samples above and below the surface; radiance is multiplied by eta^2 below.
fn albedo(m: &Layered, out: [f64; 3]) -> [f64; 3] {
    const COUNT: usize = 32_768;
    let view = LayeredView::new(m.clone(), single(out));
    let mut sum = [0.0; 3];
    for (choice, disk) in numbers(COUNT) {
        let sampled = view.sample(choice, disk);
        for c in 0..3 {
            let spread = if sampled.transmitted && !m.thin { f64::from(m.eta[c] * m.eta[c]) } else { 1.0 };
            sum[c] += spread * f64::from(sampled.weight[c]) / COUNT as f64;
        }
    }
    sum
}

/// The scalar code has the values and pdfs of the sixteen lanes, up to rounding.
#[test]
fn without_layers_it_is_the_bsdf_of_sixteen_lanes() {
    let mut random = Random::new(5);
    for _ in 0..4000 {
        let one = One::random(&mut random);
        let mut out = random.direction();
        out[2] = out[2].abs().max(1e-3);
        let into = random.direction();
        let lanes = bsdf(&[one; LANES]).evaluate(&same_in_all_lanes(out), &same_in_all_lanes(into));
        let (value, pdf) = LayeredView::new(layered(&one), single(out)).evaluate(single(into));
        let near = |a: f32, b: f32| (a - b).abs() <= 2e-3 * (a.abs() + b.abs()) + 1e-6;
        for c in 0..3 {
            assert!(near(value[c], lanes.value[c][0]), "{value:?} {:?} {one:?} {out:?} {into:?}", lanes.value);
        }
        assert!(near(pdf, lanes.pdf[0]), "{pdf} {} {one:?} {out:?} {into:?}", lanes.pdf[0]);
    }
}

/// The pdf integrates to the share of samples that are valid; weights are BSDF * cosine / pdf; the mean weight is the
/// integral of the BSDF.
#[test]
fn samples_pdf_and_values_agree() {
    for (name, m) in rough_kinds() {
        for mu in [0.3, 0.8] {
            let out = viewer(mu);
            let view = LayeredView::new(m.clone(), single(out));
            let (mut integral, mut density) = ([0.0; 3], 0.0);
            for (into, solid_angle) in grid(800, 300) {
                let (value, pdf) = view.evaluate(into);
                (0..3).for_each(|c| integral[c] += f64::from(value[c]) * solid_angle);
                density += f64::from(pdf) * solid_angle;
            }
            let (mut drawn, mut valid) = ([0.0; 3], 0.0);
            const COUNT: usize = 200_000;
            let mut random = Random::new(3);
            for _ in 0..COUNT {
                // The lattice of `numbers` is not even in the digits of the choice that select a channel.
                let [u, v, choice] = [random.next(), random.next(), random.next()];
                let (sin, cos) = (TAU * v).sin_cos();
                let disk = single([u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt()]);
                let choice = (choice as f32).min(1.0 - f32::EPSILON);
                let sampled = view.sample(choice, disk);
                valid += if sampled.pdf > 0.0 { 1.0 / COUNT as f64 } else { 0.0 };
                (0..3).for_each(|c| drawn[c] += f64::from(sampled.weight[c]) / COUNT as f64);
                if sampled.pdf > 0.0 {
                    let (value, pdf) = view.evaluate(sampled.into);
                    assert_eq!(pdf, sampled.pdf, "{name}");
                    assert!((0..3).all(|c| (sampled.weight[c] * pdf - value[c]).abs() <= 1e-5 * value[c]), "{name}");
                    assert_eq!(sampled.transmitted, sampled.into[2] < 0.0);
                }
            }
            assert!((density - valid).abs() < 6e-3, "{name} {mu}: pdf {density}, samples {valid}");
            let near = (0..3).all(|c| (drawn[c] - integral[c]).abs() < 6e-3 * drawn[c].max(0.5));
            assert!(near, "{name} {mu}: {drawn:?} {integral:?}");
        }
    }
}

/// f(out, into) = f(into, out) for reflection and thin panes; eta^2 f(into, out) through the surface of a body.
#[test]
fn layered_surfaces_are_reciprocal() {
    let mut random = Random::new(11);
    // A lobe with a normal of its own is reciprocal with its own cosines alone.
    for (name, m) in rough_kinds().into_iter().filter(|(name, _)| *name != "tilted clearcoat") {
        for _ in 0..300 {
            let [mut out, into] = [random.direction(), random.direction()];
            out[2] = out[2].abs();
            if out[2] < 0.02 {
                continue;
            }
            let through = into[2] < 0.0;
            if into[2].abs() < 0.02 {
                continue;
            }
            let forth = LayeredView::new(m.clone(), single(out)).evaluate(single(into)).0;
            // Seen from the other side, the surface is mirrored, and the indices are inverse.
            let flip = |v: [f64; 3]| single(if through { [v[0], v[1], -v[2]] } else { v });
            let inverse = |eta: f32| if through && !m.thin { 1.0 / eta } else { eta };
            let other = Layered { eta: m.eta.map(inverse), ..m.clone() };
            let back = LayeredView::new(other, flip(into)).evaluate(flip(out)).0;
            for c in 0..3 {
                let spread = if through && !m.thin { m.eta[c] * m.eta[c] } else { 1.0 };
                let forth = f64::from(forth[c]) / into[2].abs() * f64::from(spread);
                let back = f64::from(back[c]) / out[2];
                assert!((forth - back).abs() <= 2e-3 * forth.max(back) + 1e-6, "{name} {c}: {forth} {back}");
            }
        }
    }
}

/// Layers over white surfaces gain nothing, and lose what the documentation of the modules says.
#[test]
fn white_surfaces_under_layers_lose_little() {
    for mu in [0.05, 0.1, 0.3, 0.6, 0.9, 1.0] {
        let out = viewer(mu);
        let lost = |m: &Layered| 1.0 - albedo(m, out)[0];
        for roughness in [0.0, 0.2, 0.5, 1.0] {
            for coat_roughness in [0.0, 0.3, 0.6, 1.0] {
                let coat = clearcoat(1.0, coat_roughness);
                let diffuse = lost(&Layered { clearcoat: coat, ..white(roughness) });
                assert!((-8e-3..0.05).contains(&diffuse), "clearcoat {roughness} {coat_roughness} {mu}: {diffuse}");
                let metal = layered(&One { roughness, ..WHITE_METAL });
                let metal = lost(&Layered { clearcoat: coat, ..metal });
                assert!((-8e-3..0.05).contains(&metal), "on metal {roughness} {coat_roughness} {mu}: {metal}");
            }
            for sheen_roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
                let lost = lost(&Layered { sheen: sheen(sheen_roughness), ..white(roughness) });
                assert!((-8e-3..0.14).contains(&lost), "sheen {roughness} {sheen_roughness} {mu}: {lost}");
            }
            let film = lost(&Layered { film: Some(FILM), ..white(roughness) });
            assert!((-8e-3..0.09).contains(&film), "film {roughness} {mu}: {film}");
            let film = lost(&Layered { film: Some(FILM), ..layered(&One { roughness, ..WHITE_METAL }) });
            assert!((-8e-3..8e-3).contains(&film), "film on metal {roughness} {mu}: {film}");
            let through = Layered { diffuse_transmission: 0.4, ..white(roughness) };
            assert!(lost(&through).abs() < 8e-3, "diffuse transmission {roughness} {mu}: {}", lost(&through));
        }
    }
}

/// White metal of anisotropic roughness keeps its energy but for the error of reading an isotropic table.
#[test]
fn anisotropic_metal_keeps_its_energy() {
    let mut worst = [0.0f64; 2];
    for roughness in [0.0f32, 0.2, 0.4, 0.7] {
        for strength in [0.3f32, 0.6, 1.0] {
            let alpha = roughness * roughness;
            let along = alpha + (1.0 - alpha) * strength * strength;
            let m = Layered { alpha: [along, alpha.max(1e-3)], ..layered(&One { roughness, ..WHITE_METAL }) };
            for mu in [0.05f64, 0.2, 0.5, 0.8, 1.0] {
                for azimuth in [0.0f64, 0.8, 1.57] {
                    let r = (1.0 - mu * mu).sqrt();
                    let gained = albedo(&m, [r * azimuth.cos(), r * azimuth.sin(), mu])[0] - 1.0;
                    worst = [worst[0].min(gained), worst[1].max(gained)];
                }
            }
        }
    }
    assert!(worst[0] > -0.13 && worst[1] < 0.02, "{worst:?}");
}

/// The table of sheen against the integral of the lobe.
#[test]
fn the_sheen_table_is_right() {
    for roughness in [0.1f32, 0.2, 0.35, 0.5, 0.77, 1.0] {
        let one = Sheen { color: [1.0; 3], alpha: (roughness * roughness).max(sheen::MIN_ALPHA) };
        for mu in [0.03, 0.1, 0.24, 0.5, 0.8, 1.0] {
            let out = viewer(mu);
            let sum: f64 = grid(1000, 200)
                .filter(|(into, _)| into[2] > 0.0)
                .map(|(into, solid_angle)| f64::from(one.value(single(out), into)) * solid_angle)
                .sum();
            let bound = f64::from(one.albedo(mu as f32));
            assert!(sum < bound + 0.01, "{roughness} {mu}: {sum} {bound}");
            // Only the division by E, where E exceeds 1, loses light.
            assert!(bound > 0.99 || sum > 0.8 * bound - 0.01, "{roughness} {mu}: {sum} {bound}");
        }
    }
}

/// No film and one of the index of air are the surface itself (but towards grazing incidence, where Schlick's term of
/// the extension reflects at an interface without contrast, too); the reflectance is between 0 and 1.
#[test]
fn a_film_without_thickness_or_contrast_changes_nothing() {
    for f0 in [0.02f32, 0.04, 0.5, 0.95] {
        for cosine in [0.9f32, 0.95, 1.0] {
            let plain = f0 + (1.0 - f0) * (1.0 - cosine).powi(5);
            for film in [Film { thickness_nm: 0.0, ..FILM }, Film { ior: 1.0, ..FILM }] {
                for reflected in film.reflectance(cosine, [f0; 3]) {
                    assert!((reflected - plain).abs() < 1e-2, "{f0} {cosine}: {reflected} {plain}");
                }
            }
            for step in 0..120 {
                let film = Film { thickness_nm: 10.0 * step as f32, ior: 1.8, factor: 1.0 };
                assert!(film.reflectance(cosine, [f0; 3]).iter().all(|r| (0.0..=1.0).contains(r)));
            }
        }
    }
}

/// A smooth dispersive body refracts every channel by its own index, with the mean of the channels' transmittance.
#[test]
fn dispersion_splits_refraction_without_bias() {
    let one = One { transmission: 1.0, ..WHITE_COATED };
    let m = Layered { eta: [1.45, 1.5, 1.6], ..layered(&one) };
    let out = viewer(0.6);
    let view = LayeredView::new(m.clone(), single(out));
    let mut sum = [0.0; 3];
    const COUNT: usize = 3 * 4096;
    for (choice, disk) in numbers(COUNT) {
        let sampled = view.sample(choice, disk);
        let carried = sampled.weight.iter().filter(|&&weight| weight > 0.0).count();
        assert_eq!(carried, if sampled.transmitted { 1 } else { 3 });
        for c in (0..3).filter(|&c| sampled.transmitted && sampled.weight[c] > 0.0) {
            let sine = (sampled.into[0].powi(2) + sampled.into[1].powi(2)).sqrt();
            assert!((sine * m.eta[c] - 0.8).abs() < 1e-5);
            sum[c] += f64::from(sampled.weight[c]) / COUNT as f64;
        }
    }
    for c in 0..3 {
        let interface = fresnel::interface(0.6, m.eta[c]);
        let weight = fresnel::grazing_weight(interface.reflected, m.eta[c]);
        let reflected = fresnel::interpolate(fresnel::normal_incidence(m.eta[c]), 1.0, weight);
        let exact = f64::from((1.0 - reflected) / (m.eta[c] * m.eta[c]));
        assert!((sum[c] - exact).abs() < 2e-3, "{c}: {} {exact}", sum[c]);
    }
}
