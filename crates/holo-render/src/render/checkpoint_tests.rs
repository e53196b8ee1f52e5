//! Renders that are canceled anywhere and continue from their finished tiles.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use holo_core::{GridSize, LightFieldShape, Rig, ViewIndex};
use holo_scene::gallery;

use super::checkpoint::{FinishedTile, TileId, TileKind};
use super::*;
use crate::film::layers::Layer;

/// Tiles in memory; stored after every `every` tiles.
#[derive(Default)]
struct Memory {
    tiles: Mutex<BTreeMap<TileId, FinishedTile>>,
    every: u64,
    /// The number of calls of `store` that fail.
    failures: AtomicU64,
}

impl Checkpoint for Memory {
    fn contains(&self, id: TileId) -> bool {
        self.tiles.lock().expect("a lock").contains_key(&id)
    }

    fn restore(&self, id: TileId) -> Option<FinishedTile> {
        self.tiles.lock().expect("a lock").get(&id).cloned()
    }

    fn is_due(&self, done: u64, _: u64) -> bool {
        done.is_multiple_of(self.every)
    }

    fn wants_rest(&self) -> bool {
        true
    }

    fn store(&self, tiles: &mut dyn Iterator<Item = FinishedTile>) -> bool {
        if self.failures.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_ok() {
            return false;
        }
        for tile in tiles {
            let before = self.tiles.lock().expect("a lock").insert(tile.id, tile);
            assert_eq!(before, None, "a tile is stored once");
        }
        true
    }
}

/// Cancels after `left` questions; counts the tiles that were reported.
struct Cancel {
    left: AtomicU64,
    reported: AtomicU64,
    total: AtomicU64,
}

impl Cancel {
    fn after(questions: u64) -> Self {
        Self { left: questions.into(), reported: 0.into(), total: 0.into() }
    }
}

impl Progress for Cancel {
    fn advance(&self, done: u64, total: u64) {
        self.reported.fetch_max(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_err()
    }
}

/// Requests whose tiles are elemental images, and rows of microlenses, with every kind of tile.
fn requests() -> Vec<Request> {
    let rig = |views, lenses| {
        let shape = LightFieldShape::new(views, lenses).expect("sizes");
        Rig::builder(shape).focal_length_m(0.04).sensor_size_m(0.036).baseline_m(0.002).focus_distance_m(0.9).build()
    };
    let many = rig(GridSize::new(60, 60), GridSize::new(2, 4)).expect("a rig");
    let few = rig(GridSize::new(3, 2), GridSize::new(50, 90)).expect("a rig");
    let layers = LayerSet::of(&[Layer::Depth, Layer::ShadingNormal, Layer::ObjectId]);
    let lit = |rig| Request::new(rig).sky([0.3, 0.4, 0.5]).samples(4).max_bounces(2).layers(layers);
    vec![
        lit(many).ground_truth(GroundTruth::All),
        lit(few).integrator(Integrator::Direct),
        lit(few).target_error(Some(0.3)).samples(32).rows(Some(0..36)),
        lit(few).views(Views::List(vec![ViewIndex { row: 1, column: 0 }])).ground_truth(GroundTruth::All),
        Request::new(many).integrator(Integrator::Depth).ground_truth(GroundTruth::All),
    ]
}

fn renderer() -> Renderer {
    let scene = gallery::scene("glasses").expect("a scene of the gallery");
    Renderer::new(&scene, &scene.cameras[0].pose, Backend::Bvh, NonZeroUsize::new(2)).expect("a renderer")
}

fn assert_same(continued: &Rendered, whole: &Rendered) {
    let color = |rendered: &Rendered| rendered.color.as_ref().map(|color| color.samples().to_owned());
    let all = |rendered: &Rendered| {
        let fields = rendered.all.iter().flat_map(Layers::iter);
        fields.map(|(layer, field)| (layer, field.samples().to_owned())).collect::<Vec<_>>()
    };
    assert!(color(continued) == color(whole));
    assert!(all(continued) == all(whole));
    assert!(continued.central == whole.central);
    assert_eq!((continued.rays, continued.samples), (whole.rays, whole.samples));
}

#[test]
fn a_render_that_is_canceled_anywhere_continues_to_the_same_values() {
    let renderer = renderer();
    for request in requests() {
        let counting = Cancel::after(u64::MAX);
        let whole = renderer.render(&request, &counting).expect("a render");
        let total = counting.total.into_inner();
        let questions = u64::MAX - counting.left.into_inner();
        assert!(total > 2, "{total} tiles");
        for (number, after) in [0, questions / 2, questions - 2].into_iter().enumerate() {
            let memory = Memory { every: [1, 3][number % 2], ..Memory::default() };
            let first = Cancel::after(after);
            let canceled = renderer.render_with_checkpoint(&request, &first, &memory);
            assert!(matches!(canceled, Err(Error::Cancelled)), "after {after} of {questions}");
            let stored = memory.tiles.lock().expect("a lock").len() as u64;
            assert!(stored <= first.reported.into_inner());
            let second = Cancel::after(u64::MAX);
            let continued = renderer.render_with_checkpoint(&request, &second, &memory).expect("a render");
            assert_same(&continued, &whole);
            assert_eq!(second.total.load(Ordering::Relaxed), total - stored);
            assert_eq!(second.reported.into_inner(), total - stored, "only what was missing is rendered");
            assert_eq!(memory.tiles.lock().expect("a lock").len() as u64, total);
            let third = renderer.render_with_checkpoint(&request, &(), &memory).expect("a render");
            assert_same(&third, &whole);
        }
    }
}

/// The reconstruction across views begins when all tiles are there, with what their checkpoint holds beside color.
#[test]
fn a_denoised_render_continues_to_the_same_values() {
    let renderer = renderer();
    let once = requests()[0].clone().denoise(Denoise::Views).estimate_error(true);
    let in_rounds = once.clone().samples(16).target_error(Some(0.1));
    for request in [once, in_rounds] {
        let counting = Cancel::after(u64::MAX);
        let whole = renderer.render(&request, &counting).expect("a render");
        let questions = u64::MAX - counting.left.into_inner();
        for after in [questions / 2, questions - 2] {
            let memory = Memory { every: 1, ..Memory::default() };
            let canceled = renderer.render_with_checkpoint(&request, &Cancel::after(after), &memory);
            assert!(matches!(canceled, Err(Error::Cancelled)), "after {after} of {questions}");
            let continued = renderer.render_with_checkpoint(&request, &(), &memory).expect("a render");
            assert_same(&continued, &whole);
            assert!(continued.error.is_some() && continued.error == whole.error);
        }
    }
}

#[test]
fn tiles_that_could_not_be_stored_are_offered_again() {
    let renderer = renderer();
    let request = &requests()[0];
    let memory = Memory { every: 1, failures: 2.into(), ..Memory::default() };
    let whole = renderer.render_with_checkpoint(request, &(), &memory).expect("a render");
    let mut kinds = BTreeMap::<TileKind, usize>::new();
    memory.tiles.lock().expect("a lock").keys().for_each(|id| *kinds.entry(id.kind).or_default() += 1);
    assert_eq!(kinds.keys().collect::<Vec<_>>(), [&TileKind::Color, &TileKind::AllLayers]);
    assert!(kinds.values().all(|count| *count >= 4), "{kinds:?}");
    assert_same(&renderer.render_with_checkpoint(request, &(), &memory).expect("a render"), &whole);
}

#[test]
fn a_tile_of_another_size_is_rendered_again() {
    struct Foreign;
    impl Checkpoint for Foreign {
        fn contains(&self, _: TileId) -> bool {
            true
        }
        fn restore(&self, id: TileId) -> Option<FinishedTile> {
            Some(FinishedTile { id, rays: crate::RayCounts::default(), values: vec![7.0; 5] })
        }
        fn is_due(&self, _: u64, _: u64) -> bool {
            false
        }
        fn wants_rest(&self) -> bool {
            false
        }
        fn store(&self, _: &mut dyn Iterator<Item = FinishedTile>) -> bool {
            unreachable!("nothing is due")
        }
    }
    let renderer = renderer();
    let request = &requests()[1];
    let whole = renderer.render(request, &()).expect("a render");
    assert_same(&renderer.render_with_checkpoint(request, &(), &Foreign).expect("a render"), &whole);
}
