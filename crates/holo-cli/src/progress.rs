//! A progress bar on standard error where that is a terminal.

use std::sync::atomic::{AtomicU64, Ordering};

use holo_render::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::interrupt;

/// Shows how far a render is and how long it will still take.
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar for work in `total` steps; hidden if `quiet` or if standard error is no terminal.
    pub fn new(name: &'static str, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(None, target);
        let style = ProgressStyle::with_template("{msg:12} [{bar:36}] {percent:>3} %  {elapsed} elapsed, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        bar.set_message(name);
        Self(bar)
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Bar {
    fn advance(&self, done: u64, total: u64) {
        if self.0.length() != Some(total) {
            self.0.set_length(total);
        }
        self.0.set_position(done);
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
}

/// Steps of the bar for one render.
const STEPS: u64 = 1000;

impl Overall {
    /// Hidden if `quiet` or if standard error is no terminal.
    pub fn new(quiet: bool) -> Self {
        Self { bar: Bar::new("", quiet).0, done: AtomicU64::new(0) }
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
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}
