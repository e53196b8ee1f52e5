//! Glass and mirrors where they usually go wrong: the energy stays bounded, and nothing is no number.

mod common;

use common::{add, rig, square};
use holo_core::Projection;
use holo_render::scene::{Light, LightKind, Material, Mesh, Scene, Transform, Volume};
use holo_render::{Backend, Integrator, Renderer, Request};

/// A closed box of half-width `half`.
fn cube(half: f32) -> Mesh {
    let positions = (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half } else { -half })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

fn glass(ior: f32) -> Material {
    let volume = Some(Volume { attenuation_distance_m: f32::INFINITY, attenuation_color: [1.0; 3] });
    Material { roughness: 0.0, specular: 1.0, transmission: 1.0, ior, volume, ..Material::default() }
}

/// Adds a mesh of a material.
fn place(scene: &mut Scene, mesh: Mesh, material: Material, transform: Transform) {
    add(scene, mesh, [1.0; 4], transform);
    *scene.materials.last_mut().expect("just added") = material;
}

/// Mean and largest radiance under a sky of 1, by paths of many bounces.
fn under_the_sky(scene: &Scene, pose: &Transform, samples: u32, bounces: u32) -> (f64, f32) {
    let renderer = Renderer::new(scene, pose, Backend::Auto, 0).expect("a scene");
    let request = Request {
        integrator: Integrator::Path,
        samples,
        sky: [1.0; 3],
        max_bounces: bounces,
        ..Request::new(rig([3, 3], [12, 18], 0.01, 2.0, Projection::Perspective))
    };
    let color = renderer.render(&request, &()).expect("a render").color.expect("a picture");
    let values = color.samples();
    assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "not a number, or less than nothing");
    let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
    (mean, values.iter().copied().fold(0.0, f32::max))
}

/// Under a sky of 1 radiance inside glass is at most n^2, where the camera is inside, and 1 outside, however bodies are nested or
/// touch. (A body is taken to stand in air: where glass touches glass the light is refracted twice with air between, which
/// changes directions and keeps the energy.) 2 % for the noise of 64 samples.
#[test]
fn glass_in_glass_and_a_camera_in_glass_gain_nothing() {
    let away = Transform::from_translation([0.0, 0.0, -2.0]);
    for ior in [1.0, 1.33, 1.5, 2.4] {
        let mut nested = Scene::default();
        place(&mut nested, cube(0.5), glass(ior), away);
        place(&mut nested, cube(0.3), glass(1.5), away);
        let mut touching = Scene::default();
        place(&mut touching, cube(0.3), glass(ior), Transform::from_translation([-0.3, 0.0, -2.0]));
        place(&mut touching, cube(0.3), glass(1.5), Transform::from_translation([0.3, 0.0, -2.0]));
        for (name, scene) in [("nested", nested), ("touching", touching)] {
            let (mean, _) = under_the_sky(&scene, &Transform::IDENTITY, 64, 64);
            assert!((0.8..1.02).contains(&mean), "{name} {ior}: {mean}");
        }
        let mut around = Scene::default();
        place(&mut around, cube(1.0), glass(ior), Transform::IDENTITY);
        let (mean, _) = under_the_sky(&around, &Transform::IDENTITY, 64, 64);
        assert!(mean > 0.9 && mean < f64::from(ior * ior) * 1.02, "camera inside, {ior}: {mean}");
    }
}

/// Two mirrors that face each other, and the camera between: 64 times to and fro, and what comes out is the sky, dimmed by the
/// mirrors alone.
#[test]
fn sixty_four_bounces_between_mirrors_lose_nothing_and_gain_nothing() {
    let mirror = |reflectance: f32| Material {
        base_color: [reflectance, reflectance, reflectance, 1.0],
        metallic: 1.0,
        roughness: 0.0,
        ..Material::default()
    };
    for reflectance in [1.0, 0.5] {
        let mut scene = Scene::default();
        place(&mut scene, square(1.0), mirror(reflectance), Transform::from_translation([0.0, 0.0, -1.0]));
        place(&mut scene, square(1.0), mirror(reflectance), Transform::from_translation([0.0, 0.0, 0.5]));
        let (mean, high) = under_the_sky(&scene, &Transform::IDENTITY, 4, 64);
        assert!(high <= 1.0001 && mean > 0.0, "{reflectance}: {mean} {high}");
        if reflectance == 1.0 {
            // All that is not still on its way after 64 bounces has arrived: the steepest rays of a pixel stay longest.
            assert!(mean > 0.9, "{mean}");
        }
    }
}

/// At the critical angle and at grazing incidence the equations of Fresnel divide by what is nearly nothing: a pane seen at
/// angles down to 0.001 degrees and a prism around the critical angle, in steps of 1e-6 of its sine.
#[test]
fn grazing_and_critical_angles_are_numbers() {
    for degrees in [10.0_f64, 1.0, 0.1, 0.01, 0.001] {
        let (sin, cos) = (0.5 * (90.0 - degrees).to_radians()).sin_cos();
        // A slab seen along its face.
        let tilted = Transform::from_parts([0.0, 0.0, -2.0], [sin, 0.0, 0.0, cos], [1.0; 3]);
        let mut scene = Scene::default();
        place(&mut scene, square(3.0), Material { volume: None, ..glass(1.5) }, tilted);
        let (mean, high) = under_the_sky(&scene, &Transform::IDENTITY, 16, 16);
        assert!((0.98..1.02).contains(&mean) && high < 1.5, "{degrees}: {mean} {high}");
    }
    let critical = (1.0 / 1.5_f64).asin();
    for step in -3..=3 {
        let angle = critical + f64::from(step) * 1e-6;
        let (sin, cos) = (0.5 * angle).sin_cos();
        let tilted = Transform::from_parts([0.0; 3], [sin, 0.0, 0.0, cos], [1.0; 3]);
        let mut scene = Scene::default();
        // The camera in the middle of the glass looks at a face under the critical angle.
        place(&mut scene, cube(1.0), glass(1.5), tilted);
        let (mean, _) = under_the_sky(&scene, &Transform::IDENTITY, 16, 64);
        assert!(mean > 0.9 && mean < 2.25 * 1.03, "{step}: {mean}");
    }
}

/// Light of 1e12 and of 1e-12: the picture is the same but for the factor, 24 bits of it.
#[test]
fn very_strong_and_very_faint_light_is_light() {
    let picture = |power: f64| {
        let mut scene = common::soup(60, 3);
        let kind = LightKind::Point { position: [0.5, 1.0, 0.0], range: None };
        scene.lights.push(Light { name: "lamp".into(), intensity: [power; 3], kind });
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, 1).expect("a scene");
        let request = Request {
            integrator: Integrator::Path,
            samples: 4,
            roulette: false,
            max_bounces: 3,
            ..Request::new(rig([2, 2], [8, 12], 0.01, 3.0, Projection::Perspective))
        };
        renderer.render(&request, &()).expect("a render").color.expect("a picture")
    };
    let one = picture(1.0);
    for power in [1e12, 1e-12] {
        let other = picture(power);
        for (a, b) in one.samples().iter().zip(other.samples()) {
            let (a, b) = (f64::from(*a), f64::from(*b) / power);
            // Which light is asked, and where, is the same; sums of some ten f32.
            assert!((a - b).abs() <= 1e-5 * a.abs(), "{power}: {a} {b}");
        }
    }
}
