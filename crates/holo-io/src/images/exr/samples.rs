//! The sample formats of a file, and the conversion to them.

use exr::meta::attribute::SampleType;
use half::f16;
use half::slice::HalfFloatSliceExt;
use ndarray::ArrayView1;

use super::names;

/// The format of a channel's samples in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum ExrSamples {
    /// 32-bit floats: exact.
    #[default]
    Float,
    /// 16-bit floats: half the size, 11 significant bits, magnitudes from 6e-8 to 65,504.
    ///
    /// Values are rounded to the nearest, ties to even; values nearer to 0 than 3e-8 become 0. Infinities and NaN stay.
    /// A *finite* value from 65,520 on would become infinite: it is an error, and not clamped, because a clamped value
    /// could not be distinguished from a correct one. Integers are exact up to 2048 only, so channels of identifiers
    /// ([`is_identifier`](Self::is_identifier)) are an error too.
    Half,
}

impl ExrSamples {
    /// Whether a channel of this name contains identifiers, by Blender's names for those of objects, materials and
    /// Cryptomatte.
    #[must_use]
    pub fn is_identifier(channel: &str) -> bool {
        let (layer, component) = names::split(channel);
        let pass = layer.rsplit('.').next().unwrap_or(layer);
        let identifies = |name: &str| ["IndexOB", "IndexMA", "Object Index", "Material Index", "id"].contains(&name);
        identifies(pass) || identifies(component) || pass.starts_with("Crypto")
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Float => 4,
            Self::Half => 2,
        }
    }

    pub(super) fn kind(self) -> SampleType {
        match self {
            Self::Float => SampleType::F32,
            Self::Half => SampleType::F16,
        }
    }
}

/// The byte order of the samples that a codec takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    /// Little-endian, as in the file.
    Little,
    /// That of the machine, which the codecs of the crate `exr` take.
    Native,
}

/// Buffers that are reused for every line.
#[derive(Default)]
pub(super) struct Scratch {
    floats: Vec<f32>,
    halves: Vec<f16>,
}

/// Converts and appends a line of samples. The error is the column and the value of a sample that does not fit the
/// format.
pub(super) fn append(
    line: ArrayView1<'_, f32>,
    samples: ExrSamples,
    order: ByteOrder,
    scratch: &mut Scratch,
    out: &mut Vec<u8>,
) -> Result<(), (usize, f32)> {
    let dense = match line.as_slice() {
        Some(dense) => dense,
        None => {
            scratch.floats.clear();
            scratch.floats.extend(line.iter());
            &scratch.floats
        }
    };
    let start = out.len();
    out.resize(start + dense.len() * samples.bytes(), 0);
    let out = &mut out[start..];
    let little = order == ByteOrder::Little;
    match samples {
        ExrSamples::Float => {
            for (bytes, value) in out.chunks_exact_mut(4).zip(dense) {
                bytes.copy_from_slice(&if little { value.to_le_bytes() } else { value.to_ne_bytes() });
            }
        }
        ExrSamples::Half => {
            scratch.halves.resize(dense.len(), f16::ZERO);
            scratch.halves.convert_from_f32_slice(dense);
            let mut lost = false;
            for ((bytes, half), value) in out.chunks_exact_mut(2).zip(&scratch.halves).zip(dense) {
                lost |= half.is_infinite() & value.is_finite();
                bytes.copy_from_slice(&if little { half.to_le_bytes() } else { half.to_ne_bytes() });
            }
            if lost {
                let values = dense.iter().copied().enumerate();
                let too_large = |&(_, value): &(usize, f32)| value.is_finite() && f16::from_f32(value).is_infinite();
                return Err({ values }.find(too_large).unwrap_or((0, f32::NAN)));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn halves(values: &[f32]) -> Result<Vec<u16>, (usize, f32)> {
        let mut bytes = Vec::new();
        append(ArrayView1::from(values), ExrSamples::Half, ByteOrder::Little, &mut Scratch::default(), &mut bytes)?;
        Ok(bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect())
    }

    #[test]
    fn halves_are_rounded_and_never_become_infinite() {
        // 2049 lies between 2048 and 2050, 2051 between 2050 and 2052: ties go to even.
        assert_eq!(halves(&[2048.0, 2049.0, 2051.0]).unwrap(), [0x6800, 0x6800, 0x6802]);
        assert_eq!(halves(&[65_504.0, 65_519.9, -65_519.9]).unwrap(), [0x7bff, 0x7bff, 0xfbff]);
        assert_eq!(halves(&[f32::INFINITY, f32::NEG_INFINITY, -0.0]).unwrap(), [0x7c00, 0xfc00, 0x8000]);
        assert_eq!(halves(&[5.960_464_5e-8, 2.9e-8, f32::MIN_POSITIVE]).unwrap(), [1, 0, 0]);
        assert!(halves(&[f32::NAN]).unwrap()[0] & 0x7fff > 0x7c00);
        assert_eq!(halves(&[0.0, 65_520.0, 1.0]), Err((1, 65_520.0)));
        assert_eq!(halves(&[f32::INFINITY, f32::MIN]), Err((1, f32::MIN)));
    }

    #[test]
    fn identifiers_are_told_by_their_names() {
        for (name, identifier) in [
            ("ViewLayer.Combined.R", false),
            ("A", false),
            ("ViewLayer.Depth.Z", false),
            ("ViewLayer.Normal.X", false),
            ("ViewLayer.IndexOB.X", true),
            ("ViewLayer.Object Index.X", true),
            ("IndexMA.X", true),
            ("id", true),
            ("ViewLayer.CryptoObject00.r", true),
        ] {
            assert_eq!(ExrSamples::is_identifier(name), identifier, "{name}");
        }
    }
}
