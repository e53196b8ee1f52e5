//! Buffer views: validated ranges of bytes, decompressed if they are compressed.

use std::borrow::Cow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use super::json::{Object, bad};
use super::meshopt::{self, Compressed};
use crate::Error;

/// The buffer views of a file, with its buffers.
pub(super) struct BufferViews<'f> {
    buffer_views: Vec<Object<'f>>,
    buffers: Vec<Cow<'f, [u8]>>,
    /// The contents of compressed buffer views that were used.
    decoded: Vec<OnceLock<Vec<u8>>>,
    /// How many bytes may still be decompressed.
    bytes_left: AtomicU64,
    max_bytes: u64,
}

/// A buffer view that lies inside its buffer.
pub(super) struct BufferView<'v> {
    /// The number for [`BufferViews::buffer`].
    pub(super) buffer: usize,
    pub(super) offset: usize,
    pub(super) stride: Option<usize>,
    pub(super) bytes: &'v [u8],
}

impl<'f> BufferViews<'f> {
    /// All compressed buffer views together may have `max_bytes` bytes.
    pub(super) fn new(root: &Object<'f>, buffers: Vec<Cow<'f, [u8]>>, max_bytes: u64) -> Result<Self, Error> {
        let buffer_views = root.objects("bufferViews")?;
        let decoded = buffer_views.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { buffer_views, buffers, decoded, bytes_left: AtomicU64::new(max_bytes), max_bytes })
    }

    pub(super) fn len(&self) -> usize {
        self.buffer_views.len()
    }

    /// The number of buffers: those of the file, then one for each buffer view, which is there if it was compressed.
    pub(super) fn buffer_count(&self) -> usize {
        self.buffers.len() + self.decoded.len()
    }

    /// The bytes of a buffer.
    pub(super) fn buffer(&self, number: usize) -> Option<&[u8]> {
        match number.checked_sub(self.buffers.len()) {
            None => self.buffers.get(number).map(|buffer| &**buffer),
            Some(view) => self.decoded.get(view)?.get().map(Vec::as_slice),
        }
    }

    /// Validates a buffer view and returns it with its bytes.
    pub(super) fn get(&self, number: usize) -> Result<BufferView<'_>, Error> {
        let Some(view) = self.buffer_views.get(number) else {
            return Err(bad("bufferViews", format!("there is no bufferViews[{number}]")));
        };
        let stride = match view.unsigned("byteStride")? {
            // Not allowed, but written by some exporters for "tightly packed".
            None | Some(0) => None,
            Some(stride @ 4..=252) => Some(stride as usize),
            Some(stride) => return Err(bad(view.at("byteStride"), format!("is {stride}; it must be 4..252"))),
        };
        if let Some(extension) = meshopt::extension(view)? {
            let bytes = self.decode(number, &extension)?;
            return Ok(BufferView { buffer: self.buffers.len() + number, offset: 0, stride, bytes });
        }
        let buffer = view.index("buffer", "buffers", self.buffers.len())?.ok_or_else(|| view.missing("buffer"))?;
        let length = view.unsigned("byteLength")?.ok_or_else(|| view.missing("byteLength"))?;
        let offset = view.unsigned("byteOffset")?.unwrap_or(0);
        let bytes: &[u8] = &self.buffers[buffer];
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        let range = end.map(|end| offset as usize..end as usize);
        let bytes = range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            let have = bytes.len();
            bad(view.path(), format!("needs {length} bytes from byte {offset} on, but buffers[{buffer}] has {have}"))
        })?;
        Ok(BufferView { buffer, offset: offset as usize, stride, bytes })
    }

    /// The contents of a compressed buffer view, decoded once.
    fn decode(&self, number: usize, extension: &Object<'_>) -> Result<&[u8], Error> {
        let cell = &self.decoded[number];
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let compressed = Compressed::new(&self.buffer_views[number], extension, &self.buffers)?;
        let size = compressed.size();
        let charge = |left: u64| left.checked_sub(size);
        if self.bytes_left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, charge).is_err() {
            let limit = self.max_bytes;
            let what = format!("decompresses to {size} bytes, which exceeds the limit of {limit} of all buffer views");
            return Err(bad(self.buffer_views[number].path(), what));
        }
        let bytes = compressed.decode()?;
        // Another thread may have been faster, with the same bytes.
        Ok(cell.get_or_init(|| bytes))
    }
}
