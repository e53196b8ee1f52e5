//! Filters: what decoded attributes are turned into, element by element. Appendix B of the extension defines them.

/// A filter of the extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    /// Unit vectors.
    Octahedral,
    /// Unit quaternions.
    Quaternion,
    /// Floats.
    Exponential,
    /// Colors.
    Color,
}

impl Filter {
    pub(super) fn new(name: &str) -> Option<Self> {
        Some(match name {
            "NONE" => Self::None,
            "OCTAHEDRAL" => Self::Octahedral,
            "QUATERNION" => Self::Quaternion,
            "EXPONENTIAL" => Self::Exponential,
            "COLOR" => Self::Color,
            _ => return None,
        })
    }

    /// Whether it is defined for elements of `stride` bytes.
    pub(super) fn fits(self, stride: usize) -> bool {
        match self {
            Self::None => true,
            Self::Octahedral | Self::Color => stride == 4 || stride == 8,
            Self::Quaternion => stride == 8,
            Self::Exponential => stride.is_multiple_of(4),
        }
    }

    /// Filters all elements in place.
    pub(super) fn apply(self, elements: &mut [u8], stride: usize) {
        let four = |elements: &mut [u8], map: fn([i32; 4], f32) -> [f32; 4], signed: bool| {
            if stride == 4 {
                bytes(elements, map, signed);
            } else {
                shorts(elements, map, signed);
            }
        };
        match self {
            Self::None => {}
            Self::Octahedral => four(elements, octahedral, true),
            Self::Quaternion => four(elements, quaternion, true),
            Self::Exponential => {
                for element in elements.as_chunks_mut::<4>().0 {
                    *element = exponential(i32::from_le_bytes(*element)).to_le_bytes();
                }
            }
            Self::Color => four(elements, color, false),
        }
    }
}

/// Elements of four 8-bit components. Casts of floats to integers saturate, and NaN becomes 0.
fn bytes(elements: &mut [u8], map: fn([i32; 4], f32) -> [f32; 4], signed: bool) {
    for element in elements.as_chunks_mut::<4>().0 {
        let from = element.map(|x| i32::from(x as i8));
        *element = if signed { map(from, 127.0).map(|x| x as i8 as u8) } else { map(from, 255.0).map(|x| x as u8) };
    }
}

/// Elements of four 16-bit components.
fn shorts(elements: &mut [u8], map: fn([i32; 4], f32) -> [f32; 4], signed: bool) {
    for element in elements.as_chunks_mut::<8>().0 {
        let from = std::array::from_fn(|k| i32::from(i16::from_le_bytes([element[2 * k], element[2 * k + 1]])));
        let to = if signed { map(from, 32767.0) } else { map(from, 65535.0) };
        for (x, out) in to.into_iter().zip(element.as_chunks_mut::<2>().0) {
            *out = if signed { (x as i16).to_le_bytes() } else { (x as u16).to_le_bytes() };
        }
    }
}

/// The third component holds what 1 is in the first two; the fourth one is kept.
fn octahedral([x, y, one, kept]: [i32; 4], max: f32) -> [f32; 4] {
    let (x, y) = (x as f32 / one as f32, y as f32 / one as f32);
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let scale = max / (x * x + y * y + z * z).sqrt();
    [(x * scale).round(), (y * scale).round(), (z * scale).round(), kept as f32]
}

/// Three components times the square root of 2, without the largest; the fourth holds what 1 is, and in its lowest two
/// bits which one is the largest.
fn quaternion([x, y, z, code]: [i32; 4], max: f32) -> [f32; 4] {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / (code | 3) as f32;
    let [x, y, z] = [x, y, z].map(|component| component as f32 * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut to = [w, x, y, z].map(|component| (component * max).round());
    to.rotate_right((code & 3) as usize);
    to
}

/// An exponent of 8 bits, a mantissa of 24. Exact; beyond the range of f32 infinite or rounded.
fn exponential(code: i32) -> f32 {
    let (exponent, mantissa) = (code >> 24, code << 8 >> 8);
    // 2^exponent as f64, which has bias 1023 and 52 bits of mantissa.
    (f64::from(mantissa) * f64::from_bits(((1023 + exponent) as u64) << 52)) as f32
}

/// Luma, two differences of color, alpha. The highest bit of alpha gives the precision.
fn color([y, co, cg, alpha]: [i32; 4], max: f32) -> [f32; 4] {
    // Luma and alpha are unsigned.
    let (y, alpha) = (y & max as i32, alpha & max as i32);
    let ones = (1_i32 << (32 - alpha.leading_zeros())) - 1;
    let a = alpha & ones >> 1;
    let scale = max / ones as f32;
    [y + co - cg, y + cg, y - co - cg, a << 1 | a & 1].map(|component| (component as f32 * scale).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shorts_of(filter: Filter, from: [i16; 4]) -> [i16; 4] {
        let mut bytes: Vec<u8> = from.iter().flat_map(|x| x.to_le_bytes()).collect();
        filter.apply(&mut bytes, 8);
        std::array::from_fn(|k| i16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]))
    }

    fn bytes_of(filter: Filter, from: [u8; 4]) -> [u8; 4] {
        let mut bytes = from;
        filter.apply(&mut bytes, 4);
        bytes
    }

    #[test]
    fn octahedral_by_hand() {
        // The axes, also in the folded half.
        assert_eq!(bytes_of(Filter::Octahedral, [0, 0, 127, 5]), [0, 0, 127, 5]);
        assert_eq!(bytes_of(Filter::Octahedral, [127, 0, 127, 0x85]), [127, 0, 0, 0x85]);
        assert_eq!(bytes_of(Filter::Octahedral, [127, 127, 127, 0]), [0, 0, 129, 0], "-z, as i8");
        // Ten bits in shorts: x = y = 1/2 is at z = 0.
        let [x, y, z, kept] = shorts_of(Filter::Octahedral, [256, 255, 511, -7]);
        assert!((x - 23170).abs() <= 64 && (y - 23170).abs() <= 64 && z.abs() <= 64 && kept == -7, "{x} {y} {z}");
        // No precision: any value, no panic.
        shorts_of(Filter::Octahedral, [3, 4, 0, 0]);
    }

    #[test]
    fn quaternion_by_hand() {
        // The identity, with the largest component at each place.
        for place in 0..4_i16 {
            let mut expected = [0; 4];
            expected[place as usize] = 32767;
            assert_eq!(shorts_of(Filter::Quaternion, [0, 0, 0, 2044 | place]), expected);
        }
        // 90 degrees around x with w (place 3) omitted: x follows it.
        let one = 2047;
        let [x, y, z, w] = shorts_of(Filter::Quaternion, [one, 0, 0, one]);
        assert!((x - 23170).abs() <= 1 && (w - 23170).abs() <= 1 && (y, z) == (0, 0), "{x} {y} {z} {w}");
    }

    #[test]
    fn exponential_by_hand() {
        let code = |exponent: i32, mantissa: i32| exponent << 24 | mantissa & 0xFF_FFFF;
        for (exponent, mantissa, value) in
            [(0, 1, 1.0), (-1, 3, 1.5), (2, -5, -20.0), (-24, 1 << 22, 0.25), (100, -1, -(2.0_f32.powi(100)))]
        {
            assert_eq!(exponential(code(exponent, mantissa)), value);
        }
        let mut bytes = code(-3, 12).to_le_bytes();
        Filter::Exponential.apply(&mut bytes, 4);
        assert_eq!(f32::from_le_bytes(bytes), 1.5);
        assert_eq!(exponential(code(-128, 1)), 2.0_f32.powi(-128));
        assert_eq!(exponential(code(127, 1 << 22)), f32::INFINITY);
    }

    #[test]
    fn color_by_hand() {
        // Eight bits: luma 100, no chroma, alpha 127 of 127.
        assert_eq!(bytes_of(Filter::Color, [100, 0, 0, 0xFF]), [100, 100, 100, 255]);
        // r = y + co - cg, g = y + cg, b = y - co - cg.
        assert_eq!(bytes_of(Filter::Color, [100, 20, 0xF6, 0x80]), [130, 90, 90, 0]);
        // Luma is unsigned.
        assert_eq!(bytes_of(Filter::Color, [200, 0, 0, 0xFF]), [200, 200, 200, 255]);
        // Five bits: 31 is white.
        assert_eq!(bytes_of(Filter::Color, [31, 0, 0, 0x1F]), [255; 4]);
        assert_eq!(shorts_of(Filter::Color, [1023, 0, 0, 1023]), [-1; 4]);
        // No precision: any value, no panic.
        bytes_of(Filter::Color, [1, 2, 3, 0]);
    }
}
