//! Planes of known depth are sharpest at their own disparity.

use holo_core::refocus::{FocalPlane, Kernel, Refocus};
use holo_core::{GridSize, LightField, LightFieldShape, Rig};
use ndarray::{Array2, Array3, Array5, ArrayView3};

/// A texture of waves of 5 to 12 pixels in all directions, within 0..1: every kernel can follow it between pixels.
fn texture(row: f64, column: f64) -> f64 {
    let wave = |length: f64, angle: f64, phase: f64| {
        (std::f64::consts::TAU * (column * angle.cos() + row * angle.sin()) / length + phase).sin()
    };
    let waves =
        [(5.0, 0.3, 0.1), (6.1, 1.4, 2.0), (7.3, 2.6, 4.0), (8.9, 0.9, 1.0), (10.3, 2.1, 5.0), (12.0, 0.0, 3.0)];
    0.5 + waves.iter().map(|&(length, angle, phase)| wave(length, angle, phase)).sum::<f64>() / 12.0
}

fn rig(views: (usize, usize), baselines_m: (f64, f64)) -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(views.0, views.1), GridSize::new(64, 80)).unwrap())
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_x_m(baselines_m.1)
        .baseline_y_m(baselines_m.0)
        .focus_distance_m(4.0)
        .build()
        .unwrap()
}

/// A wall at a depth, painted with the texture in pixels of the rig's center, as 8-bit samples.
///
/// It uses the rays of the rig, not the shifts under test.
fn wall(rig: &Rig, depth_m: f64) -> LightField<ndarray::OwnedRepr<u8>> {
    let samples = Array5::from_shape_fn(rig.shape().array_shape(1), |(v, u, t, s, _)| {
        let point = rig.ray(v, u, t, s, 0.5, 0.5).at_depth_m(depth_m);
        let (row, column) = (rig.row(point[1] / depth_m), rig.column(point[0] / depth_m));
        (255.0 * texture(row, column)).round() as u8
    });
    LightField::new(samples).unwrap()
}

/// The variance of the Laplacian, without the 12 px at the edges that not all views see.
fn sharpness(image: ArrayView3<'_, f32>) -> f64 {
    let (rows, columns, _) = image.dim();
    let at = |row: usize, column: usize| f64::from(image[[row, column, 0]]);
    let laplacians: Vec<f64> = (12..rows - 12)
        .flat_map(|row| (12..columns - 12).map(move |column| (row, column)))
        .map(|(row, column)| {
            at(row - 1, column) + at(row + 1, column) + at(row, column - 1) + at(row, column + 1)
                - 4.0 * at(row, column)
        })
        .collect();
    let mean = laplacians.iter().sum::<f64>() / laplacians.len() as f64;
    laplacians.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / laplacians.len() as f64
}

#[test]
fn walls_are_sharpest_at_their_own_disparity() {
    const STEP: f64 = 0.1;
    // The bilinear kernel blurs views that fall between pixels, which favors disparities that put many views on pixels:
    // near -0.2 it prefers -0.25 or so. The cubic has next to none of that.
    for (views, baselines_m, kernel, bound) in [
        ((9, 9), (0.03, 0.03), Kernel::CatmullRom, 0.02),
        ((8, 8), (0.03, 0.03), Kernel::CatmullRom, 0.02),
        ((5, 8), (0.015, 0.03), Kernel::CatmullRom, 0.02),
        ((9, 9), (0.03, 0.03), Kernel::Bilinear, 0.04),
    ] {
        let rig = rig(views, baselines_m);
        for depth_m in [2.9, 4.0, 5.3] {
            let light_field = wall(&rig, depth_m);
            let expected = rig.disparity().from_depth_m(depth_m);
            let refocus = Refocus::new(rig.shape().views()).unwrap().kernel(kernel);
            let refocus = refocus.baseline_ratio(rig.baseline_ratio());
            // Steps that do not meet the disparity itself.
            let disparities: Vec<f64> = (-10..=10).map(|step| expected + 0.037 + f64::from(step) * STEP).collect();
            let stack = refocus.focal_stack(&light_field, &disparities);
            let sharp: Vec<f64> = stack.map(|image| sharpness(image.unwrap().view())).collect();
            let best = (1..sharp.len() - 1).max_by(|&a, &b| sharp[a].total_cmp(&sharp[b])).unwrap();
            let (before, top, behind) = (sharp[best - 1], sharp[best], sharp[best + 1]);
            let found = disparities[best] + STEP * 0.5 * (before - behind) / (before - 2.0 * top + behind);
            assert!(
                (found - expected).abs() < bound,
                "{views:?} {kernel:?} {depth_m} m: {found} for {expected}, peak {top} beside {before} and {behind}"
            );
        }
    }
}

#[test]
fn a_wall_in_focus_agrees_with_the_reference_view() {
    for views in [(9, 9), (8, 6)] {
        let rig = rig(views, (0.03, 0.03));
        let (t, s) = rig.shape().central_view();
        for depth_m in [2.9, 5.3] {
            let light_field = wall(&rig, depth_m);
            let central = light_field.view(t, s).unwrap().mapv(f32::from);
            let refocus = Refocus::new(rig.shape().views()).unwrap();
            let plane = refocus.at_distance_m(&light_field, &rig, depth_m).unwrap();
            let map = Array2::from_elem((64, 80), rig.disparity().from_depth_m(depth_m));
            let everywhere = refocus.all_in_focus(&light_field, &map).unwrap();
            for image in [&plane, &everywhere] {
                let mut largest: f32 = 0.0;
                for v in 12..52 {
                    for u in 12..68 {
                        largest = largest.max((image[[v, u, 0]] - central[[v, u, 0]]).abs());
                    }
                }
                // The cubic loses up to (2 pi/5)^3/16 * 255/12 = 2.6 codes of the shortest wave half-way between
                // pixels, less of the others; the reference view itself was rounded to half a code.
                assert!(largest < 4.0, "{views:?} {depth_m} m: {largest} codes off");
                let flat = Array3::<f32>::from_elem((64, 80, 1), central.mean().unwrap());
                assert!(sharpness(image.view()) > 0.8 * sharpness(central.view()), "blurred");
                assert!(sharpness(flat.view()) < 1.0, "the measure does not see blur");
            }
        }
    }
}

/// A tilted wall is sharp as a whole on its own plane, for other baselines along the axes and references between views; the plane
/// perpendicular to the axis through its middle is not.
#[test]
fn a_tilted_wall_is_sharp_on_its_plane() {
    let rig = rig((8, 9), (0.02, 0.03));
    let (right, up) = (0.9_f64, -0.6_f64);
    let distance_m = 3.0;
    // Where a ray meets the wall: depth = distance + x tan(right) + y tan(up).
    let met = |origin: [f64; 3], direction: [f64; 3]| {
        let slope = |v: [f64; 3]| v[0] * right.tan() + v[1] * up.tan();
        let depth = (distance_m + slope(origin)) / (1.0 - slope(direction));
        [origin[0] + depth * direction[0], origin[1] + depth * direction[1]]
    };
    // In the plane's own coordinates it would be stretched: painted along x and y, waves are short where it is far.
    let color = |[x, y]: [f64; 2]| 127.5 + 60.0 * (30.0 * x + 1.0).sin() + 60.0 * (28.0 * y - 9.0 * x).cos();
    let samples = Array5::from_shape_fn(rig.shape().array_shape(1), |(v, u, t, s, _)| {
        let ray = rig.ray(v, u, t, s, 0.5, 0.5);
        color(met(ray.origin_m, ray.direction)).round() as u8
    });
    let field = LightField::new(samples).unwrap();
    let plane = FocalPlane::new(distance_m).and_then(|plane| plane.tilted(right, up)).unwrap();
    for reference in [(4.0, 4.0), (3.5, 4.0), (2.25, 5.75)] {
        let refocus = Refocus::new(rig.shape().views()).unwrap().reference(reference.0, reference.1).unwrap();
        // The ray of the reference view, between those of the views around it.
        let ray = |v: usize, u: usize| {
            let [t, s] = [reference.0.floor() as usize, reference.1.floor() as usize];
            let [one, other] = [(t, s), (t + 1, s + 1)].map(|(t, s)| rig.ray(v, u, t, s, 0.5, 0.5));
            let between = |one: [f64; 3], other: [f64; 3]| {
                let part = [reference.1.fract(), reference.0.fract()];
                [0, 1, 2].map(|k| one[k] + part.get(k).map_or(0.0, |part| part * (other[k] - one[k])))
            };
            (between(one.origin_m, other.origin_m), between(one.direction, other.direction))
        };
        let deviation = |image: &Array3<f32>| {
            let inside = || (14..50).flat_map(|v| (14..66).map(move |u| (v, u)));
            let error = |(v, u): (usize, usize)| {
                let (origin, direction) = ray(v, u);
                f64::from(image[[v, u, 0]]) - color(met(origin, direction))
            };
            (inside().map(|at| error(at).powi(2)).sum::<f64>() / inside().count() as f64).sqrt()
        };
        let sharp = deviation(&refocus.at_plane(&field, &rig, plane).unwrap());
        let straight = deviation(&refocus.at_plane(&field, &rig, FocalPlane::new(distance_m).unwrap()).unwrap());
        assert!(sharp < 1.0 && straight > 10.0 * sharp, "{reference:?}: {sharp} and {straight} codes");
    }
    let straight = FocalPlane::new(2.0).unwrap();
    let refocus = Refocus::new(rig.shape().views()).unwrap();
    assert_eq!(refocus.at_plane(&field, &rig, straight).unwrap(), refocus.at_distance_m(&field, &rig, 2.0).unwrap());
}
