//! Hard cases of glass and mirrors: energy is bounded, and no radiance is NaN.

use std::num::NonZeroUsize;

use crate::common;
use crate::common::{add, rig, square};
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

/// Adds a mesh with a material.
fn place(scene: &mut Scene, mesh: Mesh, material: Material, transform: Transform) {
    add(scene, mesh, [1.0; 4], transform);
    *scene.materials.last_mut().expect("just added") = material;
}

/// Mean and largest radiance under a sky of 1, by paths of many bounces.
fn under_the_sky(scene: &Scene, pose: &Transform, samples: u32, bounces: u32) -> (f64, f32) {
    let renderer = Renderer::new(scene, pose, Backend::Auto, None).expect("a scene");
    let request = Request::new(rig([3, 3], [12, 18], 0.01, 2.0, Projection::Perspective))
        .integrator(Integrator::Path)
        .samples(samples)
        .sky([1.0; 3])
        .max_bounces(bounces);
    let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
    let values = color.samples();
    assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "NaN, infinite or negative");
    let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
    (mean, values.iter().copied().fold(0.0, f32::max))
}

/// Under a sky of 1 the radiance is at most n^2 inside glass and 1 outside, for nested and for touching bodies. (Where
/// glass touches glass, light is refracted twice with air between, which changes directions and preserves energy.) 2 %
/// for the noise of 64 samples.
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

/// A camera between two parallel mirrors: a ray leaves after a number of reflections that follows from its slope, and
/// returns the sky times the reflectance of each. A ray with more than 64 reflections returns 0. 1e-5 for up to 64
/// products of f32.
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
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
        let request = Request::new(rig).integrator(Integrator::Path).sky([1.0; 3]).max_bounces(64).roulette(false);
        let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
        let (mut judged, mut most, mut trapped) = (0, 0, 0);
        for ((v, u, t, s, channel), &found) in color.samples().indexed_iter() {
            let ray = rig.ray(v, u, t, s, 0.5, 0.5);
            // Mirror number k is hit at a depth of 1 + 1.5 k meters.
            let reach = |k: i32| {
                (0..2)
                    .map(|i| (ray.origin_m[i] + ray.direction[i] * (1.0 + 1.5 * f64::from(k))).abs())
                    .fold(0.0, f64::max)
            };
            let reflections = (0..).find(|&k| reach(k) > 1.0 || k > 80).expect("a number");
            // Too close to the edge of a mirror, or to the last bounce.
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

/// Near the critical angle and at grazing incidence Fresnel's equations divide by numbers near 0. The test views a pane
/// at angles down to 0.001 degrees, and a block of glass around the critical angle in steps of 1e-6 and 1e-5 of it,
/// with cameras of that field of view. Under a sky of 1 the pane has radiance 1, to 2 % for noise. In the block, a ray
/// just below the critical angle hits the face or the opposite one at 34 of 64 path vertices, by its slope. A share T
/// is transmitted each time, and the other faces reflect totally: n^2 (1 - (1 - T)^34), to 15 % for the uncertainty of
/// 34. Beyond the angle the ray never leaves. (At 1e-6 the rounding of f32 directions is a tenth of the step: at most
/// n^2.)
#[test]
fn radiance_at_grazing_and_critical_angles_is_finite() {
    for degrees in [10.0_f64, 1.0, 0.1, 0.01, 0.001] {
        // The center of the view is in the plane of the pane up to this angle; a ray from (0, 0, 0) hits it after 2 m.
        let angle = degrees.to_radians();
        let (sin, cos) = (0.5 * (std::f64::consts::FRAC_PI_2 - angle)).sin_cos();
        let tilted = Transform::from_parts([0.0, 0.0, -2.0], [sin, 0.0, 0.0, cos], [1.0; 3]);
        let mut scene = Scene::default();
        place(&mut scene, square(3.0), Material { volume: None, ..glass(1.5) }, tilted);
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
        let (rig, integrator) = (narrow_rig(angle / 8.0), Integrator::Path);
        let request = Request::new(rig).integrator(integrator).samples(16).sky([1.0; 3]).max_bounces(16);
        let rendered = renderer.render(&request, &()).expect("a render");
        let hit = rendered.central[Layer::Depth].iter().filter(|z| z.is_finite()).count();
        assert_eq!(hit, 8 * 12, "{degrees}: every pixel sees the pane");
        let color = rendered.color.expect("an image");
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
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
        let (rig, integrator) = (narrow_rig(critical * width), Integrator::Path);
        let (samples, roulette) = (256, false);
        let request =
            Request::new(rig).integrator(integrator).samples(samples).roulette(roulette).sky([1.0; 3]).max_bounces(64);
        let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
        let values = color.samples();
        assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0));
        let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
        // Over the height of the image, 2/3 of its width.
        let angles = (0..64).map(|k| angle + critical * width * 2.0 / 3.0 * ((f64::from(k) + 0.5) / 32.0 - 1.0));
        let expected = 2.25 * angles.map(|angle| 1.0 - (1.0 - transmitted(angle)).powi(34)).sum::<f64>() / 64.0;
        println!("critical angle {step:+} x {width:e}: mean {mean:.4}, expected {expected:.4}");
        assert!(mean < 2.25 * 1.02, "{step} x {width}: {mean}");
        if width == 1e-5 && step != 0 {
            assert!((mean - expected).abs() <= 0.15 * expected + 0.01, "{step}: {mean} {expected}");
        }
    }
}

/// Light of 1e12 and of 1e-12: the image is the same up to the factor, to 24 bits.
#[test]
fn images_scale_with_very_strong_and_very_faint_light() {
    let image = |power: f64| {
        let mut scene = common::soup(60, 3);
        let kind = LightKind::Point { position: [0.5, 1.0, 0.0], range: None };
        scene.lights.push(Light { name: "lamp".into(), intensity: [power; 3], kind });
        let renderer =
            Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, NonZeroUsize::new(1)).expect("a scene");
        let request = Request::new(rig([2, 2], [8, 12], 0.01, 3.0, Projection::Perspective))
            .integrator(Integrator::Path)
            .samples(4)
            .roulette(false)
            .max_bounces(3);
        renderer.render(&request, &()).expect("a render").color.expect("an image")
    };
    let one = image(1.0);
    for power in [1e12, 1e-12] {
        let other = image(power);
        assert!(other.samples().iter().filter(|x| **x > 0.0).count() > 100, "something must be lit");
        for (a, b) in one.samples().iter().zip(other.samples()) {
            let (a, b) = (f64::from(*a), f64::from(*b) / power);
            // The choices of light sampling are the same; sums of about ten f32.
            assert!((a - b).abs() <= 1e-5 * a.abs(), "{power}: {a} {b}");
        }
    }
}

/// A square that glows inside a block of absorbing glass without refraction: half of its light is left after the 0.2 m
/// of glass before it, seen from outside and by a camera in the glass.
#[test]
fn what_lies_in_absorbing_glass_is_attenuated() {
    let body = |distance: f32| Material {
        specular: 0.0,
        ior: 1.0,
        volume: Some(Volume { attenuation_distance_m: distance, attenuation_color: [0.5; 3] }),
        ..glass(1.0)
    };
    let lamp = Material { emission: [1.0; 3], ..Material::default() };
    let color = |scene: &Scene| {
        let renderer = Renderer::new(scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
        let rig = rig([1, 1], [3, 3], 0.0, 2.0, Projection::Orthographic);
        let request = Request::new(rig).integrator(Integrator::Path);
        let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
        color.samples()[[1, 1, 0, 0, 0]]
    };
    // Beside the axis, so that the ray in the middle meets no edge.
    let at = |z: f64| Transform::from_translation([0.013, 0.029, z]);
    let mut scene = Scene::default();
    // From 1.8 m to 2.8 m, and the square at 2 m.
    place(&mut scene, cube(0.5), body(0.2), at(-2.3));
    place(&mut scene, square(0.6), lamp.clone(), at(-2.0));
    let seen = color(&scene);
    assert!((seen - 0.5).abs() < 1e-3, "{seen}");

    // A block in a block: 0.1 m of the outer glass and 0.1 m of the inner one, which absorbs twice as much.
    let mut nested = Scene::default();
    place(&mut nested, cube(0.5), body(0.2), at(-2.3));
    place(&mut nested, cube(0.3), body(0.1), at(-2.2));
    place(&mut nested, square(0.2), lamp.clone(), at(-2.0));
    let seen = color(&nested);
    assert!((seen - 0.5f32.powf(1.5)).abs() < 1e-3, "{seen}");

    // A hollow: what lies behind the air bubble is seen through 0.1 m of glass, not 0.3 m.
    let mut hollow = Scene::default();
    place(&mut hollow, cube(0.5), body(0.2), at(-2.3));
    place(&mut hollow, cube(0.1), Material { volume: body(f32::INFINITY).volume, ..body(1.0) }, at(-2.0));
    place(&mut hollow, square(0.05), lamp, at(-1.95));
    let seen = color(&hollow);
    assert!((seen - 0.5f32.powf(0.5)).abs() < 1e-3, "{seen}");
}

/// A body of water in water cannot be seen: inside a medium the index of refraction is relative to it.
#[test]
fn a_body_in_the_same_medium_is_invisible() {
    let image = |with: bool| {
        let mut scene = Scene::default();
        place(&mut scene, cube(0.5), glass(1.33), Transform::from_translation([0.1, 0.05, -1.6]));
        if with {
            place(&mut scene, cube(0.2), glass(1.33), Transform::from_translation([0.1, 0.0, -1.6]));
        }
        let lamp = Material { emission: [1.0, 2.0, 3.0], ..Material::default() };
        place(&mut scene, square(0.3), lamp, Transform::from_translation([0.0, 0.0, -3.0]));
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
        let request = Request::new(rig([1, 1], [30, 40], 0.0, 2.0, Projection::Perspective))
            .integrator(Integrator::Path)
            .samples(64)
            .roulette(false)
            .sky([0.5; 3])
            .max_bounces(16);
        renderer.render(&request, &()).expect("a render").color.expect("an image").samples().to_owned()
    };
    let (without, with) = (image(false), image(true));
    let mean = |x: &ndarray::Array5<f32>| x.iter().map(|x| f64::from(*x)).sum::<f64>() / x.len() as f64;
    assert!((mean(&with) / mean(&without) - 1.0).abs() < 0.01, "{} {}", mean(&with), mean(&without));
    let rmse =
        (with.iter().zip(&without).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / with.len() as f64).sqrt();
    // Noise of 64 samples where light is reflected or refracted; a body in air there would give 0.3.
    assert!(rmse < 0.08, "{rmse}");
}

/// The choice at surfaces of partial opacity is one of the seed, also for a single ray through the center of the pixel.
#[test]
fn partial_opacity_depends_on_the_seed() {
    let mut scene = Scene::default();
    let veil = Material {
        base_color: [1.0, 1.0, 1.0, 0.5],
        alpha: holo_scene::Alpha::Blend,
        unlit: true,
        ..Material::default()
    };
    place(&mut scene, square(9.0), veil, Transform::from_translation([0.0, 0.0, -2.0]));
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
    let image = |seed: u64| {
        let request = Request::new(rig([4, 4], [20, 20], 0.01, 2.0, Projection::Perspective)).seed(seed);
        renderer.render(&request, &()).expect("a render").color.expect("an image").samples().to_owned()
    };
    let (a, b) = (image(1), image(2));
    assert_eq!(a, image(1));
    let share = |x: &ndarray::Array5<f32>| x.iter().filter(|x| **x > 0.5).count() as f64 / x.len() as f64;
    assert!((share(&a) - 0.5).abs() < 0.03 && (share(&b) - 0.5).abs() < 0.03, "{} {}", share(&a), share(&b));
    let same = a.iter().zip(&b).filter(|(a, b)| a == b).count() as f64 / a.len() as f64;
    assert!((same - 0.5).abs() < 0.03, "{same}");
}

/// The disc of a distant light is what a far, glowing disc of the same size and radiance is, on surfaces from mirrors to
/// Lambert's: both techniques that find it are weighted right. 1 % for the noise.
#[test]
fn a_sun_is_a_far_glowing_disc() {
    let (diameter, radiance): (f64, f64) = (0.2, 5.0);
    // Before the camera, so that the floor reflects it there.
    let (sin, direction) = ((0.5 * diameter).sin(), [0.0, 0.28, -0.96]);
    let far = 1e5;
    let lamp_pose = Transform::look_at(direction.map(|x: f64| x * far), [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    for (metallic, roughness) in [(1.0, 0.0), (1.0, 0.1), (1.0, 0.3), (0.0, 0.2), (0.0, 1.0)] {
        let floor =
            Material { metallic, roughness, specular: 1.0, base_color: [0.5, 0.5, 0.5, 1.0], ..Material::default() };
        let mean = |as_light: bool| {
            let mut scene = Scene::default();
            let corners = [[-2.0, -0.5, -0.5], [2.0, -0.5, -0.5], [2.0, -0.5, -4.0], [-2.0, -0.5, -4.0]];
            let ground = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
            place(&mut scene, ground, floor.clone(), Transform::IDENTITY);
            if as_light {
                let irradiance = radiance * std::f64::consts::PI * sin * sin;
                let kind = LightKind::Directional { direction: direction.map(|x| -x), angular_diameter_rad: diameter };
                scene.lights.push(Light { name: String::new(), intensity: [irradiance; 3], kind });
            } else {
                let radius = far * (0.5 * diameter).tan();
                let rim = (0..256)
                    .map(|k| f64::from(k) / 256.0 * std::f64::consts::TAU)
                    .map(|angle| [angle.cos() * radius, angle.sin() * radius, 0.0].map(|x| x as f32));
                let positions = std::iter::once([0.0; 3]).chain(rim).collect();
                let triangles = (0..256).map(|k| [0, 1 + k, 1 + (k + 1) % 256]).collect();
                let emission = Material { emission: [radiance as f32; 3], ..Material::default() };
                place(&mut scene, Mesh { positions, triangles, ..Mesh::default() }, emission, lamp_pose);
            }
            let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
            let request = Request::new(rig([2, 2], [40, 60], 0.01, 2.0, Projection::Perspective))
                .integrator(Integrator::Direct)
                .samples(64);
            let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
            color.samples().iter().map(|&x| f64::from(x)).sum::<f64>() / color.samples().len() as f64
        };
        let (sun, disc) = (mean(true), mean(false));
        println!("metal {metallic}, roughness {roughness}: {sun:.5} {disc:.5}");
        assert!(sun > 0.001 && (sun / disc - 1.0).abs() < 0.01, "{metallic} {roughness}: {sun} {disc}");
    }
}

/// With culling the camera and the ground truth see through the back of a surface that has only a front; its shadow and
/// its mirror image stay.
#[test]
fn culled_backs_are_seen_by_light_alone() {
    let mut scene = Scene::default();
    let mut turned = Transform::from_translation([0.0, 0.0, -1.0]);
    turned.columns[0][0] = -1.0;
    turned.columns[2][2] = -1.0;
    place(&mut scene, square(0.2), Material { double_sided: false, ..Material::default() }, turned);
    place(&mut scene, square(3.0), Material::default(), Transform::from_translation([0.0, 0.0, -2.0]));
    let kind = LightKind::Directional { direction: [0.0, 0.0, -1.0], angular_diameter_rad: 0.0 };
    scene.lights.push(Light { name: String::new(), intensity: [1.0; 3], kind });
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
    let center = |cull: bool| {
        let request = Request::new(rig([1, 1], [21, 21], 0.0, 2.0, Projection::Perspective)).cull(cull);
        let rendered = renderer.render(&request, &()).expect("a render");
        (rendered.central[Layer::Depth][[10, 10, 0]], rendered.color.expect("lit").samples()[[10, 10, 0, 0, 0]])
    };
    let ((depth, light), (culled_depth, culled_light)) = (center(false), center(true));
    assert!((depth - 1.0).abs() < 1e-5 && (culled_depth - 2.0).abs() < 1e-5, "{depth} {culled_depth}");
    assert!(light > 0.3 && culled_light == 0.0, "the wall behind is in its shadow: {light} {culled_light}");
}

/// A limit bounds what paths add after their first hit, takes light away only, and changes nothing above all of it.
#[test]
fn a_limit_takes_away_bright_paths_alone() {
    let mut scene = Scene::default();
    place(&mut scene, square(3.0), Material::default(), Transform::from_translation([0.0, 0.0, -2.0]));
    let lamp = Material { emission: [200.0; 3], ..Material::default() };
    place(&mut scene, square(0.05), lamp, Transform::from_translation([0.3, 0.6, -1.5]));
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
    let image = |limit: f32| {
        let request = Request::new(rig([1, 1], [20, 30], 0.0, 2.0, Projection::Perspective))
            .integrator(Integrator::Path)
            .samples(16)
            .sky([0.1; 3])
            .indirect_limit(limit);
        renderer.render(&request, &()).expect("a render").color.expect("an image").samples().to_owned()
    };
    let (free, low, high) = (image(f32::INFINITY), image(0.05), image(1e6));
    assert_eq!(free, high);
    assert!(free.iter().zip(&low).all(|(free, low)| low <= free), "light is added");
    assert!(free.iter().zip(&low).any(|(free, low)| *low < 0.9 * free), "nothing is limited");
    let request = Request::new(rig([1, 1], [2, 2], 0.0, 2.0, Projection::Perspective));
    assert!(renderer.render(&request.indirect_limit(0.0), &()).is_err());
}

/// A diffuse floor, 4 m in front of the camera, lit from the right; what stands between is out of the camera's sight.
struct Floor {
    scene: Scene,
    rig: Rig,
}

impl Floor {
    fn lit_by_a_point() -> Self {
        let mut floor = Self::dark();
        floor.scene.lights.push(Light {
            name: String::new(),
            intensity: [10.0; 3],
            kind: LightKind::Point { position: [4.0, 0.0, -2.0], range: None },
        });
        floor
    }

    fn lit_by_a_panel() -> Self {
        let mut floor = Self::dark();
        let emitter = Material { emission: [5.0; 3], double_sided: true, ..Material::default() };
        floor.put(square(0.5), emitter, [3.0, 0.0, -3.0]);
        floor
    }

    fn dark() -> Self {
        let mut scene = Scene::default();
        let gray = Material { base_color: [0.5, 0.5, 0.5, 1.0], specular: 0.0, ..Material::default() };
        place(&mut scene, square(3.0), gray, Transform::from_translation([0.0, 0.0, -4.0]));
        Self { scene, rig: rig([1, 2], [12, 18], 0.01, 4.0, Projection::Perspective) }
    }

    /// Adds a mesh that was built across the z axis, turned to stand across the x axis.
    fn put(&mut self, mesh: Mesh, material: Material, at: [f64; 3]) {
        let upright = mesh.positions.iter().map(|[x, y, z]| [*z, *y, -*x]).collect();
        place(&mut self.scene, Mesh { positions: upright, ..mesh }, material, Transform::from_translation(at));
    }

    fn render(&self, samples: u32, seed: u64, transparent: bool) -> Vec<f64> {
        let renderer = Renderer::new(&self.scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
        let request = Request::new(self.rig)
            .integrator(Integrator::Path)
            .samples(samples)
            .seed(seed)
            .transparent_shadows(transparent);
        let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
        color.samples().iter().map(|&x| f64::from(x)).collect()
    }

    /// For every sample of the image: the cosine of the way to the point light with the x axis.
    fn cosines(&self) -> Vec<f64> {
        let mut out = Vec::new();
        for (v, u, t, s) in pixels(self.rig.shape()) {
            let ray = self.rig.ray(v, u, t, s, 0.5, 0.5);
            let at = [0, 1].map(|k| ray.origin_m[k] + 4.0 * ray.direction[k]);
            let way = [4.0 - at[0], -at[1], 2.0];
            out.extend([way[0] / way.iter().map(|x| x * x).sum::<f64>().sqrt(); 3]);
        }
        out
    }
}

/// All pixels, in the order of the samples.
fn pixels(shape: &LightFieldShape) -> Vec<(usize, usize, usize, usize)> {
    let ([v, u], [t, s]) = ([shape.lenses().rows, shape.lenses().columns], [shape.views().rows, shape.views().columns]);
    let all = (0..v).flat_map(|v| (0..u).map(move |u| (v, u)));
    all.flat_map(|(v, u)| (0..t).flat_map(move |t| (0..s).map(move |s| (v, u, t, s)))).collect()
}

/// The reflectance of glass of index 1.5 by Fresnel's equations.
fn reflectance(cosine: f64) -> f64 {
    let n2 = 2.25;
    let g = (n2 - 1.0 + cosine * cosine).sqrt();
    let (across, along) = ((cosine - g) / (cosine + g), (n2 * cosine - g) / (n2 * cosine + g));
    0.5 * (across * across + along * along)
}

/// With transparent shadows a point light shines through a pane and through a block of absorbing glass, by as much as
/// Fresnel's equations and the law of Beer and Lambert say of the straight way; without, it does not. Rough glass is as
/// it was. 1e-4 for f32.
#[test]
fn transparent_shadows_are_those_of_the_straight_way() {
    let free = Floor::lit_by_a_point();
    let (lit, cosines) = (free.render(1, 0, false), free.cosines());
    assert!(lit.iter().all(|x| *x > 0.01));
    assert_eq!(free.render(1, 0, true), lit, "nothing is between");

    let pane = Material { volume: None, base_color: [1.0, 0.5, 0.25, 1.0], ..glass(1.5) };
    let mut slab = cube(5.0);
    slab.positions.iter_mut().for_each(|p| p[2] *= 0.05);
    let volume = Some(Volume { attenuation_distance_m: 0.5, attenuation_color: [0.5, 0.25, 1.0] });
    let block = Material { volume, ..glass(1.5) };
    let mut frosted = Floor::lit_by_a_point();
    frosted.put(square(5.0), Material { roughness: 0.5, ..pane.clone() }, [2.5, 0.0, -3.0]);
    assert_eq!(frosted.render(4, 0, true), frosted.render(4, 0, false), "rough glass is as without");
    for (name, mesh, material) in [("pane", square(5.0), pane), ("block", slab, block)] {
        let mut floor = Floor::lit_by_a_point();
        floor.put(mesh, material, [2.5, 0.0, -3.0]);
        assert!(floor.render(1, 0, false).iter().all(|x| *x == 0.0), "{name}: a point light has no caustic");
        let found = floor.render(1, 0, true);
        let mut largest = 0.0_f64;
        for (k, (found, lit)) in found.iter().zip(&lit).enumerate() {
            let (cosine, channel) = (cosines[k], k % 3);
            let once = 1.0 - reflectance(cosine);
            let expected = match name {
                "pane" => once * [1.0, 0.5, 0.25][channel],
                _ => once * once * [0.5_f64, 0.25, 1.0][channel].powf(0.5 / cosine / 0.5),
            };
            largest = largest.max((found / lit - expected).abs());
        }
        println!("{name}: {largest:.1e} from the straight way");
        assert!(largest < 1e-4, "{name}: {largest}");
    }
}

/// Behind a pane a panel gives the light that paths find, which is exact for panes, with less noise. Three standard
/// errors of the paths' mean.
#[test]
fn transparent_shadows_of_panes_are_exact_and_calm() {
    let mut floor = Floor::lit_by_a_panel();
    let pane = Material { volume: None, base_color: [0.8, 0.8, 0.8, 1.0], ..glass(1.5) };
    floor.put(square(5.0), pane, [2.0, 0.0, -3.0]);
    // Means and variances between seeds.
    let statistics = |transparent: bool| {
        let images: Vec<Vec<f64>> = (0..8).map(|seed| floor.render(64, seed, transparent)).collect();
        let means: Vec<f64> = images.iter().map(|image| image.iter().sum::<f64>() / image.len() as f64).collect();
        let mean = means.iter().sum::<f64>() / 8.0;
        let error = (means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 7.0 / 8.0).sqrt();
        let pixel = |k: usize| {
            let values: Vec<f64> = images.iter().map(|image| image[k]).collect();
            let mean = values.iter().sum::<f64>() / 8.0;
            values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 7.0
        };
        let noise = (0..images[0].len()).map(pixel).sum::<f64>() / images[0].len() as f64;
        (mean, error, noise)
    };
    let ((paths, error, noise), (straight, own, calm)) = (statistics(false), statistics(true));
    println!("paths {paths:.6} +- {error:.6}, straight {straight:.6} +- {own:.6}; variance {noise:.3e} to {calm:.3e}");
    assert!(paths > 0.0 && (paths - straight).abs() < 3.0 * (error * error + own * own).sqrt(), "{paths} {straight}");
    assert!(calm < 0.2 * noise, "{calm} {noise}");
}
