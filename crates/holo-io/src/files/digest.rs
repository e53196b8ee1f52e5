//! Sizes and digests of files.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256 as Hasher};

use crate::Error;

/// Bytes that are read before they are hashed.
const BUFFER_BYTES: usize = 256 * 1024;

/// The SHA-256 digest of a file; prints as 64 lower-case hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Sha256(pub [u8; 32]);

impl Sha256 {
    /// Computes the digest of bytes in memory.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self(Hasher::digest(bytes).into())
    }
}

impl fmt::Display for Sha256 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Sha256 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Sha256({self})")
    }
}

impl Sha256 {
    /// Parses 64 hexadecimal digits of either case; `None` for any other text.
    #[must_use]
    pub fn from_hex(text: &str) -> Option<Self> {
        let digits = text.as_bytes();
        if digits.len() != 64 {
            return None;
        }
        let digit = |at: usize| (digits[at] as char).to_digit(16).map(|value| value as u8);
        let mut digest = [0; 32];
        for (at, byte) in digest.iter_mut().enumerate() {
            *byte = digit(2 * at)? << 4 | digit(2 * at + 1)?;
        }
        Some(Self(digest))
    }
}

/// Size and digest of a file: what a manifest contains of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FileDigest {
    /// Size of the file in bytes.
    pub bytes: u64,
    /// Digest of its contents.
    pub sha256: Sha256,
}

/// Computes the size and digest of a file.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read.
pub fn hash_file(path: impl AsRef<Path>) -> Result<FileDigest, Error> {
    let path = path.as_ref();
    let failed = |source| Error::io("read", path, source);
    let mut file = File::open(path).map_err(failed)?;
    hash(&mut file).map_err(failed)
}

/// Computes the size and digest of everything up to the end of `source`.
pub(crate) fn hash(source: &mut impl Read) -> io::Result<FileDigest> {
    let mut hasher = Hasher::new();
    let mut buffer = vec![0; BUFFER_BYTES];
    let mut bytes = 0;
    loop {
        match source.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => {
                hasher.update(&buffer[..count]);
                bytes += count as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(FileDigest { bytes, sha256: Sha256(hasher.finalize().into()) })
}
