//! A row of dominoes that winds from right before the lens to the far end of the table.
//!
//! **Purpose**: a large range of depths, the largest of the gallery. **Difficulty**: the same stone is seen from 30 cm
//! and from a meter, at disparities of both signs; the row occludes itself.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::built::parts::materials::{BRASS, diffuse, glossy, metal, repeated, textured};
use crate::built::parts::noise::{Random, fractal};
use crate::built::parts::patterns::{mix, paint};
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, upright};
use crate::built::parts::textures::grained;
use crate::{Scene, Texture, Transform, Wrap};

/// Size of a stone, m: width, height, thickness.
const STONE: [f64; 3] = [0.0235, 0.047, 0.0085];

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![parquet(), grained("wall", [0.26, 0.30, 0.275], 0.2)]);
    let floor = studio.material("parquet", repeated(0, [4.0, 4.0], glossy([1.0; 3], 0.28)));
    let wall = studio.material("wall", textured(1, diffuse([1.0; 3])));
    let colors: [[f32; 3]; 5] =
        [[0.70, 0.66, 0.56], [0.66, 0.13, 0.07], [0.78, 0.50, 0.11], [0.07, 0.25, 0.29], [0.045, 0.052, 0.065]];
    let lacquers = colors.map(|color| studio.material("lacquer", glossy(color, 0.16)));
    let light_pip = studio.material("pip", glossy([0.76, 0.73, 0.66], 0.3));
    let dark_pip = studio.material("dark pip", glossy([0.03, 0.03, 0.035], 0.3));
    let brass = studio.material("brass", metal(BRASS, 0.2));

    studio.add(
        "floor",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.0, 0.995 * t - 0.60)),
        floor,
        Transform::IDENTITY,
    );
    studio.add(
        "wall",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.42 - 0.42 * t, -0.60)),
        wall,
        Transform::IDENTITY,
    );
    studio.add("skirting", rounded_box([1.0, 0.042, 0.010], 0.003), lacquers[0], at(0.0, 0.021, -0.594));

    stones(&mut studio, lacquers, [dark_pip, light_pip]);
    bell(&mut studio, brass, lacquers[4]);
    for (x, z, size) in [(-0.19, -0.43, 0.034), (0.245, -0.29, 0.024), (-0.255, -0.20, 0.020)] {
        studio.add(
            "ball",
            shapes::ball(96, 48, |_| 0.0),
            lacquers[if size > 0.03 { 1 } else { 2 }],
            Transform::from_parts([x, size, z], [0.0, 0.0, 0.0, 1.0], [size; 3]),
        );
    }

    studio.room([0.17, 0.175, 0.18]);
    studio.softbox("window", [-0.95, 0.70, -0.15], [0.0, 0.0, -0.15], [0.30, 0.55], [11.0, 10.0, 8.4]);
    studio.softbox("fill", [0.8, 0.9, 0.9], [0.0, 0.0, 0.0], [0.6, 0.6], [1.2, 1.35, 1.6]);
    studio.with_camera([0.035, 0.160, 0.555], [0.0, 0.010, -0.02])
}

/// The row of stones with their pips.
fn stones(studio: &mut Studio, lacquers: [usize; 5], inks: [usize; 2]) {
    let bodies = lacquers.map(|lacquer| studio.add_mesh("stone", rounded_box(STONE, 0.0016), lacquer));
    let pip = shapes::ball(20, 10, |_| 0.0);
    let pips = inks.map(|material| studio.add_mesh("pip", pip.clone(), material));
    let bar = inks.map(|material| studio.add_mesh("bar", rounded_box([0.017, 0.0008, 0.0004], 0.00015), material));
    let mut random = Random::new(13);
    let count = 58;
    for k in 0_u32..count {
        let s = f64::from(k) / f64::from(count - 1);
        let path = |s: f64| {
            let z = 0.268 - 0.77 * s;
            DVec3::new(0.165 * (0.15 + 0.85 * s.sqrt()) * (s * 2.35 * TAU - 1.0).sin() - 0.02 * (1.0 - s), 0.0, z)
        };
        let ahead = path(s + 1e-3) - path(s - 1e-3);
        let heading = ahead.x.atan2(ahead.z).to_degrees() + random.between(-2.5, 2.5);
        // Stones of one color form runs.
        let color = [0, 0, 0, 1, 2, 2, 3, 3, 3, 4, 1][k as usize % 11];
        let place = path(s);
        let pose = upright([place.x, 0.5 * STONE[1], place.z], heading);
        studio.add_instance("stone", bodies[color], pose);
        let ink = usize::from(matches!(color, 1 | 3 | 4));
        for face in [-1.0, 1.0] {
            let side = pose.after(&upright([0.0; 3], if face > 0.0 { 0.0 } else { 180.0 })).after(&at(
                0.0,
                0.0,
                0.5 * STONE[2],
            ));
            studio.add_instance("bar", bar[ink], side);
            for half in [-1.0, 1.0] {
                let value = (random.unit() * 7.0) as usize % 7;
                for &(x, y) in spots(value) {
                    let place = [x * 0.0062, half * 0.0118 + y * 0.0062, 0.0];
                    studio.add_instance(
                        "pip",
                        pips[ink],
                        side.after(&Transform::from_parts(place, [0.0, 0.0, 0.0, 1.0], [0.0019, 0.0019, 0.0003])),
                    );
                }
            }
        }
    }
}

/// The bell at the far end.
fn bell(studio: &mut Studio, brass: usize, lacquer: usize) {
    let bell = lathe(
        96,
        7,
        &[
            [0.0, 0.064],
            [0.0035, 0.0635],
            [0.0045, 0.060],
            [0.003, 0.057],
            [0.014, 0.054],
            [0.024, 0.043],
            [0.030, 0.024],
            [0.037, 0.012],
            [0.038, 0.009],
            [0.036, 0.008],
            [0.0, 0.020],
        ],
    );
    studio.add("bell", bell, brass, at(0.145, 0.0, -0.535));
    studio.add(
        "foot",
        lathe(64, 4, &[[0.0, 0.009], [0.040, 0.009], [0.042, 0.006], [0.042, 0.0], [0.0, 0.0]]),
        lacquer,
        at(0.145, 0.0, -0.535),
    );
}

/// The positions of the pips of a value on a grid of three by three.
fn spots(value: usize) -> &'static [(f64, f64)] {
    const SIX: [(f64, f64); 6] = [(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, 0.0), (1.0, 0.0)];
    const FIVE: [(f64, f64); 5] = [(0.0, 0.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)];
    match value {
        0 => &[],
        1 | 3 | 5 => &FIVE[..value],
        _ => &SIX[..value],
    }
}

/// A parquet of oak blocks; periodic.
fn parquet() -> Texture {
    let mut random = Random::new(83);
    let tones: Vec<f64> = (0..16).map(|_| random.between(0.72, 1.18)).collect();
    paint("parquet", 768, Wrap::Repeat, |x, y| {
        // Squares of four staves, standing and lying by turns.
        let (column, row) = ((x * 2.0).floor(), (y * 2.0).floor());
        let (u, v) = ((x * 2.0).fract(), (y * 2.0).fract());
        let standing = (column as i64 + row as i64) % 2 == 0;
        let (across, along) = if standing { (u, v) } else { (v, u) };
        let stave = (across * 4.0).floor();
        let own = stave + 4.0 * (column + 2.0 * row);
        let gap = (across * 4.0).fract().min(1.0 - (across * 4.0).fract()) < 0.03 || along.min(1.0 - along) < 0.0075;
        let grain = fractal([across * 60.0, along * 2.5, own * 3.1], 3);
        let color = mix([0.36, 0.205, 0.105], [0.20, 0.100, 0.048], (0.45 + 0.55 * grain).clamp(0.0, 1.0));
        let tone = tones[own as usize % 16] * if gap { 0.4 } else { 1.0 };
        color.map(|c| c * tone)
    })
}
