//! Running other programs; an error contains the command.

use std::process::Command;

use crate::Result;

/// Runs a command to its end.
pub fn run(command: &mut Command) -> Result {
    let shown = describe(command);
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{shown}` ended with {status}")),
        Err(why) => Err(format!("`{shown}` cannot be run: {why}")),
    }
}

/// Runs a command to its end and returns what it writes to its standard output.
pub fn output(command: &mut Command) -> Result<String> {
    let shown = describe(command);
    let output = command.output().map_err(|why| format!("`{shown}` cannot be run: {why}"))?;
    if !output.status.success() {
        return Err(format!("`{shown}` ended with {}: {}", output.status, String::from_utf8_lossy(&output.stderr)));
    }
    String::from_utf8(output.stdout).map_err(|_| format!("`{shown}` printed bytes that are no UTF-8"))
}

/// The name of this machine's target, such as `x86_64-unknown-linux-gnu`.
pub fn host() -> Result<String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let text = output(Command::new(rustc).arg("-vV"))?;
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "`rustc -vV` names no host".into())
}

/// Whether a program is on `PATH`.
pub fn exists(program: &str) -> bool {
    let Some(path) = std::env::var_os("PATH") else { return false };
    let exe = format!("{program}.exe");
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file() || folder.join(&exe).is_file())
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
