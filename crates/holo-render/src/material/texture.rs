//! Texture lookup: bilinear in linear light, or the nearest texel.
//!
//! The texel (i, j) has its center at ((i + 0.5) / width, (j + 0.5) / height). sRGB is decoded before the four texels
//! are interpolated (as in Mitsuba; Cycles interpolates first, which is darker where they differ).

mod footprint;
mod pyramid;

pub(crate) use footprint::{TextureFootprint, TextureFootprints};
pub(crate) use pyramid::{AROUND_HITS, Filter as FootprintFilter, Filters as FootprintFilters, Pyramid};

use crate::simd::LANES;
use holo_scene::{Filter, Texture, Wrap};

/// Samples RGB at texture coordinates, (0, 0) being the upper left corner of the image; `table` decodes the 8-bit
/// codes.
#[inline(always)]
pub(crate) fn sample(texture: &Texture, table: &[f32; 256], coordinates: [f32; 2], filter: Filter) -> [f32; 3] {
    let (size, wrap) = ([texture.width, texture.height], [texture.wrap_u, texture.wrap_v]);
    let (texels, fraction) = neighbors(&texture.texels, size, wrap, filter, coordinates);
    let mut corners = [[0.0; 3]; 4];
    for corner in 0..4 {
        for c in 0..3 {
            corners[corner][c] = table[texels[corner][c] as usize];
        }
    }
    bilinear(&corners, fraction)
}

/// Interpolates four texels.
#[inline(always)]
fn bilinear<const N: usize>([a, b, c, d]: &[[f32; N]; 4], fraction: [f32; 2]) -> [f32; N] {
    let mut out = [0.0; N];
    for k in 0..N {
        out[k] = mix([a[k], b[k], c[k], d[k]], fraction);
    }
    out
}

/// Samples alpha, 0 to 1.
#[inline(always)]
pub(crate) fn sample_alpha(texture: &Texture, coordinates: [f32; 2]) -> f32 {
    let (size, wrap) = ([texture.width, texture.height], [texture.wrap_u, texture.wrap_v]);
    let ([a, b, c, d], fraction) = neighbors(&texture.texels, size, wrap, texture.filter, coordinates);
    let value = |texel: [u8; 4]| f32::from(texel[3]);
    mix([value(a), value(b), value(c), value(d)], fraction) / 255.0
}

/// [`sample`] at sixteen points, with bitwise identical results.
#[inline(always)]
pub(crate) fn sample_sixteen(texture: &Texture, table: &[f32; 256], [u, v]: &[[f32; LANES]; 2]) -> [[f32; LANES]; 3] {
    let columns = taps_of_sixteen(u, &[texture.width as u32; LANES], texture.wrap_u, texture.filter);
    let rows = taps_of_sixteen(v, &[texture.height as u32; LANES], texture.wrap_v, texture.filter);
    let mut out = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let (upper, lower) = (rows.first[lane] as usize * texture.width, rows.second[lane] as usize * texture.width);
        let (left, right) = (columns.first[lane] as usize, columns.second[lane] as usize);
        let texels = [upper + left, upper + right, lower + left, lower + right];
        let [a, b, c, d] = [texels[0], texels[1], texels[2], texels[3]];
        let [a, b, c, d] = [texture.texels[a], texture.texels[b], texture.texels[c], texture.texels[d]];
        let fraction = [columns.fraction[lane], rows.fraction[lane]];
        for k in 0..3 {
            let values = [table[a[k] as usize], table[b[k] as usize], table[c[k] as usize], table[d[k] as usize]];
            out[k][lane] = mix(values, fraction);
        }
    }
    out
}

/// The four texels around a point (upper left, upper right, lower left, lower right), and the interpolation weights to
/// the right and down.
#[inline(always)]
fn neighbors<T: Copy>(
    texels: &[T],
    [width, height]: [usize; 2],
    [wrap_u, wrap_v]: [Wrap; 2],
    filter: Filter,
    [u, v]: [f32; 2],
) -> ([T; 4], [f32; 2]) {
    let (columns, fraction_x) = taps(u, width as u32, wrap_u, filter);
    let (rows, fraction_y) = taps(v, height as u32, wrap_v, filter);
    let texel = |j: usize, i: usize| texels[rows[j] as usize * width + columns[i] as usize];
    ([texel(0, 0), texel(0, 1), texel(1, 0), texel(1, 1)], [fraction_x, fraction_y])
}

#[inline(always)]
fn mix([a, b, c, d]: [f32; 4], [x, y]: [f32; 2]) -> f32 {
    let (upper, lower) = (a + (b - a) * x, c + (d - c) * x);
    upper + (lower - upper) * y
}

/// Two adjacent texels along one axis and the interpolation weight of the second, for sixteen points.
#[derive(Clone, Copy)]
struct Taps {
    first: [u32; LANES],
    second: [u32; LANES],
    fraction: [f32; LANES],
}

/// One branch-free loop per wrap mode, so that the lanes are vectorized.
#[inline(always)]
fn taps_of_sixteen(coordinates: &[f32; LANES], sizes: &[u32; LANES], mode: Wrap, filter: Filter) -> Taps {
    let mut out = Taps { first: [0; LANES], second: [0; LANES], fraction: [0.0; LANES] };
    let mut whole = [0.0; LANES];
    let mut are_inside = true;
    for lane in 0..LANES {
        (whole[lane], out.fraction[lane]) = cell(coordinates[lane], sizes[lane]);
        are_inside &= is_inside(whole[lane], sizes[lane]);
    }
    if filter == Filter::Nearest {
        for lane in 0..LANES {
            out.fraction[lane] = nearest(out.fraction[lane]);
        }
    }
    if are_inside {
        for lane in 0..LANES {
            [out.first[lane], out.second[lane]] = [whole[lane] as u32, whole[lane] as u32 + 1];
        }
        return out;
    }
    match mode {
        Wrap::Repeat => {
            for lane in 0..LANES {
                [out.first[lane], out.second[lane]] = repeated(whole[lane], sizes[lane]);
            }
        }
        Wrap::Clamp => {
            for lane in 0..LANES {
                [out.first[lane], out.second[lane]] = clamped(whole[lane], sizes[lane]);
            }
        }
        Wrap::Mirror => {
            for lane in 0..LANES {
                [out.first[lane], out.second[lane]] = mirrored(whole[lane], sizes[lane]);
            }
        }
    }
    out
}

#[inline(always)]
fn taps(coordinate: f32, size: u32, mode: Wrap, filter: Filter) -> ([u32; 2], f32) {
    let (whole, fraction) = cell(coordinate, size);
    let indices = if is_inside(whole, size) {
        [whole as u32, whole as u32 + 1]
    } else {
        match mode {
            Wrap::Repeat => repeated(whole, size),
            Wrap::Clamp => clamped(whole, size),
            Wrap::Mirror => mirrored(whole, size),
        }
    };
    (indices, if filter == Filter::Nearest { nearest(fraction) } else { fraction })
}

/// The weight of the second of two texels if only the nearer one counts.
#[inline(always)]
fn nearest(fraction: f32) -> f32 {
    if fraction < 0.5 { 0.0 } else { 1.0 }
}

/// The texel to the left of (above) a coordinate, before wrapping, and the interpolation weight of the next.
#[inline(always)]
fn cell(coordinate: f32, size: u32) -> (f32, f32) {
    let position = coordinate * size as f32 - 0.5;
    let whole = position.floor();
    // So far outside f32 has no fraction any more, and any texel is equally valid.
    let near = whole.abs() < WHOLE_NUMBERS;
    (if near { whole } else { 0.0 }, if near { position - whole } else { 0.0 })
}

/// The limit up to which f32 represents all integers; textures are smaller.
const WHOLE_NUMBERS: f32 = 16_777_216.0;

/// Whether this texel and the next are texels of the texture, so that no wrap mode moves them.
#[inline(always)]
fn is_inside(whole: f32, size: u32) -> bool {
    (whole >= 0.0) & (whole + 1.0 < size as f32)
}

/// `whole` modulo `period`, both integers below 2^24.
#[inline(always)]
fn modulo(whole: f32, period: f32) -> u32 {
    let rest = whole - (whole / period).floor() * period;
    // The quotient is rounded and may have reached the next integer.
    let rest = if rest < 0.0 { rest + period } else { rest };
    (if rest >= period { rest - period } else { rest }) as u32
}

#[inline(always)]
fn repeated(whole: f32, size: u32) -> [u32; 2] {
    let first = modulo(whole, size as f32);
    let second = first + 1;
    [first, if second == size { 0 } else { second }]
}

#[inline(always)]
fn clamped(whole: f32, size: u32) -> [u32; 2] {
    let last = (size - 1) as f32;
    [whole.max(0.0).min(last) as u32, (whole + 1.0).max(0.0).min(last) as u32]
}

#[inline(always)]
fn mirrored(whole: f32, size: u32) -> [u32; 2] {
    let first = modulo(whole, (2 * size) as f32);
    let second = if first + 1 == 2 * size { 0 } else { first + 1 };
    let fold = |k: u32| if k < size { k } else { 2 * size - 1 - k };
    [fold(first), fold(second)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::color::{srgb_to_linear, srgb8_to_linear_table as srgb_table};

    fn ramp(mode: Wrap) -> Texture {
        let texels = (0..4).map(|k| [k * 60, 0, 0, 255]).collect();
        Texture { name: String::new(), width: 4, height: 1, texels, wrap_u: mode, wrap_v: mode, filter: Filter::Linear }
    }

    fn red(texture: &Texture, u: f32) -> f32 {
        sample(texture, srgb_table(), [u, 0.5], texture.filter)[0]
    }

    #[test]
    fn texel_centers_return_their_texel_in_linear_light() {
        let t = ramp(Wrap::Clamp);
        for k in 0..4 {
            let expected = srgb_to_linear(f64::from(k * 60) / 255.0) as f32;
            assert!((red(&t, (k as f32 + 0.5) / 4.0) - expected).abs() < 1e-7);
        }
        // Halfway between two centers: the mean of the linear values, not of the codes.
        let mean = (srgb_to_linear(60.0 / 255.0) + srgb_to_linear(120.0 / 255.0)) / 2.0;
        assert!((f64::from(red(&t, 0.5)) - mean).abs() < 1e-7);
    }

    #[test]
    fn the_nearest_texel_is_constant_up_to_its_edge() {
        let t = Texture { filter: Filter::Nearest, ..ramp(Wrap::Repeat) };
        for k in 0..4 {
            let expected = srgb_to_linear(f64::from(k * 60) / 255.0) as f32;
            for within in [0.001, 0.3, 0.5, 0.999] {
                let seen = red(&t, (k as f32 + within) / 4.0);
                assert!((seen - expected).abs() < 1e-6, "{k} {within}: {seen}");
            }
        }
    }

    #[test]
    fn edges_repeat_clamp_and_mirror() {
        let value = |k: i32| srgb_to_linear(f64::from(k * 60) / 255.0) as f32;
        for (mode, left, right) in [(Wrap::Repeat, 3, 0), (Wrap::Clamp, 0, 3), (Wrap::Mirror, 0, 3)] {
            let t = ramp(mode);
            assert!((red(&t, -0.125) - value(left)).abs() < 1e-6, "{mode:?}");
            assert!((red(&t, 1.125) - value(right)).abs() < 1e-6, "{mode:?}");
        }
        assert!((red(&ramp(Wrap::Mirror), 1.375) - value(2)).abs() < 1e-6);
        assert!((red(&ramp(Wrap::Repeat), -7.375) - value(2)).abs() < 1e-6);
        for mode in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            for u in [f32::MAX, f32::MIN, 1e20, -1e20] {
                assert!(red(&ramp(mode), u).is_finite(), "{mode:?} {u}");
            }
        }
    }

    /// Sixteen points together give the same values as each alone, in every mode, near and far.
    #[test]
    fn sixteen_points_equal_sixteen_single_points() {
        let (width, height) = (7, 3);
        let texels = (0..width * height).map(|k| [k as u8 * 11, 255 - k as u8, k as u8, 255]).collect();
        let mut texture = Texture {
            name: String::new(),
            width,
            height,
            texels,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            filter: Filter::Linear,
        };
        for (wrap_u, wrap_v) in [(Wrap::Repeat, Wrap::Mirror), (Wrap::Mirror, Wrap::Clamp), (Wrap::Clamp, Wrap::Repeat)]
        {
            (texture.wrap_u, texture.wrap_v) = (wrap_u, wrap_v);
            for k in 0..200 {
                texture.filter = if k % 3 == 0 { Filter::Nearest } else { Filter::Linear };
                let place = |lane: usize| (k as f32 - 100.0) * 0.37 * 1.07f32.powi(k) + lane as f32 * 0.093;
                let u: [f32; LANES] = std::array::from_fn(place);
                let v: [f32; LANES] = std::array::from_fn(|lane| place(lane) * -0.61);
                let together = sample_sixteen(&texture, srgb_table(), &[u, v]);
                for lane in 0..LANES {
                    let alone = sample(&texture, srgb_table(), [u[lane], v[lane]], texture.filter);
                    assert_eq!([0, 1, 2].map(|c| together[c][lane].to_bits()), alone.map(f32::to_bits));
                }
            }
        }
    }

    /// Integer arithmetic gives the same wrapped indices.
    #[test]
    fn indices_wrap_as_integers_do() {
        for size in [1u32, 2, 3, 7, 4096, 12_345] {
            for k in (-40_000i64..40_000).step_by(37).chain(-20..20).chain([-16_777_215, 16_777_215]) {
                let count = i64::from(size);
                let fold = |k: i64| {
                    let k = k.rem_euclid(2 * count);
                    if k < count { k } else { 2 * count - 1 - k }
                };
                let both = |f: &dyn Fn(i64) -> i64| [f(k) as u32, f(k + 1) as u32];
                assert_eq!(repeated(k as f32, size), both(&|k| k.rem_euclid(count)), "{k} of {size}");
                assert_eq!(clamped(k as f32, size), both(&|k| k.clamp(0, count - 1)), "{k} of {size}");
                assert_eq!(mirrored(k as f32, size), both(&fold), "{k} of {size}");
            }
        }
    }
}
