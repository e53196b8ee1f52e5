//! Procedural textures of the garden, and the functions that all procedural textures use.

use super::noise::{Random, fractal, smooth};
use crate::{Filter, Texture, Wrap};

/// A texture from a function of linear color at (x, y) in 0..1.
pub(crate) fn paint(name: &str, size: usize, wrap: Wrap, color: impl Fn(f64, f64) -> [f64; 3]) -> Texture {
    let texels = (0..size * size)
        .map(|k| {
            let (x, y) = (((k % size) as f64 + 0.5) / size as f64, ((k / size) as f64 + 0.5) / size as f64);
            let [r, g, b] = color(x, y).map(|c| holo_core::color::linear_to_srgb8(c as f32));
            [r, g, b, 255]
        })
        .collect();
    Texture { name: name.into(), width: size, height: size, texels, wrap_u: wrap, wrap_v: wrap, filter: Filter::Linear }
}

/// Linear interpolation from `a` at 0 to `b` at 1.
pub(crate) fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
}

/// Old brickwork, 8 courses high; periodic.
pub(crate) fn bricks() -> Texture {
    let mut random = Random::new(11);
    let tones: Vec<f64> = (0..64).map(|_| random.between(0.65, 1.25)).collect();
    paint("bricks", 1024, Wrap::Repeat, |x, y| {
        let row = (y * 8.0).floor();
        let along = (x * 4.0 + 0.5 * (row as i64 & 1) as f64).rem_euclid(4.0);
        let (column, fx, fy) = (along.floor(), along.fract(), (y * 8.0).fract());
        let edge = (fx.min(1.0 - fx) * 2.0).min(fy.min(1.0 - fy));
        let rough = fractal([x * 40.0, y * 40.0, 1.0], 4);
        let brick = ((edge + 0.025 * rough - 0.05) / 0.03).clamp(0.0, 1.0);
        let tone = tones[(row as usize * 4 + column as usize) % 64] * (1.0 + 0.25 * rough);
        let clay = [0.42 * tone, 0.14 * tone, 0.085 * tone];
        let mortar = [0.48, 0.45, 0.40].map(|c| c * (1.0 + 0.2 * rough));
        std::array::from_fn(|c| mortar[c] + (clay[c] - mortar[c]) * brick)
    })
}

/// Moss and gravel; not periodic.
pub(crate) fn ground() -> Texture {
    paint("ground", 1024, Wrap::Clamp, |x, y| {
        let broad = fractal([x * 6.0, y * 6.0, 3.0], 4);
        let fine = fractal([x * 120.0, y * 120.0, 5.0], 3);
        let moss = ((broad + 0.15) * 3.0).clamp(0.0, 1.0);
        let stone = 0.30 + 0.16 * fine;
        let green = 1.0 + 0.5 * fine;
        let (gravel, mossy) = ([stone, stone * 0.93, stone * 0.80], [0.09 * green, 0.17 * green, 0.035 * green]);
        std::array::from_fn(|c| gravel[c] + (mossy[c] - gravel[c]) * moss)
    })
}

/// Glazed tiles in rings and rays, with fine detail at every scale.
pub(crate) fn mosaic() -> Texture {
    paint("mosaic", 1024, Wrap::Clamp, |x, y| {
        let (dx, dy) = (x - 0.5, y - 0.5);
        let (radius, angle) = (dx.hypot(dy), dy.atan2(dx) / std::f64::consts::TAU + 0.5);
        let ring = (radius * 18.0).floor();
        let tiles = (6.0 * ring + 3.0).max(3.0);
        let place = (angle * tiles).rem_euclid(tiles);
        let (fr, fa) = ((radius * 18.0).fract(), place.fract());
        let joint = fr.min(1.0 - fr).min(fa.min(1.0 - fa) * 1.4) < 0.07;
        if joint {
            return [0.62, 0.60, 0.55];
        }
        let tone = 0.85 + 0.3 * smooth([ring * 3.7, place.floor() * 1.9, 9.0]);
        let palette =
            [[0.02, 0.12, 0.38], [0.75, 0.62, 0.30], [0.03, 0.33, 0.36], [0.55, 0.10, 0.05], [0.80, 0.78, 0.70]];
        let pick = (ring as usize * 2 + (place as usize).is_multiple_of(3) as usize) % palette.len();
        palette[pick].map(|c: f64| c * tone)
    })
}
