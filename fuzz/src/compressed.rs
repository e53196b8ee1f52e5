//! Compressed geometry: a small glTF around any bytes, so that the input goes to the decoder. The first bytes of the
//! input are the description of the rest.

use crate::gltf::gltf;

/// Draco: two bytes for the vertices that the accessors declare, two for the triangles, then the data.
///
/// # Panics
/// As [`gltf`].
pub fn draco(data: &[u8]) {
    if let Some(file) = draco_file(data) {
        gltf(&file);
    }
}

fn draco_file(data: &[u8]) -> Option<Vec<u8>> {
    let (&[a, b, c, d], stream) = data.split_first_chunk()?;
    let (vertices, triangles) = (u32::from(u16::from_le_bytes([a, b])), u32::from(u16::from_le_bytes([c, d])));
    let accessor = |kind: &str| format!(r#"{{"componentType":5126,"count":{vertices},"type":"{kind}"}}"#);
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{length}}}],
        "bufferViews":[{{"buffer":0,"byteLength":{length}}}],"accessors":[{vec3},{vec3},{vec2},
        {{"componentType":5125,"count":{indices},"type":"SCALAR"}}],"meshes":[{{"primitives":[{{"indices":3,
        "attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},
        "extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,
        "attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}}}}}}}}]}}],"nodes":[{{"mesh":0}}]}}"#,
        length = stream.len(),
        vec3 = accessor("VEC3"),
        vec2 = accessor("VEC2"),
        indices = 3 * triangles,
    );
    Some(glb(&text, stream))
}

/// meshopt: a byte for mode and filter, one for the bytes of an element, two for the number of elements, then the data.
///
/// # Panics
/// As [`gltf`].
pub fn meshopt(data: &[u8]) {
    if let Some(file) = meshopt_file(data) {
        gltf(&file);
    }
}

fn meshopt_file(data: &[u8]) -> Option<Vec<u8>> {
    const FILTERS: [&str; 5] = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"];
    let (&[kind, stride, a, b], stream) = data.split_first_chunk()?;
    let count = u32::from(u16::from_le_bytes([a, b]));
    let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(kind) / FILTERS.len() % 3];
    let filter = FILTERS[usize::from(kind) % FILTERS.len()];
    // 0 is 256.
    let stride = (u32::from(stride) + 255) % 256 + 1;
    let bytes = stride * count;
    // The elements are colors, which may be anything, or indices.
    let (attributes, indices) =
        if mode == "ATTRIBUTES" { (r#""POSITION":1,"COLOR_0":0"#, "") } else { (r#""POSITION":1"#, r#","indices":0"#) };
    let (component, shape) = match (mode, stride) {
        ("ATTRIBUTES", _) => (r#"5121,"normalized":true"#, "VEC4"),
        (_, 2) => ("5123", "SCALAR"),
        _ => ("5125", "SCALAR"),
    };
    let vertices = if mode == "ATTRIBUTES" { count } else { 1 << 15 };
    // More than 252 is possible only where the buffer view has no stride.
    let has_stride = mode == "ATTRIBUTES" && stride <= 252;
    let view_stride = if has_stride { format!(r#","byteStride":{stride}"#) } else { String::new() };
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{length}}},{{"byteLength":{bytes}}}],
        "bufferViews":[{{"buffer":1,"byteLength":{bytes}{view_stride},"extensions":{{"KHR_meshopt_compression":{{
        "buffer":0,"byteLength":{length},"byteStride":{stride},"count":{count},"mode":"{mode}","filter":"{filter}"}}}}}}],
        "accessors":[{{"bufferView":0,"componentType":{component},"count":{count},"type":"{shape}"}},
        {{"componentType":5126,"count":{vertices},"type":"VEC3"}}],
        "meshes":[{{"primitives":[{{"attributes":{{{attributes}}}{indices}}}]}}],"nodes":[{{"mesh":0}}]}}"#,
        length = stream.len(),
    );
    Some(glb(&text, stream))
}

/// A binary glTF file.
fn glb(text: &str, binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (text, binary) = (padded(text.as_bytes(), b' '), padded(binary, 0));
    let word = |number: usize| (number as u32).to_le_bytes();
    let head = [&b"glTF\x02\0\0\0"[..], &word(28 + text.len() + binary.len()), &word(text.len()), b"JSON"].concat();
    [&head[..], &text, &word(binary.len()), b"BIN\0", &binary].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Otherwise the targets would test the checks before the decoders alone.
    #[test]
    fn the_corpora_load() {
        for (target, wrap) in [("draco", draco_file as fn(&[u8]) -> Option<Vec<u8>>), ("meshopt", meshopt_file)] {
            let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
            for entry in std::fs::read_dir(folder).expect("the corpus is part of the project") {
                let path = entry.expect("a readable folder").path();
                let file = wrap(&std::fs::read(&path).expect("a readable file")).expect("it has a description");
                let loaded = holo_scene::gltf::load_slice(&file, &Default::default());
                let meshes = loaded.map(|loaded| loaded.scene.meshes.len()).map_err(|error| error.to_string());
                assert_eq!(meshes, Ok(1), "{}", path.display());
            }
        }
    }
}
