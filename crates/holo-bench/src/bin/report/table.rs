//! Tables in Markdown and CSV, and measuring time and memory.

use std::time::Instant;

use holo_bench::memory_bytes;

/// Rows of cells under headings.
pub struct Table {
    headings: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub fn new(headings: &[&'static str]) -> Self {
        Self { headings: headings.to_vec(), rows: Vec::new() }
    }

    /// Adds a row of as many cells as there are headings.
    pub fn push<const N: usize>(&mut self, cells: [String; N]) {
        assert_eq!(N, self.headings.len(), "cells of a row");
        self.rows.push(cells.into());
    }

    /// The last row; panics if it has not `N` cells.
    pub fn last<const N: usize>(&self) -> [String; N] {
        let row = self.rows.last().cloned().unwrap_or_default();
        row.try_into().expect("as many cells as there are headings")
    }

    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let headings: Vec<String> = self.headings.iter().map(|heading| (*heading).into()).collect();
        let mut text = line(&headings) + &"|---".repeat(headings.len()) + "|\n";
        self.rows.iter().for_each(|row| text += &line(row));
        text
    }

    pub fn csv(&self) -> String {
        // Commas occur only in text, where semicolons can replace them.
        let line = |cells: &mut dyn Iterator<Item = &str>| {
            cells.map(|cell| cell.replace(',', ";")).collect::<Vec<_>>().join(",") + "\n"
        };
        let rows = self.rows.iter().map(|row| line(&mut row.iter().map(String::as_str)));
        line(&mut self.headings.iter().copied()) + &rows.collect::<String>()
    }
}

/// The times of several runs, s.
#[derive(Clone, Copy, Debug)]
pub struct Seconds {
    pub median: f64,
    /// The difference between the slowest and the fastest run, relative to the median.
    pub spread: f64,
}

impl Seconds {
    /// Median and spread of measured times; `None` without any.
    pub fn of(mut seconds: Vec<f64>) -> Option<Self> {
        seconds.sort_by(f64::total_cmp);
        let median = *seconds.get(seconds.len() / 2)?;
        Some(Self { median, spread: (seconds[seconds.len() - 1] - seconds[0]) / median })
    }

    /// The ratio to another time with the sum of both spreads: `3.1 ±6 %`.
    pub fn ratio(self, other: Self) -> String {
        with_spread(self.median / other.median, self.spread + other.spread)
    }

    /// Median and half the spread: `0.123 ±4 %`; of a single run nothing is known of that.
    pub fn text(self) -> String {
        with_spread(self.median, self.spread)
    }
}

fn with_spread(value: f64, spread: f64) -> String {
    let spread = if spread > 0.0 { format!(" ±{:.0} %", 50.0 * spread) } else { String::new() };
    short(value) + &spread
}

/// Work whose first run takes less time than this, s, is warmed up by that run.
const WARM_UP: f64 = 0.5;

/// No further run begins after this time, s: with all runs a report would take twice as long.
pub const LONGEST: f64 = 10.0;

/// Runs `work` several times, none begins after ten seconds; also returns the result of the last run.
pub fn timed<T>(rounds: usize, mut work: impl FnMut() -> T) -> (Seconds, T) {
    let mut last = None;
    let mut seconds = Vec::new();
    for round in 0..=rounds.max(1) {
        // Only one result is in memory at a time.
        drop(last.take());
        let start = Instant::now();
        last = Some(work());
        seconds.push(start.elapsed().as_secs_f64());
        // A short first run only warms up caches and is not counted.
        if round == 0 && seconds[0] < WARM_UP {
            seconds.clear();
        } else if seconds.len() == rounds.max(1) || seconds.iter().sum::<f64>() > LONGEST {
            break;
        }
    }
    (Seconds::of(seconds).expect("at least one run"), last.expect("at least one run"))
}

/// Runs `work` and returns by how many bytes the peak memory rose (`None` where the system cannot measure it).
pub fn peak_bytes<T>(work: impl FnOnce() -> T) -> (Option<u64>, T) {
    let reset = reset_peak();
    let before = memory_bytes("VmRSS:");
    let made = work();
    let peak = memory_bytes("VmHWM:").zip(before).map(|(peak, before)| peak.saturating_sub(before));
    (peak.filter(|_| reset), made)
}

/// Resets the peak memory of this process; returns whether the system supports it.
pub fn reset_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// The peak memory of this process since its start or the last reset, bytes.
pub fn peak_of_process() -> Option<u64> {
    memory_bytes("VmHWM:")
}

/// A number with three significant digits, in scientific notation below 1e-3.
pub fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return format!("{number}");
    }
    let digits = (2 - number.abs().log10().floor() as i32).max(0) as usize;
    if digits > 5 { format!("{number:.2e}") } else { format!("{number:.digits$}") }
}
