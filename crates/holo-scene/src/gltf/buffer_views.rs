//! Buffer views: validated ranges of bytes.

use std::borrow::Cow;

use super::extensions::MESHOPT;
use super::json::{Object, bad, unsupported};
use crate::Error;

/// The buffer views of a file, with its buffers.
pub(super) struct BufferViews<'f> {
    buffer_views: Vec<Object<'f>>,
    buffers: Vec<Cow<'f, [u8]>>,
}

/// A buffer view that lies inside its buffer.
pub(super) struct BufferView<'v> {
    pub(super) buffer: usize,
    pub(super) offset: usize,
    pub(super) stride: Option<usize>,
    pub(super) bytes: &'v [u8],
}

impl<'f> BufferViews<'f> {
    pub(super) fn new(root: &Object<'f>, buffers: Vec<Cow<'f, [u8]>>) -> Result<Self, Error> {
        Ok(Self { buffer_views: root.objects("bufferViews")?, buffers })
    }

    pub(super) fn len(&self) -> usize {
        self.buffer_views.len()
    }

    pub(super) fn buffers(&self) -> &[Cow<'f, [u8]>] {
        &self.buffers
    }

    /// Validates a buffer view and returns it with its bytes.
    pub(super) fn get(&self, number: usize) -> Result<BufferView<'_>, Error> {
        let Some(view) = self.buffer_views.get(number) else {
            return Err(bad("bufferViews", format!("there is no bufferViews[{number}]")));
        };
        let buffer = view.index("buffer", "buffers", self.buffers.len())?.ok_or_else(|| view.missing("buffer"))?;
        let length = view.unsigned("byteLength")?.ok_or_else(|| view.missing("byteLength"))?;
        let offset = view.unsigned("byteOffset")?.unwrap_or(0);
        let stride = match view.unsigned("byteStride")? {
            // Not allowed, but written by some exporters for "tightly packed".
            None | Some(0) => None,
            Some(stride @ 4..=252) => Some(stride as usize),
            Some(stride) => return Err(bad(view.at("byteStride"), format!("is {stride}; it must be 4..252"))),
        };
        let bytes: &[u8] = &self.buffers[buffer];
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        let range = end.map(|end| offset as usize..end as usize);
        match range.and_then(|range| bytes.get(range)) {
            Some(bytes) => Ok(BufferView { buffer, offset: offset as usize, stride, bytes }),
            None if view.extension(MESHOPT)?.is_some() => {
                Err(unsupported(view.path(), format!("{MESHOPT} (export the file uncompressed)")))
            }
            None => {
                let have = bytes.len();
                Err(bad(
                    view.path(),
                    format!("needs {length} bytes from byte {offset} on, but buffers[{buffer}] has {have}"),
                ))
            }
        }
    }
}
