//! Hard cases of precision and robustness.

use std::num::NonZeroUsize;

use crate::common::{add, engines, everything, render, render_from, rig, soup, square, truth};
use holo_core::{Projection, RigRay};
use holo_render::{Backend, Error, Integrator, Layer, Renderer};
use holo_scene::{Light, LightKind, Mesh, Scene, Transform};

fn lit_soup(seed: u64) -> Scene {
    let mut scene = soup(300, seed);
    let sun = LightKind::Directional { direction: [0.0, -0.6, -0.8], angular_diameter_rad: 0.0 };
    let lamp = LightKind::Point { position: [0.5, 1.0, -1.0], range: None };
    scene.lights.push(Light { name: "sun".into(), intensity: [2.0, 1.9, 1.7], kind: sun });
    scene.lights.push(Light { name: "lamp".into(), intensity: [0.5, 0.7, 0.9], kind: lamp });
    scene
}

/// Whether the distance of two numbers, which may be infinite but not NaN, exceeds a bound.
fn differ(a: f32, b: f32, bound: f32) -> bool {
    a != b && ((a - b).is_nan() || (a - b).abs() > bound)
}

/// The depth of the intersection of a ray with the plane of depth `c + a x + b y`.
fn depth_of_plane([a, b, c]: [f64; 3], ray: &RigRay) -> f64 {
    let (o, d) = (ray.origin_m, ray.direction);
    (c + a * o[0] + b * o[1]) / (1.0 - a * d[0] - b * d[1])
}

/// A wall of depth 3 + 0.2 x - 0.3 y, and the coefficients of its plane.
fn slanted_wall() -> (Scene, [f64; 3]) {
    let mut scene = Scene::default();
    let columns = [[1.0, 0.0, -0.2], [0.0, 1.0, 0.3], [0.0, 0.0, 1.0]];
    add(&mut scene, square(500.0), [1.0; 4], Transform { columns, translation: [0.0, 0.0, -3.0] });
    (scene, [0.2, -0.3, 3.0])
}

/// The same bytes for any number of threads and for a repeated render.
#[test]
fn the_image_does_not_depend_on_threads() {
    let scene = lit_soup(4);
    let rig = rig([7, 6], [19, 23], 0.01, 3.0, Projection::Perspective);
    let request = everything(rig, 3, [0.2, 0.3, 0.4]);
    for backend in engines() {
        let one = render(&scene, &request, backend, 1);
        for threads in 1..=8 {
            let other = render(&scene, &request, backend, threads);
            assert_eq!(one.color, other.color, "{backend:?} {threads} threads");
            assert_eq!(one.all, other.all, "{backend:?} {threads} threads");
            assert_eq!(one.rays, other.rays);
        }
    }
}

/// A 10 um baseline at world coordinate 2^20 m: moved by powers of two, the scene gives the same bytes as at the
/// origin.
#[test]
fn a_far_away_scene_is_the_scene_at_the_origin() {
    let near = lit_soup(5);
    let shift = [f64::from(1 << 20), -f64::from(1 << 19), f64::from(1 << 22)];
    let mut far = near.clone();
    far.instances.iter_mut().for_each(|i| i.transform.translation = shift);
    for light in &mut far.lights {
        if let LightKind::Point { position, .. } = &mut light.kind {
            (0..3).for_each(|k| position[k] += shift[k]);
        }
    }
    let rig = rig([4, 4], [15, 20], 1e-5, 3.0, Projection::Perspective);
    let request = everything(rig, 2, [0.1; 3]);
    for backend in engines() {
        let a = render(&near, &request, backend, 1);
        let b = render_from(&far, &Transform::from_translation(shift), &request, backend, 1);
        assert_eq!(a.color, b.color, "{backend:?}");
        assert_eq!(a.all, b.all, "{backend:?}");
    }
}

/// A scene 10,000 km from the origin, where f64 rounds positions to 2 nm, with a rotated camera. Depth agrees with that
/// at the origin to f32 rounding and 10 nm of slope, disparity (up to 1.4e-4 px here) to its rounding, except at one
/// silhouette pixel in
/// 1000. Radiance agrees to 1e-4, except at one pixel in 100, at shadow edges.
#[test]
fn ten_thousand_kilometers_away_nanometers_are_lost() {
    let place = |shift: [f64; 3]| {
        let pose = Transform::from_parts(shift, [0.3, -0.5, 0.2, 0.7], [1.0; 3]);
        let mut scene = lit_soup(8);
        for (k, instance) in scene.instances.iter_mut().enumerate() {
            instance.transform.translation = [0.123 * k as f64, -0.077 * k as f64, 0.031 * k as f64];
            instance.transform = pose.after(&instance.transform);
        }
        for light in &mut scene.lights {
            match &mut light.kind {
                LightKind::Point { position, .. } => *position = pose.point(*position),
                LightKind::Directional { direction, .. } => *direction = pose.vector(*direction),
                _ => unreachable!("no other light in this scene"),
            }
        }
        (scene, pose)
    };
    let rig = rig([4, 4], [20, 30], 1e-5, 3.0, Projection::Perspective);
    let request = everything(rig, 1, [0.0; 3]);
    for backend in engines() {
        let [a, b] = [[0.0; 3], [1e7, -1e7, 1e7]].map(|shift| {
            let (scene, pose) = place(shift);
            render_from(&scene, &pose, &request, backend, 1)
        });
        let off = |what: &str, a: ndarray::ArrayView5<f32>, b: ndarray::ArrayView5<f32>, relative: f32, plus: f32| {
            let bound = |a: f32, b: f32| relative * a.abs().min(b.abs()) + plus;
            let count = a.iter().zip(&b).filter(|&(&a, &b)| differ(a, b, bound(a, b))).count();
            println!("{backend:?} {what}: {count} of {}", a.len());
            count as f64 / a.len() as f64
        };
        let [all_a, all_b] = [&a, &b].map(|rendered| rendered.all.as_ref().expect("requested"));
        let [depth_a, depth_b] = [all_a, all_b].map(|all| all[Layer::Depth].samples());
        assert!(off("depth", depth_a, depth_b, 1.2e-7, 1e-8) <= 1e-3);
        let [disparity_a, disparity_b] = [all_a, all_b].map(|all| all[Layer::Disparity].samples());
        assert!(off("disparity", disparity_a, disparity_b, 1.2e-7, 5e-12) <= 1e-3);
        let [color_a, color_b] = [&a, &b].map(|rendered| rendered.color.as_ref().expect("lit").samples());
        assert!(off("light", color_a, color_b, 1e-4, 1e-6) <= 1e-2);
        assert!(color_a.iter().any(|x| *x > 0.0));
    }
}

/// At that distance, views 10 um apart remain distinct: the depth of a wall at 45 degrees agrees with its plane in each
/// view, to f32 rounding.
#[test]
fn ten_micrometers_survive_ten_thousand_kilometers_away() {
    let shift = [1e7, -1e7, 1e7];
    let mut scene = Scene::default();
    // z = -3 + x
    let slanted = Transform {
        columns: [[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [shift[0], shift[1], shift[2] - 3.0],
    };
    add(&mut scene, square(40.0), [1.0; 4], slanted);
    let rig = rig([4, 4], [9, 12], 1e-5, 1.0, Projection::Perspective);
    for backend in engines() {
        let all =
            render_from(&scene, &Transform::from_translation(shift), &truth(rig), backend, 1).all.expect("requested");
        let depth = all[Layer::Depth].samples();
        for ((v, u, t, s, _), &found) in depth.indexed_iter() {
            let exact = depth_of_plane([-1.0, 0.0, 3.0], &rig.ray(v, u, t, s, 0.5, 0.5));
            assert!((f64::from(found) / exact - 1.0).abs() <= 6.0e-8, "{backend:?} {v} {u} {t} {s}: {found} {exact}");
        }
        // 30 um of baseline, twice that behind the focus plane, on a slope of 1: hundreds of steps of f32.
        assert!((depth[[4, 6, 0, 0, 0]] - depth[[4, 6, 0, 3, 0]]).abs() > 2e-5);
    }
}

/// The scene scaled by a power of two, light intensities by its square: the same bytes, with depths scaled by the
/// factor.
#[test]
fn powers_of_two_change_nothing() {
    let scene = lit_soup(6);
    let base = rig([4, 4], [15, 20], 0.01, 3.0, Projection::Perspective);
    for exponent in [-20, -10, 10, 20] {
        let scale = 2.0_f64.powi(exponent);
        let mut scaled = scene.clone();
        let columns = [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]];
        scaled.instances.iter_mut().for_each(|i| i.transform.columns = columns);
        for light in &mut scaled.lights {
            if let LightKind::Point { position, .. } = &mut light.kind {
                position.iter_mut().for_each(|x| *x *= scale);
                light.intensity.iter_mut().for_each(|x| *x *= scale * scale);
            }
        }
        let rig = rig([4, 4], [15, 20], 0.01 * scale, 3.0 * scale, Projection::Perspective);
        for backend in engines() {
            let a = render(&scene, &everything(base, 2, [0.1; 3]), backend, 1);
            let b = render(&scaled, &everything(rig, 2, [0.1; 3]), backend, 1);
            assert_eq!(a.color, b.color, "{backend:?} x 2^{exponent}");
            let (a, b) = (a.all.expect("requested"), b.all.expect("requested"));
            assert_eq!(a[Layer::Disparity], b[Layer::Disparity], "{backend:?} x 2^{exponent}");
            let times = a[Layer::Depth].samples().mapv(|z| z * scale as f32);
            assert_eq!(times, b[Layer::Depth].samples(), "{backend:?} x 2^{exponent}");
        }
    }
}

/// A scene scaled by a thousand or a million, with rig and lights, has the same disparities. The scale is not a power
/// of two, so f32 rounding differs: one silhouette pixel in a thousand may change, the others agree to 1e-6 px of up to
/// 0.6.
#[test]
fn scale_does_not_matter() {
    let scene = soup(300, 6);
    let base = rig([4, 4], [20, 30], 0.01, 3.0, Projection::Perspective);
    for scale in [1e-6, 1e-3, 1e3, 1e6] {
        let mut scaled = scene.clone();
        scaled
            .instances
            .iter_mut()
            .for_each(|i| i.transform.columns = [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]]);
        let rig = rig([4, 4], [20, 30], 0.01 * scale, 3.0 * scale, Projection::Perspective);
        for backend in engines() {
            let a = render(&scene, &truth(base), backend, 1).all.expect("requested");
            let b = render(&scaled, &truth(rig), backend, 1).all.expect("requested");
            let (a, b) = (a[Layer::Disparity].samples(), b[Layer::Disparity].samples());
            let count = a.iter().zip(b).filter(|(a, b)| differ(**a, **b, 1e-6)).count();
            println!("{backend:?} x {scale}: {count} of {}", a.len());
            assert!(count * 1000 <= a.len(), "{backend:?} x {scale}: {count}");
        }
    }
}

/// Sizes at the edges: one view, one lens, one pixel, long rows of views.
#[test]
fn any_shape_of_rig_works() {
    let scene = lit_soup(7);
    for (views, lenses) in [
        ([1, 1], [1, 1]),
        ([1, 1], [33, 17]),
        ([1, 10_000], [1, 1]),
        ([10_000, 1], [1, 1]),
        ([3, 5], [1, 50]),
        ([70_000, 1], [1, 1]),
    ] {
        let rig = rig(views, lenses, 1e-5, 3.0, Projection::Perspective);
        let rendered = render(&scene, &everything(rig, 1, [0.1; 3]), Backend::Bvh, 2);
        let color = rendered.color.expect("lit");
        assert_eq!(color.samples().dim(), (lenses[0], lenses[1], views[0], views[1], 3));
        assert!(color.samples().iter().all(|x| x.is_finite() && *x >= 0.0));
        assert!(color.samples().iter().any(|x| *x > 0.0));
    }
}

/// 65,535 and 65,537 views, a million microlenses: no index is truncated to 16 bits, no product to 32. Every pixel has
/// the depth of its own ray to a slanted wall, to f32 rounding.
#[test]
fn sizes_at_the_edges_of_index_types_work() {
    let (scene, plane) = slanted_wall();
    for (views, lenses) in [
        ([1, 65_535], [1, 2]),
        ([257, 255], [2, 1]),
        ([65_537, 1], [1, 1]),
        ([1, 1], [1000, 1000]),
        ([2, 1], [1, 1 << 20]),
    ] {
        let rig = rig(views, lenses, 1e-5, 3.0, Projection::Perspective);
        for backend in engines() {
            let all = render(&scene, &truth(rig), backend, 2).all.expect("requested");
            let depth = all[Layer::Depth].samples();
            assert_eq!(depth.dim(), (lenses[0], lenses[1], views[0], views[1], 1));
            for ((v, u, t, s, _), &found) in depth.indexed_iter() {
                let exact = depth_of_plane(plane, &rig.ray(v, u, t, s, 0.5, 0.5));
                assert!(
                    (f64::from(found) / exact - 1.0).abs() <= 6.0e-8,
                    "{backend:?} {v} {u} {t} {s}: {found} {exact}"
                );
            }
        }
    }
}

/// Sizes beyond memory are errors without an allocation.
#[test]
fn absurd_sizes_are_errors() {
    let renderer = Renderer::new(&soup(4, 1), &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1)).unwrap();
    let huge = rig([30_000, 30_000], [10_000, 10_000], 1e-5, 3.0, Projection::Perspective);
    for request in [truth(huge), everything(huge, 1, [1.0; 3])] {
        assert!(matches!(renderer.render(&request, &()), Err(Error::Core(_))));
    }
}

/// Triangles without area and duplicates of triangles change nothing.
#[test]
fn degenerate_triangles_do_no_harm() {
    let mut scene = Scene::default();
    add(&mut scene, square(5.0), [0.5, 0.5, 0.5, 1.0], Transform::from_translation([0.0, 0.0, -3.0]));
    scene.lights.push(Light {
        name: String::new(),
        intensity: [1.0; 3],
        kind: LightKind::Directional { direction: [0.0, 0.0, -1.0], angular_diameter_rad: 0.0 },
    });
    let rig = rig([4, 4], [9, 9], 0.01, 3.0, Projection::Perspective);
    let request = everything(rig, 2, [0.3; 3]);
    let clean: Vec<_> = engines().into_iter().map(|b| render(&scene, &request, b, 1)).collect();
    scene.meshes[0].triangles.extend([[0, 0, 0], [1, 1, 2], [0, 1, 2], [0, 2, 3]]);
    for (backend, clean) in engines().into_iter().zip(clean) {
        let dirty = render(&scene, &request, backend, 1);
        assert_eq!(dirty.color, clean.color, "{backend:?}");
        assert_eq!(dirty.all, clean.all, "{backend:?}");
    }
}

/// A focus plane in front of and behind all surfaces, at infinity, on the surface: every pixel has the depth of its own
/// ray to a slanted wall.
#[test]
fn any_focus_sees_the_wall_at_its_depth() {
    let (scene, plane) = slanted_wall();
    for focus in [1e-3, 3.0, 1e9, f64::INFINITY] {
        let rig = rig([2, 2], [5, 5], 1e-4, focus, Projection::Perspective);
        for backend in engines() {
            let all = render(&scene, &truth(rig), backend, 1).all.expect("requested");
            for ((v, u, t, s, _), &found) in all[Layer::Depth].samples().indexed_iter() {
                let exact = depth_of_plane(plane, &rig.ray(v, u, t, s, 0.5, 0.5));
                assert!((f64::from(found) / exact - 1.0).abs() <= 6.0e-8, "focus {focus}: {found} {exact}");
                let disparity = f64::from(all[Layer::Disparity].samples()[[v, u, t, s, 0]]);
                let expected = rig.disparity().from_depth_m(exact);
                let scale = rig.disparity().from_depth_m(exact / 2.0).abs().max(expected.abs());
                assert!((disparity - expected).abs() <= 1.2e-7 * scale, "focus {focus}: {disparity} {expected}");
            }
        }
    }
}

/// A camera in the middle of a solid block sees its inner walls; a camera in the plane of a wall sees what is in front
/// of it.
#[test]
fn a_camera_in_a_wall_sees_what_is_before_it() {
    let rig = rig([2, 2], [9, 12], 1e-6, 3.0, Projection::Perspective);
    for backend in engines() {
        for half in [1e-4, 0.5] {
            let mut scene = Scene::default();
            // Only the wall ahead and the wall behind: those at the sides are out of sight.
            let wall = Transform::from_translation([0.0, 0.0, -half]);
            add(&mut scene, square(10.0), [1.0; 4], wall);
            add(&mut scene, square(10.0), [1.0; 4], Transform::from_translation([0.0, 0.0, half]));
            let central = render(&scene, &truth(rig), backend, 1).central;
            assert!(central[Layer::Depth].iter().all(|z| *z == half as f32), "{backend:?} {half}");
        }
        let mut scene = Scene::default();
        add(&mut scene, square(10.0), [1.0; 4], Transform::IDENTITY);
        add(&mut scene, square(10.0), [1.0; 4], Transform::from_translation([0.0, 0.0, -2.0]));
        let central = render(&scene, &truth(rig), backend, 1).central;
        assert!(central[Layer::Depth].iter().all(|z| *z == 2.0), "{backend:?}: the plane of the cameras is not seen");
    }
}

/// Empty scenes, meshes without triangles, no light: the sky, infinite depth, and black that is exactly 0.
#[test]
fn empty_and_black_scenes_are_the_sky_and_black() {
    let rig = rig([3, 3], [7, 9], 0.01, 3.0, Projection::Perspective);
    let sky = [0.25, 0.5, 2.0];
    let mut hollow = Scene::default();
    add(&mut hollow, Mesh::default(), [1.0; 4], Transform::IDENTITY);
    let mut points = Scene::default();
    add(&mut points, Mesh { positions: vec![[0.0; 3]; 4], ..Mesh::default() }, [1.0; 4], Transform::IDENTITY);
    for backend in engines() {
        for scene in [&Scene::default(), &hollow, &points] {
            let rendered = render(scene, &everything(rig, 2, sky), backend, 1);
            let color = rendered.color.expect("requested");
            assert!(color.samples().indexed_iter().all(|(at, &x)| x == sky[at.4]), "{backend:?}");
            assert!(rendered.central[Layer::Depth].iter().all(|z| *z == f32::INFINITY));
            let far = rig.disparity().from_depth_m(f64::INFINITY) as f32;
            assert!(rendered.central[Layer::Disparity].iter().all(|d| *d == far));
        }
        for integrator in [Integrator::Direct, Integrator::Path] {
            let request = everything(rig, 2, [0.0; 3]).integrator(integrator);
            let color = render(&soup(40, 2), &request, backend, 1).color.expect("requested");
            assert!(color.samples().iter().all(|x| x.to_bits() == 0), "{backend:?} {integrator:?}");
        }
    }
}

#[test]
fn broken_scenes_are_named_errors() {
    let mut nan = soup(4, 1);
    nan.meshes[0].positions[0][1] = f32::NAN;
    let mut range = soup(4, 1);
    range.meshes[1].triangles[0][2] = 99;
    let mut far = soup(4, 1);
    far.instances[0].transform.translation = [1e30, 0.0, 0.0];
    // Finite numbers whose products are not finite.
    let mut canceling = soup(4, 1);
    canceling.instances[0].transform.columns = [[1e308, 0.0, 0.0], [-1e308, 1e-3, 0.0], [0.0, 0.0, 1.0]];
    let mut glaring = soup(4, 1);
    let direction = [0.0, 0.0, -1.0];
    glaring.lights.push(Light {
        name: "sun".into(),
        intensity: [1e39; 3],
        kind: LightKind::Directional { direction, angular_diameter_rad: 0.0 },
    });
    for (scene, word) in
        [(nan, "meshes[0]"), (range, "meshes[1]"), (far, "mesh"), (canceling, "mesh"), (glaring, "lights[0]")]
    {
        let Err(error) = Renderer::new(&scene, &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1)) else {
            panic!("accepted")
        };
        assert!(error.to_string().contains(word), "{error}");
    }
}

/// A rig beyond the range of f32 is an error.
#[test]
fn a_rig_of_absurd_size_is_an_error() {
    let renderer = Renderer::new(&soup(4, 1), &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(1)).unwrap();
    let rig = rig([2, 2], [3, 3], 1e39, f64::INFINITY, Projection::Perspective);
    assert!(matches!(renderer.render(&truth(rig), &()), Err(Error::BadSetting(_))));
}
