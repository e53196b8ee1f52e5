//! Shadows where they usually go wrong: no light through surfaces, no surface in its own shadow.

mod common;

use common::{add, engines, everything, render, rig, square};
use holo_core::Projection;
use holo_render::scene::{Light, LightKind, Mesh, Scene, Transform};
use holo_render::{Layer, LayerSet, Request};

fn light(kind: LightKind) -> Light {
    Light { name: String::new(), intensity: [1.0; 3], kind }
}

/// Pixels without any light, of all views.
fn dark_pixels(scene: &Scene, backend: holo_render::Backend) -> (usize, usize) {
    let rig = rig([4, 4], [40, 60], 0.002, 2.0, Projection::Perspective);
    let color = render(scene, &everything(rig, 1, [0.0; 3]), backend, 2).color.expect("lit");
    let dark = color.samples().iter().step_by(3).filter(|x| **x == 0.0).count();
    (dark, color.samples().len() / 3)
}

/// A wall of 4 m x 4 mm strips, tilted, under a slanting sun: rounding on slivers must not let a strip shade itself.
#[test]
fn slivers_do_not_shade_themselves() {
    let mut scene = Scene::default();
    let mut mesh = Mesh::default();
    for k in 0..1000u32 {
        let (y0, y1) = (-2.0 + 0.004 * k as f32, -2.0 + 0.004 * (k + 1) as f32);
        mesh.positions.extend([[-2.0, y0, 0.0], [2.0, y0, 0.0], [2.0, y1, 0.0], [-2.0, y1, 0.0]]);
        mesh.triangles.extend([[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]);
    }
    let tilt = Transform::from_parts([0.01, -0.02, -2.0], [0.21, 0.13, 0.08, 0.96], [1.0; 3]);
    add(&mut scene, mesh, [0.8, 0.8, 0.8, 1.0], tilt);
    let direction = [0.48, -0.6, -0.64];
    scene.lights.push(light(LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
    for backend in engines() {
        let (dark, all) = dark_pixels(&scene, backend);
        assert_eq!(dark, 0, "{backend:?}: of {all}");
    }
}

/// A sheet 30 cm before a wall casts the same shadow whether the lamp is 100 m or 1000 km away behind the camera.
#[test]
fn the_distance_of_a_lamp_does_not_lose_its_shadow() {
    for backend in engines() {
        let mut counts = Vec::new();
        for distance in [100.0, 1e4, 1e6] {
            let mut scene = Scene::default();
            add(&mut scene, square(5.0), [0.8, 0.8, 0.8, 1.0], Transform::from_translation([0.0, 0.0, -2.0]));
            add(&mut scene, square(0.1), [0.8, 0.8, 0.8, 1.0], Transform::from_translation([0.0, 0.0, -1.7]));
            let direction = [0.6 * distance, 0.0, 0.8 * distance];
            scene.lights.push(Light {
                intensity: [distance * distance; 3],
                ..light(LightKind::Point { position: direction, range: None })
            });
            counts.push(dark_pixels(&scene, backend).0);
        }
        assert!(counts[0] > 100, "the shadow must be in the picture: {counts:?}");
        // The nearest moves the edge by 2 mm: one column of pixels, an eighth of this narrow shadow.
        assert!(counts.iter().all(|&n| n.abs_diff(counts[2]) * 8 <= counts[2]), "{backend:?} {counts:?}");
    }
}

/// A lamp that lies in the ceiling lights the room below.
#[test]
fn a_lamp_in_the_ceiling_is_not_hidden_by_it() {
    let mut scene = Scene::default();
    add(&mut scene, square(5.0), [0.8, 0.8, 0.8, 1.0], Transform::from_translation([0.0, 0.0, -2.0]));
    // A tilted sheet above, out of sight, with the lamp at its centre.
    let center = [0.1, 1.3, -1.1];
    let sheet = Transform::from_parts(center, [0.7, 0.02, 0.01, 0.71], [1.0; 3]);
    add(&mut scene, square(0.3), [0.8, 0.8, 0.8, 1.0], sheet);
    scene.lights.push(light(LightKind::Point { position: center, range: None }));
    for backend in engines() {
        let (dark, all) = dark_pixels(&scene, backend);
        assert_eq!(dark, 0, "{backend:?}: of {all}");
    }
}

/// Coincident duplicates of a surface do not shade each other.
#[test]
fn duplicates_do_not_shade_each_other() {
    let mut scene = Scene::default();
    for _ in 0..3 {
        let tilt = Transform::from_parts([0.01, -0.02, -2.0], [0.21, 0.13, 0.08, 0.96], [1.0; 3]);
        add(&mut scene, square(4.0), [0.8, 0.8, 0.8, 1.0], tilt);
    }
    let direction = [0.48, -0.6, -0.64];
    scene.lights.push(light(LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
    for backend in engines() {
        assert_eq!(dark_pixels(&scene, backend).0, 0, "{backend:?}");
    }
}

/// Under a sun 0.01 degrees above the horizon every pixel of a plain has E sin(0.01 degrees) of it, and none is dark: f32 knows the
/// cosine of so flat an angle to 1e-7/1.7e-4.
#[test]
fn grazing_light_is_even() {
    let elevation = 0.01_f64.to_radians();
    let mut scene = Scene::default();
    // Seen from above: the plain faces the camera, the sun comes from the right.
    add(&mut scene, square(4.0), [0.8, 0.8, 0.8, 1.0], Transform::from_translation([0.0, 0.0, -2.0]));
    let direction = [-elevation.cos(), 0.0, -elevation.sin()];
    scene.lights.push(light(LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
    let expected = 0.8 / std::f64::consts::PI * elevation.sin();
    for backend in engines() {
        let rig = rig([4, 4], [40, 60], 0.002, 2.0, Projection::Perspective);
        let color = render(&scene, &everything(rig, 1, [0.0; 3]), backend, 2).color.expect("lit");
        let worst = color.samples().iter().map(|&x| (f64::from(x) / expected - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 2e-3, "{backend:?}: {worst}");
    }
}

/// A coarse ball with smooth normals under a sun: where the triangle itself is turned away it is dark, and where it faces the sun it is
/// not darker than Lambert's law makes it; no light comes through from behind.
#[test]
fn the_terminator_of_a_coarse_ball_has_neither_acne_nor_leaks() {
    let mut mesh = Mesh::default();
    let (around, up) = (16_u32, 8_u32);
    for i in 0..=up {
        for j in 0..=around {
            let (a, b) = (std::f64::consts::PI * f64::from(i) / 8.0, std::f64::consts::TAU * f64::from(j) / 16.0);
            let point = [a.sin() * b.cos(), a.cos(), a.sin() * b.sin()].map(|x| x as f32);
            mesh.positions.push(point);
            mesh.normals.push(point);
        }
    }
    for i in 0..up {
        for j in 0..around {
            let [a, b, c, d] = [i * 17 + j, (i + 1) * 17 + j, (i + 1) * 17 + j + 1, i * 17 + j + 1];
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    let mut scene = Scene::default();
    add(&mut scene, mesh, [1.0; 4], Transform::from_translation([0.0, 0.0, -4.0]));
    let sun = [-0.8_f32, -0.36, -0.48];
    let direction = sun.map(f64::from);
    scene.lights.push(light(LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
    for backend in engines() {
        let rig = rig([2, 2], [80, 120], 0.002, 4.0, Projection::Perspective);
        let layers = LayerSet::of(&[Layer::GeometricNormal, Layer::ShadingNormal, Layer::HitMask]);
        let request = Request { layers, ..everything(rig, 1, [0.0; 3]) };
        let rendered = render(&scene, &request, backend, 2);
        let (color, all) = (rendered.color.expect("lit"), rendered.all.expect("asked for"));
        let (geometric, shading) = (all[Layer::GeometricNormal].samples(), all[Layer::ShadingNormal].samples());
        let [mut leaks, mut acne, mut lit] = [0; 3];
        for ((v, u, t, s, c), value) in color.samples().indexed_iter() {
            if c > 0 || all[Layer::HitMask].samples()[[v, u, t, s, 0]] == 0.0 {
                continue;
            }
            let facing = |normals: &ndarray::ArrayView5<f32>| -> f32 {
                (0..3).map(|k| -sun[k] * normals[[v, u, t, s, k]]).sum()
            };
            let (by_triangle, by_normal) = (facing(&geometric), facing(&shading));
            // The rim of the shadow is a rounding wide.
            leaks += usize::from(by_triangle < -1e-4 && *value > 0.0);
            let expected = by_normal.max(0.0) / std::f32::consts::PI;
            acne += usize::from(by_triangle > 1e-4 && *value < 0.999 * expected);
            lit += usize::from(*value > 0.0);
        }
        assert!(lit > 4000, "{backend:?}: only {lit} pixels are lit");
        assert_eq!((leaks, acne), (0, 0), "{backend:?}: leaks, acne");
    }
}
