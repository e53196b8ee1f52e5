//! A progress bar on standard error where that is a terminal; elsewhere a line every tenth of a long render.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use holo_render::{Progress, Tenths};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::console::say;
use crate::interrupt;

/// Writes a line of progress, if it is time.
fn say_tenth(tenths: &Tenths, name: &str, done: u64, total: u64) {
    if let Some((tenths, elapsed)) = tenths.next(done, total) {
        let seconds = elapsed.as_secs_f64();
        let left = seconds * (total as f64 / done.max(1) as f64 - 1.0);
        say!("{name}: {tenths}0 %, {seconds:.0} s elapsed, about {left:.0} s left");
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
    advice: Option<Advice>,
}

/// A hint that the bar prints once, if the render is long.
struct Advice {
    text: &'static str,
    is_said: AtomicBool,
    /// When the first part was done, and how much: what was prepared before tells nothing about what is left.
    first: OnceLock<(Instant, u64)>,
}

impl Advice {
    /// How long the rest will take, once the speed so far tells; `now`: when so much was done.
    fn left(&self, now: Instant, done: u64, total: u64) -> Option<Duration> {
        let (begun, first) = *self.first.get_or_init(|| (now, done));
        let elapsed = now.saturating_duration_since(begun);
        if elapsed < BEGINNING || done <= first {
            return None;
        }
        Some(elapsed.mul_f64(total.saturating_sub(done) as f64 / (done - first) as f64))
    }
}

/// From here on the speed so far tells how long a render will take.
const BEGINNING: Duration = Duration::from_secs(2);

/// A render that needs this time more is long.
const LONG: Duration = Duration::from_secs(60);

impl Bar {
    /// A bar; lines if standard error is no terminal, and nothing if `quiet`.
    pub fn new(name: &'static str, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(None, target);
        let style = ProgressStyle::with_template("{msg:12} [{bar:36}] {percent:>3} %  {elapsed} elapsed, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        bar.set_message(name);
        Self { bar, lines: needs_lines(quiet).then(Tenths::default), name, advice: None }
    }

    /// Says `text` once if the render turns out to be long.
    pub fn advise(&mut self, text: &'static str) {
        let is_said = AtomicBool::new(self.bar.is_hidden() && self.lines.is_none());
        self.advice = Some(Advice { text, is_said, first: OnceLock::new() });
    }

    /// Says the advice, if it is time.
    fn give_advice(&self, done: u64, total: u64) {
        let Some(advice) = &self.advice else { return };
        let Some(left) = advice.left(Instant::now(), done, total) else { return };
        if left > LONG && !advice.is_said.swap(true, Ordering::Relaxed) {
            let minutes = (left.as_secs_f64() / 60.0).round().max(1.0);
            self.bar.suspend(|| say!("note: about {minutes:.0} min are left; {}", advice.text));
        }
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
            say_tenth(lines, self.name, done, total);
        }
        self.give_advice(done, total);
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
        let lines = needs_lines(quiet).then(|| Mutex::new((String::new(), Tenths::default())));
        Self { bar: Bar::new("", quiet).bar, done: AtomicU64::new(0), lines }
    }

    /// There are so many renders to come.
    pub fn expect(&self, jobs: usize) {
        self.bar.set_length(jobs as u64 * STEPS);
    }

    /// `done` renders are over; the next is called `name`.
    pub fn begin(&self, done: usize, name: &str) {
        self.done.store(done as u64, Ordering::Relaxed);
        self.bar.set_message(holo_core::shown(name).into_owned());
        self.bar.set_position(done as u64 * STEPS);
        if let Some(lines) = &self.lines {
            *lines.lock().unwrap_or_else(PoisonError::into_inner) = (name.to_owned(), Tenths::default());
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
            say_tenth(&lines.1, &lines.0, done, total);
        }
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left follows from the speed since the first part, not from the time that the render was prepared in.
    #[test]
    fn preparation_says_nothing_about_what_is_left() {
        let advice = Advice { text: "", is_said: AtomicBool::new(false), first: OnceLock::new() };
        let start = Instant::now();
        let at = |seconds: u64, done: u64| advice.left(start + Duration::from_secs(seconds), done, 1000);
        assert_eq!(at(100, 10), None);
        assert_eq!(at(101, 60), None);
        assert_eq!(at(104, 210), Some(Duration::from_secs_f64(4.0 * 790.0 / 200.0)));
        assert_eq!(at(120, 1000), Some(Duration::ZERO));
    }
}
