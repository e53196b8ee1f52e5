//! Materials and textures of recipes.

use std::f64::consts::TAU;

use serde::Deserialize;

use super::composition::Composition;
use super::objects::LETTERS;
use crate::built::parts::materials::{body_of_glass, diffuse, glossy, metal, repeated};
use crate::built::parts::noise::{Random, fractal, smooth};
use crate::built::parts::patterns::{mix, paint};
use crate::built::parts::textures::{normal_map_of, with_alpha};
use crate::{
    Alpha, Anisotropy, Clearcoat, DiffuseTransmission, Material, NormalMap, Sheen, Texture, TextureInfo,
    TextureTransform, Wrap,
};

/// Textures of a scene, beside those of its floor and walls: more take time, and tell little more.
const TEXTURES: usize = 6;

/// A kind of material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Surface {
    /// Lambertian.
    #[default]
    Matte,
    /// A dielectric coat over a color: plastic, glaze.
    Glossy,
    /// A clear coat over a rougher surface.
    Coated,
    Cloth,
    Metal,
    /// Metal with a direction.
    Brushed,
    /// Clear or colored glass; a pane where the body is open.
    Glass,
    /// Partly transparent: a veil, or holes.
    Veil,
    /// Light passes, and is scattered.
    Translucent,
    Luminous,
}

/// A kind of texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Pattern {
    /// No texture.
    #[default]
    Plain,
    Grain,
    Clouds,
    Checks,
    Stripes,
    Dots,
    Bricks,
    Wood,
    Cells,
    Letters,
    /// One of the user's images.
    Image,
}

/// Adds a material for a body.
pub(super) fn material(c: &mut Composition, is_closed: bool) -> usize {
    let kind = c.recipe.surfaces.pick(&mut c.random);
    let color = color(&mut c.random);
    let random = &mut c.random;
    let material = match kind {
        Surface::Matte => diffuse(color),
        Surface::Glossy => glossy(color, random.between(0.08, 0.5) as f32),
        Surface::Coated => {
            let coat = Clearcoat { factor: 1.0, roughness: random.between(0.02, 0.2) as f32, ..Clearcoat::default() };
            Material { clearcoat: Some(coat), ..glossy(color, random.between(0.3, 0.8) as f32) }
        }
        Surface::Cloth => {
            let sheen = Sheen { color: color.map(|c| 0.5 + 0.5 * c), roughness: 0.4, ..Sheen::default() };
            Material { sheen: Some(sheen), ..diffuse(color) }
        }
        Surface::Metal => metal(pale(color), random.between(0.03, 0.5) as f32),
        Surface::Brushed => {
            let anisotropy = Anisotropy {
                strength: random.between(0.4, 0.9) as f32,
                rotation_rad: random.between(0.0, TAU) as f32,
                texture: None,
            };
            Material { anisotropy: Some(anisotropy), ..metal(pale(color), random.between(0.15, 0.4) as f32) }
        }
        Surface::Glass if is_closed => body_of_glass(random.between(0.05, 0.6) as f32, pale(color)),
        Surface::Glass => {
            let [r, g, b] = pale(color);
            Material { transmission: 1.0, base_color: [r, g, b, 1.0], ..glossy([1.0; 3], 0.0) }
        }
        Surface::Veil => {
            let [r, g, b] = color;
            let alpha = random.between(0.25, 0.85) as f32;
            Material { base_color: [r, g, b, alpha], alpha: Alpha::Blend, ..diffuse(color) }
        }
        Surface::Translucent => {
            let through = DiffuseTransmission { factor: 0.6, color, ..DiffuseTransmission::default() };
            Material { diffuse_transmission: Some(through), ..diffuse(color) }
        }
        Surface::Luminous => {
            let strength = random.between(0.5, 3.0) as f32;
            Material { emission: color.map(|c| c * strength), ..diffuse([0.02; 3]) }
        }
    };
    let has_texture = !matches!(kind, Surface::Glass | Surface::Luminous | Surface::Metal | Surface::Brushed);
    let times = if has_texture { Some(c.random.between(1.0, 2.5)) } else { None };
    let material = times.map_or(material.clone(), |times| dressed(c, material, times, kind == Surface::Veil));
    c.studio.material(name(kind), material)
}

/// Adds a material for a floor or a wall, whose texture is repeated.
pub(super) fn ground(c: &mut Composition) -> usize {
    let color = color(&mut c.random);
    let material = match c.random.unit() {
        x if x < 0.75 => diffuse(color),
        _ => glossy(color, c.random.between(0.25, 0.6) as f32),
    };
    let times = c.random.between(2.0_f64.ln(), 8.0_f64.ln()).exp();
    let pattern = c.recipe.textures.patterns.pick(&mut c.random);
    let material = match texture(c, pattern, 512) {
        Some(texture) => Material { base_color: [1.0; 4], ..repeated(texture, [times as f32; 2], material) },
        None => material,
    };
    c.studio.material("ground", material)
}

/// Adds a material for leaves, whose colors are those of the mesh.
pub(super) fn leaf(c: &mut Composition) -> usize {
    let through = DiffuseTransmission { factor: 0.25, color: [0.5, 0.7, 0.2], ..DiffuseTransmission::default() };
    c.studio.material("leaf", Material { diffuse_transmission: Some(through), ..diffuse([1.0; 3]) })
}

/// With a texture and a normal map, if they are drawn.
fn dressed(c: &mut Composition, material: Material, times: f64, has_holes: bool) -> Material {
    let pattern = c.recipe.textures.patterns.pick(&mut c.random);
    let number = match c.textures.len() < TEXTURES {
        true => {
            let made = texture(c, pattern, 256);
            c.textures.extend(made);
            made
        }
        false if pattern == Pattern::Plain => None,
        false => Some(c.textures[c.random.index(c.textures.len())]),
    };
    let mut out = material;
    if let Some(texture) = number {
        let transform = TextureTransform {
            scale: [times as f32; 2],
            rotation_rad: c.random.between(0.0, TAU) as f32,
            ..TextureTransform::IDENTITY
        };
        let [r, g, b, alpha] = out.base_color;
        // Some are tinted: objects with one texture differ.
        let tint = if c.random.chance(0.5) { [1.0; 3] } else { pale([r, g, b]) };
        out.base_color = [tint[0], tint[1], tint[2], alpha];
        out.base_color_texture = Some(TextureInfo { transform, ..TextureInfo::new(texture) });
    }
    if has_holes && c.random.chance(0.5) {
        let (across, share) = (c.random.between(4.0, 12.0), c.random.between(0.15, 0.4));
        let plain = paint("holes", 256, Wrap::Repeat, |_, _| [1.0; 3]);
        let is_solid = move |x: f64, y: f64| {
            let middle = |t: f64| (t * across).rem_euclid(1.0) - 0.5;
            f64::from(u8::from(middle(x).hypot(middle(y)) > share))
        };
        let texture = c.studio.texture(with_alpha(plain, is_solid));
        out = Material { alpha: Alpha::Mask(0.5), base_color_texture: Some(TextureInfo::new(texture)), ..out };
        out.base_color[3] = 1.0;
    }
    if c.random.chance(c.recipe.textures.relief) {
        let (across, own) = (c.random.between(6.0, 40.0), c.random.between(0.0, 99.0));
        let height = move |x: f64, y: f64| 0.25 / across * smooth([x * across, y * across, own]);
        let texture = c.studio.texture(normal_map_of("relief", height));
        out.normal_map = Some(NormalMap { texture: TextureInfo::new(texture), scale: 1.0 });
    }
    out
}

/// Adds a texture; `None` if it is plain.
fn texture(c: &mut Composition, pattern: Pattern, size: usize) -> Option<usize> {
    let across = c.recipe.textures.across.log(&mut c.random);
    let texture = match pattern {
        Pattern::Plain => return None,
        Pattern::Image if c.models.images.is_empty() => return None,
        Pattern::Image => c.models.images[c.random.index(c.models.images.len())].clone(),
        pattern => {
            // Four texels for what is finest.
            let size = size.max(((8.0 * across) as usize).next_power_of_two()).min(1024);
            painted(pattern, across, size, &mut c.random)
        }
    };
    Some(c.studio.texture(texture))
}

fn painted(pattern: Pattern, across: f64, size: usize, random: &mut Random) -> Texture {
    let [a, b] = [color(random), color(random)].map(|color| color.map(f64::from));
    let (own, share, angle) = (random.between(0.0, 99.0), random.between(0.3, 0.7), random.between(0.0, TAU));
    // Half of them are equal to the last texel where they repeat.
    let grain = if random.chance(0.5) { random.between(0.05, 0.35) } else { 0.0 };
    let wrap =
        if matches!(pattern, Pattern::Grain | Pattern::Clouds | Pattern::Wood) { Wrap::Mirror } else { Wrap::Repeat };
    // What repeats has a whole number of pieces.
    let count = across.round().max(1.0);
    let (sin, cos) = angle.sin_cos();
    let pick = |is_first: bool| if is_first { a } else { b };
    let base = move |x: f64, y: f64| -> [f64; 3] {
        let (column, row) = ((x * count).floor(), (y * count).floor());
        let (fx, fy) = (x * count - column, y * count - row);
        match pattern {
            Pattern::Plain | Pattern::Image => a,
            Pattern::Grain => a.map(|c| c * (1.0 + 0.8 * fractal([x * across, y * across, own], 3))),
            Pattern::Clouds => mix(a, b, (0.5 + fractal([x * across, y * across, own], 4)).clamp(0.0, 1.0)),
            Pattern::Checks => pick((column + row).rem_euclid(2.0) < 1.0),
            Pattern::Stripes => pick(((x * cos + y * sin) * across).rem_euclid(1.0) < share),
            Pattern::Dots => pick((fx - 0.5).hypot(fy - 0.5) < 0.5 * share),
            Pattern::Bricks => {
                let along = (0.5 * x * count + 0.5 * row.rem_euclid(2.0)).rem_euclid(1.0);
                let edge = (2.0 * along.min(1.0 - along)).min(fy.min(1.0 - fy));
                let tone = 0.8 + 0.4 * hash(column.div_euclid(2.0), row, own);
                if edge < 0.06 { b } else { a.map(|c| c * tone) }
            }
            Pattern::Wood => {
                let ring = (0.3 * across * (x + 0.3 * fractal([x * 2.0, y * 0.6, own], 2))).rem_euclid(1.0);
                mix(a, b, ring.powi(2)).map(|c| c * (1.0 - 0.2 * fractal([x * 160.0, y * 8.0, own], 2).max(0.0)))
            }
            Pattern::Cells => cells([x * count, y * count], count, own, [a, b]),
            Pattern::Letters => {
                let letter = LETTERS[(hash(column, row, own) * LETTERS.len() as f64) as usize % LETTERS.len()];
                let [u, v] = [fx, fy].map(|t| ((t - 0.15) / 0.7 * 5.0).floor());
                let is_in = (0.0..5.0).contains(&u) && (0.0..5.0).contains(&v);
                pick(is_in && letter[v as usize % 5] >> (4 - u as usize % 5) & 1 == 1)
            }
        }
    };
    paint("pattern", size, wrap, move |x, y| {
        let tone = if grain > 0.0 { 1.0 + grain * fractal([x * 90.0, y * 90.0, own], 2) } else { 1.0 };
        base(x, y).map(|c| (c * tone).clamp(0.0, 1.0))
    })
}

/// Irregular cells with joints.
fn cells([x, y]: [f64; 2], count: f64, own: f64, [a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    let (mut nearest, mut second, mut tone) = (f64::INFINITY, f64::INFINITY, 1.0);
    for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (f64::from(i), f64::from(j)))) {
        let (column, row) = (x.floor() + i, y.floor() + j);
        let (wrapped, below) = (column.rem_euclid(count), row.rem_euclid(count));
        let point = [column + hash(wrapped, below, own), row + hash(wrapped, below, own + 1.0)];
        let distance = (x - point[0]).hypot(y - point[1]);
        if distance < nearest {
            (second, nearest, tone) = (nearest, distance, 0.6 + 0.7 * hash(wrapped, below, own + 2.0));
        } else {
            second = second.min(distance);
        }
    }
    if second - nearest < 0.08 { b } else { a.map(|c| c * tone) }
}

/// A number from 0 to 1 for a place.
fn hash(column: f64, row: f64, own: f64) -> f64 {
    Random::of(&[column.to_bits(), row.to_bits(), own.to_bits()]).unit()
}

/// A linear color of any hue, neither black nor white.
pub(super) fn color(random: &mut Random) -> [f32; 3] {
    let (hue, saturation) = (random.between(0.0, 3.0), random.unit().powf(0.7) * 0.95);
    let value = 0.04 * 20.0_f64.powf(random.unit());
    [0.0, 1.0, 2.0].map(|channel: f64| {
        let away = (hue - channel).abs();
        let share = 1.0 - away.min(3.0 - away).min(1.0);
        (value * (1.0 - saturation * (1.0 - share))) as f32
    })
}

/// A color near white: of metals and glass.
fn pale(color: [f32; 3]) -> [f32; 3] {
    let most = color.into_iter().fold(1e-6, f32::max);
    color.map(|c| 0.5 + 0.48 * c / most)
}

fn name(kind: Surface) -> &'static str {
    match kind {
        Surface::Matte => "matte",
        Surface::Glossy => "glossy",
        Surface::Coated => "coated",
        Surface::Cloth => "cloth",
        Surface::Metal => "metal",
        Surface::Brushed => "brushed",
        Surface::Glass => "glass",
        Surface::Veil => "veil",
        Surface::Translucent => "translucent",
        Surface::Luminous => "luminous",
    }
}
