//! The kernels under every instruction set, and stopping.

use std::sync::atomic::{AtomicU32, Ordering};

use holo_core::{Intrinsics, Projection, RigParameters};
use ndarray::Array5;

use super::*;
use holo_scene::gallery;
use holo_scene::{Alpha, Environment, Material};

fn garden() -> (Renderer, Request) {
    let scene = gallery::scene("garden").expect("a scene of the gallery");
    let renderer = Renderer::new(&scene, &scene.cameras[0].pose, Backend::Bvh, 1).expect("a renderer");
    let rig = Rig::new(RigParameters {
        split: Split::new(GridSize::new(5, 6), GridSize::new(1, 60)).expect("sizes"),
        intrinsics: Intrinsics { focal_length_m: 0.04, sensor_size_m: 0.036 },
        baseline_x_m: 0.002,
        baseline_y_m: 0.002,
        focus_distance_m: 0.9,
        projection: Projection::Perspective,
    })
    .expect("a rig");
    let sky = [0.3, 0.4, 0.5];
    let ground_truth = GroundTruth::Central;
    (renderer, Request { integrator: Integrator::Direct, samples: 2, seed: 3, sky, ground_truth, ..Request::new(rig) })
}

/// The whole chain - rays, refinement, shading, random numbers, sky, layers - gives the same bits without vectors, with
/// AVX2 and with AVX-512, wherever the machine has them.
#[test]
fn every_instruction_set_gives_the_same_picture() {
    let (_, request) = garden();
    let mut scene = gallery::scene("garden").expect("a scene of the gallery");
    let pose = scene.cameras[0].pose;
    // A little of everything.
    for (k, material) in scene.materials.iter_mut().enumerate() {
        let some = (k % 3) as f32 * 0.4;
        *material = Material {
            metallic: some,
            roughness: 0.2 + some,
            specular: 1.0,
            transmission: 0.3,
            emission: [0.05, 0.1, 0.2],
            alpha: Alpha::Blend,
            base_color: [0.8, 0.7, 0.6, 0.9],
            ..material.clone()
        };
    }
    let radiance = ndarray::Array3::from_shape_fn((8, 16, 3), |(v, u, c)| (v * u + c) as f32 * 0.01);
    scene.environment = Some(Environment { radiance });
    let renderer = Renderer::new(&scene, &pose, Backend::Bvh, 1).expect("a renderer");
    let stop = Stop::new(&());
    let tiling = Tiling::new([1, 60, 5, 6]);
    let context = renderer.context(&request, Integrator::Path, &tiling, &stop);
    let [tile] = tiling.tiles()[..] else { panic!("one tile is enough for this rig") };
    // Every kernel writes into a picture of its own.
    let mut pictures: Vec<Array5<f32>> = vec![Array5::zeros((1, 60, 5, 6, 3)); 3];
    let mut parts = pictures.iter_mut();
    let counts = dispatch::run_on_all(|| {
        let color = parts.next().expect("three sets at most").view_mut();
        PathTile { context: &context, tile: &tile, color }
    });
    assert!(pictures[0].iter().any(|x| *x > 0.0) && counts[0].other > 0);
    for set in 0..counts.len() {
        assert_eq!(counts[set], counts[0]);
        assert!(pictures[set].iter().zip(&pictures[0]).all(|(a, b)| a.to_bits() == b.to_bits()), "set {set}");
    }

    let mut truths: Vec<_> = (0..3).map(|_| light_fields(*request.rig.split(), LayerSet::ALL).expect("room")).collect();
    let mut parts = truths.iter_mut();
    let sets = dispatch::run_on_all(|| {
        let out = tiles(parts.next().expect("three sets at most"), &tiling).pop().expect("a tile");
        DepthTile { context: &context, tile: &tile, out }
    });
    for set in 0..sets.len() {
        for (layer, field) in truths[set].iter() {
            let same = field.samples().iter().zip(truths[0][layer].samples()).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same && field.samples().iter().any(|x| *x != 0.0), "{layer} of set {set}");
        }
    }
}

/// How the picture is cut into tiles is nobody's business: the same bytes, though paths are sorted within a tile.
#[test]
fn the_size_of_tiles_changes_nothing() {
    let scene = gallery::scene("garden").expect("a scene of the gallery");
    let renderer = Renderer::new(&scene, &scene.cameras[0].pose, Backend::Bvh, 1).expect("a renderer");
    let (_, request) = garden();
    let split = Split::new(GridSize::new(5, 6), GridSize::new(7, 30)).expect("sizes");
    let rig = Rig::new(RigParameters { split, ..*request.rig.parameters() }).expect("a rig");
    let picture = |integrator: Integrator, pixels: usize| {
        let request = Request { rig, integrator, samples: 4, ..request.clone() };
        let (stop, tiling) = (Stop::new(&()), Tiling::with_tiles_of([7, 30, 5, 6], pixels));
        let context = renderer.context(&request, integrator, &tiling, &stop);
        let (mut color, mut truth) =
            (zeros(split, 3).expect("room"), light_fields(split, LayerSet::ALL).expect("room"));
        for (tile, color) in tiling.tiles().iter().zip(tiling.cut(color.samples_mut())) {
            dispatch::run(PathTile { context: &context, tile, color });
        }
        for (tile, out) in tiling.tiles().iter().zip(tiles(&mut truth, &tiling)) {
            dispatch::run(DepthTile { context: &context, tile, out });
        }
        (color, truth, tiling.tiles().len())
    };
    for integrator in [Integrator::Direct, Integrator::Path] {
        let (color, truth, _) = picture(integrator, 100_000);
        assert!(color.samples().iter().any(|x| *x > 0.0));
        let mut counts = Vec::new();
        for pixels in [40, 300, 2048] {
            let (other, other_truth, count) = picture(integrator, pixels);
            counts.push(count);
            assert_eq!(truth, other_truth, "{pixels}");
            let bits = color.samples().iter().zip(other.samples()).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            assert_eq!(bits, 0, "{integrator:?}, tiles of {pixels}");
        }
        assert!(counts[0] > counts[1] && counts[1] > counts[2], "{counts:?}");
    }
}

/// Numbers that f32 cannot hold are refused for the layers that hold them, and only for those.
#[test]
fn more_instances_than_f32_can_number_are_refused() {
    let (mut renderer, request) = garden();
    renderer.counts = [MOST_NUMBERED, MOST_NUMBERED];
    let ask = |layers| Request { layers, ..request.clone() };
    assert!(renderer.choose(&ask(LayerSet::ALL)).is_ok());
    renderer.counts = [MOST_NUMBERED + 1, MOST_NUMBERED];
    let refused = renderer.choose(&ask(LayerSet::ALL)).unwrap_err().to_string();
    assert!(refused.contains("object-id") && refused.contains("16777217"), "{refused}");
    assert!(renderer.choose(&ask(LayerSet::ALL.without([Layer::ObjectId].into()))).is_ok());
}

/// A caller that says stop once and then forgets it does not get a picture with holes.
#[test]
fn a_stop_is_remembered() {
    struct Once(AtomicU32);
    impl Progress for Once {
        fn cancelled(&self) -> bool {
            self.0.fetch_add(1, Ordering::SeqCst) == 3
        }
    }
    let (renderer, request) = garden();
    assert!(matches!(renderer.render(&request, &Once(AtomicU32::new(0))), Err(Error::Cancelled)));
}

#[test]
fn progress_reaches_its_total() {
    struct Last(std::sync::Mutex<Vec<(u64, u64)>>);
    impl Progress for Last {
        fn advance(&self, done: u64, total: u64) {
            self.0.lock().expect("no other test").push((done, total));
        }
    }
    let (renderer, request) = garden();
    for (integrator, ground_truth) in [
        (Integrator::Depth, GroundTruth::Central),
        (Integrator::Direct, GroundTruth::All),
        (Integrator::Depth, GroundTruth::All),
    ] {
        let seen = Last(Vec::new().into());
        renderer.render(&Request { integrator, ground_truth, ..request.clone() }, &seen).expect("a render");
        let steps = seen.0.into_inner().expect("no other test");
        let last = *steps.last().expect("some progress");
        assert_eq!(last.0, last.1, "{integrator:?} {ground_truth:?}");
    }
}

#[test]
fn poses_that_are_no_camera_are_errors() {
    let scene = gallery::scene("garden").expect("a scene of the gallery");
    let mut scaled = Transform::IDENTITY;
    scaled.columns[0][0] = 2.0;
    for pose in [scaled, Transform::from_translation([f64::NAN, 0.0, 0.0])] {
        assert!(matches!(Renderer::new(&scene, &pose, Backend::Bvh, 1), Err(Error::BadSetting(_))));
    }
}

/// Sixteen samples of a pixel visit each sixteenth of it once, at the same points in all views of a block; other lenses
/// and other blocks have points of their own.
#[test]
fn the_views_of_a_block_share_the_points_of_the_pixel() {
    let (renderer, request) = garden();
    let stop = Stop::new(&());
    let tiling = Tiling::new([1, 60, 8, 8]);
    let context = renderer.context(&request, request.integrator, &tiling, &stop);
    let points = |block, sample| {
        let [x, y] = context.points(&context.tables.pixels(block), sample);
        assert!(x.iter().all(|a| *a == x[0]) && y.iter().all(|a| *a == y[0]), "{x:?} {y:?}");
        [x[0], y[0]]
    };
    let mut visited = std::collections::BTreeSet::new();
    for sample in 0..16 {
        let here = points([0, 7, 0, 0], sample);
        for elsewhere in [[0, 8, 0, 0], [0, 7, 1, 0], [0, 7, 0, 1]] {
            assert_ne!(here, points(elsewhere, sample));
        }
        visited.insert(here.map(|p| (p * 4.0) as u32));
    }
    assert_eq!(visited.len(), 16, "{visited:?}");
}
