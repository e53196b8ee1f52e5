//! Procedural textures of the studio scenes: wood, cloth, stone, paper, normal maps and roughness maps.

use std::f64::consts::FRAC_1_SQRT_2;

use super::noise::{Random, fractal, smooth};
use super::patterns::{mix, paint};
use crate::{Filter, Texture, Wrap};

/// Oiled planks along y, `planks` of them side by side. Not periodic: one per piece of furniture.
pub(crate) fn wood(name: &str, dark: [f64; 3], light: [f64; 3], planks: f64, seed: f64) -> Texture {
    paint(name, 768, Wrap::Clamp, |x, y| {
        let plank = (x * planks).floor();
        let own = 17.3 * plank + seed;
        let across = x * planks - plank;
        // Growth rings of a trunk that is not quite straight.
        let bend = 0.6 * fractal([x * 3.0 + own, y * 1.2, seed], 2);
        let ring = ((across - 0.4 + bend) * (7.0 + 2.0 * smooth([own, 0.5, 0.5]))).rem_euclid(1.0);
        let late = ring.powi(3) * (1.0 - ((ring - 0.9) * 10.0).max(0.0));
        let pore = fractal([x * 260.0, y * 14.0, own], 2).max(0.0);
        let tone = 1.0 + 0.16 * smooth([own, 3.0, 7.0]) + 0.08 * fractal([x * 9.0, y * 5.0, own], 2) - 0.22 * pore;
        let gap = if across.min(1.0 - across) < 0.006 * planks / 5.0 { 0.35 } else { 1.0 };
        mix(light, dark, (0.15 + 0.75 * late).clamp(0.0, 1.0)).map(|c| c * tone * gap)
    })
}

/// Woven linen with stripes (color, relative width) across x; periodic.
pub(crate) fn striped_linen(stripes: &[([f64; 3], f64)]) -> Texture {
    paint("striped linen", 512, Wrap::Repeat, |x, y| {
        let mut rest = x;
        let mut color = stripes[0].0;
        for &(own, width) in stripes {
            color = own;
            rest -= width;
            if rest < 0.0 {
                break;
            }
        }
        let (warp, weft) = ((x * 64.0 * std::f64::consts::TAU).sin(), (y * 64.0 * std::f64::consts::TAU).sin());
        color.map(|c| c * (0.92 + 0.08 * warp * weft))
    })
}

/// A cloth of crossing bands, like a kitchen towel; periodic.
pub(crate) fn checked_linen(ground: [f64; 3], band: [f64; 3]) -> Texture {
    paint("checked linen", 512, Wrap::Repeat, |x, y| {
        let on = |t: f64| {
            f64::from(u8::from((0.30..0.70).contains(&t) || (0.08..0.12).contains(&t) || (0.88..0.92).contains(&t)))
        };
        let thread = (x * 96.0 * std::f64::consts::TAU).sin() * (y * 96.0 * std::f64::consts::TAU).sin();
        let share = 0.5 * (on(x) + on(y));
        mix(ground, band, share).map(|c| c * (0.93 + 0.07 * thread))
    })
}

/// Felt, card or plaster: one color with fine grain and faint clouds. Not periodic.
pub(crate) fn grained(name: &str, color: [f64; 3], grain: f64) -> Texture {
    paint(name, 512, Wrap::Clamp, |x, y| {
        let fine = fractal([x * 110.0, y * 110.0, 2.0], 2);
        let broad = fractal([x * 4.0, y * 4.0, 6.0], 3);
        color.map(|c| c * (1.0 + grain * fine + 0.4 * grain * broad))
    })
}

/// A painted tile: a rosette in a ring with quarter flowers in the corners. Exactly periodic.
pub(crate) fn azulejo() -> Texture {
    paint("azulejo", 512, Wrap::Repeat, |x, y| {
        let (white, blue, pale, ochre) =
            ([0.80, 0.79, 0.73], [0.025, 0.075, 0.30], [0.28, 0.42, 0.62], [0.62, 0.36, 0.06]);
        let edge = x.min(1.0 - x).min(y.min(1.0 - y));
        if edge < 0.012 {
            return [0.42, 0.39, 0.34];
        }
        let flower = |dx: f64, dy: f64, petals: f64, size: f64| {
            let (radius, angle) = (dx.hypot(dy) / size, dy.atan2(dx));
            radius / (0.72 + 0.28 * (petals * angle).cos())
        };
        let (dx, dy) = (x - 0.5, y - 0.5);
        let radius = dx.hypot(dy);
        let rosette = flower(dx, dy, 8.0, 0.25);
        let star = flower(dy, dx, 4.0, 0.13);
        let corner = flower(dx.abs() - 0.5, dy.abs() - 0.5, 8.0, 0.24);
        let brush = 1.0 + 0.10 * fractal([x * 22.0, y * 22.0, 1.0], 3);
        let color = match () {
            () if star < 0.5 => ochre,
            () if star < 1.0 => white,
            () if rosette < 0.86 => blue,
            () if rosette < 1.0 => white,
            () if (0.355..0.385).contains(&radius) || (0.40..0.41).contains(&radius) => blue,
            () if corner < 0.45 => ochre,
            () if corner < 0.8 => blue,
            () if corner < 0.98 => pale,
            () if (0.27..0.355).contains(&radius) && ((dy.atan2(dx) * 16.0).sin() > 0.2) => pale,
            () => white,
        };
        color.map(|c| c * brush)
    })
}

/// Wallpaper with leaves and dots in a half-drop pattern; periodic.
pub(crate) fn wallpaper(ground: [f64; 3], leaf: [f64; 3], dot: [f64; 3]) -> Texture {
    paint("wallpaper", 512, Wrap::Repeat, |x, y| {
        let drawn = |cx: f64, cy: f64| {
            let wrap = |t: f64| t - t.round();
            let (dx, dy) = (wrap(x - cx), wrap(y - cy));
            // A twig with three pairs of leaves and a berry.
            let mut best = f64::INFINITY;
            for k in 0..3 {
                let base = 0.14 - 0.12 * f64::from(k);
                for side in [-1.0, 1.0] {
                    let (u, v) = (dx * side - 0.065, dy - base + 0.055);
                    let (along, across) = ((u - v) * FRAC_1_SQRT_2, (u + v) * FRAC_1_SQRT_2);
                    best = best.min((along / 0.085).powi(2) + (across / 0.030).powi(2));
                }
            }
            let stem = if dx.abs() < 0.006 && dy.abs() < 0.17 { 0.5 } else { 2.0 };
            (best.min(stem), (dx.hypot(dy + 0.20) / 0.030).min((dx - 0.25).hypot(dy - 0.02) / 0.016))
        };
        let (first, second) = (drawn(0.25, 0.5), drawn(0.75, 0.0));
        let cloth = 1.0 + 0.05 * smooth([x * 128.0, y * 128.0, 3.0]);
        let color = if first.1.min(second.1) < 1.0 {
            dot
        } else if first.0.min(second.0) < 1.0 {
            leaf
        } else {
            ground
        };
        color.map(|c| c * cloth)
    })
}

/// A metallic-roughness map (green: roughness, blue: metallic, 1): streaks along y around `mean`. Approximately
/// periodic.
pub(crate) fn brushed(mean: f64, spread: f64) -> Texture {
    linear_texture("brushed", 512, |x, y| {
        let streak = 0.7 * smooth([x * 70.0, y * 3.0, 4.0]) + 0.5 * fractal([x * 8.0, y * 5.0, 9.0], 3);
        [1.0, (mean + spread * streak).clamp(0.05, 1.0), 1.0, 1.0]
    })
}

/// A normal map of the periodic height field `height(x, y)`, with heights in widths of the image.
pub(crate) fn normal_map_of(name: &str, height: impl Fn(f64, f64) -> f64) -> Texture {
    let step = 1.0 / 512.0;
    linear_texture(name, 512, |x, y| {
        let slope_x = (height(x + step, y) - height(x - step, y)) / (2.0 * step);
        let slope_y = (height(x, y + step) - height(x, y - step)) / (2.0 * step);
        let normal = glam::DVec3::new(-slope_x, slope_y, 1.0).normalize();
        [0.5 + 0.5 * normal.x, 0.5 + 0.5 * normal.y, 0.5 + 0.5 * normal.z, 1.0]
    })
}

/// A normal map of the pores of a fruit peel, periodic.
pub(crate) fn peel() -> Texture {
    let mut random = Random::new(23);
    let pores: Vec<[f64; 3]> = (0..900).map(|_| [random.unit(), random.unit(), random.between(0.006, 0.013)]).collect();
    let mut cells = vec![Vec::new(); 32 * 32];
    for pore in &pores {
        cells[(pore[1] * 32.0) as usize * 32 + (pore[0] * 32.0) as usize].push(*pore);
    }
    normal_map_of("peel", move |x, y| {
        let wrap = |t: f64| t - t.round();
        let (column, row) = ((x * 32.0).floor() as i64, (y * 32.0).floor() as i64);
        let mut depth = 0.0;
        for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
            let cell = (row + j).rem_euclid(32) * 32 + (column + i).rem_euclid(32);
            for [px, py, size] in &cells[cell as usize] {
                let distance = wrap(x - px).hypot(wrap(y - py)) / size;
                depth += 0.2 * size * (1.0 - distance * distance).max(0.0).powi(2);
            }
        }
        -depth
    })
}

/// A texture of linear RGBA values, 0 to 1.
pub(crate) fn linear_texture(name: &str, size: usize, value: impl Fn(f64, f64) -> [f64; 4]) -> Texture {
    let texels = (0..size * size)
        .map(|k| {
            let (x, y) = (((k % size) as f64 + 0.5) / size as f64, ((k / size) as f64 + 0.5) / size as f64);
            value(x, y).map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
        })
        .collect();
    Texture {
        name: name.into(),
        width: size,
        height: size,
        texels,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: Filter::Linear,
    }
}

/// Adds alpha to a color texture.
pub(crate) fn with_alpha(mut texture: Texture, alpha: impl Fn(f64, f64) -> f64) -> Texture {
    let (width, height) = (texture.width, texture.height);
    for (k, texel) in texture.texels.iter_mut().enumerate() {
        let (x, y) = (((k % width) as f64 + 0.5) / width as f64, ((k / width) as f64 + 0.5) / height as f64);
        texel[3] = (alpha(x, y).clamp(0.0, 1.0) * 255.0).round() as u8;
    }
    texture
}

/// Sky over hills and a garden, out of focus.
pub(crate) fn landscape() -> Texture {
    paint("landscape", 512, Wrap::Clamp, |x, y| {
        let up = 1.0 - y;
        let sky = mix([0.80, 0.83, 0.84], [0.46, 0.62, 0.80], ((up - 0.45) * 1.9).clamp(0.0, 1.0));
        let cloud = (fractal([x * 3.0, y * 6.0, 5.0], 4) * 1.6).clamp(0.0, 1.0);
        let sky = mix(sky, [0.93, 0.92, 0.89], 0.7 * cloud);
        let hill = |height: f64, rough: f64, seed: f64| height + rough * fractal([x * 4.0, seed, 0.5], 3);
        let edge = |height: f64| ((height - up) * 26.0 + 0.5).clamp(0.0, 1.0);
        let far = mix(sky, [0.40, 0.52, 0.56], edge(hill(0.46, 0.06, 1.0)));
        let middle = mix(far, [0.27, 0.40, 0.27], edge(hill(0.38, 0.07, 7.0)));
        let near = [0.20, 0.33, 0.13].map(|c| c * (1.0 + 0.5 * fractal([x * 12.0, y * 12.0, 2.0], 3)));
        mix(middle, near, edge(hill(0.28, 0.05, 13.0)))
    })
}
