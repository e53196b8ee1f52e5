//! Cargo in the workspace, with what the machine lacks.

use std::ffi::OsString;
use std::process::Command;

use super::{cmake, peers, process};
use crate::Result;

/// Runs cargo in the workspace with this process's own output.
pub fn run(arguments: &[&str]) -> Result {
    run_with(arguments, Vec::new())
}

/// Runs cargo with additional environment variables.
pub fn run_with(arguments: &[&str], environment: Vec<(&'static str, OsString)>) -> Result {
    let environment = environment.into_iter().chain(cmake::environment()).chain(peers::environment());
    process::run(command().args(arguments).envs(environment))
}

/// Cargo in the workspace.
pub fn command() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(crate::root());
    cargo
}
