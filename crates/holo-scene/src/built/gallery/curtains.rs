//! Lace curtains before a window, a veil behind them, a vase on the sill between the two.
//!
//! **Purpose**: transparency by alpha, as holes (lace) and as opacity (veil). **Difficulty**: a pixel shows up to four
//! layers at once; the holes repeat and are about as wide as a pixel; what is behind is visible in pieces.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::built::parts::materials::{BRASS, alpha_masked, diffuse, glossy, metal, repeated, textured};
use crate::built::parts::noise::Random;
use crate::built::parts::patterns::paint;
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, turned};
use crate::built::parts::textures::{grained, with_alpha};
use crate::{Alpha, Material, Mesh, Scene, Texture, Transform, Wrap};

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![lace(), petals(), grained("wall", [0.060, 0.150, 0.140], 0.12), veil_stripes()]);
    let lace = studio.material("lace", alpha_masked(0, [7.0, 5.0], diffuse([1.0; 3])));
    let veil = studio.material("veil", Material { alpha: Alpha::Blend, ..repeated(3, [26.0, 1.0], diffuse([1.0; 3])) });
    let wall = studio.material("wall", textured(2, diffuse([1.0; 3])));
    let sill = studio.material("sill", glossy([0.42, 0.255, 0.14], 0.3));
    let rod = studio.material("rod", metal(BRASS, 0.25));
    let porcelain = studio.material("porcelain", glossy([0.66, 0.33, 0.06], 0.08));
    let stem = studio.material("stem", diffuse([0.10, 0.21, 0.06]));
    let petal = studio.material("petal", alpha_masked(1, [1.0, 1.0], diffuse([1.0; 3])));
    let heart = studio.material("heart", diffuse([0.70, 0.42, 0.04]));

    studio.add(
        "wall",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.52 - 0.56 * t, -0.40)),
        wall,
        Transform::IDENTITY,
    );
    studio.add("sill", rounded_box([0.98, 0.028, 0.62], 0.005), sill, at(0.0, -0.014, -0.10));

    drapes(&mut studio, lace, veil, rod);
    frames(&mut studio, rod);

    let vase_at = DVec3::new(0.030, 0.0, -0.075);
    let vase = vase();
    studio.add("vase", vase, porcelain, Transform::from_translation(vase_at.to_array()));
    let corolla = studio.add_mesh("petals", corolla(), petal);
    let disc = studio.add_mesh("heart", shapes::ball(24, 12, |_| 0.0), heart);
    let mut random = Random::new(19);
    for k in 0..9 {
        let heading = 2.4 * f64::from(k) + 0.3;
        let (lean, height) = (random.between(0.02, 0.085), random.between(0.13, 0.215));
        let path = move |s: f64| {
            let out = lean * s * s;
            vase_at + DVec3::new(heading.cos() * out, 0.05 + height * s, heading.sin() * out * 0.7)
        };
        studio.add("stem", shapes::tube(24, 8, |_| 0.0013, path), stem, Transform::IDENTITY);
        let top = path(1.0).to_array();
        let size = random.between(0.026, 0.034);
        // Flowers face the light and outward.
        let pose = turned(top, [0.75, 0.0, -heading.cos()], random.between(38.0, 66.0), size);
        studio.add_instance("petals", corolla, pose);
        studio.add_instance(
            "heart",
            disc,
            pose.after(&Transform::from_parts([0.0, 0.03, 0.0], [0.0, 0.0, 0.0, 1.0], [0.22, 0.12, 0.22])),
        );
    }

    studio.room([0.17, 0.175, 0.185]);
    studio.softbox("window", [0.80, 0.75, 0.70], [0.0, 0.12, -0.1], [0.35, 0.42], [10.0, 9.3, 8.2]);
    studio.softbox("behind", [-0.80, 0.75, -0.10], [0.0, 0.1, -0.25], [0.30, 0.4], [8.0, 8.0, 8.2]);
    studio.with_camera([-0.045, 0.175, 0.640], [0.008, 0.155, -0.06])
}

/// Two lace curtains, drawn aside, the veil behind the flowers, and their rods.
fn drapes(studio: &mut Studio, lace: usize, veil: usize, rod: usize) {
    for (side, open) in [(-1.0, 0.030), (1.0, 0.085)] {
        let curtain = shapes::sheet(240, 60, |s, t| {
            // Gathered above, bound aside below.
            let gather = 0.70 + 0.30 * (1.0 - ((t - 0.72) / 0.5).powi(2)).clamp(0.0, 1.0);
            let x = open + 0.36 * s * (1.0 - 0.30 * gather * t) + 0.10 * t * t * (1.0 - s);
            let fold = (s * TAU * 6.5 + 0.7 * t).sin() * (0.012 + 0.004 * t) + 0.004 * (s * TAU * 2.0).sin();
            DVec3::new(side * x, 0.405 - 0.40 * t, 0.035 + fold)
        });
        studio.add("lace", curtain, lace, Transform::IDENTITY);
    }
    let drape = shapes::sheet(200, 16, |s, t| {
        let fold = (s * TAU * 9.0 + 0.5 * t).sin() * 0.011 + 0.005 * (s * TAU * 3.3).sin();
        DVec3::new(-0.46 + 0.92 * s, 0.41 - 0.408 * t, -0.23 + fold)
    });
    studio.add("veil", drape, veil, Transform::IDENTITY);
    for (z, y) in [(0.035, 0.40), (-0.23, 0.405)] {
        studio.add(
            "rod",
            shapes::tube(2, 24, |_| 0.005, |s| DVec3::new(-0.49 + 0.98 * s, y, z)),
            rod,
            Transform::IDENTITY,
        );
    }
}

/// Frames on the wall, visible through everything.
fn frames(studio: &mut Studio, rod: usize) {
    for (x, y, wide, high) in [(-0.17, 0.225, 0.13, 0.17), (0.09, 0.26, 0.17, 0.12), (0.31, 0.20, 0.10, 0.14)] {
        studio.add("frame", rounded_box([wide, high, 0.014], 0.003), rod, at(x, y, -0.391));
        let card = studio.material("print", diffuse([0.74, 0.70, 0.61]));
        studio.add("print", rounded_box([wide - 0.022, high - 0.022, 0.004], 0.001), card, at(x, y, -0.384));
        let ink = studio.material("ink", diffuse([0.50, 0.16, 0.10]));
        studio.add(
            "print",
            shapes::ball(48, 24, |_| 0.0),
            ink,
            Transform::from_parts([x, y, -0.382], [0.0, 0.0, 0.0, 1.0], [0.25 * wide, 0.25 * wide, 0.001]),
        );
    }
}

/// The vase.
fn vase() -> Mesh {
    lathe(
        96,
        7,
        &[
            [0.0, 0.008],
            [0.020, 0.010],
            [0.034, 0.045],
            [0.031, 0.072],
            [0.016, 0.112],
            [0.0205, 0.138],
            [0.0222, 0.1392],
            [0.0240, 0.138],
            [0.0195, 0.112],
            [0.0350, 0.072],
            [0.0382, 0.045],
            [0.0250, 0.003],
            [0.0235, 0.0],
            [0.0, 0.0],
        ],
    )
}

/// Nets of threads with flowers; alpha is 1 on threads. Periodic.
fn lace() -> Texture {
    let flower = |x: f64, y: f64| {
        let wrap = |t: f64| t - t.round();
        let (dx, dy) = (wrap(x - 0.5), wrap(y - 0.5));
        let (radius, angle) = (dx.hypot(dy), dy.atan2(dx));
        let petal = radius / (0.30 + 0.07 * (6.0 * angle).cos());
        let (ex, ey) = (wrap(x), wrap(y));
        (petal, ex.hypot(ey), radius, angle)
    };
    let thread = move |x: f64, y: f64| {
        let (petal, dot, radius, angle) = flower(x, y);
        let mesh = |count: f64| {
            let (u, v) = ((x + y) * count, (x - y) * count);
            let near = |t: f64| (t - t.round()).abs();
            near(u).min(near(v)) < 0.17
        };
        let outline = (petal - 1.0).abs() < 0.10 || (petal - 0.62).abs() < 0.07;
        let rays = petal < 1.0 && petal > 0.62 && ((angle * 24.0 / TAU).fract() - 0.5).abs() > 0.22;
        let heart = radius < 0.085 && radius > 0.03;
        let work = outline || rays || heart || (0.045..0.085).contains(&dot) || dot < 0.02;
        let ground = mesh(12.0);
        f64::from(u8::from(work || ground))
    };
    with_alpha(paint("lace", 512, Wrap::Repeat, |_, _| [0.80, 0.77, 0.70]), thread)
}

/// A row of threads of varying thickness: the opacity of the veil. Periodic.
fn veil_stripes() -> Texture {
    let plain = paint("veil", 128, Wrap::Repeat, |_, _| [0.72, 0.74, 0.76]);
    with_alpha(plain, |x, _| if x < 0.12 { 0.75 } else { 0.34 + 0.06 * (x * 6.0 * TAU).sin() })
}

/// A ring of petals in a square; alpha cuts them out.
fn petals() -> Texture {
    let petal = |x: f64, y: f64| {
        let (dx, dy) = (2.0 * x - 1.0, 2.0 * y - 1.0);
        (dx.hypot(dy), dy.atan2(dx))
    };
    let color = paint("petals", 512, Wrap::Clamp, |x, y| {
        let (radius, angle) = petal(x, y);
        let vein = 1.0 + 0.10 * (angle * 84.0).sin();
        [0.80 * vein, (0.66 - 0.34 * (1.0 - radius).powi(2)) * vein, (0.60 - 0.22 * (1.0 - radius)) * vein]
    });
    with_alpha(color, |x, y| {
        let (radius, angle) = petal(x, y);
        f64::from(u8::from(radius < 0.62 + 0.36 * (7.0 * angle).cos().abs().powf(0.55)))
    })
}

/// A shallow bowl of radius 1 about +Y with the square image seen from above.
fn corolla() -> Mesh {
    shapes::sheet(20, 20, |s, t| {
        let (x, z) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        DVec3::new(x, 0.22 * (x * x + z * z) - 0.05 * (x * x + z * z).powi(2), z)
    })
}
