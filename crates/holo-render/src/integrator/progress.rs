//! Progress reports and cancellation. **May import:** nothing.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

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

/// A render that takes less has no milestones.
const LONG: Duration = Duration::from_secs(10);

/// Milestones of a long render for log files: every tenth, once, after the first ten seconds.
#[derive(Debug)]
pub struct Tenths {
    start: Instant,
    /// Tenths that were reported, or passed in silence.
    passed: AtomicU64,
}

/// A render that begins now.
impl Default for Tenths {
    fn default() -> Self {
        Self { start: Instant::now(), passed: AtomicU64::new(0) }
    }
}

impl Tenths {
    /// With the arguments of [`Progress::advance`]: the tenths to report, 1 to 9, and the time since the start, if there
    /// are more of them than before. May be called from any thread.
    pub fn next(&self, done: u64, total: u64) -> Option<(u64, Duration)> {
        let elapsed = self.start.elapsed();
        self.next_after(done, total, elapsed).map(|tenths| (tenths, elapsed))
    }

    fn next_after(&self, done: u64, total: u64, elapsed: Duration) -> Option<u64> {
        // Never above 10, whatever the numbers.
        let tenths = (u128::from(done) * 10 / u128::from(total.max(1))).min(10) as u64;
        let is_more = self.passed.fetch_max(tenths, Ordering::Relaxed) < tenths;
        (is_more && tenths < 10 && elapsed >= LONG).then_some(tenths)
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_render_says_every_tenth_once() {
        let long = Duration::from_secs(60);
        let tenths = Tenths::default();
        let said: Vec<u64> = (0..=1000).filter_map(|done| tenths.next_after(done, 1000, long)).collect();
        assert_eq!(said, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
        // Steps may be coarse, late, out of order, or none.
        let tenths = Tenths::default();
        let said: Vec<_> = [1, 4, 3, 4, 9].map(|done| tenths.next_after(done, 10, long)).into();
        assert_eq!(said, [Some(1), Some(4), None, None, Some(9)]);
        assert_eq!(Tenths::default().next_after(0, 0, long), None);
        assert_eq!(Tenths::default().next_after(u64::MAX, 1, long), None);
    }

    #[test]
    fn a_short_render_says_nothing_and_catches_up_with_nothing() {
        let tenths = Tenths::default();
        assert!((0..500).all(|done| tenths.next_after(done, 1000, Duration::from_secs(9)).is_none()));
        assert_eq!(tenths.next_after(499, 1000, LONG), None, "a tenth that passed in silence");
        assert_eq!(tenths.next_after(500, 1000, LONG), Some(5));
    }
}
