//! Views with more noise than texture: what single pixels cannot tell, many can.

use holo_core::{Effort, LightField, PlaneSweepOptions, plane_sweep};
use ndarray::Array5;

use super::scenes::{Surface, texture};

/// A slanted wall whose light changes slowly, behind a textured bar.
const WALL: Surface = Surface { here: -1.0, by_row: 0.002, by_column: -0.001 };
const BAR_PX: f64 = 0.9;
const BAR: std::ops::Range<f64> = 70.0..90.0;

/// A number within +-1 of a seed, equally likely.
fn noise(seed: usize) -> f64 {
    let mixed = (seed as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed ^ (mixed >> 32)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

/// The wall differs from pixel to pixel by 0.001, the noise by 0.01: the map follows the wall, not the noise, nor planes on
/// which interpolation has less of it.
#[test]
fn a_wall_without_texture_is_found_in_noise() {
    let (rows, columns) = (160, 160);
    let light = |v: f64, u: f64| 0.4 + 0.03 * (0.031 * v + 0.4).sin() + 0.03 * (0.027 * u - 0.011 * v).cos();
    let samples = Array5::from_shape_fn((rows, columns, 9, 9, 1), |(v, u, t, s, _)| {
        let (down, right) = (t as f64 - 4.0, s as f64 - 4.0);
        let bar_u = u as f64 + BAR_PX * right;
        let clean = if BAR.contains(&bar_u) {
            0.6 * texture(v as f64 + BAR_PX * down, bar_u, 0) + 0.4
        } else {
            let (v, u) = WALL.source(v as f64, u as f64, down, right);
            light(v, u)
        };
        (clean + 0.0173 * noise((((v * columns + u) * 9) + t) * 9 + s)) as f32
    });
    let light_field = LightField::new(samples).unwrap();
    let [balanced, thorough] = [Effort::Balanced, Effort::Thorough].map(|effort| {
        let options = PlaneSweepOptions::default().range_px(-1.6, 1.6).effort(effort);
        let found = plane_sweep(&light_field, &options).unwrap().disparity_px;
        let errors: Vec<f64> = (15..145)
            .flat_map(|v| (15..145).map(move |u| (v, u)))
            .filter(|(_, u)| (*u as f64) < BAR.start - 8.0 || (*u as f64) > BAR.end + 8.0)
            .map(|(v, u)| (f64::from(found[[v, u]]) - WALL.disparity_px(v as f64, u as f64)).abs())
            .collect();
        errors.iter().filter(|error| **error > 0.1).count() as f64 / errors.len() as f64
    });
    // Without coarser levels and the same noise on all planes both are above two thirds.
    assert!(balanced < 0.4 && thorough < 0.15, "{balanced} {thorough}");
}
