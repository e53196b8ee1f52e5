//! Renderer, light field and Eq. 3 together: the slopes of lines in rendered epipolar-plane images are the disparities
//! of the depth map.

use crate::common::{Random, engines, render, rig, square};
use holo_core::{Projection, Rig};
use holo_render::{Integrator, Layer, Request};
use holo_scene::{Instance, Light, LightKind, Material, Scene, Texture, TextureInfo, Transform, Wrap};
use proptest::prelude::*;

/// Pixels of a view, and views.
const PIXELS: [usize; 2] = [48, 64];
const VIEWS: [usize; 2] = [5, 7];

/// A wall at a depth with a smooth gray noise texture under uniform light.
fn wall(rig: &Rig, depth_m: f64, seed: u64) -> Scene {
    let mut random = Random(seed);
    let side = 256;
    // Waves in many directions, none shorter than eight pixels of a view, so that interpolation is accurate.
    let pixel_m = depth_m * 0.036 / 0.05 / PIXELS[1] as f64;
    let half_m = 48.0 * pixel_m;
    let waves: Vec<[f64; 3]> = (0..24)
        .map(|_| {
            let (angle, period) = (random.between(0.0, 3.2), random.between(8.0, 24.0));
            let per_texel = 2.0 * half_m / side as f64 / (period * pixel_m) * std::f64::consts::TAU;
            [per_texel * angle.cos(), per_texel * angle.sin(), random.between(0.0, 6.3)]
        })
        .collect();
    let texel = |k: usize| {
        let (x, y) = ((k % side) as f64, (k / side) as f64);
        let sum: f64 = waves.iter().map(|[a, b, c]| (a * x + b * y + c).sin()).sum();
        let gray = (128.0 + 18.0 * sum).clamp(0.0, 255.0) as u8;
        [gray, gray, gray, 255]
    };
    let texture = Texture {
        name: String::new(),
        width: side,
        height: side,
        texels: (0..side * side).map(texel).collect(),
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: holo_scene::Filter::Linear,
    };
    let texture_coordinates = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let kind = LightKind::Directional { direction: [0.0, 0.0, -1.0], angular_diameter_rad: 0.0 };
    assert_eq!(rig.shape().lenses().columns, PIXELS[1]);
    Scene {
        meshes: vec![holo_scene::Mesh { texture_coordinates, ..square(half_m as f32) }],
        instances: vec![Instance {
            name: String::new(),
            mesh: 0,
            transform: Transform::from_translation([0.0, 0.0, -depth_m]),
        }],
        materials: vec![Material { base_color_texture: Some(TextureInfo::new(0)), ..Material::default() }],
        textures: vec![texture],
        lights: vec![Light { name: String::new(), intensity: [3.0; 3], kind }],
        ..Scene::default()
    }
}

/// The shift d, in px per view, of lines in an epipolar-plane image `lines[view][pixel]`: line k is the first one moved
/// by -d k. Gauss-Newton on the squared differences of neighboring lines, each moved halfway by spline interpolation.
fn slope(lines: &[Vec<f64>]) -> f64 {
    let mut d = 0.0;
    for _ in 0..20 {
        let (mut gradient, mut curvature) = (0.0, 0.0);
        for pair in lines.windows(2) {
            for u in 10..pair[0].len() - 10 {
                let (a, slope_a) = at(&pair[0], u as f64 + d / 2.0);
                let (b, slope_b) = at(&pair[1], u as f64 - d / 2.0);
                let steep = (slope_a + slope_b) / 2.0;
                gradient += (b - a) * steep;
                curvature += steep * steep;
            }
        }
        let step = gradient / curvature;
        d += step;
        if step.abs() < 1e-7 {
            break;
        }
    }
    d
}

/// Value and slope between samples, by a polynomial through six samples.
fn at(line: &[f64], x: f64) -> (f64, f64) {
    let value = |x: f64| {
        let first = x.floor() as usize - 2;
        (0..6)
            .map(|i| {
                let others = (0..6).filter(|&j| j != i);
                line[first + i] * others.map(|j| (x - (first + j) as f64) / (i as f64 - j as f64)).product::<f64>()
            })
            .sum::<f64>()
    };
    (value(x), (value(x + 1e-3) - value(x - 1e-3)) / 2e-3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Along rows and along columns of views, with either projection: within 0.01 px of Eq. 3 of the depth map. (What
    /// is left: noise of 16 samples within the pixel, and a box filter that neighboring views lay over other places of
    /// the wall.)
    #[test]
    fn lines_have_the_slope_of_their_disparity(
        nearness in 0.5_f64..2.5, step_px in 0.2_f64..1.5, seed in any::<u64>(), orthographic in any::<bool>()
    ) {
        let projection = if orthographic { Projection::Orthographic } else { Projection::Perspective };
        let focus_m = 2.0;
        let depth_m = focus_m / nearness;
        // A baseline for which the wall moves by about `step_px` at most from view to view.
        let pixels_per_slope = PIXELS[1] as f64 / 0.72;
        let baseline_m = step_px / pixels_per_slope / (1.0 / depth_m - 1.0 / focus_m).abs().max(0.3);
        let rig = rig(VIEWS, PIXELS, baseline_m, focus_m, projection);
        // An orthographic view is as wide everywhere as the perspective one is in the focus plane.
        let painted_at_m = if orthographic { focus_m } else { depth_m };
        let mut scene = wall(&rig, painted_at_m, seed);
        scene.instances[0].transform = Transform::from_translation([0.0, 0.0, -depth_m]);
        let request = Request::new(rig).integrator(Integrator::Direct).samples(16).seed(seed);
        for backend in engines() {
            let rendered = render(&scene, &request, backend, 2);
            let disparity = f64::from(rendered.central[Layer::Disparity][[PIXELS[0] / 2, PIXELS[1] / 2, 0]]);
            let depth = f64::from(rendered.central[Layer::Depth][[PIXELS[0] / 2, PIXELS[1] / 2, 0]]);
            prop_assert!((rig.disparity().from_depth_m(depth) - disparity).abs() < 1e-6);
            let color = rendered.color.expect("an image");
            let samples = color.samples();
            for v in [14, 24, 33] {
                let lines = |s: usize| (0..PIXELS[1]).map(|u| f64::from(samples[[v, u, 2, s, 1]])).collect();
                let found = slope(&(0..VIEWS[1]).map(lines).collect::<Vec<_>>());
                prop_assert!((found - disparity).abs() < 0.01, "row {v}: {found} for {disparity}");
            }
            for u in [20, 40] {
                let lines = |t: usize| (0..PIXELS[0]).map(|v| f64::from(samples[[v, u, t, 3, 1]])).collect();
                let found = slope(&(0..VIEWS[0]).map(lines).collect::<Vec<_>>());
                prop_assert!((found - disparity).abs() < 0.01, "column {u}: {found} for {disparity}");
            }
        }
    }
}
