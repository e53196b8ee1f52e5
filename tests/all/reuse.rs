//! Path reuse between views: no bias, less noise, the same bytes for parts, and no effect where it is off.
//!
//! Bounds: images with and without reuse are compared microlens by microlens, 864 in all, 384 unless the run is
//! thorough. Over independent seeds the differences of the means, divided by their standard errors, are distributed about
//! like Student's t with 62 degrees of freedom: 0.39 % lie beyond 3, five in a million beyond 5. The sums over
//! the microlenses of an image are about normal: six in 100,000 lie beyond 4. Seeds are fixed, so the result is deterministic.

use std::num::NonZeroUsize;
use std::path::Path;

use crate::common::{is_thorough, rig};
use holo_core::{LightFieldOwned, Projection, Rig, ViewIndex};
use holo_io::Limits;
use holo_render::{Backend, Integrator, Renderer, Request, Reuse, Views};
use holo_scene::{Alpha, Environment, Instance, Light, LightKind, Material, Mesh, Scene, Transform, gallery, gltf};

const SEEDS: u64 = 32;

/// 8 x 8 views of 6 x 4 pixels, which move by a few hundredths of a pixel from view to view.
fn small_rig(focus_m: f64) -> Rig {
    rig([8, 8], [4, 6], 4e-4, focus_m, Projection::Perspective)
}

fn square(z: f32, half: f32, material: usize) -> Mesh {
    Mesh {
        positions: vec![[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}

/// A diffuse wall lit by a sun with a disc, behind a mask with holes and beside a mirror and an emissive patch.
fn corner() -> Scene {
    let materials = vec![
        Material { base_color: [0.6, 0.5, 0.4, 1.0], ..Material::default() },
        Material { base_color: [0.5, 0.5, 0.5, 0.3], alpha: Alpha::Mask(0.5), ..Material::default() },
        Material { metallic: 1.0, roughness: 0.3, specular: 1.0, ..Material::default() },
        Material { emission: [3.0, 2.0, 1.0], ..Material::default() },
    ];
    let mut meshes = vec![square(-1.0, 2.0, 0), square(-0.5, 0.1, 1), square(0.4, 0.3, 2), square(0.0, 0.0, 3)];
    meshes[3].positions = vec![[0.5, -0.2, -0.8], [0.5, 0.2, -0.8], [0.5, 0.2, -0.4], [0.5, -0.2, -0.4]];
    let instances = (0..4).map(|mesh| Instance { name: String::new(), mesh, transform: Transform::IDENTITY }).collect();
    let kind = LightKind::Directional { direction: [0.36, -0.48, -0.8], angular_diameter_rad: 0.3 };
    let lights = vec![Light { name: "sun".into(), intensity: [2.0, 1.9, 1.7], kind }];
    Scene { materials, meshes, instances, lights, ..Scene::default() }
}

/// Names, scenes, renderers, rigs and skies: every third scene of the gallery unless the run is thorough.
fn cases() -> Vec<(String, Renderer, Request)> {
    let mut scenes: Vec<(String, Scene, f64, f32)> = gallery::NAMES
        .iter()
        .step_by(if is_thorough() { 1 } else { 3 })
        .map(|&name| (name.into(), gallery::scene(name).expect("a scene of the gallery"), 0.6, 0.3))
        .collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join("radiance");
    let mut window = gltf::load(&folder.join("window.glb"), &Default::default()).expect("a scene").scene;
    let radiance = holo_io::read_hdr(folder.join("window_sky.hdr"), &Limits::default()).expect("a map");
    window.environment = Some(Environment { radiance });
    scenes.push(("window".into(), window, 0.8, 0.0));
    scenes.push(("corner".into(), corner(), 1.0, 0.2));
    let case = |(name, scene, focus_m, sky): (String, Scene, f64, f32)| {
        let pose = scene.cameras.first().map_or(Transform::IDENTITY, |camera| camera.pose);
        let renderer = Renderer::new(&scene, &pose, Backend::Auto, None).expect("a renderer");
        (name, renderer, Request::new(small_rig(focus_m)).reuse(Reuse::Views).samples(4).max_bounces(3).sky([sky; 3]))
    };
    scenes.into_iter().map(case).collect()
}

fn color(renderer: &Renderer, request: &Request) -> LightFieldOwned<f32> {
    renderer.render(request, &()).expect("a render").color.expect("an image")
}

/// The mean luminance behind every microlens.
fn lens_means(color: &LightFieldOwned<f32>) -> Vec<f64> {
    let samples = color.samples();
    let [rows, columns] = [color.shape().lenses().rows, color.shape().lenses().columns];
    let mut means = Vec::new();
    for v in 0..rows {
        for u in 0..columns {
            let lens = samples.slice(ndarray::s![v, u, .., .., ..]);
            means.push(lens.iter().map(|&x| f64::from(x)).sum::<f64>() / lens.len() as f64);
        }
    }
    means
}

/// Mean and squared standard error of every microlens over the seeds.
fn statistics(renderer: &Renderer, request: &Request, first_seed: u64) -> Vec<[f64; 2]> {
    let images: Vec<Vec<f64>> =
        (0..SEEDS).map(|seed| lens_means(&color(renderer, &request.clone().seed(first_seed + seed)))).collect();
    (0..images[0].len())
        .map(|k| {
            let mean = images.iter().map(|image| image[k]).sum::<f64>() / SEEDS as f64;
            let squares = images.iter().map(|image| (image[k] - mean).powi(2)).sum::<f64>();
            [mean, squares / (SEEDS * (SEEDS - 1)) as f64]
        })
        .collect()
}

#[test]
fn sharing_light_is_unbiased() {
    let (mut all, mut beyond_three, mut shared, mut images) = (0, 0, 0, 0);
    for (name, renderer, request) in cases() {
        for integrator in [Integrator::Direct, Integrator::Path] {
            let request = request.clone().integrator(integrator);
            let own = statistics(&renderer, &request.clone().reuse(Reuse::Off), 100);
            let reused = statistics(&renderer, &request, 900);
            // The same random numbers, so that nothing but sharing differs.
            let image = |reuse| color(&renderer, &request.clone().reuse(reuse));
            shared += usize::from(image(Reuse::Off).samples() != image(Reuse::Views).samples());
            images += 1;
            let mut sum = 0.0;
            for (lens, ([a, a_squared], [b, b_squared])) in own.iter().zip(&reused).enumerate() {
                let error = (a_squared + b_squared).sqrt();
                let deviation = if error > 0.0 { (b - a) / error } else { 0.0 };
                assert!(deviation.abs() < 5.0, "{name}, {integrator:?}, lens {lens}: {a} {b} +- {error}");
                all += 1;
                beyond_three += usize::from(deviation.abs() > 3.0);
                sum += deviation;
            }
            // Independent lenses: the sum of their deviations is normal.
            let together = sum / (own.len() as f64).sqrt();
            assert!(together.abs() < 4.0, "{name}, {integrator:?}: {together} standard errors together");
        }
    }
    assert!(shared * 5 > images * 3, "{shared} of {images}");
    // Of 864 three are expected, and more than eight come by chance once in 100; of 384 one or two, and more than three once
    // in 15.
    assert!(beyond_three * 100 < all, "{beyond_three} of {all} beyond three standard errors");
}

/// On a matt wall below a sky the variance of a pixel falls to a fifth or less, and that of the mean of 4 x 4 views does not
/// grow by more than a third.
#[test]
fn there_is_less_noise_in_every_view() {
    let mut scene = corner();
    scene.lights.clear();
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a renderer");
    let request = Request::new(small_rig(1.0)).samples(4).max_bounces(2).sky([0.5; 3]);
    for integrator in [Integrator::Direct, Integrator::Path] {
        let request = request.clone().integrator(integrator);
        let [own, reused] = [Reuse::Off, Reuse::Views].map(|reuse| {
            let images: Vec<_> =
                (0..24).map(|seed| color(&renderer, &request.clone().reuse(reuse).seed(seed))).collect();
            let (mut single, mut mean) = (0.0, 0.0);
            for v in 0..4 {
                for u in 0..6 {
                    let pixel = |k: usize, t: usize, s: usize| f64::from(images[k].samples()[[v, u, t, s, 1]]);
                    single += variance((0..images.len()).map(|k| pixel(k, 1, 2)));
                    mean += variance(
                        (0..images.len()).map(|k| (0..16).map(|n| pixel(k, n / 4, n % 4)).sum::<f64>() / 16.0),
                    );
                }
            }
            [single, mean]
        });
        assert!(reused[0] < own[0] / 5.0, "{integrator:?}: {own:?} {reused:?}");
        assert!(reused[1] < own[1] * 1.34, "{integrator:?}: {own:?} {reused:?}");
    }
}

fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0)
}

/// The correlation of the noise of views that are a number of columns apart, at the same pixel: of the difference of two
/// seeds, which contains no scene.
fn correlation(renderer: &Renderer, request: &Request, apart: usize) -> f64 {
    let [one, other] = [1, 2].map(|seed| color(renderer, &request.clone().seed(seed)));
    let noise = &one.samples() - &other.samples();
    let views = noise.dim().3 - apart;
    let [left, right] = [0, apart].map(|from| noise.slice(ndarray::s![.., .., .., from..from + views, ..]));
    let product = |a: ndarray::ArrayView5<f32>, b: ndarray::ArrayView5<f32>| -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    };
    product(left, right) / (product(left, left) * product(right, right)).sqrt()
}

/// What matches views must find nothing in the noise of a default render; light that views share stands still.
#[test]
fn the_noise_of_neighboring_views_tells_nothing() {
    let scene = gallery::scene("plaster").expect("a scene of the gallery");
    let renderer = Renderer::new(&scene, &scene.cameras[0].pose, Backend::Auto, None).expect("a renderer");
    let request = Request::new(rig([9, 9], [24, 24], 4e-4, 0.6, Projection::Perspective));
    let request = request.integrator(Integrator::Path).samples(4).max_bounces(8);
    for apart in [1, 2] {
        let [own, shared] =
            [Reuse::default(), Reuse::Views].map(|reuse| correlation(&renderer, &request.clone().reuse(reuse), apart));
        println!("{apart} apart: {own:.3} by default, {shared:.3} where light is shared");
        // Neighbors share no sample, but complete one sequence of points: a little is left, below 0.
        assert!(own.abs() <= 0.05 && shared > own + 0.05, "{apart} apart: {own}, {shared}");
    }
}

/// Parts of a light field and any number of threads have the bytes of the whole; views alone those without reuse.
#[test]
fn parts_have_the_bytes_of_the_whole() {
    let scene = gallery::scene("plaster").expect("a scene of the gallery");
    let [one, many] = [1, 3].map(|threads| {
        Renderer::new(&scene, &scene.cameras[0].pose, Backend::Auto, NonZeroUsize::new(threads)).expect("a renderer")
    });
    let request = Request::new(rig([8, 8], [8, 6], 4e-4, 0.6, Projection::Perspective));
    let request = request.reuse(Reuse::Views).integrator(Integrator::Path).samples(5).max_bounces(3);
    let whole = color(&one, &request);
    assert_eq!(color(&many, &request).samples(), whole.samples());
    let rows = one.shard_rows(&request, 1, 2).expect("a shard");
    let part = color(&many, &request.clone().rows(Some(rows.clone())));
    assert_eq!(part.samples(), whole.samples().slice(ndarray::s![rows, .., .., .., ..]));
    let [off, on] =
        [Reuse::Off, Reuse::Views].map(|reuse| one.render(&request.clone().reuse(reuse), &()).expect("a render"));
    assert_eq!((on.samples, on.rays.primary), (off.samples, off.rays.primary), "a sample is a camera ray");
    let off = off.color.expect("an image");
    assert_ne!(off.samples(), whole.samples());
    let view = color(&one, &request.views(Views::List(vec![ViewIndex { row: 2, column: 5 }])));
    assert_eq!(view.view(0, 0).expect("a view"), off.view(2, 5).expect("a view"));
}
