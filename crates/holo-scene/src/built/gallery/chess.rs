//! An endgame of chess under a lamp and a window: wooden pieces of the Staunton pattern on an inlaid board.
//!
//! **Purpose**: soft and hard shadows side by side, and across each other. **Difficulty**: shadows move over a regular
//! pattern and must not be mistaken for depth edges; pieces of one kind look alike; their reflections are view
//! dependent.

use crate::built::parts::materials::{diffuse, glossy, textured};
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, upright};
use crate::built::parts::textures::wood;
use crate::built::parts::{noise::Random, shapes};
use crate::{Mesh, Scene, Transform};

/// Side of a field, m.
const FIELD: f64 = 0.046;

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![
        wood("walnut", [0.050, 0.022, 0.010], [0.155, 0.070, 0.032], 8.0, 3.0),
        wood("maple", [0.50, 0.30, 0.14], [0.72, 0.50, 0.28], 8.0, 11.0),
        wood("table", [0.045, 0.028, 0.020], [0.115, 0.070, 0.045], 6.0, 21.0),
    ]);
    let walnut = studio.material("walnut", textured(0, glossy([1.0; 3], 0.35)));
    let maple = studio.material("maple", textured(1, glossy([1.0; 3], 0.35)));
    let table = studio.material("table", textured(2, glossy([1.0; 3], 0.4)));
    let boxwood = studio.material("boxwood", glossy([0.70, 0.46, 0.20], 0.22));
    let rosewood = studio.material("rosewood", glossy([0.085, 0.022, 0.012], 0.2));
    let felt = studio.material("felt", diffuse([0.055, 0.105, 0.115]));

    studio.add("table", rounded_box([0.99, 0.02, 0.74], 0.004), table, at(0.0, -0.032, 0.0));
    studio.add(
        "wall",
        shapes::sheet(1, 1, |s, t| glam::DVec3::new(s - 0.5, 0.42 - 0.48 * t, -0.36)),
        felt,
        at(0.0, 0.0, 0.0),
    );
    board(&mut studio, walnut, maple);

    let kinds = [pawn(), rook(), bishop(), queen(), king()];
    let meshes: Vec<[usize; 2]> = kinds
        .iter()
        .map(|mesh| {
            [("light", boxwood), ("dark", rosewood)].map(|(name, wood)| studio.add_mesh(name, mesh.clone(), wood))
        })
        .collect();
    // (kind, side, file, rank): white has the open file, black the passed pawn.
    let game = [
        (4, 0, 5, 0),
        (3, 0, 3, 3),
        (1, 0, 4, 1),
        (2, 0, 2, 2),
        (0, 0, 6, 1),
        (0, 0, 7, 2),
        (0, 0, 0, 1),
        (0, 0, 1, 2),
        (4, 1, 6, 7),
        (3, 1, 5, 5),
        (1, 1, 2, 7),
        (2, 1, 4, 4),
        (0, 1, 6, 6),
        (0, 1, 7, 5),
        (0, 1, 0, 5),
        (0, 1, 1, 4),
        (0, 1, 3, 5),
    ];
    let mut random = Random::new(77);
    for (kind, side, file, rank) in game {
        let (x, z) = ((f64::from(file) - 3.5) * FIELD, (3.5 - f64::from(rank)) * FIELD);
        // Pieces are not placed exactly in the center.
        let (dx, dz, turn) = (random.between(-0.003, 0.003), random.between(-0.003, 0.003), random.between(0.0, 360.0));
        studio.add_instance("piece", meshes[kind][side], turned_board().after(&upright([x + dx, 0.0, z + dz], turn)));
    }
    // Taken pieces beside the board.
    for (k, (x, z)) in [(-0.235, -0.215), (-0.205, -0.245), (-0.255, -0.255)].into_iter().enumerate() {
        studio.add_instance("taken", meshes[[0, 0, 2][k]][1], at(x, -0.022, z));
    }

    studio.room([0.16, 0.18, 0.22]);
    studio.softbox("window", [-0.95, 0.75, 0.25], [0.0, 0.0, 0.0], [0.7, 0.9], [1.5, 1.7, 2.0]);
    studio.spot("lamp", [0.62, 0.85, -0.35], [0.0, 0.0, 0.02], 34.0, [2.9, 2.2, 1.4]);
    studio.with_camera([0.105, 0.265, 0.575], [-0.002, 0.006, -0.012])
}

/// The rotated frame of the board.
fn turned_board() -> Transform {
    upright([0.0; 3], -24.0)
}

fn board(studio: &mut Studio, walnut: usize, maple: usize) {
    let rim = rounded_box([8.8 * FIELD, 0.02, 8.8 * FIELD], 0.003);
    studio.add("rim", rim, walnut, turned_board().after(&at(0.0, -0.0115, 0.0)));
    // One mesh per wood; every field has its own part of the grain.
    for (name, parity, material) in [("dark fields", 0, walnut), ("light fields", 1, maple)] {
        let mut fields = Mesh::default();
        for k in (0..64_u32).filter(|k| (k % 8 + k / 8) % 2 == parity) {
            let (file, rank) = (f64::from(k % 8), f64::from(k / 8));
            let (x, z) = ((file - 4.0) * FIELD, (3.0 - rank) * FIELD);
            let first = fields.positions.len() as u32;
            for (s, t) in [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)] {
                fields.positions.push([(x + s * FIELD) as f32, 0.0, (z + t * FIELD) as f32]);
                fields.texture_coordinates.push([((file + s) / 8.0) as f32, ((rank * 3.0 % 7.0 + t) / 8.0) as f32]);
            }
            fields.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        studio.add(name, fields, material, turned_board());
    }
}

/// The foot that all pieces share, up to the neck, for a base of the given radius; from the top downward.
fn foot(radius: f64, neck: f64, height: f64) -> Vec<[f64; 2]> {
    vec![
        [neck, height],
        [neck * 1.15, 0.55 * height],
        [radius * 0.62, 0.018],
        [radius * 0.70, 0.0155],
        [radius * 0.80, 0.015],
        [radius * 0.82, 0.0125],
        [radius * 0.72, 0.0115],
        [radius * 0.97, 0.0075],
        [radius, 0.0045],
        [radius * 0.97, 0.0004],
        [radius * 0.94, 0.0],
        [0.0, 0.0],
    ]
}

fn turned_piece(head: &[[f64; 2]], foot: Vec<[f64; 2]>) -> Mesh {
    let profile: Vec<[f64; 2]> = head.iter().copied().chain(foot).collect();
    lathe(48, 5, &profile)
}

fn pawn() -> Mesh {
    let head = [
        [0.0, 0.043],
        [0.005, 0.0422],
        [0.0078, 0.0385],
        [0.0082, 0.035],
        [0.0068, 0.031],
        [0.0052, 0.0295],
        [0.0096, 0.0285],
        [0.0096, 0.0272],
    ];
    turned_piece(&head, foot(0.0142, 0.0052, 0.0262))
}

fn rook() -> Mesh {
    let head = [
        [0.0, 0.046],
        [0.0062, 0.046],
        [0.0066, 0.0462],
        [0.0068, 0.050],
        [0.0072, 0.0503],
        [0.0098, 0.0503],
        [0.0102, 0.050],
        [0.0104, 0.041],
        [0.0098, 0.0395],
        [0.0074, 0.038],
    ];
    turned_piece(&head, foot(0.0156, 0.0074, 0.036))
}

fn bishop() -> Mesh {
    let head = [
        [0.0, 0.0655],
        [0.0022, 0.0648],
        [0.0024, 0.0625],
        [0.0014, 0.061],
        [0.005, 0.0565],
        [0.0082, 0.050],
        [0.0072, 0.045],
        [0.005, 0.0425],
        [0.0098, 0.0412],
        [0.0098, 0.0396],
        [0.0066, 0.0388],
    ];
    turned_piece(&head, foot(0.0156, 0.0054, 0.0375))
}

fn queen() -> Mesh {
    let head = [
        [0.0, 0.0775],
        [0.0026, 0.0765],
        [0.0028, 0.0742],
        [0.0016, 0.0728],
        [0.0072, 0.0712],
        [0.0098, 0.0722],
        [0.0106, 0.0716],
        [0.0084, 0.063],
        [0.0062, 0.056],
        [0.0056, 0.0535],
        [0.0108, 0.052],
        [0.0108, 0.0502],
        [0.0072, 0.049],
    ];
    turned_piece(&head, foot(0.0172, 0.006, 0.0475))
}

fn king() -> Mesh {
    let head = [
        [0.0, 0.091],
        [0.0016, 0.0908],
        [0.002, 0.0885],
        [0.0042, 0.0872],
        [0.0042, 0.0852],
        [0.002, 0.084],
        [0.0018, 0.0805],
        [0.0085, 0.0782],
        [0.0112, 0.0768],
        [0.009, 0.067],
        [0.0066, 0.0595],
        [0.006, 0.0568],
        [0.0114, 0.0552],
        [0.0114, 0.0533],
        [0.0076, 0.052],
    ];
    turned_piece(&head, foot(0.018, 0.0064, 0.0505))
}
