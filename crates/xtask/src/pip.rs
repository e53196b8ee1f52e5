//! Python packages into a folder of their own under `target/`: a bare Debian has no venv.

use std::path::Path;
use std::process::Command;

use crate::{Result, process};

/// Installs packages with their dependencies into `home`, which must be named without an ending.
///
/// They are put beside their place and then moved there: a killed run leaves nothing half done behind.
pub fn install(python: &str, packages: &[&str], home: &Path) -> Result {
    let fresh = home.with_extension("part");
    let _ = std::fs::remove_dir_all(&fresh);
    process::run(
        Command::new(python)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--root-user-action=ignore"])
            .args(["--only-binary=:all:", "--no-warn-script-location", "--target"])
            .arg(&fresh)
            .args(packages)
            // What is installed elsewhere is no concern of this folder's.
            .env_remove("PYTHONPATH"),
    )?;
    let _ = std::fs::remove_dir_all(home);
    std::fs::rename(&fresh, home).map_err(|why| format!("{}: {why}", home.display()))
}
