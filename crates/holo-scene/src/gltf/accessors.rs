//! Validation of accessors before the `gltf` crate reads them.
//!
//! The `gltf` crate panics on indices out of range, wrong component types, counts of zero, short sparse lists and
//! overflowing sizes. It therefore gets a document that contains only the accessors that are read, each of them checked
//! against its buffer to the last byte.

use std::collections::BTreeMap;

use ::gltf::json;
use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::json::validation::{Checked, USize64};

use super::buffer_views::BufferViews;
use super::handle::Handle;
use super::json::{Object, bad};
use crate::Error;

/// The use of an accessor, which determines the allowed types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Positions,
    Normals,
    Tangents,
    TextureCoordinates,
    Colors,
    Indices,
    /// Quaternions of instances.
    Rotations,
    /// Vertex joints of a skin.
    Joints,
    /// Vertex weights of a skin.
    Weights,
    /// Inverse bind matrices.
    Matrices,
    /// Times of an animation.
    Times,
    /// Values of an animation, of this shape.
    Animated(Type),
}

/// Validates accessors one by one.
pub(super) struct Checker<'f> {
    accessors: Vec<Object<'f>>,
    buffer_views: &'f BufferViews<'f>,
    known: BTreeMap<usize, Handle>,
    known_views: BTreeMap<usize, usize>,
    root: json::Root,
}

impl<'f> Checker<'f> {
    pub(super) fn new(root: &Object<'f>, buffer_views: &'f BufferViews<'f>) -> Result<Self, Error> {
        let mut document = json::Root::default();
        for number in 0..buffer_views.buffer_count() {
            document.buffers.push(json::Buffer {
                // Those of compressed buffer views are not decoded yet. The crate does not use the length.
                byte_length: USize64::from(buffer_views.buffer(number).map_or(0, <[u8]>::len)),
                name: None,
                uri: None,
                extensions: None,
                extras: json::Extras::default(),
            });
        }
        Ok(Self {
            accessors: root.objects("accessors")?,
            buffer_views,
            known: BTreeMap::new(),
            known_views: BTreeMap::new(),
            root: document,
        })
    }

    /// The number of accessors of the file.
    pub(super) fn len(&self) -> usize {
        self.accessors.len()
    }

    /// Whether the accessor has data, rather than the zeros of one without a buffer view.
    pub(super) fn has_data(&self, number: usize) -> bool {
        self.accessors.get(number).is_some_and(|a| a.has("bufferView") || a.has("sparse"))
    }

    /// The shape of the elements of accessor `number` (in range).
    pub(super) fn shape(&self, number: usize) -> Result<Type, Error> {
        shape(&self.accessors[number])
    }

    /// The bytes of the buffer view that an object refers to.
    pub(super) fn buffer_view(&self, user: &Object<'_>) -> Result<&'f [u8], Error> {
        let number = user.index("bufferView", "bufferViews", self.buffer_views.len())?;
        Ok(self.buffer_views.get(number.ok_or_else(|| user.missing("bufferView"))?)?.bytes)
    }

    /// Validates accessor `number` (in range) for a use; `user` is the JSON path of the reference to it.
    pub(super) fn check(&mut self, number: usize, wanted: Use, user: &str) -> Result<Handle, Error> {
        let Some(accessor) = self.accessors.get(number).cloned() else {
            return Err(bad(user, format!("refers to accessors[{number}], which is not there")));
        };
        let component = component_type(&accessor)?;
        let shape = shape(&accessor)?;
        let normalized = accessor.boolean("normalized")?.unwrap_or(false);
        check_use(&accessor, wanted, (component, shape, normalized), user)?;
        if let Some(&handle) = self.known.get(&number) {
            return Ok(handle);
        }
        let count = count(&accessor)?;
        let size = component.size() * shape.multiplicity();
        let offset = accessor.unsigned("byteOffset")?.unwrap_or(0);
        let view = match accessor.index("bufferView", "bufferViews", self.buffer_views.len())? {
            Some(view) => {
                self.check_range(&accessor, view, (offset, count, size), true)?;
                Some(json::Index::new(self.view(view)?))
            }
            None => None,
        };
        let sparse = match accessor.object("sparse")? {
            Some(sparse) => Some(self.check_sparse(&sparse, count, size)?),
            None => None,
        };
        let handle = Handle { number, count, checked: self.root.accessors.len() };
        self.root.accessors.push(json::Accessor {
            buffer_view: view,
            byte_offset: Some(USize64(offset)),
            count: USize64::from(count),
            component_type: Checked::Valid(json::accessor::GenericComponentType(component)),
            extensions: None,
            extras: json::Extras::default(),
            type_: Checked::Valid(shape),
            min: None,
            max: None,
            name: None,
            normalized,
            sparse,
        });
        self.known.insert(number, handle);
        Ok(handle)
    }

    /// The accessors that were validated, for the `gltf` crate.
    pub(super) fn finish(self) -> (::gltf::Document, &'f BufferViews<'f>) {
        // Nothing is left to validate, and the validation of the crate requires optional fields (min, max).
        (::gltf::Document::from_json_without_validation(self.root), self.buffer_views)
    }

    /// Copies a buffer view to the document for the `gltf` crate, once.
    fn view(&mut self, number: usize) -> Result<u32, Error> {
        if let Some(&known) = self.known_views.get(&number) {
            return Ok(known as u32);
        }
        let view = self.buffer_views.get(number)?;
        let known = self.root.buffer_views.len();
        self.root.buffer_views.push(json::buffer::View {
            buffer: json::Index::new(view.buffer as u32),
            byte_length: USize64::from(view.bytes.len()),
            byte_offset: Some(USize64::from(view.offset)),
            byte_stride: view.stride.map(json::buffer::Stride),
            name: None,
            target: None,
            extensions: None,
            extras: json::Extras::default(),
        });
        self.known_views.insert(number, known);
        Ok(known as u32)
    }

    /// Checks that `count` elements of `size` bytes from `offset` on lie inside the buffer view, and returns their
    /// bytes.
    fn check_range(
        &self,
        user: &Object<'_>,
        number: usize,
        (offset, count, size): (u64, usize, usize),
        strided: bool,
    ) -> Result<&'f [u8], Error> {
        let view = self.buffer_views.get(number)?;
        let stride = match view.stride {
            Some(_) if !strided => {
                return Err(bad(format!("bufferViews[{number}].byteStride"), "is not allowed for sparse accessors"));
            }
            Some(stride) if stride < size => {
                let what = format!("is {stride}, but {} has elements of {size} bytes", user.path());
                return Err(bad(format!("bufferViews[{number}].byteStride"), what));
            }
            Some(stride) => stride,
            None => size,
        };
        let last = (count as u64 - 1).checked_mul(stride as u64);
        let end = last.and_then(|last| last.checked_add(size as u64)?.checked_add(offset));
        let range = end.filter(|&end| end <= view.bytes.len() as u64).map(|end| offset as usize..end as usize);
        range.and_then(|range| view.bytes.get(range)).ok_or_else(|| {
            let have = view.bytes.len();
            let what = format!(
                "needs {count} elements of {size} bytes (stride {stride}) from byte {offset} on, \
                but bufferViews[{number}] has {have} bytes"
            );
            bad(user.path(), what)
        })
    }

    fn check_sparse(
        &mut self,
        sparse: &Object<'_>,
        length: usize,
        size: usize,
    ) -> Result<json::accessor::sparse::Sparse, Error> {
        let count = count(sparse)?;
        if count > length {
            return Err(bad(sparse.at("count"), format!("is {count}, but the accessor has {length} elements")));
        }
        let part = |key: &str| sparse.object(key)?.ok_or_else(|| sparse.missing(key));
        let view_of = |part: &Object<'_>| {
            let view = part.index("bufferView", "bufferViews", self.buffer_views.len())?;
            view.ok_or_else(|| part.missing("bufferView"))
        };
        let (indices, values) = (part("indices")?, part("values")?);
        let (index_view, value_view) = (view_of(&indices)?, view_of(&values)?);
        let index_offset = indices.unsigned("byteOffset")?.unwrap_or(0);
        let value_offset = values.unsigned("byteOffset")?.unwrap_or(0);
        let component = component_type(&indices)?;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(bad(indices.at("componentType"), "must be an unsigned integer type"));
        }
        let range = (index_offset, count, component.size());
        let bytes = self.check_range(&indices, index_view, range, false)?;
        self.check_range(&values, value_view, (value_offset, count, size), false)?;
        // The `gltf` crate requires increasing indices; otherwise it panics or skips values.
        let mut previous = None;
        for (k, bytes) in bytes.chunks_exact(component.size()).enumerate() {
            let index = bytes.iter().rev().fold(0_usize, |index, &byte| index << 8 | usize::from(byte));
            if index >= length || previous.is_some_and(|previous| index <= previous) {
                let what = format!("number {k} is {index}; they must increase and stay below the count {length}");
                return Err(bad(indices.path(), what));
            }
            previous = Some(index);
        }
        Ok(json::accessor::sparse::Sparse {
            count: USize64::from(count),
            indices: json::accessor::sparse::Indices {
                buffer_view: json::Index::new(self.view(index_view)?),
                byte_offset: USize64(index_offset),
                component_type: Checked::Valid(json::accessor::IndexComponentType(component)),
                extensions: None,
                extras: json::Extras::default(),
            },
            values: json::accessor::sparse::Values {
                buffer_view: json::Index::new(self.view(value_view)?),
                byte_offset: USize64(value_offset),
                extensions: None,
                extras: json::Extras::default(),
            },
            extensions: None,
            extras: json::Extras::default(),
        })
    }
}

fn component_type(object: &Object<'_>) -> Result<ComponentType, Error> {
    let code = object.unsigned("componentType")?.ok_or_else(|| object.missing("componentType"))?;
    Ok(match code {
        5120 => ComponentType::I8,
        5121 => ComponentType::U8,
        5122 => ComponentType::I16,
        5123 => ComponentType::U16,
        5125 => ComponentType::U32,
        5126 => ComponentType::F32,
        _ => return Err(bad(object.at("componentType"), format!("is {code}, which is no component type of glTF"))),
    })
}

fn shape(accessor: &Object<'_>) -> Result<Type, Error> {
    Ok(match accessor.string("type")?.ok_or_else(|| accessor.missing("type"))? {
        "SCALAR" => Type::Scalar,
        "VEC2" => Type::Vec2,
        "VEC3" => Type::Vec3,
        "VEC4" => Type::Vec4,
        "MAT2" => Type::Mat2,
        "MAT3" => Type::Mat3,
        "MAT4" => Type::Mat4,
        _ => return Err(bad(accessor.at("type"), "is no accessor type of glTF")),
    })
}

fn count(object: &Object<'_>) -> Result<usize, Error> {
    let count = object.unsigned("count")?.ok_or_else(|| object.missing("count"))?;
    // Vertex indices have 32 bits, and glTF reserves the largest one.
    if count == 0 || count >= u64::from(u32::MAX) {
        return Err(bad(object.at("count"), format!("is {count}; it must be 1..{}", u32::MAX - 1)));
    }
    Ok(count as usize)
}

fn check_use(
    accessor: &Object<'_>,
    wanted: Use,
    (component, shape, normalized): (ComponentType, Type, bool),
    user: &str,
) -> Result<(), Error> {
    use ComponentType::{F32, I8, I16, U8, U16, U32};
    let small = matches!(component, U8 | U16);
    let (fits, need) = match wanted {
        Use::Positions => (shape == Type::Vec3 && component != U32, "VEC3 of floats, bytes or shorts"),
        Use::Tangents | Use::Rotations => (
            shape == Type::Vec4 && (component == F32 || matches!(component, I8 | I16) && normalized),
            "VEC4 of floats or of normalized signed bytes or shorts",
        ),
        Use::Normals => (
            shape == Type::Vec3 && (component == F32 || matches!(component, I8 | I16) && normalized),
            "VEC3 of floats or of normalized signed bytes or shorts",
        ),
        Use::TextureCoordinates => (shape == Type::Vec2 && component != U32, "VEC2 of floats, bytes or shorts"),
        Use::Colors => (
            matches!(shape, Type::Vec3 | Type::Vec4) && (component == F32 || small && normalized),
            "VEC3 or VEC4 of floats or of normalized unsigned bytes or shorts",
        ),
        Use::Indices => (shape == Type::Scalar && (small || component == U32), "SCALAR of unsigned integers"),
        Use::Joints => (shape == Type::Vec4 && small, "VEC4 of unsigned bytes or shorts"),
        Use::Weights => (
            shape == Type::Vec4 && (component == F32 || small && normalized),
            "VEC4 of floats or of normalized unsigned bytes or shorts",
        ),
        Use::Matrices => (shape == Type::Mat4 && component == F32, "MAT4 of floats"),
        Use::Times => (shape == Type::Scalar && component == F32, "SCALAR of floats"),
        Use::Animated(wanted) => (
            shape == wanted
                && matches!(wanted, Type::Scalar | Type::Vec2 | Type::Vec3 | Type::Vec4)
                && component != U32,
            "of the shape of the property that it animates, of floats, bytes or shorts",
        ),
    };
    if fits { Ok(()) } else { Err(bad(accessor.path(), format!("must be {need}, since {user} refers to it"))) }
}
