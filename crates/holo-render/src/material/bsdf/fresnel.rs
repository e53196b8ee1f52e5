//! Fresnel reflectance and refraction.
//!
//! Metals and coats use Schlick's approximation (1994), as specified by glTF 2.0 (appendix B). Glass uses Fresnel's
//! equations for unpolarized light. With c the cosine on the side of the viewer, n the index of refraction behind the
//! surface relative to that in front of it, and g = sqrt(n^2 - 1 + c^2), which is n times the cosine behind it:
//!
//! ```text
//! F = ((c - g)^2 / (c + g)^2 + (n^2 c - g)^2 / (n^2 c + g)^2) / 2,    1 where n^2 - 1 + c^2 <= 0 (total reflection)
//! ```
//!
//! # Accuracy
//! g^2 is a difference that cancels at the critical angle, and g is its root, so an error of e in g^2 may cause an
//! error of sqrt(e) in F. It is therefore computed in f64, where the squares of f32 are exact. F has an error below
//! 1e-6 for every f32 cosine down to 1e-8 and every n from 1e-3 to 1e3; refracted directions have this accuracy for the
//! indices of real materials. These bounds hold for the cosine as given: rounding the cosine itself by half a unit in
//! the last place changes F at the critical angle by 2^-11 (1 + n^-2).

use crate::simd::LANES;

/// Cosines are clamped to this minimum, whose square fits into f32.
const MIN_COSINE: f32 = 1e-12;

/// Fresnel's equations at one angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// The reflectance.
    pub reflected: f32,
    /// The cosine of the refracted ray with the normal, times n; 0 for total internal reflection.
    pub scaled_cosine: f32,
    /// Total internal reflection.
    pub total: bool,
}

/// Fresnel's equations at `cosine` on the side of the viewer; `eta` is n.
#[inline(always)]
pub(super) fn interface(cosine: f32, eta: f32) -> Interface {
    let c = cosine.max(MIN_COSINE);
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

/// The directions from which rays towards `out` (to the viewer) are refracted by microfacets with the normals `normal`,
/// given the cosines of `out` with the normals and `scaled_cosine` of [`interface`]. All are unit vectors. The result
/// is unspecified for total internal reflection.
#[inline(always)]
pub(super) fn refract(
    out: &[[f32; LANES]; 3],
    normal: &[[f32; LANES]; 3],
    cosine: &[f32; LANES],
    scaled_cosine: &[f32; LANES],
) -> [[f32; LANES]; 3] {
    let mut into = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        // The component of `out` along the microfacet, times n; only the direction of the result matters.
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

/// The reflectance at normal incidence for an index of refraction (or its inverse).
#[inline(always)]
pub(crate) fn normal_incidence(eta: f32) -> f32 {
    let root = (eta - 1.0) / (eta + 1.0);
    root * root
}

/// The interpolation weight of a Fresnel reflectance of glass between normal (0) and grazing incidence (1).
/// KHR_materials_specular specifies the two ends, Fresnel's equations the weight. Slightly below 0 around Brewster's
/// angle.
#[inline(always)]
pub(super) fn grazing_weight(reflected: f32, eta: f32) -> f32 {
    let sum = eta + 1.0;
    (reflected - normal_incidence(eta)) * (sum * sum / (4.0 * eta))
}

/// Schlick's interpolation weight: (1 - cosine)^5.
#[inline(always)]
pub(super) fn schlick(cosine: f32) -> f32 {
    let x = (1.0 - cosine).clamp(0.0, 1.0);
    let square = x * x;
    square * square * x
}

/// Interpolates between the reflectances `f0` at normal and `f90` at grazing incidence; clamped to 0..1.
#[inline(always)]
pub(super) fn interpolate(f0: f32, f90: f32, schlick_weight: f32) -> f32 {
    (f0 + (f90 - f0) * schlick_weight).clamp(0.0, 1.0)
}
