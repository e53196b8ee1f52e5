//! The container of a glTF file: binary or JSON, and the bytes of its buffers and images.

use std::borrow::Cow;
use std::cell::Cell;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::foreign;
use super::json::{Object, bad, unsupported};
use super::meshopt;
use super::uri::{self, Target};
use crate::Error;

const MAGIC: &[u8] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BINARY: u32 = 0x004E_4942;

/// The JSON text and the binary chunk of a file in memory.
pub(super) struct Parts<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a file into JSON and binary chunk. Binary glTF is detected by its first bytes.
pub(super) fn split(bytes: &[u8]) -> Result<Parts<'_>, Error> {
    if !bytes.starts_with(MAGIC) {
        // The specification forbids a byte order mark; editors add one nevertheless.
        let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        return match json.iter().find(|b| !b.is_ascii_whitespace()) {
            Some(b'{') => Ok(Parts { json, binary: None }),
            Some(_) => Err(foreign::error(bytes)),
            None => Err(bad("file", "is empty")),
        };
    }
    let truncated = || bad("glb header", "the file is cut short");
    match word(bytes, 4).ok_or_else(truncated)? {
        2 => {}
        1 => return Err(foreign::old_gltf("glb header")),
        version => {
            return Err(unsupported("glb header", format!("glTF container version {version} (convert the file to 2)")));
        }
    }
    let length = word(bytes, 8).ok_or_else(truncated)? as usize;
    let Some(bytes) = bytes.get(..length) else {
        let what = format!("says {length} bytes, but the file has {}: it is cut short", bytes.len());
        return Err(bad("glb header", what));
    };
    let mut parts = Parts { json: &[], binary: None };
    let (mut offset, mut number) = (12_usize, 0_usize);
    // Up to three bytes may remain if a writer padded the file but not its last chunk.
    while offset + 8 <= bytes.len() {
        let (Some(length), Some(kind)) = (word(bytes, offset), word(bytes, offset + 4)) else { break };
        let chunk = bytes[offset + 8..].get(..length as usize);
        let chunk = chunk.ok_or_else(|| bad(format!("glb chunk {number}"), "reaches beyond the end of the file"))?;
        match (number, kind) {
            // Padding consists of spaces; some writers use zeros.
            (0, CHUNK_JSON) => parts.json = trim_zeros(chunk),
            (0, _) => return Err(bad("glb chunk 0", "is not JSON")),
            (1, CHUNK_BINARY) => parts.binary = Some(chunk),
            // Other chunks belong to extensions and must be ignored.
            _ => {}
        }
        offset = next_chunk(bytes, offset + 8 + chunk.len());
        number += 1;
    }
    if number == 0 { Err(bad("glb chunk 0", "is missing: the file has no JSON")) } else { Ok(parts) }
}

/// Where the chunk after one that ends at `end` starts: at a multiple of four, unless the length of a chunk is none and
/// the next one follows at once, as some writers do.
fn next_chunk(bytes: &[u8], end: usize) -> usize {
    let aligned = end.next_multiple_of(4);
    let starts = |at: usize| {
        let fits =
            word(bytes, at).is_some_and(|length| bytes.len() - at >= 8 && bytes.len() - at - 8 >= length as usize);
        fits && word(bytes, at + 4) == Some(CHUNK_BINARY)
    };
    if starts(end) && !starts(aligned) { end } else { aligned }
}

fn trim_zeros(mut json: &[u8]) -> &[u8] {
    while let [rest @ .., 0] = json {
        json = rest;
    }
    json
}

fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    bytes.get(offset..)?.first_chunk().copied().map(u32::from_le_bytes)
}

/// Parses the JSON and checks the glTF version.
pub(super) fn parse(json: &[u8]) -> Result<Value, Error> {
    let value: Value = serde_json::from_slice(json).map_err(|e| bad("glTF JSON", e.to_string()))?;
    let root = Object::root(&value)?;
    // Version 1 has objects by name where version 2 has lists, and needs no asset.
    let by_name = ["nodes", "meshes", "accessors"].iter().any(|key| value.get(key).is_some_and(Value::is_object));
    let asset = match root.object("asset")? {
        Some(asset) => asset,
        None if by_name => return Err(foreign::old_gltf("glTF JSON")),
        None => return Err(root.missing("asset")),
    };
    // Some exporters wrote the version 1 as a number.
    if asset.number("version").is_ok_and(|version| version.is_some_and(|version| version < 2.0)) {
        return Err(foreign::old_gltf("asset.version"));
    }
    let Some(version) = asset.string("version")? else {
        return Err(if by_name { foreign::old_gltf("glTF JSON") } else { asset.missing("version") });
    };
    if version.split('.').next() == Some("1") {
        return Err(foreign::old_gltf("asset.version"));
    }
    if version.split('.').next() != Some("2") {
        return Err(unsupported("asset.version", format!("glTF {} (convert the file to 2.0)", uri::shorten(version))));
    }
    match asset.string("minVersion")? {
        Some(least) if least != "2.0" => Err(unsupported("asset.minVersion", format!("glTF {}", uri::shorten(least)))),
        _ => Ok(value),
    }
}

/// Access to external files, with the remaining number of bytes that may be read.
pub(super) struct Files {
    folder: Option<PathBuf>,
    bytes_left: Cell<u64>,
    max_bytes: u64,
}

impl Files {
    pub(super) fn new(folder: Option<&Path>, max_bytes: u64) -> Self {
        Self { folder: folder.map(Path::to_path_buf), bytes_left: Cell::new(max_bytes), max_bytes }
    }

    /// Reads a whole file.
    ///
    /// # Errors
    /// [`Error::Read`] for a file that cannot be read, [`Error::BadFile`] for one above the remaining limit.
    pub(super) fn read(&self, path: &Path) -> Result<Vec<u8>, Error> {
        let fail = |error| Error::Read { path: path.display().to_string(), error };
        // Opening a pipe would block, so the type of the file is checked first.
        let size = path.metadata().map_err(fail)?;
        if !size.is_file() {
            return Err(fail(std::io::Error::other("is not a file")));
        }
        let left = self.bytes_left.get();
        let too_large = || {
            let what = format!("makes the scene larger than the limit of {} bytes in files", self.max_bytes);
            bad(path.display().to_string(), what)
        };
        if size.len() > left {
            return Err(too_large());
        }
        let file = File::open(path).map_err(fail)?;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(usize::try_from(size.len()).map_err(|_| too_large())?).map_err(|_| too_large())?;
        // The file may grow while it is read.
        file.take(left).read_to_end(&mut bytes).map_err(fail)?;
        self.bytes_left.set(left - bytes.len() as u64);
        Ok(bytes)
    }

    /// The bytes behind a URI; `at` is its JSON path.
    pub(super) fn fetch(&self, uri: &str, at: &str) -> Result<Vec<u8>, Error> {
        match uri::resolve(uri, at)? {
            Target::Data(bytes) => Ok(bytes),
            Target::File(path) => self.read(&self.locate(&path, at)?),
        }
    }

    /// The path of an external file, from that in a URI.
    pub(super) fn locate(&self, path: &Path, at: &str) -> Result<PathBuf, Error> {
        let shown = || uri::shorten(&path.display().to_string());
        let Some(folder) = &self.folder else {
            return Err(bad(at, format!("refers to the file '{}'; load the scene from its path", shown())));
        };
        let found = folder.join(path);
        // The text of the path stays in the folder, but links may lead anywhere. What does not exist has the error of
        // reading it.
        let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder.as_path() };
        if let (Ok(root), Ok(real)) = (root.canonicalize(), found.canonicalize())
            && !real.starts_with(root)
        {
            let what = format!(
                "the file '{}' is a link that leads out of the folder of the glTF file; copy the file below that folder",
                shown()
            );
            return Err(bad(at, what));
        }
        Ok(found)
    }
}

/// The bytes of all buffers, each at least as long as it says. Buffers that only hold uncompressed copies of compressed
/// buffer views are empty: they are not read, and often have no bytes.
pub(super) fn buffers<'a>(
    root: &Object<'_>,
    binary: Option<&'a [u8]>,
    files: &Files,
) -> Result<Vec<Cow<'a, [u8]>>, Error> {
    let list = root.objects("buffers")?;
    let fallbacks = meshopt::fallbacks(root, list.len())?;
    let mut buffers = Vec::new();
    for (k, buffer) in list.into_iter().enumerate() {
        let length = buffer.unsigned("byteLength")?.ok_or_else(|| buffer.missing("byteLength"))?;
        if fallbacks[k] || !buffer.has("uri") && meshopt::extension(&buffer)?.is_some() {
            buffers.push(Cow::Borrowed(&[][..]));
            continue;
        }
        let bytes: Cow<'a, [u8]> = match (buffer.string("uri")?, binary) {
            (Some(uri), _) => Cow::Owned(files.fetch(uri, &buffer.at("uri"))?),
            (None, Some(binary)) if k == 0 => Cow::Borrowed(binary),
            (None, _) if k == 0 => return Err(bad(buffer.path(), "has no uri, and the file no binary chunk")),
            (None, _) => return Err(buffer.missing("uri")),
        };
        if length > bytes.len() as u64 {
            let what = format!("says {length} bytes, but there are only {}", bytes.len());
            return Err(bad(buffer.at("byteLength"), what));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}
