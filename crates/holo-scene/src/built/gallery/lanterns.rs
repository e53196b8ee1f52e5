//! Paper lanterns over a pond of pebbles at dusk; candles in cups.
//!
//! **Purpose**: emissive light, from many colored lamps in the scene. **Difficulty**: emissive surfaces have hardly any
//! shading; light comes from within the scene and falls off fast; the shadows are many, soft and colored.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::built::parts::materials::{BRASS, diffuse, glossy, metal, textured};
use crate::built::parts::noise::{Random, fractal};
use crate::built::parts::patterns::paint;
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, turned};
use crate::built::parts::textures::{grained, wood};
use crate::{Material, Scene, Texture, TextureInfo, Transform, Wrap};

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![
        lantern_paper(),
        grained("screen", [0.20, 0.27, 0.38], 0.15),
        wood("deck", [0.22, 0.14, 0.095], [0.50, 0.34, 0.23], 9.0, 71.0),
    ]);
    let screen = studio.material("screen", textured(1, diffuse([1.0; 3])));
    let deck = studio.material("deck", textured(2, glossy([1.0; 3], 0.35)));
    let lacquer = studio.material("lacquer", glossy([0.018, 0.016, 0.018], 0.15));
    let gold = studio.material("gold", metal(BRASS, 0.25));
    let flame = studio.material("flame", Material { emission: [3.2, 1.7, 0.55], ..diffuse([0.0; 3]) });
    let wax = studio.material("wax", Material { emission: [0.26, 0.12, 0.035], ..diffuse([0.72, 0.62, 0.46]) });
    let cup = studio.material("cup", glossy([0.10, 0.20, 0.19], 0.15));
    let stones = [[0.30, 0.30, 0.31], [0.17, 0.18, 0.195], [0.42, 0.39, 0.35], [0.10, 0.105, 0.115]]
        .map(|c| studio.material("stone", glossy(c, 0.32)));
    let branch = studio.material("branch", diffuse([0.17, 0.11, 0.075]));
    let blossom = studio.material("blossom", diffuse([0.76, 0.50, 0.52]));

    backdrop(&mut studio, screen, lacquer, deck);

    hang_lanterns(&mut studio, lacquer, gold);

    candles(&mut studio, cup, wax, flame);
    pebbles(&mut studio, &stones);
    twig(&mut studio, branch, blossom);

    studio.room([0.034, 0.050, 0.084]);
    studio.softbox("dusk", [-0.9, 0.85, 0.55], [0.0, 0.1, -0.1], [0.7, 0.7], [1.0, 1.45, 2.2]);
    studio.with_camera([0.025, 0.185, 0.610], [-0.002, 0.125, -0.08])
}

/// The screen with its posts and bars, and the deck.
fn backdrop(studio: &mut Studio, screen: usize, lacquer: usize, deck: usize) {
    studio.add(
        "screen",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.50 - 0.52 * t, -0.38)),
        screen,
        Transform::IDENTITY,
    );
    for k in 0..6 {
        let x = 0.18 * (f64::from(k) - 2.5);
        studio.add(
            "post",
            shapes::cuboid([x - 0.005, 0.0, -0.378], [x + 0.005, 0.5, -0.366]),
            lacquer,
            Transform::IDENTITY,
        );
    }
    for y in [0.14, 0.30] {
        studio.add(
            "bar",
            shapes::cuboid([-0.495, y - 0.004, -0.377], [0.495, y + 0.004, -0.367]),
            lacquer,
            Transform::IDENTITY,
        );
    }
    studio.add("deck", rounded_box([0.98, 0.024, 0.72], 0.004), deck, at(0.0, -0.012, -0.04));
}

/// The lanterns on their cords.
fn hang_lanterns(studio: &mut Studio, lacquer: usize, gold: usize) {
    // (place, size, color): from far to near.
    let lamps = [
        ([-0.235, 0.235, -0.27], 0.040, [0.95, 0.40, 0.11]),
        ([-0.085, 0.275, -0.215], 0.044, [0.98, 0.60, 0.24]),
        ([0.085, 0.245, -0.25], 0.036, [0.90, 0.20, 0.075]),
        ([0.225, 0.270, -0.185], 0.042, [0.98, 0.54, 0.19]),
        ([-0.150, 0.165, -0.115], 0.040, [0.92, 0.24, 0.085]),
        ([0.130, 0.170, -0.065], 0.044, [1.0, 0.62, 0.26]),
    ];
    let body = lathe(96, 8, &[[0.34, 0.80], [0.72, 0.62], [0.98, 0.20], [0.98, -0.20], [0.72, -0.62], [0.34, -0.80]]);
    let body = lantern_bodies(studio, body, &lamps);
    let cap = studio.add_mesh(
        "cap",
        lathe(48, 4, &[[0.0, 0.90], [0.30, 0.90], [0.37, 0.885], [0.37, 0.79], [0.0, 0.79]]),
        lacquer,
    );
    let tassel = studio.add_mesh(
        "tassel",
        lathe(
            24,
            4,
            &[
                [0.0, -0.78],
                [0.30, -0.79],
                [0.34, -0.80],
                [0.34, -0.88],
                [0.03, -0.89],
                [0.03, -1.02],
                [0.075, -1.08],
                [0.10, -1.42],
                [0.0, -1.43],
            ],
        ),
        gold,
    );
    for ((place, size, _), mesh) in lamps.into_iter().zip(body) {
        let pose = turned(place, [0.0, 1.0, 0.0], 900.0 * size, size);
        studio.add_instance("lantern", mesh, pose);
        studio.add_instance("cap", cap, pose);
        studio.add_instance("tassel", tassel, pose);
        let top = 0.46 - place[1] - 0.9 * size;
        studio.add(
            "cord",
            shapes::tube(2, 6, |_| 0.0006, |s| DVec3::new(0.0, 0.9 * size + top * s, 0.0)),
            lacquer,
            Transform::from_translation(place),
        );
    }
}

/// Candles in cups on the deck.
fn candles(studio: &mut Studio, cup: usize, wax: usize, flame: usize) {
    let saucer = lathe(
        64,
        6,
        &[
            [0.0, 0.004],
            [0.017, 0.005],
            [0.0215, 0.012],
            [0.0225, 0.020],
            [0.0235, 0.0205],
            [0.0245, 0.020],
            [0.0235, 0.011],
            [0.0185, 0.0],
            [0.0, 0.0],
        ],
    );
    let candle = lathe(
        48,
        5,
        &[[0.0, 0.0275], [0.008, 0.0285], [0.0142, 0.0302], [0.0150, 0.0285], [0.0150, 0.005], [0.0, 0.005]],
    );
    let fire = lathe(24, 6, &[[0.0, 0.0215], [0.0012, 0.016], [0.0030, 0.0065], [0.0022, 0.0015], [0.0, 0.0]]);
    for (x, z, turn) in [(-0.055, 0.030, 10.0), (0.036, -0.105, 80.0), (0.150, 0.010, 150.0), (-0.195, -0.085, 200.0)] {
        studio.add("cup", saucer.clone(), cup, at(x, 0.0, z));
        studio.add("candle", candle.clone(), wax, at(x, 0.0, z));
        studio.add("flame", fire.clone(), flame, turned([x, 0.0305, z], [0.05, 1.0, 0.02], turn, 1.0));
    }
}

/// A lantern mesh with a material for every color.
fn lantern_bodies(studio: &mut Studio, body: crate::Mesh, lamps: &[([f64; 3], f64, [f32; 3])]) -> Vec<usize> {
    let glows = lamps.iter().map(|&(_, _, color)| {
        let emissive = Material {
            emission: color.map(|c| 0.92 * c),
            emission_texture: Some(TextureInfo::new(0)),
            double_sided: false,
            ..diffuse(color.map(|c| 0.5 * c))
        };
        let emissive = studio.material("lantern", emissive);
        studio.add_mesh("lantern", body.clone(), emissive)
    });
    glows.collect()
}

/// Ribs of bamboo and fibers of paper, brighter in the middle, where the flame is.
fn lantern_paper() -> Texture {
    paint("lantern", 256, Wrap::Repeat, |x, y| {
        let rib = (y * 13.0).fract();
        let rib = if rib < 0.10 { 0.45 } else { 0.88 + 0.12 * (rib * TAU).cos() };
        let middle = 1.0 - 0.62 * (2.0 * y - 0.9).abs().powf(1.7);
        let fiber = 1.0 + 0.10 * fractal([(x * TAU).cos() * 9.0, y * 30.0, (x * TAU).sin() * 9.0], 3);
        [1.0, 0.92 - 0.14 * (1.0 - middle), 0.85 - 0.25 * (1.0 - middle)].map(|c| c * rib * middle * fiber)
    })
}

/// Round stones in heaps along the front.
fn pebbles(studio: &mut Studio, stones: &[usize; 4]) {
    let kinds: Vec<usize> = (0..8)
        .map(|k| {
            let offset = 4.0 * k as f64;
            let mesh = shapes::ball(40, 20, |d| 0.16 * fractal((d * 0.9 + offset).to_array(), 2));
            studio.add_mesh("pebble", mesh, stones[k % 4])
        })
        .collect();
    let mut random = Random::new(29);
    for k in 0..110 {
        let heap = [(0.135, 0.105), (-0.165, 0.075), (0.27, -0.10)][k % 3];
        let (angle, out) = (random.between(0.0, TAU), random.unit().sqrt());
        let size = random.between(0.007, 0.017) * (1.1 - 0.4 * out);
        let (x, z) = (heap.0 + 0.105 * out * angle.cos(), heap.1 + 0.050 * out * angle.sin());
        let flat = random.between(0.5, 0.75);
        let turn =
            turned([x, 0.85 * flat * size + 0.008 * (1.0 - out), z], [0.1, 1.0, 0.1], random.between(0.0, 360.0), size);
        let squash = Transform { columns: [[1.0, 0.0, 0.0], [0.0, flat, 0.0], [0.0, 0.0, 0.8]], ..Transform::IDENTITY };
        studio.add_instance("pebble", kinds[(random.unit() * 8.0) as usize % 8], turn.after(&squash));
    }
}

/// A cherry branch that enters from above on the left.
fn twig(studio: &mut Studio, branch: usize, blossom: usize) {
    let mut random = Random::new(31);
    let flower = studio.add_mesh(
        "blossom",
        shapes::sheet(40, 6, |s, t| {
            let angle = -s * TAU;
            let radius = (0.04 + 0.96 * t) * (0.72 + 0.28 * (2.5 * angle).cos().abs());
            DVec3::new(radius * angle.cos(), 0.35 * t * t, radius * angle.sin())
        }),
        blossom,
    );
    for arm in 0..3 {
        let own = f64::from(arm);
        let path = move |s: f64| {
            let sway = 0.012 * (7.0 * s + 2.0 * own).sin() * s;
            DVec3::new(
                -0.34 + (0.26 - 0.05 * own) * s,
                0.345 - 0.055 * own - (0.06 + 0.045 * own) * s * s + sway,
                0.02 + 0.035 * own - 0.05 * s,
            )
        };
        studio.add("branch", shapes::tube(48, 10, |s| 0.0034 * (1.0 - 0.75 * s), path), branch, Transform::IDENTITY);
        for _ in 0..16 {
            let s = random.between(0.25, 1.0);
            let place = path(s)
                + DVec3::new(
                    random.between(-0.006, 0.006),
                    random.between(-0.004, 0.006),
                    random.between(-0.004, 0.008),
                );
            let axis = [random.between(-1.0, 1.0), 0.2, random.between(-1.0, 1.0)];
            studio.add_instance(
                "blossom",
                flower,
                turned(place.to_array(), axis, random.between(20.0, 140.0), random.between(0.006, 0.0095)),
            );
        }
    }
}
