//! The panic guard of the loader: a panic in a decoder becomes an error.
//!
//! All values of a file are validated before they reach another crate, so no panic should occur; the mutation tests
//! assert that. A library must not install a panic hook; a program that has one checks [`is_guarding`] and prints
//! nothing.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::Error;

thread_local! {
    static GUARDING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is inside the panic guard of the loader: a panic then becomes an [`Error`], so a panic hook
/// should print nothing.
#[must_use]
pub fn is_guarding() -> bool {
    GUARDING.get()
}

/// Restores the flag, also on unwinding.
struct Restore(bool);

impl Drop for Restore {
    fn drop(&mut self) {
        GUARDING.set(self.0);
    }
}

/// Runs `work` with the flag of this thread set; for closures that run on other threads than their [`catch`].
pub(super) fn guarded<T>(work: impl FnOnce() -> T) -> T {
    let _restore = Restore(GUARDING.replace(true));
    work()
}

/// Runs `work`; a panic in it becomes an error about `at`.
pub(crate) fn catch<T>(at: &str, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    // Unwind safety: `work` owns its data or only reads it, and everything is discarded on a panic.
    let outcome = catch_unwind(AssertUnwindSafe(|| guarded(work)));
    outcome.unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no message");
        let what = format!("the reader failed on this file ({text}); the file is likely damaged; please report it");
        Err(super::json::bad(at, what))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_become_errors_and_the_flag_is_restored() {
        assert!(!is_guarding());
        let seen = catch("glTF", || Ok(is_guarding()));
        assert!(matches!(seen, Ok(true)));
        // `resume_unwind` calls no panic hook.
        let caught = catch::<()>("glTF", || std::panic::resume_unwind(Box::new("boom")));
        assert!(matches!(caught, Err(Error::BadFile { what, .. }) if what.contains("boom")));
        assert!(!is_guarding());
    }
}
