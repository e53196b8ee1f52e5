//! Deflate, as PNG and OpenEXR have it inside.

use zlib_rs::{Deflate, DeflateConfig, DeflateFlush, Status};

/// Compresses `data` in one go; `config` says whether a zlib header and checksum surround it.
///
/// With [`DeflateFlush::Finish`] the stream is complete, with [`DeflateFlush::SyncFlush`] another may follow it.
pub(crate) fn deflate(data: &[u8], config: DeflateConfig, flush: DeflateFlush) -> std::io::Result<Vec<u8>> {
    let mut deflate = Deflate::new_with_config(config);
    let mut out = vec![0; data.len() / 2 + 1024];
    loop {
        let (read, written) = (deflate.total_in() as usize, deflate.total_out() as usize);
        let status = deflate
            .compress(&data[read..], &mut out[written..], flush)
            .map_err(|error| std::io::Error::other(error.as_str()))?;
        let end = deflate.total_out() as usize;
        // A flush is complete when it leaves room behind it.
        if status == Status::StreamEnd || (end < out.len() && flush != DeflateFlush::Finish) {
            out.truncate(end);
            return Ok(out);
        }
        out.resize(out.len() * 2, 0);
    }
}
