//! The values of validated accessors, read through the `gltf` crate: strides, sparse lists, conversions to floats.

use std::borrow::Cow;

use ::gltf::accessor::Item;
use ::gltf::animation::util::Rotations as ReadRotations;
use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::mesh::util::{ReadColors, ReadIndices, ReadJoints, ReadTexCoords, ReadWeights};

use super::accessors::Handle;
use super::json::bad;
use crate::Error;

/// Reads accessors that [`super::accessors::Checker`] has validated.
pub(super) struct Values<'f> {
    document: ::gltf::Document,
    buffers: &'f [Cow<'f, [u8]>],
}

impl<'f> Values<'f> {
    /// `document` contains only validated accessors.
    pub(super) fn new(document: ::gltf::Document, buffers: &'f [Cow<'f, [u8]>]) -> Self {
        Self { document, buffers }
    }

    /// Positions or normals.
    pub(super) fn vectors(&self, handle: Handle) -> Result<Vec<[f32; 3]>, Error> {
        self.collect(handle, |accessor| self.iterate(accessor))
    }

    /// Texture coordinates as floats.
    pub(super) fn texture_coordinates(&self, handle: Handle) -> Result<Vec<[f32; 2]>, Error> {
        self.collect(handle, |accessor| {
            let read = match accessor.data_type() {
                ComponentType::U8 => ReadTexCoords::U8(self.iterate(accessor)?),
                ComponentType::U16 => ReadTexCoords::U16(self.iterate(accessor)?),
                _ => ReadTexCoords::F32(self.iterate(accessor)?),
            };
            Some(read.into_f32())
        })
    }

    /// Colors as floats; alpha is 1 if there is none.
    pub(super) fn colors(&self, handle: Handle) -> Result<Vec<[f32; 4]>, Error> {
        self.collect(handle, |accessor| {
            let rgb = accessor.dimensions() == Type::Vec3;
            let read = match (accessor.data_type(), rgb) {
                (ComponentType::U8, true) => ReadColors::RgbU8(self.iterate(accessor)?),
                (ComponentType::U16, true) => ReadColors::RgbU16(self.iterate(accessor)?),
                (_, true) => ReadColors::RgbF32(self.iterate(accessor)?),
                (ComponentType::U8, false) => ReadColors::RgbaU8(self.iterate(accessor)?),
                (ComponentType::U16, false) => ReadColors::RgbaU16(self.iterate(accessor)?),
                (_, false) => ReadColors::RgbaF32(self.iterate(accessor)?),
            };
            Some(read.into_rgba_f32())
        })
    }

    /// Quaternions as floats.
    pub(super) fn rotations(&self, handle: Handle) -> Result<Vec<[f32; 4]>, Error> {
        self.collect(handle, |accessor| {
            let read = match accessor.data_type() {
                ComponentType::I8 => ReadRotations::I8(self.iterate(accessor)?),
                ComponentType::I16 => ReadRotations::I16(self.iterate(accessor)?),
                _ => ReadRotations::F32(self.iterate(accessor)?),
            };
            Some(read.into_f32())
        })
    }

    /// The joints of vertices.
    pub(super) fn joints(&self, handle: Handle) -> Result<Vec<[u16; 4]>, Error> {
        self.collect(handle, |accessor| {
            let read = match accessor.data_type() {
                ComponentType::U8 => ReadJoints::U8(self.iterate(accessor)?),
                _ => ReadJoints::U16(self.iterate(accessor)?),
            };
            Some(read.into_u16())
        })
    }

    /// The weights of joints as floats.
    pub(super) fn weights(&self, handle: Handle) -> Result<Vec<[f32; 4]>, Error> {
        self.collect(handle, |accessor| {
            let read = match accessor.data_type() {
                ComponentType::U8 => ReadWeights::U8(self.iterate(accessor)?),
                ComponentType::U16 => ReadWeights::U16(self.iterate(accessor)?),
                _ => ReadWeights::F32(self.iterate(accessor)?),
            };
            Some(read.into_f32())
        })
    }

    /// Matrices, column by column.
    pub(super) fn matrices(&self, handle: Handle) -> Result<Vec<[[f32; 4]; 4]>, Error> {
        self.collect(handle, |accessor| self.iterate(accessor))
    }

    /// Calls `take` with an iterator over the vertex indices.
    pub(super) fn with_indices<T>(
        &self,
        handle: Handle,
        take: impl FnOnce(&mut dyn Iterator<Item = u32>) -> T,
    ) -> Result<T, Error> {
        let read = self.accessor(handle).and_then(|accessor| {
            Some(match accessor.data_type() {
                ComponentType::U8 => ReadIndices::U8(self.iterate(accessor)?),
                ComponentType::U16 => ReadIndices::U16(self.iterate(accessor)?),
                _ => ReadIndices::U32(self.iterate(accessor)?),
            })
        });
        match read {
            Some(read) => Ok(take(&mut read.into_u32())),
            None if self.is_zero(handle) => Ok(take(&mut std::iter::repeat_n(0, handle.count))),
            None => Err(unreadable(handle)),
        }
    }

    fn accessor(&self, handle: Handle) -> Option<::gltf::Accessor<'_>> {
        self.document.accessors().nth(handle.checked)
    }

    fn iterate<'a, T: Item>(&'a self, accessor: ::gltf::Accessor<'a>) -> Option<::gltf::accessor::Iter<'a, T>> {
        // An accessor without data consists of zeros; the crate has no iterator for it.
        if accessor.view().is_none() && accessor.sparse().is_none() {
            return None;
        }
        ::gltf::accessor::Iter::new(accessor, |buffer: ::gltf::Buffer<'a>| {
            self.buffers.get(buffer.index()).map(|b| &**b)
        })
    }

    fn is_zero(&self, handle: Handle) -> bool {
        self.accessor(handle).is_some_and(|a| a.view().is_none() && a.sparse().is_none())
    }

    fn collect<'a, T: Item + Clone, I: Iterator<Item = T>>(
        &'a self,
        handle: Handle,
        read: impl FnOnce(::gltf::Accessor<'a>) -> Option<I>,
    ) -> Result<Vec<T>, Error> {
        if self.is_zero(handle) {
            let mut values = reserve(handle.count, handle)?;
            values.resize(handle.count, T::zero());
            return Ok(values);
        }
        let items = self.accessor(handle).and_then(read).ok_or_else(|| unreadable(handle))?;
        let mut values = reserve(handle.count, handle)?;
        values.extend(items.take(handle.count));
        if values.len() == handle.count { Ok(values) } else { Err(unreadable(handle)) }
    }
}

/// Allocates memory for `count` elements, or returns an error.
fn reserve<T>(count: usize, handle: Handle) -> Result<Vec<T>, Error> {
    let mut values = Vec::new();
    let at = || bad(format!("accessors[{}].count", handle.number), format!("{count} elements do not fit into memory"));
    values.try_reserve_exact(count).map_err(|_| at())?;
    Ok(values)
}

/// Should not occur after validation.
fn unreadable(handle: Handle) -> Error {
    bad(format!("accessors[{}]", handle.number), "cannot be read")
}
