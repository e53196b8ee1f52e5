//! A still life after the Dutch: oranges in a pewter bowl, pears, a carafe, a knife, a cloth that hangs in folds.
//!
//! **Purpose**: all materials together, as a check of methods that are tuned on one of them: gloss, metal, glass, fine
//! relief, cloth, soft shadow, a dark background. **Difficulty**: the carafe is in front of the bowl; the cloth has few
//! features on its folds.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::built::parts::materials::{
    STEEL, body_of_glass, diffuse, glossy, metal, normal_mapped, repeated, roughness_mapped, textured,
};
use crate::built::parts::noise::{Random, fractal};
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, turned};
use crate::built::parts::textures::{brushed, checked_linen, grained, peel, wood};
use crate::{Mesh, Scene, Transform};

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![
        checked_linen([0.74, 0.71, 0.64], [0.10, 0.20, 0.31]),
        wood("table", [0.060, 0.032, 0.018], [0.185, 0.105, 0.060], 4.0, 91.0),
        peel(),
        brushed(0.45, 0.18),
        grained("wall", [0.085, 0.072, 0.058], 0.18),
    ]);
    let linen = studio.material("linen", repeated(0, [9.0, 9.0], diffuse([1.0; 3])));
    let table = studio.material("table", textured(1, glossy([1.0; 3], 0.3)));
    let orange = studio.material("orange", normal_mapped(2, [2.0, 1.0], 1.0, glossy([0.86, 0.30, 0.015], 0.36)));
    let pear = studio.material("pear", glossy([1.0; 3], 0.4));
    let pewter = studio.material("pewter", roughness_mapped(3, [4.0, 1.0], metal([0.60, 0.58, 0.55], 0.75)));
    let wall = studio.material("wall", textured(4, diffuse([1.0; 3])));
    let glass = studio.material("glass", body_of_glass(0.05, [0.80, 0.93, 0.88]));
    let steel = studio.material("blade", metal(STEEL, 0.14));
    let horn = studio.material("horn", glossy([0.075, 0.038, 0.020], 0.15));
    let walnut = studio.material("walnut", diffuse([0.40, 0.245, 0.125]));
    let leaf = studio.material("leaf", glossy([0.060, 0.150, 0.040], 0.35));
    let stalk = studio.material("stalk", diffuse([0.12, 0.075, 0.04]));

    studio.add(
        "wall",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.50 - 0.62 * t, -0.40)),
        wall,
        Transform::IDENTITY,
    );
    studio.add("table", rounded_box([0.98, 0.028, 0.62], 0.006), table, at(0.0, -0.0145, -0.10));
    studio.add("cloth", cloth(), linen, Transform::IDENTITY);

    let bowl = bowl();
    let bowl_at = [0.060, 0.0045, -0.105];
    studio.add("bowl", bowl, pewter, Transform::from_translation(bowl_at));
    oranges(&mut studio, orange, stalk);
    pears(&mut studio, pear, stalk, leaf);
    let carafe = carafe();
    studio.add("carafe", carafe, glass, at(-0.075, 0.0050, -0.150));
    let walnut_shape = shapes::ball(64, 32, |d| {
        0.10 * fractal((d * 3.4).to_array(), 3).abs() + 0.05 * (1.0 - d.z.abs() * 12.0).max(0.0) + 0.10 * d.y.powi(8)
    });
    let nut = studio.add_mesh("walnut", walnut_shape, walnut);
    for (x, z, turn) in [(0.085, 0.065, 40.0), (0.060, 0.088, 130.0), (-0.195, 0.055, 250.0)] {
        studio.add_instance("walnut", nut, turned([x, 0.0185, z], [0.5, 1.0, 0.7], turn, 0.0155));
    }
    // The knife lies over the edge of the cloth.
    let knife = turned([-0.040, 0.0105, 0.112], [0.0, 1.0, 0.0], 24.0, 1.0);
    studio.add("blade", blade(), steel, knife);
    studio.add("handle", rounded_box([0.088, 0.0115, 0.0155], 0.005), horn, knife.after(&at(-0.052, 0.0, 0.0)));

    studio.room([0.105, 0.105, 0.11]);
    studio.softbox("window", [-0.95, 0.65, 0.30], [0.0, 0.05, -0.08], [0.42, 0.62], [8.4, 7.8, 6.8]);
    studio.softbox("strip", [0.95, 0.5, -0.2], [0.0, 0.08, -0.1], [0.14, 0.7], [2.2, 2.5, 3.0]);
    studio.with_camera([-0.015, 0.235, 0.615], [-0.004, 0.078, -0.06])
}

/// The bowl.
fn bowl() -> Mesh {
    lathe(
        160,
        7,
        &[
            [0.0, 0.020],
            [0.040, 0.022],
            [0.075, 0.040],
            [0.098, 0.0625],
            [0.1000, 0.0640],
            [0.1020, 0.0625],
            [0.079, 0.038],
            [0.047, 0.0185],
            [0.030, 0.015],
            [0.0285, 0.010],
            [0.044, 0.003],
            [0.045, 0.0],
            [0.0, 0.0],
        ],
    )
}

/// Oranges in the bowl and on the cloth.
fn oranges(studio: &mut Studio, orange: usize, stalk: usize) {
    let ball = studio.add_mesh(
        "orange",
        shapes::ball(128, 64, |d| 0.03 * fractal((d * 1.3).to_array(), 2) - 0.05 * d.y.abs().powi(8)),
        orange,
    );
    for (x, y, z, size, turn) in [
        (0.020, 0.063, -0.085, 0.0375, 10.0),
        (0.100, 0.062, -0.075, 0.0365, 120.0),
        (0.062, 0.064, -0.150, 0.0380, 220.0),
        (0.058, 0.112, -0.105, 0.0370, 300.0),
        (-0.062, 0.041, 0.020, 0.0365, 60.0),
    ] {
        studio.add_instance("orange", ball, turned([x, y, z], [0.4, 1.0, 0.3], turn, size));
        let navel = turned([x, y, z], [0.4, 1.0, 0.3], turn, size).point([0.0, 0.965, 0.0]);
        studio.add(
            "navel",
            shapes::ball(16, 8, |_| 0.0),
            stalk,
            Transform::from_parts(navel, [0.0, 0.0, 0.0, 1.0], [0.0022; 3]),
        );
    }
}

/// Pears with stalks, and leaves of the oranges.
fn pears(studio: &mut Studio, pear: usize, stalk: usize, leaf: usize) {
    let pears = pear_body();
    for (place, axis, turn) in
        [([-0.145, 0.0055, -0.045], [0.1, 1.0, 0.05], 20.0), ([0.155, 0.0365, 0.050], [0.55, 0.2, 1.0], 84.0)]
    {
        let pose = turned(place, axis, turn, 1.0);
        studio.add("pear", pears.clone(), pear, pose);
        studio.add(
            "stalk",
            shapes::tube(12, 8, |s| 0.0012 + 0.0005 * s, |s| DVec3::new(0.004 * s * s, 0.097 + 0.022 * s, 0.0)),
            stalk,
            pose,
        );
    }
    for (x, y, z, turn) in [(0.092, 0.132, -0.090, 30.0), (0.020, 0.098, -0.062, 200.0)] {
        studio.add("leaf", leaf_shape(), leaf, turned([x, y - 0.006, z], [0.15, 1.0, 0.2], turn, 0.052));
    }
}

/// The carafe.
fn carafe() -> Mesh {
    lathe(
        144,
        8,
        &[
            [0.0, 0.010],
            [0.030, 0.012],
            [0.0445, 0.036],
            [0.0395, 0.070],
            [0.0185, 0.112],
            [0.0125, 0.145],
            [0.0155, 0.184],
            [0.0192, 0.200],
            [0.0204, 0.2008],
            [0.0216, 0.200],
            [0.0182, 0.184],
            [0.0152, 0.145],
            [0.0212, 0.1125],
            [0.0423, 0.071],
            [0.0475, 0.036],
            [0.0340, 0.0045],
            [0.031, 0.0008],
            [0.0, 0.0008],
        ],
    )
}

/// A cloth over half of the table, its near edge hanging down.
fn cloth() -> Mesh {
    shapes::sheet(180, 160, |s, t| {
        let (x, way) = (0.74 * s - 0.355, 0.60 * t);
        let wave = 0.0035 * fractal([x * 9.0, way * 8.0, 3.0], 2);
        let (front, radius) = (0.44, 0.020);
        let z = -0.235 + way.min(front) + radius * (((way - front) / radius).clamp(0.0, 1.5)).sin();
        let drop = (way - front - 1.4 * radius).max(0.0);
        let bend = radius * (1.0 - ((way - front) / radius).clamp(0.0, 1.5).cos());
        let fold = 0.016 * (drop / 0.1).min(1.0) * (x * 44.0 + 1.5 * (x * 9.0).sin()).sin();
        DVec3::new(x + 0.05 * (t - 0.5) * 0.4, 0.0045 + wave - bend - drop, z + fold)
    })
}

/// A pear of 10 cm about +Y, green to red on one cheek, speckled; its foot on the ground.
fn pear_body() -> Mesh {
    let mut mesh = lathe(
        96,
        8,
        &[
            [0.0, 0.0985],
            [0.0055, 0.0995],
            [0.0125, 0.0945],
            [0.0165, 0.080],
            [0.0230, 0.062],
            [0.0345, 0.040],
            [0.0362, 0.027],
            [0.0290, 0.009],
            [0.0140, 0.0005],
            [0.0065, 0.002],
            [0.0, 0.0045],
        ],
    );
    for p in &mut mesh.positions {
        let lean = 0.004 * (f64::from(p[1]) * 30.0).sin() as f32;
        *p = [p[0] + lean, p[1], p[2] * 0.97];
    }
    let mut random = Random::new(7);
    mesh.colors = mesh
        .positions
        .iter()
        .map(|p| {
            let at = p.map(|x| f64::from(x) * 36.0);
            let red = (0.5 + 14.0 * f64::from(p[2]) + 8.0 * f64::from(p[0]) + 0.5 * fractal(at, 3)).clamp(0.0, 1.0);
            let speck = 1.0 - 0.10 * random.unit();
            let color = [0.50 + 0.14 * red, 0.46 - 0.24 * red, 0.085 - 0.02 * red];
            let [r, g, b] = color.map(|c| (c * speck) as f32);
            [r, g, b, 1.0]
        })
        .collect();
    mesh
}

/// A leaf of length 1 along +X, folded along its rib.
fn leaf_shape() -> Mesh {
    shapes::sheet(24, 8, |s, t| {
        let side = 2.0 * t - 1.0;
        let half = 0.24 * (0.5 * TAU * (0.02 + 0.96 * s)).sin().powf(0.8);
        DVec3::new(s, 0.12 * (s * 2.6).sin() + 0.25 * side.abs() * half, side * half)
    })
}

/// A blade of 11 cm along +X that narrows to its point: two faces that meet in the edge.
fn blade() -> Mesh {
    shapes::sheet(48, 8, |s, t| {
        let back = 0.0085;
        let edge = -0.0085 * (1.0 - s.powi(4)) + back * s.powi(4);
        let across = if t < 0.5 { 2.0 * t } else { 2.0 - 2.0 * t };
        let thick = 0.0011 * (1.0 - across) * if t < 0.5 { 1.0 } else { -1.0 } * (1.0 - 0.8 * s);
        DVec3::new(-0.012 + 0.118 * s, thick, back + (edge - back) * across)
    })
}
