//! Readers of other programs in Python, where they are installed.

use std::process::Command;

/// Runs a script with `HOLO_PYTHON` or `python3` and returns its output; prints what is missing and returns `None`
/// without the modules.
///
/// # Panics
///
/// If the script itself fails.
pub fn run(modules: &[&str], script: &str, arguments: &[&str]) -> Option<String> {
    let program = std::env::var("HOLO_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let imports = format!("import {}", modules.join(", "));
    let has = Command::new(&program).args(["-c", &imports]).output().is_ok_and(|output| output.status.success());
    if !has {
        eprintln!("not run: needs {} in Python (HOLO_PYTHON names the interpreter)", modules.join(", "));
        return None;
    }
    let output = Command::new(&program)
        .args(["-c", &format!("import sys\n{imports}\n{script}")])
        .args(arguments)
        .output()
        .expect("it just ran");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}
