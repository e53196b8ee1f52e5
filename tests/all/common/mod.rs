//! Scenes, rigs and vectors for several tests.
#![allow(dead_code, reason = "every test file uses a part of it")]

mod peer;

use std::num::NonZeroUsize;

use holo_core::plenoptic::{
    ArrayFocus, ImageSensor, LensAperture, MainLens, MicrolensArray, MicrolensFocus, MicrolensGrid, PlenopticCamera,
    PupilShape,
};
use holo_core::{GridSize, LightFieldShape, Projection, Rig};
use holo_render::{Backend, GroundTruth, Integrator, Rendered, Renderer, Request};
use holo_scene::{Instance, Material, Mesh, Scene, Transform};

/// Whether the nightly run wants all scenes and samples, which take minutes.
pub fn is_thorough() -> bool {
    std::env::var_os("HOLO_THOROUGH").is_some_and(|value| value == "1")
}

/// SplitMix64, a deterministic pseudo-random generator.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// A rig at the origin that looks along -Z: 50 mm lens on a 36 mm sensor.
pub fn rig(
    [t, s]: [usize; 2],
    [v, u]: [usize; 2],
    baseline_m: f64,
    focus_distance_m: f64,
    projection: Projection,
) -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).expect("sizes"))
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_m(baseline_m)
        .focus_distance_m(focus_distance_m)
        .projection(projection)
        .build()
        .expect("a rig")
}

/// Adds a mesh of one material, placed once.
pub fn add(scene: &mut Scene, mut mesh: Mesh, base_color: [f32; 4], transform: Transform) {
    mesh.material = scene.materials.len();
    scene.materials.push(Material { base_color, ..Material::default() });
    scene.meshes.push(mesh);
    scene.instances.push(Instance { name: String::new(), mesh: scene.meshes.len() - 1, transform });
}

/// A square of half-width `half` around the origin in the plane z = 0, facing +Z.
pub fn square(half: f32) -> Mesh {
    Mesh {
        positions: vec![[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Random triangles of a few colors, 2 to 6 m in front of the camera.
pub fn soup(count: usize, seed: u64) -> Scene {
    let mut random = Random(seed);
    let mut scene = Scene::default();
    for _ in 0..4 {
        let color = [random.unit() as f32, random.unit() as f32, random.unit() as f32, 1.0];
        let mut mesh = Mesh::default();
        for k in 0..(count / 4) as u32 {
            let center = [random.between(-1.5, 1.5), random.between(-1.5, 1.5), random.between(-6.0, -2.0)];
            mesh.positions.extend((0..3).map(|_| center.map(|c| (c + random.between(-0.4, 0.4)) as f32)));
            mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
        }
        add(&mut scene, mesh, color, Transform::IDENTITY);
    }
    scene
}

/// Renders with the camera at the origin.
pub fn render(scene: &Scene, request: &Request, backend: Backend, threads: usize) -> Rendered {
    render_from(scene, &Transform::IDENTITY, request, backend, threads)
}

/// Renders with the camera at `pose`.
pub fn render_from(scene: &Scene, pose: &Transform, request: &Request, backend: Backend, threads: usize) -> Rendered {
    let renderer = Renderer::new(scene, pose, backend, NonZeroUsize::new(threads)).expect("a renderer");
    renderer.render(request, &()).expect("a render")
}

/// A request for color and the ground truth of all views.
pub fn everything(rig: Rig, samples: u32, sky: [f32; 3]) -> Request {
    let ground_truth = GroundTruth::All;
    Request::new(rig).integrator(Integrator::Direct).samples(samples).seed(1).sky(sky).ground_truth(ground_truth)
}

/// A request for the ground truth of all views alone.
pub fn truth(rig: Rig) -> Request {
    everything(rig, 1, [0.0; 3]).integrator(Integrator::Depth)
}

/// The ray tracing backends of this machine. Prints a line if Embree is missing.
pub fn engines() -> Vec<Backend> {
    match Renderer::new(&soup(4, 1), &Transform::IDENTITY, Backend::Embree, NonZeroUsize::new(1)) {
        Ok(_) => vec![Backend::Embree, Backend::Bvh],
        Err(why) => {
            peer::missing(&format!("Embree: {why}"));
            vec![Backend::Bvh]
        }
    }
}

/// The difference of two vectors.
pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The dot product of two vectors.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product of two vectors.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Whole pixels behind square microlenses that image a matched square pupil: the ideal rig, and that rig.
pub fn ideal(views: usize, lenses: [usize; 2]) -> (PlenopticCamera, Rig) {
    let (pixel, gap, focal) = (5e-6, 2e-3, 0.05);
    let distance = 1.0 / (1.0 / focal - 1.0 / 3.0);
    let pitch = views as f64 * pixel / (1.0 + gap / distance);
    let mut array = MicrolensArray::new(MicrolensGrid::Square, pitch, gap);
    (array.focus, array.aperture) = (MicrolensFocus::Pupil, LensAperture::Square { half_width_m: pitch / 2.0 });
    // The image of the pupil is as wide as the micro-images are apart: no overlap.
    let mut lens = MainLens::new(focal, focal * gap / (views as f64 * pixel * distance), 3.0);
    (lens.focus, lens.aperture) = (ArrayFocus::Distance { mla_distance_m: distance }, PupilShape::Square);
    let [v, u] = lenses;
    let mut sensor = ImageSensor::new(GridSize::new(v * views, u * views), pixel);
    sensor.fill = 1e-6;
    let camera = PlenopticCamera::new(sensor, array, lens).expect("a camera");
    let rig = camera.equivalent_rig(GridSize::new(views, views), GridSize::new(v, u), pitch, 1.0).expect("a rig");
    (camera, rig)
}
