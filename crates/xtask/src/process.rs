//! Running other programs, and saying what was run when they fail.

use std::path::Path;
use std::process::Command;

use crate::Result;

/// Runs cargo in the workspace with this process's own output.
pub fn cargo(arguments: &[&str]) -> Result {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    run(Command::new(cargo).args(arguments).current_dir(crate::root()))
}

/// Runs a command to its end.
pub fn run(command: &mut Command) -> Result {
    let shown = describe(command);
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{shown}` ended with {status}")),
        Err(why) => Err(format!("`{shown}` cannot be run: {why}")),
    }
}

/// Whether a program is there to be run.
pub fn exists(program: &str) -> bool {
    let Some(path) = std::env::var_os("PATH") else { return false };
    std::env::split_paths(&path).any(|folder| {
        let candidate = folder.join(program);
        candidate.is_file() || Path::new(&candidate).with_extension("exe").is_file()
    })
}

fn describe(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
