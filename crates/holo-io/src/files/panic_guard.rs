//! The panic guard around decoders of other crates: a panic in them becomes an error.
//!
//! What a file announces is checked before the decoder reads it, but the decoder's own arithmetic on damaged data may
//! still panic. A library must not install a panic hook; a program that has one checks [`is_guarding`] and prints
//! nothing where it is true.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::Error;

thread_local! {
    static GUARDING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is inside this crate's panic guard: a panic now becomes an [`Error`](crate::Error), so a panic
/// hook should print nothing.
///
/// The decoders of EXR, MAT, TIFF and SGI files need the guard.
#[must_use]
pub fn is_guarding() -> bool {
    GUARDING.get()
}

/// Restores the flag when it is dropped, also during a panic.
struct Restore(bool);

impl Drop for Restore {
    fn drop(&mut self) {
        GUARDING.set(self.0);
    }
}

/// Runs `work` with the flag of this thread set: for closures that run on another thread than their [`catch`].
pub(crate) fn guarded<T>(work: impl FnOnce() -> T) -> T {
    let _restore = Restore(GUARDING.replace(true));
    work()
}

/// Runs `work` inside the panic guard. The error is the message of the panic.
pub(crate) fn catch<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    // Unwind safety: `work` owns or only reads what it uses, and all of that is dropped on a panic.
    catch_unwind(AssertUnwindSafe(|| guarded(work))).map_err(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str);
        text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no message").to_owned()
    })
}

/// Runs a decoder inside the panic guard: a panic means that the file of that format is broken.
pub(crate) fn decoded<T>(
    path: &Path,
    format: &'static str,
    work: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    catch(work).unwrap_or_else(|text| Err(Error::broken(path, format, format!("the decoder failed on it ({text})"))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_become_errors_and_the_flag_is_restored() {
        assert!(!is_guarding());
        assert_eq!(catch(is_guarding), Ok(true));
        // `resume_unwind` runs no panic hook, so the test's output stays clean.
        assert_eq!(catch::<()>(|| std::panic::resume_unwind(Box::new("boom"))), Err("boom".to_owned()));
        assert!(!is_guarding());
    }
}
