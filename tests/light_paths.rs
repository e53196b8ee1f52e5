//! Glass and mirrors where they usually go wrong: the energy stays bounded, and nothing is no number.

mod common;

use common::{add, rig, square};
use holo_core::{GridSize, LightFieldShape, Projection, Rig};
use holo_render::{Backend, Integrator, Layer, Renderer, Request};
use holo_scene::{Light, LightKind, Material, Mesh, Scene, Transform, Volume};

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
            println!("{name} {ior}: {mean:.4}");
            assert!((0.8..1.02).contains(&mean), "{name} {ior}: {mean}");
        }
        let mut around = Scene::default();
        place(&mut around, cube(1.0), glass(ior), Transform::IDENTITY);
        let (mean, _) = under_the_sky(&around, &Transform::IDENTITY, 64, 64);
        println!("camera inside {ior}: {mean:.4}, n^2 {:.4}", ior * ior);
        assert!(mean > 0.9 && mean < f64::from(ior * ior) * 1.02, "camera inside, {ior}: {mean}");
    }
}

/// Two mirrors that face each other, and the camera between: a ray leaves after as many reflections as its slope says, and brings the
/// sky, dimmed by each; one that has not left after 64 brings nothing. 1e-5 for up to 64 products of f32.
#[test]
fn sixty_four_bounces_between_mirrors_lose_nothing_and_gain_nothing() {
    let mirror = |reflectance: f32| Material {
        base_color: [reflectance, reflectance, reflectance, 1.0],
        metallic: 1.0,
        roughness: 0.0,
        ..Material::default()
    };
    let rig = rig([3, 3], [64, 96], 0.01, 2.0, Projection::Perspective);
    for reflectance in [1.0, 0.96875] {
        let mut scene = Scene::default();
        place(&mut scene, square(1.0), mirror(reflectance), Transform::from_translation([0.0, 0.0, -1.0]));
        place(&mut scene, square(1.0), mirror(reflectance), Transform::from_translation([0.0, 0.0, 0.5]));
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, 0).expect("a scene");
        let request = Request {
            integrator: Integrator::Path,
            sky: [1.0; 3],
            max_bounces: 64,
            roulette: false,
            ..Request::new(rig)
        };
        let color = renderer.render(&request, &()).expect("a render").color.expect("a picture");
        let (mut judged, mut most, mut trapped) = (0, 0, 0);
        for ((v, u, t, s, channel), &found) in color.samples().indexed_iter() {
            let ray = rig.ray(v, u, t, s, 0.5, 0.5);
            // The mirror number k is met after 1 + 1.5 k metres of depth.
            let reach = |k: i32| {
                (0..2)
                    .map(|i| (ray.origin_m[i] + ray.direction[i] * (1.0 + 1.5 * f64::from(k))).abs())
                    .fold(0.0, f64::max)
            };
            let reflections = (0..).find(|&k| reach(k) > 1.0 || k > 80).expect("a number");
            // Too close to a mirror's border to say, or to the last bounce.
            if (0..=reflections).any(|k| (reach(k) - 1.0).abs() < 1e-5) || (63..66).contains(&reflections) {
                continue;
            }
            let expected = if reflections < 64 { f64::from(reflectance).powi(reflections) } else { 0.0 };
            assert!((f64::from(found) - expected).abs() < 1e-5, "{reflections} reflections: {found} for {expected}");
            if channel > 0 {
                continue;
            }
            judged += 1;
            trapped += i32::from(reflections > 64);
            most = if reflections < 64 { most.max(reflections) } else { most };
        }
        println!("mirrors of {reflectance}: {judged} pixels, up to {most} reflections, {trapped} have more than 64");
        assert!(judged > 40_000 && most > 40 && trapped > 0, "{judged} {most} {trapped}");
    }
}

/// A camera that sees a hundred-thousandth of a degree: with it rays meet a surface at the angle that is wanted.
fn narrow_rig(half_angle: f64) -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(2, 2), GridSize::new(8, 12)).expect("sizes"))
        .focal_length_m(0.018 / half_angle)
        .sensor_size_m(0.036)
        .baseline_m(1e-9)
        .focus_distance_m(2.0)
        .build()
        .expect("a rig")
}

/// At the critical angle and at grazing incidence the equations of Fresnel divide by what is nearly nothing: a pane seen at
/// angles down to 0.001 degrees, and a prism around the critical angle in steps of 1e-6 and 1e-5 of it, through cameras that see no more than
/// that. Under a sky of 1 a pane shows 1, to 2 % for noise. In a block of glass a ray just short of the critical angle meets the face and
/// the one opposite a little more than every second time (34 of 64 events, by its slope), passes T of Fresnel's equations each time,
/// and is held by the other faces: n^2 (1 - (1 - T)^34), to 15 % for what 34 is worth; beyond the angle it never leaves. (At 1e-6 the
/// rounding of f32 directions is a tenth of the step: never more than n^2.)
#[test]
fn grazing_and_critical_angles_are_numbers() {
    for degrees in [10.0_f64, 1.0, 0.1, 0.01, 0.001] {
        // The plane of the pane holds the view's centre but for this angle: from (0, 0, 0) it is met after 2 m.
        let angle = degrees.to_radians();
        let (sin, cos) = (0.5 * (std::f64::consts::FRAC_PI_2 - angle)).sin_cos();
        let tilted = Transform::from_parts([0.0, 0.0, -2.0], [sin, 0.0, 0.0, cos], [1.0; 3]);
        let mut scene = Scene::default();
        place(&mut scene, square(3.0), Material { volume: None, ..glass(1.5) }, tilted);
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, 0).expect("a scene");
        let (rig, integrator) = (narrow_rig(angle / 8.0), Integrator::Path);
        let request = Request { integrator, samples: 16, sky: [1.0; 3], max_bounces: 16, ..Request::new(rig) };
        let rendered = renderer.render(&request, &()).expect("a render");
        let hit = rendered.central[Layer::Depth].iter().filter(|z| z.is_finite()).count();
        assert_eq!(hit, 8 * 12, "{degrees}: every pixel sees the pane");
        let color = rendered.color.expect("a picture");
        let off = color.samples().iter().map(|&x| (f64::from(x) - 1.0).abs()).fold(0.0, f64::max);
        println!("pane at {degrees} degrees: off by {off:.1e}");
        assert!(color.samples().iter().all(|x| (0.98..1.02).contains(x)), "{degrees}: {off}");
    }
    let critical = (1.0 / 1.5_f64).asin();
    let transmitted = |angle: f64| {
        let (inside, sine) = (angle.cos(), 1.5 * angle.sin());
        let outside = (1.0 - sine * sine).max(0.0).sqrt();
        let [s, p] = [(1.5 * inside, outside), (inside, 1.5 * outside)].map(|(a, b)| ((a - b) / (a + b)).powi(2));
        1.0 - 0.5 * (s + p)
    };
    for (step, width) in (-3..=3).flat_map(|step| [(step, 1e-6), (step, 1e-5)]) {
        let angle = critical * (1.0 + f64::from(step) * width);
        let (sin, cos) = (0.5 * angle).sin_cos();
        let tilted = Transform::from_parts([0.0; 3], [sin, 0.0, 0.0, cos], [1.0; 3]);
        let mut scene = Scene::default();
        // The camera in the middle of the glass looks at a face under the critical angle.
        place(&mut scene, cube(1.0), glass(1.5), tilted);
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, 0).expect("a scene");
        let (rig, integrator) = (narrow_rig(critical * width), Integrator::Path);
        let (samples, roulette) = (256, false);
        let request = Request { integrator, samples, roulette, sky: [1.0; 3], max_bounces: 64, ..Request::new(rig) };
        let color = renderer.render(&request, &()).expect("a render").color.expect("a picture");
        let values = color.samples();
        assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0));
        let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
        // Over the height of the picture, 2/3 of its width.
        let angles = (0..64).map(|k| angle + critical * width * 2.0 / 3.0 * ((f64::from(k) + 0.5) / 32.0 - 1.0));
        let expected = 2.25 * angles.map(|angle| 1.0 - (1.0 - transmitted(angle)).powi(34)).sum::<f64>() / 64.0;
        println!("critical angle {step:+} x {width:e}: mean {mean:.4}, expected {expected:.4}");
        assert!(mean < 2.25 * 1.02, "{step} x {width}: {mean}");
        if width == 1e-5 && step != 0 {
            assert!((mean - expected).abs() <= 0.15 * expected + 0.01, "{step}: {mean} {expected}");
        }
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
        assert!(other.samples().iter().filter(|x| **x > 0.0).count() > 100, "something must be lit");
        for (a, b) in one.samples().iter().zip(other.samples()) {
            let (a, b) = (f64::from(*a), f64::from(*b) / power);
            // Which light is asked, and where, is the same; sums of some ten f32.
            assert!((a - b).abs() <= 1e-5 * a.abs(), "{power}: {a} {b}");
        }
    }
}
