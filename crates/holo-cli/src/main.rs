//! The program `holo`; see the library of the same crate.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(holo_cli::run(std::env::args_os()))
}
