//! Light of recipes: a sky, a sun, lamps and panels, in several colors.

use glam::DVec3;
use ndarray::Array3;

use super::composition::Composition;
use crate::built::parts::noise::{Random, fractal};
use crate::{Environment, Light, LightKind};

/// The size of a sky, rows.
const ROWS: usize = 64;

/// Lights a scene around a point; `scale` is the distance of the camera from it, m.
pub(super) fn add(c: &mut Composition, middle: DVec3, scale: f64) {
    let light = &c.recipe.light;
    // A sky that varies, or an even one as of a bright room.
    let sky = if c.random.chance(light.sky) { sky(&mut c.random) } else { even(&mut c.random) };
    c.studio.environment(sky);
    if c.random.chance(light.sun) {
        let toward = upward(&mut c.random);
        let size = c.random.between(0.0093_f64.ln(), 0.15_f64.ln()).exp();
        let lux = c.random.between(1.0, 6.0);
        let intensity = warm(&mut c.random).map(|c| c * lux);
        let kind = LightKind::Directional { direction: (-toward).to_array(), angular_diameter_rad: size };
        c.studio.light(Light { name: "sun".into(), intensity, kind });
    }
    for _ in 0..light.lamps.count(&mut c.random) {
        let place = middle + upward(&mut c.random) * (scale * c.random.between(0.8, 2.0));
        let lux = c.random.between(0.5, 3.0);
        let square = place.distance_squared(middle);
        let intensity = warm(&mut c.random).map(|c| c * lux * square);
        let (outer, direction) = (c.random.between(0.3, 1.2), (middle - place).normalize_or(DVec3::NEG_Y));
        let kind = LightKind::Spot {
            position: place.to_array(),
            direction: direction.to_array(),
            range: None,
            inner_angle_rad: 0.6 * outer,
            outer_angle_rad: outer,
        };
        c.studio.light(Light { name: "lamp".into(), intensity, kind });
    }
    for _ in 0..light.panels.count(&mut c.random) {
        let away = scale * c.random.between(1.2, 2.5);
        let place = middle + upward(&mut c.random) * away;
        let size = [(); 2].map(|()| scale * c.random.between(0.2, 1.0));
        let strength = c.random.between(0.5, 3.0) * (away / scale).powi(2) / (size[0] * size[1] / scale.powi(2));
        let radiance = warm(&mut c.random).map(|c| (c * strength.min(30.0)) as f32);
        c.studio.softbox("panel", place.to_array(), middle.to_array(), size, radiance);
    }
}

/// A direction at least 15 degrees above the horizon.
fn upward(random: &mut Random) -> DVec3 {
    let (turn, up) = (random.between(0.0, std::f64::consts::TAU), random.between(0.26, 0.98));
    let out = (1.0 - up * up).sqrt();
    DVec3::new(out * turn.cos(), up, out * turn.sin())
}

/// White, warmer or colder.
fn warm(random: &mut Random) -> [f64; 3] {
    let tone = random.between(-1.0, 1.0) * random.unit();
    [1.0 + 0.35 * tone, 1.0, 1.0 - 0.45 * tone]
}

fn even(random: &mut Random) -> Environment {
    let radiance = random.between(0.15, 0.6);
    let color = warm(random).map(|c| (c * radiance) as f32);
    Environment { radiance: Array3::from_shape_fn((1, 1, 3), |(_, _, c)| color[c]) }
}

/// A sky with clouds above a ground.
fn sky(random: &mut Random) -> Environment {
    let radiance = random.between(0.3, 1.2);
    let (high, low) = (random.between(0.3, 0.9), random.between(0.8, 1.3));
    let blue = random.between(0.0, 0.5);
    let ground = super::surface::color(random).map(|c| f64::from(c) * 0.6 + 0.05);
    let (clouds, own) = (random.between(0.0, 1.0), random.between(0.0, 99.0));
    let value = move |row: usize, column: usize, c: usize| {
        let up = (std::f64::consts::PI * (row as f64 + 0.5) / ROWS as f64).cos();
        if up < 0.0 {
            return (radiance * ground[c]) as f32;
        }
        let tint = [1.0 - blue, 1.0 - 0.5 * blue, 1.0][c];
        let height = low + (high - low) * up.sqrt();
        let turn = std::f64::consts::TAU * column as f64 / (2 * ROWS) as f64;
        let out = (1.0 - up * up).sqrt();
        let place = [2.0 * out * turn.cos(), 3.0 * up, 2.0 * out * turn.sin() + own];
        let cover = clouds * (1.5 * fractal(place, 4) + 0.3).clamp(0.0, 1.0);
        (radiance * (height * tint * (1.0 - cover) + 1.3 * cover)) as f32
    };
    Environment { radiance: Array3::from_shape_fn((ROWS, 2 * ROWS, 3), |(row, column, c)| value(row, column, c)) }
}
