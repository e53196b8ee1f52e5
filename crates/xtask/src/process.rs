//! Running other programs, and saying what was run when they fail.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use crate::Result;

/// Runs cargo in the workspace with this process's own output.
pub fn cargo(arguments: &[&str]) -> Result {
    cargo_with(arguments, Vec::new())
}

/// Runs cargo with some more variables set.
pub fn cargo_with(arguments: &[&str], environment: Vec<(&'static str, OsString)>) -> Result {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    run(Command::new(cargo)
        .args(arguments)
        .current_dir(crate::root())
        .envs(crate::cmake::environment())
        .envs(crate::peers::environment())
        .envs(environment))
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

/// The name of this machine's target, such as `x86_64-unknown-linux-gnu`.
pub fn host() -> Result<String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().map_err(|why| format!("`rustc -vV` cannot be run: {why}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "`rustc -vV` names no host".into())
}

/// Whether a program is there to be run.
pub fn exists(program: &str) -> bool {
    let Some(path) = std::env::var_os("PATH") else { return false };
    std::env::split_paths(&path).any(|folder| {
        let candidate = folder.join(program);
        candidate.is_file() || Path::new(&candidate).with_extension("exe").is_file()
    })
}

/// The name of Python 3.
pub fn python() -> Result<&'static str> {
    let found = ["python3", "python"].into_iter().find(|name| exists(name));
    found.ok_or_else(|| "neither python3 nor python is on PATH".into())
}

fn describe(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
