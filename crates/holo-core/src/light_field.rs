//! The 5D light field: one array type over any strides.

mod clip;
mod compose;
mod dynamic;
mod encoding;
mod epi;
mod grids;
mod images;
mod interpolate;
mod path;
mod quilt;
pub mod rearrange;
mod rotate;
mod sample;

pub use compose::ViewOrder;
pub use dynamic::{DynImage, DynImageRef, DynLightField, DynLightFieldRef};
pub use grids::Layout;
pub use path::ViewPath;
pub use quilt::evenly_spaced_views;
pub use sample::{Sample, SampleKind};

use std::fmt;

use ndarray::{
    ArrayBase, ArrayView5, ArrayViewMut5, CowRepr, Data, DataMut, Ix5, OwnedRepr, RawData, RawDataClone, ViewRepr,
};

use crate::layout::checked_product;
use crate::{Error, GridSize, Split};

/// A light field `H(v, u, t, s, c)`: lens row, lens column, view row, view column, channel.
///
/// It wraps an ndarray of five dimensions with **any strides** and any storage: owned, borrowed, mutably borrowed, shared. The elemental
/// grid, the viewpoint grid and every crop of either are the same type with other strides, so wrapping one copies nothing and
/// every algorithm is written once. No axis is ever empty.
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
/// use holo_core::{GridSize, LightField, Split};
/// use ndarray::Array3;
///
/// let split = Split::new(GridSize::new(2, 3), GridSize::new(4, 5))?;
/// let raw = Array3::from_shape_fn((8, 15, 1), |(row, column, _)| (row * 15 + column) as u8);
/// let from_lenses = LightField::from_elemental_grid(raw, split)?;
/// let from_views = LightField::from_viewpoint_grid(from_lenses.to_viewpoint_grid(), split)?;
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
    /// [`Error::ZeroCount`] if an axis is empty; [`Error::TooLarge`] if the samples would not fit the address space when copied out, which only an
    /// array that repeats itself by strides of 0 can reach.
    pub fn new(samples: ArrayBase<S, Ix5>) -> Result<Self, Error> {
        let (v, u, t, s, channels) = samples.dim();
        let split = Split::new(GridSize::new(t, s), GridSize::new(v, u))?;
        checked_length::<S::Elem>(&split, channels)?;
        Ok(Self { samples })
    }

    /// Wraps samples whose shape is known to be good.
    fn trusted(samples: ArrayBase<S, Ix5>) -> Self {
        debug_assert!(samples.shape().iter().all(|&count| count > 0));
        Self { samples }
    }

    /// Returns the array itself.
    #[must_use]
    pub fn into_samples(self) -> ArrayBase<S, Ix5> {
        self.samples
    }

    /// Returns the number of views and lenses.
    #[must_use]
    pub fn split(&self) -> Split {
        let (v, u, t, s, _) = self.samples.dim();
        Split::new(GridSize::new(t, s), GridSize::new(v, u)).expect("checked when the light field was made")
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

    /// Returns a light field that borrows this one.
    #[must_use]
    pub fn borrowed(&self) -> LightFieldRef<'_, S::Elem> {
        LightField::trusted(self.samples.view())
    }

    /// Copies the samples out into a light field of its own.
    ///
    /// Samples without gaps keep their order in memory, others are put in the order `(v, u, t, s, c)`.
    #[must_use]
    pub fn to_owned(&self) -> LightFieldOwned<S::Elem>
    where
        S::Elem: Clone,
    {
        LightField::trusted(self.samples.to_owned())
    }

    /// Makes a light field that owns its samples, copying them only if this one borrows them.
    #[must_use]
    pub fn into_owned(self) -> LightFieldOwned<S::Elem>
    where
        S::Elem: Clone,
    {
        LightField::trusted(self.samples.into_owned())
    }

    /// Applies a function to every sample and keeps the results.
    #[must_use]
    pub fn map<U>(&self, function: impl FnMut(&S::Elem) -> U) -> LightFieldOwned<U> {
        LightField::trusted(self.samples.map(function))
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
    pub fn borrowed_mut(&mut self) -> LightFieldRefMut<'_, S::Elem> {
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

/// Two light fields are equal when their counts and samples are, whatever their order in memory.
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

/// Prints counts and strides, not 40 million samples.
impl<S: RawData> fmt::Debug for LightField<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LightField")
            .field("shape", &self.samples.shape())
            .field("strides", &self.samples.strides())
            .finish_non_exhaustive()
    }
}

/// The number of samples of all channels, if there is at least one channel and their bytes fit the address space.
pub(crate) fn checked_length<T>(split: &Split, channels: usize) -> Result<usize, Error> {
    if channels == 0 {
        return Err(Error::ZeroCount { what: "channels" });
    }
    let too_large = Error::TooLarge { what: "light field" };
    // A zero-sized element takes no bytes, but the length of the array is bounded all the same.
    checked_product(&[split.sample_count(), channels, size_of::<T>().max(1)]).ok_or(too_large)?;
    Ok(split.sample_count() * channels)
}

/// Memory for `length` samples, asked for without aborting the program when there is none.
pub(crate) fn filled_memory<T: Clone>(length: usize, value: T) -> Result<Vec<T>, Error> {
    // Asked for and given back: an error where there is no such memory. Then `vec!`, which leaves zeros to the system, so
    // that pages are made by the threads that first write to them.
    Vec::<T>::new()
        .try_reserve_exact(length)
        .map_err(|_| Error::OutOfMemory { bytes: length.saturating_mul(size_of::<T>()) })?;
    Ok(vec![value; length])
}
