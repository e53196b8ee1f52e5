//! A paper theatre: ranges of mountains cut from card, one behind the other, and a leporello of pictures in front.
//!
//! **Purpose**: slanted and layered planes. **Difficulty**: the layers are some centimeters apart and cast shadows on
//! each other; the pages of the leporello meet in sharp folds and slant both ways.

use glam::DVec3;

use crate::built::parts::materials::{diffuse, glossy, textured};
use crate::built::parts::noise::fractal;
use crate::built::parts::patterns::{mix, paint};
use crate::built::parts::shapes;
use crate::built::parts::studio::{Studio, at, turned, upright};
use crate::built::parts::textures::{grained, wood};
use crate::{Mesh, Scene, Texture, Transform, Wrap};

/// Pages of the leporello.
const PAGES: u32 = 7;

pub(super) fn scene() -> Scene {
    let layers = [
        ([0.55, 0.57, 0.56], 0.205, 0.055),
        ([0.36, 0.47, 0.50], 0.165, 0.060),
        ([0.185, 0.345, 0.38], 0.128, 0.055),
        ([0.075, 0.215, 0.245], 0.092, 0.045),
        ([0.030, 0.115, 0.135], 0.060, 0.035),
    ];
    let mut textures = vec![
        grained("sky", [0.82, 0.60, 0.42], 0.07),
        wood("table", [0.11, 0.06, 0.035], [0.27, 0.16, 0.095], 5.0, 61.0),
        pages(),
    ];
    textures.extend(layers.iter().map(|(color, _, _)| grained("card", *color, 0.26)));
    let mut studio = Studio::new(textures);
    let sky = studio.material("sky", textured(0, diffuse([1.0; 3])));
    let table = studio.material("table", textured(1, glossy([1.0; 3], 0.35)));
    let pages = studio.material("pictures", textured(2, diffuse([1.0; 3])));
    let sun = studio.material("sun", diffuse([0.86, 0.30, 0.13]));
    let white = studio.material("paper", diffuse([0.82, 0.80, 0.75]));

    studio.add(
        "table",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.0, 0.80 * t - 0.48)),
        table,
        Transform::IDENTITY,
    );
    studio.add(
        "sky",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.46 - 0.48 * t, -0.44)),
        sky,
        Transform::IDENTITY,
    );
    let disc = shapes::sheet(96, 1, |s, t| {
        let (angle, radius) = (-s * std::f64::consts::TAU, 0.058 * (0.001 + 0.999 * t));
        DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
    });
    studio.add("sun", disc, sun, at(0.105, 0.232, -0.415));
    for (k, (_, height, normal_map_of)) in layers.into_iter().enumerate() {
        let seed = 3.7 * k as f64;
        let card = studio.material("card", textured(3 + k, diffuse([1.0; 3])));
        let ridge = move |x: f64| {
            let peaks = 1.0 - 1.7 * fractal([x * (5.0 + 0.8 * k as f64) + seed, 0.5, seed], 2).abs();
            height + normal_map_of * (peaks - 0.35) + 0.10 * normal_map_of * fractal([x * 70.0, 1.5, seed], 2)
        };
        let depth = -0.385 + 0.068 * k as f64;
        let mesh = shapes::sheet(500, 4, |s, t| DVec3::new(s - 0.5, ridge(s - 0.5) * (1.0 - t), 0.0));
        studio.add(
            "range",
            mesh,
            card,
            turned([0.0, 0.0, depth], [0.0, 1.0, 0.0], [2.0, -3.0, 2.5, -1.5, 3.0][k], 0.985),
        );
    }
    // Birds over the ranges.
    for (x, y, z, size) in [
        (-0.10, 0.215, -0.30, 0.012),
        (-0.072, 0.232, -0.29, 0.010),
        (-0.135, 0.228, -0.31, 0.009),
        (-0.09, 0.25, -0.32, 0.008),
    ] {
        studio.add("gull", gull(), white, turned([x, y, z], [0.2, 0.6, 0.1], 25.0, size));
    }
    // The zigzag stands on the table, open towards the camera.
    studio.add("leporello", leporello(), pages, upright([0.005, 0.0005, 0.020], 9.0));

    studio.room([0.15, 0.16, 0.18]);
    studio.softbox("key", [-0.90, 0.85, 0.35], [0.0, 0.08, -0.15], [0.20, 0.22], [30.0, 27.0, 22.5]);
    studio.with_camera([-0.075, 0.215, 0.575], [-0.002, 0.104, -0.12])
}

fn gull() -> Mesh {
    let positions = vec![
        [0.0, 0.0, 0.0],
        [-0.5, 0.35, 0.0],
        [-1.2, 0.15, 0.1],
        [0.5, 0.35, 0.0],
        [1.2, 0.15, 0.1],
        [0.0, 0.12, -0.25],
    ];
    Mesh { positions, triangles: vec![[0, 5, 1], [1, 5, 2], [0, 3, 5], [3, 4, 5]], ..Mesh::default() }
}

/// Folded paper: every page a slanted plane, the next slants the other way.
fn leporello() -> Mesh {
    let (wide, high, open) = (0.060, 0.074, 0.62_f64);
    let mut mesh = Mesh::default();
    let fold = |k: u32| {
        let x = (f64::from(k) - 0.5 * f64::from(PAGES)) * wide * open.cos();
        let z = if k.is_multiple_of(2) { -0.5 } else { 0.5 } * wide * open.sin();
        [x, z]
    };
    for k in 0..PAGES {
        let first = mesh.positions.len() as u32;
        for (fold, u) in [(fold(k), f64::from(k)), (fold(k + 1), f64::from(k + 1))] {
            for (y, v) in [(high, 0.0), (0.0, 1.0)] {
                mesh.positions.push([fold[0] as f32, y as f32, fold[1] as f32]);
                mesh.texture_coordinates.push([(u / f64::from(PAGES)) as f32, v]);
            }
        }
        mesh.triangles.extend([[first, first + 1, first + 3], [first, first + 3, first + 2]]);
    }
    mesh
}

/// A strip of woodcuts, one a page: waves, a moon, reeds, rain, a hill, a sail, a fish's scales.
fn pages() -> Texture {
    paint("pictures", 1024, Wrap::Clamp, |x, y| {
        let page = (x * f64::from(PAGES)).floor();
        let (u, v) = (x * f64::from(PAGES) - page, y);
        let (ivory, ink, red, sea, sand) =
            ([0.80, 0.76, 0.66], [0.035, 0.06, 0.09], [0.62, 0.12, 0.07], [0.10, 0.32, 0.38], [0.68, 0.50, 0.27]);
        let fiber = 1.0 + 0.05 * fractal([x * 300.0, y * 60.0, 2.0], 2);
        let frame = u.min(1.0 - u) < 0.08 || v.min(1.0 - v) < 0.07;
        let wave = |rows: f64| {
            ((v * rows + 0.5 * (u * 9.0 + (v * rows).floor() * 1.9).sin() * 0.55) * std::f64::consts::TAU).sin()
        };
        let drawing = match page as u32 {
            0 => {
                if v > 0.45 {
                    if wave(9.0) > 0.1 { sea } else { ivory }
                } else {
                    mix(sand, ivory, v * 2.0)
                }
            }
            1 => {
                if (u - 0.55).hypot((v - 0.38) * 1.2) < 0.24 {
                    ivory
                } else if v > 0.72 + 0.06 * (u * 7.0).sin() {
                    ink
                } else {
                    sea
                }
            }
            2 => {
                let reed = (0..7).any(|k| {
                    let foot = 0.16 + 0.115 * f64::from(k);
                    (u - foot - 0.10 * (1.0 - v).powi(2) * f64::from(k % 3 - 1)).abs() < 0.016 * (v + 0.15)
                        && v > 0.14 + 0.06 * f64::from(k * 3 % 5)
                });
                if reed { ink } else { mix(red, sand, v) }
            }
            3 => {
                if ((u * 3.0 + v * 1.2) * 13.0).fract() < 0.12
                    && (v * 7.0 + (u * 39.0 + v * 15.6).floor() * 0.37).fract() < 0.6
                {
                    ink
                } else {
                    mix([0.45, 0.52, 0.53], ivory, v)
                }
            }
            4 => {
                if v > 0.35 + 0.5 * (u - 0.45).abs() {
                    if wave(22.0) > 0.55 && v > 0.5 { ink } else { sea }
                } else {
                    mix(red, sand, v * 1.6)
                }
            }
            5 => {
                let sail = u > 0.34 && v < 0.68 && (u - 0.34) < (v - 0.14) * 0.72;
                if sail {
                    red
                } else if v > 0.70 {
                    if wave(12.0) > 0.3 { ivory } else { sea }
                } else {
                    ivory
                }
            }
            _ => {
                let row = (v * 9.0).floor();
                let (a, b) = ((u * 5.0 + 0.5 * (row % 2.0)).fract() - 0.5, (v * 9.0).fract());
                if (a.hypot(b) * 2.0).fract() < 0.3 { ink } else { sand }
            }
        };
        if frame { ivory } else { drawing }.map(|c| c * fiber)
    })
}
