//! The format of a file, from its contents.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::Error;
use crate::files::dng_header::is_dng;
use crate::files::names;

/// A file format that `holo` detects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FileFormat {
    /// A PNG image.
    Png,
    /// A TIFF image; `read_tiff_info` reads its size and samples.
    Tiff,
    /// A DNG, which is a TIFF with the codes of an image sensor; `read_dng_info` reads its size and color filter.
    Dng,
    /// A PFM float image, gray or color.
    Pfm,
    /// An SGI image (`.rgb`).
    Sgi,
    /// The description of a light field of Stanford's LightPack (`.lid`).
    LightPack,
    /// A container of a Lytro camera, `.lfp` or `.lfr`; see [`LytroImage`](crate::interop::LytroImage).
    Lytro,
    /// An OpenEXR image; `read_exr_info` reads its size and channels.
    Exr,
    /// A Radiance HDR image; `read_hdr_info` reads its size.
    Hdr,
    /// A MAT file of version 5; `read_mat_info` lists its variables.
    Mat5,
    /// A MAT file of version 7.3: an HDF5 file with a MATLAB header in front.
    Mat73,
    /// An HDF5 file.
    Hdf5,
    /// A glTF scene in one binary file (`.glb`).
    GltfBinary,
    /// A glTF scene as JSON (`.gltf`).
    GltfJson,
    /// Camera parameters with the keys of the HCI benchmark.
    ParametersCfg,
    /// The manifest of a dataset folder.
    Manifest,
    /// Another format.
    Unknown,
}

/// Number of bytes of a text file that are searched for the sections of a `parameters.cfg`.
const HEAD_BYTES: u64 = 64 << 10;

/// Maximum number of bytes of JSON that are parsed.
const MAX_JSON_BYTES: u64 = 1 << 30;

/// Detects the format of a file from its contents; the name of the file does not matter.
///
/// A file of a known format may still be damaged: only what distinguishes the formats is read, up to 64 KiB, of a TIFF
/// also its first directory, and of JSON the keys of the top level.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read. An unknown format is [`FileFormat::Unknown`], not an error.
pub fn detect_format(path: impl AsRef<Path>) -> Result<FileFormat, Error> {
    let path = path.as_ref();
    let failed = |source| Error::io("read", path, source);
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(failed(std::io::ErrorKind::IsADirectory.into()));
    }
    let mut source = BufReader::with_capacity(HEAD_BYTES as usize, file);
    let mut head = Vec::new();
    source.by_ref().take(HEAD_BYTES).read_to_end(&mut head).map_err(failed)?;
    let format = match head.as_slice() {
        [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => FileFormat::Png,
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => {
            if is_dng(&mut source) {
                FileFormat::Dng
            } else {
                FileFormat::Tiff
            }
        }
        [0x89, b'L', b'F', b'P', b'\r', b'\n', 0x1a, b'\n', ..] => FileFormat::Lytro,
        [b'P', b'f' | b'F', space, ..] if space.is_ascii_whitespace() => FileFormat::Pfm,
        [0x76, 0x2f, 0x31, 0x01, ..] => FileFormat::Exr,
        // Verbatim or run-length coded, of 1 or 2 bytes.
        [0x01, 0xda, 0 | 1, 1 | 2, ..] => FileFormat::Sgi,
        text if [&b"#?RADIANCE"[..], b"#?RGBE"].iter().any(|signature| text.starts_with(signature)) => FileFormat::Hdr,
        [0x89, b'H', b'D', b'F', b'\r', b'\n', 0x1a, b'\n', ..] => FileFormat::Hdf5,
        [b'M', b'A', b'T', b'L', b'A', b'B', b' ', ..] if is_mat(&head, 0x01) => FileFormat::Mat5,
        [b'M', b'A', b'T', b'L', b'A', b'B', b' ', ..] if is_mat(&head, 0x02) => FileFormat::Mat73,
        // HDF5 behind a user block of any other kind.
        bytes if hdf5_behind_block(bytes) => FileFormat::Hdf5,
        [b'g', b'l', b'T', b'F', ..] => FileFormat::GltfBinary,
        text if first_character(text) == Some(b'{') => {
            source.rewind().map_err(failed)?;
            json_format(source)
        }
        text if has_sections(text) => FileFormat::ParametersCfg,
        text if has_slab(text) => FileFormat::LightPack,
        _ => FileFormat::Unknown,
    };
    Ok(format)
}

/// Whether the first bytes are the header of a MAT file of this version, in either byte order.
fn is_mat(head: &[u8], version: u8) -> bool {
    matches!(head.get(124..128), Some(&[0, major, b'I', b'M'] | &[major, 0, b'M', b'I']) if major == version)
}

/// Whether the signature of HDF5 follows a user block of 512, 1024, 2048 ... bytes.
fn hdf5_behind_block(head: &[u8]) -> bool {
    let starts = std::iter::successors(Some(512_usize), |start| start.checked_mul(2));
    let mut rests = starts.map_while(|start| head.get(start..));
    rests.any(|rest| rest.starts_with(b"\x89HDF\r\n\x1a\n"))
}

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

fn first_character(text: &[u8]) -> Option<u8> {
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    text.iter().copied().find(|byte| !byte.is_ascii_whitespace())
}

/// Whether a text has the two sections of `parameters.cfg` that specify the rig.
fn has_sections(text: &[u8]) -> bool {
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    let has =
        |section: &[u8]| text.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| line.trim_ascii() == section);
    has(b"[intrinsics]") && has(b"[extrinsics]")
}

/// Whether a line of a text begins with the word for the plane of cameras.
fn has_slab(text: &[u8]) -> bool {
    text.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| line.trim_ascii_start().starts_with(b"SLAB_UV"))
}

/// The format of a JSON file from its top-level keys `format` and `asset`, wherever in the file they are.
fn json_format(mut source: impl BufRead) -> FileFormat {
    #[derive(Deserialize)]
    struct TopLevel {
        format: Option<Text>,
        asset: Option<IgnoredAny>,
    }
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Text {
        Text(String),
        Other(IgnoredAny),
    }
    if source.fill_buf().is_ok_and(|head| head.starts_with(BYTE_ORDER_MARK)) {
        source.consume(BYTE_ORDER_MARK.len());
    }
    match serde_json::from_reader(source.take(MAX_JSON_BYTES)) {
        Ok(TopLevel { format: Some(Text::Text(format)), .. }) if format.starts_with(names::FORMAT_FAMILY) => {
            FileFormat::Manifest
        }
        Ok(TopLevel { asset: Some(_), .. }) => FileFormat::GltfJson,
        _ => FileFormat::Unknown,
    }
}
