//! A table that is written as Markdown and as CSV.

use std::time::Instant;

/// Rows of cells under headings.
pub struct Sheet {
    headings: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Sheet {
    pub fn new(headings: &[&'static str]) -> Self {
        Self { headings: headings.to_vec(), rows: Vec::new() }
    }

    /// Adds a row of as many cells as there are headings.
    pub fn push<const N: usize>(&mut self, cells: [String; N]) {
        assert_eq!(N, self.headings.len(), "cells of a row");
        self.rows.push(cells.into());
    }

    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let headings: Vec<String> = self.headings.iter().map(|heading| (*heading).into()).collect();
        let mut text = line(&headings) + &"|---".repeat(headings.len()) + "|\n";
        self.rows.iter().for_each(|row| text += &line(row));
        text
    }

    pub fn csv(&self) -> String {
        let mut text = self.headings.join(",") + "\n";
        for row in &self.rows {
            // No cell has a comma but those that are numbers with words.
            let cells: Vec<String> = row.iter().map(|cell| cell.replace(',', ";")).collect();
            text += &(cells.join(",") + "\n");
        }
        text
    }
}

/// Seconds of several runs.
#[derive(Clone, Copy, Debug)]
pub struct Seconds {
    pub median: f64,
    /// The slowest less the fastest, of the median.
    pub spread: f64,
}

impl Seconds {
    /// `0.123 +-4 %`.
    pub fn text(self) -> String {
        format!("{} ±{:.0} %", short(self.median), 50.0 * self.spread)
    }
}

/// Runs of fewer seconds are warmed up.
const WARM_UP: f64 = 0.5;

/// Runs something several times; also returns what the last run made.
pub fn timed<T>(rounds: usize, mut work: impl FnMut() -> T) -> (Seconds, T) {
    let mut last = None;
    let mut seconds = Vec::new();
    for round in 0..=rounds.max(1) {
        // Not two of them at once in memory.
        drop(last.take());
        let start = Instant::now();
        last = Some(work());
        seconds.push(start.elapsed().as_secs_f64());
        // What is quick is warmed up by its first run, which does not count; of what takes long that makes no difference.
        if round == 0 && seconds[0] < WARM_UP {
            seconds.clear();
        } else if seconds.len() == rounds.max(1) {
            break;
        }
    }
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    let spread = (seconds[seconds.len() - 1] - seconds[0]) / median;
    (Seconds { median, spread }, last.expect("at least one run"))
}

/// Runs something and tells by how many bytes the peak of memory rose; `None` where the system does not tell.
pub fn peak_bytes<T>(work: impl FnOnce() -> T) -> (Option<u64>, T) {
    // Makes the peak that of what comes.
    let reset = std::fs::write("/proc/self/clear_refs", "5").is_ok();
    let before = status("VmRSS:");
    let made = work();
    let peak = status("VmHWM:").zip(before).map(|(peak, before)| peak.saturating_sub(before));
    (peak.filter(|_| reset), made)
}

fn status(key: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// Three significant digits, in the short way.
pub fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return format!("{number}");
    }
    let digits = (2 - number.abs().log10().floor() as i32).max(0) as usize;
    if digits > 5 { format!("{number:.2e}") } else { format!("{number:.digits$}") }
}
