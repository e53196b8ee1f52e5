//! Points of a microlens that stand for all of it.

use super::super::LensAperture;
use super::super::microlenses::rotate;

/// Gauss-Legendre places: three, from 0 to 1, with their weights.
pub(super) const GAUSS_3: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// The number of points of a microlens behind a lens of glass.
const EVEN_POINTS: usize = 100;

/// Points of a microlens from its center, with weights whose sum is 1.
pub(super) fn lens_points(aperture: LensAperture, rotation_rad: f64) -> Vec<([f64; 2], f64)> {
    let points: Vec<([f64; 2], f64)> = match aperture {
        // Stroud, S2 5-1.
        LensAperture::Round { radius_m } => ring(radius_m * (2f64 / 3.0).sqrt(), 0.125),
        LensAperture::Square { half_width_m } => {
            let each = GAUSS_3.iter().flat_map(|&(y, wy)| GAUSS_3.map(|(x, wx)| ([x, y], wx * wy)));
            each.map(|(point, weight)| (point.map(|x| (2.0 * x - 1.0) * half_width_m), weight)).collect()
        }
        // Of the same means of r^2 and r^4 as the hexagon: 5/9 and 56/135 for a half width of 1.
        LensAperture::Hexagon { half_width_m } => ring(half_width_m * (56f64 / 75.0).sqrt(), 125.0 / 1008.0),
    };
    points.into_iter().map(|(point, weight)| (rotate(point, rotation_rad), weight)).collect()
}

/// About [`EVEN_POINTS`] points of a microlens from its center that stand for the same area each.
pub(super) fn even_points(aperture: LensAperture, rotation_rad: f64) -> Vec<[f64; 2]> {
    let middles =
        |side: usize| (0..side * side).map(move |k| [k % side, k / side].map(|k| (k as f64 + 0.5) / side as f64));
    let points: Vec<[f64; 2]> = match aperture {
        // Vogel, "A better way to construct the sunflower head" (1979).
        LensAperture::Round { radius_m } => (0..EVEN_POINTS)
            .map(|k| {
                let (sin, cos) = (k as f64 * std::f64::consts::PI * (3.0 - 5f64.sqrt())).sin_cos();
                [cos, sin].map(|x| x * radius_m * ((k as f64 + 0.5) / EVEN_POINTS as f64).sqrt())
            })
            .collect(),
        LensAperture::Square { half_width_m } => {
            middles(EVEN_POINTS.isqrt()).map(|unit| unit.map(|x| (2.0 * x - 1.0) * half_width_m)).collect()
        }
        // Three rhombi between the center and every other corner.
        LensAperture::Hexagon { .. } => {
            let corners = [0.0, 1.0, 2.0, 3.0].map(|k: f64| {
                let (sin, cos) = (k * 2.0 * std::f64::consts::FRAC_PI_3).sin_cos();
                [sin, cos].map(|x| x * aperture.outer_radius_m())
            });
            let rhombi = corners.windows(2).map(|ends| [ends[0], ends[1]]);
            let of_rhombus = |[a, b]: [[f64; 2]; 2]| {
                middles((EVEN_POINTS / 3).isqrt()).map(move |[u, v]| [0, 1].map(|k| u * a[k] + v * b[k]))
            };
            rhombi.flat_map(of_rhombus).collect()
        }
    };
    points.into_iter().map(|point| rotate(point, rotation_rad)).collect()
}

/// The center, and six points around it of this weight each.
fn ring(radius_m: f64, weight: f64) -> Vec<([f64; 2], f64)> {
    let angles = (0..6).map(|k| (f64::from(k) * std::f64::consts::FRAC_PI_3).sin_cos());
    let around = angles.map(|(sin, cos)| ([radius_m * cos, radius_m * sin], weight));
    std::iter::once(([0.0; 2], 1.0 - 6.0 * weight)).chain(around).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{central_cos4, cos4};
    use super::*;

    /// The points of a microlens have its mean of cos^4, up to the sixth power of half width / gap: 0.2 of that power.
    #[test]
    fn points_of_microlenses_have_the_mean_of_cos4() {
        for part in [0.1f64, 0.25] {
            for aperture in [
                LensAperture::Round { radius_m: part },
                LensAperture::Square { half_width_m: part },
                LensAperture::Hexagon { half_width_m: part },
            ] {
                let points = lens_points(aperture, 0.3);
                let mean: f64 = points.iter().map(|&(point, weight)| weight * cos4([0.0; 2], point, 1.0)).sum();
                let error = mean - central_cos4(aperture, 1.0);
                assert!(error.abs() < 0.2 * part.powi(6), "{aperture:?}: {error:e}");
            }
        }
    }
}
