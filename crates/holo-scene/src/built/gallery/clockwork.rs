//! The train of an old clock: wheels of brass, copper, iron and steel before a brushed plate.
//!
//! **Purpose**: rough metal, in layers. **Difficulty**: rough metal shows only blurred reflections; teeth repeat;
//! wheels overlap with gaps of some millimeters.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::animation::{Animation, Key, Target, Track};
use crate::built::parts::materials::{BRASS, COPPER, STEEL, diffuse, metal, roughness_mapped, textured};
use crate::built::parts::shapes;
use crate::built::parts::solids::{join, lathe, plate, rounded_box};
use crate::built::parts::studio::{Studio, at, turned};
use crate::built::parts::textures::{brushed, grained};
use crate::{Mesh, Scene, Transform};

/// A toothed wheel; wheels in one plane mesh.
struct Wheel {
    place: [f64; 3],
    teeth: u32,
    radius: f64,
    /// Without spokes it is solid.
    spokes: u32,
    /// Rotation at the start, in teeth.
    turn: f64,
    /// Turns of this wheel for one of the first; negative for the other direction.
    ratio: f64,
}

const fn at_rest(place: [f64; 3], teeth: u32, radius: f64, spokes: u32, turn: f64, ratio: f64) -> Wheel {
    Wheel { place, teeth, radius, spokes, turn, ratio }
}

/// Two wheels that mesh turn in opposite directions, in the ratio of their teeth; two on one arbor turn together.
const WHEELS: [Wheel; 10] = [
    at_rest([-0.088, 0.010, -0.075], 72, 0.090, 6, 0.0, 1.0),
    at_rest([0.0145, 0.0595, -0.075], 18, 0.0225, 0, 0.36, -72.0 / 18.0),
    at_rest([0.0145, 0.0595, -0.048], 60, 0.068, 5, 0.1, -72.0 / 18.0),
    at_rest([0.094, 0.003, -0.048], 24, 0.0275, 0, 0.3, 72.0 / 18.0 * 60.0 / 24.0),
    at_rest([0.094, 0.003, -0.022], 64, 0.074, 6, 0.4, 72.0 / 18.0 * 60.0 / 24.0),
    at_rest([0.0085, -0.0555, -0.022], 24, 0.0265, 0, 0.62, -72.0 / 18.0 * 60.0 / 24.0 * 64.0 / 24.0),
    at_rest([0.0085, -0.0555, 0.004], 48, 0.052, 4, 0.2, -72.0 / 18.0 * 60.0 / 24.0 * 64.0 / 24.0),
    at_rest([-0.066, -0.0800, 0.004], 24, 0.0255, 0, 0.5, 72.0 / 18.0 * 60.0 / 24.0 * 64.0 / 24.0 * 48.0 / 24.0),
    at_rest([-0.066, -0.0800, 0.024], 15, 0.0165, 0, 0.2, 72.0 / 18.0 * 60.0 / 24.0 * 64.0 / 24.0 * 48.0 / 24.0),
    // Meshes with none.
    at_rest([0.172, 0.080, -0.075], 30, 0.036, 5, 0.2, 0.0),
];

/// The start of the names of the instances of wheels.
const WHEEL: &str = "wheel";

/// Degrees that the first wheel turns in a second: the last two turn by 160.
const SPEED_DEG: f64 = 3.0;

/// Keys a second: less than half a turn lies between them.
const RATE: u32 = 4;

/// Length of the animation, s.
const SECONDS: u32 = 2;

impl Wheel {
    fn turn_deg(&self) -> f64 {
        self.turn * 360.0 / f64::from(self.teeth)
    }

    fn key(&self, time_s: f64) -> Key {
        let angle_rad = (self.turn_deg() + SPEED_DEG * self.ratio * time_s).to_radians();
        let (sin, cos) = (0.5 * angle_rad).sin_cos();
        let rotation = [0.0, 0.0, sin as f32, cos as f32];
        Key { time_s: time_s as f32, translation: self.place.map(|x| x as f32), rotation }
    }
}

/// The train turns evenly.
pub(super) fn animation() -> Animation {
    let scene = scene();
    let track = |(k, wheel): (usize, &Wheel)| {
        let index = scene.instances.iter().position(|instance| instance.name == format!("{WHEEL} {k}"))?;
        let keys = (0..=RATE * SECONDS).map(|key| wheel.key(f64::from(key) / f64::from(RATE))).collect();
        Some(Track { target: Target::Instance(index), keys })
    };
    let moving = WHEELS.iter().enumerate().filter(|(_, wheel)| wheel.ratio != 0.0);
    Animation { name: "turn".into(), tracks: moving.filter_map(track).collect() }
}

pub(super) fn scene() -> Scene {
    let mut studio =
        Studio::new(vec![brushed(0.42, 0.16), brushed(0.62, 0.22), grained("leather", [0.028, 0.040, 0.058], 0.5)]);
    let backing = studio.material("backing", textured(2, diffuse([1.0; 3])));
    let iron = studio.material("plate", roughness_mapped(1, [3.0, 3.0], metal([0.30, 0.31, 0.33], 1.0)));
    let brass = studio.material("brass", roughness_mapped(0, [1.0, 1.0], metal(BRASS, 0.85)));
    let old_brass = studio.material("old brass", roughness_mapped(1, [1.0, 1.0], metal([0.72, 0.50, 0.24], 0.8)));
    let copper = studio.material("copper", roughness_mapped(0, [1.0, 1.0], metal(COPPER, 0.8)));
    let steel = studio.material("steel", roughness_mapped(0, [1.0, 1.0], metal(STEEL, 0.7)));
    let blued = studio.material("blued steel", metal([0.10, 0.16, 0.36], 0.24));

    plate_with_pillars(&mut studio, backing, iron, brass);

    let metals = [brass, steel, copper, steel, old_brass, steel, brass, copper, steel, old_brass];
    for (k, (own, metal)) in WHEELS.iter().zip(metals).enumerate() {
        let pose = turned(own.place, [0.0, 0.0, 1.0], own.turn_deg(), 1.0);
        studio.add(&format!("{WHEEL} {k}"), wheel(own.teeth, own.radius, own.spokes), metal, pose);
    }
    arbors(&mut studio, steel);
    spring(&mut studio, blued);
    for (x, y) in [(-0.19, 0.06), (-0.19, -0.06), (0.13, -0.125), (0.02, 0.135), (0.19, 0.01)] {
        screw(&mut studio, [x, y, -0.106], 40.0 * (x * 90.0 + y * 50.0), blued);
    }

    studio.room([0.23, 0.25, 0.28]);
    studio.softbox("softbox", [-0.8, 0.75, 0.8], [0.0, 0.0, -0.05], [0.7, 0.5], [4.6, 4.3, 3.8]);
    studio.softbox("strip", [0.95, 0.1, 0.45], [0.0, 0.0, -0.05], [0.18, 0.9], [3.6, 4.0, 4.8]);
    studio.with_camera([0.110, -0.055, 0.475], [0.002, -0.003, -0.055])
}

/// The backing, the plate and its pillars.
fn plate_with_pillars(studio: &mut Studio, backing: usize, iron: usize, brass: usize) {
    studio.add(
        "backing",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.48 - 0.72 * t, -0.16)),
        backing,
        Transform::IDENTITY,
    );
    studio.add("plate", rounded_box([0.46, 0.30, 0.008], 0.003), iron, at(0.0, 0.0, -0.110));
    for (x, y) in [(-0.205, -0.125), (0.205, -0.125), (-0.205, 0.125), (0.205, 0.125)] {
        studio.add(
            "pillar",
            lathe(
                48,
                4,
                &[
                    [0.0, 0.10],
                    [0.008, 0.10],
                    [0.0088, 0.0988],
                    [0.0088, 0.08],
                    [0.006, 0.072],
                    [0.0055, 0.03],
                    [0.009, 0.02],
                    [0.010, 0.0],
                    [0.0, 0.0],
                ],
            ),
            brass,
            turned([x, y, -0.108], [1.0, 0.0, 0.0], 90.0, 1.0),
        );
    }
}

/// The arbors of the wheels.
fn arbors(studio: &mut Studio, steel: usize) {
    for (x, y, near) in [
        (-0.088, 0.010, -0.055),
        (0.0145, 0.0595, -0.030),
        (0.094, 0.003, -0.002),
        (0.0085, -0.0555, 0.022),
        (-0.066, -0.08, 0.042),
        (0.172, 0.08, -0.055),
    ] {
        let arbor = lathe(
            40,
            4,
            &[
                [0.0, near + 0.112],
                [0.0032, near + 0.111],
                [0.0045, near + 0.1085],
                [0.0045, near + 0.100],
                [0.0075, near + 0.098],
                [0.0078, near + 0.094],
                [0.0045, near + 0.093],
                [0.0045, 0.0],
                [0.0, 0.0],
            ],
        );
        studio.add("arbor", arbor, steel, turned([x, y, -0.108], [1.0, 0.0, 0.0], 90.0, 1.0));
    }
}

/// A toothed wheel around +Z with a rim, spokes and a hub; without spokes it is solid.
fn wheel(teeth: u32, radius: f64, spokes: u32) -> Mesh {
    let depth = TAU * radius / f64::from(teeth) * 0.62;
    let flank = |turn: f64| {
        // A tooth with slanted flanks.
        let phase = (turn * f64::from(teeth)).rem_euclid(1.0);
        let up = ((phase - 0.16) / 0.14).clamp(0.0, 1.0) - ((phase - 0.66) / 0.14).clamp(0.0, 1.0);
        radius + depth * (up - 0.5)
    };
    let columns = teeth * 16;
    if spokes == 0 {
        return plate(columns, 0.011, 0.003, flank);
    }
    let mut all = Mesh::default();
    join(&mut all, &plate(columns, 0.007, radius * 0.80, flank), &Transform::IDENTITY);
    join(&mut all, &plate(96, 0.010, 0.003, |_| radius * 0.19), &Transform::IDENTITY);
    let bar = shapes::cuboid([radius * 0.15, -radius * 0.048, -0.0026], [radius * 0.83, radius * 0.048, 0.0026]);
    for k in 0..spokes {
        let mut bar = bar.clone();
        bar.texture_coordinates = bar.positions.iter().map(|p| [p[0] * 10.0, p[1] * 10.0]).collect();
        join(&mut all, &bar, &turned([0.0; 3], [0.0, 0.0, 1.0], 360.0 * f64::from(k) / f64::from(spokes), 1.0));
    }
    // Flat sides: without normals.
    all.normals.clear();
    all
}

/// A hairspring over the first wheel.
fn spring(studio: &mut Studio, material: usize) {
    let coil = shapes::tube(
        900,
        8,
        |_| 0.0009,
        |s| {
            let (angle, radius) = (s * 7.0 * TAU, 0.012 + 0.044 * s);
            DVec3::new(-0.088 + radius * angle.cos(), 0.010 + radius * angle.sin(), -0.058 + 0.004 * s)
        },
    );
    studio.add("spring", coil, material, Transform::IDENTITY);
}

/// A slotted screw whose head faces +Z.
fn screw(studio: &mut Studio, place: [f64; 3], turn: f64, material: usize) {
    let half = |side: f64| {
        let mut mesh = Mesh::default();
        let outline = |t: f64| {
            // A half of a disc, less the slot.
            let angle = (t - 0.5) * std::f64::consts::PI * 0.93;
            DVec3::new(0.0075 * angle.sin(), side * (0.0012 + 0.0063 * angle.cos()), 0.004)
        };
        for k in 0..=24 {
            let p = outline(f64::from(k) / 24.0);
            mesh.positions.extend([p, p * DVec3::new(1.0, 1.0, 0.0)].map(|p| p.as_vec3().to_array()));
        }
        for k in 0..24 {
            let a = 2 * k;
            mesh.triangles
                .extend([[a, a + 1, a + 2], [a + 1, a + 3, a + 2], [0, a, a + 2]].into_iter().filter(|t| t[0] != t[1]));
        }
        mesh.triangles.extend([[0, 48, 49], [0, 49, 1]]);
        mesh
    };
    let pose = turned(place, [0.0, 0.0, 1.0], turn, 1.0);
    studio.add("screw", half(1.0), material, pose);
    studio.add("screw", half(-1.0), material, pose);
}
