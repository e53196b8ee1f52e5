//! Packages as `cargo add` gets them: each library is packed, unpacked and built from its package alone.

use crate::{Result, process};
use std::path::PathBuf;

/// Every package that is published and builds alone.
const LIBRARIES: &[&str] =
    &["holo-core", "holo-scene", "holo-render", "holo-io", "holo-dataset", "holo-viewer", "holoscopic"];

/// The direct dependencies of `holo-core`.
const CORE_NEEDS: &[&str] = &["ndarray", "rayon"];

/// Packs and builds the libraries; checks the licenses in all packages and the dependencies of `holo-core`.
pub fn run() -> Result {
    forget_unpacked()?;
    let mut arguments = vec!["package", "--quiet", "--allow-dirty"];
    arguments.extend(LIBRARIES.iter().flat_map(|name| ["-p", name]));
    process::cargo(&arguments)?;
    for name in LIBRARIES.iter().chain(&[PROGRAM]) {
        has_licenses(name)?;
    }
    let tree = ["tree", "-p", "holo-core", "--edges", "normal", "--depth", "1", "--prefix", "none", "--format", "{p}"];
    let listed = process::output(process::cargo_command().args(tree))?;
    let needs: Vec<&str> = listed.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    if needs != CORE_NEEDS {
        return Err(format!("holo-core depends on {needs:?}; it may depend on {CORE_NEEDS:?} alone"));
    }
    println!(
        "{} packages build from what they contain; holo-core depends on {} alone",
        LIBRARIES.len(),
        needs.join(" and ")
    );
    Ok(())
}

/// The package of the program; published, too.
const PROGRAM: &str = "holo-cli";

/// Whether a package contains its readme and both licenses.
fn has_licenses(name: &str) -> Result {
    let listed = process::output(process::cargo_command().args(["package", "--list", "--allow-dirty", "-p", name]))?;
    let missing: Vec<&str> = ["LICENSE-APACHE", "LICENSE-MIT", "README.md"]
        .into_iter()
        .filter(|file| !listed.lines().any(|line| line == *file))
        .collect();
    if missing.is_empty() { Ok(()) } else { Err(format!("the package of {name} lacks {}", missing.join(", "))) }
}

/// Removes the libraries that an earlier run unpacked into cargo's home and built: `cargo package` takes both as
/// current as long as the version is the same. Their registries are the nameless ones that cargo makes within a target
/// folder, so nothing that was downloaded is touched.
fn forget_unpacked() -> Result {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo")));
    let registries = home.and_then(|home| home.join("registry/src").read_dir().ok()).into_iter().flatten().flatten();
    let nameless = registries.filter(|registry| registry.file_name().to_string_lossy().starts_with('-'));
    let mut folders: Vec<PathBuf> = nameless.map(|registry| registry.path()).collect();
    folders.push(crate::target().join("debug/.fingerprint"));
    for entry in folders.iter().filter_map(|folder| folder.read_dir().ok()).flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if LIBRARIES.iter().any(|library| name.strip_prefix(library).is_some_and(|rest| rest.starts_with('-'))) {
            let path = entry.path();
            std::fs::remove_dir_all(&path).map_err(|why| format!("removing {}: {why}", path.display()))?;
        }
    }
    Ok(())
}
