//! Eq. 5: conversion between 2D layouts and light fields by strides alone.

use ndarray::{Array5, ArrayBase, ArrayRef, ArrayView3, Axis, Data, Ix3, RawData};

use super::memory_order::{self, MemoryOrder, inverse};
use super::{LightField, LightFieldCow, LightFieldOwned, checked_length};
use crate::base::memory::filled;
use crate::{Error, LightFieldShape};

/// The layout of the samples of a raw image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Elemental image array: microlens `(v, u)` owns the T x S block at row `v*T`, column `u*S`.
    ElementalGrid,
    /// Sub-aperture image array: view `(t, s)` owns the V x U block at row `t*V`, column `s*U`.
    ViewpointGrid,
}

impl Layout {
    /// The permutation from the axes (outer row, inner row, outer column, inner column, channel) of an image in this
    /// layout to `(v, u, t, s, c)`: entry n is the image axis of light field axis n.
    const fn axes(self) -> [usize; 5] {
        match self {
            // The image splits into (v, t, u, s, c).
            Self::ElementalGrid => [0, 2, 1, 3, 4],
            // The image splits into (t, v, s, u, c).
            Self::ViewpointGrid => [1, 3, 0, 2, 4],
        }
    }

    /// The outer and inner counts of rows and columns.
    const fn counts(self, shape: &LightFieldShape) -> [usize; 4] {
        let (views, lenses) = (shape.views(), shape.lenses());
        match self {
            Self::ElementalGrid => [lenses.rows, views.rows, lenses.columns, views.columns],
            Self::ViewpointGrid => [views.rows, lenses.rows, views.columns, lenses.columns],
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::ElementalGrid => "elemental grid",
            Self::ViewpointGrid => "viewpoint grid",
        }
    }
}

impl<S: RawData> LightField<S> {
    /// Wraps an elemental grid, the raw image behind the microlenses, without copying it.
    ///
    /// The storage is that of the image: owned, borrowed or mutably borrowed.
    ///
    /// # Shape
    ///
    /// `(V*T, U*S, C)`: row, column, channel. The image must have no gaps in memory. Its axes may have any order and
    /// direction. [`LightField::from_elemental_grid_view`] borrows an image with gaps, such as a crop.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the image has another size; [`Error::NotDense`] if it has gaps; [`Error::ZeroCount`] without
    /// channels.
    ///
    /// # Source
    ///
    /// Eq. 5.
    pub fn from_elemental_grid(image: ArrayBase<S, Ix3>, shape: LightFieldShape) -> Result<Self, Error> {
        split_dense(image, &shape, Layout::ElementalGrid)
    }

    /// Wraps a viewpoint grid, all views side by side, without copying it.
    ///
    /// # Shape
    ///
    /// `(T*V, S*U, C)`: row, column, channel; without gaps in memory, as for [`LightField::from_elemental_grid`].
    ///
    /// # Errors
    ///
    /// As [`LightField::from_elemental_grid`].
    ///
    /// # Source
    ///
    /// Eq. 5.
    pub fn from_viewpoint_grid(image: ArrayBase<S, Ix3>, shape: LightFieldShape) -> Result<Self, Error> {
        split_dense(image, &shape, Layout::ViewpointGrid)
    }

    /// Returns the elemental grid without copying, if the memory order of the samples is that of the grid, row by row.
    ///
    /// # Errors
    ///
    /// The light field itself, if its memory order differs. [`LightField::to_elemental_grid`] copies it.
    pub fn into_elemental_grid(self) -> Result<ArrayBase<S, Ix3>, Self> {
        self.into_grid(Layout::ElementalGrid)
    }

    /// Returns the viewpoint grid without copying, if the memory order of the samples is that of the grid, row by row.
    ///
    /// # Errors
    ///
    /// The light field itself, if its memory order differs. [`LightField::to_viewpoint_grid`] copies it.
    pub fn into_viewpoint_grid(self) -> Result<ArrayBase<S, Ix3>, Self> {
        self.into_grid(Layout::ViewpointGrid)
    }

    fn into_grid(self, layout: Layout) -> Result<ArrayBase<S, Ix3>, Self> {
        let (shape, channels) = (self.shape(), self.channels());
        let ordered = self.samples.permuted_axes(inverse(layout.axes()));
        if ordered.is_standard_layout() {
            let raw = shape.raw_size();
            Ok(ordered.into_shape_with_order((raw.rows, raw.columns, channels)).expect("standard layout, same length"))
        } else {
            Err(Self::trusted(ordered.permuted_axes(layout.axes())))
        }
    }
}

impl<S: Data> LightField<S> {
    /// Returns the elemental grid as a borrowed image, if the memory order of the samples is that of the grid, row by
    /// row.
    #[must_use]
    pub fn as_elemental_grid(&self) -> Option<ArrayView3<'_, S::Elem>> {
        self.as_light_field_ref().into_elemental_grid().ok()
    }

    /// Returns the viewpoint grid as a borrowed image, if the memory order of the samples is that of the grid, row by
    /// row.
    #[must_use]
    pub fn as_viewpoint_grid(&self) -> Option<ArrayView3<'_, S::Elem>> {
        self.as_light_field_ref().into_viewpoint_grid().ok()
    }
}

impl<'a, T: Clone> LightFieldCow<'a, T> {
    /// Borrows an elemental grid of any strides, such as a crop of a larger image or planar channels.
    ///
    /// Nothing is copied. (The copy-on-write type is the return type of ndarray's safe reshaping.)
    ///
    /// # Shape
    ///
    /// `(V*T, U*S, C)`: row, column, channel, any strides.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the image has another size; [`Error::ZeroCount`] without channels; [`Error::TooLarge`] if a
    /// copy would not fit the address space, which strides of 0 can cause.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, Remainder, Sensor};
    /// use ndarray::{Array3, s};
    ///
    /// // A sensor of 7 x 11 pixels holds 2 x 3 views of 3 x 3 pixels; one row and two columns are left over.
    /// let sensor = Sensor::Other(GridSize::new(7, 11)).divide(GridSize::new(2, 3), Remainder::Crop)?;
    /// let image = Array3::from_shape_fn((7, 11, 1), |(row, column, _)| row * 100 + column);
    /// let used = image.slice(s![..6, ..9, ..]);
    /// let light_field = LightField::from_elemental_grid_view(&used, sensor.shape)?;
    /// assert_eq!(light_field.samples()[[2, 1, 1, 2, 0]], (2 * 2 + 1) * 100 + 1 * 3 + 2);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn from_elemental_grid_view(image: &'a ArrayRef<T, Ix3>, shape: LightFieldShape) -> Result<Self, Error> {
        split_any(image, &shape, Layout::ElementalGrid)
    }

    /// Borrows a viewpoint grid of any strides; see [`LightField::from_elemental_grid_view`].
    ///
    /// # Shape
    ///
    /// `(T*V, S*U, C)`: row, column, channel, any strides.
    ///
    /// # Errors
    ///
    /// As [`LightField::from_elemental_grid_view`].
    pub fn from_viewpoint_grid_view(image: &'a ArrayRef<T, Ix3>, shape: LightFieldShape) -> Result<Self, Error> {
        split_any(image, &shape, Layout::ViewpointGrid)
    }
}

impl<T: Clone> LightFieldOwned<T> {
    /// Returns a light field with every sample equal to `value`, in the memory order of `layout`.
    ///
    /// [`LightField::into_elemental_grid`] or [`LightField::into_viewpoint_grid`] turns it into an image without
    /// copying.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] without channels; [`Error::TooLarge`] if the size overflows; [`Error::OutOfMemory`] if the
    /// allocation fails.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, Layout, LightField, LightFieldShape};
    ///
    /// let shape = LightFieldShape::new(GridSize::new(2, 2), GridSize::new(3, 4))?;
    /// let mut light_field = LightField::filled(shape, 3, Layout::ElementalGrid, 0_u8)?;
    /// light_field.view_mut(1, 0)?.fill(255);
    /// let raw = light_field.into_elemental_grid().unwrap();
    /// assert_eq!((raw[[1, 0, 0]], raw[[0, 0, 0]], raw[[1, 1, 0]]), (255, 0, 0));
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn filled(shape: LightFieldShape, channels: usize, layout: Layout, value: T) -> Result<Self, Error> {
        let memory = filled("a light field", checked_length::<T>(&shape, channels)?, value)?;
        let [rows, inner_rows, columns, inner_columns] = layout.counts(&shape);
        let samples = Array5::from_shape_vec((rows, inner_rows, columns, inner_columns, channels), memory)
            .expect("the length is the product of the shape");
        Ok(Self::trusted(samples.permuted_axes(layout.axes())))
    }
}

/// Checks that an image has the raw size of a shape, and returns its number of channels.
fn check_shape(found: &[usize], shape: &LightFieldShape, layout: Layout) -> Result<usize, Error> {
    let raw = shape.raw_size();
    let channels = found[2];
    if found[..2] != [raw.rows, raw.columns] {
        let expected = vec![raw.rows, raw.columns, channels];
        return Err(Error::Shape { what: layout.name(), expected, found: found.to_vec() });
    }
    Ok(channels)
}

/// Splits the rows and columns of an image of any storage.
///
/// ndarray splits axes in place only in standard layout. A dense image is in standard layout once its axes are sorted
/// by stride and run forward; afterwards the order and the direction of the axes are restored. Only strides change.
fn split_dense<S: RawData>(
    image: ArrayBase<S, Ix3>,
    shape: &LightFieldShape,
    layout: Layout,
) -> Result<LightField<S>, Error> {
    let channels = check_shape(image.shape(), shape, layout)?;
    checked_length::<S::Elem>(shape, channels)?;
    let not_dense = Error::NotDense { shape: image.shape().to_vec(), strides: image.strides().to_vec() };

    let (image, MemoryOrder { axes: order, reversed }) = memory_order::sorted(image);
    if !image.is_standard_layout() {
        return Err(not_dense);
    }

    let [rows, inner_rows, columns, inner_columns] = layout.counts(shape);
    // Per image axis: the lengths of the axes that it splits into, and their positions among (outer row, inner row,
    // outer column, inner column, channel).
    let parts: [&[(usize, usize)]; 3] =
        [&[(rows, 0), (inner_rows, 1)], &[(columns, 2), (inner_columns, 3)], &[(channels, 4)]];
    let split_axes: Vec<(usize, usize)> = order.iter().flat_map(|&axis| parts[axis].iter().copied()).collect();
    let counts: [usize; 5] = std::array::from_fn(|axis| split_axes[axis].0);
    let places: [usize; 5] = std::array::from_fn(|axis| split_axes[axis].1);
    let samples = image.into_shape_with_order(counts).expect("standard layout, same length");
    let mut samples = samples.permuted_axes(inverse(places));

    // A reversed axis splits into two reversed axes.
    for axis in (0..3).filter(|&axis| reversed[axis]) {
        for &(_, place) in parts[axis] {
            samples.invert_axis(Axis(place));
        }
    }
    Ok(LightField::trusted(samples.permuted_axes(layout.axes())))
}

/// Splits the rows and columns of a borrowed image of any strides.
fn split_any<'a, T: Clone>(
    image: &'a ArrayRef<T, Ix3>,
    shape: &LightFieldShape,
    layout: Layout,
) -> Result<LightFieldCow<'a, T>, Error> {
    let channels = check_shape(image.shape(), shape, layout)?;
    checked_length::<T>(shape, channels)?;
    let [rows, inner_rows, columns, inner_columns] = layout.counts(shape);
    // `to_shape` copies only where axes are merged. Splitting an axis needs strides alone.
    let samples = image.to_shape((rows, inner_rows, columns, inner_columns, channels)).expect("same length");
    debug_assert!(samples.is_view());
    Ok(LightField::trusted(samples.permuted_axes(layout.axes())))
}
