//! Large scenes: build time, peak memory and rays per second, with repeated meshes copied to every instance (flattened)
//! or stored once (instanced). The criterion in `holo-render/src/geometry/instancing.rs` is based on it.
//!
//! `cargo bench -p holo-bench --bench large -- [CASE] [--storage flattened|instanced|chosen] [--views N] [--rounds N]`
//!
//! Cases are `unique` (5 million triangles without repetition), `garden` (of the gallery), and INSTANCESxTRIANGLES with
//! a letter for the mesh: `r1000x10000` is rocks whose bounding boxes hardly overlap, `g2500x4000` tufts of grass whose
//! bounding boxes overlap. Needs Embree. Every row runs in its own process, because peak memory is measured per
//! process. The peak is taken after the build (scene, geometry and BVH); that of the scene alone is printed, too.

use std::f64::consts::TAU;
use std::process::Command;
use std::time::Instant;

use holo_bench::{best_of, memory_bytes};
use holo_core::{GridSize, LightFieldShape};
use holo_render::bench::{Storage, Work, renderer, trace};
use holo_render::{Baseline, Framing, GroundTruth, Integrator, Request};
use holo_scene::{Camera, CameraProjection, Instance, Light, LightKind, Material, Mesh, Scene, Transform};

const CASES: [&str; 5] = ["unique", "r1000x10000", "r100x100000", "g2500x4000", "garden"];

fn main() {
    let (mut case, mut storage, mut views, mut rounds) = (None, None, "100".to_owned(), "3".to_owned());
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().expect("a value after the option");
        match argument.as_str() {
            "--storage" => storage = Some(value()),
            "--views" => views = value(),
            "--rounds" => rounds = value(),
            _ => case = Some(argument),
        }
    }
    if let (Some(case), Some(storage)) = (&case, &storage) {
        measure(case, storage, views.parse().expect("a count"), rounds.parse().expect("a count"));
        return;
    }
    println!(
        "{views} x {views} views of 79 x 53 px, best of {rounds}; MiB: scene alone, peak after the build; Mrays/s:"
    );
    println!(
        "{:<14} {:<10} {:>10} {:>8} {:>7} {:>7} {:>8} {:>8} {:>8}",
        "", "", "triangles", "build s", "scene", "peak", "bare", "depth", "direct"
    );
    for case in case.as_deref().map_or(CASES.to_vec(), |case| vec![case]) {
        for storage in storage.as_deref().map_or(vec!["flattened", "instanced", "chosen"], |storage| vec![storage]) {
            if case == "unique" && storage != "chosen" {
                continue;
            }
            let program = std::env::current_exe().expect("the path of this program");
            let child = [case, "--storage", storage, "--views", &views, "--rounds", &rounds];
            let status = Command::new(program).args(child).status().expect("this program runs again");
            assert!(status.success(), "{case} {storage} failed");
        }
    }
}

fn measure(case: &str, storage_name: &str, views: usize, rounds: usize) {
    let storage = match storage_name {
        "flattened" => Storage::Flattened,
        "instanced" => Storage::Instanced,
        _ => Storage::Chosen,
    };
    let scene = scene(case);
    let scene_mib = peak_mib();
    let framing =
        Framing::new(LightFieldShape::new(GridSize::new(views, views), GridSize::new(53, 79)).expect("sizes"))
            .baseline(Baseline::FNumber(5.0));
    let framed = framing.frame(&scene).expect("a camera");
    let build = || {
        let start = Instant::now();
        let renderer = renderer(&scene, &framed.pose, storage).expect("Embree and a renderer");
        (start.elapsed().as_secs_f64(), renderer)
    };
    let (mut seconds, built) = build();
    let peak = peak_mib();
    let rig = framed.rig(built.automatic_focus_m(&framed).expect("a focus")).expect("a rig");
    let render = |integrator, ground_truth| {
        let request = Request::new(rig).integrator(integrator).ground_truth(ground_truth);
        let start = Instant::now();
        let rendered = built.render(&request, &()).expect("the scene renders");
        (start.elapsed().as_secs_f64(), rendered.rays.total())
    };
    let bare = || {
        let traced = trace(&built, &rig, Work::BarePackets);
        (traced.seconds, traced.rays)
    };
    let results = best_of(
        rounds,
        &mut [
            ("bare".into(), Box::new(bare)),
            ("depth".into(), Box::new(|| render(Integrator::Depth, GroundTruth::All))),
            ("direct".into(), Box::new(|| render(Integrator::Direct, GroundTruth::Central))),
        ],
    );
    drop(built);
    for _ in 1..rounds {
        seconds = seconds.min(build().0);
    }
    let mrays = |k: usize| results[k].1.1 as f64 / results[k].1.0 / 1e6;
    println!(
        "{case:<14} {storage_name:<10} {:>10} {seconds:>8.3} {scene_mib:>7} {peak:>7} {:>8.1} {:>8.1} {:>8.1}",
        scene.triangle_count(),
        mrays(0),
        mrays(1),
        mrays(2)
    );
}

/// The most memory that this process has had so far (Linux; 0 elsewhere).
fn peak_mib() -> u64 {
    memory_bytes("VmHWM:").unwrap_or(0) >> 20
}

fn scene(case: &str) -> Scene {
    match case {
        "garden" => return holo_scene::gallery::scene("garden").expect("a scene of the gallery"),
        "unique" => {
            let mut scene = Scene::default();
            let land = grid_mesh(1600, 1562, |s, t| {
                let (x, z) = (3.4 * (s - 0.5), 3.4 * (t - 0.5));
                [x, bumps(x * 4.0, z * 4.0) * 0.12 + bumps(x * 90.0, z * 90.0) * 0.002, z]
            });
            add_instances(&mut scene, land, [0.4, 0.35, 0.3], vec![Transform::IDENTITY]);
            return lit(scene);
        }
        _ => {}
    }
    let (instances, triangles) = case[1..].split_once('x').expect("INSTANCESxTRIANGLES");
    let (instances, triangles) =
        (instances.parse::<usize>().expect("a count"), triangles.parse::<u32>().expect("a count"));
    let mut scene = Scene::default();
    let ground = grid_mesh(200, 200, |s, t| [3.4 * (s - 0.5), 0.0, 3.4 * (t - 0.5)]);
    add_instances(&mut scene, ground, [0.4, 0.35, 0.3], vec![Transform::IDENTITY]);
    // A square of 3 x 3 m is divided into cells; each has one instance at a random position, rotated and scaled.
    let mut random = Random(7);
    let side = (instances as f64).sqrt().ceil() as usize;
    let pitch = 3.0 / side as f64;
    let grass = case.starts_with('g');
    let mut transforms = Vec::with_capacity(instances);
    for k in 0..instances {
        let [x, z] = [k % side, k / side].map(|i| (i as f64 + 0.5) * pitch - 1.5);
        let [dx, dz, turn, size] = [(); 4].map(|()| random.unit());
        let size = pitch * (0.35 + 0.2 * size);
        let turn = TAU / 2.0 * turn;
        let position =
            [x + pitch * 0.3 * (dx - 0.5), if grass { 0.0 } else { 0.3 * size }, z + pitch * 0.3 * (dz - 0.5)];
        transforms.push(Transform::from_parts(position, [0.0, turn.sin(), 0.0, turn.cos()], [size; 3]));
    }
    if grass {
        add_instances(&mut scene, tuft(triangles), [0.2, 0.4, 0.1], transforms);
    } else {
        add_instances(&mut scene, rock(triangles), [0.5, 0.5, 0.55], transforms);
    }
    lit(scene)
}

/// Adds a camera that looks down on the square obliquely, and a directional light.
fn lit(mut scene: Scene) -> Scene {
    let pose = Transform::look_at([0.1, 1.2, 1.9], [0.0, 0.0, 0.1], [0.0, 1.0, 0.0]);
    let projection = CameraProjection::Perspective { vertical_angle_rad: 0.9, aspect_ratio: Some(1.5) };
    scene.cameras.push(Camera { name: "main".into(), pose, projection });
    let kind = LightKind::Directional { direction: [0.48, -0.8, -0.36], angular_diameter_rad: 0.0 };
    scene.lights.push(Light { name: "sun".into(), intensity: [3.0; 3], kind });
    scene
}

fn add_instances(scene: &mut Scene, mut mesh: Mesh, [r, g, b]: [f32; 3], transforms: Vec<Transform>) {
    mesh.material = scene.materials.len();
    scene.materials.push(Material { base_color: [r, g, b, 1.0], ..Material::default() });
    let mesh_index = scene.meshes.len();
    scene.meshes.push(mesh);
    let instance = |transform| Instance { name: String::new(), mesh: mesh_index, transform };
    scene.instances.extend(transforms.into_iter().map(instance));
}

/// A displaced sphere of radius about 1 with about this many triangles.
fn rock(triangles: u32) -> Mesh {
    let rows = (f64::from(triangles) / 4.0).sqrt().round() as u32;
    grid_mesh(triangles / 2 / rows, rows, |s, t| {
        let (longitude, latitude) = (s * TAU, (1e-3 + (1.0 - 2e-3) * t) * TAU / 2.0);
        let d = [latitude.sin() * longitude.cos(), latitude.cos(), -latitude.sin() * longitude.sin()];
        let radius = 0.9 + 0.15 * bumps(3.0 * d[0] + d[1], 3.0 * d[2] - d[1]) + 0.01 * bumps(40.0 * d[0], 40.0 * d[2]);
        d.map(|x| x * radius)
    })
}

/// Bent blades of grass around the origin, seven triangles each, wider at the top than their cell.
fn tuft(triangles: u32) -> Mesh {
    let mut random = Random(11);
    let mut mesh = Mesh::default();
    for _ in 0..triangles / 7 {
        let [angle, radius, height, bend] = [(); 4].map(|()| random.unit());
        let (angle, radius, height) = (angle * TAU, 0.9 * radius.sqrt(), 1.0 + 1.5 * height);
        let (ahead, root) = ([angle.cos(), angle.sin()], [radius * angle.sin(), radius * (2.0 * angle).cos()]);
        let first = mesh.positions.len() as u32;
        for k in 0..=4 {
            let t = f64::from(k) / 4.0;
            let out = bend * height * t * t;
            for side in [-0.03, 0.03] {
                let wide = side * (1.0 - t);
                let p = [
                    root[0] + ahead[0] * out - ahead[1] * wide,
                    height * t,
                    root[1] + ahead[1] * out + ahead[0] * wide,
                ];
                mesh.positions.push(p.map(|x| x as f32));
            }
        }
        for k in 0..4 {
            let a = first + 2 * k;
            mesh.triangles.push([a, a + 1, a + 2]);
            if k < 3 {
                mesh.triangles.push([a + 1, a + 3, a + 2]);
            }
        }
    }
    mesh
}

/// A grid of `columns` x `rows` quads over `surface(s, t)`, s and t in 0..1, with smooth normals.
fn grid_mesh(columns: u32, rows: u32, surface: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    let step = 1e-5;
    for j in 0..=rows {
        for i in 0..=columns {
            let (s, t) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let difference = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
            let a = difference(surface(s, t + step), surface(s, t - step));
            let b = difference(surface(s + step, t), surface(s - step, t));
            let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
            mesh.positions.push(surface(s, t).map(|x| x as f32));
            mesh.normals.push(n.map(|x| (x / length) as f32));
        }
    }
    let corner = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A smooth function with values between -1 and 1.
fn bumps(x: f64, y: f64) -> f64 {
    ((1.3 * x + 0.7 * y).sin() + (2.1 * y - 0.4 * x).sin() + (3.7 * x + 2.9 * y).cos()) / 3.0
}

/// SplitMix64: the same random numbers on all machines.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
