//! Gallery scenes with their rigs, and a description of the machine.

use std::num::NonZeroUsize;
use std::process::Command;

use holo_core::{GridSize, LightFieldShape, Rig};
use holo_render::{Backend, Baseline, Framing, Integrator, Renderer};
use holo_scene::gallery;
use holo_scene::{Scene, Transform};

/// A scene of the gallery with a camera pose and a rig.
pub struct FramedScene {
    pub scene: Scene,
    pub pose: Transform,
    pub rig: Rig,
}

impl FramedScene {
    /// Frames a scene for `views` x `views` views, with `baseline_m` or, without it, the baseline of an f/5 lens.
    pub fn new(name: &str, views: usize, lenses: GridSize, baseline_m: Option<f64>) -> Self {
        let scene = gallery::scene(name).expect("a scene of the gallery");
        let framing = Framing::new(LightFieldShape::new(GridSize::new(views, views), lenses).expect("sizes"))
            .baseline(baseline_m.map_or(Baseline::FNumber(5.0), Baseline::Meters));
        let framed = framing.frame(&scene).expect("a camera");
        let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, None).expect("a renderer");
        let focus = renderer.automatic_focus_m(&framed).expect("a focus");
        Self { rig: framed.rig(focus).expect("a rig"), pose: framed.pose, scene }
    }

    /// A renderer with `threads` threads; `None`: one per core.
    pub fn renderer(&self, backend: Backend, threads: impl Into<Option<NonZeroUsize>>) -> Renderer {
        Renderer::new(&self.scene, &self.pose, backend, threads).expect("a renderer")
    }
}

/// The constant environment radiance that a scene is measured with: 0 except for `garden`, whose shadows are black
/// without one.
pub fn sky(name: &str) -> [f32; 3] {
    if name == "garden" { [0.35, 0.45, 0.6] } else { [0.0; 3] }
}

/// The available backends, the fastest one first.
pub fn engines() -> Vec<Backend> {
    let empty = Scene::default();
    let all = [Backend::Embree, Backend::Bvh];
    all.into_iter()
        .filter(|&backend| Renderer::new(&empty, &Transform::IDENTITY, backend, NonZeroUsize::new(1)).is_ok())
        .collect()
}

/// The name of a backend in tables.
pub fn backend_name(backend: Backend) -> &'static str {
    match backend {
        Backend::Embree => "Embree",
        Backend::Bvh => "BVH",
        _ => "other",
    }
}

/// Processor, threads and backend of this machine, and the version and commit of this program.
pub fn machine() -> String {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(": an unknown processor");
    let sets = [(" avx512f ", " with AVX-512"), (" avx2 ", " with AVX2")];
    let set = sets.into_iter().find(|(flag, _)| cpu.contains(flag)).map_or("", |(_, name)| name);
    let mut git = Command::new("git");
    let git = git.args(["describe", "--always", "--dirty"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let commit = git.output().ok().and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let engine = Renderer::new(&Scene::default(), &Transform::IDENTITY, Backend::Auto, NonZeroUsize::new(1));
    let engine = engine.map_or_else(|error| error.to_string(), |renderer| renderer.engine_name().to_owned());
    format!(
        "Machine: {}{set}, {threads} threads; {engine}; holo {}, commit {}.",
        model.trim_start_matches([' ', '\t', ':']),
        env!("CARGO_PKG_VERSION"),
        commit.trim()
    )
}

/// The name of an integrator in tables and file names.
pub fn integrator_name(integrator: Integrator) -> &'static str {
    if integrator == Integrator::Direct { "direct" } else { "path" }
}

/// The name of an integrator in the summary.
pub fn integrator_label(integrator: Integrator) -> &'static str {
    if integrator == Integrator::Direct { "direct light" } else { "paths" }
}
