//! Light that changes from view to view.

use holo_core::{Effort, LightField, PlaneSweepOptions, plane_sweep};
use ndarray::Array5;

use super::scenes::{Surface, texture};

const WALL: Surface = Surface { here: -0.6, by_row: 0.002, by_column: -0.001 };

/// A wall gets brighter from left to right over the image by 0.002 a pixel, and from view to view by 0.001, as under a wide
/// highlight: by brightness alone it moves by half a pixel more. Its texture tells that it does not.
#[test]
fn gloss_on_texture_is_no_parallax() {
    let samples = Array5::from_shape_fn((128, 128, 9, 9, 1), |(v, u, t, s, _)| {
        let (down, right) = (t as f64 - 4.0, s as f64 - 4.0);
        let (v, u) = WALL.source(v as f64, u as f64, down, right);
        (0.2 + 0.002 * u + 0.03 * texture(v, u, 0) + 0.001 * right) as f32
    });
    let light_field = LightField::new(samples).unwrap();
    for effort in [Effort::Fast, Effort::Balanced, Effort::Thorough] {
        let options = PlaneSweepOptions::default().range_px(-1.6, 1.6).effort(effort);
        let found = plane_sweep(&light_field, &options).unwrap().disparity_px;
        let error = (15..113)
            .flat_map(|v| (15..113).map(move |u| (v, u)))
            .map(|(v, u)| (f64::from(found[[v, u]]) - WALL.disparity_px(v as f64, u as f64)).abs())
            .sum::<f64>()
            / 9604.0;
        assert!(error < 0.03, "{effort:?}: {error}");
    }
}
