//! The program `holo`; see the library of the same crate.
// Allowed in one module.
#![deny(unsafe_code)]

#[allow(unsafe_code, reason = "mallopt and handlers of signals have no safe binding")]
mod memory;

use std::process::ExitCode;

fn main() -> ExitCode {
    memory::return_large_blocks();
    memory::report_aborts();
    ExitCode::from(holo_cli::run(std::env::args_os()))
}
