//! Hard cases of shadows: no light leaks, no self-shadowing.

use crate::common::{add, engines, everything, render, rig, square};
use holo_core::Projection;
use holo_render::{Integrator, Layer, LayerSet};
use holo_scene::{Light, LightKind, Mesh, Scene, Transform};

fn light(kind: LightKind) -> Light {
    Light { name: String::new(), intensity: [1.0; 3], kind }
}

/// The black pixels of all views, and the number of all pixels.
fn dark_pixels(scene: &Scene, backend: holo_render::Backend) -> (usize, usize) {
    let rig = rig([4, 4], [40, 60], 0.002, 2.0, Projection::Perspective);
    let color = render(scene, &everything(rig, 1, [0.0; 3]), backend, 2).color.expect("lit");
    // NaN counts as black.
    let dark = color.samples().iter().step_by(3).filter(|x| x.is_nan() || **x <= 0.0).count();
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

/// A sheet 30 cm in front of a wall casts the same shadow for a light 100 m or 1000 km behind the camera.
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
        assert!(counts[0] > 100, "the shadow must be in the image: {counts:?}");
        // The nearest moves the edge by 2 mm: one column of pixels, an eighth of this narrow shadow.
        assert!(counts.iter().all(|&n| n.abs_diff(counts[2]) * 8 <= counts[2]), "{backend:?} {counts:?}");
    }
}

/// A point light within the ceiling lights the room below.
#[test]
fn a_lamp_in_the_ceiling_is_not_hidden_by_it() {
    let mut scene = Scene::default();
    add(&mut scene, square(5.0), [0.8, 0.8, 0.8, 1.0], Transform::from_translation([0.0, 0.0, -2.0]));
    // A tilted sheet above, out of sight, with the lamp at its center.
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

/// A tilted wall that is a micrometer, a meter or a thousand kilometers wide does not shadow itself: the offset of
/// shadow rays scales with the scene.
#[test]
fn no_scale_shades_itself() {
    for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let mut scene = Scene::default();
        let tilt = Transform::from_parts([0.01, -0.02, -2.0].map(|x| x * scale), [0.21, 0.13, 0.08, 0.96], [scale; 3]);
        add(&mut scene, square(4.0), [0.8, 0.8, 0.8, 1.0], tilt);
        let direction = [0.48, -0.6, -0.64];
        scene.lights.push(light(LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
        let rig = rig([4, 4], [40, 60], 0.002 * scale, 2.0 * scale, Projection::Perspective);
        for backend in engines() {
            let color = render(&scene, &everything(rig, 1, [0.0; 3]), backend, 2).color.expect("lit");
            let dark = color.samples().iter().filter(|x| x.is_nan() || **x <= 0.0).count();
            assert_eq!(dark, 0, "{backend:?} x {scale}");
        }
    }
}

/// A tilted plane of 5000 triangles under a sun 0.01 degrees above it: every pixel has E sin(0.01 degrees), to 1e-3,
/// the rounding of this cosine in f32 (1e-7 of 1.7e-4), and none is black. With the sun 0.01 degrees below, all are
/// black.
#[test]
fn grazing_light_is_even() {
    let elevation = 0.01_f64.to_radians();
    let mut plain = Mesh::default();
    for k in 0..51 * 51 {
        plain.positions.push([-4.0 + 0.16 * (k % 51) as f32, -4.0 + 0.16 * (k / 51) as f32, 0.0]);
    }
    for k in 0..50 * 50_u32 {
        let a = k / 50 * 51 + k % 50;
        plain.triangles.extend([[a, a + 1, a + 52], [a, a + 52, a + 51]]);
    }
    let tilt = Transform::from_parts([0.01, -0.02, -2.0], [0.21, 0.13, 0.08, 0.96], [1.0; 3]);
    let rig = rig([4, 4], [40, 60], 0.002, 2.0, Projection::Perspective);
    for (elevation, below) in [(elevation, false), (-elevation, true)] {
        let mut scene = Scene::default();
        add(&mut scene, plain.clone(), [0.8, 0.8, 0.8, 1.0], tilt);
        let direction = tilt.vector([-elevation.cos(), 0.0, -elevation.sin()]);
        scene.lights.push(light(LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
        let expected = 0.8 / std::f64::consts::PI * elevation.sin();
        for backend in engines() {
            let color = render(&scene, &everything(rig, 1, [0.0; 3]), backend, 2).color.expect("lit");
            let values = color.samples();
            assert!(values.iter().all(|x| x.is_finite()));
            if below {
                assert!(values.iter().all(|x| *x == 0.0), "{backend:?}: light from below");
                continue;
            }
            let worst = values.iter().map(|&x| (f64::from(x) / expected - 1.0).abs()).fold(0.0, f64::max);
            println!("{backend:?}: {worst:.1e}");
            assert!(worst < 1e-3, "{backend:?}: {worst}");
        }
    }
}

/// A closed room is black with any light outside: no light leaks through its walls, edges and corners.
#[test]
fn no_light_leaks_into_a_closed_room() {
    let positions = (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    let room = Mesh { positions, triangles, ..Mesh::default() };
    let mut scene = Scene::default();
    let turned = Transform::from_parts([0.1, 0.05, -0.2], [0.21, 0.33, 0.18, 0.8], [1.0; 3]);
    add(&mut scene, room, [0.8, 0.8, 0.8, 1.0], turned);
    for direction in [[0.48, -0.6, -0.64], [-1.0, 0.0, 0.0], [0.6, 0.0, 0.8]] {
        scene.lights.push(light(LightKind::Directional { direction, angular_diameter_rad: 0.02 }));
    }
    let lamp = LightKind::Point { position: [0.5, 3.0, -1.0], range: None };
    scene.lights.push(Light { intensity: [1e6; 3], ..light(lamp) });
    // An edge, a corner and the walls between are in the image.
    let rig = rig([4, 4], [80, 120], 0.002, 1.0, Projection::Perspective);
    for backend in engines() {
        for integrator in [Integrator::Direct, Integrator::Path] {
            let request = everything(rig, 4, [1.0; 3]).integrator(integrator);
            let rendered = render(&scene, &request, backend, 2);
            assert!(rendered.central[Layer::Depth].iter().all(|z| z.is_finite()));
            let lit = rendered.color.expect("requested").samples().iter().filter(|x| **x != 0.0).count();
            assert_eq!(lit, 0, "{backend:?} {integrator:?}");
        }
    }
}

/// A coarse ball with smooth normals under a sun: triangles that face away are black, and triangles that face the sun
/// are not darker than by Lambert's law; no light leaks from behind.
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
        let request = everything(rig, 1, [0.0; 3]).layers(layers);
        let rendered = render(&scene, &request, backend, 2);
        let (color, all) = (rendered.color.expect("lit"), rendered.all.expect("requested"));
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
