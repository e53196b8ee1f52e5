//! Compressed buffer views: `EXT_meshopt_compression` and its successor `KHR_meshopt_compression`.
//!
//! The decoder follows the text of the extensions (Khronos; appendix A the bit streams, appendix B the filters). The
//! two differ in the second version of attributes and the filter COLOR; both are accepted in both, as other loaders do.
//! Vertex data and indices are exact; filters round as the text says.

mod attributes;
mod filters;
mod indices;

use std::borrow::Cow;

use self::filters::Filter;
use super::extensions::{MESHOPT, MESHOPT_KHR};
use super::json::{Object, bad, unsupported};
use crate::Error;

/// What is wrong with compressed data.
type Damage = &'static str;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// Compressed data with its description.
pub(super) struct Compressed<'f> {
    at: String,
    data: &'f [u8],
    stride: usize,
    count: usize,
    mode: Mode,
    filter: Filter,
}

/// The extension object of a buffer view or a buffer, if it has one.
pub(super) fn extension<'f>(object: &Object<'f>) -> Result<Option<Object<'f>>, Error> {
    match object.extension(MESHOPT_KHR)? {
        Some(extension) => Ok(Some(extension)),
        None => object.extension(MESHOPT),
    }
}

/// The buffers that only hold uncompressed copies of compressed buffer views; they need not exist.
pub(super) fn fallbacks(root: &Object<'_>, count: usize) -> Result<Vec<bool>, Error> {
    let (mut copies, mut needed) = (vec![false; count], vec![false; count]);
    for view in root.objects("bufferViews")? {
        // Wrong indices are reported when the buffer view is used.
        let buffer = |object: &Object<'_>| object.index("buffer", "buffers", count).ok().flatten();
        let compressed = extension(&view)?;
        if let Some(buffer) = buffer(&view) {
            let list = if compressed.is_some() { &mut copies } else { &mut needed };
            list[buffer] = true;
        }
        if let Some(buffer) = compressed.as_ref().and_then(buffer) {
            needed[buffer] = true;
        }
    }
    Ok(copies.into_iter().zip(needed).map(|(is_copy, is_needed)| is_copy && !is_needed).collect())
}

impl<'f> Compressed<'f> {
    /// Validates the description in `extension`, that of the buffer view `view`.
    pub(super) fn new(view: &Object<'_>, extension: &Object<'_>, buffers: &'f [Cow<'_, [u8]>]) -> Result<Self, Error> {
        let number = |key: &str| extension.unsigned(key)?.ok_or_else(|| extension.missing(key));
        let buffer = extension.index("buffer", "buffers", buffers.len())?.ok_or_else(|| extension.missing("buffer"))?;
        let (stride, count, length) = (number("byteStride")?, number("count")?, number("byteLength")?);
        let offset = extension.unsigned("byteOffset")?.unwrap_or(0);
        let bytes: &[u8] = &buffers[buffer];
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        let range = end.map(|end| offset as usize..end as usize);
        let data = range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            let have = bytes.len();
            let what = format!("needs {length} bytes from byte {offset} on, but buffers[{buffer}] has {have}");
            bad(extension.path(), what)
        })?;

        let name = extension.string("mode")?.ok_or_else(|| extension.missing("mode"))?;
        let mode = match name {
            "ATTRIBUTES" => Mode::Attributes,
            "TRIANGLES" => Mode::Triangles,
            "INDICES" => Mode::Indices,
            _ => return Err(unknown(extension, "mode")),
        };
        let filter = Filter::new(extension.string("filter")?.unwrap_or("NONE"));
        let filter = filter.ok_or_else(|| unknown(extension, "filter"))?;
        let fits = match mode {
            Mode::Attributes => stride.is_multiple_of(4) && (4..=256).contains(&stride) && filter.fits(stride as usize),
            Mode::Triangles | Mode::Indices => (stride == 2 || stride == 4) && filter == Filter::None,
        };
        if !fits {
            let what = format!("is {stride}, which is not possible for mode {name} and filter {filter:?}");
            return Err(bad(extension.at("byteStride"), what));
        }
        if mode == Mode::Triangles && !count.is_multiple_of(3) {
            return Err(bad(extension.at("count"), format!("is {count}; indices of triangles come in threes")));
        }
        let total = view.unsigned("byteLength")?.ok_or_else(|| view.missing("byteLength"))?;
        if stride.checked_mul(count) != Some(total) {
            let what = format!("is {total}, but {count} elements of {stride} bytes are compressed");
            return Err(bad(view.at("byteLength"), what));
        }
        let count = usize::try_from(count).map_err(|_| bad(extension.at("count"), "is too large for this computer"))?;
        Ok(Self { at: extension.path().to_owned(), data, stride: stride as usize, count, mode, filter })
    }

    /// Bytes of the decompressed data.
    pub(super) fn size(&self) -> u64 {
        self.stride as u64 * self.count as u64
    }

    pub(super) fn decode(&self) -> Result<Vec<u8>, Error> {
        let decoded = match self.mode {
            Mode::Attributes => attributes::decode(self.data, self.stride, self.count),
            Mode::Triangles => indices::decode_triangles(self.data, self.stride, self.count),
            Mode::Indices => indices::decode_indices(self.data, self.stride, self.count),
        };
        let mut decoded =
            decoded.map_err(|why| bad(&self.at, format!("the compressed data is damaged: {why}; export it again")))?;
        self.filter.apply(&mut decoded, self.stride);
        Ok(decoded)
    }
}

fn unknown(extension: &Object<'_>, key: &str) -> Error {
    let what = format!("a {key} that is unknown here (decompress: npx @gltf-transform/cli copy in.glb out.glb)");
    unsupported(extension.at(key), what)
}

/// Takes `count` bytes off the front.
fn take<'d>(data: &mut &'d [u8], count: usize) -> Result<&'d [u8], Damage> {
    let (front, rest) = data.split_at_checked(count).ok_or("it is cut short")?;
    *data = rest;
    Ok(front)
}

/// Memory for `count` elements of `stride` bytes.
fn zeros(count: usize, stride: usize) -> Result<Vec<u8>, Damage> {
    let size = count.checked_mul(stride).ok_or("its elements do not fit into memory")?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(size).map_err(|_| "its elements do not fit into memory")?;
    bytes.resize(size, 0);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(hex: &str) -> Vec<u8> {
        hex.as_bytes()
            .as_chunks::<2>()
            .0
            .iter()
            .map(|pair| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap())
            .collect()
    }

    /// Streams of the encoder of the package meshoptimizer, and what its decoder makes of them.
    #[test]
    fn decodes_as_the_reference_implementation() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/compressed/meshopt_streams.txt");
        let text = std::fs::read_to_string(path).unwrap();
        let mut kinds = std::collections::BTreeSet::new();
        for (line, text) in text.lines().enumerate() {
            let [mode, filter, stride, count, data, expected] = text.split(' ').collect::<Vec<_>>()[..] else {
                panic!("line {line}");
            };
            let (data, expected) = (bytes(data), bytes(expected));
            let (stride, count): (usize, usize) = (stride.parse().unwrap(), count.parse().unwrap());
            kinds.insert((mode, filter, if mode == "ATTRIBUTES" { data[0] } else { stride as u8 }));
            let mode = match mode {
                "ATTRIBUTES" => Mode::Attributes,
                "TRIANGLES" => Mode::Triangles,
                _ => Mode::Indices,
            };
            let filter = Filter::new(filter).unwrap();
            let decode = |data: &[u8], count| {
                Compressed { at: String::new(), data, stride, count, mode, filter }.decode().map_err(|e| e.to_string())
            };
            let decoded = decode(&data, count).unwrap();
            assert_eq!(decoded.len(), expected.len());
            // The filters that compute in floats may differ by one unit.
            let rounds = matches!(filter, Filter::Octahedral | Filter::Quaternion | Filter::Color);
            let unit = |x: &[u8]| match x {
                &[low, high] => i32::from(u16::from_le_bytes([low, high])),
                bytes => i32::from(bytes[0]),
            };
            let size = if rounds && stride == 8 { 2 } else { 1 };
            for (k, (is, should)) in decoded.chunks(size).zip(expected.chunks(size)).enumerate() {
                let difference = unit(is) - unit(should);
                assert!(difference.abs() <= i32::from(rounds), "line {line}, number {k}: {is:?}, not {should:?}");
            }
            // Too few and too many bytes, too many elements.
            for wrong in [&data[..data.len() - 1], &data[..data.len() / 2], &[&data[..], &[0]].concat()] {
                let Err(error) = decode(wrong, count) else { continue };
                assert!(error.contains("damaged"), "{error}");
            }
            assert!(decode(&data[..1], count).is_err() && decode(&[], count).is_err());
            assert!(decode(&data, 3 << 40).is_err());
        }
        // Every mode and filter; both versions of attributes; both sizes of indices.
        assert_eq!(kinds.len(), 6 + 4, "{kinds:?}");
    }
}
