//! Light fields as files hold them: of one of four number types.

use holo_core::{LightFieldOwned, Split};

/// A type of number that a light field in a file may have: `u8`, `u16`, `f32` or `f64`.
#[cfg(any(feature = "mat", feature = "hdf5"))]
pub trait StoredSample: sealed::Sealed + Copy + Default + Send + Sync + 'static {}

/// A light field that was read from a file or from a file a view, in the type that it has there.
///
/// # Shape
///
/// `(v, u, t, s, c)`, as every light field; the order in memory is that of the file or files.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum StoredLightField {
    /// 8-bit integers, usually on the sRGB curve.
    U8(LightFieldOwned<u8>),
    /// 16-bit integers, usually on the sRGB curve.
    U16(LightFieldOwned<u16>),
    /// 32-bit floats, usually linear.
    F32(LightFieldOwned<f32>),
    /// 64-bit floats.
    F64(LightFieldOwned<f64>),
}

/// Calls a method on the light field, whatever its type.
macro_rules! any {
    ($stored:expr, $light_field:ident => $call:expr) => {
        match $stored {
            StoredLightField::U8($light_field) => $call,
            StoredLightField::U16($light_field) => $call,
            StoredLightField::F32($light_field) => $call,
            StoredLightField::F64($light_field) => $call,
        }
    };
}

impl StoredLightField {
    /// Takes a raw image for a light field; nothing is copied.
    ///
    /// # Errors
    ///
    /// [`Error::Core`](crate::Error::Core) if the image has not the size that the split calls for.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, Layout, Split};
    /// use holo_io::{PngSamples, StoredLightField};
    ///
    /// let split = Split::new(GridSize::new(2, 3), GridSize::new(4, 5))?;
    /// let raw = PngSamples::U8(ndarray::Array3::zeros((8, 15, 3)));
    /// let light_field = StoredLightField::from_raw(raw, Layout::ElementalGrid, split)?;
    /// assert_eq!((light_field.split(), light_field.channels()), (split, 3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "png")]
    pub fn from_raw(raw: crate::PngSamples, layout: holo_core::Layout, split: Split) -> Result<Self, crate::Error> {
        fn wrap<T>(
            raw: ndarray::Array3<T>,
            layout: holo_core::Layout,
            split: Split,
        ) -> Result<LightFieldOwned<T>, holo_core::Error> {
            match layout {
                holo_core::Layout::ElementalGrid => LightFieldOwned::from_elemental_grid(raw, split),
                holo_core::Layout::ViewpointGrid => LightFieldOwned::from_viewpoint_grid(raw, split),
            }
        }
        match raw {
            crate::PngSamples::U8(raw) => wrap(raw, layout, split).map(Self::U8),
            crate::PngSamples::U16(raw) => wrap(raw, layout, split).map(Self::U16),
        }
        .map_err(|error| crate::Error::core(std::path::Path::new(crate::error::MEMORY), error))
    }

    /// Returns the number of views and lenses.
    #[must_use]
    pub fn split(&self) -> Split {
        any!(self, light_field => light_field.split())
    }

    /// Returns the number of channels: 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha.
    #[must_use]
    pub fn channels(&self) -> usize {
        any!(self, light_field => light_field.channels())
    }
}

#[cfg(any(feature = "mat", feature = "hdf5"))]
pub(crate) mod sealed {
    use holo_core::LightField;
    use ndarray::Array5;
    #[cfg(feature = "mat")]
    use ndarray::ArrayViewD;

    use super::StoredLightField;

    /// A number that HDF5 knows, where this crate does.
    #[cfg(feature = "hdf5")]
    pub trait Number: Sized + std::fmt::Debug + ::hdf5::H5Type {}
    #[cfg(not(feature = "hdf5"))]
    pub trait Number: Sized + std::fmt::Debug {}

    /// What this crate does with a sample type; nobody else can add one.
    pub trait Sealed: Number {
        #[doc(hidden)]
        const NAME: &'static str;
        #[doc(hidden)]
        const IS_FLOAT: bool;
        #[cfg(feature = "mat")]
        #[doc(hidden)]
        fn any(array: ArrayViewD<'_, Self>) -> AnyView<'_>;
        #[doc(hidden)]
        fn stored(samples: Array5<Self>) -> Result<StoredLightField, holo_core::Error>;
    }

    /// An array of any of the types.
    #[cfg(feature = "mat")]
    #[derive(Debug)]
    pub enum AnyView<'a> {
        U8(ArrayViewD<'a, u8>),
        U16(ArrayViewD<'a, u16>),
        F32(ArrayViewD<'a, f32>),
        F64(ArrayViewD<'a, f64>),
    }

    macro_rules! sample {
        ($($type:ty, $name:ident, $text:literal, $is_float:literal;)*) => {$(
            impl Number for $type {}

            impl Sealed for $type {
                const NAME: &'static str = $text;
                const IS_FLOAT: bool = $is_float;

                #[cfg(feature = "mat")]
                fn any(array: ArrayViewD<'_, Self>) -> AnyView<'_> {
                    AnyView::$name(array)
                }

                fn stored(samples: Array5<Self>) -> Result<StoredLightField, holo_core::Error> {
                    LightField::new(samples).map(StoredLightField::$name)
                }
            }

            impl super::StoredSample for $type {}
        )*};
    }

    sample! {
        u8, U8, "uint8", false;
        u16, U16, "uint16", false;
        f32, F32, "float32", true;
        f64, F64, "float64", true;
    }
}

/// The order that a light field's axes have in a file, as letters.
#[cfg(feature = "mat")]
pub(crate) fn in_order<'a, T>(samples: ndarray::ArrayView5<'a, T>, axes: &[usize; 5]) -> ndarray::ArrayViewD<'a, T> {
    samples.into_dyn().permuted_axes(ndarray::IxDyn(axes))
}
