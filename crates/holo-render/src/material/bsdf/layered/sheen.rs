//! Sheen: a layer of fibers over a surface.
//!
//! Source: Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF" (SIGGRAPH 2017 course), as in
//! KHR_materials_sheen: with a the square of the roughness and h the half vector,
//!
//! ```text
//! f = color D G / (4 out.z into.z),   D = (2 + 1/a) (1 - h.z^2)^(1/(2 a)) / (2 pi),   G = 1 / (1 + L(out) + L(into))
//! ```
//!
//! with their fit of L. What the layer leaves of the light reaches the surface below: 1 - the strongest channel of the
//! color times E, of the direction for which that is less, where E is the directional albedo of white sheen.
//!
//! # Accuracy
//! E is tabulated over 32 cosines and 32 alphas at first use, and interpolated bilinearly; it has an error below 0.01
//! for alphas of [`MIN_ALPHA`] and above (verified by a test). At grazing angles the fit reflects more light than there
//! is, up to E = 2 at a roughness of 0.1; the lobe is divided by E there, of the direction for which that is more.

use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

use super::Vector;

/// The smallest alpha: narrower distributions reflect at grazing angles alone, and their table would need more nodes.
pub(crate) const MIN_ALPHA: f32 = 0.01;

const NODES: usize = 32;

/// Sheen over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sheen {
    /// Linear RGB, 0 to 1.
    pub color: [f32; 3],
    /// The square of the roughness, at least [`MIN_ALPHA`].
    pub alpha: f32,
}

impl Sheen {
    /// BSDF * into.z of directions above the surface, for a white color.
    pub fn value(&self, out: Vector, into: Vector) -> f32 {
        let h = [out[0] + into[0], out[1] + into[1], out[2] + into[2]];
        let across = h[0] * h[0] + h[1] * h[1];
        let square = across / (across + h[2] * h[2]).max(1e-30);
        let density = distribution(f64::from(square), f64::from(self.alpha)) as f32;
        let shadowed = 1.0
            + lambda(f64::from(out[2]), f64::from(self.alpha)) as f32
            + lambda(f64::from(into[2]), f64::from(self.alpha)) as f32;
        let excess = self.table(out[2]).max(self.table(into[2])).max(1.0);
        density / (4.0 * out[2] * shadowed * excess)
    }

    /// An upper bound of the directional albedo of white sheen, at most 1; the albedo itself but for what the division
    /// by E takes.
    pub fn albedo(&self, cosine: f32) -> f32 {
        self.table(cosine).clamp(0.0, 1.0)
    }

    /// E of the fit, which may exceed 1.
    fn table(&self, cosine: f32) -> f32 {
        static TABLE: OnceLock<Box<[[f32; NODES]; NODES]>> = OnceLock::new();
        let table = TABLE.get_or_init(tabulate);
        let place = |x: f32| (x.clamp(0.0, 1.0) * (NODES - 1) as f32).min((NODES - 1) as f32 - 1e-3);
        let row = place(((self.alpha - MIN_ALPHA) / (1.0 - MIN_ALPHA)).max(0.0).sqrt());
        let column = place(cosine.max(0.0).sqrt());
        let (r, c) = (row as usize, column as usize);
        let (up, right) = (row - r as f32, column - c as f32);
        let along = |r: usize| table[r][c] + (table[r][c + 1] - table[r][c]) * right;
        let low = along(r);
        low + (along(r + 1) - low) * up
    }
}

/// D of the squared sine of the half vector.
fn distribution(square: f64, alpha: f64) -> f64 {
    let inverse = 1.0 / alpha;
    (2.0 + inverse) * square.clamp(0.0, 1.0).powf(0.5 * inverse) / (2.0 * std::f64::consts::PI)
}

/// The fit of Lambda: curves for alpha 0 and 1, mixed by (1 - alpha)^2, and mirrored at a cosine of 1/2.
fn lambda(cosine: f64, alpha: f64) -> f64 {
    const SMOOTH: [f64; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
    const ROUGH: [f64; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
    let share = (1.0 - alpha) * (1.0 - alpha);
    let [a, b, c, d, e]: [f64; 5] = std::array::from_fn(|k| ROUGH[k] + (SMOOTH[k] - ROUGH[k]) * share);
    let fit = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
    let cosine = cosine.clamp(0.0, 1.0);
    if cosine < 0.5 { fit(cosine).exp() } else { (2.0 * fit(0.5) - fit(1.0 - cosine)).exp() }
}

/// E at the squares of evenly spaced numbers: directions change most at grazing incidence.
#[cold]
#[inline(never)]
fn tabulate() -> Box<[[f32; NODES]; NODES]> {
    let mut table = Box::new([[0.0; NODES]; NODES]);
    let node = |k: usize| (k as f64 / (NODES - 1) as f64).powi(2);
    let low = f64::from(MIN_ALPHA);
    for (r, row) in table.iter_mut().enumerate() {
        for (c, entry) in row.iter_mut().enumerate() {
            *entry = integral(node(c).max(1e-6), low + (1.0 - low) * node(r)) as f32;
        }
    }
    table
}

/// The albedo of a cosine: midpoints in the azimuth, and in the cosine of the light with nodes towards grazing
/// incidence.
fn integral(z: f64, alpha: f64) -> f64 {
    const HEIGHTS: usize = 96;
    const AZIMUTHS: usize = 64;
    let sine = (1.0 - z * z).max(0.0).sqrt();
    let mut sum = 0.0;
    for k in 0..HEIGHTS {
        let t = (k as f64 + 0.5) / HEIGHTS as f64;
        let (height, weight) = (t * t, 2.0 * t / HEIGHTS as f64);
        let flat = (1.0 - height * height).sqrt();
        let shadowed = 1.0 + lambda(z, alpha) + lambda(height, alpha);
        for azimuth in 0..AZIMUTHS {
            let cos = (std::f64::consts::PI * (azimuth as f64 + 0.5) / AZIMUTHS as f64).cos();
            let product = z * height + sine * flat * cos;
            let up = (z + height).powi(2) / (2.0 + 2.0 * product).max(1e-30);
            sum += weight * distribution(1.0 - up, alpha) / (4.0 * z * shadowed) / AZIMUTHS as f64;
        }
    }
    sum * 2.0 * std::f64::consts::PI
}

/// The pdf of [`direction`].
pub(super) const PDF: f32 = 0.5 * FRAC_1_PI;

/// A direction of the uniform hemisphere from a point of the unit disk with the height of the hemisphere over it.
pub(super) fn direction(disk: Vector) -> Vector {
    // The square of the height of a uniform point of the disk is uniform.
    let z = (disk[2] * disk[2]).clamp(0.0, 1.0);
    let radius = (disk[0] * disk[0] + disk[1] * disk[1]).sqrt();
    let scale = if radius > 0.0 { (1.0 - z * z).max(0.0).sqrt() / radius } else { 0.0 };
    [disk[0] * scale, disk[1] * scale, z]
}
