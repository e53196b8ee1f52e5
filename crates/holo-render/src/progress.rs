//! Progress reports and cancellation. **May import:** nothing.

use std::sync::atomic::{AtomicBool, Ordering};

/// Receives progress reports and can cancel a render. `()` ignores the reports and never cancels.
pub trait Progress: Sync {
    /// Reports that `done` of `total` units of work (tiles) are finished. Called from any thread.
    fn advance(&self, done: u64, total: u64) {
        let _ = (done, total);
    }

    /// Returns whether to cancel. Called often; once it returns `true` the render ends with
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    fn cancelled(&self) -> bool {
        false
    }
}

impl Progress for () {}

/// Whether the caller has canceled. Remembers a `true`, because tiles that were skipped stay missing.
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
