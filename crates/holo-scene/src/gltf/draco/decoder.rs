//! The decoder, with limits.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};

use crate::Error;
use crate::gltf::extensions::DECOMPRESS;
use crate::gltf::json::bad;

/// Bytes of all attributes of a vertex, at most; the attributes of glTF have about a hundred.
const MAX_VERTEX_BYTES: u64 = 1024;

/// Decoded triangles and attributes.
pub(super) struct Geometry(Mesh);

/// Decodes `data`; it is an error if there are more vertices or triangles than this.
pub(super) fn decode(at: &str, data: &[u8], vertices: usize, triangles: usize) -> Result<Geometry, Error> {
    let limits = DecodeLimits::default()
        .with_max_points(vertices as u64)
        .with_max_faces(triangles as u64)
        .with_max_decoded_bytes(MAX_VERTEX_BYTES.saturating_mul(vertices as u64));
    let mut mesh = Mesh::new();
    let status = MeshDecoder::new().decode(&mut DecoderBuffer::new(data).with_limits(limits), &mut mesh);
    status.map_err(|why| {
        let what = format!(
            "the data cannot be decoded to the {vertices} vertices and {triangles} triangles of its accessors ({why}); \
             export the file again, or try {DECOMPRESS}"
        );
        bad(at, what)
    })?;
    Ok(Geometry(mesh))
}

impl Geometry {
    /// The numbers of vertices and triangles.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.0.num_points(), self.0.num_faces())
    }

    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.0.faces().iter().map(|face| face.map(|point| point.0))
    }

    /// An attribute, `components` numbers a vertex; `None` if there is none with so many. Only if `are_floats`, numbers
    /// may be floats, otherwise they are integers.
    pub(super) fn attribute(&self, id: u32, components: usize, are_floats: bool) -> Option<Vec<f32>> {
        let attribute = self.0.attribute_by_unique_id(id)?;
        let type_fits = are_floats || attribute.data_type() != DataType::Float32;
        let fits = type_fits && usize::from(attribute.num_components()) == components;
        fits.then(|| attribute.read_f32s(self.0.num_points(), components))
    }
}
