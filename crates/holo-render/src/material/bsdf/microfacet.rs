//! Rough surfaces: mirrors too small to see, whose normals follow the GGX distribution.
//!
//! Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007), with the shadowing and masking
//! of Smith for correlated heights (Heitz, JCGT 3, 2014; glTF 2.0, appendix B). With h the normal of the facets that
//! lead from `out` to `into`, w the width, z the components along the shading normal and
//! s(z) = sqrt(w^2 + (1 - w^2) z^2):
//!
//! ```text
//! D  = w^2 / (pi ((h.x^2 + h.y^2) + w^2 h.z^2)^2)
//! G1 = 2 out.z / (out.z + s(out.z))
//! G2 = 2 out.z |into.z| / (out.z s(into.z) + |into.z| s(out.z))
//! ```
//!
//! Transmission uses the same G2, as pbrt and Cycles do. G1 times G1, which Mitsuba uses for reflection and transmission
//! alike, is darker; heights that are correlated over both sides (a beta function, Heitz 2014) would be darker still.
//!
//! Facets are drawn as `out` sees them (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG
//! 2023), which leaves the weight F G2 / G1. The cap is drawn from a point of the unit disk, the one that also makes a
//! cosine-distributed direction: neighbouring numbers stay neighbours.
//!
//! The lengths of the half vectors are kept out of D and of the Jacobians as long as possible: near the shading plane
//! `out` and `into` almost cancel.

use std::f32::consts::FRAC_1_PI;

use crate::simd::LANES;

/// Narrower distributions are perfectly smooth: f32 directions do not resolve them.
pub(super) const SMOOTH_BELOW: f32 = 1e-3;

/// Bodies of glass with an index of refraction so close to 1 are perfectly smooth whatever their width: `out` and
/// `into` no longer say which facet led from one to the other.
pub(super) const CLEAR_BELOW: f32 = 1e-3;

/// The facets that lead from `out` to `into`, all of them perfect mirrors or perfect windows.
pub(super) struct Facets {
    /// Cosine of their normal with the direction that Fresnel's equations are to be taken at, and their index from
    /// there: `out`, but for light that is bent the side where it is faster. There is no critical angle there, at which
    /// the share that gets through hangs on the root of a difference.
    pub cosine: [f32; LANES],
    pub eta: [f32; LANES],
    /// f |into.z|; 0 where no facet leads from one to the other.
    pub value: [f32; LANES],
    /// Density with which drawing a visible facet, and using it, gives `into`.
    pub pdf: [f32; LANES],
}

/// Normals as seen from `out`; `disk` holds points of the unit disk and the heights of the hemisphere over them.
/// Smooth lanes get the shading normal.
#[inline(always)]
pub(super) fn visible_normals(
    out: &[[f32; LANES]; 3],
    width: &[f32; LANES],
    smooth: &[bool; LANES],
    disk: &[[f32; LANES]; 3],
) -> [[f32; LANES]; 3] {
    let mut normal = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        // Stretched until the distribution is that of a hemisphere.
        let (x, y, z) = (width[lane] * out[0][lane], width[lane] * out[1][lane], out[2][lane]);
        let inverse = 1.0 / (x * x + y * y + z * z).max(1e-30).sqrt();
        let (x, y, z) = (x * inverse, y * inverse, z * inverse);
        // A point of the cap above -z, plus the viewer: a half vector.
        let height = disk[2][lane] * disk[2][lane];
        let spread = ((1.0 + z) * (2.0 - (1.0 - height) * (1.0 + z))).max(0.0).sqrt();
        let (x, y, z) = (disk[0][lane] * spread + x, disk[1][lane] * spread + y, (1.0 + z) * height);
        let (x, y) = (width[lane] * x, width[lane] * y);
        let inverse = 1.0 / (x * x + y * y + z * z).max(1e-30).sqrt();
        normal[0][lane] = if smooth[lane] { 0.0 } else { x * inverse };
        normal[1][lane] = if smooth[lane] { 0.0 } else { y * inverse };
        normal[2][lane] = if smooth[lane] { 1.0 } else { z * inverse };
    }
    normal
}

/// The facets between `out` and `into`: mirrors where `into` is above, windows where it is below. A window bends the
/// ray by `eta`; in a thin pane it does not, and scatters as the mirror does, only to the other side.
#[inline(always)]
pub(super) fn facets(
    out: &[[f32; LANES]; 3],
    into: &[[f32; LANES]; 3],
    width: &[f32; LANES],
    eta: &[f32; LANES],
    thin: &[bool; LANES],
) -> Facets {
    let zero = [0.0; LANES];
    let mut facets = Facets { cosine: zero, eta: zero, value: zero, pdf: zero };
    for lane in 0..LANES {
        let width = width[lane].max(SMOOTH_BELOW);
        let square = width * width;
        let (ox, oy, oz) = (out[0][lane], out[1][lane], out[2][lane]);
        let below = into[2][lane] < 0.0;
        let bends = below & !thin[lane];
        let scale = if bends { eta[lane] } else { 1.0 };
        let height = into[2][lane].abs();
        let (ix, iy, iz) = (into[0][lane], into[1][lane], if bends { -height } else { height });

        let (hx, hy, hz) = (ox + scale * ix, oy + scale * iy, oz + scale * iz);
        let across = hx * hx + hy * hy;
        let inverse_square = 1.0 / (across + hz * hz).max(1e-30);
        // Between the square of the width and 1, but for roundings.
        let bulk = ((across + square * (hz * hz)) * inverse_square).max(square);
        let density = FRAC_1_PI * square / (bulk * bulk);
        let to_unit = inverse_square.sqrt().copysign(hz);
        let cosine_out = (ox * hx + oy * hy + oz * hz) * to_unit;
        let cosine_into = (ix * hx + iy * hy + iz * hz) * to_unit;
        let cosine_into = if bends { -cosine_into } else { cosine_into };

        let spread_out = (square + (1.0 - square) * (oz * oz)).sqrt();
        let spread_into = (square + (1.0 - square) * (height * height)).sqrt();
        // Directions per facet, next to those of a mirror; without n^2, which belongs to the density alone.
        let jacobian = if bends { 4.0 * cosine_out * cosine_into * inverse_square } else { 1.0 };
        let scaled = if (cosine_out > 0.0) & (cosine_into > 0.0) { 0.5 * density * jacobian } else { 0.0 };
        let turned = bends & (scale < 1.0);
        let inverse = 1.0 / eta[lane];
        facets.cosine[lane] = if turned { cosine_into } else { cosine_out };
        facets.eta[lane] = if turned { inverse } else { eta[lane] };
        facets.value[lane] = scaled * (height / (oz * spread_into + height * spread_out));
        facets.pdf[lane] = scaled / (oz + spread_out) * (scale * scale);
    }
    facets
}
