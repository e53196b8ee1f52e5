//! Quadrature over all directions, independent of the code under test.
//!
//! Points of a Fibonacci lattice are mapped to where the integrand is large: by the cosine, by reflection and by
//! refraction at microfacets, with the visible normals of Heitz ("Sampling the GGX Distribution of Visible Normals",
//! JCGT 7, 2018; another construction than that of microfacet.rs), in f64. The weight of a direction is the inverse of
//! the sum of the three pdfs (the balance heuristic of Veach).

use std::f64::consts::{PI, TAU};

use super::{One, bsdf};
use crate::material::bsdf::Directions;
use crate::simd::LANES;

pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The GGX distribution of a unit normal, textbook form.
pub(super) fn distribution(h: Vector, alpha: f64) -> f64 {
    let square = alpha * alpha;
    square / (PI * (h[2] * h[2] * (square - 1.0) + 1.0).powi(2))
}

/// Smith's Lambda function of the cosine `z`.
pub(super) fn lambda(z: f64, alpha: f64) -> f64 {
    let tangent = (1.0 - z * z).max(0.0) / (z * z);
    ((1.0 + alpha * alpha * tangent).sqrt() - 1.0) / 2.0
}

/// The pdf of visible normals.
pub(super) fn visible(out: Vector, h: Vector, alpha: f64) -> f64 {
    dot(out, h).max(0.0) * distribution(h, alpha) / (out[2] * (1.0 + lambda(out[2], alpha)))
}

/// The unit microfacet normal between two directions, on the side of the viewer; `eta` is 1 for reflection.
pub(super) fn half_vector(out: Vector, into: Vector, eta: f64) -> Vector {
    let h = unit([out[0] + eta * into[0], out[1] + eta * into[1], out[2] + eta * into[2]]);
    h.map(|x| x * h[2].signum())
}

/// Samples a visible normal by the method of Heitz (2018).
pub(super) fn draw_normal(out: Vector, alpha: f64, [u, v]: [f64; 2]) -> Vector {
    let view = unit([alpha * out[0], alpha * out[1], out[2]]);
    let flat = view[0].hypot(view[1]);
    let first = if flat > 0.0 { [-view[1] / flat, view[0] / flat, 0.0] } else { [1.0, 0.0, 0.0] };
    let second = cross(view, first);
    let (sin, cos) = (TAU * v).sin_cos();
    let a = u.sqrt() * cos;
    let share = 0.5 * (1.0 + view[2]);
    let b = (1.0 - share) * (1.0 - a * a).sqrt() + share * u.sqrt() * sin;
    let c = (1.0 - a * a - b * b).max(0.0).sqrt();
    let normal: Vector = std::array::from_fn(|k| a * first[k] + b * second[k] + c * view[k]);
    unit([alpha * normal[0], alpha * normal[1], normal[2].max(1e-12)])
}

/// Sixteen directions with their weights.
pub(super) struct Nodes {
    pub into: Directions,
    pub weight: [f64; LANES],
}

/// Consecutive Fibonacci numbers. Results are within 2e-4 of those of 46368 points.
pub(super) const LATTICE: [usize; 2] = [4181, 2584];

/// The nodes of the quadrature over the sphere for the BSDF `one` and a viewer at `out`.
pub(super) fn nodes(one: &One, out: Vector) -> Vec<Nodes> {
    let [count, step] = LATTICE;
    let alpha = f64::from(one.alpha()).max(1e-3);
    let eta = if one.thin { 1.0 } else { f64::from(one.eta) };
    let windows = one.thin || (eta - 1.0).abs() >= 1e-3;
    let density = |into: Vector| {
        if into[2] >= 0.0 {
            let h = half_vector(out, into, 1.0);
            return into[2] / PI + visible(out, h, alpha) / (4.0 * dot(out, h));
        }
        if one.thin {
            let h = half_vector(out, [into[0], into[1], -into[2]], 1.0);
            return visible(out, h, alpha) / (4.0 * dot(out, h));
        }
        let h = half_vector(out, into, eta);
        let (o, i) = (dot(out, h), -dot(into, h));
        if o <= 0.0 || i <= 0.0 {
            return f64::INFINITY;
        }
        visible(out, h, alpha) * eta * eta * i / (o - eta * i).powi(2)
    };
    let mut directions = Vec::new();
    for k in 0..count {
        let point = [(k as f64 + 0.5) / count as f64, (k * step % count) as f64 / count as f64];
        let (sin, cos) = (TAU * point[1]).sin_cos();
        directions.push([point[0].sqrt() * cos, point[0].sqrt() * sin, (1.0 - point[0]).sqrt()]);
        let h = draw_normal(out, alpha, point);
        let c = dot(out, h);
        let mirrored: Vector = std::array::from_fn(|axis| 2.0 * c * h[axis] - out[axis]);
        if mirrored[2] > 0.0 {
            directions.push(mirrored);
            if one.thin {
                directions.push([mirrored[0], mirrored[1], -mirrored[2]]);
            }
        }
        if windows && !one.thin {
            directions.extend(crate::material::bsdf::exact::refract(out, h, c, eta).filter(|into| into[2] < 0.0));
        }
    }
    // Padded with nodes of weight 0.
    directions.resize(directions.len().next_multiple_of(LANES), [0.0; 3]);
    directions
        .chunks_exact(LANES)
        .map(|chunk| {
            let mut nodes = Nodes { into: [[0.0; LANES]; 3], weight: [0.0; LANES] };
            for (lane, into) in chunk.iter().enumerate() {
                if *into == [0.0; 3] {
                    nodes.into[2][lane] = 1.0;
                    continue;
                }
                for axis in 0..3 {
                    nodes.into[axis][lane] = into[axis] as f32;
                }
                nodes.weight[lane] = 1.0 / (count as f64 * density(*into));
            }
            nodes
        })
        .collect()
}

/// The reflected and transmitted light under constant illumination.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Total {
    /// Reflected.
    pub above: Vector,
    /// Transmitted radiance (without eta^2).
    pub below: Vector,
    pub pdf: f64,
}

/// The integral of `evaluate`.
pub(super) fn integrate(one: &One, out: Vector) -> Total {
    let surfaces = bsdf(&[*one; LANES]);
    let viewer = super::same_in_all_lanes(out);
    let mut total = Total::default();
    for nodes in nodes(one, out) {
        let evaluated = surfaces.evaluate(&viewer, &nodes.into);
        for lane in 0..LANES {
            let side = if nodes.into[2][lane] < 0.0 { &mut total.below } else { &mut total.above };
            for c in 0..3 {
                side[c] += f64::from(evaluated.value[c][lane]) * nodes.weight[lane];
            }
            total.pdf += f64::from(evaluated.pdf[lane]) * nodes.weight[lane];
        }
    }
    total
}

/// The quadrature itself: it gives the cosine-weighted solid angle, and for wide lobes the result of a plain grid.
#[test]
fn the_rule_agrees_with_a_plain_grid() {
    for (roughness, mu, eta, thin) in
        [(0.5f32, 0.6, 1.5f32, false), (0.7, 0.3, 1.5, true), (1.0, 0.1, 1.0 / 1.5, false), (0.7, 1.0, 2.4, false)]
    {
        let one = One { metallic: 0.2, transmission: 0.5, roughness, eta, thin, ..super::WHITE_COATED };
        let out = super::viewer(mu);
        let mut cosine = 0.0;
        for nodes in nodes(&one, out) {
            cosine += (0..LANES).map(|k| f64::from(nodes.into[2][k].max(0.0)) * nodes.weight[k]).sum::<f64>();
        }
        assert!((cosine / PI - 1.0).abs() < 1e-3, "{cosine}");

        let led = integrate(&one, out);
        let (surfaces, viewer) = (super::all(one), super::same_in_all_lanes(out));
        let (rows, columns) = (768, 256);
        let mut plain = Total::default();
        for row in 0..rows {
            for first in (0..columns).step_by(LANES) {
                let into = super::lanes_of(&std::array::from_fn(|lane| {
                    // Finer towards grazing incidence.
                    let t = 2.0 * (f64::from(row) + 0.5) / f64::from(rows) - 1.0;
                    let z = t.abs() * t;
                    let (sin, cos) = (TAU * (first + lane) as f64 / columns as f64).sin_cos();
                    let r = (1.0 - z * z).sqrt();
                    [r * cos, r * sin, z]
                }));
                let evaluated = surfaces.evaluate(&viewer, &into);
                let t = 2.0 * (f64::from(row) + 0.5) / f64::from(rows) - 1.0;
                let weight = 2.0 * t.abs() * 2.0 / f64::from(rows) * TAU / columns as f64;
                for lane in 0..LANES {
                    let side = if t < 0.0 { &mut plain.below } else { &mut plain.above };
                    for c in 0..3 {
                        side[c] += f64::from(evaluated.value[c][lane]) * weight;
                    }
                    plain.pdf += f64::from(evaluated.pdf[lane]) * weight;
                }
            }
        }
        for (a, b) in [(led.above[0], plain.above[0]), (led.below[0], plain.below[0]), (led.pdf, plain.pdf)] {
            assert!((a - b).abs() < 1e-3, "{led:?} {plain:?}");
        }
    }
}
