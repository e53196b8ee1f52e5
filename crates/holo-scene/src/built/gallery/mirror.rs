//! A dressing table: a round mirror in a brass frame, a vase with twigs of cotton, a candlestick, a string of pearls.
//!
//! **Purpose**: a mirror. **Difficulty**: the mirror image lies behind the surface and has the disparity of that depth,
//! while the ground truth is the surface itself; the wallpaper repeats.

use glam::DVec3;

use crate::built::parts::materials::{BRASS, SILVER, diffuse, glossy, metal, repeated, textured};
use crate::built::parts::noise::{Random, fractal};
use crate::built::parts::shapes;
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, rectangle, turned, upright};
use crate::built::parts::textures::{landscape, wallpaper, wood};
use crate::{Material, Mesh, Scene, TextureInfo, Transform};

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![
        wallpaper([0.42, 0.50, 0.44], [0.155, 0.27, 0.20], [0.60, 0.23, 0.12]),
        wood("table", [0.10, 0.045, 0.02], [0.30, 0.155, 0.075], 4.0, 31.0),
        landscape(),
    ]);
    let wall = studio.material("wallpaper", repeated(0, [9.0, 5.0], diffuse([1.0; 3])));
    let table = studio.material("table", textured(1, glossy([1.0; 3], 0.25)));
    let mirror = studio.material("mirror", metal(SILVER, 0.0));
    let brass = studio.material("brass", metal(BRASS, 0.22));
    let glaze = studio.material("glaze", glossy([0.035, 0.13, 0.19], 0.07));
    let wax = studio.material("wax", glossy([0.80, 0.73, 0.60], 0.35));
    let twig = studio.material("twig", diffuse([0.13, 0.08, 0.045]));
    let cotton = studio.material("cotton", diffuse([0.84, 0.80, 0.74]));
    let pearl = studio.material("pearl", glossy([0.80, 0.72, 0.66], 0.12));
    let card = studio.material("card", diffuse([0.72, 0.30, 0.20]));

    studio.add(
        "wall",
        shapes::sheet(1, 1, |s, t| DVec3::new(s - 0.5, 0.54 - 0.56 * t, -0.34)),
        wall,
        Transform::IDENTITY,
    );
    studio.add("table", rounded_box([0.99, 0.03, 0.64], 0.004), table, at(0.0, -0.015, -0.02));

    mirror_on_stand(&mut studio, mirror, brass);

    let vase = vase();
    let vase_at = [0.155, 0.0, -0.075];
    studio.add("vase", vase, glaze, Transform::from_translation(vase_at));
    twigs(&mut studio, vase_at, twig, cotton);

    candlestick(&mut studio, brass, wax, twig);

    pearls(&mut studio, pearl);
    // A small box in front: the mirror shows its other side.
    let casket = turned([-0.115, 0.019, 0.065], [0.0, 1.0, 0.0], 24.0, 1.0);
    studio.add("casket", rounded_box([0.082, 0.034, 0.056], 0.004), card, casket);
    studio.add("lid", rounded_box([0.086, 0.006, 0.060], 0.0025), brass, casket.after(&at(0.0, 0.019, 0.0)));

    window(&mut studio, 2);
    studio.room([0.26, 0.245, 0.22]);
    studio.softbox("window", [-0.95, 0.75, 0.70], [0.0, 0.1, -0.1], [0.55, 0.75], [4.6, 4.5, 4.3]);
    studio.softbox("lamp", [0.9, 0.95, 0.1], [0.1, 0.1, -0.1], [0.3, 0.3], [5.0, 3.7, 2.3]);
    studio.with_camera([0.050, 0.250, 0.665], [-0.006, 0.119, -0.075])
}

/// The mirror, which leans back a little and faces to the right, with its frame and foot.
fn mirror_on_stand(studio: &mut Studio, mirror: usize, brass: usize) {
    let stand = upright([-0.045, 0.0, -0.20], 10.0);
    let lean = turned([0.0, 0.165, 0.0], [1.0, 0.0, 0.0], 2.5, 1.0);
    let glass = shapes::sheet(128, 1, |s, t| {
        let (angle, radius) = (-s * std::f64::consts::TAU, 0.118 * (0.001 + 0.999 * t));
        DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
    });
    studio.add("mirror", glass, mirror, stand.after(&lean));
    let hoop = shapes::tube(
        192,
        24,
        |_| 0.0065,
        |s| {
            let angle = s * std::f64::consts::TAU;
            DVec3::new(0.121 * angle.cos(), 0.121 * angle.sin(), 0.0)
        },
    );
    studio.add("frame", hoop, brass, stand.after(&lean));
    let foot = lathe(
        96,
        5,
        &[
            [0.0, 0.048],
            [0.006, 0.046],
            [0.008, 0.03],
            [0.016, 0.016],
            [0.05, 0.009],
            [0.062, 0.005],
            [0.0625, 0.0005],
            [0.06, 0.0],
            [0.0, 0.0],
        ],
    );
    studio.add("foot", foot, brass, stand);
}

/// The vase.
fn vase() -> Mesh {
    lathe(
        96,
        6,
        &[
            [0.0, 0.008],
            [0.022, 0.012],
            [0.036, 0.04],
            [0.030, 0.075],
            [0.014, 0.103],
            [0.0165, 0.120],
            [0.0185, 0.1215],
            [0.0205, 0.120],
            [0.018, 0.103],
            [0.034, 0.075],
            [0.040, 0.04],
            [0.026, 0.006],
            [0.024, 0.0],
            [0.0, 0.0],
        ],
    )
}

/// The candlestick with a candle.
fn candlestick(studio: &mut Studio, brass: usize, wax: usize, wick: usize) {
    let candlestick = lathe(
        72,
        5,
        &[
            [0.0, 0.098],
            [0.0115, 0.098],
            [0.0125, 0.0965],
            [0.012, 0.082],
            [0.005, 0.074],
            [0.0045, 0.045],
            [0.009, 0.038],
            [0.0045, 0.031],
            [0.006, 0.018],
            [0.034, 0.007],
            [0.036, 0.004],
            [0.0355, 0.0],
            [0.0, 0.0],
        ],
    );
    studio.add("candlestick", candlestick, brass, at(-0.215, 0.0, -0.065));
    let candle = lathe(
        48,
        4,
        &[[0.0, 0.2015], [0.004, 0.2025], [0.0088, 0.204], [0.0095, 0.2025], [0.0095, 0.098], [0.0, 0.098]],
    );
    studio.add("candle", candle, wax, at(-0.215, 0.0, -0.065));
    let wick_mesh = shapes::tube(8, 8, |_| 0.0006, |s| DVec3::new(0.002 * s * s, 0.2 + 0.012 * s, 0.0));
    studio.add("wick", wick_mesh, wick, at(-0.215, 0.0, -0.065));
}

/// The string of pearls.
fn pearls(studio: &mut Studio, pearl: usize) {
    let bead = studio.add_mesh("pearl", shapes::ball(32, 16, |_| 0.0), pearl);
    for k in 0..46 {
        let angle = f64::from(k) / 46.0 * std::f64::consts::TAU;
        let radius = 0.056 + 0.012 * (2.0 * angle + 0.6).sin() + 0.007 * (3.0 * angle).cos();
        let size = 0.0043;
        let place = [0.008 + 1.25 * radius * angle.cos(), size, 0.072 + 0.75 * radius * angle.sin()];
        studio.add_instance("pearl", bead, Transform::from_parts(place, [0.0, 0.0, 0.0, 1.0], [size; 3]));
    }
}

/// A window behind the camera, for the mirror to show: a view, with bars before it.
fn window(studio: &mut Studio, view: usize) {
    let outside = studio.material(
        "view",
        Material {
            emission: [1.15; 3],
            emission_texture: Some(TextureInfo::new(view)),
            double_sided: false,
            ..diffuse([0.0; 3])
        },
    );
    let bar =
        studio.material("bar", Material { emission: [0.055, 0.05, 0.045], double_sided: false, ..diffuse([0.0; 3]) });
    // Faces -Z, so that x runs the other way.
    let pose = |center: [f64; 3], [wide, high]: [f64; 2]| Transform {
        columns: [[-wide, 0.0, 0.0], [0.0, high, 0.0], [0.0, 0.0, -1.0]],
        translation: center,
    };
    let [x, y, z] = [0.05, 0.33, 1.28];
    studio.add("view", rectangle(), outside, pose([x, y, z], [1.5, 1.2]));
    for k in 0..5 {
        studio.add("bar", rectangle(), bar, pose([x + 0.375 * (f64::from(k) - 2.0), y, z - 0.01], [0.05, 1.3]));
    }
    for k in 0..4 {
        studio.add("bar", rectangle(), bar, pose([x, y + 0.4 * (f64::from(k) - 1.5), z - 0.02], [1.55, 0.05]));
    }
}

/// Five twigs of cotton out of the vase.
fn twigs(studio: &mut Studio, vase: [f64; 3], twig: usize, cotton: usize) {
    let mut random = Random::new(41);
    let boll = studio.add_mesh("boll", shapes::ball(48, 24, |d| 0.22 * fractal((d * 2.1).to_array(), 4)), cotton);
    for k in 0..5 {
        let heading = 1.25 * f64::from(k) + 0.5;
        let (lean, height) = (random.between(0.035, 0.085), random.between(0.15, 0.235));
        let root = DVec3::from(vase) + DVec3::Y * 0.02;
        let path = move |s: f64| {
            let out = lean * s * s + 0.004 * (9.0 * s + heading).sin() * s;
            root + DVec3::new(heading.cos() * out, height * s, heading.sin() * out)
        };
        studio.add("twig", shapes::tube(32, 8, |s| 0.0016 * (1.0 - 0.5 * s), path), twig, Transform::IDENTITY);
        for step in 0..4 {
            let s = 0.62 + 0.125 * f64::from(step);
            let place = path(s) + DVec3::new(random.between(-0.008, 0.008), 0.004, random.between(-0.008, 0.008));
            let size = random.between(0.0085, 0.0125);
            studio.add_instance(
                "boll",
                boll,
                turned(place.to_array(), [0.3, 1.0, 0.2], random.between(0.0, 360.0), size),
            );
        }
    }
}
