//! The element types of images and light fields, and images and light fields whose type is known only at run time, as in files.

use std::ops::Range;

use ndarray::{Array3, ArrayView3, Axis, Slice};

use self::sealed::Sealed;
use super::{LightFieldOwned, LightFieldRef};
use crate::base::error::range_within;
use crate::{Error, GridSize, Layout, LightFieldShape};

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
mod sealed {
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

/// A light field whose element type is known at run time.
///
/// # Examples
///
/// ```
/// use holo_core::{DynLightField, LightField, for_each_sample};
/// use ndarray::Array5;
///
/// let field: DynLightField = LightField::new(Array5::<u16>::from_elem((2, 3, 4, 5, 1), 7))?.into();
/// assert_eq!(field.kind().name(), "uint16");
/// let sum: f64 = for_each_sample!(DynLightField, &field, f => f.samples().iter().map(|&x| f64::from(x)).sum());
/// assert_eq!(sum, 7.0 * 120.0);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum DynLightField {
    /// 8 bits a sample.
    U8(LightFieldOwned<u8>),
    /// 16 bits a sample.
    U16(LightFieldOwned<u16>),
    /// Single precision.
    F32(LightFieldOwned<f32>),
    /// Double precision, MATLAB's default.
    F64(LightFieldOwned<f64>),
}

/// A borrowed light field whose element type is known at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DynLightFieldRef<'a> {
    /// 8 bits a sample.
    U8(LightFieldRef<'a, u8>),
    /// 16 bits a sample.
    U16(LightFieldRef<'a, u16>),
    /// Single precision.
    F32(LightFieldRef<'a, f32>),
    /// Double precision.
    F64(LightFieldRef<'a, f64>),
}

/// An image `(row, column, channel)` whose element type is known at run time.
#[derive(Debug, Clone, PartialEq)]
pub enum DynImage {
    /// 8 bits a sample.
    U8(Array3<u8>),
    /// 16 bits a sample.
    U16(Array3<u16>),
    /// Single precision.
    F32(Array3<f32>),
    /// Double precision.
    F64(Array3<f64>),
}

/// A borrowed image `(row, column, channel)` whose element type is known at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DynImageRef<'a> {
    /// 8 bits a sample.
    U8(ArrayView3<'a, u8>),
    /// 16 bits a sample.
    U16(ArrayView3<'a, u16>),
    /// Single precision.
    F32(ArrayView3<'a, f32>),
    /// Double precision.
    F64(ArrayView3<'a, f64>),
}

/// Runs the same code for every element type of a [`DynLightField`], [`DynLightFieldRef`], [`DynImage`] or
/// [`DynImageRef`]: `for_each_sample!(DynImage, value, image => expression)`. The value is matched as given: by
/// reference or by value.
#[macro_export]
macro_rules! for_each_sample {
    ($type:ident, $value:expr, $name:ident => $body:expr) => {
        match $value {
            $crate::$type::U8($name) => $body,
            $crate::$type::U16($name) => $body,
            $crate::$type::F32($name) => $body,
            $crate::$type::F64($name) => $body,
        }
    };
}

impl DynLightField {
    /// Wraps a raw image in the given layout without copying it.
    ///
    /// # Shape
    ///
    /// `(V*T, U*S, C)`: row, column, channel.
    ///
    /// # Errors
    ///
    /// As [`LightField::from_elemental_grid`](crate::LightField::from_elemental_grid).
    pub fn from_grid(image: DynImage, layout: Layout, shape: LightFieldShape) -> Result<Self, Error> {
        fn wrap<T: Sample>(image: Array3<T>, layout: Layout, shape: LightFieldShape) -> Result<DynLightField, Error> {
            Ok(match layout {
                Layout::ElementalGrid => LightFieldOwned::from_elemental_grid(image, shape)?,
                Layout::ViewpointGrid => LightFieldOwned::from_viewpoint_grid(image, shape)?,
            }
            .into())
        }
        for_each_sample!(DynImage, image, image => wrap(image, layout, shape))
    }

    /// Returns the raw image in the given layout. Samples that already lie in memory in that order are not copied.
    ///
    /// # Shape
    ///
    /// `(V*T, U*S, C)`: row, column, channel.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the allocation of a copy fails.
    pub fn into_grid(self, layout: Layout) -> Result<DynImage, Error> {
        fn grid<T: Sample>(field: LightFieldOwned<T>, layout: Layout) -> Result<DynImage, Error> {
            Ok(match layout {
                Layout::ElementalGrid => field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?,
                Layout::ViewpointGrid => field.into_viewpoint_grid().or_else(|field| field.to_viewpoint_grid())?,
            }
            .into())
        }
        for_each_sample!(DynLightField, self, field => grid(field, layout))
    }

    /// Returns the light field without its alpha channel: the first of one or two channels, the first three of more.
    ///
    /// The colors of transparent pixels do not change. Without an alpha channel nothing is copied.
    ///
    /// # Errors
    ///
    /// As [`DynLightField::into_grid`].
    pub fn without_alpha(self) -> Result<Self, Error> {
        fn colors<T: Sample>(field: LightFieldOwned<T>) -> Result<DynLightField, Error> {
            let channels = if field.channels() >= 3 { 3 } else { 1 };
            if field.channels() == channels {
                return Ok(field.into());
            }
            let samples = field.samples().slice_axis_move(Axis(4), Slice::from(..channels));
            Ok(LightFieldRef::trusted(samples).to_owned()?.into())
        }
        for_each_sample!(DynLightField, self, field => colors(field))
    }

    /// Returns a light field that borrows the samples of this one.
    #[must_use]
    pub fn as_light_field_ref(&self) -> DynLightFieldRef<'_> {
        for_each_sample!(DynLightField, self, field => field.as_light_field_ref().into())
    }

    /// Returns the element type.
    #[must_use]
    pub fn kind(&self) -> SampleKind {
        self.as_light_field_ref().kind()
    }

    /// Returns the (rows, columns) of views and of microlenses.
    #[must_use]
    pub fn shape(&self) -> LightFieldShape {
        self.as_light_field_ref().shape()
    }

    /// Returns the number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.as_light_field_ref().channels()
    }

    /// Converts every sample to `f32` without a scale. Samples that are `f32` are not copied.
    ///
    /// # Accuracy
    ///
    /// Exact for integers and `f32`; `f64` is rounded to nearest.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the allocation of the copy fails.
    pub fn into_f32(self) -> Result<LightFieldOwned<f32>, Error> {
        match self {
            Self::F32(field) => Ok(field),
            other => other.to_f32(),
        }
    }

    /// Copies every sample as `f32`; see [`DynLightField::into_f32`].
    ///
    /// # Errors
    ///
    /// As [`DynLightField::into_f32`].
    pub fn to_f32(&self) -> Result<LightFieldOwned<f32>, Error> {
        for_each_sample!(DynLightField, self, field => field.map(|&sample| sample.to_f32()))
    }

    /// Returns view `(t, s)`.
    ///
    /// # Shape
    ///
    /// `(v, u, c)`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such view.
    pub fn view(&self, t: usize, s: usize) -> Result<DynImageRef<'_>, Error> {
        for_each_sample!(DynLightField, self, field => field.view(t, s).map(Into::into))
    }

    /// Returns the elemental image (micro-image) of microlens `(v, u)`.
    ///
    /// # Shape
    ///
    /// `(t, s, c)`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such microlens.
    pub fn elemental_image(&self, v: usize, u: usize) -> Result<DynImageRef<'_>, Error> {
        for_each_sample!(DynLightField, self, field => field.elemental_image(v, u).map(Into::into))
    }

    /// Returns the epipolar-plane image of microlens row `v` in view row `t`.
    ///
    /// # Shape
    ///
    /// `(s, u, c)`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such row.
    pub fn epi_row(&self, v: usize, t: usize) -> Result<DynImageRef<'_>, Error> {
        for_each_sample!(DynLightField, self, field => field.epi_row(v, t).map(Into::into))
    }

    /// Returns the epipolar-plane image of microlens column `u` in view column `s`.
    ///
    /// # Shape
    ///
    /// `(t, v, c)`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such column.
    pub fn epi_column(&self, u: usize, s: usize) -> Result<DynImageRef<'_>, Error> {
        for_each_sample!(DynLightField, self, field => field.epi_column(u, s).map(Into::into))
    }
}

impl DynLightFieldRef<'_> {
    /// Returns the element type.
    #[must_use]
    pub fn kind(&self) -> SampleKind {
        for_each_sample!(DynLightFieldRef, self, field => kind_of(&field.samples()))
    }

    /// Returns the (rows, columns) of views and of microlenses.
    #[must_use]
    pub fn shape(&self) -> LightFieldShape {
        for_each_sample!(DynLightFieldRef, self, field => field.shape())
    }

    /// Returns the number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        for_each_sample!(DynLightFieldRef, self, field => field.channels())
    }
}

impl DynImage {
    /// Returns an image that borrows the samples of this one.
    #[must_use]
    pub fn as_image_ref(&self) -> DynImageRef<'_> {
        for_each_sample!(DynImage, self, image => image.view().into())
    }

    /// Returns the element type.
    #[must_use]
    pub fn kind(&self) -> SampleKind {
        self.as_image_ref().kind()
    }

    /// Returns rows, columns and channels.
    #[must_use]
    pub fn dim(&self) -> (usize, usize, usize) {
        self.as_image_ref().dim()
    }

    /// Returns the number of rows and columns.
    #[must_use]
    pub fn size(&self) -> GridSize {
        self.as_image_ref().size()
    }

    /// Returns the number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.as_image_ref().channels()
    }
}

impl<'a> DynImageRef<'a> {
    /// Returns the part of the image in these rows and columns.
    ///
    /// # Errors
    ///
    /// [`Error::BadRange`] if a range is empty or ends beyond the image.
    pub fn crop(self, rows: Range<usize>, columns: Range<usize>) -> Result<Self, Error> {
        let size = self.size();
        for (what, range, count) in [("image rows", &rows, size.rows), ("image columns", &columns, size.columns)] {
            range_within(what, range, count)?;
        }
        fn cut<T: Sample>(image: ArrayView3<'_, T>, rows: Range<usize>, columns: Range<usize>) -> DynImageRef<'_> {
            image.slice_axis_move(Axis(0), rows.into()).slice_axis_move(Axis(1), columns.into()).into()
        }
        Ok(for_each_sample!(DynImageRef, self, image => cut(image, rows, columns)))
    }

    /// Returns the element type.
    #[must_use]
    pub fn kind(&self) -> SampleKind {
        for_each_sample!(DynImageRef, self, image => kind_of(image))
    }

    /// Returns rows, columns and channels.
    #[must_use]
    pub fn dim(&self) -> (usize, usize, usize) {
        for_each_sample!(DynImageRef, self, image => image.dim())
    }

    /// Returns the number of rows and columns.
    #[must_use]
    pub fn size(&self) -> GridSize {
        let (rows, columns, _) = self.dim();
        GridSize::new(rows, columns)
    }

    /// Returns the number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.dim().2
    }
}

fn kind_of<T: Sample, D>(_: &ndarray::ArrayView<'_, T, D>) -> SampleKind {
    T::KIND
}

impl<T: Sample> From<LightFieldOwned<T>> for DynLightField {
    fn from(field: LightFieldOwned<T>) -> Self {
        Sealed::light_field(field)
    }
}

impl<'a, T: Sample> From<LightFieldRef<'a, T>> for DynLightFieldRef<'a> {
    fn from(field: LightFieldRef<'a, T>) -> Self {
        Sealed::light_field_ref(field)
    }
}

impl<'a> From<&'a DynLightField> for DynLightFieldRef<'a> {
    fn from(field: &'a DynLightField) -> Self {
        field.as_light_field_ref()
    }
}

impl<T: Sample> From<Array3<T>> for DynImage {
    fn from(image: Array3<T>) -> Self {
        Sealed::image(image)
    }
}

impl<'a, T: Sample> From<ArrayView3<'a, T>> for DynImageRef<'a> {
    fn from(image: ArrayView3<'a, T>) -> Self {
        Sealed::image_ref(image)
    }
}

impl<'a> From<&'a DynImage> for DynImageRef<'a> {
    fn from(image: &'a DynImage) -> Self {
        image.as_image_ref()
    }
}

#[cfg(test)]
mod tests;
