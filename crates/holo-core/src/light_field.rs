//! The 5D light field: one array type for any strides.

mod clip;
mod compose;
mod dynamic;
mod encoding;
mod epi;
mod grids;
mod images;
mod interpolate;
pub(crate) mod layout;
mod memory_order;
mod path;
mod quilt;
pub mod rearrange;
mod rotate;
mod view_order;

pub use dynamic::{DynImage, DynImageRef, DynLightField, DynLightFieldRef, Sample, SampleKind};
pub use grids::Layout;
pub use path::ViewPath;
pub use quilt::evenly_spaced_views;
pub use view_order::ViewOrder;

use std::fmt;

use ndarray::{
    ArrayBase, ArrayView5, ArrayViewMut5, CowRepr, Data, DataMut, Ix5, OwnedRepr, RawData, RawDataClone, ViewRepr,
};

use crate::light_field::layout::checked_product;
use crate::{Error, GridSize, LightFieldShape};

/// A light field `H(v, u, t, s, c)`: an ndarray with the axes microlens row, microlens column, view row, view column,
/// channel.
///
/// The array has five dimensions, **any strides** and any storage: owned, borrowed, mutably borrowed, shared. The
/// elemental grid, the viewpoint grid and every crop of either are the same type with other strides. Wrapping one
/// copies nothing. No axis is empty.
///
/// # Source
///
/// Eq. 5.
///
/// # Examples
///
/// Both layouts of the same scene are equal light fields:
///
/// ```
/// use holo_core::{GridSize, LightField, LightFieldShape};
/// use ndarray::Array3;
///
/// let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5))?;
/// let raw = Array3::from_shape_fn((8, 15, 1), |(row, column, _)| (row * 15 + column) as u8);
/// let from_lenses = LightField::from_elemental_grid(raw, shape)?;
/// let from_views = LightField::from_viewpoint_grid(from_lenses.to_viewpoint_grid()?, shape)?;
/// assert_eq!(from_lenses, from_views);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub struct LightField<S: RawData> {
    samples: ArrayBase<S, Ix5>,
}

/// A light field that owns its samples.
pub type LightFieldOwned<T> = LightField<OwnedRepr<T>>;

/// A light field that borrows its samples.
pub type LightFieldRef<'a, T> = LightField<ViewRepr<&'a T>>;

/// A light field that mutably borrows its samples.
pub type LightFieldRefMut<'a, T> = LightField<ViewRepr<&'a mut T>>;

/// A light field that owns or borrows its samples.
pub type LightFieldCow<'a, T> = LightField<CowRepr<'a, T>>;

impl<S: RawData> LightField<S> {
    /// Wraps a 5D array with the axes `(v, u, t, s, c)`.
    ///
    /// # Shape
    ///
    /// `[V, U, T, S, C]`, any strides.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if an axis is empty; [`Error::TooLarge`] if a copy of the samples would not fit the address
    /// space. Only an array with strides of 0 can be that large.
    pub fn new(samples: ArrayBase<S, Ix5>) -> Result<Self, Error> {
        let (v, u, t, s, channels) = samples.dim();
        let shape = LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u))?;
        checked_length::<S::Elem>(&shape, channels)?;
        Ok(Self { samples })
    }

    /// Wraps samples of a shape that has been checked.
    fn trusted(samples: ArrayBase<S, Ix5>) -> Self {
        debug_assert!(samples.shape().iter().all(|&count| count > 0));
        Self { samples }
    }

    /// Returns the array, with the axes `(v, u, t, s, c)`.
    #[must_use]
    pub fn into_samples(self) -> ArrayBase<S, Ix5> {
        self.samples
    }

    /// Returns the (rows, columns) of views and of microlenses.
    ///
    /// The shape of the array, `[V, U, T, S, C]`, is `light_field.samples().shape()`.
    #[must_use]
    pub fn shape(&self) -> LightFieldShape {
        let (v, u, t, s, _) = self.samples.dim();
        LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).expect("checked when the light field was made")
    }

    /// Returns the number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.samples.dim().4
    }
}

impl<S: Data> LightField<S> {
    /// Returns the samples as an array with the axes `(v, u, t, s, c)`.
    #[must_use]
    pub fn samples(&self) -> ArrayView5<'_, S::Elem> {
        self.samples.view()
    }

    /// Returns a light field that borrows the samples of this one, as ndarray's `view` does for arrays.
    ///
    /// The name `view` stands for one viewpoint here; see [`LightField::view`].
    #[must_use]
    pub fn as_light_field_ref(&self) -> LightFieldRef<'_, S::Elem> {
        LightField::trusted(self.samples.view())
    }

    /// Returns a light field that owns a copy of the samples.
    ///
    /// Samples without gaps keep their order in memory. Others get the order `(v, u, t, s, c)`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the allocation of the copy fails.
    pub fn to_owned(&self) -> Result<LightFieldOwned<S::Elem>, Error>
    where
        S::Elem: Clone,
    {
        self.map(S::Elem::clone)
    }

    /// Returns a light field that owns its samples. It copies them only if this one borrows or shares them.
    ///
    /// # Errors
    ///
    /// As [`LightField::to_owned`].
    pub fn into_owned(self) -> Result<LightFieldOwned<S::Elem>, Error>
    where
        S::Elem: Clone,
    {
        match self.samples.try_into_owned_nocopy() {
            Ok(samples) => Ok(LightField::trusted(samples)),
            Err(samples) => LightField::trusted(samples).to_owned(),
        }
    }

    /// Returns the light field of the results of a function of every sample.
    ///
    /// The order in memory is that of [`LightField::to_owned`]. The function is called in that order.
    ///
    /// # Errors
    ///
    /// As [`LightField::to_owned`].
    pub fn map<U>(&self, function: impl FnMut(&S::Elem) -> U) -> Result<LightFieldOwned<U>, Error> {
        memory_order::map(self.samples.view(), function).map(LightField::trusted)
    }
}

impl<S: DataMut> LightField<S> {
    /// Returns the samples as a mutable array with the axes `(v, u, t, s, c)`.
    #[must_use]
    pub fn samples_mut(&mut self) -> ArrayViewMut5<'_, S::Elem> {
        self.samples.view_mut()
    }

    /// Returns a light field that mutably borrows this one.
    #[must_use]
    pub fn as_light_field_mut(&mut self) -> LightFieldRefMut<'_, S::Elem> {
        LightField::trusted(self.samples.view_mut())
    }
}

impl<S: RawData> TryFrom<ArrayBase<S, Ix5>> for LightField<S> {
    type Error = Error;

    /// As [`LightField::new`].
    fn try_from(samples: ArrayBase<S, Ix5>) -> Result<Self, Error> {
        Self::new(samples)
    }
}

impl<S: RawDataClone> Clone for LightField<S> {
    fn clone(&self) -> Self {
        Self { samples: self.samples.clone() }
    }
}

impl<S: RawDataClone + Copy> Copy for LightField<S> {}

/// Two light fields are equal if their shapes and samples are equal, in any order in memory.
impl<S, S2> PartialEq<LightField<S2>> for LightField<S>
where
    S: Data,
    S2: Data,
    S::Elem: PartialEq<S2::Elem>,
{
    fn eq(&self, other: &LightField<S2>) -> bool {
        self.samples == other.samples
    }
}

/// Prints shape and strides without the samples.
impl<S: RawData> fmt::Debug for LightField<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LightField")
            .field("shape", &self.samples.shape())
            .field("strides", &self.samples.strides())
            .finish_non_exhaustive()
    }
}

/// The number of samples of all channels, if there is at least one channel and their bytes fit the address space.
pub(crate) fn checked_length<T>(shape: &LightFieldShape, channels: usize) -> Result<usize, Error> {
    if channels == 0 {
        return Err(Error::ZeroCount { what: "channels" });
    }
    let too_large = Error::TooLarge { what: "light field" };
    // A zero-sized element takes no bytes, but the length of the array is bounded all the same.
    checked_product(&[shape.sample_count(), channels, size_of::<T>().max(1)]).ok_or(too_large)?;
    Ok(shape.sample_count() * channels)
}
