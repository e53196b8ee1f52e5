//! What `cargo add` would give: each library packed, unpacked and built from its package alone.

use std::process::Command;

use crate::{Result, process, root};

const LIBRARIES: &[&str] = &["holo-core", "holo-scene", "holo-render", "holo-io", "holo-dataset"];

/// What a user of `holo-core` pulls in directly.
const CORE_NEEDS: &[&str] = &["ndarray", "rayon"];

/// Packs and builds the libraries and counts what `holo-core` depends on.
pub fn run() -> Result {
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
