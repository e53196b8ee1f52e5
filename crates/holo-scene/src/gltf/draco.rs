//! Draco-compressed primitives (`KHR_draco_mesh_compression`), decoded by the crate `draco-core`.
//!
//! A primitive has accessors as always, and they say what the Draco data must contain: as many vertices and triangles,
//! and for each attribute its type. So all limits are checked before anything is decoded.

use std::collections::BTreeMap;

use self::decoder::Geometry;
use super::accessors::Checker;
use super::handle::Handle;
use super::json::{Object, bad};
use crate::Error;

#[cfg(feature = "draco")]
mod decoder;
#[cfg(not(feature = "draco"))]
#[path = "draco/no_decoder.rs"]
mod decoder;

/// The Draco data of a primitive, before it is decoded.
pub(super) struct Stream<'f> {
    at: String,
    data: &'f [u8],
    /// The id in the data of each accessor that the data replaces.
    ids: BTreeMap<usize, u32>,
}

/// How many triangles the data must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Triangles {
    Exactly(usize),
    AtMost(usize),
}

/// The decoded data of a primitive.
pub(super) struct Decoded<'s> {
    stream: &'s Stream<'s>,
    geometry: Geometry,
}

impl<'f> Stream<'f> {
    /// The Draco data of a primitive with this extension object; `attributes` are those of the primitive. `None` if
    /// this crate was built without Draco and the accessors have data too.
    pub(super) fn new(
        extension: &Object<'_>,
        attributes: &Object<'_>,
        accessors: &Checker<'f>,
    ) -> Result<Option<Self>, Error> {
        let listed = extension.object("attributes")?.ok_or_else(|| extension.missing("attributes"))?;
        let (mut keys, mut ids) = (Vec::new(), BTreeMap::new());
        listed.each(|key, _| keys.push(key));
        for key in keys {
            let id = listed.unsigned(key)?.and_then(|id| u32::try_from(id).ok());
            let id = id.ok_or_else(|| bad(listed.at(key), "must be an integer of 32 bits"))?;
            if let Some(accessor) = attributes.index(key, "accessors", accessors.len())? {
                ids.insert(accessor, id);
            }
        }
        if cfg!(not(feature = "draco")) && ids.keys().all(|&accessor| accessors.has_data(accessor)) {
            return Ok(None);
        }
        let data = accessors.buffer_view(extension)?;
        Ok(Some(Self { at: extension.path().to_owned(), data, ids }))
    }

    /// Decodes the data, which must have so many vertices and triangles.
    pub(super) fn decode(&self, vertices: usize, triangles: Triangles) -> Result<Decoded<'_>, Error> {
        let (Triangles::Exactly(most) | Triangles::AtMost(most)) = triangles;
        let geometry = decoder::decode(&self.at, self.data, vertices, most)?;
        let (points, faces) = geometry.size();
        if points != vertices || faces > most || triangles == Triangles::Exactly(most) && faces != most {
            let what = format!(
                "the data has {points} vertices and {faces} triangles, \
                 the accessors of the primitive have {vertices} and {most}"
            );
            return Err(bad(&self.at, what));
        }
        Ok(Decoded { stream: self, geometry })
    }
}

impl Decoded<'_> {
    pub(super) fn triangles(&self) -> Result<Vec<[u32; 3]>, Error> {
        let (_, number) = self.geometry.size();
        let mut triangles = Vec::new();
        let what = || bad(&self.stream.at, format!("{number} triangles do not fit into memory"));
        triangles.try_reserve_exact(number).map_err(|_| what())?;
        triangles.extend(self.geometry.triangles());
        Ok(triangles)
    }

    /// The numbers of an attribute as they were encoded, `components` for each vertex; integers are not scaled. The
    /// accessor says how many there are, and whether they are floats. `None` if the data does not contain the
    /// attribute, so that its accessor is read.
    pub(super) fn numbers(
        &self,
        handle: Handle,
        components: usize,
        are_floats: bool,
    ) -> Result<Option<Vec<f32>>, Error> {
        let Some(&id) = self.stream.ids.get(&handle.number) else { return Ok(None) };
        let numbers = self.geometry.attribute(id, components, are_floats);
        numbers.map(Some).ok_or_else(|| {
            let number = handle.number;
            bad(&self.stream.at, format!("the data has no attribute {id} with the type of accessors[{number}]"))
        })
    }
}
