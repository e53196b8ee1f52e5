//! Four scenes that vary one difficulty of the estimation of depth each, after the stratified scenes of Honauer, Johannsen,
//! Kondermann and Goldluecke, "A Dataset and Evaluation Methodology for Depth Estimation on 4D Light Fields", ACCV 2016.
//!
//! Each is seen straight on, so that disparity is a function of the shapes alone. Light comes evenly from the room.

use glam::DVec3;

use crate::built::parts::materials::{diffuse, textured};
use crate::built::parts::shapes;
use crate::built::parts::studio::{Studio, at};
use crate::built::parts::textures::grained;
use crate::{Mesh, Scene, Transform};

/// Half the side of the background, m; no view sees past it.
const HALF: f64 = 0.45;
/// The place of the background, m.
const BACK: f64 = -0.2;
/// The place of the camera, m.
const EYE: f64 = 0.6;
/// Half the side of what a square view sees of the background, m.
const SEEN: f64 = 0.36 * (EYE - BACK);

/// Spikes before a background: they become narrower from left to right, and the step of disparity grows downward.
///
/// **Purpose**: fine structures, occlusions and steps of disparity. **Difficulty**: towards their peaks, spikes are thinner
/// than a pixel.
pub(super) fn backgammon() -> Scene {
    let mut studio =
        Studio::new(vec![grained("stone", [0.50, 0.47, 0.42], 0.35), grained("leather", [0.42, 0.17, 0.11], 0.3)]);
    let stone = studio.material("stone", textured(0, diffuse([1.0; 3])));
    let leather = studio.material("leather", textured(1, diffuse([1.0; 3])));
    studio.add("background", facing(&[[-HALF, HALF, HALF, -HALF]], |_| BACK), stone, Transform::IDENTITY);
    // Nearer to the background above than below.
    let place = |y: f64| BACK + 0.13 - 0.22 * y;
    // The middle of the foreground is nearer than the background, and less of it is seen.
    let reach = 0.8 * SEEN * (EYE - place(0.0)) / (EYE - BACK);
    // A solid part at the left, then spikes that stand and hang in turn, each narrower than the one before.
    let mut parts = vec![[-HALF, HALF, -reach, -HALF]];
    let (mut left, count) = (-reach, 14);
    for k in 0..count {
        let width = 2.0 * reach / f64::from(count) * (1.4 - 0.8 * f64::from(k) / f64::from(count - 1));
        let (foot, peak) = if k % 2 == 0 { (-HALF, 0.9 * SEEN) } else { (HALF, -0.9 * SEEN) };
        parts.push([left, foot, left + width, peak]);
        left += width;
    }
    let (solid, spikes) = parts.split_at(1);
    studio.add("foreground", facing(solid, place), leather, Transform::IDENTITY);
    studio.add("spikes", triangles(spikes, place), leather, Transform::IDENTITY);
    seen(studio)
}

/// Dots of nine sizes in each of nine boxes. Every box reflects 0.6 of the light of the box before.
///
/// **Purpose**: small objects in noise. **Difficulty**: the smallest dots are a pixel wide, and in the darkest boxes the
/// noise of a sensor is larger than their contrast.
pub(super) fn dots() -> Scene {
    let shades = (0..9).map(|k| 0.7 * 0.6_f64.powi(k));
    let textures = shades.clone().map(|shade| grained("box", [shade, shade, 0.9 * shade], 0.3)).collect();
    let mut studio = Studio::new(textures);
    let side = 2.0 * SEEN / 3.0;
    for (number, shade) in shades.enumerate() {
        let (row, column) = ((number / 3) as f64, (number % 3) as f64);
        let (left, above) = (column * side - SEEN, SEEN - row * side);
        // The outer boxes reach beyond the view.
        let [x0, x1] = [if number % 3 == 0 { -HALF } else { left }, if number % 3 == 2 { HALF } else { left + side }];
        let [y0, y1] = [if number / 3 == 0 { HALF } else { above }, if number / 3 == 2 { -HALF } else { above - side }];
        let ground = studio.material("box", textured(number, diffuse([1.0; 3])));
        studio.add("box", facing(&[[x0, y0, x1, y1]], |_| BACK), ground, Transform::IDENTITY);
        let shade = 0.45 * shade as f32;
        let paint = studio.material("dot", diffuse([shade, 0.8 * shade, 1.3 * shade]));
        for k in 0..9 {
            // Diameters from 23 px to 1 px in views of 512.
            let radius = 0.0112 * 0.68_f64.powi(k);
            let (x, y) = (left + side * (f64::from(k % 3) + 0.5) / 3.0, above - side * (f64::from(k / 3) + 0.5) / 3.0);
            // Nearer things seem farther from the middle.
            let scale = (EYE - BACK - 0.1) / (EYE - BACK);
            studio.add("dot", disc(radius), paint, at(x * scale, y * scale, BACK + 0.1));
        }
    }
    seen(studio)
}

/// Pyramids and caps of balls, out of a plane and into it.
///
/// **Purpose**: planes and curves, convex and concave. **Difficulty**: slopes without a step, and small relief.
pub(super) fn pyramids() -> Scene {
    let mut studio = Studio::new(vec![grained("clay", [0.58, 0.50, 0.40], 0.4)]);
    let clay = studio.material("clay", textured(0, diffuse([1.0; 3])));
    let plane = shapes::sheet(400, 400, |s, t| {
        let (x, y) = (HALF * (2.0 * s - 1.0), HALF * (1.0 - 2.0 * t));
        DVec3::new(x, y, BACK + 0.05 + relief(x, y).0)
    });
    let plane = Mesh { normals: Vec::new(), ..plane };
    for part in [Relief::Base, Relief::Pyramids, Relief::BallsOut, Relief::BallsIn] {
        let mesh = triangles_where(&plane, |[x, y, _]| relief(f64::from(x), f64::from(y)).1 == part);
        let name = match part {
            Relief::Base => "base",
            Relief::Pyramids => "pyramids",
            Relief::BallsOut => "balls out",
            Relief::BallsIn => "balls in",
        };
        studio.add(name, mesh, clay, Transform::IDENTITY);
    }
    seen(studio)
}

/// A part of [`pyramids`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relief {
    Base,
    Pyramids,
    BallsOut,
    BallsIn,
}

/// The height of the relief of [`pyramids`] at a place, m, and the part that it belongs to.
fn relief(x: f64, y: f64) -> (f64, Relief) {
    let cell = SEEN / 2.0;
    let (column, row) = ((x / cell).floor(), (y / cell).floor());
    if column.abs() > 2.0 || row.abs() > 2.0 || column == 2.0 || row == 2.0 {
        return (0.0, Relief::Base);
    }
    let (x, y) = (x - (column + 0.5) * cell, y - (row + 0.5) * cell);
    let radius = 0.42 * cell;
    let (is_ball, is_out) = (((column + row) as i32).rem_euclid(2) == 1, column < 0.0);
    let height = match is_ball {
        false => 1.0 - x.abs().max(y.abs()) / radius,
        true => (1.0 - (x * x + y * y) / (radius * radius)).max(0.0).sqrt(),
    };
    if height <= 0.0 {
        return (0.0, Relief::Base);
    }
    // Out in the left half, into the plane in the right one; lower from row to row.
    let most = 0.045 * 0.6_f64.powf(row + 2.0);
    let part = match (is_ball, is_out) {
        (false, _) => Relief::Pyramids,
        (true, true) => Relief::BallsOut,
        (true, false) => Relief::BallsIn,
    };
    (if is_out { most * height } else { -most * height }, part)
}

/// Dark and bright stripes before a background, both of three amounts of texture.
///
/// **Purpose**: contrast and texture at occlusions. **Difficulty**: bright stripes differ little from the background, and
/// below neither has any texture.
pub(super) fn stripes() -> Scene {
    let grains = [0.5, 0.12, 0.0];
    let colors = [[0.62, 0.60, 0.55], [0.10, 0.09, 0.09], [0.56, 0.55, 0.52]];
    let textures = colors.iter().flat_map(|color| grains.map(|grain| grained("stripe", *color, grain))).collect();
    let mut studio = Studio::new(textures);
    let third = 2.0 * SEEN / 3.0;
    for (band, grain) in grains.into_iter().enumerate() {
        let above = if band == 0 { HALF } else { SEEN - third * band as f64 };
        let below = if band == 2 { -HALF } else { SEEN - third * (band + 1) as f64 };
        let mut paint = |color: usize| {
            let [r, g, b] = colors[color].map(|c: f64| c as f32);
            // Without grain, without a texture.
            let plain = if grain > 0.0 { textured(3 * color + band, diffuse([1.0; 3])) } else { diffuse([r, g, b]) };
            studio.material(["background", "dark", "bright"][color], plain)
        };
        let (background, dark, bright) = (paint(0), paint(1), paint(2));
        studio.add("background", facing(&[[-HALF, above, HALF, below]], |_| BACK), background, Transform::IDENTITY);
        for (side, name, paint) in [(-1.0, "dark stripes", dark), (1.0, "bright stripes", bright)] {
            let width = |k: i32| 0.03 * 0.6_f64.powi(k);
            let stripe = |k: i32| {
                let x = side * SEEN * (0.12 + 0.19 * f64::from(k));
                [x - 0.5 * width(k), above, x + 0.5 * width(k), below]
            };
            let bars: Vec<[f64; 4]> = (0..5).map(stripe).collect();
            studio.add(name, facing(&bars, |_| BACK + 0.12), paint, Transform::IDENTITY);
        }
    }
    seen(studio)
}

/// Lit by the room, before the camera.
fn seen(mut studio: Studio) -> Scene {
    studio.room([0.32, 0.32, 0.32]);
    studio.with_camera([0.0, 0.0, EYE], [0.0, 0.0, BACK])
}

/// Rectangles that face +Z: left, above, right, below; their place is a linear function of y.
fn facing(rectangles: &[[f64; 4]], place: impl Fn(f64) -> f64) -> Mesh {
    let corners =
        |[left, above, right, below]: [f64; 4]| vec![[left, above], [left, below], [right, below], [right, above]];
    flat(&rectangles.iter().map(|rectangle| corners(*rectangle)).collect::<Vec<_>>(), place)
}

/// Triangles that face +Z: left, foot, right and peak of each.
fn triangles(spikes: &[[f64; 4]], place: impl Fn(f64) -> f64) -> Mesh {
    let corners = |[left, foot, right, peak]: [f64; 4]| {
        let middle = [0.5 * (left + right), peak];
        if foot < peak { vec![[left, foot], [right, foot], middle] } else { vec![[left, foot], middle, [right, foot]] }
    };
    flat(&spikes.iter().map(|spike| corners(*spike)).collect::<Vec<_>>(), place)
}

/// Convex polygons that face +Z, counter-clockwise, with texture coordinates of the whole background.
fn flat(polygons: &[Vec<[f64; 2]>], place: impl Fn(f64) -> f64) -> Mesh {
    let mut mesh = Mesh::default();
    for polygon in polygons {
        let first = mesh.positions.len() as u32;
        for &[x, y] in polygon {
            mesh.positions.push(DVec3::new(x, y, place(y)).as_vec3().to_array());
            mesh.texture_coordinates.push([x, -y].map(|c| (0.5 + 0.5 * c / HALF) as f32));
        }
        let count = polygon.len() as u32;
        mesh.triangles.extend((2..count).map(|k| [first, first + k - 1, first + k]));
    }
    mesh
}

/// The triangles of a mesh whose centers are as wanted, with their vertices.
fn triangles_where(mesh: &Mesh, is_wanted: impl Fn([f32; 3]) -> bool) -> Mesh {
    let mut out = Mesh::default();
    let mut own = vec![None; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
        if !is_wanted([0, 1, 2].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f32>() / 3.0)) {
            continue;
        }
        out.triangles.push(triangle.map(|vertex| {
            *own[vertex as usize].get_or_insert_with(|| {
                out.positions.push(mesh.positions[vertex as usize]);
                out.texture_coordinates.push(mesh.texture_coordinates[vertex as usize]);
                out.positions.len() as u32 - 1
            })
        }));
    }
    out
}

/// A disc that faces +Z.
fn disc(radius: f64) -> Mesh {
    let corner = |k: u32| {
        let angle = f64::from(k) / 64.0 * std::f64::consts::TAU;
        [radius * angle.cos(), radius * angle.sin()]
    };
    Mesh { texture_coordinates: Vec::new(), ..flat(&[(0..64).map(corner).collect()], |_| 0.0) }
}
