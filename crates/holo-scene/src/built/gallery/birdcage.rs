//! A wire birdcage with paper birds, some in it and some gone.
//!
//! **Purpose**: thin structures. **Difficulty**: the wires are about as wide as a pixel of a view and stand in front of
//! each other, of the birds and of a plain wall; their shadows look like wires.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::built::parts::materials::{BRASS, diffuse, glossy, metal, textured};
use crate::built::parts::shapes;
use crate::built::parts::solids::lathe;
use crate::built::parts::studio::{Studio, at, turned};
use crate::built::parts::textures::{grained, wood};
use crate::{Mesh, Scene, Transform};

/// Position of the cage, m.
const CAGE: [f64; 3] = [-0.055, 0.0, -0.06];
const CAGE_RADIUS: f64 = 0.092;
/// Height at which the wires bend into the dome, m.
const SHOULDER: f64 = 0.145;

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![
        grained("wall", [0.60, 0.42, 0.345], 0.10),
        wood("table", [0.16, 0.085, 0.045], [0.36, 0.215, 0.125], 3.0, 51.0),
    ]);
    let wall = studio.material("wall", textured(0, diffuse([1.0; 3])));
    let table = studio.material("table", textured(1, glossy([1.0; 3], 0.4)));
    let wire = studio.material("wire", metal(BRASS, 0.3));
    let lacquer = studio.material("lacquer", glossy([0.045, 0.10, 0.105], 0.18));
    let papers = [[0.80, 0.78, 0.73], [0.72, 0.16, 0.10], [0.10, 0.27, 0.34], [0.80, 0.55, 0.16]]
        .map(|c| studio.material("paper", diffuse(c)));
    let thread = studio.material("thread", diffuse([0.75, 0.72, 0.66]));

    studio.add(
        "wall",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.56 - 0.58 * t, -0.36)),
        wall,
        Transform::IDENTITY,
    );
    studio.add(
        "table",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.0, 0.72 * t - 0.37)),
        table,
        Transform::IDENTITY,
    );

    cage(&mut studio, wire, lacquer, thread);

    birds(&mut studio, papers, thread);

    studio.room([0.125, 0.12, 0.12]);
    studio.spot("lamp", [-0.62, 0.50, 0.85], [0.0, 0.1, -0.1], 32.0, [3.4, 3.1, 2.6]);
    studio.softbox("window", [-0.95, 0.80, 0.50], [0.0, 0.1, -0.1], [0.4, 0.5], [2.4, 2.3, 2.2]);
    studio.softbox("reflector", [1.0, 0.4, 0.6], [0.0, 0.1, -0.1], [0.5, 0.9], [0.7, 0.75, 0.85]);
    studio.with_camera([0.045, 0.165, 0.60], [0.005, 0.118, -0.06])
}

/// The cage with its door and a perch.
fn cage(studio: &mut Studio, wire: usize, lacquer: usize, thread: usize) {
    let cage = Transform::from_translation(CAGE);
    let base = lathe(
        128,
        5,
        &[
            [0.0, 0.018],
            [0.093, 0.018],
            [0.0965, 0.0165],
            [0.0985, 0.012],
            [0.104, 0.008],
            [0.107, 0.004],
            [0.106, 0.0],
            [0.0, 0.0],
        ],
    );
    studio.add("base", base, lacquer, cage);
    for k in 0..32 {
        // The door is open: three wires are missing.
        if !(6..9).contains(&k) {
            studio.add("rib", rib(TAU * (f64::from(k) + 0.5) / 32.0), wire, cage);
        }
    }
    let hoop = |radius: f64, height: f64, thick: f64| {
        shapes::tube(
            160,
            10,
            move |_| thick,
            move |s| DVec3::new(radius * (s * TAU).cos(), height, radius * (s * TAU).sin()),
        )
    };
    for (radius, height, thick) in [
        (CAGE_RADIUS, 0.024, 0.0016),
        (CAGE_RADIUS, 0.085, 0.001),
        (CAGE_RADIUS, SHOULDER, 0.0014),
        (0.0655, 0.2045, 0.001),
    ] {
        studio.add("hoop", hoop(radius, height, thick), wire, cage);
    }
    let crown = lathe(
        64,
        5,
        &[[0.0, 0.246], [0.004, 0.244], [0.006, 0.238], [0.0035, 0.234], [0.010, 0.231], [0.010, 0.228], [0.0, 0.227]],
    );
    studio.add("crown", crown, wire, cage);
    let ring = shapes::tube(
        96,
        12,
        |_| 0.0011,
        |s| DVec3::new(0.011 * (s * TAU).cos(), 0.2565 + 0.011 * (s * TAU).sin(), 0.0),
    );
    studio.add("ring", ring, wire, cage.after(&turned([0.0; 3], [0.0, 1.0, 0.0], 35.0, 1.0)));
    // The open door.
    let hinge = TAU * 6.1 / 32.0;
    let door_at = DVec3::from(CAGE) + DVec3::new(CAGE_RADIUS * hinge.cos(), 0.0, CAGE_RADIUS * hinge.sin());
    door(studio, turned(door_at.to_array(), [0.0, 1.0, 0.0], -38.0, 1.0), wire);
    // A perch on two threads.
    studio.add("perch", shapes::tube(2, 12, |_| 0.0022, |s| DVec3::new(-0.048 + 0.096 * s, 0.098, 0.0)), lacquer, cage);
    for x in [-0.044, 0.044] {
        studio.add(
            "thread",
            shapes::tube(2, 6, |_| 0.0004, |s| DVec3::new(x * s, 0.228 - 0.13 * s, 0.0)),
            thread,
            cage,
        );
    }
}

/// A wire of the cage at an angle around it: straight up, then a quarter of an ellipse to the crown.
fn rib(angle: f64) -> Mesh {
    shapes::tube(
        40,
        10,
        |_| 0.00085,
        move |s| {
            let (radius, height) = if s < 0.5 {
                (CAGE_RADIUS, 0.018 + (SHOULDER - 0.018) * 2.0 * s)
            } else {
                let turn = (s - 0.5) * std::f64::consts::PI * 0.97;
                (CAGE_RADIUS * turn.cos(), SHOULDER + 0.085 * turn.sin())
            };
            DVec3::new(radius * angle.cos(), height, radius * angle.sin())
        },
    )
}

/// Paper birds; those in the air hang on threads.
fn birds(studio: &mut Studio, papers: [usize; 4], thread: usize) {
    // (place, heading, pitch, size, paper)
    let birds = [
        ([-0.067, 0.124, -0.060], 28.0, 8.0, 0.050, 0),
        ([-0.020, 0.044, -0.030], -140.0, 0.0, 0.046, 2),
        ([0.118, 0.026, 0.020], -28.0, 0.0, 0.056, 1),
        ([0.140, 0.165, -0.095], -35.0, 18.0, 0.050, 3),
        ([0.205, 0.235, -0.215], -50.0, 24.0, 0.050, 0),
        ([-0.165, 0.028, 0.075], 40.0, 0.0, 0.056, 3),
    ];
    for (place, heading, pitch, size, paper) in birds {
        let pose = turned(place, [0.0, 1.0, 0.0], heading, size).after(&turned([0.0; 3], [0.0, 0.0, 1.0], pitch, 1.0));
        studio.add("bird", bird(), papers[paper], pose);
    }
    for (x, y, z) in [(0.140, 0.165, -0.095), (0.205, 0.235, -0.215)] {
        studio.add(
            "thread",
            shapes::tube(2, 6, |_| 0.0004, |s| DVec3::new(0.0, 0.01 + (0.55 - y) * s, 0.0)),
            thread,
            at(x, y, z),
        );
    }
}

/// An origami crane of length about 2 that flies along +X: flat faces of folded paper.
fn bird() -> Mesh {
    let (back, belly) = ([-0.05, 0.12, 0.0], [0.0, -0.28, 0.0]);
    let (head, neck, beak) = ([0.78, 0.52, 0.0], [0.32, -0.05, 0.0], [1.02, 0.40, 0.0]);
    let (tail, rump) = ([-1.0, 0.55, 0.0], [-0.34, -0.05, 0.0]);
    let mut corners = Vec::new();
    for side in [-1.0, 1.0] {
        let (wing, fore, aft) = ([-0.06, 0.62, 0.92 * side], [0.30, 0.0, 0.11 * side], [-0.34, 0.0, 0.11 * side]);
        let (flank, cheek) = ([0.0, -0.18, 0.13 * side], [0.74, 0.50, 0.035 * side]);
        corners.extend([[fore, wing, back], [back, wing, aft], [fore, flank, back], [aft, back, flank]]);
        corners.extend([
            [fore, belly, flank],
            [aft, flank, belly],
            [neck, fore, cheek],
            [fore, head, cheek],
            [cheek, head, beak],
        ]);
        corners.extend([[aft, rump, tail], [aft, tail, back], [fore, neck, belly], [aft, belly, rump]]);
    }
    let mut mesh = Mesh::default();
    for triangle in corners {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(triangle.map(|p| p.map(|x: f64| x as f32)));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

/// A small arched door of wire, its hinge at the origin, opening along +X.
fn door(studio: &mut Studio, pose: Transform, wire: usize) {
    let wide = 0.046;
    let frame = shapes::tube(
        96,
        10,
        |_| 0.0009,
        move |s| {
            let turn = s * TAU;
            DVec3::new(0.5 * wide * (1.0 - turn.cos()), 0.060 + 0.034 * turn.sin(), 0.0)
        },
    );
    studio.add("door", frame, wire, pose);
    for k in 1..4 {
        let x = wide * f64::from(k) / 4.0;
        let high = 0.034 * (1.0 - (2.0 * x / wide - 1.0).powi(2)).sqrt();
        studio.add(
            "door wire",
            shapes::tube(2, 8, |_| 0.0007, |s| DVec3::new(x, 0.060 + high * (2.0 * s - 1.0), 0.0)),
            wire,
            pose,
        );
    }
}
