//! A pendulum before a papered wall: animated, 2 s.
//!
//! **Purpose**: motion of one thing over surfaces that rest. **Difficulty**: the rod is thinner than a pixel; its shadow
//! moves over textures whose own motion is zero.

use std::f64::consts::TAU;

use crate::animation::{Animation, Key, Target, Track};
use crate::built::parts::materials::{BRASS, STEEL, diffuse, metal, repeated, textured};
use crate::built::parts::shapes;
use crate::built::parts::solids::{join, lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, turned, upright};
use crate::built::parts::textures::{azulejo, checked_linen, wallpaper, wood};
use crate::{Mesh, Scene, Transform};

/// The axis of the pendulum, m.
const PIVOT: [f64; 3] = [0.0, 0.13, 0.02];

/// From the pivot to the center of the bob, m: a period of 0.92 s.
const LENGTH_M: f64 = 0.21;

/// The largest angle, degrees.
const AMPLITUDE_DEG: f64 = 26.0;

/// Keys a second.
const RATE: u32 = 48;

/// Length of the animation, s.
const SECONDS: u32 = 2;

/// What swings.
const MOVING: [&str; 2] = ["rod", "bob"];

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![
        wallpaper([0.62, 0.60, 0.52], [0.20, 0.34, 0.24], [0.52, 0.14, 0.10]),
        wood("oak", [0.20, 0.11, 0.05], [0.42, 0.26, 0.13], 3.0, 5.0),
        azulejo(),
        checked_linen([0.70, 0.66, 0.58], [0.10, 0.20, 0.42]),
    ]);
    let paper = studio.material("paper", repeated(0, [3.0, 2.25], diffuse([1.0; 3])));
    let oak = studio.material("oak", textured(1, diffuse([1.0; 3])));
    let tile = studio.material("tile", repeated(2, [3.0, 2.0], diffuse([1.0; 3])));
    let cloth = studio.material("cloth", textured(3, diffuse([1.0; 3])));
    let steel = studio.material("steel", metal(STEEL, 0.35));
    let brass = studio.material("brass", metal(BRASS, 0.28));

    let wall = shapes::sheet(1, 1, |s, t| glam::DVec3::new(0.8 * (s - 0.5), 0.6 * (0.5 - t), -0.12));
    studio.add("wall", wall, paper, Transform::IDENTITY);
    studio.add("shelf", rounded_box([0.56, 0.02, 0.22], 0.004), oak, at(0.0, -0.145, -0.01));
    studio.add("bracket", rounded_box([0.024, 0.018, 0.15], 0.004), steel, at(0.0, PIVOT[1], -0.045));
    studio.add(
        "ball",
        shapes::ball(120, 60, |_| 0.0),
        tile,
        turned([-0.16, -0.097, -0.03], [0.0, 1.0, 0.0], 30.0, 0.038),
    );
    studio.add("box", rounded_box([0.07, 0.07, 0.07], 0.004), cloth, upright([0.165, -0.100, -0.02], 24.0));
    let pose = swing(AMPLITUDE_DEG);
    studio.add(
        "rod",
        lathe(24, 2, &[[0.0, 0.008], [0.0022, 0.006], [0.0022, -LENGTH_M], [0.0, -LENGTH_M]]),
        steel,
        pose,
    );
    studio.add("bob", bob(), brass, pose);

    studio.room([0.30, 0.30, 0.31]);
    studio.softbox("softbox", [-0.7, 0.8, 0.9], [0.0, -0.05, 0.0], [0.4, 0.4], [9.0, 8.6, 8.0]);
    studio.with_camera([0.09, 0.03, 0.66], [0.0, -0.012, -0.02])
}

/// The harmonic approximation of a pendulum, released at its largest angle.
pub(super) fn animation() -> Animation {
    let scene = scene();
    let moving = scene.instances.iter().enumerate().filter(|(_, instance)| MOVING.contains(&instance.name.as_str()));
    let keys = || {
        (0..=RATE * SECONDS).map(|k| {
            let time_s = f64::from(k) / f64::from(RATE);
            let period_s = TAU * (LENGTH_M / 9.81).sqrt();
            let angle_rad = (AMPLITUDE_DEG * (TAU * time_s / period_s).cos()).to_radians();
            let (sin, cos) = (0.5 * angle_rad).sin_cos();
            Key {
                time_s: time_s as f32,
                translation: PIVOT.map(|x| x as f32),
                rotation: [0.0, 0.0, sin as f32, cos as f32],
            }
        })
    };
    let tracks = moving.map(|(index, _)| Track { target: Target::Instance(index), keys: keys().collect() }).collect();
    Animation { name: "swing".into(), tracks }
}

/// The pose at an angle, in degrees counter-clockwise.
fn swing(degrees: f64) -> Transform {
    turned(PIVOT, [0.0, 0.0, 1.0], degrees, 1.0)
}

/// A lens-shaped disc that faces +Z below the pivot.
fn bob() -> Mesh {
    let lens = lathe(
        96,
        6,
        &[[0.0, 0.013], [0.02, 0.0112], [0.035, 0.005], [0.0385, 0.0], [0.035, -0.005], [0.02, -0.0112], [0.0, -0.013]],
    );
    let mut mesh = Mesh::default();
    join(&mut mesh, &lens, &turned([0.0, -LENGTH_M, 0.0], [1.0, 0.0, 0.0], 90.0, 1.0));
    mesh
}
