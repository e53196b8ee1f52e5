//! Integrals over all directions, by rules that know nothing of the code under test.
//!
//! Points of Fibonacci's lattice are led to where the integrand is: over the cosine, over mirror facets and over windows,
//! with the visible normals of Heitz ("Sampling the GGX Distribution of Visible Normals", JCGT 7, 2018; another
//! construction than the one in microfacet.rs), in f64. A direction counts by the inverse of the sum of the three
//! densities (Veach's balance heuristic).

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

/// GGX by the textbook: distribution of a unit normal.
pub(super) fn distribution(h: Vector, width: f64) -> f64 {
    let square = width * width;
    square / (PI * (h[2] * h[2] * (square - 1.0) + 1.0).powi(2))
}

/// Smith's auxiliary function of the cosine `z`.
pub(super) fn lambda(z: f64, width: f64) -> f64 {
    let tangent = (1.0 - z * z).max(0.0) / (z * z);
    ((1.0 + width * width * tangent).sqrt() - 1.0) / 2.0
}

/// Density of visible normals.
pub(super) fn visible(out: Vector, h: Vector, width: f64) -> f64 {
    dot(out, h).max(0.0) * distribution(h, width) / (out[2] * (1.0 + lambda(out[2], width)))
}

/// The unit facet normal between two directions, on the viewer's side; `eta` is 1 for mirrors.
pub(super) fn half_vector(out: Vector, into: Vector, eta: f64) -> Vector {
    let h = unit([out[0] + eta * into[0], out[1] + eta * into[1], out[2] + eta * into[2]]);
    h.map(|x| x * h[2].signum())
}

/// A visible normal, by Heitz' method of 2018.
pub(super) fn draw_normal(out: Vector, width: f64, [u, v]: [f64; 2]) -> Vector {
    let view = unit([width * out[0], width * out[1], out[2]]);
    let flat = view[0].hypot(view[1]);
    let first = if flat > 0.0 { [-view[1] / flat, view[0] / flat, 0.0] } else { [1.0, 0.0, 0.0] };
    let second = cross(view, first);
    let (sin, cos) = (TAU * v).sin_cos();
    let a = u.sqrt() * cos;
    let share = 0.5 * (1.0 + view[2]);
    let b = (1.0 - share) * (1.0 - a * a).sqrt() + share * u.sqrt() * sin;
    let c = (1.0 - a * a - b * b).max(0.0).sqrt();
    let normal: Vector = std::array::from_fn(|k| a * first[k] + b * second[k] + c * view[k]);
    unit([width * normal[0], width * normal[1], normal[2].max(1e-12)])
}

/// Sixteen directions with their weights.
pub(super) struct Nodes {
    pub into: Directions,
    pub weight: [f64; LANES],
}

/// Consecutive numbers of Fibonacci. Results are within 2e-4 of those of 46368 points.
pub(super) const LATTICE: [usize; 2] = [4181, 2584];

/// Integrates over the sphere what `one` does with light for a viewer at `out`.
pub(super) fn nodes(one: &One, out: Vector) -> Vec<Nodes> {
    let [count, step] = LATTICE;
    let width = f64::from(one.width()).max(1e-3);
    let eta = if one.thin { 1.0 } else { f64::from(one.eta) };
    let windows = one.thin || (eta - 1.0).abs() >= 1e-3;
    let density = |into: Vector| {
        if into[2] >= 0.0 {
            let h = half_vector(out, into, 1.0);
            return into[2] / PI + visible(out, h, width) / (4.0 * dot(out, h));
        }
        if one.thin {
            let h = half_vector(out, [into[0], into[1], -into[2]], 1.0);
            return visible(out, h, width) / (4.0 * dot(out, h));
        }
        let h = half_vector(out, into, eta);
        let (o, i) = (dot(out, h), -dot(into, h));
        if o <= 0.0 || i <= 0.0 {
            return f64::INFINITY;
        }
        visible(out, h, width) * eta * eta * i / (o - eta * i).powi(2)
    };
    let mut directions = Vec::new();
    for k in 0..count {
        let point = [(k as f64 + 0.5) / count as f64, (k * step % count) as f64 / count as f64];
        let (sin, cos) = (TAU * point[1]).sin_cos();
        directions.push([point[0].sqrt() * cos, point[0].sqrt() * sin, (1.0 - point[0]).sqrt()]);
        let h = draw_normal(out, width, point);
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
    // Padded with what weighs nothing.
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

/// What comes back of light from everywhere.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Total {
    /// Reflected.
    pub above: Vector,
    /// Let through, as radiance is (without eta^2).
    pub below: Vector,
    pub pdf: f64,
}

/// The integral of `evaluate`.
pub(super) fn integrate(one: &One, out: Vector) -> Total {
    let surfaces = bsdf(&[*one; LANES]);
    let viewer = super::single(out);
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

/// The rule itself: it gives the solid angle under the cosine, and what a plain grid gives, without leading points
/// anywhere, for lobes wide enough for one.
#[test]
fn the_rule_agrees_with_a_plain_grid() {
    for (roughness, mu, eta, thin) in
        [(0.5f32, 0.6, 1.5f32, false), (0.7, 0.3, 1.5, true), (1.0, 0.1, 1.0 / 1.5, false), (0.7, 1.0, 2.4, false)]
    {
        let one = One { metallic: 0.2, transmission: 0.5, roughness, eta, thin, ..super::WHITE_VARNISH };
        let out = super::viewer(mu);
        let mut cosine = 0.0;
        for nodes in nodes(&one, out) {
            cosine += (0..LANES).map(|k| f64::from(nodes.into[2][k].max(0.0)) * nodes.weight[k]).sum::<f64>();
        }
        assert!((cosine / PI - 1.0).abs() < 1e-3, "{cosine}");

        let led = integrate(&one, out);
        let (surfaces, viewer) = (super::all(one), super::single(out));
        let (rows, columns) = (768, 256);
        let mut plain = Total::default();
        for row in 0..rows {
            for first in (0..columns).step_by(LANES) {
                let into = super::lanes_of(&std::array::from_fn(|lane| {
                    // Even in the cube root of the cosine: finer towards the surface.
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
