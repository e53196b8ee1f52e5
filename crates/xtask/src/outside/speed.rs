//! Two builds of `holo` by turns: programs, or commits that are built here.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::setup::{cargo, embree, process};
use crate::{Result, features, root, target};

/// Runs `speed.py` with the programs of the first one or two arguments; the second is by default that of the working tree.
///
/// # Errors
///
/// If a commit cannot be checked out or built, or as the script has it: also if the new program is slower than allowed.
pub fn run(arguments: &[String]) -> Result {
    let programs = arguments.iter().take_while(|argument| !argument.starts_with("--")).count();
    let (programs, options) = arguments.split_at(programs);
    let (old, new) = match programs {
        [old] => (program(old)?, build(&root())?),
        [old, new] => (program(old)?, program(new)?),
        _ => {
            return Err("usage: cargo xtask speed OLD [NEW] [--rounds N] [--only TEXT].. [--scenes all|NAME,..] \
                        [--fail-below RATIO] [--folder DIR]; OLD and NEW are programs or commits"
                .into());
        }
    };
    let mut command = Command::new(process::python()?);
    command.arg(root().join("crates/holo-bench/benches/speed.py")).args([old, new]).args(options);
    // Both load the same Embree: that of the working tree.
    process::run(command.envs(embree::environment()))
}

/// A program, or that of a commit.
fn program(name: &str) -> Result<PathBuf> {
    if Path::new(name).is_file() {
        return Ok(name.into());
    }
    let git = |arguments: &[&str]| {
        let mut git = Command::new("git");
        git.arg("-C").arg(root()).args(arguments);
        git
    };
    let revision = format!("{name}^{{commit}}");
    let commit = process::output(&mut git(&["rev-parse", "--verify", "--quiet", &revision]))
        .map_err(|why| format!("{name} is neither a program nor a commit: {why}"))?;
    let folder = target().join("speed").join(&commit.trim()[..12]);
    if !folder.exists() {
        let shown = folder.to_string_lossy();
        process::run(&mut git(&["worktree", "prune"]))?;
        process::run(&mut git(&["worktree", "add", "--detach", "--force", &shown, commit.trim()]))?;
    }
    build(&folder)
}

/// Builds the program of a working tree, for speed.
fn build(tree: &Path) -> Result<PathBuf> {
    let mut cargo = cargo::command();
    let own = if tree == root() { target() } else { tree.join("target") };
    cargo.current_dir(tree).env("CARGO_TARGET_DIR", &own).envs(crate::setup::cmake::environment());
    process::run(cargo.args(["build", "--release", "--quiet", "-p", "holo-cli"]).args(features()))?;
    Ok(crate::program(&own))
}
