//! What `cargo add` would give: each library packed, unpacked and built from its package alone.

use std::path::PathBuf;
use std::process::Command;

use crate::{Result, process, root};

const LIBRARIES: &[&str] = &["holo-core", "holo-scene", "holo-render", "holo-io", "holo-dataset", "holo-viewer"];

/// What a user of `holo-core` pulls in directly.
const CORE_NEEDS: &[&str] = &["ndarray", "rayon"];

/// Packs and builds the libraries and counts what `holo-core` depends on.
pub fn run() -> Result {
    forget_unpacked()?;
    let mut arguments = vec!["package", "--quiet", "--allow-dirty"];
    arguments.extend(LIBRARIES.iter().flat_map(|name| ["-p", name]));
    process::cargo(&arguments)?;
    let tree = ["tree", "-p", "holo-core", "--edges", "normal", "--depth", "1", "--prefix", "none", "--format", "{p}"];
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output =
        Command::new(cargo).args(tree).current_dir(root()).output().map_err(|why| format!("cargo tree: {why}"))?;
    let listed = String::from_utf8_lossy(&output.stdout);
    let needs: Vec<&str> = listed.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    if needs != CORE_NEEDS {
        return Err(format!("holo-core needs {needs:?}, and may need {CORE_NEEDS:?} alone"));
    }
    println!(
        "{} packages build from what they contain; holo-core needs {} alone",
        LIBRARIES.len(),
        needs.join(" and ")
    );
    Ok(())
}

/// Removes the libraries that an earlier run unpacked into cargo's home and built: `cargo package` takes both as fresh
/// for as long as the version is the same, whatever has changed since. Their registries are the nameless ones that cargo
/// makes within a target folder, so nothing that was downloaded is touched.
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
