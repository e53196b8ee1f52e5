//! Adaptive sampling: a target error instead of a number of samples.

use crate::common;
use crate::common::rig;
use holo_core::Projection;
use holo_render::{Backend, Integrator, Rendered, Request};
use holo_scene::{Light, LightKind};

/// Colored triangles under a small bright light and a sky: pixels of low and of high variance.
fn image(samples: u32, target_error: Option<f64>, seed: u64) -> Rendered {
    let mut scene = common::soup(60, 5);
    let kind = LightKind::Point { position: [1.0, 2.0, 0.5], range: None };
    scene.lights.push(Light { name: String::new(), intensity: [6.0; 3], kind });
    let request = Request::new(rig([6, 6], [10, 16], 0.02, 3.0, Projection::Perspective))
        .integrator(Integrator::Path)
        .samples(samples)
        .target_error(target_error)
        .seed(seed)
        .sky([0.3, 0.4, 0.5])
        .max_bounces(3);
    common::render(&scene, &request, Backend::Auto, 0)
}

fn mean(rendered: &Rendered) -> f64 {
    let samples = rendered.color.as_ref().expect("an image").samples();
    samples.iter().map(|&x| f64::from(x)).sum::<f64>() / samples.len() as f64
}

/// The average error is the requested one, pixels of low variance take fewer samples, and the bias of early stopping is
/// below 0.2 %: the mean of 16 images against a reference of many samples.
#[test]
fn pixels_stop_at_the_target_error() {
    let exact = image(4096, None, 99);
    let reference = mean(&exact);
    let target = 0.05;
    let (mut sum, mut within, mut all) = (0.0, 0, 0);
    for seed in 0..16 {
        let stopped = image(1024, Some(target), seed);
        let most = 36 * 160 * 1024;
        assert!(stopped.samples >= 36 * 160 * 16 && stopped.samples < most / 4, "{} of {most}", stopped.samples);
        sum += mean(&stopped) / 16.0;
        let exact = exact.color.as_ref().expect("an image").samples();
        let got = stopped.color.as_ref().expect("an image").samples();
        let luminance = |p: &[f32]| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
        for (a, b) in got.rows().into_iter().zip(exact.rows()) {
            let [a, b] = [a, b].map(|p| luminance(&[p[0], p[1], p[2]]));
            within += usize::from((a - b).abs() <= target as f32 * b);
            all += 1;
        }
    }
    assert!((sum / reference - 1.0).abs() < 2e-3, "{sum} {reference}");
    // 68 % of a normal distribution is within one standard error; the estimate here is an upper bound.
    assert!(within as f64 > 0.75 * all as f64, "{within} of {all}");
}

#[test]
fn without_a_target_every_pixel_gets_its_samples() {
    assert_eq!(image(5, None, 0).samples, 36 * 160 * 5);
    // Fewer samples than the first estimate needs: all of them are taken.
    assert_eq!(image(8, Some(0.5), 0).samples, 36 * 160 * 8);
}

/// An emissive thread covers 1.2 % of a row of pixels in the dark. Most of the first samples are black, but the mean of
/// the row is right.
#[test]
fn faint_edges_in_the_dark_are_not_cut_off() {
    let mut scene = holo_scene::Scene::default();
    // 16 pixels are 36 mm behind 50 mm: a pixel is 0.135 m wide 3 m away; the thread lies inside the ninth row.
    let (pixel, top) = (3.0 * 0.036 / 0.05 / 16.0, -0.04f32);
    let mut mesh = common::square(1.0);
    mesh.positions = [[-1.0, top], [1.0, top], [1.0, top + 0.012 * pixel as f32], [-1.0, top + 0.012 * pixel as f32]]
        .map(|[x, y]| [x, y, -3.0])
        .to_vec();
    common::add(&mut scene, mesh, [0.0, 0.0, 0.0, 1.0], holo_scene::Transform::IDENTITY);
    let material = scene.materials.last_mut().expect("that of the thread");
    (material.emission, material.double_sided) = ([1.0; 3], true);
    let row = |target_error| {
        let request = Request::new(rig([1, 1], [16, 16], 0.0, 3.0, Projection::Perspective))
            .integrator(Integrator::Direct)
            .samples(2048)
            .target_error(target_error);
        let image = common::render(&scene, &request, Backend::Bvh, 1).color.expect("an image");
        let view = image.view(0, 0).expect("the only one");
        (2..14).map(|u| f64::from(view[[8, u, 0]])).sum::<f64>() / 12.0
    };
    let (all, stopped) = (row(None), row(Some(0.05)));
    assert!((all - 0.012).abs() < 1e-3, "{all}");
    assert!((stopped / all - 1.0).abs() < 0.05, "{stopped} instead of {all}");
}
