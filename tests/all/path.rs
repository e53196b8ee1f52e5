//! Path tracing: the same bytes for any number of threads, the same image with both backends.

use std::num::NonZeroUsize;
use std::path::Path;

use crate::common::engines;
use holo_core::{GridSize, LightFieldShape};
use holo_io::Limits;
use holo_render::{Backend, Baseline, Framing, Integrator, Rendered, Renderer, Request};
use holo_scene::{Environment, Scene};

/// The two scenes of `tests/radiance`: all materials, all lights.
fn scenes() -> [(Scene, [f32; 3]); 2] {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join("radiance");
    let load = |name: &str| holo_scene::gltf::load(&folder.join(name), &Default::default()).expect("a scene").scene;
    let mut window = load("window.glb");
    let radiance = holo_io::read_hdr(folder.join("window_sky.hdr"), &Limits::default()).expect("a map");
    window.environment = Some(Environment { radiance });
    [(load("metal_and_glass.glb"), [0.2, 0.24, 0.32]), (window, [0.0; 3])]
}

/// 6 x 5 views: packets with lanes to spare.
fn render(scene: &Scene, sky: [f32; 3], backend: Backend, threads: usize, change: fn(&mut Request)) -> Rendered {
    let framing = Framing::new(LightFieldShape::new(GridSize::new(5, 6), GridSize::new(22, 33)).unwrap())
        .baseline(Baseline::Meters(0.005));
    let framed = framing.frame(scene).unwrap();
    let mut request = Request::new(framed.rig(3.0).unwrap()).integrator(Integrator::Path).sky(sky);
    change(&mut request);
    Renderer::new(scene, &framed.pose, backend, NonZeroUsize::new(threads))
        .unwrap()
        .render(&request, &())
        .expect("a render")
}

#[test]
fn the_image_does_not_depend_on_threads() {
    let changes: [fn(&mut Request); 3] = [
        |request| request.transport.samples = 1.into(),
        |request| (request.transport.samples, request.transport.seed) = (5.into(), 7),
        |request| {
            (request.transport.samples, request.transport.target_error, request.transport.roulette) =
                (32.into(), Some(0.1), false)
        },
    ];
    for (scene, sky) in scenes() {
        for backend in engines() {
            for change in changes {
                let one = render(&scene, sky, backend, 1, change);
                for threads in [2, 3] {
                    let other = render(&scene, sky, backend, threads, change);
                    assert_eq!(one.color, other.color, "{backend:?} {threads} threads");
                    assert_eq!((one.rays, one.samples), (other.rays, other.samples));
                }
            }
        }
    }
}

/// Both backends hit the same triangles, but their barycentrics differ in the last bits. A path at an edge, or at a
/// random choice within those bits, diverges. The random numbers are the same, so pixels whose paths do not diverge
/// differ by rounding: half of them by less than 1e-6, all but 2 % by less than 1e-4. Diverging paths add no bias: the
/// mean agrees.
#[test]
fn both_backends_have_the_same_radiance() {
    let [first, second] = engines()[..] else {
        return; // `engines` reports what is missing.
    };
    for (scene, sky) in scenes() {
        let [a, b] = [first, second].map(|backend| {
            let rendered = render(&scene, sky, backend, 2, |request| request.transport.samples = 16.into());
            rendered.color.expect("an image").to_elemental_grid().unwrap()
        });
        let mut differences: Vec<f64> = a
            .iter()
            .zip(&b)
            .map(|(&a, &b)| (f64::from(a) - f64::from(b)).abs() / (f64::from(a.max(b)) + 1e-3))
            .collect();
        differences.sort_by(f64::total_cmp);
        let quantile = |q: f64| differences[(q * (differences.len() - 1) as f64) as usize];
        let mean = |x: &ndarray::Array3<f32>| x.iter().map(|&x| f64::from(x)).sum::<f64>() / x.len() as f64;
        let ratio = mean(&a) / mean(&b);
        println!("median {:.1e}, 98 % {:.1e}, mean {ratio:.6}", quantile(0.5), quantile(0.98));
        assert!(quantile(0.5) < 1e-6, "median {}", quantile(0.5));
        assert!(quantile(0.98) < 1e-4, "98 % {}", quantile(0.98));
        assert!((ratio - 1.0).abs() < 1e-3, "mean {ratio}");
    }
}
