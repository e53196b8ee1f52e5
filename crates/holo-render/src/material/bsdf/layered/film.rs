//! Iridescence: the reflectance of a surface under a thin film.
//!
//! Source: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence"
//! (SIGGRAPH 2017), in the form of KHR_materials_iridescence: both interfaces with Schlick's Fresnel term, two
//! orders of interference after the constant one, and the sensitivity of the eye as Gaussians in the Fourier domain.
//!
//! # Accuracy
//! Computed in f64 and rounded to f32, so that the last digits of the exponential and the cosine of a system do not
//! matter in all but one of 2^29 cases. The model itself leaves out polarization and higher orders.

use std::f64::consts::{PI, TAU};

/// A thin film on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Film {
    /// Weight of the film, 0 to 1.
    pub factor: f32,
    /// Index of refraction of the film.
    pub ior: f32,
    /// Thickness, nm.
    pub thickness_nm: f32,
}

/// Below this thickness, nm, the index of the film fades to that of air, so that no film is the limit of a thin one.
const FADE_NM: f64 = 0.03;

/// The Gaussians of the sensitivities X, Y, Z and of the second lobe of X: weight, position, variance (per meter of
/// path, in the Fourier domain).
const SENSITIVITY: [[f64; 3]; 4] = [
    [5.4856e-13, 1.6810e6, 4.3278e9],
    [4.4201e-13, 1.7953e6, 9.3046e9],
    [5.2481e-13, 2.2084e6, 6.6121e9],
    [9.7470e-14, 2.2399e6, 4.5282e9],
];
const SENSITIVITY_SUM: f64 = 1.0685e-7;

/// XYZ to linear RGB with the primaries of Rec. 709.
const TO_RGB: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266_0, 1.876_010_8, 0.041_556_0],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

impl Film {
    /// The reflectance, RGB, at the cosine `cosine` in air over a surface with the reflectance `f0` at normal
    /// incidence; 0 to 1. The factor is not applied.
    pub fn reflectance(&self, cosine: f32, f0: [f32; 3]) -> [f32; 3] {
        let cosine = f64::from(cosine).clamp(0.0, 1.0);
        let thickness = f64::from(self.thickness_nm);
        let fade = (thickness / FADE_NM).clamp(0.0, 1.0);
        let ior = 1.0 + (f64::from(self.ior) - 1.0) * (fade * fade * (3.0 - 2.0 * fade));
        let square = 1.0 - (1.0 - cosine * cosine) / (ior * ior);
        if square < 0.0 {
            return [1.0; 3];
        }
        let inside = square.sqrt();
        let first = schlick(normal(ior, 1.0), cosine);
        let through = 1.0 - first;
        let path = 2.0 * ior * thickness * inside * 1e-9;
        let upper_shift = if ior < 1.0 { 0.0 } else { PI };
        let (mut constant, mut amplitude) = ([0.0; 3], [0.0; 3]);
        let (mut round, mut shift) = ([0.0; 3], [0.0; 3]);
        for c in 0..3 {
            let root = f64::from(f0[c]).clamp(0.0, 0.9999).sqrt();
            let base_ior = (1.0 + root) / (1.0 - root);
            let second = schlick(normal(base_ior, ior), inside);
            let both = (first * second).clamp(1e-5, 0.9999);
            let sum = through * through * second / (1.0 - both);
            constant[c] = first + sum;
            amplitude[c] = sum - through;
            round[c] = both.sqrt();
            shift[c] = upper_shift + if base_ior < ior { PI } else { 0.0 };
        }
        let mut light = constant;
        for order in [1.0, 2.0] {
            let seen = sensitivity(order * path, shift.map(|shift| order * shift));
            for c in 0..3 {
                amplitude[c] *= round[c];
                light[c] += 2.0 * amplitude[c] * seen[c];
            }
        }
        light.map(|x| x.clamp(0.0, 1.0) as f32)
    }
}

/// The reflectance at normal incidence between two indices of refraction.
fn normal(behind: f64, front: f64) -> f64 {
    ((behind - front) / (behind + front)).powi(2)
}

fn schlick(f0: f64, cosine: f64) -> f64 {
    f0 + (1.0 - f0) * (1.0 - cosine).powi(5)
}

/// The response of RGB to interference at a path difference, m, with phase shifts per channel.
fn sensitivity(path: f64, shift: [f64; 3]) -> [f64; 3] {
    let phase = TAU * path;
    let gaussian = |[weight, position, variance]: [f64; 3], shift: f64| {
        weight * (TAU * variance).sqrt() * (position * phase + shift).cos() * (-phase * phase * variance).exp()
    };
    let mut xyz = [0, 1, 2].map(|k| gaussian(SENSITIVITY[k], shift[k]));
    xyz[0] += gaussian(SENSITIVITY[3], shift[0]);
    TO_RGB.map(|row| (row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]) / SENSITIVITY_SUM)
}
