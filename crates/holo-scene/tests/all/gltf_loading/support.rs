//! Builds glTF files by hand: JSON plus a binary chunk.

use holo_scene::Error;
use holo_scene::gltf::{Limits, Loaded, load_slice};
use serde_json::{Value, json};

/// A file under construction.
pub struct File {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl File {
    pub fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), binary: Vec::new() }
    }

    /// Appends to a top-level list and returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Appends bytes as a buffer view, aligned to four.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// An accessor with its own buffer view.
    pub fn accessor(&mut self, bytes: &[u8], component: u32, shape: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": shape });
        self.push("accessors", accessor)
    }

    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1], values.len())
    }

    pub fn indices_u16(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, "SCALAR", values.len())
    }

    /// A mesh of one primitive, and a node with it.
    pub fn show(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({ "primitives": [primitive] }));
        self.push("nodes", json!({ "mesh": mesh }))
    }

    pub fn glb(&self) -> Vec<u8> {
        glb(&serde_json::to_vec(&self.json).unwrap(), &self.binary)
    }

    pub fn load(&self) -> Result<Loaded, Error> {
        load_slice(&self.glb(), &Limits::default())
    }

    /// The message of the error of loading.
    pub fn error(&self) -> String {
        match self.load() {
            Ok(_) => panic!("loaded, although it should not: {}", self.json),
            Err(error) => error.to_string(),
        }
    }
}

/// Puts JSON text and a binary chunk into a container.
pub fn glb(text: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut text = text.to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + text.len() + if binary.is_empty() { 0 } else { 8 + binary.len() };
    let mut bytes = Vec::from(*b"glTF\x02\0\0\0");
    bytes.extend_from_slice(&(total as u32).to_le_bytes());
    bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
    bytes.extend_from_slice(b"JSON");
    bytes.extend_from_slice(&text);
    if !binary.is_empty() {
        bytes.extend_from_slice(&(binary.len() as u32).to_le_bytes());
        bytes.extend_from_slice(b"BIN\0");
        bytes.extend_from_slice(&binary);
    }
    bytes
}

pub const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// One triangle with a node.
pub fn triangle() -> File {
    let mut file = File::new();
    let positions = file.floats(&TRIANGLE);
    file.show(json!({ "attributes": { "POSITION": positions } }));
    file
}

pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0_u32, |bits, k| bits << 8 | u32::from(group.get(k).copied().unwrap_or(0)));
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= group.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

/// A PNG of 8-bit RGBA texels.
pub fn png(width: u32, height: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let texture = image::RgbaImage::from_raw(width, height, texels.as_flattened().to_vec()).unwrap();
    texture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Asserts that a message contains all of some words.
#[track_caller]
pub fn assert_contains(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "'{message}' does not contain '{word}'");
    }
}
