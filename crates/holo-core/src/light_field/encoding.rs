//! Conversion between the samples of files and linear light.

use ndarray::{Array3, ArrayView3};

use super::{DynImage, DynLightField, LightFieldOwned, Sample, SampleKind};
use crate::base::color::{Srgb8Encoder, linear_to_srgb16, srgb_to_linear, srgb8_to_linear_table};
use crate::base::memory::collected;
use crate::{ColorEncoding, Error};

impl DynLightField {
    /// Converts every sample to linear light: 1 is the largest integer, floats keep their scale. Samples that are
    /// linear `f32` are not copied.
    ///
    /// Alpha is converted like color. [`DynLightField::without_alpha`] removes it.
    ///
    /// # Accuracy
    ///
    /// Computed in `f64` and rounded to `f32` once.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the allocation of a copy fails.
    ///
    /// # Source
    ///
    /// IEC 61966-2-1.
    pub fn into_linear(self, encoding: ColorEncoding) -> Result<LightFieldOwned<f32>, Error> {
        fn float<T: Sample>(field: &LightFieldOwned<T>, curve: fn(f64) -> f64) -> Result<LightFieldOwned<f32>, Error> {
            let white = T::WHITE.map_or(1.0, f64::from);
            field.map(|&sample| curve(sample.to_f64() / white) as f32)
        }
        match (encoding, self) {
            (ColorEncoding::Srgb, Self::U8(field)) => {
                let table = srgb8_to_linear_table();
                field.map(|&code| table[usize::from(code)])
            }
            (ColorEncoding::Srgb, Self::U16(field)) => {
                let table: Vec<f32> =
                    (0..=u16::MAX).map(|code| srgb_to_linear(f64::from(code) / f64::from(u16::MAX)) as f32).collect();
                field.map(|&code| table[usize::from(code)])
            }
            (ColorEncoding::Linear, Self::F32(field)) => Ok(field),
            (ColorEncoding::Srgb, field) => {
                crate::for_each_sample!(DynLightField, &field, f => float(f, srgb_to_linear))
            }
            (ColorEncoding::Linear, field) => crate::for_each_sample!(DynLightField, &field, f => float(f, |x| x)),
        }
    }
}

impl DynImage {
    /// Converts linear light to samples of a type: integers on the sRGB curve, where 1 is the largest and values
    /// outside 0 to 1 are clamped (NaN is 0); floats as they are.
    ///
    /// # Shape
    ///
    /// `(row, column, channel)`; the result has the same.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the allocation of the image fails.
    ///
    /// # Source
    ///
    /// IEC 61966-2-1.
    pub fn from_linear(image: ArrayView3<'_, f32>, kind: SampleKind) -> Result<Self, Error> {
        fn mapped<T: Sample>(image: ArrayView3<'_, f32>, code: impl Fn(f32) -> T) -> Result<DynImage, Error> {
            let samples = collected("an image", image.iter().map(|&light| code(light)))?;
            Ok(Array3::from_shape_vec(image.raw_dim(), samples).expect("one sample each").into())
        }
        match kind {
            SampleKind::U8 => {
                let encoder = Srgb8Encoder::get();
                mapped(image, |light| encoder.encode(light))
            }
            SampleKind::U16 => mapped(image, linear_to_srgb16),
            SampleKind::F32 => mapped(image, |light| light),
            SampleKind::F64 => mapped(image, f64::from),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LightField;
    use ndarray::Array5;

    fn field<T: Sample>(samples: Vec<T>) -> DynLightField {
        LightField::new(Array5::from_shape_vec((1, samples.len(), 1, 1, 1), samples).unwrap()).unwrap().into()
    }

    #[test]
    fn every_code_survives_the_way_to_linear_light_and_back() {
        let codes: [DynLightField; 2] = [field((0..=u8::MAX).collect()), field((0..=u16::MAX).collect())];
        for codes in codes {
            let linear = codes.clone().into_linear(ColorEncoding::Srgb).unwrap();
            let back = DynImage::from_linear(linear.view(0, 0).unwrap(), codes.kind()).unwrap();
            assert_eq!(back.as_image_ref(), codes.view(0, 0).unwrap());
        }
    }

    #[test]
    fn linear_samples_keep_their_scale() {
        let linear = |field: DynLightField| {
            field.into_linear(ColorEncoding::Linear).unwrap().into_samples().into_raw_vec_and_offset().0
        };
        assert_eq!(linear(field(vec![0_u8, 51, 255])), [0.0, 0.2, 1.0]);
        assert_eq!(linear(field(vec![0_u16, 13_107, 65_535])), [0.0, 0.2, 1.0]);
        assert_eq!(linear(field(vec![-1.0_f32, 7.5])), [-1.0, 7.5]);
        assert_eq!(linear(field(vec![1e-3_f64, 2.0])), [1e-3, 2.0]);
        let encoded = field(vec![0.5_f64]).into_linear(ColorEncoding::Srgb).unwrap();
        assert_eq!(encoded.samples()[[0, 0, 0, 0, 0]], srgb_to_linear(0.5) as f32);
    }

    #[test]
    fn what_no_integer_can_hold_is_clamped() {
        let light = Array3::from_shape_vec((1, 4, 1), vec![-0.1, f32::NAN, 1.5, 0.5]).unwrap();
        let Ok(DynImage::U8(codes)) = DynImage::from_linear(light.view(), SampleKind::U8) else { panic!("8 bits") };
        assert_eq!(codes.into_raw_vec_and_offset().0, [0, 0, 255, 188]);
        let Ok(DynImage::F64(same)) = DynImage::from_linear(light.view(), SampleKind::F64) else { panic!("64 bits") };
        assert_eq!(same[[0, 2, 0]], 1.5);
    }
}
