//! Files that are not glTF 2.0: what they are, by content, and how to get a `.glb` from them.

use image::ImageFormat;

use super::json::bad;
use crate::Error;

/// How many bytes of a file are searched for words.
const SEARCHED: usize = 4096;

const IMPORT: &str = "Import it into Blender, then File > Export > glTF 2.0 (.glb).";
const OPEN: &str = "Open it in Blender, then File > Export > glTF 2.0 (.glb).";
/// The cure for files of glTF 1.0.
const UPGRADE: &str = "Convert it: npx gltf-pipeline -i old.gltf -o new.glb";

/// First bytes of formats, their names, and what to do.
const STARTS: &[(&[u8], &str, &str)] = &[
    (b"version https://git-lfs", "a pointer of Git LFS instead of the file itself", "Fetch the file: git lfs pull"),
    (b"BLENDER", "a Blender file (.blend)", OPEN),
    (b"\x28\xB5\x2F\xFD", "compressed with Zstandard, probably a Blender file (.blend)", OPEN),
    (b"\x1F\x8B", "compressed with gzip: an old Blender file (.blend), or a file to unpack with gunzip", OPEN),
    (b"PXR-USDC", "a USD file (.usd, .usdc)", IMPORT),
    (b"#usda", "a USD file (.usda)", IMPORT),
    (b"Kaydara FBX Binary", "an FBX file (.fbx)", IMPORT),
    (b"; FBX", "an FBX file in text form (.fbx)", "Convert it to binary FBX (FBX Converter of Autodesk) or to glTF."),
    (b"ply\n", "a PLY file (.ply)", IMPORT),
    (b"ply\r", "a PLY file (.ply)", IMPORT),
    (b"ISO-10303-21", "a STEP file (.step)", "Export a mesh from a CAD program (FreeCAD writes .glb)."),
    (b"%PDF", "a PDF file", "Give a .glb or .gltf file."),
];

/// The error for a file that is neither binary glTF nor JSON.
pub(super) fn error(bytes: &[u8]) -> Error {
    match recognize(bytes) {
        Some((kind, cure)) => bad("file", format!("is {kind}, not glTF.\n{cure}")),
        None => bad("file", "is neither binary glTF (.glb) nor glTF JSON (.gltf)"),
    }
}

/// The error for a file of glTF 1.
pub(super) fn old_gltf(at: &str) -> Error {
    bad(at, format!("is of glTF version 1; version 2 is read.\n{UPGRADE}"))
}

fn recognize(bytes: &[u8]) -> Option<(String, &'static str)> {
    let named = |kind: &str, cure| Some((kind.to_owned(), cure));
    if bytes.starts_with(b"PK\x03\x04") {
        return Some(archive(bytes));
    }
    if let Some(&(_, kind, cure)) = STARTS.iter().find(|(start, ..)| bytes.starts_with(start)) {
        return named(kind, cure);
    }
    if let Ok(format) = image::guess_format(bytes) {
        return Some((image_kind(format), "Give the .glb or .gltf file that uses it."));
    }
    if is_binary_stl(bytes) {
        return named("an STL file (.stl)", IMPORT);
    }
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(SEARCHED)]);
    let has = |word: &str| text.contains(word);
    let start = text.trim_start().to_ascii_lowercase();
    if start.starts_with("<!doctype html") || start.starts_with("<html") {
        return named("an HTML page, probably of a download that failed", "Download the .glb or .gltf file itself.");
    }
    if has("<COLLADA") {
        return named(
            "a COLLADA file (.dae)",
            "Import it into Blender 4.5 or older, then File > Export > glTF 2.0 (.glb).",
        );
    }
    if has("<X3D") || start.starts_with("#vrml") {
        return named(
            "an X3D or VRML file",
            "Import it into Blender (extension Web3D X3D/VRML2), then export glTF 2.0 (.glb).",
        );
    }
    if start.starts_with("solid") && has("facet") {
        return named("an STL file (.stl)", IMPORT);
    }
    if start.starts_with('<') {
        return named("an XML file", "Give a .glb or .gltf file.");
    }
    is_obj(&text).then(|| ("a Wavefront OBJ file (.obj)".to_owned(), IMPORT))
}

/// A ZIP archive; that of a USDZ file starts with its USD file.
fn archive(bytes: &[u8]) -> (String, &'static str) {
    let length = bytes.get(26..28).and_then(|b| b.first_chunk()).map_or(0, |b| usize::from(u16::from_le_bytes(*b)));
    let name = bytes.get(30..).unwrap_or_default();
    let name = String::from_utf8_lossy(&name[..name.len().min(length)]).to_ascii_lowercase();
    if [".usd", ".usda", ".usdc"].iter().any(|end| name.ends_with(end)) {
        ("a USD package (.usdz)".to_owned(), IMPORT)
    } else {
        ("a ZIP archive".to_owned(), "Unpack it and give the .glb or .gltf file in it.")
    }
}

fn image_kind(format: ImageFormat) -> String {
    format!("an image ({})", format.extensions_str().first().unwrap_or(&"of unknown format"))
}

/// 80 bytes of any content, the number of triangles, and 50 bytes for each of them.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let Some(count) = bytes.get(80..84).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b)) else {
        return false;
    };
    count > 0 && bytes.len() as u64 == 84 + 50 * u64::from(count)
}

/// Whether the first statement is one of OBJ: a word and, for vertices and faces, numbers.
fn is_obj(text: &str) -> bool {
    let statement = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    let mut words = statement.unwrap_or_default().split_ascii_whitespace();
    match words.next() {
        Some("mtllib" | "usemtl" | "o" | "g" | "s") => words.next().is_some(),
        Some("v" | "vn" | "vt") => words.clone().count() >= 2 && words.all(|word| word.parse::<f64>().is_ok()),
        _ => false,
    }
}
