//! The kernels on every instruction set, tiles, cancellation, and lists of views.

use std::sync::atomic::{AtomicU32, Ordering};

use holo_core::{GridSize, LightFieldShape, Rig, ViewIndex};
use ndarray::Array5;

use super::check::MAX_EXACT_ID;
use super::color::zeros;
use super::image::{light_fields, tiles};
use super::*;
use crate::camera::tile::{Selection, Tiling};
use crate::film::layers::Layer;
use crate::integrator::aov::TileAovs;
use crate::integrator::depth::DepthTile;
use crate::integrator::path::{PathTile, Round, Scratch};
use crate::sampling::Sampling;
use crate::simd::{self, LANES};
use holo_scene::gallery;
use holo_scene::{Alpha, Anisotropy, Clearcoat, DiffuseTransmission, Environment, Iridescence, Material, Sheen};

fn garden() -> (Renderer, Request) {
    let scene = gallery::scene("garden").expect("a scene of the gallery");
    let renderer =
        Renderer::new(&scene, &scene.cameras[0].pose, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    let rig = Rig::builder(LightFieldShape::new(GridSize::new(5, 6), GridSize::new(1, 60)).expect("sizes"))
        .focal_length_m(0.04)
        .sensor_size_m(0.036)
        .baseline_m(0.002)
        .focus_distance_m(0.9)
        .build()
        .expect("a rig");
    let sky = [0.3, 0.4, 0.5];
    let ground_truth = GroundTruth::Central;
    (renderer, Request::new(rig).integrator(Integrator::Direct).samples(2).seed(3).sky(sky).ground_truth(ground_truth))
}

fn region(split: &LightFieldShape, pixels: usize) -> Region {
    let selection = Selection::whole(split);
    Region { tiling: Tiling::with_tiles_of(selection.counts(), pixels), selection }
}

/// The whole pipeline (rays, refinement, shading, random numbers, sky, layers) is bitwise identical without vector
/// instructions, with AVX2 and with AVX-512, as far as the machine supports them.
#[test]
fn every_instruction_set_gives_the_same_image() {
    let (_, request) = garden();
    let mut scene = gallery::scene("garden").expect("a scene of the gallery");
    let pose = scene.cameras[0].pose;
    // Materials with all features.
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
        if k % 4 == 1 {
            material.clearcoat = Some(Clearcoat { factor: 0.6, roughness: 0.3, ..Clearcoat::default() });
            material.sheen = Some(Sheen { color: [0.4; 3], roughness: 0.5, ..Sheen::default() });
            material.anisotropy = Some(Anisotropy { strength: 0.7, ..Anisotropy::default() });
            material.iridescence = Some(Iridescence { factor: 0.8, ..Iridescence::default() });
            material.diffuse_transmission = Some(DiffuseTransmission { factor: 0.3, ..DiffuseTransmission::default() });
        }
    }
    let radiance = ndarray::Array3::from_shape_fn((8, 16, 3), |(v, u, c)| (v * u + c) as f32 * 0.01);
    scene.environment = Some(Environment { radiance });
    let renderer = Renderer::new(&scene, &pose, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    let stop = Stop::new(&());
    let region = region(request.camera.rig().expect("a rig").shape(), 10_000);
    let context = renderer.context(&request.of_rig().expect("a rig"), Integrator::Path, &region, &stop);
    let tiling = &region.tiling;
    let [tile] = tiling.tiles()[..] else { panic!("one tile is enough for this rig") };
    // Every kernel writes into an image of its own.
    let mut images: Vec<Array5<f32>> = vec![Array5::zeros((1, 60, 5, 6, 3)); 3];
    let mut outputs = images.iter_mut();
    let mut memory: [Scratch; 3] = Default::default();
    let mut scratches = memory.iter_mut();
    let round = Round::whole(context.sampler.samples.into());
    let counts = simd::run_on_all(|| {
        let color = outputs.next().expect("three sets at most").view_mut();
        PathTile {
            context: &context,
            tile: &tile,
            color,
            guides: None,
            inverse_depths: None,
            round: &round,
            wanted: &[],
            scratch: scratches.next().expect("three sets at most"),
        }
    });
    assert!(images[0].iter().any(|x| *x > 0.0) && counts[0].secondary > 0);
    for set in 0..counts.len() {
        assert_eq!(counts[set], counts[0]);
        assert!(images[set].iter().zip(&images[0]).all(|(a, b)| a.to_bits() == b.to_bits()), "set {set}");
    }

    let mut layers_of_sets: Vec<_> = (0..3)
        .map(|_| light_fields(*request.camera.rig().expect("a rig").shape(), LayerSet::ALL).expect("room"))
        .collect();
    let mut outputs = layers_of_sets.iter_mut();
    let mut aov_memory: [TileAovs; 3] = Default::default();
    let mut aov_buffers = aov_memory.iter_mut();
    let sets = simd::run_on_all(|| {
        let out = tiles(outputs.next().expect("three sets at most"), tiling).pop().expect("a tile");
        DepthTile { context: &context, tile: &tile, out, aov: aov_buffers.next().expect("three sets at most") }
    });
    for set in 0..sets.len() {
        for (layer, field) in layers_of_sets[set].iter() {
            let same =
                field.samples().iter().zip(layers_of_sets[0][layer].samples()).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same && field.samples().iter().any(|x| *x != 0.0), "{layer} of set {set}");
        }
    }
}

/// The size of tiles does not change the image, although paths are sorted within a tile.
#[test]
fn the_size_of_tiles_changes_nothing() {
    let scene = gallery::scene("garden").expect("a scene of the gallery");
    let renderer =
        Renderer::new(&scene, &scene.cameras[0].pose, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    let (_, request) = garden();
    let split = LightFieldShape::new(GridSize::new(5, 6), GridSize::new(7, 30)).expect("sizes");
    let rig = request.camera.rig().expect("a rig").to_builder().shape(split).build().expect("a rig");
    let render_with = |integrator: Integrator, pixels: usize| {
        let request = request.clone().camera(rig).integrator(integrator).samples(4);
        let (stop, region) = (Stop::new(&()), region(&split, pixels));
        let context = renderer.context(&request.of_rig().expect("a rig"), integrator, &region, &stop);
        let tiling = &region.tiling;
        let (mut color, mut aov) = (zeros(split, 3).expect("room"), light_fields(split, LayerSet::ALL).expect("room"));
        let (mut scratch, mut buffer) = (Scratch::default(), TileAovs::default());
        let round = Round::whole(context.sampler.samples.into());
        for (tile, color) in tiling.tiles().iter().zip(tiling.cut(color.samples_mut())) {
            simd::run(PathTile {
                context: &context,
                tile,
                color,
                guides: None,
                inverse_depths: None,
                round: &round,
                wanted: &[],
                scratch: &mut scratch,
            });
        }
        for (tile, out) in tiling.tiles().iter().zip(tiles(&mut aov, tiling)) {
            simd::run(DepthTile { context: &context, tile, out, aov: &mut buffer });
        }
        (color, aov, tiling.tiles().len())
    };
    for integrator in [Integrator::Direct, Integrator::Path] {
        let (color, aov, _) = render_with(integrator, 100_000);
        assert!(color.samples().iter().any(|x| *x > 0.0));
        let mut counts = Vec::new();
        for pixels in [40, 300, 2048] {
            let (other, other_layers, count) = render_with(integrator, pixels);
            counts.push(count);
            assert_eq!(aov, other_layers, "{pixels}");
            let bits = color.samples().iter().zip(other.samples()).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            assert_eq!(bits, 0, "{integrator:?}, tiles of {pixels}");
        }
        assert!(counts[0] > counts[1] && counts[1] > counts[2], "{counts:?}");
    }
}

/// Ids that f32 cannot represent are rejected, only for the layers that contain them.
#[test]
fn more_instances_than_f32_can_number_are_refused() {
    let (mut renderer, request) = garden();
    renderer.counts = [MAX_EXACT_ID, MAX_EXACT_ID];
    let with_layers = |layers| request.clone().layers(layers);
    assert!(renderer.choose(&with_layers(LayerSet::ALL)).is_ok());
    renderer.counts = [MAX_EXACT_ID + 1, MAX_EXACT_ID];
    let refused = renderer.choose(&with_layers(LayerSet::ALL)).unwrap_err().to_string();
    assert!(refused.contains("object-id") && refused.contains("16777217"), "{refused}");
    assert!(renderer.choose(&with_layers(LayerSet::ALL.without([Layer::ObjectId].into()))).is_ok());
}

/// A single `true` of `cancelled` cancels the render.
#[test]
fn a_cancellation_is_remembered() {
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
        renderer.render(&request.clone().integrator(integrator).ground_truth(ground_truth), &seen).expect("a render");
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
        assert!(matches!(Renderer::new(&scene, &pose, Backend::Bvh, NonZeroUsize::new(1)), Err(Error::BadSetting(_))));
    }
}

/// Sixteen samples of a pixel are stratified over its sixteenths, in every view and every microlens at positions of its
/// own; with shared positions, at the same in all views of a group.
#[test]
fn sixteen_samples_lie_in_the_sixteenths_of_the_pixel() {
    let (renderer, request) = garden();
    let stop = Stop::new(&());
    let split = LightFieldShape::new(GridSize::new(8, 8), GridSize::new(1, 60)).expect("sizes");
    let rig = request.camera.rig().expect("a rig").to_builder().shape(split).build().expect("a rig");
    let region = region(&split, 8192);
    for (sampling, places_in_a_group) in [(Sampling::OwnPositions, LANES), (Sampling::SharedPositions, 1)] {
        let request = request.clone().camera(rig).samples(16).sampling(sampling);
        let context = renderer.context(&request.of_rig().expect("a rig"), request.transport.integrator, &region, &stop);
        let tiles = region.tiling.tiles();
        let packets: Vec<_> = tiles.iter().flat_map(|tile| context.camera.packets(tile)).collect();
        let positions = |[_, u, t, s]: [usize; 4], sample| -> [[f32; 2]; LANES] {
            let [x, y] = context.sampler.pixel_positions(&packets[(u * 2 + t) * 2 + s].ids, sample);
            std::array::from_fn(|lane| [x[lane], y[lane]])
        };
        let different = |places: [[f32; 2]; LANES]| {
            places.map(|place| place.map(f32::to_bits)).into_iter().collect::<std::collections::BTreeSet<_>>().len()
        };
        let mut visited = [const { std::collections::BTreeSet::new() }; LANES];
        for sample in 0..16 {
            let here = positions([0, 7, 0, 0], sample);
            assert_eq!(different(here), places_in_a_group, "{sampling:?}");
            for elsewhere in [[0, 8, 0, 0], [0, 7, 1, 0], [0, 7, 0, 1]] {
                let there = positions(elsewhere, sample);
                assert!((0..LANES).all(|lane| here[lane] != there[lane]), "{sampling:?}");
            }
            for lane in 0..LANES {
                visited[lane].insert(here[lane].map(|p| (p * 4.0) as u32));
            }
        }
        assert!(visited.iter().all(|cells| cells.len() == 16), "{sampling:?}: {visited:?}");
    }
}

/// A list of views has the same pixels as all views: a single view, the corners, more views than lanes of a packet, one
/// view twice.
#[test]
fn a_list_of_views_gives_the_pixels_of_the_whole() {
    let (renderer, request) = garden();
    let ground_truth = GroundTruth::All;
    let whole = request.ground_truth(ground_truth).layers(LayerSet::ALL).max_bounces(3).reuse(Reuse::Off);
    for integrator in [Integrator::Depth, Integrator::Path] {
        let whole = whole.clone().integrator(integrator);
        let all = renderer.render(&whole, &()).expect("a render");
        let corners = [[0, 0], [0, 5], [4, 0], [4, 5]].map(|[row, column]| ViewIndex::new(row, column));
        let many = (0..23).map(|k| ViewIndex::new(k % 5, (k * 7) % 6)).collect();
        for list in [vec![ViewIndex::new(3, 1)], corners.to_vec(), many, vec![ViewIndex::new(2, 2); 2]] {
            let some = renderer.render(&whole.clone().views(Views::List(list.clone())), &());
            let some = some.expect("a render");
            assert_eq!(some.central, all.central, "the central view is not of the list");
            let (some_all, all_all) = (some.all.expect("layers"), all.all.as_ref().expect("layers"));
            for (k, view) in list.iter().enumerate() {
                for layer in Layer::ALL {
                    let expected = all_all[layer].view(view.row, view.column).expect("a view");
                    assert_eq!(some_all[layer].view(0, k).expect("a view"), expected, "{layer} of {view:?}");
                }
                if let (Some(some), Some(all)) = (&some.color, &all.color) {
                    let expected = all.view(view.row, view.column).expect("a view");
                    // Without a target error pixels do not depend on their neighbors.
                    assert_eq!(some.view(0, k).expect("a view"), expected, "{integrator:?}, {view:?}");
                }
            }
        }
    }
    for bad in [vec![], vec![ViewIndex::new(5, 0)], vec![ViewIndex::new(0, 6)]] {
        let refused = renderer.render(&whole.clone().views(Views::List(bad)), &());
        assert!(matches!(refused, Err(Error::BadSetting(_))));
    }
}

/// The disparities of what the central view hits are those that were requested. Odd numbers of views: up to the rounding
/// of depths to f32, 6e-8, times k/Z, a few hundred px. With even ones the central view moves with the baseline over
/// the leaves of the tree.
#[test]
fn a_rig_for_a_range_of_disparities() {
    let scene = gallery::scene("garden").expect("a scene of the gallery");
    for (views, bound) in [(5, 1e-4), (6, 0.1)] {
        let shape = LightFieldShape::new(GridSize::new(views, views), GridSize::new(40, 60)).expect("sizes");
        let framed = crate::Framing::new(shape).frame(&scene).expect("a camera");
        let renderer = Renderer::new(&scene, &framed.pose, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
        let wanted = DisparityRange { min_px: -0.5, max_px: 1.5 };
        let rig = renderer.rig_for_disparities(&framed, wanted).expect("a rig");
        let (near, far) = renderer.central_depths_m(&rig).expect("layers").expect("hits");
        let disparity = rig.disparity_x();
        assert!((disparity.from_depth_m(near) - 1.5).abs() < bound, "{}", disparity.from_depth_m(near));
        assert!((disparity.from_depth_m(far) + 0.5).abs() < bound, "{}", disparity.from_depth_m(far));
        let orthographic = crate::Framing::new(shape).projection(Projection::Orthographic).frame(&scene).expect("one");
        let error = renderer.rig_for_disparities(&orthographic, wanted).unwrap_err();
        assert!(matches!(error, Error::BadSetting(why) if why.contains("`disparity`")));
    }
}
