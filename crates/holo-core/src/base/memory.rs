//! Memory for samples. Allocation failure is an error here, not an abort.

use crate::Error;

/// An empty vector with room for exactly `length` elements.
///
/// `what` names the contents in the error, with its article, such as `"a light field"`.
///
/// # Errors
///
/// [`Error::OutOfMemory`] if the allocation fails.
pub(crate) fn reserved<T>(what: &'static str, length: usize) -> Result<Vec<T>, Error> {
    let mut memory = Vec::new();
    match memory.try_reserve_exact(length) {
        Ok(()) => Ok(memory),
        Err(_) => Err(Error::OutOfMemory { what, bytes: length.saturating_mul(size_of::<T>()) }),
    }
}

/// A vector of `length` copies of `value`.
///
/// # Errors
///
/// As [`reserved`].
pub(crate) fn filled<T: Clone>(what: &'static str, length: usize, value: T) -> Result<Vec<T>, Error> {
    // The reservation is a test only: it returns an error where `vec!` would abort. `vec!` then asks the system for
    // zeroed pages where `value` is zero, so that the thread that first writes to a page also creates it.
    drop(reserved::<T>(what, length)?);
    Ok(vec![value; length])
}

/// A vector of the items of an iterator of known length.
///
/// # Errors
///
/// As [`reserved`].
pub(crate) fn collected<T>(what: &'static str, items: impl ExactSizeIterator<Item = T>) -> Result<Vec<T>, Error> {
    let mut memory = reserved(what, items.len())?;
    memory.extend(items);
    Ok(memory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_allocations_are_errors_that_name_their_contents() {
        // 2^60 bytes do not overflow, and no address space of 64 bits has them.
        let error = filled("a test", 1 << 57, 0_u64).unwrap_err();
        assert_eq!(error, Error::OutOfMemory { what: "a test", bytes: 1 << 60 });
        assert_eq!(error.to_string(), format!("out of memory: allocating {} bytes for a test failed", 1_u64 << 60));
        assert!(reserved::<u64>("a test", usize::MAX).is_err());
    }

    #[test]
    fn possible_allocations_have_their_contents() {
        assert_eq!(filled("a test", 3, 7_u8).unwrap(), [7; 3]);
        assert_eq!(collected("a test", (0..4).rev()).unwrap(), [3, 2, 1, 0]);
    }
}
