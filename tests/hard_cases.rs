//! Where renderers usually lose precision or fall over.

mod common;

use common::{add, engines, everything, render, render_from, rig, soup, square, truth};
use holo_core::Projection;
use holo_render::scene::{Light, LightKind, Scene, Transform};
use holo_render::{Backend, Error, Layer, Renderer};

fn lit_soup(seed: u64) -> Scene {
    let mut scene = soup(300, seed);
    let sun = LightKind::Directional { direction: [0.0, -0.6, -0.8], angular_diameter_rad: 0.0 };
    let lamp = LightKind::Point { position: [0.5, 1.0, -1.0], range: None };
    scene.lights.push(Light { name: "sun".into(), intensity: [2.0, 1.9, 1.7], kind: sun });
    scene.lights.push(Light { name: "lamp".into(), intensity: [0.5, 0.7, 0.9], kind: lamp });
    scene
}

/// The same bytes for any number of threads, and again.
#[test]
fn the_image_does_not_depend_on_threads() {
    let scene = lit_soup(4);
    let rig = rig([7, 6], [19, 23], 0.01, 3.0, Projection::Perspective);
    let request = everything(rig, 3, [0.2, 0.3, 0.4]);
    for backend in engines() {
        let one = render(&scene, &request, backend, 1);
        for threads in [1, 2, 3, 8] {
            let other = render(&scene, &request, backend, threads);
            assert_eq!(one.color, other.color, "{backend:?} {threads} threads");
            assert_eq!(one.all, other.all, "{backend:?} {threads} threads");
            assert_eq!(one.rays, other.rays);
        }
    }
}

/// A 10 um baseline at world coordinate 2^20 m: moved by powers of two, the scene gives the same bytes as at the origin.
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

/// A scene a thousand or a million times smaller or larger, rig and lights scaled with it, has the same disparities. The scale is no
/// power of two, so f32 rounding differs: silhouettes may flip, one pixel in a thousand.
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
            let a = render(&scene, &truth(base), backend, 1).all.expect("asked for");
            let b = render(&scaled, &truth(rig), backend, 1).all.expect("asked for");
            let (a, b) = (a[Layer::Disparity].samples(), b[Layer::Disparity].samples());
            let count = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 1e-5).count();
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

/// 65,535 and 65,537 views, a million lenses: no index is cut to 16 bits, no product to 32.
#[test]
fn sizes_at_the_edges_of_index_types_work() {
    let mut scene = Scene::default();
    add(&mut scene, square(500.0), [1.0; 4], Transform::from_translation([0.0, 0.0, -3.0]));
    for (views, lenses) in [
        ([1, 65_535], [1, 2]),
        ([257, 255], [2, 1]),
        ([65_537, 1], [1, 1]),
        ([1, 1], [1000, 1000]),
        ([2, 1], [1, 1 << 20]),
    ] {
        let rig = rig(views, lenses, 1e-9, 3.0, Projection::Perspective);
        let all = render(&scene, &truth(rig), Backend::Bvh, 2).all.expect("asked for");
        let depth = all[Layer::Depth].samples();
        assert_eq!(depth.dim(), (lenses[0], lenses[1], views[0], views[1], 1));
        assert!(depth.iter().all(|z| *z == 3.0), "{views:?} {lenses:?}");
    }
}

/// Sizes beyond memory are refused, not tried.
#[test]
fn absurd_sizes_are_errors() {
    let renderer = Renderer::new(&soup(4, 1), &Transform::IDENTITY, Backend::Bvh, 1).unwrap();
    let huge = rig([30_000, 30_000], [10_000, 10_000], 1e-5, 3.0, Projection::Perspective);
    for request in [truth(huge), everything(huge, 1, [1.0; 3])] {
        assert!(matches!(renderer.render(&request, &()), Err(Error::Core(_))));
    }
}

/// Triangles without area, and duplicates of triangles, change nothing and break nothing.
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

/// A focus plane behind everything, at infinity, on the surface: the rig decides where rays go, not what they hit.
#[test]
fn any_focus_sees_the_plane_at_its_depth() {
    let mut scene = Scene::default();
    add(&mut scene, square(500.0), [1.0; 4], Transform::from_translation([0.0, 0.0, -3.0]));
    for focus in [1e-3, 3.0, 1e9, f64::INFINITY] {
        let rig = rig([2, 2], [5, 5], 1e-4, focus, Projection::Perspective);
        let rendered = render(&scene, &truth(rig), Backend::Bvh, 1);
        assert!(rendered.central[Layer::Depth].iter().all(|z| *z == 3.0), "focus {focus}");
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
    // Finite numbers that are none any more once they are multiplied.
    let mut cancelling = soup(4, 1);
    cancelling.instances[0].transform.columns = [[1e308, 0.0, 0.0], [-1e308, 1e-3, 0.0], [0.0, 0.0, 1.0]];
    let mut glaring = soup(4, 1);
    let direction = [0.0, 0.0, -1.0];
    glaring.lights.push(Light {
        name: "sun".into(),
        intensity: [1e39; 3],
        kind: LightKind::Directional { direction, angular_diameter_rad: 0.0 },
    });
    for (scene, word) in
        [(nan, "meshes[0]"), (range, "meshes[1]"), (far, "mesh"), (cancelling, "mesh"), (glaring, "lights[0]")]
    {
        let Err(error) = Renderer::new(&scene, &Transform::IDENTITY, Backend::Bvh, 1) else { panic!("accepted") };
        assert!(error.to_string().contains(word), "{error}");
    }
}

/// A rig beyond the range of f32 is refused.
#[test]
fn a_rig_of_absurd_size_is_an_error() {
    let renderer = Renderer::new(&soup(4, 1), &Transform::IDENTITY, Backend::Bvh, 1).unwrap();
    let rig = rig([2, 2], [3, 3], 1e39, f64::INFINITY, Projection::Perspective);
    assert!(matches!(renderer.render(&truth(rig), &()), Err(Error::BadSetting(_))));
}
