//! Scene files of the wild: all below a folder are rendered, and compared with Blender's Cycles where it is there.
//!
//! The work is done by `wild/wild.py`; `wild/files.txt` lists files of public repositories by their hashes.

use std::path::PathBuf;
use std::process::Command;

use crate::setup::pip::Availability;
use crate::setup::{cargo, peers, process};
use crate::{Result, outside::renderers, root, target};

/// Renders the files below the first argument; other arguments are those of `wild.py`.
///
/// # Errors
///
/// If a file makes `holo` crash, or if Python or its packages cannot be had.
pub fn run(arguments: &[String]) -> Result {
    let [folder, rest @ ..] = arguments else {
        return Err("usage: cargo xtask wild DIR [--list crates/xtask/wild/files.txt] [--samples N] [--jobs N] \
                    [--blender FOLDER [--blender-python PROGRAM]] [--no-blender]"
            .into());
    };
    if let Availability::Missing(why) = peers::ensure()? {
        return Err(format!("the table and the contact sheet need Python packages: {why}"));
    }
    cargo::run(&["build", "--release", "--quiet", "-p", "holo-cli"])?;
    let environment = peers::environment();
    let installed = environment.iter().find(|(name, _)| *name == "HOLO_PYTHON").map(|(_, python)| python.clone());
    let python = installed.or_else(|| std::env::var_os("HOLO_PYTHON")).unwrap_or_else(|| "python3".into());
    let mut command = Command::new(python);
    command.arg(root().join("crates/xtask/wild/wild.py")).arg(folder);
    command.arg("--holo").arg(program()).arg("--out").arg(target().join("wild"));
    let (without, rest): (Vec<_>, Vec<_>) = rest.iter().partition(|argument| *argument == "--no-blender");
    // A module that the caller names needs no other.
    if without.is_empty() && !rest.iter().any(|argument| *argument == "--blender") {
        match renderers::blender()? {
            Some((python, folder)) => {
                command.arg("--blender").arg(folder).arg("--blender-python").arg(python);
            }
            None => eprintln!("not run: the comparison with Cycles needs Blender's module, for Python 3.11"),
        }
    }
    command.args(rest).envs(environment);
    let outcome = process::run(&mut command);
    println!("{}", target().join("wild/results.md").display());
    outcome
}

fn program() -> PathBuf {
    target().join("release").join(format!("holo{}", std::env::consts::EXE_SUFFIX))
}
