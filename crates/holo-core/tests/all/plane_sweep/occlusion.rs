//! A bar in front of a wall: pixels that are occluded in half of the views have the right disparity, and the depth edge
//! is sharp.

use holo_core::{Effort, LightField, PlaneSweepOptions, plane_sweep};
use ndarray::Array5;

use super::scenes::texture;

const BAR_PX: f64 = 1.5;
const WALL_PX: f64 = -0.5;
const COLUMNS: std::ops::Range<f64> = 29.5..50.5;

#[test]
fn edges_of_a_bar_stay_where_they_are() {
    let samples = Array5::from_shape_fn((64, 80, 9, 9, 3), |(v, u, t, s, channel)| {
        let (down, right) = (t as f64 - 4.0, s as f64 - 4.0);
        let at = |disparity_px: f64| (v as f64 + disparity_px * down, u as f64 + disparity_px * right);
        let (bar_v, bar_u) = at(BAR_PX);
        if COLUMNS.contains(&bar_u) {
            // The texture of the wall at an offset: colors alone do not distinguish the two.
            texture(bar_v * 1.1 + 100.0, bar_u * 1.1 + 40.0, channel) as f32
        } else {
            let (wall_v, wall_u) = at(WALL_PX);
            texture(wall_v, wall_u, channel) as f32
        }
    });
    let light_field = LightField::new(samples).unwrap();
    let options = PlaneSweepOptions::default().range_px(-1.0, 2.0).effort(Effort::Balanced);
    let found = plane_sweep(&light_field, &options).unwrap();
    let (mut near, mut wrong_near, mut wrong_far) = (0, 0, 0);
    for v in 6..58 {
        for u in 6..74 {
            let truth = if COLUMNS.contains(&(u as f64)) { BAR_PX } else { WALL_PX };
            let is_wrong = (f64::from(found.disparity_px[[v, u]]) - truth).abs() > 0.07;
            let from_edge = (u as f64 - COLUMNS.start).abs().min((u as f64 - COLUMNS.end).abs());
            // The wall is hidden in some view up to 8 pixels from the bar: (1.5 + 0.5) * 4.
            if from_edge < 8.0 {
                near += 1;
                wrong_near += usize::from(is_wrong);
            } else {
                wrong_far += usize::from(is_wrong);
            }
        }
    }
    assert_eq!(wrong_far, 0);
    // One pixel on either side of each edge would be 12 %; all of the half-hidden wall, 50 %.
    assert!(wrong_near * 100 < near * 12, "{wrong_near} of {near}");
}
