//! Programs that train on light fields: their loading code is run over what `holo export` writes.
//!
//! The work is done by `tests/peers/consumers.py`.

use std::process::Command;

use crate::setup::pip::Availability;
use crate::setup::{peers, process};
use crate::{Result, build, program, root, target};

/// Compares what the repositories below the first argument read; other arguments are those of `consumers.py`.
///
/// # Errors
///
/// If a consumer reads other values, or if Python or its packages cannot be had.
pub fn run(arguments: &[String]) -> Result {
    let [folder, rest @ ..] = arguments else {
        return Err("usage: cargo xtask consumers DIR [--only TEXT]..; DIR has clones of their repositories".into());
    };
    if let Availability::Missing(why) = peers::ensure()? {
        return Err(format!("the comparison needs Python packages: {why}"));
    }
    build()?;
    let mut command = Command::new(peers::python());
    command.arg(root().join("tests/peers/consumers.py")).arg(folder);
    command.arg("--holo").arg(program(&target()));
    process::run(command.args(rest).envs(peers::environment()))
}
