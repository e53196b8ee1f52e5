//! Pool balls, just broken, on a green cloth.
//!
//! **Purpose**: specular highlights. **Difficulty**: every ball is an almost textureless sphere that mirrors the lamps
//! above the table; the highlights lie at depths of their own, behind the surface, and move from view to view.

use glam::DVec3;

use crate::built::parts::materials::{diffuse, glossy, textured};
use crate::built::parts::noise::Random;
use crate::built::parts::patterns::{mix, paint};
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, turned};
use crate::built::parts::textures::{grained, wood};
use crate::{Scene, Texture, Transform, Wrap};

/// Radius of a ball, m.
const RADIUS: f64 = 0.0286;

pub(super) fn scene() -> Scene {
    let mut textures = vec![
        grained("cloth", [0.030, 0.165, 0.105], 0.22),
        wood("rail", [0.06, 0.02, 0.01], [0.20, 0.075, 0.03], 1.0, 5.0),
    ];
    textures.extend((0..16).map(ball));
    let mut studio = Studio::new(textures);
    let cloth = studio.material("cloth", textured(0, diffuse([1.0; 3])));
    let rail = studio.material("rail", textured(1, glossy([1.0; 3], 0.18)));
    let phenolic: Vec<usize> =
        (0..16).map(|k| studio.material("phenolic", textured(2 + k, glossy([1.0; 3], 0.06)))).collect();
    let ivory = studio.material("ferrule", glossy([0.82, 0.78, 0.66], 0.2));
    let leather = studio.material("leather", diffuse([0.10, 0.16, 0.28]));
    let maple = studio.material("maple", glossy([0.66, 0.44, 0.22], 0.2));
    let brass = studio.material("sight", glossy([0.85, 0.80, 0.68], 0.15));

    table(&mut studio, cloth, rail, brass);

    let mut random = Random::new(9);
    let places = [
        (0, -0.060, 0.125),
        (1, 0.050, 0.020),
        (2, -0.160, -0.020),
        (3, 0.150, 0.085),
        (4, 0.005, -0.095),
        (5, -0.105, -0.130),
        (6, 0.215, -0.055),
        (7, -0.255, -0.165),
        (8, 0.105, -0.150),
        (9, -0.035, 0.028),
        (10, 0.285, -0.205),
        (11, -0.020, -0.240),
        (12, -0.215, 0.062),
        (13, 0.170, -0.270),
        (14, -0.165, -0.290),
        (15, 0.045, -0.325),
    ];
    for (number, x, z) in places {
        let axis = [random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        // The numbers face the camera, more or less.
        let turn = turned([x, RADIUS, z], axis, random.between(-55.0, 55.0), RADIUS);
        let facing = turned([0.0; 3], [-1.0, 0.25, 0.0], -28.0, 1.0);
        studio.add(&format!("ball {number}"), shapes::ball(96, 48, |_| 0.0), phenolic[number], turn.after(&facing));
    }
    cue(&mut studio, leather, ivory, maple);

    studio.room([0.075, 0.065, 0.055]);
    for x in [-0.42, 0.0, 0.42] {
        studio.softbox("lamp", [x, 0.85, -0.12], [x, 0.0, -0.12], [0.26, 0.26], [7.4, 6.5, 5.0]);
    }
    studio.softbox("window", [-1.1, 0.6, 0.75], [0.0, 0.0, -0.1], [0.5, 0.8], [0.8, 1.0, 1.35]);
    studio.with_camera([0.03, 0.275, 0.585], [0.0, -0.002, -0.070])
}

/// The bed, a cushion and the rail of the table, and the panelling behind it.
fn table(studio: &mut Studio, cloth: usize, rail: usize, brass: usize) {
    studio.add(
        "bed",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.0, 0.95 * t - 0.58)),
        cloth,
        Transform::IDENTITY,
    );
    let cushion = shapes::sheet(1, 12, |s, t| {
        // From the top of the rail over the nose down to the bed.
        let angle = t * 2.6;
        DVec3::new(
            s - 0.5,
            0.030 + 0.011 * angle.cos() - 0.02 * (t - 0.6).max(0.0),
            -0.395 + 0.02 * angle.sin() - 0.035 * (1.0 - t),
        )
    });
    studio.add("cushion", cushion, cloth, Transform::IDENTITY);
    studio.add("rail", rounded_box([0.99, 0.06, 0.12], 0.006), rail, at(0.0, 0.016, -0.482));
    for x in [-0.30, 0.0, 0.30] {
        studio.add(
            "sight",
            shapes::ball(24, 12, |_| 0.0),
            brass,
            Transform::from_parts([x, 0.0455, -0.47], [0.0, 0.0, 0.0, 1.0], [0.006, 0.002, 0.006]),
        );
    }
    let backdrop = studio.material("panelling", textured(1, glossy([0.55; 3], 0.5)));
    studio.add(
        "panelling",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.45 - 0.5 * t, -0.57)),
        backdrop,
        Transform::IDENTITY,
    );
}

/// The cue, which comes in from the lower right.
fn cue(studio: &mut Studio, leather: usize, ivory: usize, maple: usize) {
    let cue = |low: f64, high: f64, thick: [f64; 2]| {
        lathe(48, 3, &[[0.0, high], [thick[1], high], [thick[0], low], [0.0, low]])
    };
    let pose = turned([-0.035, 0.048, 0.165], [0.30, 0.0, -0.95], 82.0, 1.0);
    studio.add("tip", cue(0.0, 0.006, [0.0058, 0.0062]), leather, pose);
    studio.add("ferrule", cue(0.006, 0.028, [0.0063, 0.0064]), ivory, pose);
    studio.add("shaft", cue(0.028, 0.33, [0.0064, 0.0075]), maple, pose);
}

/// The equirectangular texture of a ball: plain up to 8, striped from 9, the cue ball with a dot.
fn ball(number: usize) -> Texture {
    let ivory = [0.78, 0.74, 0.64];
    let hues = [
        [0.78, 0.74, 0.64],
        [0.80, 0.47, 0.02],
        [0.02, 0.07, 0.34],
        [0.62, 0.025, 0.02],
        [0.13, 0.03, 0.24],
        [0.80, 0.20, 0.02],
        [0.01, 0.19, 0.09],
        [0.25, 0.02, 0.03],
        [0.012, 0.012, 0.014],
    ];
    let hue = hues[if number > 8 { number - 8 } else { number }];
    paint("ball", 512, Wrap::Repeat, |x, y| {
        let (longitude, latitude) = (x * std::f64::consts::TAU, y * std::f64::consts::PI);
        let p = DVec3::new(latitude.sin() * longitude.cos(), latitude.cos(), -latitude.sin() * longitude.sin());
        let body = if number > 8 && p.y.abs() > 0.58 { ivory } else { hue };
        if number == 0 {
            let dot = [DVec3::X, DVec3::Y, DVec3::Z].iter().any(|axis| p.dot(*axis).abs() > 0.992);
            return if dot { [0.55, 0.03, 0.03] } else { ivory };
        }
        // A white circle on both sides; the digits are upright in it.
        let side = p.z.signum();
        let (u, v, within) = (side * p.x, p.y, p.z.abs() > 0.87);
        if !within {
            return body;
        }
        let ink = digits(number, u / 0.52 + 0.5, 0.5 - v / 0.52);
        let rim = ((p.z.abs() - 0.87) / 0.006).clamp(0.0, 1.0);
        mix(body, if ink { [0.02, 0.02, 0.022] } else { ivory }, rim)
    })
}

/// Whether (x, y) in the unit square lies on the digits of the number, in a font of 3 by 5 squares.
fn digits(number: usize, x: f64, y: f64) -> bool {
    const FONT: [u16; 10] = [0o75557, 0o26227, 0o71747, 0o71717, 0o55711, 0o74717, 0o74757, 0o71111, 0o75757, 0o75717];
    let shown: &[usize] = if number > 9 { &[number / 10, number % 10] } else { &[number] };
    let width = 4.0 * shown.len() as f64 - 1.0;
    let (column, row) = ((x - 0.5) * 10.5 + 0.5 * width, (y - 0.5) * 9.0 + 2.5);
    if !(0.0..width).contains(&column) || !(0.0..5.0).contains(&row) {
        return false;
    }
    let (digit, column) = (column as usize / 4, column as usize % 4);
    column < 3 && FONT[shown[digit]] >> (3 * (4 - row as usize) + 2 - column) & 1 == 1
}
