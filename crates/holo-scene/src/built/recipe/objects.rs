//! The bodies of recipes, each within the ball of radius 1 around the origin.

use std::f64::consts::TAU;

use glam::DVec3;
use serde::Deserialize;

use crate::built::parts::noise::{Random, fractal};
use crate::built::parts::{shapes, solids};
use crate::{Mesh, Transform};

/// A kind of body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Shape {
    /// A box with rounded edges.
    #[default]
    Box,
    Ball,
    /// A ball with bumps.
    Stone,
    /// A solid of revolution.
    Lathe,
    /// A vessel of revolution with a thin wall.
    Vessel,
    /// A tube closed to a ring.
    Ring,
    /// A tube closed to a knot.
    Knot,
    /// A thin wire wound to a spring.
    Spring,
    /// A plate with teeth and a hole.
    Gear,
    /// The edges of a box.
    Frame,
    /// Letters of blocks.
    Text,
    /// Thin rods in all directions.
    Burr,
    /// A plant of leaves on a stem.
    Plant,
    /// A flat sheet, bent a little.
    Sheet,
    /// One of the user's models.
    Model,
}

/// A mesh, and whether it is closed: glass must be.
pub(super) struct Body {
    pub mesh: Mesh,
    pub is_closed: bool,
}

impl Shape {
    /// The name of its instances.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Ball => "ball",
            Self::Stone => "stone",
            Self::Lathe => "lathe",
            Self::Vessel => "vessel",
            Self::Ring => "ring",
            Self::Knot => "knot",
            Self::Spring => "spring",
            Self::Gear => "gear",
            Self::Frame => "frame",
            Self::Text => "text",
            Self::Burr => "burr",
            Self::Plant => "plant",
            Self::Sheet => "sheet",
            Self::Model => "model",
        }
    }
}

/// A body of a kind.
pub(super) fn body(shape: Shape, random: &mut Random) -> Body {
    let closed = |mesh| Body { mesh, is_closed: true };
    let open = |mesh| Body { mesh, is_closed: false };
    let mut body = match shape {
        Shape::Box | Shape::Model => {
            let size = [(); 3].map(|()| random.between(0.3, 1.0));
            let smallest = size.into_iter().fold(f64::INFINITY, f64::min);
            let edge = smallest * random.between(0.02, 0.2);
            closed(solids::rounded_box(size, edge))
        }
        Shape::Ball => closed(solids::lathe(72, 4, &round())),
        Shape::Stone => {
            let (bump, scale, octaves) =
                (random.between(0.15, 0.6), random.between(0.8, 3.0), 1 + random.index(4) as u32);
            let own = random.between(0.0, 100.0);
            open(ball(move |d| bump * fractal((d * scale + DVec3::splat(own)).to_array(), octaves)))
        }
        Shape::Lathe => closed(solids::lathe(72, 6, &profile(random))),
        Shape::Vessel => closed(solids::lathe(72, 6, &vessel(random))),
        Shape::Ring => {
            let radius = random.between(0.08, 0.4);
            open(shapes::tube(96, 24, |_| radius, circle))
        }
        Shape::Knot => open(knot(random)),
        Shape::Spring => open(spring(random)),
        Shape::Gear => open(gear(random)),
        Shape::Frame => open(frame(random)),
        Shape::Text => open(text(random)),
        Shape::Burr => open(burr(random)),
        Shape::Plant => open(plant(random)),
        Shape::Sheet => open(sheet(random)),
    };
    within_unit_ball(&mut body.mesh);
    body
}

/// Moves and scales a mesh into the unit ball.
fn within_unit_ball(mesh: &mut Mesh) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in &mesh.positions {
        let p = glam::Vec3::from(*p).as_dvec3();
        (low, high) = (low.min(p), high.max(p));
    }
    let middle = 0.5 * (low + high);
    let far = |p: &[f32; 3]| glam::Vec3::from(*p).as_dvec3().distance(middle);
    let radius = mesh.positions.iter().map(far).fold(1e-9, f64::max);
    for p in &mut mesh.positions {
        *p = ((glam::Vec3::from(*p).as_dvec3() - middle) / radius).as_vec3().to_array();
    }
}

fn ball(displacement: impl Fn(DVec3) -> f64) -> Mesh {
    shapes::ball(72, 48, displacement)
}

/// The profile of a ball.
fn round() -> Vec<[f64; 2]> {
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) / 24.0 * std::f64::consts::PI).sin_cos();
        [if k == 24 { 0.0 } else { sin }, cos]
    };
    (0..=24).map(at).collect()
}

fn circle(s: f64) -> DVec3 {
    let (sin, cos) = (s * TAU).sin_cos();
    DVec3::new(cos, 0.0, sin)
}

/// From the top to the bottom, with widths that vary.
fn profile(random: &mut Random) -> Vec<[f64; 2]> {
    let (count, height) = (3 + random.index(5), random.between(0.6, 2.5));
    let mut points = vec![[0.0, height]];
    for k in 0..count {
        let place = height * (1.0 - (k as f64 + 0.5) / count as f64);
        points.push([random.between(0.15, 1.0), place]);
    }
    // A foot to stand on.
    let foot = random.between(0.3, 1.0);
    points.extend([[foot, 0.01], [foot - 0.01, 0.0], [0.0, 0.0]]);
    points
}

/// Up the inner wall, over the rim, down the outer wall.
fn vessel(random: &mut Random) -> Vec<[f64; 2]> {
    let (count, height, wall) = (3 + random.index(3), random.between(0.8, 2.2), random.between(0.04, 0.09));
    let widths: Vec<f64> = (0..count).map(|_| random.between(0.35, 1.0)).collect();
    let at = |k: usize| wall + (height - wall) * (k as f64 + 0.3) / (count as f64 - 0.7);
    let mut points = vec![[0.0, wall]];
    points.extend(widths.iter().enumerate().map(|(k, width)| [width - wall, at(k)]));
    points.extend(widths.iter().enumerate().rev().map(|(k, width)| [*width, at(k)]));
    points.extend([[widths[0] - 0.01, 0.0], [0.0, 0.0]]);
    points
}

fn knot(random: &mut Random) -> Mesh {
    let (p, q) = [(2.0, 3.0), (3.0, 2.0), (2.0, 5.0), (3.0, 4.0)][random.index(4)];
    let radius = random.between(0.06, 0.2);
    shapes::tube(
        240,
        16,
        move |_| radius,
        move |s| {
            let (sin_q, cos_q) = (q * s * TAU).sin_cos();
            let (sin_p, cos_p) = (p * s * TAU).sin_cos();
            DVec3::new((1.0 + 0.4 * cos_q) * cos_p, 0.4 * sin_q, (1.0 + 0.4 * cos_q) * sin_p)
        },
    )
}

fn spring(random: &mut Random) -> Mesh {
    let (turns, height, wire) = (random.between(3.0, 9.0), random.between(1.0, 3.0), random.between(0.015, 0.07));
    shapes::tube(
        320,
        8,
        move |_| wire,
        move |s| {
            let (sin, cos) = (turns * s * TAU).sin_cos();
            DVec3::new(cos, height * s, sin)
        },
    )
}

fn gear(random: &mut Random) -> Mesh {
    let (teeth, depth, hole) = (5 + random.index(20), random.between(0.08, 0.4), random.between(0.1, 0.5));
    let thickness = random.between(0.1, 0.6);
    let rounded = random.between(0.5, 6.0);
    // Standing on its teeth.
    let outer = move |turn: f64| 1.0 - depth * (0.5 + 0.5 * (rounded * (turn * teeth as f64 * TAU).cos()).tanh());
    solids::plate(24 * teeth as u32, thickness, hole * (1.0 - depth), outer)
}

/// The twelve edges of a box as bars.
fn frame(random: &mut Random) -> Mesh {
    let (size, bar) = ([(); 3].map(|()| random.between(0.4, 1.0)), random.between(0.02, 0.1));
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for (a, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
            // Bars along one axis end where those of the others begin.
            let end = size[axis] + if axis == 0 { bar } else { -bar };
            (low[axis], high[axis]) = (-end, end);
            for (other, side) in [((axis + 1) % 3, a), ((axis + 2) % 3, b)] {
                low[other] = side * size[other] - bar;
                high[other] = side * size[other] + bar;
            }
            add_box(&mut mesh, low, high);
        }
    }
    mesh
}

/// Letters as rows of five bits.
pub(super) const LETTERS: [[u8; 5]; 12] = [
    [0b01110, 0b10001, 0b11111, 0b10001, 0b10001], // A
    [0b11110, 0b10001, 0b11110, 0b10001, 0b11110], // B
    [0b11111, 0b10000, 0b11110, 0b10000, 0b11111], // E
    [0b01111, 0b10000, 0b10011, 0b10001, 0b01111], // G
    [0b10001, 0b10001, 0b11111, 0b10001, 0b10001], // H
    [0b10001, 0b10010, 0b11100, 0b10010, 0b10001], // K
    [0b10001, 0b11011, 0b10101, 0b10001, 0b10001], // M
    [0b01110, 0b10001, 0b10001, 0b10001, 0b01110], // O
    [0b11110, 0b10001, 0b11110, 0b10010, 0b10001], // R
    [0b01111, 0b10000, 0b01110, 0b00001, 0b11110], // S
    [0b11111, 0b00100, 0b00100, 0b00100, 0b00100], // T
    [0b10001, 0b01010, 0b00100, 0b01010, 0b10001], // X
];

/// A word of one to four letters, built of blocks.
fn text(random: &mut Random) -> Mesh {
    let (count, depth) = (1 + random.index(4), random.between(0.5, 3.0));
    let mut mesh = Mesh::default();
    for letter in 0..count {
        let rows = LETTERS[random.index(LETTERS.len())];
        for (row, bits) in rows.into_iter().enumerate() {
            let (left, below) = (6.0 * letter as f64, 4.0 - row as f64);
            let mut column = 0;
            // Blocks side by side are one.
            while column < 5 {
                let length = (column..5).take_while(|k| bits >> (4 - k) & 1 == 1).count();
                if length > 0 {
                    let low = [left + column as f64, below, 0.0];
                    add_box(&mut mesh, low, [low[0] + length as f64, below + 1.0, depth]);
                }
                column += length.max(1);
            }
        }
    }
    mesh
}

fn burr(random: &mut Random) -> Mesh {
    let (count, rod) = (12 + random.index(60), random.between(0.006, 0.025));
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let (end, length) = (random.direction(), random.between(0.6, 1.0));
        let part = shapes::tube(2, 6, move |_| rod, move |s| end * (length * s));
        solids::join(&mut mesh, &part, &Transform::IDENTITY);
    }
    mesh
}

/// A plant: stems with leaves of several greens.
fn plant(random: &mut Random) -> Mesh {
    let (stems, leaves) = (2 + random.index(6), 14 + random.index(40));
    let (size, height) = (random.between(0.1, 0.3), random.between(0.8, 2.2));
    let hue = [random.between(0.05, 0.4), random.between(0.25, 0.5), random.between(0.03, 0.12)];
    let mut mesh = Mesh::default();
    for _ in 0..stems {
        let lean = DVec3::new(random.between(-0.8, 0.8), 0.0, random.between(-0.8, 0.8));
        let bend = random.between(0.2, 1.0);
        let path = move |s: f64| DVec3::Y * (height * s) + lean * (s * (1.0 - bend + bend * s));
        let stem = shapes::tube(12, 5, |s| 0.02 * (1.0 - 0.6 * s), path);
        let first = mesh.positions.len();
        solids::join(&mut mesh, &stem, &Transform::IDENTITY);
        let brown = [0.20, 0.14, 0.07, 1.0];
        mesh.colors.extend(vec![brown; mesh.positions.len() - first]);
        for k in 0..leaves {
            let root = path((k as f64 + 1.0) / (leaves as f64 + 1.0));
            let along = (random.direction() + 0.5 * DVec3::Y).normalize_or(DVec3::X);
            let (length, tone) = (size * random.between(0.6, 1.4), random.between(0.6, 1.3));
            let color = hue.map(|c| (c * tone).min(1.0) as f32);
            add_leaf(&mut mesh, root, (along, random.direction()), length, color);
        }
    }
    mesh
}

/// A leaf: two triangles on each side of its middle, folded.
fn add_leaf(mesh: &mut Mesh, root: DVec3, (along, up): (DVec3, DVec3), length: f64, color: [f32; 3]) {
    let side = along.cross(up).normalize_or(DVec3::X) * (0.3 * length);
    let fold = side.cross(along).normalize_or(DVec3::Y) * (0.12 * length);
    let corners = [
        root,
        root + 0.5 * length * along + side + fold,
        root + length * along,
        root + 0.5 * length * along - side + fold,
    ];
    for half in [[0, 1, 2], [0, 2, 3]] {
        let [a, b, c] = half.map(|k: usize| corners[k]);
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3().to_array();
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([a, b, c].map(|p| p.as_vec3().to_array()));
        mesh.normals.extend([normal; 3]);
        mesh.texture_coordinates.extend(half.map(|k| [[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]][k]));
        mesh.colors.extend([[color[0], color[1], color[2], 1.0]; 3]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
}

/// A sheet of paper or cloth, bent along one direction.
fn sheet(random: &mut Random) -> Mesh {
    let (aspect, bend, waves) = (random.between(0.5, 1.5), random.between(-0.6, 0.6), random.between(0.0, 0.15));
    let (count, turn) = (random.between(1.0, 5.0), random.between(0.0, TAU));
    shapes::sheet(48, 48, move |s, t| {
        let (x, y) = (2.0 * s - 1.0, aspect * (1.0 - 2.0 * t));
        let along = x * turn.cos() + y * turn.sin();
        DVec3::new(x, y, bend * along * along + waves * (count * along * TAU * 0.5).sin())
    })
}

/// Adds a box with flat sides and texture coordinates.
pub(super) fn add_box(mesh: &mut Mesh, low: [f64; 3], high: [f64; 3]) {
    let part = shapes::cuboid(low, high);
    let first = mesh.positions.len() as u32;
    for side in 0..6 {
        let corners: Vec<DVec3> =
            part.positions[4 * side..4 * side + 4].iter().map(|p| glam::Vec3::from(*p).as_dvec3()).collect();
        let axis = side / 2;
        let normal = DVec3::AXES[axis] * if side % 2 == 1 { 1.0 } else { -1.0 };
        for p in corners {
            mesh.positions.push(p.as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
            let [a, b] = [(axis + 1) % 3, (axis + 2) % 3].map(|k| p[k] as f32);
            mesh.texture_coordinates.push([a, b]);
        }
    }
    mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|k| k + first)));
}
