//! What the integrators estimate: the mean over many seeds is the truth within its standard error, and the variance falls at
//! least as fast as the number of samples grows.
//!
//! Bounds: the mean luminance of a picture over 64 seeds lies within 3 standard errors of a reference of many more samples
//! (its own error counted in). Seeds are fixed, so a test that passes passes always. What is tested is sums of independent
//! pictures: normal to good approximation, and 3 standard errors are left by chance once in 370 cases.

mod common;

use common::rig;
use holo_core::{Projection, Rig};
use holo_render::scene::Scene;
use holo_render::{Backend, Integrator, Renderer, Request, gallery};

const SEEDS: u64 = 64;

/// A scene as its camera sees it in few pixels.
struct Case {
    name: &'static str,
    renderer: Renderer,
    rig: Rig,
    sky: [f32; 3],
}

impl Case {
    /// Scenes with every kind of light: glowing rooms and windows, punctual lights, a sky, glass and gloss between.
    fn all() -> Vec<Self> {
        [("plaster", 0.0), ("chess", 0.0), ("glasses", 0.0), ("garden", 0.5), ("lanterns", 0.0)]
            .map(|(name, sky)| {
                let scene: Scene = gallery::scene(name).expect("a scene of the gallery");
                let pose = scene.cameras[0].pose;
                let renderer = Renderer::new(&scene, &pose, Backend::Auto, 0).expect("a scene");
                let rig = rig([2, 2], [6, 9], 1e-3, 0.6, Projection::Perspective);
                Self { name, renderer, rig, sky: [sky; 3] }
            })
            .into()
    }

    /// The mean luminance of a picture.
    fn mean(&self, integrator: Integrator, samples: u32, seed: u64) -> f64 {
        let request = Request { integrator, samples, seed, sky: self.sky, max_bounces: 4, ..Request::new(self.rig) };
        let color = self.renderer.render(&request, &()).expect("a render").color.expect("a picture");
        let values = color.samples();
        let sum: f64 = values.iter().zip([0.2126, 0.7152, 0.0722].iter().cycle()).map(|(&x, w)| f64::from(x) * w).sum();
        assert!(sum.is_finite(), "{}", self.name);
        sum * 3.0 / values.len() as f64
    }

    /// Mean and variance over seeds of pictures of `samples` each.
    fn statistics(&self, integrator: Integrator, samples: u32) -> (f64, f64) {
        let means: Vec<f64> = (0..SEEDS).map(|seed| self.mean(integrator, samples, 1000 + seed)).collect();
        let mean = means.iter().sum::<f64>() / SEEDS as f64;
        let squares: f64 = means.iter().map(|x| (x - mean).powi(2)).sum();
        (mean, squares / (SEEDS - 1) as f64)
    }
}

#[test]
fn the_mean_over_seeds_is_the_truth_and_the_variance_falls() {
    for case in Case::all() {
        for integrator in [Integrator::Direct, Integrator::Path] {
            let (mean, variance) = case.statistics(integrator, 4);
            let (finer, finer_variance) = case.statistics(integrator, 16);
            // Four times as many samples as all seeds of the finer pictures together, in four pictures: their spread is the error.
            let references: Vec<f64> = (0..4).map(|seed| case.mean(integrator, 1024, seed)).collect();
            let reference = references.iter().sum::<f64>() / 4.0;
            let spread = references.iter().map(|x| (x - reference).powi(2)).sum::<f64>() / 12.0;
            for (mean, variance) in [(mean, variance), (finer, finer_variance)] {
                let error = (variance / SEEDS as f64 + spread).sqrt();
                let off = (mean - reference) / error;
                assert!(off.abs() < 3.0, "{} {integrator:?}: {mean} for {reference}, {off} errors", case.name);
            }
            // Independent samples would make it a quarter; Sobol points do better. 64 seeds know a variance to 18 %, a ratio
            // to 25 %: a third allows for it.
            assert!(
                finer_variance < variance / 3.0,
                "{} {integrator:?}: {variance} with 4 samples, {finer_variance} with 16",
                case.name
            );
        }
    }
}
