//! Depth and disparity against closed forms, against each other, and against other views.

use std::num::NonZeroUsize;

use crate::common::{add, engines, render, rig, soup, square, truth};
use holo_core::Projection;
use holo_render::{Backend, Layer, Renderer};
use holo_scene::{Scene, Transform};

/// A slanted plane fills the image: its depth is known for every pixel of every view, in either projection, with
/// either backend. After refinement in f64 the error is the rounding to f32: 2^-24.
#[test]
fn depth_of_a_slanted_plane_is_exact() {
    // z = -3 + 0.2 x - 0.3 y, as a transformed square.
    let mut scene = Scene::default();
    let plane =
        Transform { columns: [[1.0, 0.0, 0.2], [0.0, 1.0, -0.3], [0.0, 0.0, 1.0]], translation: [0.0, 0.0, -3.0] };
    add(&mut scene, square(20.0), [1.0; 4], plane);
    for projection in [Projection::Perspective, Projection::Orthographic] {
        for backend in engines() {
            let rig = rig([3, 4], [7, 9], 0.05, 2.5, projection);
            let rendered = render(&scene, &truth(rig), backend, 1);
            let all = rendered.all.expect("requested");
            for ((v, u, t, s, _), &depth) in all[Layer::Depth].samples().indexed_iter() {
                let ray = rig.ray(v, u, t, s, 0.5, 0.5);
                let [x, y] = [0, 1].map(|k| (ray.origin_m[k], ray.direction[k]));
                // -Z = -3 + 0.2 (x + Z dx) - 0.3 (y + Z dy)
                let exact = (3.0 - 0.2 * x.0 + 0.3 * y.0) / (1.0 + 0.2 * x.1 - 0.3 * y.1);
                assert!(
                    (f64::from(depth) - exact).abs() <= exact * 6.0e-8,
                    "{backend:?} {projection:?} {v} {u} {t} {s}: {depth} {exact}"
                );
                let disparity = rig.disparity().from_depth_m(exact);
                let found = f64::from(all[Layer::Disparity].samples()[[v, u, t, s, 0]]);
                // Relative to the scale of disparities here: f32 rounding.
                assert!((found - disparity).abs() <= 1e-7 * disparity.abs().max(1e-3), "{found} {disparity}");
            }
        }
    }
}

/// The ground truth of the central view equals that of all views at the central view, also for even counts.
#[test]
fn the_central_view_is_one_of_all() {
    for views in [[5, 5], [4, 6], [1, 1], [1, 7]] {
        let rig = rig(views, [11, 13], 0.02, 3.0, Projection::Perspective);
        let scene = soup(200, 3);
        let rendered = render(&scene, &truth(rig), Backend::Bvh, 2);
        let alone = Renderer::new(&scene, &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1))
            .unwrap()
            .central_truth(&rig)
            .unwrap();
        assert_eq!(alone, rendered.central);
        let depth_m = &alone[Layer::Depth];
        assert!(depth_m.iter().any(|z| z.is_finite()) && depth_m.iter().any(|z| z.is_infinite()));
    }
}

/// The point of a pixel of the central view is at the position of Eq. 3 in every other view. The surface is a plane, so
/// the depths agree everywhere.
#[test]
fn points_move_by_their_disparity() {
    let mut scene = Scene::default();
    add(&mut scene, square(20.0), [1.0; 4], Transform::from_translation([0.0, 0.0, -4.0]));
    let rig = rig([5, 5], [21, 31], 0.03, 2.5, Projection::Perspective);
    let rendered = render(&scene, &truth(rig), Backend::Bvh, 1);
    let (tc, sc) = rig.shape().central_view();
    for ((v, u, _), &disparity) in rendered.central[Layer::Disparity].indexed_iter() {
        let depth = f64::from(rendered.central[Layer::Depth][[v, u, 0]]);
        let point = rig.ray(v, u, tc, sc, 0.5, 0.5).at_depth_m(depth);
        for t in 0..5 {
            for s in 0..5 {
                let (row, column) = rig.project(point, t, s).expect("in front of the camera");
                let d = f64::from(disparity);
                let expected_column = u as f64 + 0.5 - d * (s as f64 - sc as f64);
                let expected_row = v as f64 + 0.5 - d * (t as f64 - tc as f64);
                // Depth and disparity were rounded to f32: a few 1e-7 of some tens of pixels.
                assert!((column - expected_column).abs() < 1e-5, "{column} {expected_column}");
                assert!((row - expected_row).abs() < 1e-5, "{row} {expected_row}");
            }
        }
    }
}

/// All rays of an elemental image intersect in one point of the focus plane.
#[test]
fn rays_of_an_elemental_image_meet_on_the_focus_plane() {
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let rig = rig([6, 4], [5, 8], 0.07, 1.75, projection);
        for (v, u) in [(0, 0), (2, 3), (4, 7)] {
            let first = rig.ray(v, u, 0, 0, 0.5, 0.5).at_depth_m(1.75);
            for (t, s) in [(5, 3), (2, 1), (0, 3)] {
                let point = rig.ray(v, u, t, s, 0.5, 0.5).at_depth_m(1.75);
                for axis in 0..3 {
                    assert!((point[axis] - first[axis]).abs() < 1e-15, "{projection:?} {point:?} {first:?}");
                }
            }
        }
    }
}

/// The three backends agree. A backend in f32 may classify a ray within rounding of an edge differently: at most one
/// pixel in a thousand.
#[test]
fn engines_agree_on_depth() {
    let rig = rig([4, 4], [24, 36], 0.01, 4.0, Projection::Perspective);
    let scene = soup(600, 9);
    let reference = render(&scene, &truth(rig), Backend::BruteForce, 2).all.expect("requested");
    for backend in engines() {
        let found = render(&scene, &truth(rig), backend, 2).all.expect("requested");
        let (a, b) = (reference[Layer::Depth].samples(), found[Layer::Depth].samples());
        let same = |a: f32, b: f32| a == b || ((a - b) / a).abs() < 1e-6;
        let (differ, all) = (a.iter().zip(b).filter(|(a, b)| !same(**a, **b)).count(), a.len());
        println!("{backend:?}: {differ} of {all}");
        assert!(differ * 1000 <= all, "{backend:?}: {differ} of {all}");
    }
}
