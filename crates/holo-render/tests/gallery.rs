//! Framing and disparities of the gallery.

use holo_core::{GridSize, LightFieldShape};
use holo_render::{Backend, Baseline, Framing, Renderer};
use holo_scene::gallery::{NAMES, scene};

/// 20 x 20 views of 397 x 265 pixels: no view sees past the scene, and disparities are within the range that the
/// gallery is designed for.
#[test]
fn disparities_suit_dense_views() {
    let split = LightFieldShape::new(GridSize::new(20, 20), GridSize::new(265, 397)).expect("a possible split");
    for name in NAMES.iter().copied() {
        let scene = &scene(name).expect("a scene of the gallery");
        let framing = Framing::new(split).baseline(Baseline::FNumber(5.0));
        let framed = framing.frame(scene).expect(name);
        let renderer = Renderer::new(scene, &framed.pose, Backend::Auto, None).expect(name);
        let rig = framed.rig(renderer.automatic_focus_m(&framed).expect(name)).expect(name);
        let truth = renderer.central_truth(&rig).expect(name);
        let disparity = truth.disparity_px().expect(name);
        let depth = truth.depth_m().expect(name);
        assert!(depth.iter().all(|z| z.is_finite()), "{name}: the view sees past the scene");
        let largest = disparity.iter().fold(0.0_f32, |largest, d| largest.max(d.abs()));
        let bounds = if name == "dominoes" { 0.2..0.4 } else { 0.08..0.26 };
        assert!(bounds.contains(&largest), "{name}: {largest} px");
    }
}
