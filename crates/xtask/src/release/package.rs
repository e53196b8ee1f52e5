//! Packages as `cargo add` gets them: each is packed, unpacked and checked from its package alone.

use crate::Result;
use crate::setup::{cargo, process};
use std::process::Command;

/// The libraries and the program, in the order in which they can be published: each after those that it needs.
pub const PACKAGES: [&str; 9] = [
    "holo-core",
    "holo-scene",
    "holo-render",
    "holo-io",
    "holo-dataset",
    "holo-viewer",
    "holo-preview",
    "holoscopic",
    "holo-cli",
];

/// The direct dependencies of `holo-core`.
const CORE_NEEDS: &[&str] = &["ndarray", "rayon"];

/// Packs and checks the packages; checks the licenses in all packages and the dependencies of `holo-core`.
pub fn run() -> Result {
    let mut arguments = vec!["package", "--quiet", "--allow-dirty", "--no-verify"];
    arguments.extend(PACKAGES.iter().flat_map(|name| ["-p", name]));
    cargo::run(&arguments)?;
    check_unpacked()?;
    for name in PACKAGES {
        has_licenses(name)?;
    }
    let tree = ["tree", "-p", "holo-core", "--edges", "normal", "--depth", "1", "--prefix", "none", "--format", "{p}"];
    let listed = process::output(cargo::command().args(tree))?;
    let needs: Vec<&str> = listed.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    if needs != CORE_NEEDS {
        return Err(format!("holo-core depends on {needs:?}; it may depend on {CORE_NEEDS:?} alone"));
    }
    println!(
        "{} packages compile from what they contain; holo-core depends on {} alone",
        PACKAGES.len(),
        needs.join(" and ")
    );
    Ok(())
}

/// Whether a package contains its readme and both licenses.
fn has_licenses(name: &str) -> Result {
    let listed = process::output(cargo::command().args(["package", "--list", "--allow-dirty", "-p", name]))?;
    let missing: Vec<&str> = ["LICENSE-APACHE", "LICENSE-MIT", "README.md"]
        .into_iter()
        .filter(|file| !listed.lines().any(|line| line == *file))
        .collect();
    if missing.is_empty() { Ok(()) } else { Err(format!("the package of {name} lacks {}", missing.join(", "))) }
}

/// Unpacks an archive into a folder. All files in packages have one time of long ago, by which cargo would take what it has
/// built of an earlier package for what is in this one.
const UNPACK: &str = "import sys, tarfile, time
archive = tarfile.open(sys.argv[1])
members = archive.getmembers()
for member in members:
    member.mtime = time.time()
archive.extractall(sys.argv[2], members)";

/// Checks the packages in a workspace of their own, in which they are each other's and everything else is as in
/// this one: what clippy has checked is not checked again.
fn check_unpacked() -> Result {
    let version = env!("CARGO_PKG_VERSION");
    let packed = crate::target().join("package");
    let place = packed.join("workspace");
    let failed = |why: std::io::Error| format!("{}: {why}", place.display());
    if place.exists() {
        std::fs::remove_dir_all(&place).map_err(failed)?;
    }
    std::fs::create_dir_all(&place).map_err(failed)?;
    for name in PACKAGES {
        let archive = packed.join(format!("{name}-{version}.crate"));
        process::run(Command::new(process::python()?).args(["-c", UNPACK]).arg(archive).arg(&place))?;
    }
    let whole = std::fs::read_to_string(crate::root().join("Cargo.toml")).map_err(failed)?;
    let (from, to) = (whole.find("[profile.dev]"), whole.find("[profile.release]"));
    let profiles = from.zip(to).and_then(|(from, to)| whole.get(from..to)).unwrap_or_default();
    let folders = PACKAGES.map(|name| (name, format!("{name}-{version}")));
    let members = folders.each_ref().map(|(_, folder)| format!("\"{folder}\"")).join(", ");
    let patches = folders.map(|(name, folder)| format!("{name} = {{ path = \"{folder}\" }}\n")).concat();
    let manifest =
        format!("[workspace]\nresolver = \"3\"\nmembers = [{members}]\n\n[patch.crates-io]\n{patches}\n{profiles}");
    std::fs::write(place.join("Cargo.toml"), manifest).map_err(failed)?;
    std::fs::copy(crate::root().join("Cargo.lock"), place.join("Cargo.lock")).map_err(failed)?;
    let mut check = cargo::command();
    check.current_dir(&place).env("CARGO_TARGET_DIR", crate::target()).args([
        "check",
        "--quiet",
        "--workspace",
        "--offline",
    ]);
    process::run(&mut check)
}
