//! Shared by the benchmarks: a scene with a rig from the command line, and interleaved timing.
#![forbid(unsafe_code)]

pub mod error;

use holo_core::{GridSize, LightFieldShape, Remainder, Rig, Sensor};
use holo_render::{Backend, Baseline, Framing, Renderer};
use holo_scene::{Scene, Transform};

/// A scene with a rig, and the number of rounds.
pub struct Setup {
    /// The scene.
    pub scene: Scene,
    /// The pose of the rig.
    pub pose: Transform,
    /// The rig.
    pub rig: Rig,
    /// How many times each entry is measured.
    pub rounds: usize,
    name: String,
}

impl Setup {
    /// One line with scene, view count, resolution and rounds.
    #[must_use]
    pub fn describe(&self) -> String {
        let split = self.rig.shape();
        format!(
            "{}: {} triangles; {} x {} views of {} x {} px; best of {}",
            self.name,
            self.scene.triangle_count(),
            split.views().columns,
            split.views().rows,
            split.lenses().columns,
            split.lenses().rows,
            self.rounds
        )
    }
}

/// Reads `[SCENE.glb] [--views N] [--lenses UxV] [--rounds N]`; by default the scene `garden`, 100 x 100 views of
/// 79 x 53 px, 3 rounds.
///
/// # Panics
/// On invalid arguments.
pub fn scene_rig(arguments: impl Iterator<Item = String>) -> Setup {
    let (mut file, mut views, mut lenses, mut rounds) = (None, 100, (79, 53), 3);
    let mut arguments = arguments.filter(|a| a != "--bench");
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().expect("a value after the option");
        match argument.as_str() {
            "--views" => views = value().parse().expect("a count"),
            "--rounds" => rounds = value().parse().expect("a count"),
            "--lenses" => {
                let text = value();
                let (u, v) = text.split_once('x').expect("UxV");
                lenses = (u.parse().expect("a count"), v.parse().expect("a count"));
            }
            _ => file = Some(argument),
        }
    }
    let (name, scene) = match file {
        Some(path) => {
            let loaded = holo_scene::gltf::load(path.as_ref(), &Default::default()).expect("a scene");
            let name = std::path::Path::new(&path).file_stem().expect("a file name");
            (name.to_string_lossy().into_owned(), loaded.scene)
        }
        None => ("garden".into(), scene("garden")),
    };
    let framing = Framing::new(
        LightFieldShape::new(GridSize::new(views, views), GridSize::new(lenses.1, lenses.0)).expect("sizes"),
    )
    .baseline(Baseline::FNumber(5.0));
    let framed = framing.frame(&scene).expect("a camera");
    let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, None).expect("a renderer");
    let focus = renderer.automatic_focus_m(&framed).expect("a focus");
    let rig = framed.rig(focus).expect("a rig");
    Setup { scene, pose: framed.pose, rig, rounds, name }
}

/// The scene of a `.glb`, or one of the gallery.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn scene(name: &str) -> Scene {
    match name.ends_with(".glb") {
        true => holo_scene::gltf::load(name.as_ref(), &Default::default()).expect("a scene").scene,
        false => holo_scene::gallery::scene(name).expect("a scene of the gallery"),
    }
}

/// A renderer of `scene`, and a rig of this many views an axis on the 8K sensor of the paper, focused automatically.
///
/// # Panics
/// If the views do not fit, or the scene has no camera.
#[must_use]
pub fn on_the_paper_sensor(scene: &Scene, views: usize) -> (Renderer, Rig) {
    let shape = Sensor::Paper8k.divide(GridSize::new(views, views), Remainder::Crop).expect("views that fit").shape;
    let framed = Framing::new(shape).frame(scene).expect("a camera");
    let renderer = Renderer::new(scene, &framed.pose, Backend::Auto, None).expect("a renderer");
    let rig = framed.rig(renderer.automatic_focus_m(&framed).expect("a focus")).expect("a rig");
    (renderer, rig)
}

/// The Python that others are measured in: `HOLO_PYTHON`, or `python3`.
#[must_use]
pub fn python() -> String {
    std::env::var("HOLO_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

/// Memory of this process in bytes by its key in `/proc/self/status`, such as `VmHWM:`; `None` where the system does not
/// say it.
#[must_use]
pub fn memory_bytes(key: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// A benchmark entry: its name, and a function that returns seconds and a count (of rays).
pub type Entry<'a> = (String, Box<dyn FnMut() -> (f64, u64) + 'a>);

/// Runs every entry once per round; returns name, seconds and count of the fastest run of each.
pub fn best_of(rounds: usize, entries: &mut [Entry]) -> Vec<(String, (f64, u64))> {
    let mut best: Vec<(String, (f64, u64))> =
        entries.iter().map(|(name, _)| (name.clone(), (f64::INFINITY, 0))).collect();
    for _ in 0..rounds {
        for ((_, run), (_, kept)) in entries.iter_mut().zip(&mut best) {
            let measured = run();
            if measured.0 < kept.0 {
                *kept = measured;
            }
        }
    }
    best
}
