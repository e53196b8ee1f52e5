//! The plaster solids of a drawing class on a sheet of paper: a cone, a ball, a cylinder, a block, an egg.
//!
//! **Purpose**: surfaces without any texture. **Difficulty**: depth follows only from shading, soft shadows and
//! outlines; the seamless background has no feature at all.

use glam::DVec3;

use crate::built::parts::materials::diffuse;
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, turned, upright};
use crate::{Scene, Transform};

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(Vec::new());
    let plaster = studio.material("plaster", diffuse([0.76, 0.745, 0.715]));
    let paper = studio.material("paper", diffuse([0.60, 0.595, 0.585]));

    // A sheet with a horizontal, a curved and a vertical part.
    let sweep = shapes::sheet(1, 96, |s, t| {
        let way = 1.25 * (1.0 - t);
        let (flat, radius) = (0.55, 0.2);
        let turn = ((way - flat) / radius).clamp(0.0, std::f64::consts::FRAC_PI_2);
        let up = (way - flat - radius * std::f64::consts::FRAC_PI_2).max(0.0);
        let y = radius * (1.0 - turn.cos()) + up;
        let z = 0.33 - way.min(flat) - radius * turn.sin();
        DVec3::new(s - 0.5, y, z)
    });
    studio.add("paper", sweep, paper, Transform::IDENTITY);

    let cone = lathe(128, 6, &[[0.0, 0.205], [0.0015, 0.2045], [0.062, 0.002], [0.0605, 0.0], [0.0, 0.0]]);
    studio.add("cone", cone, plaster, at(-0.085, 0.0, -0.085));
    let cylinder =
        lathe(128, 6, &[[0.0, 0.135], [0.040, 0.135], [0.0415, 0.1335], [0.0415, 0.0015], [0.040, 0.0], [0.0, 0.0]]);
    studio.add("cylinder", cylinder, plaster, at(0.072, 0.0, -0.175));
    studio.add("block", rounded_box([0.085, 0.085, 0.085], 0.0016), plaster, upright([0.052, 0.0425, -0.035], 31.0));
    studio.add(
        "ball",
        shapes::ball(192, 96, |_| 0.0),
        plaster,
        turned([0.155, 0.045, -0.005], [0.0, 1.0, 0.0], 0.0, 0.045),
    );
    let egg = lathe(
        128,
        10,
        &[
            [0.0, 0.060],
            [0.0105, 0.0565],
            [0.0188, 0.046],
            [0.0225, 0.031],
            [0.0195, 0.0145],
            [0.0105, 0.003],
            [0.0, 0.0],
        ],
    );
    studio.add("egg", egg, plaster, turned([-0.052, 0.0222, 0.085], [0.35, 0.0, 1.0], 86.0, 1.0));
    let pyramid = lathe(4, 2, &[[0.0, 0.092], [0.0012, 0.091], [0.058, 0.001], [0.057, 0.0], [0.0, 0.0]]);
    studio.add("pyramid", flat(pyramid), plaster, upright([-0.182, 0.0, 0.012], 20.0));
    let ring = shapes::tube(
        256,
        64,
        |_| 0.0135,
        |s| {
            let angle = s * std::f64::consts::TAU;
            DVec3::new(0.038 * angle.cos(), 0.0, 0.038 * angle.sin())
        },
    );
    studio.add("ring", ring, plaster, turned([0.062, 0.0135, 0.098], [0.0, 1.0, 0.0], 0.0, 1.0));

    studio.room([0.055, 0.06, 0.07]);
    studio.softbox("window", [-0.95, 0.70, 0.20], [0.0, 0.03, -0.05], [0.42, 0.5], [9.0, 8.4, 7.5]);
    studio.with_camera([-0.02, 0.255, 0.66], [-0.010, 0.070, -0.05])
}

/// Without smooth normals.
fn flat(mesh: crate::Mesh) -> crate::Mesh {
    crate::Mesh { normals: Vec::new(), ..mesh }
}
