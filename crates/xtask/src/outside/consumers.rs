//! Programs that train on light fields: their loading code is run over what `holo export` writes.
//!
//! The work is done by `tests/peers/consumers.py`.

use std::process::Command;

use crate::setup::pip::Availability;
use crate::setup::{peers, process};
use crate::{Result, build, root, target};

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
    let environment = peers::environment();
    let installed = environment.iter().find(|(name, _)| *name == "HOLO_PYTHON").map(|(_, python)| python.clone());
    let python = installed.or_else(|| std::env::var_os("HOLO_PYTHON")).unwrap_or_else(|| "python3".into());
    let mut command = Command::new(python);
    command.arg(root().join("tests/peers/consumers.py")).arg(folder);
    command.arg("--holo").arg(target().join("release").join(format!("holo{}", std::env::consts::EXE_SUFFIX)));
    process::run(command.args(rest).envs(environment))
}
