//! Texture look-up: bilinear, in linear light.
//!
//! The texel (i, j) has its centre at ((i + 0.5) / width, (j + 0.5) / height). sRGB is decoded before the four
//! neighbours are mixed (as Mitsuba does; Cycles mixes first, which is darker where neighbours differ).

use crate::scene::{Texture, Wrap};

/// RGB at texture coordinates (0, 0) = upper left corner of the image; `table` says what a code means.
#[inline(always)]
pub(crate) fn sample(texture: &Texture, table: &[f32; 256], coordinates: [f32; 2]) -> [f32; 3] {
    let ([upper_left, upper_right, lower_left, lower_right], fraction) = neighbours(texture, coordinates);
    let mut out = [0.0; 3];
    for c in 0..3 {
        let value = |texel: [u8; 4]| table[texel[c] as usize];
        out[c] = mix([value(upper_left), value(upper_right), value(lower_left), value(lower_right)], fraction);
    }
    out
}

/// Alpha, 0 to 1.
#[inline(always)]
pub(crate) fn sample_alpha(texture: &Texture, coordinates: [f32; 2]) -> f32 {
    let ([a, b, c, d], fraction) = neighbours(texture, coordinates);
    let value = |texel: [u8; 4]| f32::from(texel[3]);
    mix([value(a), value(b), value(c), value(d)], fraction) / 255.0
}

/// The four texels around a place (upper left, upper right, lower left, lower right), and how far it is to the right and
/// downward from the first.
#[inline(always)]
fn neighbours(texture: &Texture, [u, v]: [f32; 2]) -> ([[u8; 4]; 4], [f32; 2]) {
    let (column, fraction_x) = cell(u, texture.width);
    let (row, fraction_y) = cell(v, texture.height);
    let columns = [wrap(column, texture.width, texture.wrap_u), wrap(column + 1, texture.width, texture.wrap_u)];
    let rows = [wrap(row, texture.height, texture.wrap_v), wrap(row + 1, texture.height, texture.wrap_v)];
    let texel = |j: usize, i: usize| texture.texels[rows[j] * texture.width + columns[i]];
    ([texel(0, 0), texel(0, 1), texel(1, 0), texel(1, 1)], [fraction_x, fraction_y])
}

#[inline(always)]
fn mix([a, b, c, d]: [f32; 4], [x, y]: [f32; 2]) -> f32 {
    let (upper, lower) = (a + (b - a) * x, c + (d - c) * x);
    upper + (lower - upper) * y
}

/// The texel left of (above) a coordinate and how far it is towards the next.
#[inline(always)]
fn cell(coordinate: f32, size: usize) -> (i64, f32) {
    let position = coordinate * size as f32 - 0.5;
    let whole = position.floor();
    // So far outside f32 has no fraction any more; any texel will do as long as indices stay far from overflow.
    (whole.clamp(-1e15, 1e15) as i64, if whole.abs() < 1e15 { position - whole } else { 0.0 })
}

#[inline(always)]
fn wrap(index: i64, size: usize, mode: Wrap) -> usize {
    let count = size as i64;
    if (0..count).contains(&index) {
        return index as usize;
    }
    (match mode {
        Wrap::Repeat => index.rem_euclid(count),
        Wrap::Clamp => index.clamp(0, count - 1),
        Wrap::Mirror => {
            let k = index.rem_euclid(2 * count);
            if k < count { k } else { 2 * count - 1 - k }
        }
    }) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::srgb::{decoding_table as srgb_table, to_linear as srgb_to_linear};

    fn ramp(mode: Wrap) -> Texture {
        let texels = (0..4).map(|k| [k * 60, 0, 0, 255]).collect();
        Texture { name: String::new(), width: 4, height: 1, texels, wrap_u: mode, wrap_v: mode }
    }

    fn red(texture: &Texture, u: f32) -> f32 {
        sample(texture, srgb_table(), [u, 0.5])[0]
    }

    #[test]
    fn texel_centres_return_their_texel_in_linear_light() {
        let t = ramp(Wrap::Clamp);
        for k in 0..4 {
            let expected = srgb_to_linear(f64::from(k * 60) / 255.0) as f32;
            assert!((red(&t, (k as f32 + 0.5) / 4.0) - expected).abs() < 1e-7);
        }
        // Halfway between two centres: the mean of the two linear values, not of the codes.
        let mean = (srgb_to_linear(60.0 / 255.0) + srgb_to_linear(120.0 / 255.0)) / 2.0;
        assert!((f64::from(red(&t, 0.5)) - mean).abs() < 1e-7);
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
}
