//! Lines on standard output and standard error that never end the program: `println!` panics where nobody reads. And the
//! memory that they report.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

use holo_core::{shown_lines, shown_output};
use holo_dataset::About;

use crate::budget::line_bytes;
use crate::failure::Failure;

/// A line on standard output, for `out!`. A reader that has seen enough (`holo info x | head`) is no failure. Names from
/// files may be in it: what a terminal would take for a command is escaped.
pub fn print(line: Arguments) -> Result<(), Failure> {
    let line = line.to_string();
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{}", shown_output(&line)).and_then(|()| stdout.flush()) {
        Err(why) if why.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Failed(format!("cannot write to standard output: {why}")))
        }
        _ => Ok(()),
    }
}

/// A line on standard error, for `say!`, escaped in the same way and shortened. There is nowhere left to complain if it
/// cannot be written.
pub fn tell(line: Arguments) {
    let line = line.to_string();
    let _ = writeln!(std::io::stderr().lock(), "{}", shown_lines(&line));
}

/// Puts the diagnostics of a render on standard error, or nowhere.
pub fn say_unless(quiet: bool) -> impl Fn(About, &str) {
    move |_, line| {
        if !quiet {
            tell(format_args!("{}", Failure::spelled(line)));
        }
    }
}

/// Peak resident memory of this process, where the system reports it (Linux).
pub fn peak_rss_bytes() -> Option<u64> {
    line_bytes("/proc/self/status", "VmHWM:").map(|bytes| bytes as u64)
}

/// `println!` with an error instead of a panic.
macro_rules! out {
    ($($line:tt)*) => { $crate::console::print(format_args!($($line)*)) };
}

/// `eprintln!` without a panic.
macro_rules! say {
    ($($line:tt)*) => { $crate::console::tell(format_args!($($line)*)) };
}

pub(crate) use {out, say};
