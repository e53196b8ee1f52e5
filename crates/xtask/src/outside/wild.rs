//! Scene files of the wild: all below a folder are rendered, and compared with Blender's Cycles where it is there.
//!
//! The work is done by `wild/wild.py`; `wild/files.txt` lists files of public repositories by their hashes.

use std::process::Command;

use crate::setup::pip::Availability;
use crate::setup::{cargo, peers, process};
use crate::{Result, outside::renderers, program, root, target};

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
    let mut command = Command::new(peers::python());
    command.arg(root().join("crates/xtask/wild/wild.py")).arg(folder);
    command.arg("--holo").arg(program(&target())).arg("--out").arg(target().join("wild"));
    let (without, rest): (Vec<_>, Vec<_>) = rest.iter().partition(|argument| *argument == "--no-blender");
    // A module that the caller names needs no other.
    if without.is_empty() && !rest.iter().any(|argument| *argument == "--blender") {
        match renderers::module(&renderers::BLENDER)? {
            Some((python, folder)) => {
                command.arg("--blender").arg(folder).arg("--blender-python").arg(python);
            }
            None => eprintln!("not run: the comparison with Cycles needs Blender's module, for Python 3.11"),
        }
    }
    command.args(rest).envs(peers::environment());
    let outcome = process::run(&mut command);
    println!("{}", target().join("wild/results.md").display());
    outcome
}
