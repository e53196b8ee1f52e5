//! CMake and Ninja under `target/build-tools`: what the HDF5 library is built with.
//!
//! HDF5 comes as C source inside a crate. Where CMake, or Make for CMake to call, is missing, both tools come from
//! PyPI.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::setup::pip::{self, Availability, Requirements};
use crate::setup::process;
use crate::{Result, target};

const REQUIREMENTS: Requirements =
    Requirements { name: "build_tools", pythons: 8..=u32::MAX, platforms: pip::COMMON_PLATFORMS };

/// Fetches what is missing.
///
/// # Errors
///
/// If pip fails.
pub fn ensure() -> Result<Availability> {
    if !process::exists("cc") && std::env::var_os("CC").is_none() {
        return Ok(Availability::Missing("needs a C compiler".into()));
    }
    if is_present() {
        return Ok(Availability::Present);
    }
    let availability = pip::install(&REQUIREMENTS, &folder())?;
    if availability.is_present() && !is_fetched() {
        return Err(format!("{} holds no cmake", folder().display()));
    }
    Ok(availability)
}

/// Whether HDF5 can be built.
pub fn is_present() -> bool {
    is_installed() || is_fetched()
}

/// The environment with which cargo finds the tools.
pub fn environment() -> Vec<(&'static str, OsString)> {
    if is_installed() || !is_fetched() {
        return Vec::new();
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = program_folders().into_iter().chain(std::env::split_paths(&path));
    let Ok(path) = std::env::join_paths(folders) else { return Vec::new() };
    vec![("PATH", path), ("CMAKE_GENERATOR", "Ninja".into())]
}

/// Whether the system has both.
fn is_installed() -> bool {
    process::exists("cmake") && process::exists("make")
}

fn folder() -> PathBuf {
    target().join("build-tools")
}

/// Where the programs are. What pip writes into `bin` for CMake is a script that needs `PYTHONPATH`.
fn program_folders() -> [PathBuf; 2] {
    [folder().join("cmake").join("data").join("bin"), folder().join("bin")]
}

fn is_fetched() -> bool {
    let [cmake, ninja] = program_folders();
    cmake.join("cmake").is_file() && ninja.join("ninja").is_file() && pip::is_current(&REQUIREMENTS, &folder())
}
