//! Old bottles of thick colored glass on a window sill, the light behind them.
//!
//! **Purpose**: colored thick glass, whose color depends on the path length in it. **Difficulty**: a pixel shows up to
//! four surfaces and their background; colored light falls through the bottles onto the sill.

use crate::built::parts::materials::{body_of_glass, diffuse, glossy, textured};
use crate::built::parts::solids::{lathe, rounded_box};
use crate::built::parts::studio::{Studio, at, rectangle, turned, upright};
use crate::built::parts::textures::{self, grained};
use crate::{Material, Mesh, Scene, TextureInfo, Transform};

pub(super) fn scene() -> Scene {
    let mut studio = Studio::new(vec![textures::landscape(), grained("sill", [0.70, 0.63, 0.52], 0.12)]);
    let sill = studio.material("sill", textured(1, glossy([1.0; 3], 0.5)));
    let frame = studio.material("frame", glossy([0.80, 0.79, 0.76], 0.4));
    let outside = studio.material(
        "outside",
        Material {
            emission: [0.95; 3],
            emission_texture: Some(TextureInfo::new(0)),
            double_sided: false,
            ..diffuse([0.0; 3])
        },
    );
    let cork = studio.material("cork", diffuse([0.42, 0.27, 0.15]));
    let colors = [
        ("cobalt", body_of_glass(0.0065, [0.10, 0.22, 0.72])),
        ("amber", body_of_glass(0.008, [0.80, 0.34, 0.045])),
        ("emerald", body_of_glass(0.008, [0.16, 0.62, 0.26])),
        ("ruby", body_of_glass(0.008, [0.72, 0.06, 0.075])),
        ("aqua", body_of_glass(0.016, [0.40, 0.80, 0.76])),
    ]
    .map(|(name, glass)| studio.material(name, glass));

    studio.add("sill", rounded_box([0.98, 0.03, 0.42], 0.006), sill, at(0.0, -0.015, 0.0));
    window(&mut studio, outside, frame);

    // Walls of 3 to 5 mm; the profiles go up the inside and down the outside.
    let apothecary = apothecary();
    let flask = flask();
    let tall = tall_bottle();
    let stopper = lathe(
        96,
        6,
        &[[0.0, 0.035], [0.008, 0.034], [0.0145, 0.026], [0.0135, 0.016], [0.0072, 0.010], [0.0066, 0.0], [0.0, 0.0]],
    );
    studio.add("apothecary", apothecary.clone(), colors[1], upright([-0.040, 0.0, 0.020], 0.0));
    studio.add("tall bottle", tall.clone(), colors[0], at(-0.132, 0.0, -0.045));
    studio.add("flask", flask.clone(), colors[2], at(0.068, 0.0, -0.060));
    studio.add("small bottle", apothecary, colors[3], turned([0.158, 0.0, 0.010], [0.0, 1.0, 0.0], 0.0, 0.80));
    studio.add("tall bottle", tall, colors[4], turned([0.008, 0.0, -0.115], [0.0, 1.0, 0.0], 0.0, 1.06));
    studio.add("stopper", stopper, colors[3], turned([0.105, 0.0138, 0.085], [0.35, 0.2, 1.0], 84.0, 1.0));
    studio.add(
        "cork",
        lathe(48, 4, &[[0.0, 0.146], [0.0092, 0.1455], [0.0098, 0.1438], [0.0078, 0.115], [0.0, 0.114]]),
        cork,
        at(-0.040, 0.0, 0.020),
    );
    studio.add(
        "cork",
        lathe(48, 4, &[[0.0, 0.155], [0.0086, 0.1545], [0.0092, 0.1528], [0.0074, 0.125], [0.0, 0.124]]),
        cork,
        at(0.068, 0.0, -0.060),
    );

    studio.room([0.43, 0.40, 0.345]);
    studio.softbox("sky", [0.15, 0.95, -0.75], [0.0, 0.0, 0.05], [1.1, 0.6], [5.5, 5.6, 5.7]);
    studio.with_camera([-0.015, 0.155, 0.60], [-0.004, 0.082, -0.05])
}

/// The view and the frame of the window: posts, a lower rail, a crossbar.
fn window(studio: &mut Studio, outside: usize, frame: usize) {
    let [width, height] = [0.99, 0.62];
    let pane = Transform {
        columns: [[width, 0.0, 0.0], [0.0, height, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0, 0.27, -0.36],
    };
    studio.add("outside", rectangle(), outside, pane);
    // The frame: two posts, a crossbar, a lower rail.
    for (x, thick) in [(-0.29, 0.014), (0.118, 0.010), (0.42, 0.014)] {
        studio.add("post", rounded_box([2.0 * thick, 0.56, 0.03], 0.003), frame, at(x, 0.25, -0.20));
    }
    studio.add("rail", rounded_box([0.98, 0.035, 0.036], 0.004), frame, at(0.0, 0.0165, -0.20));
    studio.add("crossbar", rounded_box([0.98, 0.018, 0.026], 0.003), frame, at(0.0, 0.262, -0.20));
}

/// A bottle with round shoulders.
fn apothecary() -> Mesh {
    lathe(
        128,
        7,
        &[
            [0.0, 0.0075],
            [0.023, 0.009],
            [0.0275, 0.014],
            [0.0275, 0.084],
            [0.023, 0.097],
            [0.0095, 0.106],
            [0.0085, 0.128],
            [0.0105, 0.1295],
            [0.0145, 0.1285],
            [0.0150, 0.1240],
            [0.0128, 0.1215],
            [0.0128, 0.111],
            [0.0265, 0.101],
            [0.0315, 0.086],
            [0.0315, 0.005],
            [0.0285, 0.0008],
            [0.0, 0.0008],
        ],
    )
}

/// A conical flask.
fn flask() -> Mesh {
    lathe(
        128,
        7,
        &[
            [0.0, 0.006],
            [0.027, 0.008],
            [0.039, 0.028],
            [0.037, 0.045],
            [0.0185, 0.072],
            [0.0085, 0.092],
            [0.0080, 0.136],
            [0.0105, 0.139],
            [0.0140, 0.138],
            [0.0138, 0.133],
            [0.0115, 0.130],
            [0.0118, 0.094],
            [0.0215, 0.0745],
            [0.0408, 0.047],
            [0.0430, 0.028],
            [0.031, 0.0035],
            [0.028, 0.0008],
            [0.0, 0.0008],
        ],
    )
}

/// A slender bottle.
fn tall_bottle() -> Mesh {
    lathe(
        128,
        7,
        &[
            [0.0, 0.012],
            [0.016, 0.009],
            [0.0212, 0.013],
            [0.0215, 0.118],
            [0.0165, 0.140],
            [0.0082, 0.158],
            [0.0078, 0.196],
            [0.0098, 0.1985],
            [0.0128, 0.1978],
            [0.0130, 0.1925],
            [0.0108, 0.190],
            [0.0112, 0.160],
            [0.0200, 0.142],
            [0.0252, 0.119],
            [0.0252, 0.004],
            [0.0225, 0.0008],
            [0.0, 0.0008],
        ],
    )
}
