//! The values of validated accessors, read through the `gltf` crate: strides, sparse lists, conversions to floats.

use ::gltf::accessor::Item;
use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::mesh::util::{ReadColors, ReadIndices};

use super::accessors::Checker;
use super::buffer_views::BufferViews;
use super::draco::Decoded;
use super::handle::Handle;
use super::json::bad;
use crate::Error;

/// Reads accessors that a [`Checker`] has validated.
pub(super) struct Values<'f> {
    document: ::gltf::Document,
    buffer_views: &'f BufferViews<'f>,
}

/// The values of one primitive: those that its Draco data contains from there, others from the accessors.
#[derive(Clone, Copy)]
pub(super) struct PrimitiveValues<'v, 'f> {
    values: &'v Values<'f>,
    decoded: Option<&'v Decoded<'v>>,
}

/// How integers become floats: the equations of `KHR_mesh_quantization`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    divisor: f32,
    least: f32,
}

impl Scale {
    fn new(component: ComponentType, normalized: bool) -> Self {
        let (divisor, least) = match component {
            ComponentType::I8 if normalized => (127.0, -1.0),
            ComponentType::I16 if normalized => (32767.0, -1.0),
            ComponentType::U8 if normalized => (255.0, 0.0),
            ComponentType::U16 if normalized => (65535.0, 0.0),
            // Floats too: NaN must stay NaN, so that it is reported.
            _ => return Self { divisor: 1.0, least: f32::NEG_INFINITY },
        };
        Self { divisor, least }
    }

    /// Correctly rounded: integers of 16 bits are exact in f32.
    fn apply(self, x: f32) -> f32 {
        let x = x / self.divisor;
        if x < self.least { self.least } else { x }
    }
}

impl<'f> Values<'f> {
    /// Those that were validated.
    pub(super) fn of(accessors: Checker<'f>) -> Self {
        let (document, buffer_views) = accessors.finish();
        Self { document, buffer_views }
    }

    /// The values of a primitive with this Draco data.
    pub(super) fn with<'v>(&'v self, decoded: Option<&'v Decoded<'v>>) -> PrimitiveValues<'v, 'f> {
        PrimitiveValues { values: self, decoded }
    }

    /// Floats, or integers as floats.
    pub(super) fn numbers<const N: usize>(&self, handle: Handle) -> Result<Vec<[f32; N]>, Error>
    where
        [i8; N]: Item,
        [u8; N]: Item,
        [i16; N]: Item,
        [u16; N]: Item,
        [f32; N]: Item,
    {
        let (component, scale) = self.scale(handle)?;
        let convert = |x: [f32; N]| x.map(|x| scale.apply(x));
        match component {
            ComponentType::I8 => {
                self.collect(handle, |a| Some(self.iterate::<[i8; N]>(a)?.map(|x| convert(x.map(f32::from)))))
            }
            ComponentType::U8 => {
                self.collect(handle, |a| Some(self.iterate::<[u8; N]>(a)?.map(|x| convert(x.map(f32::from)))))
            }
            ComponentType::I16 => {
                self.collect(handle, |a| Some(self.iterate::<[i16; N]>(a)?.map(|x| convert(x.map(f32::from)))))
            }
            ComponentType::U16 => {
                self.collect(handle, |a| Some(self.iterate::<[u16; N]>(a)?.map(|x| convert(x.map(f32::from)))))
            }
            ComponentType::U32 | ComponentType::F32 => self.collect(handle, |a| self.iterate(a)),
        }
    }

    /// The components of all elements, one after the other: floats, or integers as floats.
    pub(super) fn components(&self, handle: Handle) -> Result<Vec<f32>, Error> {
        let accessor = self.accessor(handle).ok_or_else(|| unreadable(handle))?;
        match accessor.dimensions() {
            Type::Scalar => self.scalars(handle),
            Type::Vec2 => self.numbers::<2>(handle).map(Vec::into_flattened),
            Type::Vec3 => self.numbers::<3>(handle).map(Vec::into_flattened),
            _ => self.numbers::<4>(handle).map(Vec::into_flattened),
        }
    }

    fn scalars(&self, handle: Handle) -> Result<Vec<f32>, Error> {
        let (component, scale) = self.scale(handle)?;
        let convert = |x: f32| scale.apply(x);
        match component {
            ComponentType::I8 => self.collect(handle, |a| Some(self.iterate::<i8>(a)?.map(|x| convert(f32::from(x))))),
            ComponentType::U8 => self.collect(handle, |a| Some(self.iterate::<u8>(a)?.map(|x| convert(f32::from(x))))),
            ComponentType::I16 => {
                self.collect(handle, |a| Some(self.iterate::<i16>(a)?.map(|x| convert(f32::from(x)))))
            }
            ComponentType::U16 => {
                self.collect(handle, |a| Some(self.iterate::<u16>(a)?.map(|x| convert(f32::from(x)))))
            }
            ComponentType::U32 | ComponentType::F32 => self.collect(handle, |a| self.iterate(a)),
        }
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

    /// The type of the components of an accessor, and how they become floats.
    fn scale(&self, handle: Handle) -> Result<(ComponentType, Scale), Error> {
        let accessor = self.accessor(handle).ok_or_else(|| unreadable(handle))?;
        let component = accessor.data_type();
        Ok((component, Scale::new(component, accessor.normalized())))
    }

    fn iterate<'a, T: Item>(&'a self, accessor: ::gltf::Accessor<'a>) -> Option<::gltf::accessor::Iter<'a, T>> {
        // An accessor without data consists of zeros; the crate has no iterator for it.
        if accessor.view().is_none() && accessor.sparse().is_none() {
            return None;
        }
        ::gltf::accessor::Iter::new(accessor, |buffer: ::gltf::Buffer<'a>| self.buffer_views.buffer(buffer.index()))
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

impl PrimitiveValues<'_, '_> {
    /// Positions or normals.
    pub(super) fn vectors(&self, handle: Handle) -> Result<Vec<[f32; 3]>, Error> {
        self.decoded(handle)?.map_or_else(|| self.values.numbers(handle), Ok)
    }

    /// Texture coordinates as floats.
    pub(super) fn texture_coordinates(&self, handle: Handle) -> Result<Vec<[f32; 2]>, Error> {
        self.decoded(handle)?.map_or_else(|| self.values.numbers(handle), Ok)
    }

    /// Colors as floats; alpha is 1 if there is none.
    pub(super) fn colors(&self, handle: Handle) -> Result<Vec<[f32; 4]>, Error> {
        let rgb = self.values.accessor(handle).is_some_and(|accessor| accessor.dimensions() == Type::Vec3);
        let decoded = if rgb {
            self.decoded(handle)?.map(|colors| colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
        } else {
            self.decoded(handle)?
        };
        decoded.map_or_else(|| self.values.colors(handle), Ok)
    }

    /// Tangents with their signs.
    pub(super) fn tangents(&self, handle: Handle) -> Result<Vec<[f32; 4]>, Error> {
        self.decoded(handle)?.map_or_else(|| self.values.numbers(handle), Ok)
    }

    /// The joints that a vertex follows.
    pub(super) fn joints(&self, handle: Handle) -> Result<Vec<[u16; 4]>, Error> {
        // Integers of 16 bits are exact in f32.
        Ok(self.weights(handle)?.into_iter().map(|joints| joints.map(|joint| joint as u16)).collect())
    }

    /// The weights of the joints.
    pub(super) fn weights(&self, handle: Handle) -> Result<Vec<[f32; 4]>, Error> {
        self.decoded(handle)?.map_or_else(|| self.values.numbers(handle), Ok)
    }

    /// The triangles of the Draco data, if there is one.
    pub(super) fn triangles(&self) -> Option<Result<Vec<[u32; 3]>, Error>> {
        self.decoded.map(|decoded| decoded.triangles())
    }

    /// Calls `take` with an iterator over the vertex indices of an accessor.
    pub(super) fn with_indices<T>(
        &self,
        handle: Handle,
        take: impl FnOnce(&mut dyn Iterator<Item = u32>) -> T,
    ) -> Result<T, Error> {
        self.values.with_indices(handle, take)
    }

    /// The values of an attribute in the Draco data, as floats.
    fn decoded<const N: usize>(&self, handle: Handle) -> Result<Option<Vec<[f32; N]>>, Error> {
        let Some(decoded) = self.decoded else { return Ok(None) };
        let (component, scale) = self.values.scale(handle)?;
        let Some(numbers) = decoded.numbers(handle, N, component == ComponentType::F32)? else { return Ok(None) };
        let mut values = reserve(handle.count, handle)?;
        values.extend(numbers.as_chunks().0.iter().map(|x: &[f32; N]| x.map(|x| scale.apply(x))));
        if values.len() == handle.count { Ok(Some(values)) } else { Err(unreadable(handle)) }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_become_floats_by_the_equations_of_the_extension() {
        use ComponentType::{F32, I8, I16, U8, U16};
        let cases = [
            (I8, true, [(-128.0, -1.0), (-127.0, -1.0), (127.0, 1.0), (63.0, 63.0 / 127.0)]),
            (I16, true, [(-32768.0, -1.0), (-32767.0, -1.0), (32767.0, 1.0), (1.0, 1.0 / 32767.0)]),
            (U8, true, [(0.0, 0.0), (255.0, 1.0), (51.0, 0.2), (1.0, 1.0 / 255.0)]),
            (U16, true, [(0.0, 0.0), (65535.0, 1.0), (13107.0, 0.2), (1.0, 1.0 / 65535.0)]),
            (I8, false, [(-128.0, -128.0), (127.0, 127.0), (0.0, 0.0), (3.0, 3.0)]),
            (U16, false, [(65535.0, 65535.0), (0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]),
            (F32, true, [(1e30, 1e30), (-7.5, -7.5), (0.0, 0.0), (f32::INFINITY, f32::INFINITY)]),
        ];
        for (component, normalized, values) in cases {
            for (integer, float) in values {
                assert_eq!(Scale::new(component, normalized).apply(integer), float, "{component:?} {integer}");
            }
        }
        assert!(Scale::new(F32, false).apply(f32::NAN).is_nan());
    }
}
