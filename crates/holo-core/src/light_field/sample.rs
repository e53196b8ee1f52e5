//! The element types of images and light fields.

use ndarray::{Array3, ArrayView3};

use super::dynamic::{DynImage, DynImageRef, DynLightField, DynLightFieldRef};
use super::{LightFieldOwned, LightFieldRef};

/// An element type as a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SampleKind {
    /// `u8`.
    U8,
    /// `u16`.
    U16,
    /// `f32`.
    F32,
    /// `f64`.
    F64,
}

impl SampleKind {
    /// Returns the name of the type in numpy and HDF5, such as `uint8`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::U16 => "uint16",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }

    /// Returns the size of a sample in bytes.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Returns whether it is one of the two floating-point types.
    #[must_use]
    pub const fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// `u8`, `u16`, `f32` or `f64`: an element of an image or of a light field.
///
/// Conversions apply no transfer curve.
pub trait Sample: sealed::Sealed + Copy + Default + PartialEq + std::fmt::Debug + Send + Sync + 'static {
    /// The element type as a value.
    const KIND: SampleKind;

    /// The largest value of an integer type; `None` for floats, which have no fixed scale.
    const WHITE: Option<f32>;

    /// Converts to `f32`: exact for all but `f64`, which is rounded to nearest.
    fn to_f32(self) -> f32;

    /// Widens to `f64`, which is exact.
    fn to_f64(self) -> f64;
}

/// The conversions into the dynamic types; public as `From`.
pub(super) mod sealed {
    use super::{Array3, ArrayView3, DynImage, DynImageRef, DynLightField, DynLightFieldRef};
    use super::{LightFieldOwned, LightFieldRef};

    pub trait Sealed: Sized {
        fn light_field(field: LightFieldOwned<Self>) -> DynLightField;
        fn light_field_ref(field: LightFieldRef<'_, Self>) -> DynLightFieldRef<'_>;
        fn image(image: Array3<Self>) -> DynImage;
        fn image_ref(image: ArrayView3<'_, Self>) -> DynImageRef<'_>;
    }
}

macro_rules! sample {
    ($($type:ty, $name:ident, $white:expr;)*) => {$(
        impl sealed::Sealed for $type {
            fn light_field(field: LightFieldOwned<Self>) -> DynLightField {
                DynLightField::$name(field)
            }

            fn light_field_ref(field: LightFieldRef<'_, Self>) -> DynLightFieldRef<'_> {
                DynLightFieldRef::$name(field)
            }

            fn image(image: Array3<Self>) -> DynImage {
                DynImage::$name(image)
            }

            fn image_ref(image: ArrayView3<'_, Self>) -> DynImageRef<'_> {
                DynImageRef::$name(image)
            }
        }

        impl Sample for $type {
            const KIND: SampleKind = SampleKind::$name;
            const WHITE: Option<f32> = $white;

            #[allow(clippy::cast_possible_truncation, clippy::cast_lossless, reason = "one line for four types")]
            fn to_f32(self) -> f32 {
                self as f32
            }

            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }
    )*};
}

sample! {
    u8, U8, Some(255.0);
    u16, U16, Some(65_535.0);
    f32, F32, None;
    f64, F64, None;
}
