//! The Python package of this checkout under `target/python-package`, and its tests.
//!
//! Users install it with pip, which builds an optimized wheel. For the tests its library is linked from what the Rust
//! tests have built.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::setup::pip::{self, Availability, Requirements};
use crate::setup::{cargo, embree, process};
use crate::{Result, root, target};

const REQUIREMENTS: Requirements = Requirements { name: "package", pythons: 10..=14, platforms: pip::COMMON_PLATFORMS };

/// The library as Python imports it, with the stable ABI.
const LIBRARY: &str = if cfg!(windows) { "_holo.pyd" } else { "_holo.abi3.so" };

/// Fetches what the tests need.
///
/// # Errors
///
/// If pip fails.
pub fn ensure() -> Result<Availability> {
    pip::install(&REQUIREMENTS, &packages())
}

/// Builds the package and runs its tests with the arguments of pytest.
///
/// # Errors
///
/// If a test fails.
pub fn test(arguments: &[String]) -> Result {
    if let Availability::Missing(why) = ensure()? {
        return Err(format!("the tests of the Python package: {why}"));
    }
    let python = pip::installed(&REQUIREMENTS, &packages()).ok_or("pytest is not installed")?;
    let package = build()?;
    let path = std::env::join_paths([package, packages()]).map_err(|why| why.to_string())?;
    let mut pytest = Command::new(python);
    // Two at a time: what one leaves of the processor, while it starts and writes, the other takes.
    pytest
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--numprocesses", "2"])
        .arg(folder().join("tests"))
        .args(arguments);
    pytest.env("PYTHONPATH", path).env("PYTHONDONTWRITEBYTECODE", "1").env("MPLBACKEND", "agg");
    process::run(pytest.envs(embree::environment()))
}

/// The package of this checkout, to be named in `PYTHONPATH`.
fn build() -> Result<PathBuf> {
    // With the features of the tests, those of development dependencies too: the libraries are theirs.
    cargo::run(&[&["build", "--quiet", "--workspace", "--lib", "--examples"], crate::workspace_features()].concat())?;
    let out = target().join("python-package").join("holo");
    let _ = std::fs::remove_dir_all(&out);
    std::fs::create_dir_all(&out).map_err(|why| format!("{}: {why}", out.display()))?;
    let sources = folder().join("python").join("holo");
    for entry in std::fs::read_dir(&sources).map_err(|why| format!("{}: {why}", sources.display()))?.flatten() {
        if entry.path().is_file() {
            copy(&entry.path(), &out.join(entry.file_name()))?;
        }
    }
    let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    copy(&target().join("debug").join(format!("{prefix}_holo{suffix}")), &out.join(LIBRARY))?;
    Ok(target().join("python-package"))
}

fn copy(from: &Path, to: &Path) -> Result {
    std::fs::copy(from, to).map(drop).map_err(|why| format!("{}: {why}", from.display()))
}

fn folder() -> PathBuf {
    root().join("crates").join("holo-python")
}

/// The packages that the tests need.
pub fn packages() -> PathBuf {
    target().join("python-packages")
}
