//! A fence of wire between posts before a hedge, with a climbing plant in the mesh and a brick wall behind.
//!
//! **Purpose**: depth through a fence. **Difficulty**: the wires repeat, and are about as wide as a pixel; the leaves
//! behind have no edges that are longer than a few pixels, so that most pixels are mixed of two or three depths.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::built::parts::materials::{STEEL, diffuse, glossy, metal, repeated};
use crate::built::parts::noise::{Random, fractal};
use crate::built::parts::shapes;
use crate::built::parts::solids::rounded_box;
use crate::built::parts::studio::{Studio, at};
use crate::built::parts::{patterns, textures};
use crate::{Mesh, Scene, Transform};

/// The plane of the wires.
const WIRES_Z: f64 = 0.05;

pub(super) fn scene() -> Scene {
    let wood = textures::grained("wood", [0.30, 0.20, 0.12], 0.25);
    let mut studio = Studio::new(vec![patterns::bricks(), patterns::ground(), wood]);
    let brick = studio.material("brick", repeated(0, [3.2, 1.9], diffuse([0.8; 3])));
    let earth = studio.material("earth", repeated(1, [2.0, 2.0], diffuse([0.8; 3])));
    let wood = studio.material("wood", repeated(2, [1.0, 1.0], diffuse([1.0; 3])));
    let wire = studio.material("wire", metal(STEEL, 0.35));
    let leaf = studio.material("leaf", glossy([1.0; 3], 0.5));
    let stem = studio.material("stem", diffuse([0.16, 0.13, 0.06]));

    let wall = shapes::sheet(1, 1, |s, t| DVec3::new(0.98 * (s - 0.5), 0.55 - 0.6 * t, -0.42));
    studio.add("wall", wall, brick, Transform::IDENTITY);
    let ground = shapes::sheet(80, 80, |s, t| {
        let (x, z) = (0.98 * (s - 0.5), 0.98 * t - 0.52);
        DVec3::new(x, 0.008 * fractal([x * 9.0, z * 9.0, 1.5], 3), z)
    });
    studio.add("ground", ground, earth, Transform::IDENTITY);

    let mut random = Random::new(23);
    hedge(&mut studio, leaf, stem, &mut random);
    fence(&mut studio, wood, wire);
    climber(&mut studio, leaf, stem, &mut random);
    grass(&mut studio, leaf, &mut random);

    studio.room([0.17, 0.18, 0.20]);
    studio.softbox("sky", [-0.60, 1.15, 0.55], [0.0, 0.1, -0.1], [0.6, 0.5], [7.0, 7.2, 7.6]);
    studio.spot("sun", [0.85, 1.25, 0.60], [0.0, 0.1, -0.1], 40.0, [3.2, 2.9, 2.4]);
    studio.with_camera([0.035, 0.150, 0.620], [0.0, 0.135, -0.10])
}

/// A leaf: two triangles, folded a little along the middle.
fn add_leaf(mesh: &mut Mesh, root: DVec3, along: DVec3, up: DVec3, size: f64, color: [f32; 3]) {
    let side = along.cross(up).normalize_or(DVec3::X) * (0.36 * size);
    let middle = root + along * (0.5 * size) + up * (0.08 * size);
    let corners = [root, middle + side, root + along * size, middle - side];
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners.map(|p| p.as_vec3().to_array()));
    mesh.colors.extend([[color[0], color[1], color[2], 1.0]; 4]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

/// Greens, some of them of autumn.
fn color(random: &mut Random) -> [f32; 3] {
    let (tone, autumn) = (random.between(0.55, 1.25) as f32, random.unit().powi(5) as f32);
    [(0.11 + 0.38 * autumn) * tone, (0.27 - 0.08 * autumn) * tone, 0.05 * tone]
}

fn direction(random: &mut Random) -> DVec3 {
    DVec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0)).normalize_or(DVec3::Y)
}

/// Bushes one behind the other, with gaps through which the wall is seen.
fn hedge(studio: &mut Studio, leaf: usize, stem: usize, random: &mut Random) {
    for (name, z, count, height) in [("far hedge", -0.30, 5200, 0.30), ("hedge", -0.17, 4200, 0.23)] {
        let mut leaves = Mesh::default();
        for _ in 0..count {
            let (x, y) = (random.between(-0.46, 0.46), random.between(0.01, height));
            // Bare in places, and thinner above.
            let cover = fractal([x * 7.0, y * 7.0, z * 11.0], 3) + 0.35 - 0.9 * (y / height - 0.5).max(0.0);
            if cover < 0.0 {
                continue;
            }
            let root = DVec3::new(x, y, z + random.between(-0.045, 0.045));
            let (along, up) = (direction(random), (direction(random) + DVec3::Z).normalize_or(DVec3::Z));
            let (size, color) = (random.between(0.010, 0.020), color(random));
            add_leaf(&mut leaves, root, along, up, size, color);
        }
        studio.add(name, leaves, leaf, Transform::IDENTITY);
        for k in 0..14 {
            let x = 0.065 * f64::from(k) - 0.43 + random.between(-0.02, 0.02);
            let (lean, bend) = (random.between(-0.06, 0.06), random.between(0.0, TAU));
            let path = move |s: f64| {
                DVec3::new(
                    x + lean * s + 0.008 * (5.0 * s + bend).sin(),
                    height * 0.95 * s,
                    z + 0.01 * (bend + s).cos(),
                )
            };
            studio.add("stem", shapes::tube(24, 8, |s| 0.0025 * (1.0 - 0.7 * s), path), stem, Transform::IDENTITY);
        }
    }
}

/// Posts and rails of wood, and between them two families of wires, which cross.
fn fence(studio: &mut Studio, wood: usize, wire: usize) {
    for (k, x) in [-0.30, -0.10, 0.10, 0.30].into_iter().enumerate() {
        let lean = 0.002 * (k as f64 - 1.5);
        studio.add("post", rounded_box([0.016, 0.30, 0.016], 0.003), wood, at(x + lean, 0.15, WIRES_Z - 0.012));
    }
    for y in [0.022, 0.272] {
        studio.add("rail", rounded_box([0.72, 0.011, 0.009], 0.002), wood, at(0.0, y, WIRES_Z - 0.012));
    }
    let (left, right, bottom, top) = (-0.34, 0.34, 0.022, 0.272);
    let high = top - bottom;
    for side in [1.0, -1.0] {
        // Wires rise by their height along the same width, and end at the sides of the fence.
        for k in -14..38 {
            let foot = left + 0.0182 * f64::from(k);
            let [from, to] = [0.0, high].map(|y| foot + y);
            let (start, end) = (((left - from) / (to - from)).max(0.0), ((right - from) / (to - from)).min(1.0));
            if end <= start + 0.02 {
                continue;
            }
            let path = move |s: f64| {
                let y = high * (start + (end - start) * s);
                let x = foot + y;
                // Over and under those that cross it.
                let weave = 0.0006 * side * (TAU * 0.5 * y / 0.0091).cos();
                DVec3::new(side * x, bottom + y, WIRES_Z + weave)
            };
            studio.add("wire", shapes::tube(96, 6, |_| 0.00055, path), wire, Transform::IDENTITY);
        }
    }
}

/// A plant that climbs through the mesh.
fn climber(studio: &mut Studio, leaf: usize, stem: usize, random: &mut Random) {
    let mut leaves = Mesh::default();
    for (x, lean, height) in [(-0.17, 0.09, 0.24), (0.045, -0.05, 0.19), (0.20, -0.08, 0.26)] {
        let path = move |s: f64| {
            let turn = 5.0 * TAU * s;
            DVec3::new(x + lean * s + 0.008 * turn.sin(), 0.004 + height * s, WIRES_Z + 0.0035 * turn.cos())
        };
        studio.add("vine", shapes::tube(160, 6, |s| 0.0014 * (1.0 - 0.6 * s), path), stem, Transform::IDENTITY);
        for k in 0..46 {
            let s = (f64::from(k) + random.unit()) / 46.0;
            let out = (direction(random) + 0.8 * DVec3::Z).normalize_or(DVec3::Z);
            let along = (direction(random) + DVec3::Y * 0.4).normalize_or(DVec3::X);
            let (size, color) = (random.between(0.012, 0.022), color(random));
            add_leaf(&mut leaves, path(s), along, out, size, color);
        }
    }
    studio.add("climber", leaves, leaf, Transform::IDENTITY);
}

/// Grass on both sides of the fence.
fn grass(studio: &mut Studio, leaf: usize, random: &mut Random) {
    let mut blades = Mesh::default();
    for _ in 0..1500 {
        let (x, z) = (random.between(-0.36, 0.36), random.between(-0.10, 0.16));
        if fractal([x * 8.0, z * 8.0, 4.0], 2) < -0.08 {
            continue;
        }
        let (heading, height, bend) =
            (random.between(0.0, TAU), random.between(0.015, 0.045), random.between(0.1, 0.8));
        let dry = random.unit() as f32;
        let color = [0.12 + 0.16 * dry, 0.30 + 0.04 * dry, 0.05 + 0.02 * dry];
        shapes::add_blade(&mut blades, DVec3::new(x, -0.002, z), heading, height, bend, color);
    }
    studio.add("grass", blades, leaf, Transform::IDENTITY);
}
