//! The GGX microfacet distribution.
//!
//! Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007), with height-correlated
//! Smith shadowing and masking (Heitz, JCGT 3, 2014; glTF 2.0, appendix B). With h the microfacet normal between `out`
//! and `into`, a the alpha, z the components along the shading normal, and s(z) = sqrt(a^2 + (1 - a^2) z^2):
//!
//! ```text
//! D  = a^2 / (pi ((h.x^2 + h.y^2) + a^2 h.z^2)^2)
//! G1 = 2 out.z / (out.z + s(out.z))
//! G2 = 2 out.z |into.z| / (out.z s(into.z) + |into.z| s(out.z))
//! ```
//!
//! Transmission uses the same G2, as pbrt and Cycles do. The uncorrelated product G1 G1, which Mitsuba uses for
//! reflection and transmission, is darker; heights correlated over both sides (a beta function, Heitz 2014) would be
//! darker still.
//!
//! Normals are sampled from the distribution of visible normals (Dupuy and Benyoub, "Sampling Visible GGX Normals with
//! Spherical Caps", HPG 2023), so that the weight is F G2 / G1. The cap is sampled from the same point of the unit disk
//! as the cosine-distributed direction, which preserves the stratification of the random numbers.
//!
//! D and the Jacobians use unnormalized half vectors as long as possible: near grazing incidence `out` and `into`
//! almost cancel.

use std::f32::consts::FRAC_1_PI;

use crate::simd::LANES;

/// Distributions with a smaller alpha are delta distributions: f32 directions do not resolve them.
pub(super) const SMOOTH_BELOW: f32 = 1e-3;

/// Bodies of glass whose relative index of refraction is this close to 1 have delta lobes for any alpha: the half
/// vector of `out` and `into` is ill-conditioned.
pub(super) const INDEX_MATCHED_BELOW: f32 = 1e-3;

/// The microfacets between `out` and `into`, as perfect mirrors or perfect refractors.
pub(super) struct Microfacets {
    /// The cosine of the microfacet normal for Fresnel's equations, and the relative index for it. On the side of
    /// `out`; for refraction on the side with the lower index, where there is no critical angle, at which the
    /// transmittance is ill-conditioned.
    pub cosine: [f32; LANES],
    pub eta: [f32; LANES],
    /// BSDF * |into.z|; 0 if no microfacet connects the directions.
    pub value: [f32; LANES],
    /// The pdf of `into` if a visible normal is sampled and used.
    pub pdf: [f32; LANES],
}

/// Samples visible normals as seen from `out`; `disk` holds points of the unit disk and the heights of the hemisphere
/// over them. Smooth lanes get the shading normal.
#[inline(always)]
pub(super) fn visible_normals(
    out: &[[f32; LANES]; 3],
    alpha: &[f32; LANES],
    smooth: &[bool; LANES],
    disk: &[[f32; LANES]; 3],
) -> [[f32; LANES]; 3] {
    let mut normal = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        // Transformed to the configuration in which the distribution is a hemisphere.
        let (x, y, z) = (alpha[lane] * out[0][lane], alpha[lane] * out[1][lane], out[2][lane]);
        let inverse = 1.0 / (x * x + y * y + z * z).max(1e-30).sqrt();
        let (x, y, z) = (x * inverse, y * inverse, z * inverse);
        // A point of the cap above -z, plus the direction to the viewer: a half vector.
        let height = disk[2][lane] * disk[2][lane];
        let spread = ((1.0 + z) * (2.0 - (1.0 - height) * (1.0 + z))).max(0.0).sqrt();
        let (x, y, z) = (disk[0][lane] * spread + x, disk[1][lane] * spread + y, (1.0 + z) * height);
        let (x, y) = (alpha[lane] * x, alpha[lane] * y);
        let inverse = 1.0 / (x * x + y * y + z * z).max(1e-30).sqrt();
        normal[0][lane] = if smooth[lane] { 0.0 } else { x * inverse };
        normal[1][lane] = if smooth[lane] { 0.0 } else { y * inverse };
        normal[2][lane] = if smooth[lane] { 1.0 } else { z * inverse };
    }
    normal
}

/// The microfacets between `out` and `into`: reflecting if `into` is above, transmitting if it is below. Transmission
/// refracts by `eta`; in a thin pane it scatters as the reflection does, to the other side.
#[inline(always)]
pub(super) fn microfacets(
    out: &[[f32; LANES]; 3],
    into: &[[f32; LANES]; 3],
    alpha: &[f32; LANES],
    eta: &[f32; LANES],
    thin: &[bool; LANES],
) -> Microfacets {
    let zero = [0.0; LANES];
    let mut microfacets = Microfacets { cosine: zero, eta: zero, value: zero, pdf: zero };
    for lane in 0..LANES {
        let alpha = alpha[lane].max(SMOOTH_BELOW);
        let square = alpha * alpha;
        let (ox, oy, oz) = (out[0][lane], out[1][lane], out[2][lane]);
        let below = into[2][lane] < 0.0;
        let bends = below & !thin[lane];
        let scale = if bends { eta[lane] } else { 1.0 };
        let height = into[2][lane].abs();
        let (ix, iy, iz) = (into[0][lane], into[1][lane], if bends { -height } else { height });

        let (hx, hy, hz) = (ox + scale * ix, oy + scale * iy, oz + scale * iz);
        let across = hx * hx + hy * hy;
        let inverse_square = 1.0 / (across + hz * hz).max(1e-30);
        // Between the square of alpha and 1, up to rounding.
        let bulk = ((across + square * (hz * hz)) * inverse_square).max(square);
        let density = FRAC_1_PI * square / (bulk * bulk);
        let to_unit = inverse_square.sqrt().copysign(hz);
        let cosine_out = (ox * hx + oy * hy + oz * hz) * to_unit;
        let cosine_into = (ix * hx + iy * hy + iz * hz) * to_unit;
        let cosine_into = if bends { -cosine_into } else { cosine_into };

        let spread_out = (square + (1.0 - square) * (oz * oz)).sqrt();
        let spread_into = (square + (1.0 - square) * (height * height)).sqrt();
        // The Jacobian relative to that of reflection; without n^2, which belongs to the pdf only.
        let jacobian = if bends { 4.0 * cosine_out * cosine_into * inverse_square } else { 1.0 };
        let scaled = if (cosine_out > 0.0) & (cosine_into > 0.0) { 0.5 * density * jacobian } else { 0.0 };
        let turned = bends & (scale < 1.0);
        let inverse = 1.0 / eta[lane];
        microfacets.cosine[lane] = if turned { cosine_into } else { cosine_out };
        microfacets.eta[lane] = if turned { inverse } else { eta[lane] };
        microfacets.value[lane] = scaled * (height / (oz * spread_into + height * spread_out));
        microfacets.pdf[lane] = scaled / (oz + spread_out) * (scale * scale);
    }
    microfacets
}
