//! Anisotropic GGX microfacets of one lane: [`super::super::microfacet`] with an alpha along the tangent and one across
//! it.
//!
//! Source: Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs" (JCGT 3, 2014), sections 5.3
//! and 5.4. With s(v) = sqrt((a.x v.x)^2 + (a.y v.y)^2 + v.z^2):
//!
//! ```text
//! D  = 1 / (pi a.x a.y ((h.x / a.x)^2 + (h.y / a.y)^2 + h.z^2)^2)
//! G1 = 2 out.z / (out.z + s(out))
//! G2 = 2 out.z |into.z| / (out.z s(into) + |into.z| s(out))
//! ```

use std::f32::consts::FRAC_1_PI;

use super::super::fresnel;
use super::super::microfacet::SMOOTH_BELOW;
use super::{Vector, dot, unit};

/// The microfacet between two directions; fields as in [`super::super::microfacet::Microfacets`].
pub(super) struct Facet {
    pub cosine: f32,
    pub eta: f32,
    pub value: f32,
    pub pdf: f32,
}

impl Facet {
    /// The microfacet that reflects `into` to `out` if `into` is above, and transmits it if it is below.
    pub fn new(out: Vector, into: Vector, alpha: [f32; 2], eta: f32, thin: bool) -> Self {
        let [ax, ay] = alpha.map(|alpha| alpha.max(SMOOTH_BELOW));
        let bends = (into[2] < 0.0) & !thin;
        let scale = if bends { eta } else { 1.0 };
        let height = into[2].abs();
        let toward = [into[0], into[1], if bends { -height } else { height }];
        let h = [out[0] + scale * toward[0], out[1] + scale * toward[1], out[2] + scale * toward[2]];
        let inverse_square = 1.0 / dot(h, h).max(1e-30);
        // Unnormalized as long as possible: near grazing incidence `out` and `into` almost cancel.
        let (x, y) = (h[0] / ax, h[1] / ay);
        let bulk = ((x * x + y * y + h[2] * h[2]) * inverse_square).max(1e-30);
        let density = FRAC_1_PI / (ax * ay * (bulk * bulk));
        let to_unit = inverse_square.sqrt().copysign(h[2]);
        let cosine_out = dot(out, h) * to_unit;
        let cosine_into = dot(toward, h) * if bends { -to_unit } else { to_unit };
        let spread = |v: Vector| ((ax * v[0]).powi(2) + (ay * v[1]).powi(2) + v[2] * v[2]).sqrt();
        let (spread_out, spread_into) = (spread(out), spread(into));
        let jacobian = if bends { 4.0 * cosine_out * cosine_into * inverse_square } else { 1.0 };
        let scaled = if (cosine_out > 0.0) & (cosine_into > 0.0) { 0.5 * density * jacobian } else { 0.0 };
        let turned = bends & (scale < 1.0);
        Self {
            cosine: if turned { cosine_into } else { cosine_out },
            eta: if turned { 1.0 / eta } else { eta },
            value: scaled * (height / (out[2] * spread_into + height * spread_out)),
            pdf: scaled / (out[2] + spread_out) * (scale * scale),
        }
    }
}

/// The number of visible normals by which [`albedo`] integrates; consecutive Fibonacci numbers with the next one.
const LATTICE: [usize; 2] = [34, 21];

/// The albedo W of anisotropic microfacets with a reflectance of 1 for light towards `out`, and the excess R of
/// Schlick's term (see [`super::super::albedo`]), with an error of about 0.01.
pub(super) fn albedo(out: Vector, alpha: [f32; 2]) -> [f32; 2] {
    let [count, step] = LATTICE;
    let [ax, ay] = alpha.map(|alpha| alpha.max(SMOOTH_BELOW));
    let spread = |v: Vector| ((ax * v[0]).powi(2) + (ay * v[1]).powi(2) + v[2] * v[2]).sqrt();
    let out = [out[0], out[1], out[2].max(1e-4)];
    let (mut scale, mut grazing) = (0.0, 0.0);
    // The angles of the lattice are multiples of one, by repeated rotation.
    let (sin, cos) = ROTATION;
    let mut turned = [1.0f32, 0.0];
    let mut rotations = [[0.0; 2]; LATTICE[0]];
    for rotation in &mut rotations {
        *rotation = turned;
        turned = [turned[0] * cos - turned[1] * sin, turned[0] * sin + turned[1] * cos];
    }
    for k in 0..count {
        let square = (k as f32 + 0.5) / count as f32;
        let [x, y] = rotations[k * step % count].map(|x| x * square.sqrt());
        let normal = visible_normal(out, alpha, [x, y, (1.0 - square).sqrt()]);
        let cosine = dot(out, normal);
        let into: Vector = std::array::from_fn(|axis| 2.0 * cosine * normal[axis] - out[axis]);
        if into[2] <= 0.0 {
            continue;
        }
        let (there, here) = (spread(into), spread(out));
        let share = (out[2] + here) * into[2] / (out[2] * there + into[2] * here) / count as f32;
        scale += share;
        grazing += share * fresnel::schlick(cosine);
    }
    [scale, grazing - scale * fresnel::schlick(out[2])]
}

/// Sine and cosine of 1/34 turn.
const ROTATION: (f32, f32) = (0.183_749_52, 0.982_973_1);

/// Samples a visible normal as seen from `out`; `disk` is a point of the unit disk with the height of the hemisphere
/// over it (Dupuy and Benyoub, 2023).
pub(super) fn visible_normal(out: Vector, alpha: [f32; 2], disk: Vector) -> Vector {
    let [ax, ay] = alpha.map(|alpha| alpha.max(SMOOTH_BELOW));
    let [x, y, z] = unit([ax * out[0], ay * out[1], out[2]]);
    let height = disk[2] * disk[2];
    let spread = ((1.0 + z) * (2.0 - (1.0 - height) * (1.0 + z))).max(0.0).sqrt();
    unit([ax * (disk[0] * spread + x), ay * (disk[1] * spread + y), (1.0 + z) * height])
}
