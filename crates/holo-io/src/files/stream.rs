//! Sources and destinations of images: files that are read in order, and anything that reads or writes bytes.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use crate::error::STREAM;
use crate::{Error, Limits};

/// Bytes by which an encoded image may be longer than its samples: headers, tables, data that do not compress.
const OVERHEAD_BYTES: u64 = 64 << 20;

/// Opens a file that is read in order, in large pieces.
pub(crate) fn open(path: &Path) -> Result<BufReader<File>, Error> {
    let file = File::open(path).map_err(|source| Error::io("read", path, source))?;
    Ok(BufReader::with_capacity(1 << 18, file))
}

/// Reads a source up to its end, for formats that need its length or read it in another order.
pub(crate) fn read_to_end(source: impl Read, limits: Limits) -> Result<Vec<u8>, Error> {
    let path = Path::new(STREAM);
    let allowed = limits.max_bytes.saturating_add(OVERHEAD_BYTES);
    let mut bytes = Vec::new();
    source.take(allowed.saturating_add(1)).read_to_end(&mut bytes).map_err(|source| Error::io("read", path, source))?;
    if bytes.len() as u64 > allowed {
        return Err(Error::TooLarge { path: path.into(), what: "encoded file", needed: bytes.len() as u64, allowed });
    }
    Ok(bytes)
}

/// Writes bytes that were encoded in memory.
pub(crate) fn write_bytes(mut out: impl std::io::Write, bytes: &[u8]) -> Result<(), Error> {
    out.write_all(bytes).and_then(|()| out.flush()).map_err(|source| Error::io("write", Path::new(STREAM), source))
}
