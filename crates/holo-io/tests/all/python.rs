//! Readers and writers of other projects in Python, where this machine has them.
#![allow(dead_code, reason = "every test file uses its own part of this")]

use std::path::Path;
use std::process::Command;

#[path = "../../../../tests/all/common/peer.rs"]
pub mod peer;

pub use peer::missing;

/// Runs a script that imports `modules` with `HOLO_PYTHON` or `python3` and returns what it prints; `None` if a module
/// is missing.
///
/// # Panics
///
/// If the script itself fails; if a module is missing and `HOLO_REQUIRE_PEERS` is 1.
pub fn run(modules: &[&str], script: &str, arguments: &[&str]) -> Option<String> {
    let imports = format!("import {}", modules.join(", "));
    let probe = Command::new(program()).args(["-c", &imports]).output();
    if !probe.is_ok_and(|output| output.status.success()) {
        missing(&format!("{} in Python (HOLO_PYTHON names the interpreter)", modules.join(", ")));
        return None;
    }
    finish(Command::new(program()).args(["-c", &format!("import sys\n{imports}\n{script}")]).args(arguments))
}

/// Runs a script of `tests/peers` and returns what it prints; `None` if a module that it imports is missing.
///
/// # Panics
///
/// As [`run`].
pub fn run_file<'a>(name: &str, arguments: impl IntoIterator<Item = &'a Path>) -> Option<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers").join(name);
    finish(Command::new(program()).arg(script).args(arguments))
}

fn program() -> String {
    std::env::var("HOLO_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

fn finish(python: &mut Command) -> Option<String> {
    let output = match python.output() {
        Ok(output) => output,
        Err(error) => {
            missing(&format!("{}: {error}", program()));
            return None;
        }
    };
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains("ModuleNotFoundError"), "{text}");
        let line = text.lines().last().unwrap_or_default();
        missing(&format!("{line}: `cargo xtask test` fetches it, or HOLO_PYTHON names a Python that has it"));
        return None;
    }
    Some(String::from_utf8(output.stdout).expect("the scripts print UTF-8"))
}
