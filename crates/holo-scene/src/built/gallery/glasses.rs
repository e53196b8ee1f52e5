//! A wine glass, a tumbler, a prism and a crystal ball on striped linen.
//!
//! **Purpose**: clear glass, refraction and total internal reflection. **Difficulty**: the stripes are seen through
//! glass bent, upside down, mirrored and twice; the surface itself shows only in reflections; the prism deflects the
//! image without a mirror.

use glam::DVec3;

use crate::built::parts::materials::{clear_glass, diffuse, glossy, repeated, textured};
use crate::built::parts::shapes;
use crate::built::parts::solids::lathe;
use crate::built::parts::studio::{Studio, at, turned, upright};
use crate::built::parts::textures::{grained, striped_linen};
use crate::{Mesh, Scene, Transform};

pub(super) fn scene() -> Scene {
    let linen = [0.70, 0.66, 0.58];
    let mut studio = Studio::new(vec![
        striped_linen(&[
            (linen, 0.30),
            ([0.055, 0.12, 0.24], 0.22),
            (linen, 0.08),
            ([0.055, 0.12, 0.24], 0.04),
            (linen, 0.20),
            ([0.58, 0.17, 0.08], 0.06),
            (linen, 0.10),
        ]),
        grained("wall", [0.30, 0.335, 0.34], 0.22),
    ]);
    let cloth = studio.material("linen", repeated(0, [11.0, 11.0], diffuse([1.0; 3])));
    let wall = studio.material("wall", textured(1, diffuse([1.0; 3])));
    let glass = studio.material("glass", clear_glass());
    let peel = studio.material("lemon", glossy([0.80, 0.52, 0.045], 0.38));
    let wood = studio.material("frame", glossy([0.18, 0.085, 0.04], 0.35));

    let folds = |x: f64, z: f64| 0.0035 * ((x * 9.0 + 2.2 * z).sin() * (z * 5.0 + 0.4).cos()) - 0.0035;
    let sheet = shapes::sheet(120, 100, |s, t| {
        let (x, z) = (s - 0.5, 0.78 * t - 0.44);
        DVec3::new(x, folds(x, z), z)
    });
    studio.add("linen", sheet, cloth, Transform::IDENTITY);
    studio.add(
        "wall",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.55 - 0.58 * t, -0.43)),
        wall,
        Transform::IDENTITY,
    );
    // Slats on the wall: straight lines to be bent.
    for k in 0..9 {
        let x = 0.105 * (f64::from(k) - 4.0);
        studio.add(
            "slat",
            shapes::cuboid([x - 0.011, 0.0, -0.428], [x + 0.011, 0.5, -0.418]),
            wood,
            Transform::IDENTITY,
        );
    }

    let wine = wine_glass();
    studio.add("wine glass", wine, glass, at(-0.100, 0.0, -0.070));
    let tumbler = tumbler();
    studio.add("tumbler", tumbler, glass, at(0.128, 0.0, -0.085));
    studio.add(
        "ball",
        shapes::ball(256, 128, |_| 0.0),
        glass,
        Transform::from_parts([0.030, 0.0402, 0.012], [0.0, 0.0, 0.0, 1.0], [0.040; 3]),
    );
    studio.add("prism", prism(0.052, 0.098), glass, upright([-0.058, 0.0008, 0.078], 24.0));
    let lemon = lemon();
    studio.add("lemon", lemon.clone(), peel, turned([0.052, 0.0255, -0.165], [0.7, 0.0, 1.0], 82.0, 1.0));
    studio.add("lemon", lemon, peel, turned([-0.012, 0.0255, -0.215], [1.0, 0.3, 0.25], 97.0, 1.0));

    studio.room([0.24, 0.25, 0.26]);
    studio.softbox("window", [-0.95, 0.7, 0.05], [0.0, 0.05, -0.05], [0.6, 0.9], [4.4, 4.3, 4.1]);
    studio.softbox("strip", [0.95, 0.45, 0.35], [0.0, 0.08, -0.05], [0.2, 0.8], [3.2, 3.3, 3.6]);
    studio.with_camera([0.02, 0.215, 0.590], [0.012, 0.062, -0.045])
}

/// A wine glass.
fn wine_glass() -> Mesh {
    lathe(
        160,
        8,
        &[
            [0.0, 0.0935],
            [0.012, 0.0955],
            [0.027, 0.108],
            [0.0355, 0.131],
            [0.0345, 0.160],
            [0.0285, 0.1945],
            [0.0292, 0.1952],
            [0.0299, 0.1945],
            [0.0360, 0.160],
            [0.0371, 0.131],
            [0.0285, 0.1063],
            [0.0125, 0.0925],
            [0.0052, 0.083],
            [0.0038, 0.060],
            [0.0038, 0.030],
            [0.0065, 0.009],
            [0.0200, 0.0042],
            [0.0335, 0.0024],
            [0.0348, 0.0014],
            [0.0335, 0.0005],
            [0.0, 0.0005],
        ],
    )
}

/// A tumbler with a thick base.
fn tumbler() -> Mesh {
    lathe(
        160,
        8,
        &[
            [0.0, 0.0165],
            [0.024, 0.0175],
            [0.0285, 0.0215],
            [0.0335, 0.089],
            [0.0345, 0.0902],
            [0.0355, 0.089],
            [0.0312, 0.0055],
            [0.0285, 0.0012],
            [0.0265, 0.0006],
            [0.0, 0.0006],
        ],
    )
}

/// A lemon.
fn lemon() -> Mesh {
    lathe(
        96,
        6,
        &[
            [0.0, 0.041],
            [0.0035, 0.040],
            [0.0065, 0.0355],
            [0.0195, 0.026],
            [0.0262, 0.0],
            [0.0195, -0.026],
            [0.0058, -0.0365],
            [0.0, -0.0385],
        ],
    )
}

/// A right-angled prism that lies on its long face: side `leg`, length `length` along x.
fn prism(leg: f64, length: f64) -> Mesh {
    let (half, high) = (leg * 0.5_f64.sqrt(), leg * 0.5_f64.sqrt());
    let x = 0.5 * length;
    let point = |k: usize, x: f64| {
        let [y, z] = [[0.0, half], [0.0, -half], [high, 0.0]][k];
        [x as f32, y as f32, z as f32]
    };
    let mut mesh = Mesh::default();
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([point(a, -x), point(b, -x), point(b, x), point(a, x)]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    for (side, turn) in [(-x, [0, 2, 1]), (x, [0, 1, 2])] {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend((0..3).map(|k| point(k, side)));
        mesh.triangles.push(turn.map(|k: u32| k + first));
    }
    mesh
}
