//! How a caller follows a render and stops it. **May enter:** nothing.

use std::sync::atomic::{AtomicBool, Ordering};

/// Follows a render, and stops it.
pub trait Progress: Sync {
    /// `done` of `total` units of work are finished. Called from any thread.
    fn advance(&self, done: u64, total: u64) {
        let _ = (done, total);
    }

    /// Asked often; once it says yes the render ends with [`Error::Cancelled`](crate::Error::Cancelled).
    fn cancelled(&self) -> bool {
        false
    }
}

impl Progress for () {}

/// Asks the caller whether to stop, and remembers a yes: what was skipped once is missing for good.
pub(crate) struct Stop<'a> {
    progress: &'a dyn Progress,
    seen: AtomicBool,
}

impl<'a> Stop<'a> {
    pub fn new(progress: &'a dyn Progress) -> Self {
        Self { progress, seen: AtomicBool::new(false) }
    }

    pub fn requested(&self) -> bool {
        if self.progress.cancelled() {
            self.seen.store(true, Ordering::Relaxed);
        }
        self.seen.load(Ordering::Relaxed)
    }
}
