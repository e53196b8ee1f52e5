//! How much a surface reflects at an angle, and where it bends what it lets through.
//!
//! Metals and varnish follow Schlick's approximation (1994), as glTF 2.0 asks (appendix B). Glass follows Fresnel's
//! equations for unpolarised light. With c the cosine on the viewer's side, n the index of refraction behind the
//! surface over that in front of it, and g = sqrt(n^2 - 1 + c^2), which is n times the cosine behind it:
//!
//! ```text
//! F = ((c - g)^2 / (c + g)^2 + (n^2 c - g)^2 / (n^2 c + g)^2) / 2,    1 where n^2 - 1 + c^2 <= 0 (total reflection)
//! ```
//!
//! # Accuracy
//! g^2 is a difference that cancels at the critical angle, and g is its root: an error of e in g^2 may be one of
//! sqrt(e) in F. It is therefore taken in f64, where the squares of f32 are exact. F is within 1e-6 for every f32 cosine
//! down to 1e-8 and every n from 1e-3 to 1e3, and refracted directions are for the indices of real matter. That is for
//! the cosine as it is given: one that is itself rounded by half a unit in the last place moves F at the critical angle
//! by 2^-11 (1 + n^-2), which no formula can help.

use crate::simd::LANES;

/// Cosines below this are raised to it: its square stays within f32.
const SMALLEST_COSINE: f32 = 1e-12;

/// Fresnel's equations at one angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// Share that is reflected.
    pub reflected: f32,
    /// Cosine of the refracted ray with the normal, times n; 0 under total reflection.
    pub scaled_cosine: f32,
    /// Nothing gets through.
    pub total: bool,
}

/// What happens at an interface under `cosine` (the incident one), `eta` being n.
#[inline(always)]
pub(super) fn interface(cosine: f32, eta: f32) -> Interface {
    let c = cosine.max(SMALLEST_COSINE);
    let (wide_c, wide_eta) = (f64::from(c), f64::from(eta));
    let square = ((wide_eta * wide_eta - 1.0) + wide_c * wide_c) as f32;
    let total = square <= 0.0;
    let g = square.max(0.0).sqrt();
    let bent = eta * eta * c;
    let across = (c - g) / (c + g);
    let along = (bent - g) / (bent + g);
    let reflected = 0.5 * (across * across + along * along);
    Interface { reflected: if total { 1.0 } else { reflected }, scaled_cosine: g, total }
}

/// Where rays of direction `out` (towards the viewer) come from through facets of normal `normal`, with the cosines of
/// `out` with the normals and what [`interface`] says of them. Unit vectors; what it gives under total reflection means
/// nothing.
#[inline(always)]
pub(super) fn refract(
    out: &[[f32; LANES]; 3],
    normal: &[[f32; LANES]; 3],
    cosine: &[f32; LANES],
    scaled_cosine: &[f32; LANES],
) -> [[f32; LANES]; 3] {
    let mut into = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        // The part of `out` along the facet keeps its length times n, whatever n: only directions matter here.
        let x = cosine[lane] * normal[0][lane] - out[0][lane] - scaled_cosine[lane] * normal[0][lane];
        let y = cosine[lane] * normal[1][lane] - out[1][lane] - scaled_cosine[lane] * normal[1][lane];
        let z = cosine[lane] * normal[2][lane] - out[2][lane] - scaled_cosine[lane] * normal[2][lane];
        let inverse = 1.0 / (x * x + y * y + z * z).max(1e-30).sqrt();
        into[0][lane] = x * inverse;
        into[1][lane] = y * inverse;
        into[2][lane] = z * inverse;
    }
    into
}

/// The reflectance at normal incidence that belongs to an index of refraction (or its inverse).
#[inline(always)]
pub(crate) fn normal_incidence(eta: f32) -> f32 {
    let root = (eta - 1.0) / (eta + 1.0);
    root * root
}

/// How far on the way from normal (0) to grazing incidence (1) a reflectance of glass is: KHR_materials_specular gives
/// the two ends, Fresnel's equations what lies between. A little below 0 around Brewster's angle.
#[inline(always)]
pub(super) fn towards_grazing(reflected: f32, eta: f32) -> f32 {
    let sum = eta + 1.0;
    (reflected - normal_incidence(eta)) * (sum * sum / (4.0 * eta))
}

/// The same by Schlick: the fifth power of 1 - cosine.
#[inline(always)]
pub(super) fn schlick(cosine: f32) -> f32 {
    let x = (1.0 - cosine).clamp(0.0, 1.0);
    let square = x * x;
    square * square * x
}

/// A reflectance of `f0` at normal and `f90` at grazing incidence; a share, whatever `way`.
#[inline(always)]
pub(super) fn between(f0: f32, f90: f32, way: f32) -> f32 {
    (f0 + (f90 - f0) * way).clamp(0.0, 1.0)
}
