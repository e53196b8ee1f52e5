//! A walled garden on a table: brickwork and a mosaic behind, stones, a knotted sculpture, grass and a small tree.
//!
//! **Purpose**: dense foliage of many instances before a textured background, and hard shadows on rough and smooth
//! things. **Difficulty**: blades and leaves are narrower than a pixel and occlude each other; neighboring pixels
//! rarely have the same depth.

use glam::DVec3;

use crate::animation::{Animation, Key, Target, Track};
use crate::built::parts::noise::{Random, fractal};
use crate::built::parts::{patterns, shapes};
use crate::{Camera, CameraProjection, Instance, Light, LightKind, Material, Mesh, Scene, TextureInfo, Transform};

pub(super) fn scene() -> Scene {
    let mut scene = Scene {
        textures: vec![patterns::bricks(), patterns::ground(), patterns::mosaic()],
        lights: vec![sun(), lamp()],
        cameras: vec![camera()],
        ..Scene::default()
    };
    let brick = textured(&mut scene, "brick", 0);
    let earth = textured(&mut scene, "earth", 1);
    let tiles = textured(&mut scene, "tiles", 2);
    let stone = plain(&mut scene, "stone", [0.46, 0.44, 0.41]);
    let bronze = plain(&mut scene, "bronze", [0.10, 0.34, 0.27]);
    let marble = plain(&mut scene, "marble", [0.82, 0.80, 0.76]);
    let leaf = plain(&mut scene, "leaf", [1.0; 3]);
    let bark = plain(&mut scene, "bark", [0.20, 0.12, 0.07]);

    let ground = shapes::sheet(160, 120, |s, t| {
        let (x, z) = (1.8 * (s - 0.5), 1.3 * (t - 0.5));
        DVec3::new(x, ground_height(x, z), z)
    });
    place(&mut scene, "ground", ground, earth, Transform::IDENTITY);
    place(&mut scene, "wall", wall(), brick, Transform::IDENTITY);
    let disc = shapes::sheet(96, 1, |s, t| {
        // With a small hole in the middle, where the parametrization is singular.
        let (angle, radius) = (-s * std::f64::consts::TAU, 0.19 * (0.002 + 0.998 * t));
        DVec3::new(radius * angle.cos(), 0.36 + radius * angle.sin(), -0.492)
    });
    place(&mut scene, "mosaic", round_coordinates(disc), tiles, Transform::IDENTITY);
    place(&mut scene, "coping", shapes::cuboid([-0.9, 0.62, -0.56], [0.9, 0.65, -0.46]), marble, Transform::IDENTITY);

    stones(&mut scene, stone);
    sculpture(&mut scene, bronze, marble);
    grass(&mut scene, leaf);
    tree(&mut scene, bark, leaf);
    halved(scene)
}

/// Scales the scene by one half: the numbers above are in units of half a meter. A power of two causes no rounding.
fn halved(mut scene: Scene) -> Scene {
    let half = |p: [f64; 3]| p.map(|x| 0.5 * x);
    for Instance { transform, .. } in &mut scene.instances {
        *transform = Transform { columns: transform.columns.map(half), translation: half(transform.translation) };
    }
    for camera in &mut scene.cameras {
        camera.pose.translation = half(camera.pose.translation);
    }
    for light in &mut scene.lights {
        if let LightKind::Point { position, .. } = &mut light.kind {
            // Half the distances: a quarter of the intensity gives the same irradiance.
            *position = half(*position);
            light.intensity = light.intensity.map(|x| 0.25 * x);
        }
    }
    scene
}

fn sun() -> Light {
    let direction = DVec3::new(-0.55, -0.85, -0.5).normalize().to_array();
    Light {
        name: "sun".into(),
        intensity: [3.3, 3.0, 2.5],
        kind: LightKind::Directional { direction, angular_diameter_rad: 0.0 },
    }
}

fn lamp() -> Light {
    let kind = LightKind::Point { position: [0.62, 0.42, 0.15], range: None };
    Light { name: "lamp".into(), intensity: [0.10, 0.065, 0.03], kind }
}

fn camera() -> Camera {
    let pose = Transform::look_at([0.06, 0.34, 1.02], [0.0, 0.2, -0.1], [0.0, 1.0, 0.0]);
    let projection = CameraProjection::Perspective { vertical_angle_rad: 0.60, aspect_ratio: Some(1.5) };
    Camera { name: "main".into(), pose, projection }
}

/// Length of the walk, s.
const WALK_SECONDS: u32 = 4;

/// Keys of the walk a second.
const WALK_RATE: u32 = 24;

/// A walk of the camera over the lawn, on the scale of the halved scene: eight steps past the stones.
pub(super) fn walk() -> Animation {
    let keys = (0..=WALK_RATE * WALK_SECONDS).map(|k| {
        let time_s = f64::from(k) / f64::from(WALK_RATE);
        let along = time_s / f64::from(WALK_SECONDS);
        // Two steps a second: the head rises by 2 mm with each, and sways half as often.
        let step = std::f64::consts::TAU * 2.0 * time_s;
        let eye = [
            -0.09 + 0.22 * along + 0.001 * (0.5 * step).sin(),
            0.100 - 0.015 * along + 0.001 * (1.0 - step.cos()),
            0.47 - 0.15 * along - 0.03 * (std::f64::consts::PI * along).sin(),
        ];
        let target = [0.03 * along, 0.08, -0.10];
        let [right, up, back] = Transform::look_at(eye, target, [0.0, 1.0, 0.0]).columns.map(DVec3::from);
        let rotation = glam::DQuat::from_mat3(&glam::DMat3::from_cols(right, up, back)).as_quat().normalize();
        Key { time_s: time_s as f32, translation: eye.map(|x| x as f32), rotation: rotation.to_array() }
    });
    let track = Track { target: Target::Camera(0), keys: keys.collect() };
    Animation { name: "walk".into(), tracks: vec![track] }
}

fn ground_height(x: f64, z: f64) -> f64 {
    0.02 * fractal([x * 3.0, z * 3.0, 0.5], 3)
}

fn wall() -> Mesh {
    let mut wall = shapes::sheet(1, 1, |s, t| DVec3::new(1.8 * (s - 0.5), 0.62 - 0.7 * t, -0.5));
    for coordinate in &mut wall.texture_coordinates {
        *coordinate = [coordinate[0] * 3.6, coordinate[1] * 1.4];
    }
    wall
}

/// Texture coordinates of a disc parametrized by angle and radius: the disc as it lies in the square image.
fn round_coordinates(mut disc: Mesh) -> Mesh {
    for coordinate in &mut disc.texture_coordinates {
        let (angle, radius) = (-coordinate[0] * std::f32::consts::TAU, 0.5 * coordinate[1]);
        *coordinate = [0.5 + radius * angle.cos(), 0.5 - radius * angle.sin()];
    }
    disc
}

fn stones(scene: &mut Scene, material: usize) {
    for (k, (x, z, size)) in
        [(-0.42, 0.10, 0.085), (-0.30, 0.20, 0.045), (0.33, 0.26, 0.055), (0.47, 0.05, 0.075), (-0.08, 0.34, 0.03)]
            .into_iter()
            .enumerate()
    {
        let offset = 10.0 * k as f64;
        let mesh = shapes::ball(96, 48, |d| 0.28 * fractal((d * 1.6 + offset).to_array(), 5));
        let flat = Transform::from_parts(
            [x, ground_height(x, z) + 0.35 * size, z],
            [0.0, (k as f64).sin(), 0.0, (k as f64).cos()],
            [size, 0.72 * size, size],
        );
        place(scene, &format!("stone {k}"), mesh, material, flat);
    }
}

fn sculpture(scene: &mut Scene, bronze: usize, marble: usize) {
    place(
        scene,
        "plinth",
        shapes::cuboid([-0.07, -0.03, -0.07], [0.07, 0.10, 0.07]),
        marble,
        Transform::from_translation([0.1, 0.0, -0.08]),
    );
    // A (2, 3) torus knot.
    let knot = shapes::tube(
        480,
        28,
        |_| 0.017,
        |s| {
            let angle = s * std::f64::consts::TAU;
            let radius = 0.062 + 0.03 * (3.0 * angle).cos();
            DVec3::new(radius * (2.0 * angle).cos(), 0.035 * (3.0 * angle).sin(), radius * (2.0 * angle).sin())
        },
    );
    let upright = Transform::from_parts([0.1, 0.207, -0.08], [0.62, 0.15, 0.1, 0.76], [1.0; 3]);
    place(scene, "knot", knot, bronze, upright);
}

fn grass(scene: &mut Scene, material: usize) {
    let mut random = Random::new(3);
    // Four different tufts with many instances.
    let tufts: Vec<usize> = (0..4)
        .map(|_| {
            let mut tuft = Mesh { name: "tuft".into(), material, ..Mesh::default() };
            for _ in 0..26 {
                let (angle, radius) = (random.between(0.0, std::f64::consts::TAU), 0.016 * random.unit().sqrt());
                let root = DVec3::new(radius * angle.cos(), -0.006, radius * angle.sin());
                let dry = random.unit() as f32;
                let color = [0.12 + 0.16 * dry, 0.30 + 0.04 * dry, 0.05 + 0.02 * dry];
                let heading = random.between(0.0, std::f64::consts::TAU);
                let (height, bend) = (random.between(0.025, 0.07), random.between(0.1, 0.8));
                shapes::add_blade(&mut tuft, root, heading, height, bend, color);
            }
            scene.meshes.push(tuft);
            scene.meshes.len() - 1
        })
        .collect();
    for _ in 0..2600 {
        let (x, z) = (random.between(-0.85, 0.85), random.between(-0.47, 0.55));
        let (size, turn) = (random.between(0.5, 1.1), random.between(0.0, std::f64::consts::PI));
        let mesh = tufts[(random.unit() * 4.0) as usize % 4];
        // Dense in patches, bare where the gravel lies.
        if fractal([x * 4.0 + 7.0, z * 4.0, 2.0], 2) < -0.12 {
            continue;
        }
        let transform =
            Transform::from_parts([x, ground_height(x, z), z], [0.0, turn.sin(), 0.0, turn.cos()], [size; 3]);
        scene.instances.push(Instance { name: "tuft".into(), mesh, transform });
    }
}

fn tree(scene: &mut Scene, bark: usize, leaf: usize) {
    let root = DVec3::new(-0.24, -0.01, -0.24);
    let trunk = shapes::tube(
        48,
        16,
        |s| 0.019 * (1.0 - 0.72 * s),
        move |s| root + DVec3::new(0.05 * (3.0 * s).sin(), 0.40 * s, 0.03 * (5.0 * s).sin()),
    );
    place(scene, "trunk", trunk, bark, Transform::IDENTITY);
    let mut random = Random::new(5);
    let mut crown = Mesh { name: "crown".into(), material: leaf, ..Mesh::default() };
    for _ in 0..5200 {
        // Leaves near the surface of a few overlapping balls.
        let (center, radius) = [
            (DVec3::new(-0.22, 0.42, -0.24), 0.12),
            (DVec3::new(-0.32, 0.37, -0.22), 0.085),
            (DVec3::new(-0.13, 0.36, -0.2), 0.08),
            (DVec3::new(-0.23, 0.34, -0.14), 0.075),
        ][(random.unit() * 4.0) as usize % 4];
        let mut vector = || DVec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let (outward, along) = (vector().normalize_or(DVec3::Y), vector().normalize_or(DVec3::X));
        let across = along.cross(outward).normalize_or(DVec3::Z);
        let at = center + outward * radius * random.unit().powf(0.25);
        let (long, wide) = (along * random.between(0.007, 0.013), across * random.between(0.003, 0.006));
        let first = crown.positions.len() as u32;
        crown.positions.extend([at - long, at + wide, at + long, at - wide].map(|p| p.as_vec3().to_array()));
        let tone = random.between(0.6, 1.2) as f32;
        let autumn = (random.unit().powi(4)) as f32;
        let color = [(0.10 + 0.4 * autumn) * tone, (0.27 - 0.07 * autumn) * tone, 0.04 * tone, 1.0];
        crown.colors.extend([color; 4]);
        crown.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    place(scene, "crown", crown, leaf, Transform::IDENTITY);
}

fn textured(scene: &mut Scene, name: &str, texture: usize) -> usize {
    let base_color_texture = Some(TextureInfo::new(texture));
    scene.materials.push(Material { name: name.into(), base_color_texture, ..Material::default() });
    scene.materials.len() - 1
}

fn plain(scene: &mut Scene, name: &str, [r, g, b]: [f32; 3]) -> usize {
    scene.materials.push(Material { name: name.into(), base_color: [r, g, b, 1.0], ..Material::default() });
    scene.materials.len() - 1
}

fn place(scene: &mut Scene, name: &str, mesh: Mesh, material: usize, transform: Transform) {
    scene.meshes.push(Mesh { name: name.into(), material, ..mesh });
    scene.instances.push(Instance { name: name.into(), mesh: scene.meshes.len() - 1, transform });
}
