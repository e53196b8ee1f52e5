//! Memory limits of the readers, checked before memory is allocated.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::Error;

/// Maximum memory that reading one file may take.
///
/// A few bytes of a damaged or hostile file can announce an image of many gigabytes. Every reader of this crate
/// computes the size of its result and compares it with this limit before it allocates.
///
/// # Examples
///
/// ```
/// // An 8K raw image of 8-bit RGB is 127 MB; a caller that expects no more can set a lower limit.
/// let limits = holo_io::Limits { max_bytes: 200_000_000 };
/// assert!(limits.max_bytes < holo_io::Limits::default().max_bytes);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Maximum size of the data of one file in memory, in bytes.
    pub max_bytes: u64,
}

impl Limits {
    /// No limit but the memory of the machine: for files from sources you trust.
    pub const NONE: Self = Self { max_bytes: u64::MAX };
}

impl Default for Limits {
    /// 4 GiB: thirty times an 8K raw image of 8-bit RGB.
    fn default() -> Self {
        Self { max_bytes: 4 << 30 }
    }
}

impl Limits {
    /// Returns the product of `counts`, a number of elements, if that many elements fit into the limit and the address
    /// space.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] otherwise.
    pub(crate) fn elements(
        self,
        path: &Path,
        what: &'static str,
        counts: &[usize],
        element_bytes: usize,
    ) -> Result<usize, Error> {
        let too_large = |needed: u64, allowed: u64| Error::TooLarge { path: path.to_owned(), what, needed, allowed };
        let address_space = isize::MAX as u64;
        let elements = counts
            .iter()
            .try_fold(1_usize, |product, &count| product.checked_mul(count))
            .ok_or_else(|| too_large(u64::MAX, self.max_bytes.min(address_space)))?;
        let bytes = (elements as u64).saturating_mul(element_bytes as u64);
        if bytes > self.max_bytes.min(address_space) {
            return Err(too_large(bytes, self.max_bytes.min(address_space)));
        }
        Ok(elements)
    }

    /// Allocates an empty vector with room for `elements` elements.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the allocation fails.
    pub(crate) fn room<T>(path: &Path, what: &'static str, elements: usize) -> Result<Vec<T>, Error> {
        let mut vector = Vec::new();
        vector.try_reserve_exact(elements).map_err(|_| Error::OutOfMemory {
            path: path.to_owned(),
            what,
            bytes: (elements as u64).saturating_mul(size_of::<T>() as u64),
        })?;
        Ok(vector)
    }
}

/// Reads a text file of at most `max_bytes`, or what a pipe gives.
pub(crate) fn read_small_file(path: &Path, max_bytes: u64) -> Result<Vec<u8>, Error> {
    let failed = |source| Error::io("read", path, source);
    let file = File::open(path).map_err(failed)?;
    let announced = file.metadata().map_err(failed)?.len();
    Limits { max_bytes }.elements(path, "file", &[usize::try_from(announced).unwrap_or(usize::MAX)], 1)?;
    let mut bytes = Vec::new();
    // A pipe announces no length, so the length is checked again.
    file.take(max_bytes + 1).read_to_end(&mut bytes).map_err(failed)?;
    Limits { max_bytes }.elements(path, "file", &[bytes.len()], 1)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_exact() {
        let path = Path::new("x.png");
        let limits = Limits { max_bytes: 24 };
        assert_eq!(limits.elements(path, "image", &[2, 3], 4).unwrap(), 6);
        let error = limits.elements(path, "image", &[5, 5], 1).unwrap_err();
        assert!(matches!(error, Error::TooLarge { needed: 25, allowed: 24, .. }), "{error}");
    }

    #[test]
    fn sizes_that_overflow_are_errors() {
        let path = Path::new("x.png");
        for counts in [&[usize::MAX, usize::MAX][..], &[usize::MAX], &[1 << 40, 1 << 40, 0]] {
            assert!(Limits::NONE.elements(path, "image", counts, 8).is_err(), "{counts:?}");
        }
        let error = Limits::room::<u64>(path, "image", 1 << 58).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("x.png: out of memory: allocating {} bytes for the image failed", 1_u64 << 61)
        );
    }
}
