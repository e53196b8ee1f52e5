//! A progress bar on standard error where that is a terminal; elsewhere a line every tenth of a long render.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use holo_render::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::console::say;
use crate::interrupt;

/// A render that takes less has no lines of progress.
const LONG: Duration = Duration::from_secs(10);

/// Lines of progress for log files: one for every tenth.
struct Tenths {
    start: Instant,
    /// Tenths that were said, or passed in silence.
    said: AtomicU64,
}

impl Tenths {
    fn new() -> Self {
        Self { start: Instant::now(), said: AtomicU64::new(0) }
    }

    /// The tenths to say after `elapsed`, if they are more than before. The last one is the summary's.
    fn next(&self, done: u64, total: u64, elapsed: Duration) -> Option<u64> {
        // Never above 10, whatever the numbers.
        let tenths = (u128::from(done) * 10 / u128::from(total.max(1))).min(10) as u64;
        let is_more = self.said.fetch_max(tenths, Ordering::Relaxed) < tenths;
        (is_more && tenths < 10 && elapsed >= LONG).then_some(tenths)
    }

    /// Writes a line, if it is time.
    fn say(&self, name: &str, done: u64, total: u64) {
        let elapsed = self.start.elapsed();
        if let Some(tenths) = self.next(done, total, elapsed) {
            let left = elapsed.as_secs_f64() * (total as f64 / done.max(1) as f64 - 1.0);
            say!("{name}: {}0 %, {:.0} s elapsed, about {left:.0} s left", tenths, elapsed.as_secs_f64());
        }
    }
}

/// Whether lines take the place of the bar.
fn needs_lines(quiet: bool) -> bool {
    !quiet && !std::io::stderr().is_terminal()
}

/// Shows how far a render is and how long it will still take.
pub struct Bar {
    bar: ProgressBar,
    lines: Option<Tenths>,
    name: &'static str,
}

impl Bar {
    /// A bar; lines if standard error is no terminal, and nothing if `quiet`.
    pub fn new(name: &'static str, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(None, target);
        let style = ProgressStyle::with_template("{msg:12} [{bar:36}] {percent:>3} %  {elapsed} elapsed, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        bar.set_message(name);
        Self { bar, lines: needs_lines(quiet).then(Tenths::new), name }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn advance(&self, done: u64, total: u64) {
        if self.bar.length() != Some(total) {
            self.bar.set_length(total);
        }
        self.bar.set_position(done);
        if let Some(lines) = &self.lines {
            lines.say(self.name, done, total);
        }
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

/// Shows how far many renders are, one after another.
pub struct Overall {
    bar: ProgressBar,
    /// Renders that are over.
    done: AtomicU64,
    /// Name and progress of the present one.
    lines: Option<Mutex<(String, Tenths)>>,
}

/// Steps of the bar for one render.
const STEPS: u64 = 1000;

impl Overall {
    /// A bar; lines if standard error is no terminal, and nothing if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let lines = needs_lines(quiet).then(|| Mutex::new((String::new(), Tenths::new())));
        Self { bar: Bar::new("", quiet).bar, done: AtomicU64::new(0), lines }
    }

    /// There are so many renders to come.
    pub fn expect(&self, jobs: usize) {
        self.bar.set_length(jobs as u64 * STEPS);
    }

    /// `done` renders are over; the next is called `name`.
    pub fn begin(&self, done: usize, name: &str) {
        self.done.store(done as u64, Ordering::Relaxed);
        self.bar.set_message(name.to_owned());
        self.bar.set_position(done as u64 * STEPS);
        if let Some(lines) = &self.lines {
            *lines.lock().unwrap_or_else(PoisonError::into_inner) = (name.to_owned(), Tenths::new());
        }
    }

    /// Writes lines where the bar is, which goes down.
    pub fn above(&self, write: impl FnOnce()) {
        self.bar.suspend(write);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Overall {
    fn advance(&self, done: u64, total: u64) {
        let part = STEPS * done / total.max(1);
        self.bar.set_position(self.done.load(Ordering::Relaxed) * STEPS + part.min(STEPS - 1));
        if let Some(lines) = &self.lines {
            let lines = lines.lock().unwrap_or_else(PoisonError::into_inner);
            lines.1.say(&lines.0, done, total);
        }
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_render_says_every_tenth_once() {
        let long = Duration::from_secs(60);
        let tenths = Tenths::new();
        let said: Vec<u64> = (0..=1000).filter_map(|done| tenths.next(done, 1000, long)).collect();
        assert_eq!(said, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
        // Steps may be coarse, late, out of order, or none.
        let tenths = Tenths::new();
        let said: Vec<_> = [1, 4, 3, 4, 9].map(|done| tenths.next(done, 10, long)).into();
        assert_eq!(said, [Some(1), Some(4), None, None, Some(9)]);
        assert_eq!(Tenths::new().next(0, 0, long), None);
        assert_eq!(Tenths::new().next(u64::MAX, 1, long), None);
    }

    #[test]
    fn a_short_render_says_nothing_and_catches_up_with_nothing() {
        let tenths = Tenths::new();
        assert!((0..500).all(|done| tenths.next(done, 1000, Duration::from_secs(9)).is_none()));
        assert_eq!(tenths.next(499, 1000, LONG), None, "a tenth that passed in silence");
        assert_eq!(tenths.next(500, 1000, LONG), Some(5));
    }
}
