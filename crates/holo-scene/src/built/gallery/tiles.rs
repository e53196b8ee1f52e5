//! A tiled corner: the same painted tile everywhere, with bowls and lemons on the ledge.
//!
//! **Purpose**: repetitive texture. **Difficulty**: every tile equals its neighbors exactly, on the wall, the ledge and
//! the floor, so that a match is right only up to a whole tile; the glaze mirrors the window.

use glam::DVec3;

use crate::built::parts::materials::{glossy, normal_mapped, repeated};
use crate::built::parts::noise::fractal;
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, turned};
use crate::built::parts::textures::{azulejo, peel};
use crate::{Mesh, Scene, Transform};

/// Side of a tile, m.
const TILE: f64 = 0.07;

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![azulejo(), peel()]);
    let tile = studio.material("tile", repeated(0, [1.0, 1.0], glossy([1.0; 3], 0.14)));
    let terracotta = studio.material("terracotta", glossy([0.47, 0.20, 0.115], 0.55));
    let white = studio.material("white glaze", glossy([0.76, 0.75, 0.71], 0.10));
    let blue = studio.material("blue glaze", glossy([0.035, 0.095, 0.29], 0.10));
    let lemon = studio.material("lemon", normal_mapped(1, [1.6, 1.0], 1.2, glossy([0.82, 0.53, 0.03], 0.34)));
    let leaf = studio.material("leaf", glossy([0.055, 0.155, 0.04], 0.35));

    corner(&mut studio, tile, terracotta);

    let bowl = bowl();
    let jug = jug();
    studio.add("bowl", bowl.clone(), white, at(-0.005, 0.0, 0.025));
    studio.add("bowl", bowl, blue, at(-0.155, 0.105, -0.205));
    studio.add("jug", jug, white, at(0.145, 0.105, -0.205));
    let handle = shapes::tube(
        64,
        20,
        |s| 0.0052 + 0.0012 * (s - 0.5).abs(),
        |s| {
            let angle = (s - 0.5) * 3.3;
            DVec3::new(0.036 + 0.034 * angle.cos(), 0.082 - 0.040 * angle.sin(), 0.0)
        },
    );
    studio.add("handle", handle, white, turned([0.130, 0.105, -0.205], [0.0, 1.0, 0.0], -24.0, 1.0));
    let fruit = fruit();
    let lemons = [
        ([-0.028, 0.040, 0.018], [0.2, 1.0, 0.9], 75.0),
        ([0.026, 0.041, 0.030], [1.0, 0.2, 0.3], 98.0),
        ([-0.002, 0.075, 0.020], [0.5, 0.1, 1.0], 80.0),
        ([0.118, 0.0262, 0.052], [1.0, 0.0, 0.4], 88.0),
        ([-0.155, 0.150, -0.205], [0.4, 0.2, 1.0], 70.0),
    ];
    for (place, axis, turn) in lemons {
        studio.add("lemon", fruit.clone(), lemon, turned(place, axis, turn, 1.0));
    }
    for (place, axis, turn) in
        [([0.101, 0.026, 0.027], [0.2, 1.0, 0.4], 60.0), ([0.018, 0.078, 0.045], [0.1, 1.0, 0.2], -40.0)]
    {
        studio.add("leaf", curled_leaf(), leaf, turned(place, axis, turn, 0.05));
    }

    studio.room([0.20, 0.21, 0.225]);
    studio.softbox("window", [0.95, 0.75, 0.45], [0.0, 0.05, -0.1], [0.45, 0.60], [6.6, 6.2, 5.5]);
    studio.with_camera([0.060, 0.250, 0.600], [0.000, 0.097, -0.085])
}

/// The walls, the ledge and the floor, with whole tiles from the corner on.
fn corner(studio: &mut Studio, tile: usize, terracotta: usize) {
    studio.add(
        "back wall",
        tiled([-0.42, 0.56, -0.28], [0.0, 0.0], [0.91, 0.0, 0.0], [0.0, -0.56, 0.0]),
        tile,
        Transform::IDENTITY,
    );
    studio.add(
        "side wall",
        tiled([-0.42, 0.56, 0.35], [9.0, 0.0], [0.0, 0.0, -0.63], [0.0, -0.56, 0.0]),
        tile,
        Transform::IDENTITY,
    );
    studio.add(
        "ledge",
        tiled([-0.42, 0.105, -0.28], [0.0, 0.0], [0.91, 0.0, 0.0], [0.0, 0.0, 0.14]),
        tile,
        Transform::IDENTITY,
    );
    studio.add(
        "ledge front",
        tiled([-0.42, 0.105, -0.14], [0.0, 0.5], [0.91, 0.0, 0.0], [0.0, -0.105, 0.0]),
        tile,
        Transform::IDENTITY,
    );
    studio.add("nosing", rounded_box([0.91, 0.012, 0.014], 0.005), terracotta, at(0.035, 0.1010, -0.139));
    studio.add(
        "floor",
        tiled([-0.42, 0.0, -0.14], [0.0, 0.0], [0.91, 0.0, 0.0], [0.0, 0.0, 0.49]),
        tile,
        Transform::IDENTITY,
    );
}

/// The bowls.
fn bowl() -> Mesh {
    lathe(
        128,
        7,
        &[
            [0.0, 0.010],
            [0.022, 0.0125],
            [0.050, 0.034],
            [0.0610, 0.0600],
            [0.0625, 0.0612],
            [0.0640, 0.0600],
            [0.0535, 0.032],
            [0.0250, 0.0085],
            [0.0235, 0.0],
            [0.0205, 0.0],
            [0.019, 0.003],
            [0.0, 0.003],
        ],
    )
}

/// The body of the jug.
fn jug() -> Mesh {
    lathe(
        128,
        7,
        &[
            [0.0, 0.006],
            [0.028, 0.008],
            [0.043, 0.045],
            [0.036, 0.085],
            [0.0225, 0.112],
            [0.0265, 0.136],
            [0.0282, 0.1372],
            [0.0298, 0.136],
            [0.0258, 0.112],
            [0.0395, 0.085],
            [0.0465, 0.045],
            [0.0335, 0.003],
            [0.031, 0.0],
            [0.0, 0.0],
        ],
    )
}

/// A rectangle from `corner` along `across` and `down`; a texture coordinate is a tile.
fn tiled(corner: [f64; 3], start: [f64; 2], across: [f64; 3], down: [f64; 3]) -> Mesh {
    let [corner, across, down] = [corner, across, down].map(DVec3::from);
    let mut mesh = shapes::sheet(1, 1, |s, t| corner + across * s + down * t);
    let tiles = [across.length() / TILE, down.length() / TILE];
    for coordinates in &mut mesh.texture_coordinates {
        let [s, t] = coordinates.map(f64::from);
        *coordinates = [(start[0] + s * tiles[0]) as f32, (start[1] + t * tiles[1]) as f32];
    }
    mesh
}

fn fruit() -> Mesh {
    let mut mesh = lathe(
        96,
        8,
        &[
            [0.0, 0.0425],
            [0.0032, 0.0418],
            [0.0060, 0.0375],
            [0.0155, 0.0305],
            [0.0245, 0.0140],
            [0.0258, 0.0],
            [0.0235, -0.0160],
            [0.0140, -0.0300],
            [0.0052, -0.0350],
            [0.0, -0.0358],
        ],
    );
    for p in &mut mesh.positions {
        let bump = 1.0 + 0.03 * fractal(p.map(|x| f64::from(x) * 60.0), 2) as f32;
        *p = [p[0] * bump, p[1], p[2] * bump];
    }
    mesh
}

/// A pointed leaf of length 1 along +X, curled.
fn curled_leaf() -> Mesh {
    shapes::sheet(24, 8, |s, t| {
        let side = 2.0 * t - 1.0;
        let half = 0.22 * (std::f64::consts::PI * (0.02 + 0.96 * s)).sin().powf(0.8);
        DVec3::new(s, 0.10 * (s * 3.0).sin() + 0.12 * side.abs() * half, side * half)
    })
}
